//! Text files line by line, and tables row by row.

use super::atomic;
use super::columns::{Field, push_row};
use super::error::FormatError;
use super::particles::Particles;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// A text file read line by line, which knows where it is.
pub(super) struct Lines<R> {
    path: PathBuf,
    input: R,
    line: usize,
    bytes: Vec<u8>,
}

impl Lines<BufReader<File>> {
    /// Opens `path`.
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        let file = File::open(path).map_err(|source| FormatError::io(path, "open", source))?;
        Ok(Self::new(path, BufReader::with_capacity(1 << 16, file)))
    }
}

impl<R: BufRead> Lines<R> {
    /// Reads `input`, which messages call `path`.
    pub(super) fn new(path: &Path, input: R) -> Self {
        Self { path: path.to_owned(), input, line: 0, bytes: Vec::new() }
    }

    /// Puts the next line, without blanks at its ends, in `buffer`; false at the
    /// end of the file. Any of LF and CRLF ends a line; a byte order mark is skipped.
    pub(super) fn next(&mut self, buffer: &mut String) -> Result<bool, FormatError> {
        self.bytes.clear();
        buffer.clear();
        let read = self
            .input
            .read_until(b'\n', &mut self.bytes)
            .map_err(|source| FormatError::io(&self.path, "read", source))?;
        if read == 0 {
            return Ok(false);
        }
        self.line += 1;
        let text = std::str::from_utf8(&self.bytes)
            .map_err(|_| self.wrong("is not text (bytes that are not UTF-8)"))?;
        let text = if self.line == 1 { text.trim_start_matches('\u{feff}') } else { text };
        buffer.push_str(text.trim());
        Ok(true)
    }

    /// Like [`Lines::next`], but passes over empty lines.
    pub(super) fn next_filled(&mut self, buffer: &mut String) -> Result<bool, FormatError> {
        while self.next(buffer)? {
            if !buffer.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The next line that is not empty, which must be there; `what` says what it holds.
    pub(super) fn need(&mut self, buffer: &mut String, what: &str) -> Result<(), FormatError> {
        if self.next_filled(buffer)? {
            return Ok(());
        }
        Err(FormatError::line(
            &self.path,
            self.line + 1,
            format!("the file ends here, but {what} should follow"),
        ))
    }

    /// An error in the line read last.
    pub(super) fn wrong(&self, problem: impl Into<String>) -> FormatError {
        FormatError::line(&self.path, self.line, problem)
    }

    /// An error that concerns the file as a whole.
    pub(super) fn wrong_file(&self, problem: impl Into<String>) -> FormatError {
        FormatError::file(&self.path, problem)
    }
}

/// Checks `particles` and writes `path` through `fill`, complete or not at all.
pub(super) fn save(
    path: &Path,
    particles: &Particles,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FormatError> {
    particles.check().map_err(|fault| FormatError::unwritable(path, fault.to_string()))?;
    atomic::write(path, |out| fill(out))
}

/// Writes all rows; numbers that count things are raised by `first`.
pub(super) fn write_rows(
    out: &mut dyn Write,
    particles: &Particles,
    fields: &[Field],
    separator: char,
    first: u64,
) -> io::Result<()> {
    let mut line = String::new();
    for row in 0..particles.len() {
        line.clear();
        push_row(&mut line, fields, separator, particles, row, first);
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}
