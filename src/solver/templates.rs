//! The templates of all decks, embedded in the program and compiled once.
//!
//! A misspelt name in `{% if … %}` is silently false in tera, so physics
//! switches come from one struct, [`crate::model::Needs`], and a test holds
//! every `needs.NAME` of every template against its fields. Floating-point
//! numbers print as the shortest text that reads back to the same double.

use super::SolverError;
use serde::Serialize;
use std::sync::LazyLock;
use tera::{Context, Tera};

macro_rules! templates {
    ($($name:literal),* $(,)?) => {
        /// Every template: its name and its text.
        pub const ALL: &[(&str, &str)] = &[
            $(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/templates/", $name)))),*
        ];
    };
}

templates![
    "header.txt",
    "job.slurm",
    "lammps/arrivals.in",
    "lammps/in.lammps",
    "lammps/rigid.inf",
    "lammps/run.sh",
    "lammps/spheres.data",
    "left_out.txt",
    "liggghts/arrivals.in",
    "liggghts/clumps.in",
    "liggghts/in.liggghts",
    "liggghts/placed.in",
    "liggghts/rigid.inf",
    "liggghts/run.sh",
    "liggghts/spheres.data",
    "liggghts/wall.stl",
    "springs.csv",
    "springs.py",
    "yade/arrivals.csv",
    "yade/bonds.csv",
    "yade/clumps.csv",
    "yade/members.csv",
    "yade/run.py",
    "yade/run.sh",
    "yade/spheres.csv",
    "yade/springs.csv",
    "yade/wall.txt",
];

/// A fault in a template is kept as text and comes back from every rendering.
static TERA: LazyLock<Result<Tera, String>> = LazyLock::new(|| {
    let mut tera = Tera::default();
    tera.add_raw_templates(ALL.iter().copied()).map_err(|error| error.to_string())?;
    Ok(tera)
});

/// The text of template `name` for `values`, which must hold finite numbers only.
///
/// NaN, infinity (and `None`) become null in JSON: `values` goes through it so
/// that the first such value is refused by name instead of printed.
pub fn render(name: &str, values: &impl Serialize) -> Result<String, SolverError> {
    let fail = |problem: String| SolverError::Template { template: name.to_owned(), problem };
    let values = serde_json::to_value(values).map_err(|error| fail(error.to_string()))?;
    if let Some(path) = null_in(&values, String::new()) {
        return Err(SolverError::NotFinite { what: path, value: f64::NAN });
    }
    let tera = TERA.as_ref().map_err(|problem| fail(problem.clone()))?;
    let context = Context::from_serialize(&values).map_err(|error| fail(error.to_string()))?;
    tera.render(name, &context).map_err(|error| fail(error.to_string()))
}

/// Path of the first null in `value`.
fn null_in(value: &serde_json::Value, path: String) -> Option<String> {
    use serde_json::Value;
    match value {
        Value::Null => Some(path),
        Value::Array(items) => {
            // The path is built only for items that can hold a null at all.
            items.iter().enumerate().find_map(|(index, item)| match item {
                Value::Null | Value::Array(_) | Value::Object(_) => {
                    null_in(item, format!("{path}[{index}]"))
                }
                _ => None,
            })
        }
        Value::Object(fields) => fields.iter().find_map(|(key, item)| match item {
            Value::Null | Value::Array(_) | Value::Object(_) => {
                let dot = if path.is_empty() { "" } else { "." };
                null_in(item, format!("{path}{dot}{key}"))
            }
            _ => None,
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Needs;

    /// Names that follow `needs.` in `text`.
    fn needs_named(text: &str) -> Vec<&str> {
        text.split("needs.")
            .skip(1)
            .map(|rest| {
                let end = rest.find(|c: char| !(c.is_ascii_lowercase() || c == '_'));
                &rest[..end.unwrap_or(rest.len())]
            })
            .collect()
    }

    #[test]
    fn templates_name_needs_that_exist() {
        let model = crate::solver::deck::examples::two_spheres();
        let needs: Needs = model.needs();
        let fields = serde_json::to_value(needs).expect("needs are plain");
        let mut seen = 0;
        for (name, text) in ALL {
            for field in needs_named(text) {
                assert!(fields.get(field).is_some(), "{name} names needs.{field}");
                seen += 1;
            }
        }
        assert!(seen > 20, "only {seen} uses found: has the test lost its way?");
    }

    #[test]
    fn all_templates_compile() {
        assert!(TERA.is_ok(), "{:?}", TERA.as_ref().err());
    }

    #[test]
    fn nan_is_refused_by_name() {
        #[derive(Serialize)]
        struct Wrong {
            facets: Vec<[f64; 3]>,
        }
        let wrong = Wrong { facets: vec![[0.0, 1.0, 2.0], [0.0, f64::NAN, 1.0]] };
        match render("yade/wall.txt", &wrong) {
            Err(SolverError::NotFinite { what, .. }) => assert_eq!(what, "facets[1][1]"),
            other => panic!("{other:?}"),
        }
    }
}
