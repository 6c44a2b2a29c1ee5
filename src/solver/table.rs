//! Tables of bodies in decks, written row by row: however many bodies there are, no table is
//! ever held in memory.
//!
//! A template has a table where a line says `@rows NAME` and what a row looks like, with the
//! columns in braces: `@rows atoms {id} {type} {x} {y} {z}`; `\n` in it begins a new line. Numbers are written with as few
//! digits as give the same double back. Cost O(rows × columns).

use super::SolverError;
use std::io::Write;

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell {
    /// A whole number.
    Count(usize),
    /// Any number; must be finite.
    Number(f64),
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Count(value)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

/// Writes all rows of a table.
type Fill<'a> = Box<dyn Fn(&mut Rows<'_>) -> Result<(), SolverError> + 'a>;

/// A table that a template may have.
pub struct Table<'a> {
    /// Name in the template.
    name: &'static str,
    /// Names of the columns, in the order of the cells of a row.
    columns: &'static [&'static str],
    fill: Fill<'a>,
}

impl<'a> Table<'a> {
    /// A table whose rows `fill` hands over.
    pub fn new(
        name: &'static str,
        columns: &'static [&'static str],
        fill: impl Fn(&mut Rows<'_>) -> Result<(), SolverError> + 'a,
    ) -> Self {
        Self { name, columns, fill: Box::new(fill) }
    }
}

/// Part of a row.
enum Piece {
    Text(String),
    Column(usize),
}

/// Where rows go.
pub struct Rows<'a> {
    out: &'a mut dyn Write,
    pieces: Vec<Piece>,
    table: &'a Table<'a>,
    line: Vec<u8>,
    count: usize,
}

/// Why a row was not written.
fn broken(problem: impl std::fmt::Display) -> SolverError {
    SolverError::Options(format!("a table of a deck cannot be written: {problem}"))
}

impl Rows<'_> {
    /// Writes a row; cells are in the order of the columns of the table.
    pub fn put(&mut self, cells: &[Cell]) -> Result<(), SolverError> {
        self.line.clear();
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => self.line.extend_from_slice(text.as_bytes()),
                Piece::Column(index) => match cells[*index] {
                    Cell::Count(count) => put(&mut self.line, &count)?,
                    Cell::Number(value) if value.is_finite() => put(&mut self.line, &value)?,
                    Cell::Number(value) => {
                        let column = self.table.columns[*index];
                        let what = format!("{}[{}].{column}", self.table.name, self.count);
                        return Err(SolverError::NotFinite { what, value });
                    }
                },
            }
        }
        self.line.push(b'\n');
        self.count += 1;
        self.out.write_all(&self.line).map_err(broken)
    }
}

/// JSON has the shortest digits of a double.
fn put(line: &mut Vec<u8>, value: &impl serde::Serialize) -> Result<(), SolverError> {
    serde_json::to_writer(line, value).map_err(broken)
}

/// Writes a rendered template with its tables.
///
/// # Errors
/// Output that cannot be written, a number that is not finite, a table or column in `text` that
/// there is not.
pub fn write(out: &mut dyn Write, text: &str, tables: &[Table<'_>]) -> Result<(), SolverError> {
    for line in text.split_inclusive('\n') {
        let Some(row) = line.strip_prefix("@rows ").filter(|_| !tables.is_empty()) else {
            out.write_all(line.as_bytes()).map_err(broken)?;
            continue;
        };
        let (name, row) = row.trim_end().split_once(' ').unwrap_or((row.trim_end(), ""));
        let Some(table) = tables.iter().find(|table| table.name == name) else {
            return Err(broken(format!("there is no table `{name}`")));
        };
        let pieces = pieces(row, table)?;
        (table.fill)(&mut Rows { out, pieces, table, line: Vec::new(), count: 0 })?;
    }
    Ok(())
}

/// The text of a row cut at its columns.
fn pieces(row: &str, table: &Table<'_>) -> Result<Vec<Piece>, SolverError> {
    let mut pieces = Vec::new();
    for part in row.split_inclusive('}') {
        let (text, name) = match part.strip_suffix('}').and_then(|part| part.split_once('{')) {
            Some((text, name)) => (text, Some(name)),
            None => (part, None),
        };
        if !text.is_empty() {
            pieces.push(Piece::Text(text.replace("\\n", "\n")));
        }
        if let Some(name) = name {
            let place = table.columns.iter().position(|column| *column == name);
            let unknown = || broken(format!("table `{}` has no column `{name}`", table.name));
            pieces.push(Piece::Column(place.ok_or_else(unknown)?));
        }
    }
    Ok(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str, value: f64) -> Result<String, SolverError> {
        let table = Table::new("a", &["id", "x"], move |rows| {
            rows.put(&[7.into(), value.into()])?;
            rows.put(&[8.into(), 1e-7.into()])
        });
        let mut out = Vec::new();
        write(&mut out, text, &[table])?;
        Ok(String::from_utf8(out).expect("text"))
    }

    #[test]
    fn rows_stand_where_the_template_says() {
        let found = written("# head\n@rows a <{x}>, {id};\nend", 0.1).expect("written");
        assert_eq!(found, "# head\n<0.1>, 7;\n<1e-7>, 8;\nend");
    }

    #[test]
    fn a_row_may_have_several_lines() {
        let found = written("@rows a {id}\\n  {x}\n", 0.5).expect("written");
        assert_eq!(found, "7\n  0.5\n8\n  1e-7\n");
    }

    #[test]
    fn what_is_wrong_is_said() {
        let said = |text: &str, value| written(text, value).expect_err("wrong").to_string();
        assert!(said("@rows b {x}\n", 1.0).contains("no table `b`"));
        assert!(said("@rows a {y}\n", 1.0).contains("no column `y`"));
        assert!(said("@rows a {x}\n", f64::NAN).contains("a[0].x"));
    }
}
