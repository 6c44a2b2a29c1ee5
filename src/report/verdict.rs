//! The verdict of a comparison and how it came about, as texts.

use super::compare::rows::MOST_CHANCE;
use super::compare::{Comparison, Quantity, Row, Statistics};
use super::number::{per_cent, significant, with_unit};
use super::table::Table;
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct Verdict {
    passed: bool,
    line: String,
    rules: Vec<String>,
    /// Scatter among realisations.
    scatter: Option<Table>,
    solvers: Vec<Opinion>,
    ours: String,
    /// What time the rows stand for.
    span: String,
    rows: Vec<VerdictRow>,
    missing: Vec<String>,
}

#[derive(Serialize)]
struct Opinion {
    name: String,
    passed: bool,
    reasons: Vec<String>,
}

#[derive(Serialize)]
struct VerdictRow {
    quantity: String,
    ours: String,
    cells: Vec<Cell>,
}

#[derive(Serialize)]
struct Cell {
    value: String,
    difference: String,
    allowed: String,
    passed: bool,
}

pub(super) fn verdict(found: &Comparison, missing: &[String]) -> Verdict {
    let statistics = found.ours.statistics.as_ref();
    let cell = |row: &Row| Cell {
        value: with_unit(row.theirs, row.quantity.unit()),
        difference: per_cent(row.relative),
        allowed: format!(
            "{} %{}",
            significant(row.allowed * 100.0, 3),
            if row.allowed > row.tolerance { " with chance" } else { "" }
        ),
        passed: row.passed,
    };
    let absent = || Cell {
        value: "–".into(),
        difference: String::new(),
        allowed: String::new(),
        passed: false,
    };
    let rows = Quantity::ALL
        .into_iter()
        .filter_map(|quantity| {
            let ours = statistics?.value(quantity)?;
            let others: Vec<Option<&Row>> =
                found.others.iter().map(|other| other.row(quantity)).collect();
            if ours == 0.0 && others.iter().flatten().all(|row| row.theirs == 0.0) {
                return None;
            }
            Some(VerdictRow {
                quantity: quantity.name().into(),
                ours: with_unit(ours, quantity.unit()),
                cells: others.into_iter().map(|row| row.map_or_else(absent, cell)).collect(),
            })
        })
        .collect();
    Verdict {
        passed: found.passed(),
        line: found.verdict(),
        rules: rules(found),
        solvers: found
            .others
            .iter()
            .map(|other| Opinion {
                name: other.side.solver.clone(),
                passed: other.passed,
                reasons: other.reasons.clone(),
            })
            .collect(),
        ours: found.ours.solver.clone(),
        span: statistics.map(|known| basis(known, found)).unwrap_or_default(),
        scatter: scatter(found),
        rows,
        missing: missing.to_vec(),
    }
}

/// What realisations there are, as the end of half a sentence.
fn realisations(found: &Comparison) -> String {
    let known = &found.realisations;
    match known.runs.len() {
        0 | 1 => " (there is no second realisation here)".into(),
        number => format!(
            ": the standard deviation among its {number} realisations (our run and the twins that \
             parted from it and from each other) times √2 and Student's factor for 95 % and so few \
             (at most 4.30), together {}",
            significant(known.factor, 3)
        ),
    }
}

/// What the numbers of the table are means over, and what differences are relative to.
fn basis(known: &Statistics, found: &Comparison) -> String {
    format!(
        "{} Differences of heights are relative to the height of our bed, of kinetic energy to the \
         energy that was put in ({}), all others to our value.",
        span(known),
        with_unit(found.energy_scale, "J")
    )
}

/// The time that statistics stand for.
pub(super) fn span(found: &Statistics) -> String {
    let until = with_unit(found.until, "s");
    match found.frames {
        1 => format!("State at t = {until}."),
        frames => format!(
            "Means over the last quarter of the time: {frames} frames from t = {} to {until}.",
            with_unit(found.from, "s")
        ),
    }
}

/// How much equal beds differ, for people.
fn scatter(found: &Comparison) -> Option<Table> {
    let known = &found.realisations;
    let columns = ["quantity".to_owned()]
        .into_iter()
        .chain(known.runs.iter().cloned())
        .chain(["standard deviation".into(), "two runs may differ by".into()]);
    let rows: Vec<Vec<String>> = known
        .scatter
        .iter()
        .filter(|scatter| scatter.values.iter().any(|value| *value != 0.0))
        .map(|scatter| {
            let unit = scatter.quantity.unit();
            let reach = known.factor * scatter.deviation;
            let numbers = scatter.values.iter().copied().chain([scatter.deviation, reach]);
            let cells = numbers.map(|value| with_unit(value, unit));
            [scatter.quantity.name().to_owned()].into_iter().chain(cells).collect()
        })
        .collect();
    (!rows.is_empty()).then(|| Table { columns: columns.collect(), rows })
}

/// How the verdict comes about, for people.
fn rules(found: &Comparison) -> Vec<String> {
    let asked = &found.tolerances;
    vec![
        format!(
            "Same computation? Each solver is compared, sphere by sphere, with its twin: our DEM run \
             in that solver's own scheme and contact law. From the first contact (t = {}) until {} \
             durations of the shortest contact later (t = {}, or the end of the run), no sphere may \
             be farther away than {} smallest radii. Many-body contact is chaotic: one rounding error grows e-fold within \
             some ten contact durations, so trajectories that part later prove nothing; they are \
             shown, not judged.",
            with_unit(found.first_contact, "s"),
            significant(asked.contact_durations, 3),
            with_unit(found.window_end, "s"),
            significant(asked.trajectory, 2),
        ),
        "Same bed? Statistics over the last quarter of the time (means over at most 16 frames, at \
         least the last), computed from positions and velocities in the same way for every solver, \
         must agree with our run within the tolerances."
            .into(),
        format!(
            "Chance. Once trajectories have parted, two runs are two realisations of one bed and \
             differ even if both are right. The larger of these is then allowed, where it is more \
             than the tolerance: two standard errors of the difference of the means over time \
             (neighbouring frames are correlated, which is allowed for); two standard errors from \
             the number of bodies or contacts; and what our own DEM shows when it runs the same bed \
             again{}. Never more than {} tolerances: a bed that scatters more is too small to judge \
             and does not pass.",
            realisations(found),
            significant(MOST_CHANCE, 2),
        ),
    ]
}
