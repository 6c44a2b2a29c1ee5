//! Wavefront OBJ surfaces: `v` and `f` lines; polygons are cut into fans about
//! their first corner; negative (relative) indices, `v/vt/vn` corners and `\`
//! at the end of a line are understood; normals, textures, groups and materials
//! are passed over.

use super::atomic;
use super::error::FormatError;
use super::stl::writable;
use crate::geometry::Mesh;
use crate::num::Vec3;
use std::fs;
use std::io::Write;
use std::path::Path;

/// Reads an OBJ file. Vertices are kept as they are, double precision.
pub fn read(path: &Path) -> Result<Mesh, FormatError> {
    let bytes = fs::read(path).map_err(|source| FormatError::io(path, "read", source))?;
    // Names of materials may be in any encoding; numbers are ASCII.
    let text = String::from_utf8_lossy(&bytes);
    let mut mesh = Mesh::default();
    let mut continued = String::new();
    for (number, line) in text.lines().enumerate() {
        let wrong = |problem: String| FormatError::line(path, number + 1, problem);
        if let Some(start) = line.trim_end().strip_suffix('\\') {
            continued.push_str(start);
            continued.push(' ');
            continue;
        }
        let line = std::mem::take(&mut continued) + line;
        let mut words = line.split('#').next().unwrap_or("").split_ascii_whitespace();
        match words.next() {
            Some("v") => mesh.vertices.push(vertex(words).map_err(wrong)?),
            Some("f") => {
                let corners = words
                    .map(|word| corner(word, mesh.vertices.len()))
                    .collect::<Result<Vec<u32>, String>>()
                    .map_err(wrong)?;
                fan(&corners, &mut mesh.triangles).map_err(wrong)?;
            }
            _ => {}
        }
    }
    if mesh.triangles.is_empty() {
        return Err(FormatError::file(path, "holds no face"));
    }
    Ok(mesh)
}

fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec3, String> {
    let numbers: Vec<f64> = words
        .take(3)
        .map(|word| {
            word.parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(|| format!("`{word}` is no finite number"))
        })
        .collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("a vertex has 3 coordinates".to_owned()),
    }
}

fn corner(word: &str, vertices: usize) -> Result<u32, String> {
    let index = word.split('/').next().unwrap_or("");
    let number: i64 = index.parse().map_err(|_| format!("`{word}` is no corner of a face"))?;
    let place = if number < 0 { vertices as i64 + number } else { number - 1 };
    if number == 0 || place < 0 || place >= vertices as i64 {
        return Err(format!("corner {number} names no vertex: {vertices} were given so far"));
    }
    u32::try_from(place).map_err(|_| "more vertices than riprap can count".to_owned())
}

/// Cuts a polygon into triangles about its first corner.
pub(super) fn fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) -> Result<(), String> {
    if corners.len() < 3 {
        return Err(format!("a face of {} corners; at least 3 are needed", corners.len()));
    }
    triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
    Ok(())
}

/// Writes an OBJ file with all digits of double precision.
pub fn write(path: &Path, mesh: &Mesh) -> Result<(), FormatError> {
    writable(path, mesh)?;
    atomic::write(path, |writer| {
        for p in &mesh.vertices {
            writeln!(writer, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
        }
        for [a, b, c] in &mesh.triangles {
            writeln!(writer, "f {} {} {}", a + 1, b + 1, c + 1)?;
        }
        Ok(())
    })
}
