//! Reading of VTK XML PolyData: what ParaView, OVITO, LIGGGHTS and we write.
//!
//! Arrays may be ASCII, base64 (inline or appended) or raw (appended), in
//! either byte order, not compressed. A point array `radius` (or `diameter`)
//! makes the file a table of spheres; else its polygons are a surface, those
//! with more than three corners cut into fans.

use super::Data;
use super::base64;
use super::columns::{real, shown};
use super::error::FormatError;
use super::particles::{LARGEST_MATERIAL, LARGEST_NUMBER, Particles};
use super::vtp::{
    BODY, BOX, DENSITY, DIAMETER, FORCE, ID, MATERIAL, RADIUS, SPIN, STEP, TIME, VELOCITY,
};
use super::xml::{Piece, Reader, attribute};
use crate::geometry::{Bounds, Mesh};
use crate::num::Vec3;
use std::path::Path;

/// Reads spheres or a surface; the notes name arrays that were passed over.
pub fn read(path: &Path) -> Result<(Data, Vec<String>), FormatError> {
    let bytes = std::fs::read(path).map_err(|source| FormatError::io(path, "read", source))?;
    parse(path, &bytes)
}

fn parse(path: &Path, bytes: &[u8]) -> Result<(Data, Vec<String>), FormatError> {
    let (markup, appended) = split_appended(bytes);
    let text = std::str::from_utf8(markup)
        .map_err(|error| FormatError::byte(path, error.valid_up_to() as u64, "is not text"))?;
    let mut reader = Reader::new(text);
    let mut file = VtkFile { appended, ..VtkFile::default() };
    file.scan(&mut reader).map_err(|problem| FormatError::line(path, reader.line(), problem))?;
    file.finish().map_err(|problem| FormatError::file(path, problem))
}

/// Markup and, behind the `_` that marks its start, appended data.
fn split_appended(bytes: &[u8]) -> (&[u8], &[u8]) {
    let tag = b"<AppendedData";
    let Some(start) = bytes.windows(tag.len()).position(|window| window == tag) else {
        return (bytes, &[]);
    };
    let after = &bytes[start..];
    let Some(open) = after.iter().position(|byte| *byte == b'>') else {
        return (bytes, &[]);
    };
    let (markup, data) = bytes.split_at(start + open + 1);
    match data.iter().position(|byte| !byte.is_ascii_whitespace()) {
        Some(first) if data[first] == b'_' => (markup, &data[first + 1..]),
        _ => (markup, &[]),
    }
}

/// One array as it stands in the file.
struct Array<'a> {
    /// The element that holds it: Points, PointData, Verts, Polys, FieldData, …
    section: &'a str,
    name: &'a str,
    kind: &'a str,
    components: usize,
    format: &'a str,
    offset: Option<usize>,
    text: &'a str,
}

#[derive(Default)]
struct VtkFile<'a> {
    big_endian: bool,
    wide_header: bool,
    appended: &'a [u8],
    appended_raw: bool,
    points: Option<usize>,
    arrays: Vec<Array<'a>>,
}

impl<'a> VtkFile<'a> {
    fn scan(&mut self, reader: &mut Reader<'a>) -> Result<(), String> {
        let mut section = "";
        let mut seen = false;
        while let Some(piece) = reader.next()? {
            match piece {
                Piece::Open("VTKFile", attributes) => {
                    self.head(&attributes)?;
                    seen = true;
                }
                Piece::Open("Piece", attributes) => {
                    if self.points.is_some() {
                        return Err("more than one piece; merge them first".to_owned());
                    }
                    let count = attribute(&attributes, "NumberOfPoints").unwrap_or("0");
                    self.points =
                        Some(count.parse().map_err(|_| "NumberOfPoints is not a whole number")?);
                }
                Piece::Open("DataArray", attributes) => {
                    self.arrays.push(declared(section, &attributes)?);
                }
                Piece::Open("AppendedData", attributes) => {
                    self.appended_raw = attribute(&attributes, "encoding") == Some("raw");
                }
                Piece::Open(
                    name @ ("Points" | "PointData" | "Verts" | "Lines" | "Strips" | "Polys"
                    | "CellData" | "FieldData"),
                    _,
                ) => section = name,
                Piece::Text(text) => {
                    if let Some(array) = self.arrays.last_mut().filter(|a| a.text.is_empty()) {
                        array.text = text;
                    }
                }
                Piece::Open(..) | Piece::Close(_) => {}
            }
        }
        if seen { Ok(()) } else { Err("there is no element `VTKFile`".to_owned()) }
    }

    fn head(&mut self, attributes: &[(&str, &str)]) -> Result<(), String> {
        match attribute(attributes, "type") {
            Some("PolyData") => {}
            other => {
                return Err(format!(
                    "holds `{}`; only PolyData is read",
                    shown(other.unwrap_or("nothing"))
                ));
            }
        }
        if attribute(attributes, "compressor").is_some() {
            return Err(
                "is compressed; save it again without (ParaView: Compressor Type None)".to_owned()
            );
        }
        self.big_endian = attribute(attributes, "byte_order") == Some("BigEndian");
        self.wide_header = attribute(attributes, "header_type") == Some("UInt64");
        Ok(())
    }

    fn array(&self, section: &str, names: &[&str]) -> Option<&Array<'a>> {
        names.iter().find_map(|name| {
            self.arrays.iter().find(|array| array.section == section && array.name == *name)
        })
    }

    /// All numbers of an array. 64-bit whole numbers above 2⁵³ are rounded,
    /// which the range checks of ids and indices then refuse.
    fn values(&self, array: &Array) -> Result<Vec<f64>, String> {
        let name = shown(array.name);
        let data = match array.format {
            "ascii" => {
                return array
                    .text
                    .split_whitespace()
                    .map(|word| real(word).map_err(|problem| format!("array `{name}`: {problem}")))
                    .collect();
            }
            "binary" => self.block(&decoded(array.text.as_bytes(), &name)?),
            "appended" => {
                let start = array.offset.filter(|offset| *offset <= self.appended.len());
                let start =
                    start.ok_or(format!("array `{name}`: its offset is not in the file"))?;
                let rest = &self.appended[start..];
                if self.appended_raw {
                    self.block(rest)
                } else {
                    let end = rest.iter().position(|b| *b == b'<').unwrap_or(rest.len());
                    self.block(
                        &base64_block(&rest[..end], self.header_bytes(), |head| self.length(head))
                            .ok_or(format!("array `{name}`: is not base64"))?,
                    )
                }
            }
            other => return Err(format!("array `{name}`: format `{}` is not known", shown(other))),
        };
        let data = data.ok_or(format!("array `{name}`: is cut off"))?;
        self.numbers(&data, array.kind)
            .ok_or(format!("array `{name}`: type `{}` does not fit its length", shown(array.kind)))
    }

    fn header_bytes(&self) -> usize {
        if self.wide_header { 8 } else { 4 }
    }

    /// The length in bytes that stands in front of an array.
    fn length(&self, head: &[u8]) -> Option<usize> {
        let head = head.get(..self.header_bytes())?;
        let mut wide = [0; 8];
        for (place, byte) in head.iter().enumerate() {
            let at = if self.big_endian { head.len() - 1 - place } else { place };
            wide[at] = *byte;
        }
        usize::try_from(u64::from_le_bytes(wide)).ok()
    }

    /// The values of an array that begins with its length.
    fn block(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let length = self.length(bytes)?;
        let start = self.header_bytes();
        bytes.get(start..start.checked_add(length)?).map(<[u8]>::to_vec)
    }

    fn numbers(&self, bytes: &[u8], kind: &str) -> Option<Vec<f64>> {
        macro_rules! read {
            ($type:ty) => {{
                let (chunks, rest) = bytes.as_chunks::<{ size_of::<$type>() }>();
                rest.is_empty().then(|| {
                    chunks
                        .iter()
                        .map(|chunk| match self.big_endian {
                            true => <$type>::from_be_bytes(*chunk) as f64,
                            false => <$type>::from_le_bytes(*chunk) as f64,
                        })
                        .collect()
                })
            }};
        }
        match kind {
            "Float64" => read!(f64),
            "Float32" => read!(f32),
            "Int64" => read!(i64),
            "UInt64" => read!(u64),
            "Int32" => read!(i32),
            "UInt32" => read!(u32),
            "Int16" => read!(i16),
            "UInt16" => read!(u16),
            "Int8" => read!(i8),
            "UInt8" => read!(u8),
            _ => None,
        }
    }

    fn finish(&self) -> Result<(Data, Vec<String>), String> {
        let count = self.points.unwrap_or(0);
        let positions = match self.arrays.iter().find(|array| array.section == "Points") {
            Some(array) => vectors(array, &self.values(array)?)?,
            None => Vec::new(),
        };
        if positions.len() != count {
            return Err(format!("NumberOfPoints is {count}, but there are {}", positions.len()));
        }
        if positions.iter().flat_map(|p| p.iter()).any(|v| !v.is_finite()) {
            return Err("a position is not finite".to_owned());
        }
        let radii = self.array("PointData", RADIUS).map(|array| (array, 1.0));
        match radii.or(self.array("PointData", DIAMETER).map(|array| (array, 0.5))) {
            Some((array, factor)) => self.particles(positions, array, factor),
            None => self.mesh(positions),
        }
    }

    fn particles(
        &self,
        positions: Vec<Vec3>,
        radii: &Array,
        factor: f64,
    ) -> Result<(Data, Vec<String>), String> {
        let scalar = |names: &[&str]| {
            self.array("PointData", names).map(|array| self.values(array)).transpose()
        };
        let vector = |names: &[&str]| {
            self.array("PointData", names)
                .map(|array| vectors(array, &self.values(array)?))
                .transpose()
        };
        let counted = |names: &[&str], largest: u64| {
            scalar(names)?.map(|values| wholes(names[0], &values, largest)).transpose()
        };
        let materials = counted(MATERIAL, u64::from(LARGEST_MATERIAL))?;
        let particles = Particles {
            positions,
            radii: self.values(radii)?.into_iter().map(|value| value * factor).collect(),
            ids: counted(ID, LARGEST_NUMBER)?,
            bodies: counted(BODY, LARGEST_NUMBER)?,
            materials: materials.map(|m| m.into_iter().map(|v| v as u32).collect()),
            densities: scalar(DENSITY)?,
            velocities: vector(VELOCITY)?,
            spins: vector(SPIN)?,
            forces: vector(FORCE)?,
            time: self.field(TIME)?.and_then(|values| values.first().copied()),
            step: match self.field(STEP)? {
                Some(values) => wholes(STEP, &values, LARGEST_NUMBER)?.first().copied(),
                None => None,
            },
            bounds: self.field(BOX)?.and_then(|values| match values[..] {
                [a, b, c, d, e, f] => {
                    Some(Bounds { low: Vec3::new(a, b, c), high: Vec3::new(d, e, f) })
                }
                _ => None,
            }),
        };
        particles.check().map_err(|fault| fault.to_string())?;
        let used = [RADIUS, DIAMETER, ID, BODY, MATERIAL, DENSITY, VELOCITY, SPIN, FORCE].concat();
        let notes = self
            .arrays
            .iter()
            .filter(|a| matches!(a.section, "PointData" | "CellData") && !used.contains(&a.name))
            .map(|array| format!("array `{}` not read", shown(array.name)))
            .collect();
        Ok((Data::Particles(particles), notes))
    }

    fn field(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        self.array("FieldData", &[name]).map(|array| self.values(array)).transpose()
    }

    fn mesh(&self, vertices: Vec<Vec3>) -> Result<(Data, Vec<String>), String> {
        let cells = |section: &str, name: &str| match self.array(section, &[name]) {
            Some(array) => wholes(name, &self.values(array)?, LARGEST_NUMBER),
            None => Ok(Vec::new()),
        };
        if !cells("Strips", "offsets")?.is_empty() {
            return Err("holds triangle strips; triangulate it first".to_owned());
        }
        if cells("Polys", "offsets")?.is_empty() {
            return Err("holds neither polygons nor a point array `radius`".to_owned());
        }
        let limit = u32::try_from(vertices.len()).map_err(|_| "has too many vertices")?;
        let corners: Vec<u32> = cells("Polys", "connectivity")?
            .into_iter()
            .map(|corner| u32::try_from(corner).ok().filter(|corner| *corner < limit))
            .collect::<Option<_>>()
            .ok_or("a polygon has a corner that is no vertex")?;
        let mut triangles = Vec::new();
        let mut start = 0;
        for end in cells("Polys", "offsets")? {
            let polygon = usize::try_from(end)
                .ok()
                .and_then(|end| corners.get(start..end))
                .filter(|polygon| polygon.len() >= 3)
                .ok_or("a polygon has less than three corners or is cut off")?;
            triangles.extend(polygon[1..].windows(2).map(|pair| [polygon[0], pair[0], pair[1]]));
            start += polygon.len();
        }
        Ok((Data::Mesh(Mesh { vertices, triangles }), Vec::new()))
    }
}

fn declared<'a>(section: &'a str, attributes: &[(&'a str, &'a str)]) -> Result<Array<'a>, String> {
    let whole = |key: &str| {
        attribute(attributes, key)
            .map(|text| text.parse::<usize>().map_err(|_| format!("{key} is not a whole number")))
            .transpose()
    };
    Ok(Array {
        section,
        name: attribute(attributes, "Name").unwrap_or_default(),
        kind: attribute(attributes, "type").unwrap_or_default(),
        components: whole("NumberOfComponents")?.unwrap_or(1),
        format: attribute(attributes, "format").unwrap_or("ascii"),
        offset: whole("offset")?,
        text: "",
    })
}

fn decoded(text: &[u8], name: &str) -> Result<Vec<u8>, String> {
    base64::decode(text).ok_or(format!("array `{name}`: is not base64"))
}

/// The bytes of one appended base64 array: the next one follows without a gap,
/// so the length in its header says where it ends.
fn base64_block(
    text: &[u8],
    header: usize,
    length: impl Fn(&[u8]) -> Option<usize>,
) -> Option<Vec<u8>> {
    let symbols = header.div_ceil(3) * 4;
    let size = length(&base64::decode(text.get(..symbols)?)?)?;
    let symbols = header.checked_add(size)?.div_ceil(3).checked_mul(4)?;
    base64::decode(text.get(..symbols)?)
}

fn vectors(array: &Array, values: &[f64]) -> Result<Vec<Vec3>, String> {
    let (chunks, rest) = values.as_chunks::<3>();
    if array.components != 3 || !rest.is_empty() {
        return Err(format!("array `{}` should hold three components a point", shown(array.name)));
    }
    Ok(chunks.iter().map(|chunk| Vec3::from(*chunk)).collect())
}

fn wholes(name: &str, values: &[f64], largest: u64) -> Result<Vec<u64>, String> {
    values
        .iter()
        .map(|value| {
            (value.fract() == 0.0 && (0.0..=largest as f64).contains(value))
                .then_some(*value as u64)
        })
        .collect::<Option<_>>()
        .ok_or(format!("array `{name}` should hold whole numbers from 0 to {largest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_bytes(bytes: &[u8]) -> Result<(Data, Vec<String>), FormatError> {
        parse(Path::new("t.vtp"), bytes)
    }

    fn spheres(bytes: &[u8]) -> Particles {
        match parse_bytes(bytes) {
            Ok((Data::Particles(particles), _)) => particles,
            other => panic!("{other:?}"),
        }
    }

    const TWO: &str = "<VTKFile type='PolyData' byte_order='BigEndian'>\n<PolyData>\n\
        <Piece NumberOfPoints='2'>\n<PointData>\n\
        <DataArray type='Float32' Name='radii' RADII</DataArray>\n\
        <DataArray type='Int32' Name='grade' format='ascii'>1 2</DataArray>\n\
        </PointData>\n<Points>\n<DataArray type='Float64' NumberOfComponents='3' POINTS</DataArray>\n\
        </Points>\n</Piece>\n</PolyData>\n";

    fn ascii() -> String {
        TWO.replace("RADII", "format='ascii'>\n0.5\t0.25\n")
            .replace("POINTS", "format='ascii'>0 1 2 3 4 5")
            + "</VTKFile>"
    }

    #[test]
    fn text_and_appended_bytes_say_the_same() {
        let plain = spheres(ascii().as_bytes());
        assert_eq!(plain.positions[1], Vec3::new(3.0, 4.0, 5.0));
        assert_eq!(plain.radii, vec![0.5, 0.25]);
        let mut data = 8u32.to_be_bytes().to_vec();
        data.extend([0.5f32, 0.25].iter().flat_map(|v| v.to_be_bytes()));
        let second = data.len();
        data.extend(48u32.to_be_bytes());
        data.extend([0.0f64, 1.0, 2.0, 3.0, 4.0, 5.0].iter().flat_map(|v| v.to_be_bytes()));
        let head = |second: usize| {
            TWO.replace("RADII", "format='appended' offset='0'>")
                .replace("POINTS", &format!("format='appended' offset='{second}'>"))
        };
        let mut raw = (head(second) + "<AppendedData encoding='raw'>\n_").into_bytes();
        raw.extend(&data);
        raw.extend(b"\n</AppendedData></VTKFile>");
        assert_eq!(spheres(&raw), plain);
        let coded = base64::encode(&data[..second]);
        let text = head(coded.len())
            + "<AppendedData encoding='base64'>\n_"
            + &coded
            + &base64::encode(&data[second..])
            + "\n</AppendedData></VTKFile>";
        assert_eq!(spheres(text.as_bytes()), plain);
    }

    #[test]
    fn polygons_are_cut_into_triangles() {
        let text = "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='4'>\
            <Points><DataArray type='Float32' NumberOfComponents='3'>0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>\
            <Polys><DataArray type='Int32' Name='connectivity'>0 1 2 3</DataArray>\
            <DataArray type='Int32' Name='offsets'>4</DataArray></Polys></Piece></PolyData></VTKFile>";
        match parse_bytes(text.as_bytes()) {
            Ok((Data::Mesh(mesh), _)) => assert_eq!(mesh.triangles, vec![[0, 1, 2], [0, 2, 3]]),
            other => panic!("{other:?}"),
        }
        let error = parse_bytes(text.replace("0 1 2 3<", "0 1 2 4<").as_bytes());
        assert!(error.is_err_and(|e| e.to_string().contains("a corner that is no vertex")));
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let good = ascii();
        for (from, to, part) in [
            (
                "type='PolyData'",
                "type='UnstructuredGrid'",
                "t.vtp: line 1: holds `UnstructuredGrid`",
            ),
            (
                "type='PolyData'",
                "type='PolyData' compressor='vtkZLibDataCompressor'",
                "is compressed",
            ),
            ("<PointData>", "<PointData", "line 4: "),
            ("NumberOfPoints='2'", "NumberOfPoints='3'", "NumberOfPoints is 3, but there are 2"),
            ("0.5\t", "", "`radii` has 1 entries"),
            ("0.5\t", "x\t", "array `radii`: `x` is not a number"),
            ("0.5\t", "-0.5\t", "`radii[0]` is -0.5"),
            ("Name='radii'", "Name='size'", "holds neither polygons"),
        ] {
            let damaged = good.replace(from, to);
            assert_ne!(damaged, good, "{from}");
            let error = parse_bytes(damaged.as_bytes()).map(|_| ()).expect_err(part).to_string();
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}
