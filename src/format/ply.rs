//! PLY surfaces (Turk 1994): text, binary little endian and binary big endian
//! read; binary little endian with double precision coordinates written.
//!
//! Elements `vertex` (properties x, y, z of any number type) and `face` (list
//! `vertex_indices` or `vertex_index`) are used; polygons are cut into fans;
//! every other element and property is passed over.

use super::atomic;
use super::error::FormatError;
use super::obj::fan;
use super::stl::writable;
use crate::geometry::Mesh;
use crate::num::Vec3;
use std::fs;
use std::io::Write;
use std::path::Path;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Kind {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::Signed(1),
            "short" | "int16" => Self::Signed(2),
            "int" | "int32" => Self::Signed(4),
            "uchar" | "uint8" => Self::Unsigned(1),
            "ushort" | "uint16" => Self::Unsigned(2),
            "uint" | "uint32" => Self::Unsigned(4),
            "float" | "float32" => Self::Float(4),
            "double" | "float64" => Self::Float(8),
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::Signed(n) | Self::Unsigned(n) | Self::Float(n) => n,
        }
    }

    /// The number in `bytes`, lowest byte first.
    fn number(self, bytes: [u8; 8]) -> f64 {
        let whole = u64::from_le_bytes(bytes);
        match self {
            Self::Unsigned(_) => whole as f64,
            Self::Signed(n) => {
                let spare = 64 - 8 * n as u32;
                ((whole << spare) as i64 >> spare) as f64
            }
            Self::Float(4) => f64::from(f32::from_bits(whole as u32)),
            Self::Float(_) => f64::from_bits(whole),
        }
    }
}

struct Property {
    name: String,
    /// Type of the count, for lists.
    count: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// The body of the file, read number by number.
struct Body<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl Body<'_> {
    fn wrong(&self, problem: impl Into<String>) -> FormatError {
        match self.encoding {
            Encoding::Text => {
                let line = self.bytes[..self.at].iter().filter(|byte| **byte == b'\n').count();
                FormatError::line(self.path, line + 1, problem)
            }
            _ => FormatError::byte(self.path, self.at as u64, problem),
        }
    }

    fn number(&mut self, kind: Kind) -> Result<f64, FormatError> {
        if self.encoding == Encoding::Text {
            return self.word();
        }
        let size = kind.bytes();
        let Some(field) = self.bytes.get(self.at..self.at + size) else {
            return Err(self.wrong("the file ends here: it is truncated"));
        };
        let mut low_first = [0u8; 8];
        low_first[..size].copy_from_slice(field);
        if self.encoding == Encoding::Big {
            low_first[..size].reverse();
        }
        self.at += size;
        Ok(kind.number(low_first))
    }

    fn word(&mut self) -> Result<f64, FormatError> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace());
        let Some(start) = start else {
            self.at = self.bytes.len();
            return Err(self.wrong("the file ends here: it is truncated"));
        };
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(rest.len(), |length| start + length);
        let text = String::from_utf8_lossy(&rest[start..end]);
        self.at += start;
        let number = text.parse().map_err(|_| self.wrong(format!("`{text}` is no number")))?;
        self.at += end - start;
        Ok(number)
    }

    fn list_length(&mut self, kind: Kind) -> Result<usize, FormatError> {
        let count = self.number(kind)?;
        if count < 0.0 || count.fract() != 0.0 || count > self.bytes.len() as f64 {
            return Err(self.wrong(format!("{count} is no possible length of a list")));
        }
        Ok(count as usize)
    }
}

/// Reads a PLY file. Vertices are kept as they are, double precision.
pub fn read(path: &Path) -> Result<Mesh, FormatError> {
    let bytes = fs::read(path).map_err(|source| FormatError::io(path, "read", source))?;
    let (encoding, elements, start) = header(path, &bytes)?;
    let mut body = Body { path, bytes: &bytes, at: start, encoding };
    let mut mesh = Mesh::default();
    // An element without properties takes no space, whatever its count says.
    for element in elements.iter().filter(|element| !element.properties.is_empty()) {
        for index in 0..element.count {
            read_element(&mut body, element, index, &mut mesh)?;
        }
    }
    let vertices = mesh.vertices.len();
    let bad = mesh.triangles.iter().flatten().find(|corner| **corner as usize >= vertices);
    if let Some(corner) = bad {
        let problem = format!("a face names vertex {corner}, but there are {vertices} vertices");
        return Err(FormatError::file(path, problem));
    }
    if mesh.triangles.is_empty() {
        return Err(FormatError::file(path, "holds no face"));
    }
    Ok(mesh)
}

fn read_element(
    body: &mut Body,
    element: &Element,
    index: usize,
    mesh: &mut Mesh,
) -> Result<(), FormatError> {
    let mut point = [None; 3];
    for property in &element.properties {
        let Some(count) = property.count else {
            let value = body.number(property.kind)?;
            if let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == property.name) {
                point[axis] = Some(value);
            }
            continue;
        };
        let length = body.list_length(count)?;
        let mut list = Vec::with_capacity(length);
        for _ in 0..length {
            list.push(body.number(property.kind)?);
        }
        if element.name == "face" && property.name.starts_with("vertex_ind") {
            let corners: Vec<u32> = list.iter().map(|x| *x as u32).collect();
            if list.iter().zip(&corners).any(|(x, corner)| f64::from(*corner) != *x) {
                return Err(body.wrong(format!("face {index} has a corner that is no index")));
            }
            fan(&corners, &mut mesh.triangles).map_err(|problem| body.wrong(problem))?;
        }
    }
    if element.name == "vertex" {
        let [Some(x), Some(y), Some(z)] = point else {
            return Err(body.wrong("the element `vertex` needs the properties x, y, z"));
        };
        if ![x, y, z].iter().all(|x| x.is_finite()) {
            return Err(body.wrong(format!("vertex {index} lies at ({x}, {y}, {z})")));
        }
        mesh.vertices.push(Vec3::new(x, y, z));
    }
    Ok(())
}

/// Encoding, elements, and where the body begins.
fn header(path: &Path, bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), FormatError> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    for number in 1.. {
        let wrong = |problem: String| FormatError::line(path, number, problem);
        let Some(length) = bytes[at..].iter().position(|byte| *byte == b'\n') else {
            return Err(wrong("the header does not end: this is no PLY file".to_owned()));
        };
        let line = String::from_utf8_lossy(&bytes[at..at + length]).into_owned();
        at += length + 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if (number == 1) != (words[..] == ["ply"]) {
            return Err(wrong("a PLY file begins with one line `ply`".to_owned()));
        }
        match words[..] {
            ["format", name, _] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(wrong(format!("`{name}` is no encoding of PLY"))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong(format!("`{count}` is no count")))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref rest @ ..] => {
                let property = property(rest)
                    .ok_or_else(|| wrong(format!("`{}` is no property of PLY", line.trim())))?;
                let element = elements
                    .last_mut()
                    .ok_or_else(|| wrong("a property before the first element".to_owned()))?;
                element.properties.push(property);
            }
            ["end_header"] => {
                let encoding =
                    encoding.ok_or_else(|| wrong("there is no `format` line".to_owned()))?;
                return Ok((encoding, elements, at));
            }
            [] | ["ply"] | ["comment" | "obj_info", ..] => {}
            _ => return Err(wrong(format!("`{}` is no line of a PLY header", line.trim()))),
        }
    }
    unreachable!("the header is finite")
}

fn property(words: &[&str]) -> Option<Property> {
    Some(match words {
        ["list", count, kind, name] => Property {
            name: (*name).to_owned(),
            count: Some(Kind::parse(count)?),
            kind: Kind::parse(kind)?,
        },
        [kind, name] => {
            Property { name: (*name).to_owned(), count: None, kind: Kind::parse(kind)? }
        }
        _ => return None,
    })
}

/// Writes binary little endian PLY with double precision coordinates.
pub fn write(path: &Path, mesh: &Mesh) -> Result<(), FormatError> {
    writable(path, mesh)?;
    atomic::write(path, |writer| {
        write!(
            writer,
            "ply\nformat binary_little_endian 1.0\ncomment lengths in metres\n\
             element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            mesh.vertices.len(),
            mesh.triangles.len()
        )?;
        for p in &mesh.vertices {
            for x in p.iter() {
                writer.write_all(&x.to_le_bytes())?;
            }
        }
        for corners in &mesh.triangles {
            writer.write_all(&[3])?;
            for corner in corners {
                writer.write_all(&corner.to_le_bytes())?;
            }
        }
        Ok(())
    })
}
