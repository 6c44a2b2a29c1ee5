//! Extended XYZ, as OVITO reads it: a line with the number of spheres, a line
//! of `key=value` pairs (`Properties`, `Lattice`, `Origin`, `Time`, `Step`),
//! then one line a sphere. A file may hold many frames; the last one is read.
//!
//! Property names are those that OVITO maps (`id`, `molecule`, `pos`, `radius`,
//! `velo`, `force`) and, beside them, `material`, `angular_velocity` and
//! `density`. The box is kept as origin and edges, to rounding.

use super::columns::{Field, Rows, real, shown, whole};
use super::error::FormatError;
use super::number::number;
use super::particles::Particles;
use super::text::{Lines, save, write_rows};
use crate::geometry::Bounds;
use crate::num::Vec3;
use std::io::{self, BufRead, Write};
use std::path::Path;

/// Property name, kind (I whole number, R real) and fields; the first name of
/// a field is the one that is written.
const PROPERTIES: [(&str, char, &[Field]); 17] = [
    ("id", 'I', &[Field::Id]),
    ("molecule", 'I', &[Field::Body]),
    ("body", 'I', &[Field::Body]),
    ("material", 'I', &[Field::Material]),
    ("pos", 'R', &[Field::Position(0), Field::Position(1), Field::Position(2)]),
    ("radius", 'R', &[Field::Radius]),
    ("velo", 'R', &VELOCITY),
    ("velocity", 'R', &VELOCITY),
    ("velocities", 'R', &VELOCITY),
    ("vel", 'R', &VELOCITY),
    ("angular_velocity", 'R', &SPIN),
    ("spin", 'R', &SPIN),
    ("omega", 'R', &SPIN),
    ("force", 'R', &FORCE),
    ("forces", 'R', &FORCE),
    ("density", 'R', &[Field::Density]),
    ("rho", 'R', &[Field::Density]),
];
const VELOCITY: [Field; 3] = [Field::Velocity(0), Field::Velocity(1), Field::Velocity(2)];
const SPIN: [Field; 3] = [Field::Spin(0), Field::Spin(1), Field::Spin(2)];
const FORCE: [Field; 3] = [Field::Force(0), Field::Force(1), Field::Force(2)];

/// Writes one frame.
pub fn write(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    save(path, particles, |out| write_to(out, particles))?;
    Ok(Vec::new())
}

fn write_to(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    let fields = Field::present(particles);
    let mut described = Vec::new();
    for field in &fields {
        if let Some((name, kind, members)) =
            PROPERTIES.iter().find(|(_, _, members)| members.contains(field))
            && members[0] == *field
        {
            described.push(format!("{name}:{kind}:{}", members.len()));
        }
    }
    writeln!(out, "{}", particles.len())?;
    write!(out, "Properties={}", described.join(":"))?;
    if let Some(bounds) = particles.bounds {
        let (origin, edges) = (bounds.low, bounds.size());
        let [x, y, z] = [0, 1, 2].map(|axis| number(edges[axis]));
        write!(out, " Lattice=\"{x} 0 0 0 {y} 0 0 0 {z}\"")?;
        let [x, y, z] = [0, 1, 2].map(|axis| number(origin[axis]));
        write!(out, " Origin=\"{x} {y} {z}\" pbc=\"F F F\"")?;
    }
    if let Some(time) = particles.time {
        write!(out, " Time={}", number(time))?;
    }
    if let Some(step) = particles.step {
        write!(out, " Step={step}")?;
    }
    writeln!(out)?;
    write_rows(out, particles, &fields, ' ', 0)
}

/// Reads the last frame; the notes say how many there are and which
/// properties were passed over.
pub fn read(path: &Path) -> Result<(Particles, Vec<String>), FormatError> {
    read_lines(Lines::open(path)?)
}

fn read_lines<R: BufRead>(mut lines: Lines<R>) -> Result<(Particles, Vec<String>), FormatError> {
    let mut line = String::new();
    let mut last = None;
    let mut count = 0;
    while lines.next_filled(&mut line)? {
        last = Some(frame(&mut lines, &mut line)?);
        count += 1;
    }
    let (particles, mut notes) = last.ok_or_else(|| {
        lines.wrong_file("is empty; the first line should hold the number of spheres")
    })?;
    if count > 1 {
        notes.push(format!("{count} frames; the last one was read"));
    }
    Ok((particles, notes))
}

/// Reads the frame whose first line is in `line`.
fn frame<R: BufRead>(
    lines: &mut Lines<R>,
    line: &mut String,
) -> Result<(Particles, Vec<String>), FormatError> {
    let count = whole(line).map_err(|problem| lines.wrong(problem))?;
    lines.need(line, "the line `Properties=…`")?;
    let header = Header::parse(line).map_err(|problem| lines.wrong(problem))?;
    let mut rows = Rows::new(header.fields, 0, |field| {
        PROPERTIES
            .iter()
            .find(|(_, _, members)| members.contains(&field))
            .map_or(String::new(), |(name, ..)| (*name).to_owned())
    })
    .map_err(|problem| lines.wrong(problem))?;
    for done in 0..count {
        lines.need(line, &format!("sphere {} of {count}", done + 1))?;
        rows.add(line.split_whitespace()).map_err(|problem| lines.wrong(problem))?;
    }
    let mut particles = rows.finish();
    particles.bounds = header.bounds;
    particles.time = header.time;
    particles.step = header.step;
    particles.check().map_err(|fault| lines.wrong(fault.to_string()))?;
    Ok((particles, header.notes))
}

#[derive(Default)]
struct Header {
    fields: Vec<Field>,
    notes: Vec<String>,
    bounds: Option<Bounds>,
    time: Option<f64>,
    step: Option<u64>,
}

impl Header {
    fn parse(line: &str) -> Result<Self, String> {
        let mut header = Self::default();
        let (mut lattice, mut origin) = (None, Vec3::zeros());
        let mut described = false;
        for (key, value) in pairs(line) {
            match key.to_ascii_lowercase().as_str() {
                "properties" => {
                    header.properties(value)?;
                    described = true;
                }
                "lattice" => lattice = Some(reals::<9>(value)?),
                "origin" => origin = Vec3::from(reals::<3>(value)?),
                "time" => header.time = Some(real(value)?),
                "step" | "timestep" => header.step = Some(whole(value)?),
                _ => {}
            }
        }
        if !described {
            return Err("a line with `Properties=…:pos:R:3:radius:R:1…` should stand here; plain XYZ has no radii".to_owned());
        }
        if let Some([x, a, b, c, y, d, e, f, z]) = lattice {
            if [a, b, c, d, e, f].iter().any(|v| *v != 0.0) || [x, y, z].iter().any(|v| *v < 0.0) {
                return Err("the lattice is oblique; only boxes along the axes are read".to_owned());
            }
            header.bounds = Some(Bounds { low: origin, high: origin + Vec3::new(x, y, z) });
        }
        Ok(header)
    }

    fn properties(&mut self, text: &str) -> Result<(), String> {
        let parts: Vec<&str> = text.split(':').collect();
        for part in parts.chunks(3) {
            let [name, kind, width] = part else {
                return Err("Properties should be `name:kind:columns` over and over".to_owned());
            };
            let width = whole(width)?;
            // No file has a thousand columns; a larger number is a damaged one.
            if width == 0 || width > 1000 {
                return Err(format!("property `{}` has {width} columns", shown(name)));
            }
            let known = PROPERTIES
                .iter()
                .find(|(known, ..)| known.eq_ignore_ascii_case(name))
                .map(|(_, _, members)| *members)
                .filter(|members| members.len() as u64 == width && *kind != "S");
            match known {
                Some(members) => self.fields.extend(members),
                None => {
                    self.fields.extend((0..width).map(|_| Field::Other));
                    self.notes.push(format!("property `{}` not read", shown(name)));
                }
            }
        }
        Ok(())
    }
}

fn reals<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let values: Vec<f64> = text.split_whitespace().map(real).collect::<Result<_, _>>()?;
    values.try_into().map_err(|_| format!("`{}` should be {N} numbers", shown(text)))
}

/// The pairs `key=value` and `key="value with blanks"` of a line.
fn pairs(line: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    let mut rest = line.trim_start();
    while let Some((key, after)) = rest.split_once('=') {
        // Words without a value before the key are passed over.
        let key = key.split_whitespace().last().unwrap_or_default();
        let (value, tail) = match after.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => after.split_once(char::is_whitespace).unwrap_or((after, "")),
        };
        found.push((key, value));
        rest = tail;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<(Particles, Vec<String>), FormatError> {
        read_lines(Lines::new(Path::new("t.xyz"), text.as_bytes()))
    }

    #[test]
    fn reads_the_last_frame_of_another_program() {
        let text = "1\r\nProperties=species:S:1:pos:R:3:radius:R:1 Time=1\r\nSi 0 0 0 1\r\n\
            1\r\nLattice=\"1 0 0 0 2 0 0 0 3\" Properties=species:S:1:pos:R:3:radius:R:1 Time=2.5\r\nSi 1 2 3 0.5\r\n";
        let (particles, notes) = parse(text).expect("two frames");
        assert_eq!(particles.positions, vec![Vec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(particles.time, Some(2.5));
        assert_eq!(particles.bounds.map(|b| b.high), Some(Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!(notes, vec!["property `species` not read", "2 frames; the last one was read"]);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, part) in [
            ("two\n", "t.xyz: line 1: `two`"),
            ("1\ncomment\nAr 0 0 0\n", "line 2: a line with `Properties"),
            ("1\nProperties=pos:R:3\n0 0 0\n", "line 2: missing column radius"),
            (
                "2\nProperties=pos:R:3:radius:R:1\n0 0 0 1\n",
                "line 4: the file ends here, but sphere 2 of 2",
            ),
            (
                "1\nProperties=pos:R:3:radius:R:1:f:R:99999999\n",
                "line 2: property `f` has 99999999 columns",
            ),
            (
                "1\nProperties=pos:R:3:radius:R:1 Lattice=\"1 1 0 0 1 0 0 0 1\"\n0 0 0 1\n",
                "line 2: the lattice is oblique",
            ),
        ] {
            let error = parse(text).map(|_| ()).expect_err(text).to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
