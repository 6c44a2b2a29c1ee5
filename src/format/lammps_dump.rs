//! Text dumps (`dump custom`): the common tongue of LIGGGHTS, LAMMPS and OVITO.
//!
//! Column names as all three know them: `id mol type x y z radius vx vy vz
//! omegax omegay omegaz fx fy fz density`. Ids, molecules and types count from
//! 1 in the file and from 0 in the table; molecule 0 ("none") becomes a body of
//! its own. The box must be orthogonal. A file may hold many frames.

use super::columns::{Field, Rows, real, shown, whole};
use super::error::FormatError;
use super::number::number;
use super::particles::Particles;
use super::text::{Lines, save, write_rows};
use crate::geometry::Bounds;
use crate::num::Vec3;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;

/// What a column means.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    /// As it stands.
    Plain(Field),
    /// A coordinate as a fraction of the box.
    Scaled(usize),
}

/// Column names; the first name of a field is the one that is written.
const NAMES: [(&str, Field); 24] = [
    ("id", Field::Id),
    ("mol", Field::Body),
    ("id_multisphere", Field::Body),
    ("body", Field::Body),
    ("type", Field::Material),
    ("x", Field::Position(0)),
    ("y", Field::Position(1)),
    ("z", Field::Position(2)),
    ("xu", Field::Position(0)),
    ("yu", Field::Position(1)),
    ("zu", Field::Position(2)),
    ("radius", Field::Radius),
    ("diameter", Field::Diameter),
    ("vx", Field::Velocity(0)),
    ("vy", Field::Velocity(1)),
    ("vz", Field::Velocity(2)),
    ("omegax", Field::Spin(0)),
    ("omegay", Field::Spin(1)),
    ("omegaz", Field::Spin(2)),
    ("fx", Field::Force(0)),
    ("fy", Field::Force(1)),
    ("fz", Field::Force(2)),
    ("density", Field::Density),
    ("rho", Field::Density),
];

fn name(field: Field) -> &'static str {
    NAMES.iter().find(|(_, known)| *known == field).map_or("", |(name, _)| name)
}

fn meaning_of(text: &str) -> Meaning {
    match text {
        "xs" | "xsu" => Meaning::Scaled(0),
        "ys" | "ysu" => Meaning::Scaled(1),
        "zs" | "zsu" => Meaning::Scaled(2),
        _ => Meaning::Plain(
            NAMES.iter().find(|(name, _)| *name == text).map_or(Field::Other, |(_, field)| *field),
        ),
    }
}

/// Writes one frame.
pub fn write(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    save(path, particles, |out| write_frame(out, particles))?;
    let mut notes = Vec::new();
    if particles.bounds.is_none() {
        notes.push("no box known: written as the smallest one around the spheres".to_owned());
    }
    if particles.step.is_none() {
        notes.push("no step number known: written as 0".to_owned());
    }
    Ok(notes)
}

/// Puts one frame at the end of `out`, for files of many frames. The caller has
/// checked `particles` ([`Particles::check`]). Time is written where it is known.
pub fn write_frame(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    if let Some(time) = particles.time {
        writeln!(out, "ITEM: TIME\n{}", number(time))?;
    }
    writeln!(out, "ITEM: TIMESTEP\n{}", particles.step.unwrap_or(0))?;
    writeln!(out, "ITEM: NUMBER OF ATOMS\n{}", particles.len())?;
    writeln!(out, "ITEM: BOX BOUNDS ff ff ff")?;
    let bounds = particles.extent();
    for axis in 0..3 {
        writeln!(out, "{} {}", number(bounds.low[axis]), number(bounds.high[axis]))?;
    }
    let mut fields = Field::present(particles);
    if particles.ids.is_none() {
        fields.insert(0, Field::Id);
    }
    let names: Vec<&str> = fields.iter().map(|field| name(*field)).collect();
    writeln!(out, "ITEM: ATOMS {}", names.join(" "))?;
    write_rows(out, particles, &fields, ' ', 1)
}

/// Reads the last frame; the notes say how many there are and which columns
/// were passed over.
pub fn read(path: &Path) -> Result<(Particles, Vec<String>), FormatError> {
    let mut frames = frames(path)?;
    let mut last = None;
    let mut count = 0;
    for frame in &mut frames {
        last = Some(frame?);
        count += 1;
    }
    let particles =
        last.ok_or_else(|| FormatError::file(path, "holds no frame (`ITEM: TIMESTEP`)"))?;
    let mut notes = frames.passed_over();
    if count > 1 {
        notes.push(format!("{count} frames; the last one was read"));
    }
    Ok((particles, notes))
}

/// Opens a dump to read it frame by frame.
pub fn frames(path: &Path) -> Result<Frames<BufReader<File>>, FormatError> {
    Ok(Frames::new(Lines::open(path)?))
}

/// The frames of a dump, one after the other; ends after the first error.
pub struct Frames<R> {
    lines: Lines<R>,
    buffer: String,
    ended: bool,
    passed: Vec<String>,
}

impl<R: BufRead> Frames<R> {
    fn new(lines: Lines<R>) -> Self {
        Self { lines, buffer: String::new(), ended: false, passed: Vec::new() }
    }

    /// One sentence for each column of the latest frame that was not read.
    pub fn passed_over(&self) -> Vec<String> {
        self.passed.iter().map(|name| format!("column `{name}` not read")).collect()
    }

    fn frame(&mut self) -> Result<Option<Particles>, FormatError> {
        let mut header = Header::default();
        if !self.lines.next_filled(&mut self.buffer)? {
            return Ok(None);
        }
        loop {
            let Some(item) = self.buffer.strip_prefix("ITEM:").map(|item| item.trim().to_owned())
            else {
                return Err(self.lines.wrong(format!(
                    "a line `ITEM: …` should stand here, not `{}`",
                    shown(&self.buffer)
                )));
            };
            if let Some(names) = item.strip_prefix("ATOMS") {
                return self.atoms(names, header).map(Some);
            }
            self.section(&item, &mut header)?;
            if !self.lines.next_filled(&mut self.buffer)? {
                return Err(self
                    .lines
                    .wrong("the file ends in the middle of a frame, before `ITEM: ATOMS`"));
            }
        }
    }

    fn section(&mut self, item: &str, header: &mut Header) -> Result<(), FormatError> {
        let Self { lines, buffer, .. } = self;
        if let Some(rest) = item.strip_prefix("BOX BOUNDS") {
            if rest.split_whitespace().any(|word| ["xy", "xz", "yz", "abc"].contains(&word)) {
                return Err(lines.wrong("the box is oblique; only boxes along the axes are read"));
            }
            return header.read_box(lines, buffer);
        }
        match item {
            "TIMESTEP" => {
                lines.need(buffer, "the step number")?;
                header.step = Some(whole(buffer).map_err(|problem| lines.wrong(problem))?);
            }
            "TIME" => {
                lines.need(buffer, "the time")?;
                header.time = Some(real(buffer).map_err(|problem| lines.wrong(problem))?);
            }
            "NUMBER OF ATOMS" => {
                lines.need(buffer, "the number of atoms")?;
                header.count = Some(whole(buffer).map_err(|problem| lines.wrong(problem))?);
            }
            "UNITS" => {
                lines.need(buffer, "the name of the units")?;
                if buffer != "si" && buffer != "lj" {
                    return Err(lines.wrong(format!(
                        "units `{}` are not read; only `si` (and `lj`, taken as they stand)",
                        shown(buffer)
                    )));
                }
            }
            _ => {
                return Err(lines.wrong(format!("`ITEM: {}` is not known here", shown(item))));
            }
        }
        Ok(())
    }

    fn atoms(&mut self, names: &str, header: Header) -> Result<Particles, FormatError> {
        let Self { lines, buffer, passed, .. } = self;
        let count = header
            .count
            .ok_or_else(|| lines.wrong("`ITEM: NUMBER OF ATOMS` should stand before the atoms"))?;
        let mut columns: Vec<Meaning> = names.split_whitespace().map(meaning_of).collect();
        // The examples of LIGGGHTS dump `id type type x y z …`: the first one counts.
        for place in 1..columns.len() {
            if columns[..place].contains(&columns[place]) {
                columns[place] = Meaning::Plain(Field::Other);
            }
        }
        *passed = names
            .split_whitespace()
            .zip(&columns)
            .filter(|(_, column)| **column == Meaning::Plain(Field::Other))
            .map(|(name, _)| shown(name))
            .collect();
        let fields = columns
            .iter()
            .map(|column| match column {
                Meaning::Plain(field) => *field,
                Meaning::Scaled(axis) => Field::Position(*axis),
            })
            .collect();
        let mut rows = Rows::new(fields, 1, |field| name(field).to_owned())
            .map_err(|problem| lines.wrong(problem))?;
        for done in 0..count {
            lines.need(buffer, &format!("atom {} of {count}", done + 1))?;
            rows.add(buffer.split_whitespace()).map_err(|problem| lines.wrong(problem))?;
        }
        let mut particles = rows.finish();
        for axis in 0..3 {
            if columns.contains(&Meaning::Scaled(axis)) {
                let bounds = header.bounds.ok_or_else(|| {
                    lines.wrong("coordinates as fractions of the box need `ITEM: BOX BOUNDS`")
                })?;
                for position in &mut particles.positions {
                    position[axis] = bounds.low[axis] + position[axis] * bounds.size()[axis];
                }
            }
        }
        particles.step = header.step;
        particles.time = header.time;
        particles.bounds = header.bounds;
        particles.check().map_err(|fault| lines.wrong(fault.to_string()))?;
        Ok(particles)
    }
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<Particles, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let frame = self.frame().transpose();
        self.ended = !matches!(frame, Some(Ok(_)));
        frame
    }
}

#[derive(Default)]
struct Header {
    step: Option<u64>,
    time: Option<f64>,
    count: Option<u64>,
    bounds: Option<Bounds>,
}

impl Header {
    fn read_box<R: BufRead>(
        &mut self,
        lines: &mut Lines<R>,
        buffer: &mut String,
    ) -> Result<(), FormatError> {
        let mut bounds = Bounds { low: Vec3::zeros(), high: Vec3::zeros() };
        for axis in 0..3 {
            lines.need(buffer, "the box")?;
            let ends: Vec<f64> = buffer
                .split_whitespace()
                .map(real)
                .collect::<Result<_, _>>()
                .map_err(|problem| lines.wrong(problem))?;
            match ends[..] {
                [low, high] if low <= high => {
                    bounds.low[axis] = low;
                    bounds.high[axis] = high;
                }
                _ => return Err(lines.wrong("should hold the lower and the upper end of the box")),
            }
        }
        self.bounds = Some(bounds);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: &str = "ITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n\
        0 1\n0 2\n-1 4\nITEM: ATOMS id type type xs ys zs radius c_q[1] id_multisphere\n\
        2 1 1 0.5 0.5 0.5 0.1 9 -2\n";

    fn parse(text: &str) -> Vec<Result<Particles, FormatError>> {
        Frames::new(Lines::new(Path::new("t.dump"), text.as_bytes())).collect()
    }

    fn error(text: &str) -> String {
        let last = parse(text).pop().expect("something comes back");
        last.map(|_| ()).expect_err("it is wrong").to_string()
    }

    #[test]
    fn frames_come_one_after_the_other() {
        let particles = Particles {
            positions: vec![Vec3::new(0.25, 1.0, 0.0)],
            radii: vec![0.1],
            ..Particles::default()
        };
        let mut bytes = Vec::new();
        for step in [5, 6] {
            let frame = Particles { step: Some(step), time: Some(0.5), ..particles.clone() };
            write_frame(&mut bytes, &frame).expect("memory takes all");
        }
        let text = String::from_utf8(bytes).expect("text");
        let steps: Vec<_> = parse(&text).into_iter().map(|f| f.expect("a frame").step).collect();
        assert_eq!(steps, vec![Some(5), Some(6)]);
    }

    #[test]
    fn fractions_become_metres() {
        let text = "ITEM: TIMESTEP\r\n10\r\nITEM: NUMBER OF ATOMS\r\n1\r\nITEM: BOX BOUNDS pp pp ff\r\n\
            0 1\r\n0 2\r\n-1 4\r\nITEM: ATOMS id type xs ys zs radius c_q[1] mol\r\n\
            2 1 0.5 0.5 0.5 0.1 9 0\r\n";
        let frame = parse(text).pop().expect("one frame").expect("a good one");
        assert_eq!(frame.positions, vec![Vec3::new(0.5, 1.0, 1.5)]);
        assert_eq!(
            (frame.ids, frame.materials, frame.bodies),
            (Some(vec![1]), Some(vec![0]), Some(vec![0]))
        );
    }

    #[test]
    fn errors_name_the_line() {
        assert!(error(FRAME).contains("t.dump: line 10: `-2` is not a whole number"));
        let short = FRAME.replace("9 -2", "9 -1");
        assert!(error(&short).contains("line 11: the file ends here, but atom 2 of 2"));
        assert!(error(&FRAME.replace("radius", "q")).contains("line 9: missing column radius"));
        assert!(
            error(&FRAME.replace("pp pp ff", "xy xz yz pp pp ff"))
                .contains("line 5: the box is oblique")
        );
        assert!(error("hello").contains("line 1: a line `ITEM: …`"));
        assert!(error(&FRAME.replace("0 2\n", "0\n")).contains("line 7: should hold the lower"));
    }
}
