//! VTK XML PolyData (`.vtp`), as ParaView and OVITO read it: spheres as
//! vertices with a point array `radius`, triangle surfaces as polygons.
//!
//! Written: 64-bit numbers in base64 without compression, so nothing is
//! rounded. The array of positions is named `Points`, without which OVITO does
//! not read it; ids, bodies and materials count from 0. Time, step and box go
//! into the field data (`TimeValue` is the name that ParaView knows). Reading is
//! in `vtp_read`.

use super::atomic;
use super::base64;
use super::error::FormatError;
use super::number::number;
use super::particles::Particles;
use super::stl::writable;
use super::text::save;
use crate::geometry::Mesh;
use crate::num::Vec3;
use std::io::{self, Write};
use std::path::Path;

pub use super::vtp_read::read;

/// Names of the point arrays; the first is the one that is written, the others
/// are those of LIGGGHTS, YADE and OVITO.
pub(super) const RADIUS: &[&str] = &["radius", "Radius", "radii", "Radii"];
pub(super) const DIAMETER: &[&str] = &["diameter", "Diameter"];
pub(super) const ID: &[&str] = &["id", "Id", "ID", "Particle Identifier"];
pub(super) const BODY: &[&str] = &["body", "clumpId", "id_multisphere", "mol"];
pub(super) const MATERIAL: &[&str] = &["material", "materialId"];
pub(super) const DENSITY: &[&str] = &["density", "Density"];
pub(super) const VELOCITY: &[&str] = &["velocity", "Velocity", "v", "linVelVec"];
pub(super) const SPIN: &[&str] =
    &["angular_velocity", "Angular Velocity", "omega", "spin", "angVelVec"];
pub(super) const FORCE: &[&str] = &["force", "Force", "f"];
/// Names of the field arrays.
pub(super) const TIME: &str = "TimeValue";
pub(super) const STEP: &str = "Step";
pub(super) const BOX: &str = "Box";

/// Writes spheres as vertices.
pub fn write_particles(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    save(path, particles, |out| {
        open(out)?;
        let count = particles.len();
        piece(out, count, count, 0)?;
        point_data(out, particles)?;
        points(out, &particles.positions)?;
        cells(out, "Verts", (0..count).map(|sphere| sphere as i64), 1)?;
        writeln!(out, "</Piece>")?;
        // In front of the piece, where VTK puts it, it keeps OVITO from knowing the file.
        field_data(out, particles)?;
        close(out)
    })?;
    Ok(Vec::new())
}

/// Writes a surface as triangles.
pub fn write_mesh(path: &Path, mesh: &Mesh) -> Result<Vec<String>, FormatError> {
    writable(path, mesh)?;
    let corners: Vec<i64> = mesh.triangles.iter().flatten().map(|c| i64::from(*c)).collect();
    atomic::write(path, |out| {
        open(out)?;
        piece(out, mesh.vertices.len(), 0, mesh.triangles.len())?;
        points(out, &mesh.vertices)?;
        cells(out, "Polys", corners.iter().copied(), 3)?;
        writeln!(out, "</Piece>")?;
        close(out)
    })?;
    Ok(Vec::new())
}

fn open(out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <PolyData>"
    )
}

fn close(out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "</PolyData>\n</VTKFile>")
}

fn piece(out: &mut dyn Write, points: usize, verts: usize, polys: usize) -> io::Result<()> {
    writeln!(
        out,
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{verts}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">"
    )
}

fn field_data(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    writeln!(out, "<FieldData>")?;
    if let Some(time) = particles.time {
        field(out, "Float64", TIME, &number(time), 1)?;
    }
    if let Some(step) = particles.step {
        field(out, "Int64", STEP, &step.to_string(), 1)?;
    }
    if let Some(bounds) = particles.bounds {
        let ends: Vec<String> =
            bounds.low.iter().chain(bounds.high.iter()).map(|v| number(*v)).collect();
        field(out, "Float64", BOX, &ends.join(" "), 6)?;
    }
    writeln!(out, "</FieldData>")
}

fn field(out: &mut dyn Write, kind: &str, name: &str, text: &str, tuples: u8) -> io::Result<()> {
    writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfTuples=\"{tuples}\" \
         format=\"ascii\">{text}</DataArray>"
    )
}

fn point_data(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    let vectors = if particles.velocities.is_some() { " Vectors=\"velocity\"" } else { "" };
    writeln!(out, "<PointData Scalars=\"radius\"{vectors}>")?;
    reals(out, RADIUS[0], &particles.radii)?;
    for (name, column) in [(ID, &particles.ids), (BODY, &particles.bodies)] {
        if let Some(column) = column {
            wholes(out, name[0], column.iter().map(|v| *v as i64))?;
        }
    }
    if let Some(column) = &particles.materials {
        wholes(out, MATERIAL[0], column.iter().map(|v| i64::from(*v)))?;
    }
    if let Some(column) = &particles.densities {
        reals(out, DENSITY[0], column)?;
    }
    for (name, column) in
        [(VELOCITY, &particles.velocities), (SPIN, &particles.spins), (FORCE, &particles.forces)]
    {
        if let Some(column) = column {
            triples(out, name[0], column)?;
        }
    }
    writeln!(out, "</PointData>")
}

fn points(out: &mut dyn Write, positions: &[Vec3]) -> io::Result<()> {
    writeln!(out, "<Points>")?;
    triples(out, "Points", positions)?;
    writeln!(out, "</Points>")
}

/// Cells of `corners` points each.
fn cells(
    out: &mut dyn Write,
    kind: &str,
    connectivity: impl ExactSizeIterator<Item = i64>,
    corners: usize,
) -> io::Result<()> {
    let count = connectivity.len() / corners;
    writeln!(out, "<{kind}>")?;
    wholes(out, "connectivity", connectivity)?;
    wholes(out, "offsets", (0..count).map(|cell| ((cell + 1) * corners) as i64))?;
    writeln!(out, "</{kind}>")
}

/// Vectors, component by component.
fn triples(out: &mut dyn Write, name: &str, vectors: &[Vec3]) -> io::Result<()> {
    let flat = vectors.iter().flat_map(|vector| [vector.x, vector.y, vector.z]);
    array(out, ("Float64", name, 3), 3 * vectors.len(), flat.map(f64::to_le_bytes))
}

fn reals(out: &mut dyn Write, name: &str, values: &[f64]) -> io::Result<()> {
    array(out, ("Float64", name, 1), values.len(), values.iter().map(|value| value.to_le_bytes()))
}

fn wholes(
    out: &mut dyn Write,
    name: &str,
    values: impl ExactSizeIterator<Item = i64>,
) -> io::Result<()> {
    array(out, ("Int64", name, 1), values.len(), values.map(i64::to_le_bytes))
}

/// Words that are encoded at a time: whole groups of three bytes.
const PORTION: usize = 3 * 1024;

/// One array of `count` values; in front of them stands their length in bytes. Never the whole array as text, which
/// would be the peak of memory of a million spheres.
fn array(
    out: &mut dyn Write,
    (kind, name, components): (&str, &str, usize),
    count: usize,
    values: impl Iterator<Item = [u8; 8]>,
) -> io::Result<()> {
    writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
         format=\"binary\">"
    )?;
    let mut portion = Vec::with_capacity(PORTION);
    portion.push((count as u64 * 8).to_le_bytes());
    for value in values {
        portion.push(value);
        if portion.len() == PORTION {
            out.write_all(base64::encode(portion.as_flattened()).as_bytes())?;
            portion.clear();
        }
    }
    writeln!(out, "{}\n</DataArray>", base64::encode(portion.as_flattened()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{self, Data};

    #[test]
    fn tables_longer_than_a_portion_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        // One word of length and the radii: less than, exactly, and more than whole portions.
        for count in [1, PORTION - 2, PORTION - 1, PORTION, 2 * PORTION + 7] {
            let table = Particles {
                positions: (0..count).map(|i| Vec3::new(i as f64, 0.5, -1.0 / 3.0)).collect(),
                radii: (0..count).map(|i| 1.0 + (i as f64).sqrt()).collect(),
                bodies: Some((0..count as u64).rev().collect()),
                ..Particles::default()
            };
            let path = folder.path().join(format!("{count}.vtp"));
            write_particles(&path, &table).expect("written");
            let Ok(Data::Particles(read)) = format::read(&path) else { panic!("{count}") };
            assert_eq!(read.positions, table.positions);
            assert_eq!((read.radii, read.bodies), (table.radii, table.bodies));
        }
    }
}
