//! Comma-separated tables with a header row: our own `run/final.csv`
//! (`id,body,material,x,y,z,r,vx,vy,vz,wx,wy,wz,fx,fy,fz`, ids from 0) and the
//! spheres of a clump (`x,y,z,r`).
//!
//! The header says which columns are there, in any order; columns with other
//! names are passed over. Read as well: `;` or tabs between columns, cells in
//! double quotes, comment lines that begin with `#`, `radius`, `diameter`,
//! and a table of four columns without a header, taken as x, y, z, r.

use super::columns::{Field, Rows, real, shown};
use super::error::FormatError;
use super::particles::Particles;
use super::text::{Lines, save, write_rows};
use std::io::{self, BufRead, Write};
use std::path::Path;

/// Column names; the first name of a field is the one that is written.
const NAMES: [(&str, Field); 19] = [
    ("id", Field::Id),
    ("body", Field::Body),
    ("material", Field::Material),
    ("x", Field::Position(0)),
    ("y", Field::Position(1)),
    ("z", Field::Position(2)),
    ("r", Field::Radius),
    ("radius", Field::Radius),
    ("diameter", Field::Diameter),
    ("density", Field::Density),
    ("vx", Field::Velocity(0)),
    ("vy", Field::Velocity(1)),
    ("vz", Field::Velocity(2)),
    ("wx", Field::Spin(0)),
    ("wy", Field::Spin(1)),
    ("wz", Field::Spin(2)),
    ("fx", Field::Force(0)),
    ("fy", Field::Force(1)),
    ("fz", Field::Force(2)),
];

fn name(field: Field) -> &'static str {
    NAMES.iter().find(|(_, known)| *known == field).map_or("", |(name, _)| name)
}

/// Writes the columns that `particles` has; time, step and box have no place.
pub fn write(path: &Path, particles: &Particles) -> Result<Vec<String>, FormatError> {
    save(path, particles, |out| write_to(out, particles))?;
    Ok(Vec::new())
}

fn write_to(out: &mut dyn Write, particles: &Particles) -> io::Result<()> {
    let fields = Field::present(particles);
    let header: Vec<&str> = fields.iter().map(|field| name(*field)).collect();
    writeln!(out, "{}", header.join(","))?;
    write_rows(out, particles, &fields, ',', 0)
}

/// Reads a table; the notes name the columns that were passed over.
pub fn read(path: &Path) -> Result<(Particles, Vec<String>), FormatError> {
    read_lines(Lines::open(path)?)
}

fn read_lines<R: BufRead>(mut lines: Lines<R>) -> Result<(Particles, Vec<String>), FormatError> {
    let mut line = String::new();
    if !next_row(&mut lines, &mut line)? {
        return Err(
            lines.wrong_file("is empty; a first line such as `x,y,z,r` should name the columns")
        );
    }
    let separator = [',', ';', '\t'].into_iter().find(|c| line.contains(*c)).unwrap_or(',');
    let header: Vec<String> = cells(&line, separator).map(str::to_lowercase).collect();
    let bare = header.iter().all(|cell| real(cell).is_ok());
    let fields = match (bare, header.len()) {
        (true, 4) => [("x", 0), ("y", 1), ("z", 2)]
            .into_iter()
            .map(|(_, axis)| Field::Position(axis))
            .chain([Field::Radius])
            .collect(),
        (true, _) => {
            return Err(lines.wrong("the first line should name the columns, such as `x,y,z,r`"));
        }
        (false, _) => header.iter().map(|cell| field_named(cell)).collect::<Vec<_>>(),
    };
    let notes = header
        .iter()
        .zip(&fields)
        .filter(|(_, field)| **field == Field::Other)
        .map(|(cell, _)| format!("column `{}` not read", shown(cell)))
        .collect();
    let mut rows = Rows::new(fields, 0, |field| name(field).to_owned())
        .map_err(|problem| lines.wrong(problem))?;
    if bare {
        rows.add(cells(&line, separator)).map_err(|problem| lines.wrong(problem))?;
    }
    while next_row(&mut lines, &mut line)? {
        rows.add(cells(&line, separator)).map_err(|problem| lines.wrong(problem))?;
    }
    Ok((rows.finish(), notes))
}

fn field_named(cell: &str) -> Field {
    // A unit in brackets behind the name, "x [m]", is no part of it.
    let cell = cell.split('[').next().unwrap_or(cell).trim();
    NAMES.iter().find(|(name, _)| *name == cell).map_or(Field::Other, |(_, field)| *field)
}

fn next_row<R: BufRead>(lines: &mut Lines<R>, line: &mut String) -> Result<bool, FormatError> {
    while lines.next_filled(line)? {
        if !line.starts_with('#') {
            return Ok(true);
        }
    }
    Ok(false)
}

fn cells(line: &str, separator: char) -> impl Iterator<Item = &str> {
    line.split(separator).map(|cell| cell.trim().trim_matches('"').trim())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;

    fn parse(text: &str) -> Result<(Particles, Vec<String>), FormatError> {
        read_lines(Lines::new(Path::new("t.csv"), text.as_bytes()))
    }

    #[test]
    fn the_header_decides_and_crlf_blank_lines_and_quotes_do_not_matter() {
        let text = "\u{feff}# by hand\r\n\"Radius\"; z ;y;x;colour\r\n\r\n0.5;3;2;1;red\r\n\r\n";
        let (particles, notes) = parse(text).expect("a good table");
        assert_eq!(particles.positions, vec![Vec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(particles.radii, vec![0.5]);
        assert_eq!(notes, vec!["column `colour` not read"]);
    }

    #[test]
    fn four_bare_columns_are_a_clump() {
        let (particles, _) = parse("1,2,3,0.5\n4,5,6,0.25").expect("two spheres");
        assert_eq!(particles.radii, vec![0.5, 0.25]);
    }

    #[test]
    fn units_behind_names_are_no_part_of_them() {
        let (particles, notes) = parse("x [m],y [m],z [m],r [m]\n1,2,3,0.5").expect("a clump");
        assert_eq!((particles.radii, notes), (vec![0.5], Vec::<String>::new()));
    }

    #[test]
    fn errors_name_the_line() {
        for (text, part) in [
            ("x,y,z,r\n0,0,0,1\n\n0,0,zero,1\n", "t.csv: line 4: `zero` is not a number"),
            ("x,y,r\n", "t.csv: line 1: missing column z"),
            ("x,y,z\n", "missing column r"),
            ("x,y,z,r,radius\n", "line 1: column `r` comes twice"),
            ("1,2,3\n", "t.csv: line 1: the first line should name"),
            ("x,y,z,r\n1,2,3\n", "line 2: 3 values in a table of 4 columns"),
            ("", "is empty"),
        ] {
            let error = parse(text).map(|_| ()).expect_err(text).to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
