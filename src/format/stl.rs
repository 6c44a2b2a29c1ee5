//! STL surfaces, binary and text, lengths in metres unless the caller scales.
//!
//! Binary files hold single precision; text holds what is written. A file is
//! binary if its length is 84 + 50 n bytes for the count n at byte 80, whatever
//! its header says: headers that begin with "solid" are common and mislead
//! readers that look at the first word only. stl_io reads the binary records
//! and writes them; the text reader is our own, because stl_io's has single
//! precision and does not say where a file is wrong.

use super::atomic;
use super::error::FormatError;
use crate::geometry::Mesh;
use crate::num::Vec3;
use std::collections::HashMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Reads a binary or text STL file. Equal corners become one vertex; nothing
/// else is repaired. Refused: empty, truncated or overlong files, coordinates
/// that are not finite (naming the triangle), files without a triangle.
pub fn read(path: &Path) -> Result<Mesh, FormatError> {
    let bytes = fs::read(path).map_err(|source| FormatError::io(path, "read", source))?;
    if bytes.is_empty() {
        return Err(FormatError::file(path, "is empty (0 bytes)"));
    }
    let count = bytes
        .get(80..HEADER)
        .and_then(|field| field.try_into().ok())
        .map(|field| u32::from_le_bytes(field) as usize);
    if let Some(count) = count
        && bytes.len() == HEADER + RECORD * count
    {
        return read_binary(path, bytes, count);
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) if text.trim_start().get(..5).is_some_and(|w| w.eq_ignore_ascii_case("solid")) => {
            read_text(path, text)
        }
        _ => Err(FormatError::file(path, mismatch(bytes.len(), count))),
    }
}

fn mismatch(length: usize, count: Option<usize>) -> String {
    match count {
        None => format!("has {length} bytes: too short for a binary STL file, and is no text one"),
        Some(count) => format!(
            "has {length} bytes, but its count of {count} triangles needs {}: it is truncated, \
             its count is wrong, or it is no STL file",
            HEADER + RECORD * count
        ),
    }
}

fn read_binary(path: &Path, mut bytes: Vec<u8>, count: usize) -> Result<Mesh, FormatError> {
    if count == 0 {
        return Err(FormatError::byte(path, 80, "holds no triangle"));
    }
    // stl_io takes a header that begins with "solid" for a text file.
    bytes[..80].fill(0);
    let surface = stl_io::read_stl(&mut Cursor::new(&bytes))
        .map_err(|source| FormatError::io(path, "read", source))?;
    for (triangle, face) in surface.faces.iter().enumerate() {
        for (k, corner) in face.vertices.iter().enumerate() {
            let [x, y, z] = surface.vertices[*corner].0;
            if ![x, y, z].iter().all(|x| x.is_finite()) {
                let byte = (HEADER + RECORD * triangle + 12 * (k + 1)) as u64;
                let problem = format!("triangle {triangle} has a corner at ({x}, {y}, {z})");
                return Err(FormatError::byte(path, byte, problem));
            }
        }
    }
    Ok(Mesh {
        vertices: surface.vertices.iter().map(|v| Vec3::from(v.0.map(f64::from))).collect(),
        triangles: surface.faces.iter().map(|f| f.vertices.map(|corner| corner as u32)).collect(),
    })
}

fn read_text(path: &Path, text: &str) -> Result<Mesh, FormatError> {
    let mut mesh = Mesh::default();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let mut corners: Vec<u32> = Vec::with_capacity(3);
    for (number, line) in text.lines().enumerate() {
        let wrong = |problem: String| FormatError::line(path, number + 1, problem);
        let mut words = line.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_str() {
            "vertex" => {
                let point = vertex(words).map_err(wrong)?;
                let next = mesh.vertices.len() as u32;
                let corner = *known.entry([0, 1, 2].map(|k| point[k].to_bits())).or_insert(next);
                if corner == next {
                    mesh.vertices.push(point);
                }
                corners.push(corner);
            }
            "facet" => corners.clear(),
            "endfacet" => match corners[..] {
                [a, b, c] => mesh.triangles.push([a, b, c]),
                _ => return Err(wrong(format!("a facet of {} vertices, not 3", corners.len()))),
            },
            "solid" | "outer" | "endloop" | "endsolid" => {}
            _ => return Err(wrong(format!("`{word}` is no word of a text STL file"))),
        }
    }
    let ended = text.lines().rev().find(|line| !line.trim().is_empty());
    if !ended.is_some_and(|line| line.trim_start().to_ascii_lowercase().starts_with("endsolid")) {
        return Err(FormatError::file(path, "is truncated: there is no `endsolid` at its end"));
    }
    if mesh.triangles.is_empty() {
        return Err(FormatError::file(path, "holds no triangle"));
    }
    Ok(mesh)
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<Vec3, String> {
    let mut point = Vec3::zeros();
    for axis in 0..3 {
        let word = words.next().ok_or("a vertex has 3 coordinates")?;
        point[axis] = word
            .parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(|| format!("`{word}` is no finite number"))?;
    }
    match words.next() {
        Some(word) => Err(format!("`{word}` after the 3 coordinates of a vertex")),
        None => Ok(point),
    }
}

/// Writes binary STL. Coordinates are rounded to single precision: exact for
/// meshes that passed [`crate::geometry::check::solid`].
pub fn write(path: &Path, mesh: &Mesh) -> Result<(), FormatError> {
    writable(path, mesh)?;
    if u32::try_from(mesh.triangles.len()).is_err() {
        return Err(FormatError::unwritable(path, "more triangles than STL can count"));
    }
    let single = |p: Vec3| stl_io::Vertex::new([p.x as f32, p.y as f32, p.z as f32]);
    if let Some(far) = mesh.vertices.iter().find(|p| !p.iter().all(|x| (*x as f32).is_finite())) {
        let problem =
            format!("({}, {}, {}) is too large for single precision", far.x, far.y, far.z);
        return Err(FormatError::unwritable(path, problem));
    }
    let records: Vec<stl_io::Triangle> = mesh
        .facets()
        .map(|corners| stl_io::Triangle {
            normal: single(normal(&corners)),
            vertices: corners.map(single),
        })
        .collect();
    atomic::write(path, |writer| stl_io::write_stl(writer, records.iter()))
}

/// Writes text STL with as many digits as give the same double precision
/// numbers when read: for walls, so that every solver has the same surface.
pub fn write_ascii(path: &Path, mesh: &Mesh) -> Result<(), FormatError> {
    writable(path, mesh)?;
    atomic::write(path, |writer| {
        writeln!(writer, "solid surface")?;
        for corners in mesh.facets() {
            let n = normal(&corners);
            writeln!(writer, "  facet normal {:e} {:e} {:e}\n    outer loop", n.x, n.y, n.z)?;
            for p in corners {
                writeln!(writer, "      vertex {:e} {:e} {:e}", p.x, p.y, p.z)?;
            }
            writeln!(writer, "    endloop\n  endfacet")?;
        }
        writeln!(writer, "endsolid surface")
    })
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

/// Refuses surfaces that no reader could make sense of.
pub(super) fn writable(path: &Path, mesh: &Mesh) -> Result<(), FormatError> {
    if mesh.triangles.is_empty() {
        return Err(FormatError::unwritable(path, "the surface holds no triangle"));
    }
    let bad =
        mesh.facets().position(|corners| corners.iter().any(|p| !p.iter().all(|x| x.is_finite())));
    match bad {
        Some(triangle) => {
            let problem = format!("triangle {triangle} has a coordinate that is not finite");
            Err(FormatError::unwritable(path, problem))
        }
        None => Ok(()),
    }
}
