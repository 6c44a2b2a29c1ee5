//! Files that are complete or absent: written beside their place, then renamed.

use super::error::FormatError;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes `path` through `fill`: into a hidden file in the same folder, which
/// takes the wanted name only once everything is written. If `fill` or the
/// file system fails, `path` is as it was before and the hidden file is gone.
///
/// A path that exists and is no regular file (a pipe, `/dev/stdout`) is written
/// in place; a link is followed. Parent folders must exist.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), FormatError> {
    let failed = |source| FormatError::io(path, "write", source);
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|data| !data.is_file()) {
        return fs::OpenOptions::new()
            .write(true)
            .open(&target)
            .and_then(|file| finish(file, fill))
            .map_err(failed);
    }
    let beside = beside(&target).map_err(failed)?;
    let outcome = File::create_new(&beside)
        .and_then(|file| finish(file, fill))
        .and_then(|()| fs::rename(&beside, &target));
    outcome.map_err(|source| {
        // The first error is the one to report; a leftover cannot be helped.
        let _ = fs::remove_file(&beside);
        failed(source)
    })
}

fn finish(file: File, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    fill(&mut writer)?;
    writer.flush()
}

/// A name in the same folder that no other writer of this or another process uses.
fn beside(target: &Path) -> io::Result<PathBuf> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(
        ".{}-{}.partial",
        std::process::id(),
        NEXT.fetch_add(1, Ordering::Relaxed)
    ));
    Ok(target.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.txt");
        write(&path, |w| w.write_all(b"old")).expect("a first write");
        let error = write(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        })
        .expect_err("the closure fails");
        assert!(error.to_string().contains("a.txt: cannot write: disk full"), "{error}");
        assert_eq!(fs::read(&path).expect("still there"), b"old");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        write(&path, |w| w.write_all(b"new")).expect("a second write");
        assert_eq!(fs::read(&path).expect("replaced"), b"new");
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let error = write(&folder.path().join("no/such/b.txt"), |_| Ok(()))
            .expect_err("the folder is missing");
        assert!(error.to_string().contains("b.txt"), "{error}");
    }
}
