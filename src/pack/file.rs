//! `packing.csv`: one row a body, 17 significant digits, so that reading it
//! back gives the same bits.

use super::{Grain, PackError, Placement};
use crate::format::error::FormatError;
use crate::format::{atomic, number};
use crate::num::{Rotation, Vec3};
use nalgebra::Quaternion;
use std::io::Write;
use std::path::Path;

/// First line of the file. Lengths in m, velocities in m/s and rad/s (world frame).
pub const HEADER: &str = "body,grain,family,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz";
/// What the first line ends with where a method has changed sizes.
const SCALED: &str = ",scale";

/// Writes `placements`; the file is complete or absent.
///
/// Errors: the file cannot be written.
pub fn write(path: &Path, placements: &[Placement], grains: &[Grain]) -> Result<(), PackError> {
    atomic::write(path, |out| {
        let scaled = placements.iter().any(|laid| laid.scale != 1.0);
        writeln!(out, "{HEADER}{}", if scaled { SCALED } else { "" })?;
        for (body, laid) in placements.iter().enumerate() {
            let family = grains.get(laid.grain as usize).map_or(0, |grain| grain.family);
            write!(out, "{body},{},{family}", laid.grain)?;
            for value in numbers(laid) {
                write!(out, ",{}", number(value))?;
            }
            if scaled {
                write!(out, ",{}", number(laid.scale))?;
            }
            writeln!(out)?;
        }
        Ok(())
    })?;
    Ok(())
}

fn numbers(laid: &Placement) -> [f64; 13] {
    let (p, q) = (laid.position, laid.orientation.quaternion());
    let (v, w) = (laid.velocity, laid.spin);
    [p.x, p.y, p.z, q.w, q.i, q.j, q.k, v.x, v.y, v.z, w.x, w.y, w.z]
}

/// Reads what [`write()`] wrote.
///
/// Errors: the file cannot be read, has other columns, or a row holds something
/// that is not a finite number or no rotation.
pub fn read(path: &Path) -> Result<Vec<Placement>, PackError> {
    let text = std::fs::read_to_string(path).map_err(|e| FormatError::io(path, "read", e))?;
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    let scaled = first.strip_suffix(SCALED);
    if scaled.unwrap_or(first) != HEADER {
        return Err(FormatError::line(path, 1, format!("the first line is not `{HEADER}`")).into());
    }
    lines
        .enumerate()
        .map(|(row, line)| {
            parse(line, row, scaled.is_some())
                .ok_or_else(|| FormatError::line(path, row + 2, problem(row)).into())
        })
        .collect()
}

fn problem(row: usize) -> String {
    format!("not body {row}: 16 finite numbers separated by commas, the quaternion of length 1")
}

fn parse(line: &str, row: usize, scaled: bool) -> Option<Placement> {
    let mut fields = line.split(',');
    let body: usize = fields.next()?.parse().ok()?;
    let grain: u32 = fields.next()?.parse().ok()?;
    let _family: u16 = fields.next()?.parse().ok()?;
    let mut values = [0.0; 13];
    for value in &mut values {
        *value = fields.next()?.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
    }
    let scale = match scaled {
        true => fields.next()?.trim().parse().ok().filter(|s: &f64| s.is_finite() && *s > 0.0)?,
        false => 1.0,
    };
    let [x, y, z, qw, qx, qy, qz, vx, vy, vz, wx, wy, wz] = values;
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    let right = body == row && fields.next().is_none() && (quaternion.norm() - 1.0).abs() < 1e-6;
    right.then(|| Placement {
        grain,
        position: Vec3::new(x, y, z),
        // Normalising again would change the last bits.
        orientation: Rotation::new_unchecked(quaternion),
        velocity: Vec3::new(vx, vy, vz),
        spin: Vec3::new(wx, wy, wz),
        scale,
    })
}

#[cfg(test)]
mod tests {
    use super::super::samples::{dumbbell, of, room};
    use super::super::{Method, Random, pack};
    use super::*;
    use crate::num::Job;

    #[test]
    fn reading_gives_the_same_bits() {
        let clumps = vec![dumbbell(0.03, 0.07); 40];
        let grains = of(&clumps);
        let method = Method::Random(Random::default());
        let packing =
            pack(&grains, &[], &room(&[1.0; 3]), &method, 1, &Job::quiet()).expect("right");
        let mut written = packing.placements;
        written[0].velocity = Vec3::new(-0.0, 1e-310, 0.1 + 0.2);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("packing.csv");
        write(&path, &written, &grains).expect("written");
        let mut read_back = read(&path).expect("read");
        assert_eq!(read_back, written);
        written[3].scale = 0.1 + 0.2;
        write(&path, &written, &grains).expect("written");
        read_back = read(&path).expect("read");
        assert_eq!(read_back, written);
        for (a, b) in read_back.iter().zip(&written) {
            assert_eq!(a.grain, b.grain);
            assert_eq!(numbers(a).map(f64::to_bits), numbers(b).map(f64::to_bits));
        }
    }

    #[test]
    fn broken_rows_name_their_line() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("packing.csv");
        let good = "0,0,0,0,0,0,1,0,0,0,0,0,0,0,0,0";
        let bad = [
            "1,0,0,0,0,0,1,0,0,0,0,0,0,0,0,nan",
            "1,0,0,0,0,0,2,0,0,0,0,0,0,0,0,0",
            "1,0,0,0,0,0,1,0,0,0,0,0,0,0,0",
            "7,0,0,0,0,0,1,0,0,0,0,0,0,0,0,0",
        ];
        for line in bad {
            std::fs::write(&path, format!("{HEADER}\n{good}\n{line}\n")).expect("written");
            let error = read(&path).expect_err("is wrong").to_string();
            assert!(error.contains("packing.csv: line 3"), "{error}");
        }
        std::fs::write(&path, "x,y\n").expect("written");
        assert!(read(&path).expect_err("is wrong").to_string().contains("line 1"));
        assert!(read(&folder.path().join("none.csv")).is_err());
    }
}
