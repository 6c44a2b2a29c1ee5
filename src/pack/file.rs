//! `packing.csv`: one row a body, 17 significant digits, so that reading it
//! back gives the same bits.

use super::{Grain, PackError, Placement};
use crate::format::atomic;
use crate::format::error::FormatError;
use crate::num::{Rotation, Vec3};
use nalgebra::Quaternion;
use std::io::Write;
use std::path::Path;

/// First line of the file. Lengths in m, velocities in m/s and rad/s (world frame).
pub const HEADER: &str = "body,grain,family,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz";

/// Writes `placements`; the file is complete or absent.
///
/// Errors: the file cannot be written.
pub fn write(path: &Path, placements: &[Placement], grains: &[Grain]) -> Result<(), PackError> {
    atomic::write(path, |out| {
        writeln!(out, "{HEADER}")?;
        for (body, laid) in placements.iter().enumerate() {
            let family = grains.get(laid.grain as usize).map_or(0, |grain| grain.family);
            write!(out, "{body},{},{family}", laid.grain)?;
            for value in numbers(laid) {
                write!(out, ",{value:.16e}")?;
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

/// Reads what [`write`] wrote.
///
/// Errors: the file cannot be read, has other columns, or a row holds something
/// that is not a finite number or no rotation.
pub fn read(path: &Path) -> Result<Vec<Placement>, PackError> {
    let text = std::fs::read_to_string(path).map_err(|e| FormatError::io(path, "read", e))?;
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return Err(FormatError::line(path, 1, format!("the first line is not `{HEADER}`")).into());
    }
    lines
        .enumerate()
        .map(|(row, line)| {
            parse(line, row).ok_or_else(|| FormatError::line(path, row + 2, problem(row)).into())
        })
        .collect()
}

fn problem(row: usize) -> String {
    format!("not body {row}: 16 finite numbers separated by commas, the quaternion of length 1")
}

fn parse(line: &str, row: usize) -> Option<Placement> {
    let mut fields = line.split(',');
    let body: usize = fields.next()?.parse().ok()?;
    let grain: u32 = fields.next()?.parse().ok()?;
    let _family: u16 = fields.next()?.parse().ok()?;
    let mut values = [0.0; 13];
    for value in &mut values {
        *value = fields.next()?.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
    }
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
    })
}
