//! Data files (`read_data`) of LIGGGHTS and LAMMPS with granular atoms.
//!
//! Single spheres: `Atoms` lines `id type DIAMETER density x y z` (atom style
//! sphere or granular). Clumps: `id type x y z DIAMETER density molecule`
//! (atom style hybrid granular molecular). `Velocities` lines are
//! `id vx vy vz wx wy wz`. Ids, types and molecules count from 1 in the file
//! and from 0 in the table; molecule 0 becomes a body of its own. The first
//! line is a title that every program skips.

use super::columns::{Field, Rows, real, shown, whole};
use super::error::FormatError;
use super::number::number;
use super::particles::Particles;
use super::text::{Lines, save, write_rows};
use crate::geometry::Bounds;
use crate::num::Vec3;
use std::io::{self, BufRead, Write};
use std::path::Path;

const SPHERES: [Field; 7] = [
    Field::Id,
    Field::Material,
    Field::Diameter,
    Field::Density,
    Field::Position(0),
    Field::Position(1),
    Field::Position(2),
];

const CLUMPS: [Field; 8] = [
    Field::Id,
    Field::Material,
    Field::Position(0),
    Field::Position(1),
    Field::Position(2),
    Field::Diameter,
    Field::Density,
    Field::Body,
];

const VELOCITIES: [Field; 7] = [
    Field::Id,
    Field::Velocity(0),
    Field::Velocity(1),
    Field::Velocity(2),
    Field::Spin(0),
    Field::Spin(1),
    Field::Spin(2),
];

/// Writes a data file: the clump columns where some body has more than one
/// sphere, else the sphere columns.
///
/// The solver loses atoms that are not inside the box, so the box grows where
/// it must to hold every sphere. The notes name what was not known and what
/// was written instead.
pub fn write(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    let mut notes = Vec::new();
    let mut particles = particles.clone();
    particles.check().map_err(|fault| FormatError::unwritable(path, fault.to_string()))?;
    if particles.densities.is_none() {
        notes.push("no density known: written as 1 kg/m³; give yours with `set … density`".into());
        particles.densities = Some(vec![1.0; particles.len()]);
    }
    if particles.velocities.is_some() != particles.spins.is_some() {
        let unknown = if particles.spins.is_none() { "spin" } else { "velocity" };
        notes.push(format!("no {unknown} known: written as 0"));
    }
    if particles.bodies.is_some() && !particles.has_clumps() {
        notes.push("body numbers not written: every body is one sphere".into());
    }
    let domain = domain(&particles);
    match particles.bounds {
        None => notes.push("no box known: written with a margin around the spheres".into()),
        Some(known) if known != domain => {
            notes.push("box made larger: it has to hold every sphere".into());
        }
        Some(_) => {}
    }
    particles.bounds = Some(domain);
    save(path, &particles, |out| write_to(out, &particles))?;
    Ok(notes)
}

/// The box of `particles`, grown to hold all spheres: an atom that lies on its
/// upper face is refused by the solver. Where no box is known, half the
/// smallest radius more on every side.
fn domain(particles: &Particles) -> Bounds {
    let around = Particles { bounds: None, ..particles.clone() }.extent();
    match particles.bounds {
        Some(bounds) => bounds.union(&around),
        None => {
            let margin = particles.radii.iter().copied().reduce(f64::min).unwrap_or(1.0) * 0.5;
            around.grown(margin)
        }
    }
}

fn write_to(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    let clumps = particles.has_clumps();
    let types =
        particles.materials.iter().flatten().max().map_or(1, |largest| u64::from(*largest) + 1);
    let style = if clumps { "hybrid granular molecular" } else { "sphere (granular)" };
    writeln!(out, "{} spheres for atom_style {style} in SI units\n", particles.len())?;
    writeln!(out, "{} atoms\n{types} atom types\n", particles.len())?;
    let bounds = particles.extent();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (number(bounds.low[axis]), number(bounds.high[axis]));
        writeln!(out, "{low} {high} {name}lo {name}hi")?;
    }
    writeln!(out, "\nAtoms\n")?;
    write_rows(out, particles, if clumps { &CLUMPS } else { &SPHERES }, ' ', 1)?;
    if particles.velocities.is_some() || particles.spins.is_some() {
        writeln!(out, "\nVelocities\n")?;
        write_rows(out, particles, &VELOCITIES, ' ', 1)?;
    }
    Ok(())
}

/// Reads a data file; the notes name sections that were passed over.
pub fn read(path: &Path) -> Result<(Particles, Vec<String>), FormatError> {
    read_lines(Lines::open(path)?)
}

fn read_lines<R: BufRead>(mut lines: Lines<R>) -> Result<(Particles, Vec<String>), FormatError> {
    let mut file = DataFile::default();
    let mut line = String::new();
    // The title, which may be empty.
    lines.next(&mut line)?;
    let mut section = Section::Header;
    while lines.next_filled(&mut line)? {
        let text = line.split('#').next().unwrap_or_default().trim();
        if text.is_empty() {
            continue;
        }
        let outcome = if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            file.open(text).map(|opened| section = opened)
        } else {
            file.take(section, text)
        };
        outcome.map_err(|problem| lines.wrong(problem))?;
    }
    file.finish().map_err(|problem| lines.wrong_file(problem))
}

#[derive(Clone, Copy, PartialEq)]
enum Section {
    Header,
    Atoms,
    Velocities,
    Other,
}

#[derive(Default)]
struct DataFile {
    count: Option<u64>,
    low: [Option<f64>; 3],
    high: [Option<f64>; 3],
    atoms: Option<Rows>,
    velocities: Vec<(u64, Vec3, Vec3)>,
    notes: Vec<String>,
}

impl DataFile {
    fn open(&mut self, title: &str) -> Result<Section, String> {
        match title {
            "Atoms" if self.atoms.is_some() => Err("section `Atoms` comes twice".to_owned()),
            "Atoms" => Ok(Section::Atoms),
            "Velocities" => Ok(Section::Velocities),
            _ => {
                self.notes.push(format!("section `{}` not read", shown(title)));
                Ok(Section::Other)
            }
        }
    }

    fn take(&mut self, section: Section, text: &str) -> Result<(), String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        match section {
            Section::Header => self.header(&words),
            Section::Atoms => self.atom(&words),
            Section::Velocities => self.velocity(&words),
            Section::Other => Ok(()),
        }
    }

    fn header(&mut self, words: &[&str]) -> Result<(), String> {
        match words {
            [count, "atoms"] => self.count = Some(whole(count)?),
            [low, high, "xlo", "xhi"] => self.edge(0, low, high)?,
            [low, high, "ylo", "yhi"] => self.edge(1, low, high)?,
            [low, high, "zlo", "zhi"] => self.edge(2, low, high)?,
            [.., "xy", "xz", "yz"] => {
                return Err("the box is oblique; only boxes along the axes are read".into());
            }
            // Other header lines ("2 atom types") say nothing that is kept.
            _ => {}
        }
        Ok(())
    }

    fn edge(&mut self, axis: usize, low: &str, high: &str) -> Result<(), String> {
        let (low, high) = (real(low)?, real(high)?);
        if low > high {
            return Err("the lower end of the box is above the upper end".to_owned());
        }
        self.low[axis] = Some(low);
        self.high[axis] = Some(high);
        Ok(())
    }

    /// One line of the section `Atoms`, three image flags at its end allowed.
    fn atom(&mut self, words: &[&str]) -> Result<(), String> {
        let rows = match &mut self.atoms {
            Some(rows) => rows,
            empty => {
                let fields = match words.len() {
                    7 | 10 => SPHERES.to_vec(),
                    8 | 11 => CLUMPS.to_vec(),
                    other => {
                        return Err(format!(
                            "{other} columns; known: `id type diameter density x y z` and \
                         `id type x y z diameter density molecule`"
                        ));
                    }
                };
                empty.insert(Rows::new(fields, 1, |field| format!("{field:?}"))?)
            }
        };
        let columns = rows.columns();
        let flagged = words.len() == columns + 3;
        rows.add(words.iter().copied().take(if flagged { columns } else { words.len() }))
    }

    fn velocity(&mut self, words: &[&str]) -> Result<(), String> {
        let &[id, vx, vy, vz, wx, wy, wz] = words else {
            return Err(format!("{} columns; a velocity is `id vx vy vz wx wy wz`", words.len()));
        };
        self.velocities.push((
            whole(id)?,
            Vec3::new(real(vx)?, real(vy)?, real(vz)?),
            Vec3::new(real(wx)?, real(wy)?, real(wz)?),
        ));
        Ok(())
    }

    fn finish(mut self) -> Result<(Particles, Vec<String>), String> {
        let count = self.count.ok_or("the header lacks a line `N atoms`")?;
        let mut particles = match self.atoms.take() {
            Some(rows) => rows.finish(),
            None => Rows::new(SPHERES.to_vec(), 1, |field| format!("{field:?}"))?.finish(),
        };
        if particles.len() as u64 != count {
            return Err(format!(
                "the header says {count} atoms, but there are {}",
                particles.len()
            ));
        }
        let [Some(x0), Some(y0), Some(z0)] = self.low else {
            return Err("the header lacks a line `LOW HIGH xlo xhi` (or y, z)".to_owned());
        };
        let [Some(x1), Some(y1), Some(z1)] = self.high else {
            return Err("the header lacks a line `LOW HIGH xlo xhi` (or y, z)".to_owned());
        };
        particles.bounds = Some(Bounds { low: Vec3::new(x0, y0, z0), high: Vec3::new(x1, y1, z1) });
        self.move_atoms(&mut particles)?;
        particles.check().map_err(|fault| fault.to_string())?;
        Ok((particles, self.notes))
    }

    /// Gives each atom its velocity by id.
    fn move_atoms(&mut self, particles: &mut Particles) -> Result<(), String> {
        let ids = particles.ids.clone().unwrap_or_default();
        let mut order: Vec<usize> = (0..ids.len()).collect();
        order.sort_by_key(|&row| ids[row]);
        if let Some(pair) = order.windows(2).find(|pair| ids[pair[0]] == ids[pair[1]]) {
            return Err(format!("atom id {} comes twice", ids[pair[0]] + 1));
        }
        if self.velocities.is_empty() {
            return Ok(());
        }
        self.velocities.sort_by_key(|(id, ..)| *id);
        if self.velocities.len() != ids.len() {
            return Err(format!("{} velocities for {} atoms", self.velocities.len(), ids.len()));
        }
        let (mut velocities, mut spins) =
            (vec![Vec3::zeros(); ids.len()], vec![Vec3::zeros(); ids.len()]);
        for (row, (id, velocity, spin)) in order.into_iter().zip(&self.velocities) {
            if ids[row] + 1 != *id {
                return Err(format!(
                    "no velocity for atom id {}, or no atom for {id}",
                    ids[row] + 1
                ));
            }
            velocities[row] = *velocity;
            spins[row] = *spin;
        }
        particles.velocities = Some(velocities);
        particles.spins = Some(spins);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "title\r\n\r\n2 atoms\r\n1 atom types\r\n0 1 xlo xhi\r\n0 1 ylo yhi\r\n0 1 zlo zhi\r\n\r\n\
        Atoms # sphere\r\n\r\n2 1 0.2 2500 0.5 0.5 0.5 0 0 0\r\n1 1 0.1 2500 0.2 0.2 0.2\r\n\r\n\
        Velocities\r\n\r\n1 1 2 3 4 5 6\r\n2 0 0 0 0 0 7\r\n";

    fn parse(text: &str) -> Result<Particles, FormatError> {
        read_lines(Lines::new(Path::new("t.data"), text.as_bytes())).map(|(particles, _)| particles)
    }

    #[test]
    fn column_three_is_the_diameter_and_velocities_go_by_id() {
        let particles = parse(FILE).expect("a good file");
        assert_eq!(particles.radii, vec![0.1, 0.05]);
        assert_eq!(particles.ids, Some(vec![1, 0]));
        let spins = particles.spins.expect("there are velocities");
        assert_eq!((spins[0].z, spins[1].z), (7.0, 6.0));
    }

    #[test]
    fn errors_name_the_line_or_what_is_missing() {
        for (from, to, part) in [
            ("2 atoms", "3 atoms", "says 3 atoms, but there are 2"),
            ("1 1 2 3 4 5 6", "1 1 2 3", "line 16: 4 columns; a velocity"),
            ("1 1 2 3 4 5 6", "3 1 2 3 4 5 6", "no velocity for atom id 1"),
            ("2 1 0.2 2500 0.5", "1 1 0.2 2500 0.5", "atom id 1 comes twice"),
            ("0.2 2500", "-0.2 2500", "line 11: radius is -0.1"),
            ("0 1 ylo yhi", "", "lacks a line"),
            ("1 1 0.1 2500", "1 1 2500", "line 12: 6 values in a table of 7 columns"),
        ] {
            let error = parse(&FILE.replace(from, to)).map(|_| ()).expect_err(to).to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn the_box_grows_to_hold_every_sphere() {
        let particles = Particles {
            positions: vec![Vec3::new(0.5, 0.5, 1.0)],
            radii: vec![0.1],
            bounds: Some(Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) }),
            ..Particles::default()
        };
        let domain = domain(&particles);
        assert_eq!((domain.low.z, domain.high.z, domain.high.x), (0.0, 1.1, 1.0));
    }
}
