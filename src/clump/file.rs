//! Clumps on disk: `NAME.csv`, one sphere a line, and `clumps.json` beside them
//! with what the spheres do not say (mass, centre, axes, errors).
//!
//! Numbers have 17 significant digits, so that reading gives back the same bits.
//! Files are written beside and renamed: complete or absent.

use super::{Clump, ClumpError, Fidelity};
use crate::format::{FormatError, atomic};
use crate::geometry::Ball;
use crate::num::{Rotation, Vec3};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// First line of the table of spheres: body frame, metres.
pub const HEADER: &str = "x,y,z,r";

/// Name of the file that describes all clumps of a folder.
pub const INDEX: &str = "clumps.json";

/// What `clumps.json` says of one clump.
#[derive(Serialize, Deserialize)]
struct Entry {
    name: String,
    method: String,
    spheres: usize,
    /// m³.
    volume: f64,
    /// Principal moments for density 1, m⁵.
    inertia: [f64; 3],
    /// In the frame of the solid, m.
    centroid: [f64; 3],
    /// Unit quaternion w, x, y, z: body frame to frame of the solid.
    axes: [f64; 4],
    fidelity: Option<Fidelity>,
}

/// Writes the spheres of `clump` to `folder/NAME.csv` and returns the path.
///
/// # Errors
/// [`ClumpError::File`].
pub fn write(folder: &Path, clump: &Clump) -> Result<PathBuf, ClumpError> {
    let path = folder.join(format!("{}.csv", clump.name));
    write_as(&path, clump)?;
    Ok(path)
}

/// Writes the spheres of `clump` to the file `path`.
///
/// # Errors
/// [`ClumpError::File`].
pub fn write_as(path: &Path, clump: &Clump) -> Result<(), ClumpError> {
    let mut text = String::from(HEADER);
    text.push('\n');
    for ball in &clump.balls {
        let (c, r) = (ball.centre, ball.radius);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:.16e},{:.16e},{:.16e},{:.16e}", c.x, c.y, c.z, r);
    }
    atomic::write(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// Reads spheres from a file that [`write()`] made.
///
/// # Errors
/// [`ClumpError::File`], [`ClumpError::Content`] with the line that is wrong.
pub fn read(path: &Path) -> Result<Vec<Ball>, ClumpError> {
    let text = fs::read_to_string(path).map_err(|source| unreadable(path, source))?;
    let wrong = |line: usize, problem: String| ClumpError::Content {
        path: path.to_owned(),
        line: line + 1,
        problem,
    };
    let mut lines = text.lines().enumerate();
    if lines.next().is_none_or(|(_, first)| first.trim() != HEADER) {
        return Err(wrong(0, format!("the first line must be `{HEADER}`")));
    }
    let mut balls = Vec::new();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let values: Vec<f64> =
            line.split(',').map_while(|field| field.trim().parse().ok()).collect();
        match values[..] {
            [x, y, z, r] if values.iter().all(|v| v.is_finite()) && r > 0.0 => {
                balls.push(Ball { centre: Vec3::new(x, y, z), radius: r });
            }
            _ => {
                let problem = format!("`{line}` is not x,y,z,r with finite numbers and r > 0");
                return Err(wrong(number, problem));
            }
        }
    }
    if balls.is_empty() {
        return Err(wrong(0, "there are no spheres".to_owned()));
    }
    Ok(balls)
}

/// Writes every clump's spheres and `clumps.json` into `folder`, which must be there.
///
/// # Errors
/// [`ClumpError::File`].
pub fn write_all(folder: &Path, clumps: &[Clump]) -> Result<(), ClumpError> {
    for clump in clumps {
        write(folder, clump)?;
    }
    let entries: Vec<Entry> = clumps.iter().map(entry).collect();
    let path = folder.join(INDEX);
    atomic::write(&path, |out| Ok(serde_json::to_writer_pretty(out, &entries)?))?;
    Ok(())
}

/// Reads all clumps of a folder that [`write_all`] filled.
///
/// # Errors
/// [`ClumpError::File`], [`ClumpError::Content`].
pub fn read_all(folder: &Path) -> Result<Vec<Clump>, ClumpError> {
    let path = folder.join(INDEX);
    let text = fs::read(&path).map_err(|source| unreadable(&path, source))?;
    let entries: Vec<Entry> = serde_json::from_slice(&text).map_err(|e| ClumpError::Content {
        path: path.clone(),
        line: e.line(),
        problem: e.to_string(),
    })?;
    entries
        .into_iter()
        .map(|entry| {
            let balls = read(&folder.join(format!("{}.csv", entry.name)))?;
            Ok(clump(entry, balls))
        })
        .collect()
}

fn entry(clump: &Clump) -> Entry {
    let q = clump.axes.quaternion();
    Entry {
        name: clump.name.clone(),
        method: clump.method.clone(),
        spheres: clump.balls.len(),
        volume: clump.volume,
        inertia: clump.inertia.into(),
        centroid: clump.centroid.into(),
        axes: [q.w, q.i, q.j, q.k],
        fidelity: clump.fidelity,
    }
}

fn clump(entry: Entry, balls: Vec<Ball>) -> Clump {
    let [w, x, y, z] = entry.axes;
    Clump {
        name: entry.name,
        method: entry.method,
        balls,
        volume: entry.volume,
        inertia: entry.inertia.into(),
        centroid: entry.centroid.into(),
        // Unchecked, because normalising again would change the last bit.
        axes: Rotation::new_unchecked(nalgebra::Quaternion::new(w, x, y, z)),
        fidelity: entry.fidelity,
    }
}

fn unreadable(path: &Path, source: std::io::Error) -> ClumpError {
    FormatError::io(path, "read", source).into()
}

#[cfg(test)]
mod tests {
    use super::super::{disc, sphere};
    use super::*;

    #[test]
    fn clumps_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut odd = sphere("odd", 1.0 / 3.0);
        odd.balls.push(Ball { centre: Vec3::new(-0.0, 1e-9 / 7.0, 1e3 / 3.0), radius: 1e-7 / 3.0 });
        odd.axes = Rotation::from_euler_angles(0.1, 0.2, 0.3);
        odd.fidelity = Some(Fidelity {
            equivalent_diameter: 0.1,
            volume_error: -0.01 / 3.0,
            mean_distance: 1e-3 / 7.0,
            rms_distance: 2e-3,
            largest_distance: 1e-2,
            centroid_error: 0.0,
            inertia_error: 1.0 / 3.0,
        });
        let clumps = vec![odd, disc("plate", 0.25)];
        write_all(folder.path(), &clumps).expect("written");
        assert_eq!(read_all(folder.path()).expect("read"), clumps);
        let names = fs::read_dir(folder.path()).expect("listed").count();
        assert_eq!(names, 3, "no part is left");
    }

    #[test]
    fn wrong_lines_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bad.csv");
        for (text, line) in [
            ("x,y,z\n", 1),
            ("x,y,z,r\n0,0,0,1\n0,0,nan,1\n", 3),
            ("x,y,z,r\n0,0,0,-1\n", 2),
            ("x,y,z,r\n0,0,0,1,5\n", 2),
            ("x,y,z,r\n", 1),
        ] {
            fs::write(&path, text).expect("written");
            match read(&path) {
                Err(ClumpError::Content { line: at, .. }) => assert_eq!(at, line, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        assert!(matches!(read(&folder.path().join("none.csv")), Err(ClumpError::File(_))));
    }
}
