//! Sphere tables of YADE: blank-separated `x y z r`, with a last column where
//! needed, as `ymport.textExt` (`#format x_y_z_r`, `x_y_z_r_matId`) and
//! `ymport.textClumps` (`x_y_z_r_clumpId`, clump by clump) read them.
//!
//! YADE's own exporters print 6 digits; this one prints 17. There are no blank
//! lines in what is written, since YADE stops at them.

use super::columns::{Field, Rows, shown};
use super::error::FormatError;
use super::particles::Particles;
use super::text::{Lines, save, write_rows};
use std::io::{BufRead, Write};
use std::path::Path;

const PLAIN: &str = "x_y_z_r";
const MATERIALS: &str = "x_y_z_r_matId";
const CLUMPS: &str = "x_y_z_r_clumpId";
const NUMBERED: &str = "id_x_y_z_r_matId";

const PLACE: [Field; 4] =
    [Field::Position(0), Field::Position(1), Field::Position(2), Field::Radius];

fn columns(format: &str) -> Option<Vec<Field>> {
    let tail = |last: &[Field]| PLACE.iter().chain(last).copied().collect();
    match format {
        PLAIN => Some(tail(&[])),
        MATERIALS => Some(tail(&[Field::Material])),
        CLUMPS => Some(tail(&[Field::Body])),
        NUMBERED => Some([Field::Id].into_iter().chain(PLACE).chain([Field::Material]).collect()),
        _ => None,
    }
}

/// Writes clump numbers where some body has more than one sphere, else
/// materials where they are known; the notes name what found no place.
pub fn write(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    let materials = particles.materials.is_some();
    let mut notes = Vec::new();
    let format = match (particles.has_clumps(), particles.ids.is_some(), materials) {
        (true, ids, _) => {
            if materials {
                notes
                    .push("materials not written: a clump table has no column for them".to_owned());
            }
            if ids {
                notes.push("ids not written: a clump table has no column for them".to_owned());
            }
            if !is_in_blocks(particles.bodies.as_deref().unwrap_or_default()) {
                return Err(FormatError::unwritable(
                    path,
                    "the spheres of a clump must follow one another; sort them by body first",
                ));
            }
            CLUMPS
        }
        (false, true, true) => NUMBERED,
        (false, false, true) => MATERIALS,
        (false, ids, false) => {
            if ids {
                notes.push("ids not written: YADE reads them with materials only".to_owned());
            }
            PLAIN
        }
    };
    if !particles.has_clumps() && particles.bodies.is_some() {
        notes.push("body numbers not written: every body is one sphere".to_owned());
    }
    let fields = columns(format).unwrap_or_else(|| PLACE.to_vec());
    save(path, particles, |out: &mut dyn Write| {
        writeln!(out, "#format {format}")?;
        write_rows(out, particles, &fields, ' ', 0)
    })?;
    Ok(notes)
}

/// True if equal numbers stand together.
fn is_in_blocks(bodies: &[u64]) -> bool {
    let mut starts: Vec<u64> =
        bodies.chunk_by(|a, b| a == b).filter_map(|block| block.first().copied()).collect();
    starts.sort_unstable();
    starts.windows(2).all(|pair| pair[0] != pair[1])
}

/// Reads a table. Without a `#format` line, four columns are x, y, z, r; five
/// are refused, since the last could be a material or a clump.
pub fn read(path: &Path) -> Result<(Particles, Vec<String>), FormatError> {
    read_lines(Lines::open(path)?)
}

fn read_lines<R: BufRead>(mut lines: Lines<R>) -> Result<(Particles, Vec<String>), FormatError> {
    let mut line = String::new();
    let mut fields = None;
    let mut rows: Option<Rows> = None;
    while lines.next_filled(&mut line)? {
        if let Some(comment) = line.strip_prefix('#') {
            if let Some(format) = comment.strip_prefix("format") {
                let known = columns(format.trim()).ok_or_else(|| {
                    lines.wrong(format!(
                        "`{}` is not a format known here; known: {PLAIN}, {MATERIALS}, {CLUMPS}, {NUMBERED}",
                        shown(format.trim())
                    ))
                })?;
                if rows.is_some() {
                    return Err(lines.wrong("the #format line must stand before the first sphere"));
                }
                fields = Some(known);
            }
            continue;
        }
        if rows.is_none() {
            let chosen = match (&fields, line.split_whitespace().count()) {
                (Some(known), _) => known.clone(),
                (None, 5) => {
                    return Err(lines.wrong(format!(
                        "five columns need a first line `#format {MATERIALS}` or `#format {CLUMPS}`"
                    )));
                }
                (None, _) => PLACE.to_vec(),
            };
            rows = Some(start(chosen, &lines)?);
        }
        if let Some(rows) = &mut rows {
            rows.add(line.split_whitespace()).map_err(|problem| lines.wrong(problem))?;
        }
    }
    match (rows, fields) {
        (Some(rows), _) => Ok((rows.finish(), Vec::new())),
        (None, Some(known)) => Ok((start(known, &lines)?.finish(), Vec::new())),
        (None, None) => Err(lines.wrong_file("holds no sphere and no `#format` line")),
    }
}

fn start<R: BufRead>(fields: Vec<Field>, lines: &Lines<R>) -> Result<Rows, FormatError> {
    Rows::new(fields, 0, |field| format!("{field:?}")).map_err(|problem| lines.wrong(problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;

    fn parse(text: &str) -> Result<Particles, FormatError> {
        read_lines(Lines::new(Path::new("t.txt"), text.as_bytes())).map(|(particles, _)| particles)
    }

    #[test]
    fn format_line_names_the_last_column() {
        let clumps = parse("#format x_y_z_r_clumpId\r\n0 0 0 1 4\r\n\r\n1 0 0 1 4\r\n");
        assert_eq!(clumps.expect("a clump").bodies, Some(vec![4, 4]));
        let materials = parse("# by hand\n#format x_y_z_r_matId\n0 0 0 1 2\n").expect("a sphere");
        assert_eq!(materials.materials, Some(vec![2]));
        assert_eq!(parse("1 2 3 4").expect("a sphere").positions, vec![Vec3::new(1.0, 2.0, 3.0)]);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, part) in [
            ("0 0 0 1 4\n", "t.txt: line 1: five columns need"),
            ("#format x_y\n", "line 1: `x_y` is not a format"),
            ("0 0 0 1\n\n0 0 0\n", "line 3: 3 values"),
            ("0 0 0 1\n#format x_y_z_r\n", "line 2: the #format line"),
            ("", "no sphere"),
        ] {
            let error = parse(text).map(|_| ()).expect_err(text).to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn scattered_clumps_are_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let particles = Particles {
            positions: vec![Vec3::zeros(); 3],
            radii: vec![1.0; 3],
            bodies: Some(vec![0, 1, 0]),
            ..Particles::default()
        };
        let error = write(&folder.path().join("a.txt"), &particles).expect_err("not in blocks");
        assert!(error.to_string().contains("sort them by body"), "{error}");
    }
}
