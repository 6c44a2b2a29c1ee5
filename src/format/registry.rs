//! The list of formats: what each is called, what it can carry, who reads it.

use super::error::FormatError;
use super::particles::Particles;
use super::{Data, csv, known, lammps_dump, liggghts_data, obj, ply, stl, vtp, xyz, yade_text};
use crate::geometry::Mesh;
use std::path::Path;

/// What a file can hold of a sphere besides its place and radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// Numbers of the spheres.
    Ids,
    /// Numbers of bodies (clumps).
    Bodies,
    /// Numbers of materials.
    Materials,
    /// Densities.
    Densities,
    /// Velocities.
    Velocities,
    /// Angular velocities.
    Spins,
    /// Forces.
    Forces,
    /// Time.
    Time,
    /// Step number.
    Step,
    /// Box of the simulation.
    Box,
}

impl Column {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Ids,
        Self::Bodies,
        Self::Materials,
        Self::Densities,
        Self::Velocities,
        Self::Spins,
        Self::Forces,
        Self::Time,
        Self::Step,
        Self::Box,
    ];

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ids => "ids",
            Self::Bodies => "body numbers",
            Self::Materials => "materials",
            Self::Densities => "densities",
            Self::Velocities => "velocities",
            Self::Spins => "angular velocities",
            Self::Forces => "forces",
            Self::Time => "time",
            Self::Step => "step number",
            Self::Box => "box",
        }
    }

    /// True if `particles` has it.
    pub fn is_in(self, particles: &Particles) -> bool {
        match self {
            Self::Ids => particles.ids.is_some(),
            Self::Bodies => particles.bodies.is_some(),
            Self::Materials => particles.materials.is_some(),
            Self::Densities => particles.densities.is_some(),
            Self::Velocities => particles.velocities.is_some(),
            Self::Spins => particles.spins.is_some(),
            Self::Forces => particles.forces.is_some(),
            Self::Time => particles.time.is_some(),
            Self::Step => particles.step.is_some(),
            Self::Box => particles.bounds.is_some(),
        }
    }
}

/// What a reader returns: the data, and one sentence for each thing in the
/// file that was passed over.
pub type Reading = Result<(Data, Vec<String>), FormatError>;
/// What a writer returns: one sentence for each thing that had to be left out
/// or chosen.
pub type Writing = Result<Vec<String>, FormatError>;

/// One file format.
#[derive(Debug)]
pub struct Format {
    /// Short name.
    pub name: &'static str,
    /// Extensions in lower case, without the dot; the first is the usual one.
    pub extensions: &'static [&'static str],
    /// One line for people.
    pub about: &'static str,
    /// What it holds of spheres besides place and radius.
    pub columns: &'static [Column],
    /// Reads a file.
    pub read: fn(&Path) -> Reading,
    /// Writes a surface; `None` where the format holds no surfaces.
    pub write_mesh: Option<fn(&Path, &Mesh) -> Writing>,
    /// Writes spheres; `None` where the format holds no spheres.
    pub write_particles: Option<fn(&Path, &Particles) -> Writing>,
    /// True if a file that begins like this (4 kB, blanks in front removed) is of this format.
    pub recognises: fn(&str) -> bool,
}

impl Format {
    /// Writes `data`; returns what was left out or had to be chosen.
    pub fn write(&self, path: &Path, data: &Data) -> Writing {
        match (data, self.write_mesh, self.write_particles) {
            (Data::Mesh(mesh), Some(write), _) => {
                // Formats with a table of vertices hold those of no triangle as well.
                match mesh.vertices.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
                    Some(vertex) => Err(FormatError::unwritable(
                        path,
                        format!("vertex {vertex} has a coordinate that is not finite"),
                    )),
                    None => write(path, mesh),
                }
            }
            (Data::Particles(particles), _, Some(write)) => {
                let mut notes = self.lost(particles);
                notes.extend(write(path, particles)?);
                Ok(notes)
            }
            (Data::Mesh(_), None, _) => {
                Err(self.refuse(path, "a surface", "spheres", |format| format.write_mesh.is_some()))
            }
            (Data::Particles(_), _, None) => {
                Err(self
                    .refuse(path, "spheres", "surfaces", |format| format.write_particles.is_some()))
            }
        }
    }

    fn refuse(
        &self,
        path: &Path,
        given: &str,
        holds: &str,
        fits: impl Fn(&Self) -> bool,
    ) -> FormatError {
        FormatError::unwritable(
            path,
            format!(
                "the data is {given}, and {} files hold {holds} only; for {given} there are {}",
                self.name,
                known(fits)
            ),
        )
    }

    /// One sentence for each column of `particles` that this format has no place for.
    fn lost(&self, particles: &Particles) -> Vec<String> {
        Column::ALL
            .iter()
            .filter(|column| column.is_in(particles) && !self.columns.contains(column))
            .map(|column| {
                format!("{} not written: {} has no place for it", column.name(), self.name)
            })
            .collect()
    }
}

/// Every known format.
pub static FORMATS: &[Format] = &[
    Format {
        name: "CSV",
        extensions: &["csv"],
        about: "table with a header: id,body,material,x,y,z,r,vx,…; clumps as x,y,z,r",
        columns: &[
            Column::Ids,
            Column::Bodies,
            Column::Materials,
            Column::Densities,
            Column::Velocities,
            Column::Spins,
            Column::Forces,
        ],
        read: |path| csv::read(path).map(spheres),
        write_mesh: None,
        write_particles: Some(csv::write),
        recognises: is_csv,
    },
    Format {
        name: "VTP",
        extensions: &["vtp"],
        about: "VTK XML PolyData for ParaView and OVITO: spheres as points with radius, or triangles",
        columns: Column::ALL,
        read: vtp::read,
        write_mesh: Some(vtp::write_mesh),
        write_particles: Some(vtp::write_particles),
        recognises: |head| head.starts_with("<?xml") || head.starts_with("<VTKFile"),
    },
    Format {
        name: "LAMMPS dump",
        extensions: &["dump", "lammpstrj", "liggghts"],
        about: "text dump of LIGGGHTS and LAMMPS, also read by OVITO; many frames a file",
        columns: Column::ALL,
        read: |path| lammps_dump::read(path).map(spheres),
        write_mesh: None,
        write_particles: Some(lammps_dump::write),
        recognises: |head| head.starts_with("ITEM:"),
    },
    Format {
        name: "LIGGGHTS data",
        extensions: &["data"],
        about: "start configuration for read_data of LIGGGHTS and LAMMPS, spheres or clumps",
        columns: &[
            Column::Ids,
            Column::Bodies,
            Column::Materials,
            Column::Densities,
            Column::Velocities,
            Column::Spins,
            Column::Box,
        ],
        read: |path| liggghts_data::read(path).map(spheres),
        write_mesh: None,
        write_particles: Some(liggghts_data::write),
        recognises: |head| head.contains("xlo xhi"),
    },
    Format {
        name: "extended XYZ",
        extensions: &["xyz", "extxyz"],
        about: "extended XYZ with radius and more, for OVITO",
        columns: Column::ALL,
        read: |path| xyz::read(path).map(spheres),
        write_mesh: None,
        write_particles: Some(xyz::write),
        recognises: |head| head.lines().nth(1).is_some_and(|line| line.contains("Properties=")),
    },
    Format {
        name: "YADE text",
        extensions: &["txt", "spheres"],
        about: "x y z r with clump or material for YADE's ymport.textExt and textClumps",
        columns: &[Column::Ids, Column::Bodies, Column::Materials],
        read: |path| yade_text::read(path).map(spheres),
        write_mesh: None,
        write_particles: Some(yade_text::write),
        recognises: |head| head.lines().any(|line| line.starts_with("#format")),
    },
    Format {
        name: "STL",
        extensions: &["stl"],
        about: "triangles; text and binary read, binary (single precision) written",
        columns: &[],
        read: |path| stl::read(path).map(surface),
        write_mesh: Some(write_stl),
        write_particles: None,
        recognises: |head| head.starts_with("solid") && head.contains("facet"),
    },
    Format {
        name: "PLY",
        extensions: &["ply"],
        about: "polygons; text and binary read, binary double precision written",
        columns: &[],
        read: |path| ply::read(path).map(surface),
        write_mesh: Some(|path, mesh| ply::write(path, mesh).map(|()| Vec::new())),
        write_particles: None,
        recognises: |head| head.starts_with("ply\n") || head.starts_with("ply\r"),
    },
    Format {
        name: "OBJ",
        extensions: &["obj"],
        about: "Wavefront polygons; text with all digits",
        columns: &[],
        read: |path| obj::read(path).map(surface),
        write_mesh: Some(|path, mesh| obj::write(path, mesh).map(|()| Vec::new())),
        write_particles: None,
        recognises: |head| head.lines().any(|line| line.starts_with("v ")),
    },
];

/// Writes binary STL and says so where single precision rounds.
fn write_stl(path: &Path, mesh: &Mesh) -> Writing {
    stl::write(path, mesh)?;
    let rounded = mesh.facets().flatten().flat_map(|corner| [corner.x, corner.y, corner.z]);
    let largest = rounded.map(|x| (f64::from(x as f32) - x).abs()).fold(0.0, f64::max);
    let note = format!("coordinates rounded to single precision, by up to {largest:.1e} m");
    Ok(if largest > 0.0 { vec![note] } else { Vec::new() })
}

fn surface(mesh: Mesh) -> (Data, Vec<String>) {
    (Data::Mesh(mesh), Vec::new())
}

fn spheres((particles, notes): (Particles, Vec<String>)) -> (Data, Vec<String>) {
    (Data::Particles(particles), notes)
}

/// True if the first line that is not empty and not a comment is four words or
/// more with commas between them.
fn is_csv(head: &str) -> bool {
    let row = head.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    row.is_some_and(|row| {
        let cells = || row.split(',').map(str::trim);
        cells().count() >= 4 && cells().all(|cell| !cell.contains(char::is_whitespace))
    })
}
