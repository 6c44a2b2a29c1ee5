//! What a study found: tables with all digits as CSV, charts as SVG, pictures as
//! PNG, everything as JSON, and one self-contained page.

use super::chart::Chart;
use super::figure::Figure;
use super::picture::Picture;
use super::table::Table;
use super::{ReportError, number, write_whole};
use crate::format::FormatError;
use serde::Serialize;
use std::path::{Path, PathBuf};
use tera::{Context, Tera};

/// Pictures up to which they stand among the charts.
const FEW: usize = 12;

/// What a study found.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Heading.
    pub title: String,
    /// What was asked, in a few sentences, with sources.
    pub question: String,
    /// What was found, one sentence each, the most important first.
    pub remarks: Vec<String>,
    /// Tables.
    pub tables: Vec<Sheet>,
    /// Charts with the names of their files, without extension.
    pub charts: Vec<(String, Chart)>,
    /// Pictures with the names of their files, their titles and captions.
    pub pictures: Vec<(String, String, String, Picture)>,
}

/// A table of numbers and texts.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Sheet {
    /// File name without extension: letters, digits and `-`.
    pub key: String,
    /// Heading.
    pub title: String,
    /// What the columns mean.
    pub caption: String,
    /// Heads of the columns, units included: `step [s]`.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
}

/// One cell of a [`Sheet`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// A number; one that is not finite is an empty cell.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// A text.
    Text(String),
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        Self::Count(value)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl Cell {
    /// With all digits, for CSV.
    fn exact(&self) -> String {
        match self {
            Self::Number(value) if value.is_finite() => format!("{value:?}"),
            Self::Number(_) => String::new(),
            Self::Count(value) => value.to_string(),
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => text.clone(),
        }
    }

    /// With the digits that people read.
    fn short(&self) -> String {
        match self {
            Self::Number(value) => number::significant(*value, 4),
            Self::Count(value) => number::count(*value),
            Self::Text(text) => text.clone(),
        }
    }
}

impl Sheet {
    fn csv(&self) -> String {
        let head = self.columns.iter().map(|name| Cell::from(name.as_str()).exact());
        let mut text = head.collect::<Vec<_>>().join(",");
        text.push('\n');
        for row in &self.rows {
            text.push_str(&row.iter().map(Cell::exact).collect::<Vec<_>>().join(","));
            text.push('\n');
        }
        text
    }

    fn table(&self) -> Table {
        Table {
            columns: self.columns.clone(),
            rows: self.rows.iter().map(|row| row.iter().map(Cell::short).collect()).collect(),
        }
    }
}

/// Table of the page with its heading.
#[derive(Serialize)]
struct Entry<'a> {
    key: &'a str,
    title: &'a str,
    caption: &'a str,
    table: Table,
}

impl Findings {
    /// Writes `KEY.csv` a table, `NAME.svg` a chart, `NAME.png` a picture,
    /// `study.json` and `index.html` into `folder`, which is made if needed;
    /// `command` is what reproduces them. Returns the files.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write(&self, folder: &Path, command: &str) -> Result<Vec<PathBuf>, ReportError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| FormatError::io(folder, "write", source))?;
        let mut files = Vec::new();
        let mut put = |name: String, bytes: &[u8]| -> Result<(), ReportError> {
            let path = folder.join(name);
            write_whole(&path, bytes)?;
            files.push(path);
            Ok(())
        };
        for sheet in &self.tables {
            put(format!("{}.csv", sheet.key), sheet.csv().as_bytes())?;
        }
        for (name, chart) in &self.charts {
            if let Some(svg) = chart.svg() {
                put(format!("{name}.svg"), svg.as_bytes())?;
            }
        }
        for (name, _, _, picture) in &self.pictures {
            put(format!("{name}.png"), &picture.png()?)?;
        }
        put("study.json".into(), &serde_json::to_vec_pretty(&self.json())?)?;
        put("index.html".into(), self.page(command)?.as_bytes())?;
        Ok(files)
    }

    /// Title, remarks and tables as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "title": self.title, "question": self.question, "remarks": self.remarks,
            "tables": self.tables,
        })
    }

    /// Remarks and tables for a terminal.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", self.title);
        for sheet in &self.tables {
            let table = sheet.table();
            text.push_str(&format!("\n{}\n{}", sheet.title, aligned(&table)));
        }
        text.push('\n');
        for remark in &self.remarks {
            text.push_str(&format!("{remark}\n"));
        }
        text
    }

    fn page(&self, command: &str) -> Result<String, ReportError> {
        let mut figures: Vec<Figure> =
            self.charts.iter().filter_map(|(_, chart)| Figure::chart(chart)).collect();
        let pictures = self
            .pictures
            .iter()
            .map(|(_, title, caption, picture)| Figure::picture(picture, title, caption))
            .collect::<Result<Vec<_>, _>>()?;
        // Many pictures are small and stand apart.
        let gallery = if pictures.len() > FEW {
            pictures
        } else {
            figures.extend(pictures);
            Vec::new()
        };
        let tables: Vec<Entry> = self
            .tables
            .iter()
            .map(|sheet| Entry {
                key: &sheet.key,
                title: &sheet.title,
                caption: &sheet.caption,
                table: sheet.table(),
            })
            .collect();
        let mut context = Context::new();
        context.insert("title", &self.title);
        context.insert("version", &format!("riprap {}", crate::VERSION));
        context.insert("question", &self.question);
        context.insert("remarks", &self.remarks);
        context.insert("figures", &figures);
        context.insert("gallery", &gallery);
        context.insert("tables", &tables);
        context.insert("command", command);
        let mut tera = Tera::default();
        tera.add_raw_templates(super::page::SHARED)?;
        tera.add_raw_template("study.html", include_str!("../../templates/report/study.html"))?;
        Ok(tera.render("study.html", &context)?)
    }
}

/// Columns under their heads, two spaces between.
fn aligned(table: &Table) -> String {
    let mut widths: Vec<usize> = table.columns.iter().map(|head| head.chars().count()).collect();
    for row in &table.rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    for row in std::iter::once(&table.columns).chain(&table.rows) {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::chart::tests::assert_balanced;
    use crate::report::chart::{Axis, Series};

    #[test]
    fn findings_become_files_that_hold_all_digits() {
        let chart = Chart {
            title: "error <of> it".into(),
            caption: String::new(),
            x: Axis::log("time", "s"),
            y: Axis::log("error", ""),
            series: vec![Series {
                name: "a".into(),
                points: vec![(1.0, 0.1), (10.0, 0.01)],
                dots: true,
            }],
            mark: None,
        };
        let found = Findings {
            title: "A study".into(),
            question: "How far?".into(),
            remarks: vec!["Not far.".into()],
            tables: vec![Sheet {
                key: "errors".into(),
                title: "Errors".into(),
                caption: String::new(),
                columns: vec!["method".into(), "error, relative".into(), "steps".into()],
                rows: vec![vec!["a, b".into(), (1.0 / 3.0).into(), 7_u64.into()]],
            }],
            charts: vec![("errors".into(), chart)],
            pictures: Vec::new(),
        };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let target = folder.path().join("new/study");
        let files = found.write(&target, "riprap study contact").expect("writable");
        assert_eq!(files.len(), 4);
        let csv = std::fs::read_to_string(target.join("errors.csv")).expect("written");
        assert_eq!(csv, "method,\"error, relative\",steps\n\"a, b\",0.3333333333333333,7\n");
        let html = std::fs::read_to_string(target.join("index.html")).expect("written");
        assert_balanced(&html);
        assert!(html.contains("error &lt;of&gt; it") && html.contains("0.3333"));
        assert!(found.text().contains("0.3333"));
    }
}
