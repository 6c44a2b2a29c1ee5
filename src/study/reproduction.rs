//! R1 to R5 against what their papers say of them, and what the survey that names them says
//! (Sajjadi & Khalili 2015, section 4.1).
//!
//! R1 (Lu & McDowell 2007): spheres at all inner nodes; error of the order of the spacing. R2 (Wang
//! et al. 2007): fewer spheres for the same error; smaller first spheres are sharper; first
//! spheres far below the replacing ones leave a pitted surface. R3 (Matsushima et al. 2003): the
//! result depends on the random start and on the stiffnesses. R4 (Price et al. 2007): the
//! second step is nearer, and slow. R5 (Ferellec & McDowell 2010): a larger threshold needs fewer
//! spheres and less time.
//!
//! Every statement is a row with what was measured and what it is held against. Errors are root mean square
//! distances ([`crate::clump::measure`]) over the equivalent diameter. Pits are what the largest distance has beyond
//! the root mean square one.

use super::solids::solids;
use super::{Effort, StudyError, go_on, timed};
use crate::clump::{
    self, ClumpError, Dynamic, FourPoints, MassSource, Method, Nodes, Normals, Order, Place,
    Replaced,
};
use crate::num::statistics::median;
use crate::num::{Job, statistics};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};
use crate::report::gallery::solid_beside_clump;
use crate::report::picture::Picture;
use crate::shape::Solid;

/// Surface points each way of an error.
const POINTS: usize = 2000;
/// Stiffness of growth over that of motion.
const STIFFNESSES: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];
const ROUNDS: [usize; 5] = [0, 10, 30, 100, 300];
/// CPU seconds of repeated fits that are enough, and repeats that are.
const ENOUGH: f64 = 0.15;
const REPEATS: u32 = 60;
const THRESHOLDS: [f64; 5] = [0.1, 0.05, 0.02, 0.01, 0.005];

/// What is computed.
struct Size {
    solids: &'static [&'static str],
    across: &'static [f64],
    starts: u64,
}

const QUICK: Size = Size {
    solids: &["cube", "smooth-0", "sharp-0"],
    across: &[6.0, 8.0, 10.0, 12.0, 16.0],
    starts: 8,
};
const FULL: Size = Size {
    solids: &[
        "ellipsoid",
        "cube",
        "smooth-0",
        "sharp-0",
        "sharp-1",
        "smooth-1",
        "octahedron",
        "cylinder",
    ],
    across: &[6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 24.0],
    starts: 24,
};

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let size = if effort == Effort::Quick { QUICK } else { FULL };
    let solids: Vec<Solid> =
        solids()?.into_iter().filter(|s| size.solids.contains(&s.name.as_str())).collect();
    let mut runs = Vec::new();
    let mut pictures = Vec::new();
    for (done, solid) in solids.iter().enumerate() {
        for (method, setting, value, repeat) in plan(&size) {
            go_on(job)?;
            runs.extend(run(solid, method, setting, value, repeat, job)?);
        }
        if solid.name == size.solids[size.solids.len().min(3) - 1] {
            for (name, method) in examples() {
                pictures.extend(picture(solid, name, &method, job)?);
            }
        }
        job.report("solids", done as u64 + 1, solids.len() as u64);
    }
    let statements = statements(&runs, &solids, &size);
    let failed = statements.iter().filter(|s| !s.holds()).count();
    let mut remarks: Vec<String> = vec![match failed {
        0 => format!("All {} statements hold.", statements.len()),
        _ => format!("{failed} of {} statements do not hold.", statements.len()),
    }];
    remarks.extend(statements.iter().map(Statement::sentence));
    Ok(Findings {
        title: "R1 to R5 against what their papers say".into(),
        question: "Do the five methods behave as their papers and the survey that names them (Sajjadi & Khalili 2015) say?".into(),
        remarks,
        tables: vec![sheet_of_statements(&statements), sheet_of_runs(&runs)],
        charts: charts(&runs, &solids),
        pictures,
    })
}

/// One set of spheres.
struct Run {
    solid: String,
    method: &'static str,
    setting: &'static str,
    value: f64,
    repeat: u64,
    spheres: usize,
    /// Root mean square and largest distance, %.
    rms: f64,
    largest: f64,
    seconds: f64,
}

type Planned = (&'static str, &'static str, f64, u64);

fn plan(size: &Size) -> Vec<Planned> {
    let mut plan: Vec<Planned> = Vec::new();
    for &across in size.across {
        plan.extend([("nodes", "across", across, 0), ("replaced", "across", across, 0)]);
    }
    for stiffness in STIFFNESSES {
        plan.extend((0..size.starts).map(|start| ("dynamic", "growth", stiffness, start)));
    }
    plan.extend(ROUNDS.map(|rounds| ("four_points", "rounds", rounds as f64, 0)));
    plan.extend(THRESHOLDS.map(|threshold| ("normals", "threshold", threshold, 0)));
    plan
}

fn method(name: &str, value: f64) -> Method {
    match name {
        "nodes" => {
            Method::Nodes(Nodes { across: value, place: Place::Inscribed, ..Nodes::default() })
        }
        "replaced" => {
            let (across, spheres) = (Some(value), 5000);
            Method::Replaced(Replaced { across, spheres, ..Replaced::default() })
        }
        "dynamic" => Method::Dynamic(Dynamic { growth: value, starts: 1, ..Dynamic::default() }),
        "four_points" => {
            let (rounds, draws) = (value as usize, 10_000);
            Method::FourPoints(FourPoints { rounds, draws, ..FourPoints::default() })
        }
        // As in the source: random order, nothing sticks out, as many spheres as it takes.
        _ => Method::Normals(Normals {
            threshold: value,
            spheres: 2000,
            protrusion: 0.0,
            smallest: 0.005,
            order: Order::Random,
            ..Normals::default()
        }),
    }
}

fn run(
    solid: &Solid,
    name: &'static str,
    setting: &'static str,
    value: f64,
    repeat: u64,
    job: &Job,
) -> Result<Option<Run>, StudyError> {
    let method = method(name, value);
    let alone = job.with_threads(1);
    // Short fits are repeated: clocks of CPU time tick slowly.
    let (mut balls, mut seconds, mut repeats) = (Vec::new(), 0.0, 0);
    while repeats == 0 || (seconds < ENOUGH && is_timed(name) && repeats < REPEATS) {
        let (found, taken) = timed(|| clump::spheres(solid, &method, repeat, 0, &alone));
        balls = match found {
            Err(ClumpError::Cancelled) => return Err(StudyError::Cancelled),
            Err(ClumpError::NoSphere { .. }) => return Ok(None),
            found => found.map_err(|error| StudyError::Work(error.to_string()))?,
        };
        seconds += taken;
        repeats += 1;
    }
    let seconds = seconds / f64::from(repeats);
    let fidelity = clump::measure(solid, &balls, POINTS)
        .map_err(|error| StudyError::Work(error.to_string()))?;
    let share = |distance: f64| 100.0 * distance / fidelity.equivalent_diameter;
    Ok(Some(Run {
        solid: solid.name.clone(),
        method: name,
        setting,
        value,
        repeat,
        spheres: balls.len(),
        rms: share(fidelity.rms_distance),
        largest: share(fidelity.largest_distance),
        seconds,
    }))
}

/// Methods whose CPU time is looked at.
fn is_timed(name: &str) -> bool {
    name == "four_points" || name == "normals"
}

/// One claim about one solid, with limits between which what was measured must lie.
struct Statement {
    id: &'static str,
    says: &'static str,
    solid: String,
    what: &'static str,
    measured: f64,
    least: f64,
    most: f64,
}

impl Statement {
    fn holds(&self) -> bool {
        (self.least..=self.most).contains(&self.measured)
    }

    fn sentence(&self) -> String {
        let verdict = if self.holds() { "" } else { " (does not hold)" };
        format!(
            "{} {}, {}: {} {:.3}{verdict}.",
            self.id, self.says, self.solid, self.what, self.measured
        )
    }
}

fn statements(runs: &[Run], solids: &[Solid], size: &Size) -> Vec<Statement> {
    let mut list = Vec::new();
    for solid in solids {
        let of = |method: &str| -> Vec<&Run> {
            runs.iter().filter(|r| r.solid == solid.name && r.method == method).collect()
        };
        let mut say = |id, says, what, measured, least, most| {
            let solid = solid.name.clone();
            list.push(Statement { id, says, solid, what, measured, least, most });
        };
        let (nodes, replaced) = (of("nodes"), of("replaced"));
        say(
            "R1",
            "error of the order of the spacing",
            "exponent of the rms distance over nodes across",
            slope(&nodes, |r| r.value, |r| r.rms),
            -2.0,
            -0.6,
        );
        say(
            "R2",
            "fewer spheres than R1 at the same error",
            "most spheres over those of R1 at equal rms distance",
            fewer(&nodes, &replaced),
            0.0,
            0.7,
        );
        say(
            "R2",
            "smaller first spheres are sharper",
            "exponent of the rms distance over nodes across",
            slope(&replaced, |r| r.value, |r| r.rms),
            -2.0,
            -0.4,
        );
        let ends = |of: &dyn Fn(&Run) -> f64, runs: &[&Run]| match (runs.first(), runs.last()) {
            (Some(first), Some(last)) => of(last) / of(first),
            _ => f64::NAN,
        };
        say(
            "R2",
            "first spheres far below the replacing ones leave pits",
            "largest over rms distance, finest over coarsest grid",
            ends(&|r| r.largest / r.rms, &replaced),
            1.1,
            3.0,
        );
        let dynamic = of("dynamic");
        let at = |value: f64| -> Vec<f64> {
            dynamic.iter().filter(|r| r.value == value).map(|r| r.rms).collect()
        };
        say(
            "R3",
            "depends on its random start",
            "worst over best rms distance of the starts at a stiffness ratio of 1",
            spread(&at(1.0)),
            1.1,
            10.0,
        );
        let medians: Vec<f64> = STIFFNESSES.iter().filter_map(|&k| median(&at(k))).collect();
        say(
            "R3",
            "depends on its constants",
            "worst over best median rms distance of the stiffness ratios",
            spread(&medians),
            1.05,
            10.0,
        );
        let four = of("four_points");
        let pick = |rounds: usize| four.iter().find(|r| r.value == rounds as f64);
        let over = |of: &dyn Fn(&Run) -> f64| match (pick(300), pick(0)) {
            (Some(with), Some(without)) => of(with) / of(without),
            _ => f64::NAN,
        };
        say(
            "R4",
            "the second step is nearer",
            "rms distance with over without it",
            over(&|r| r.rms),
            0.0,
            0.9,
        );
        say(
            "R4",
            "the second step is slow",
            "CPU time with over without it",
            over(&|r| r.seconds),
            1.0,
            1000.0,
        );
        let normals = of("normals");
        say(
            "R5",
            "a larger threshold needs fewer spheres",
            "least ratio of spheres from one threshold to the next smaller",
            normals
                .windows(2)
                .map(|w| w[1].spheres as f64 / w[0].spheres as f64)
                .fold(f64::INFINITY, f64::min),
            1.1,
            100.0,
        );
        say(
            "R5",
            "a larger threshold is quicker",
            "CPU time at the smallest over the largest threshold",
            ends(&|r| r.seconds, &normals),
            1.2,
            10_000.0,
        );
    }
    debug_assert!(list.len() == size.solids.len() * 10 || solids.len() < size.solids.len());
    list
}

/// Exponent of a power law through the runs.
fn slope(runs: &[&Run], x: impl Fn(&Run) -> f64, y: impl Fn(&Run) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = runs.iter().map(|r| (x(r).ln(), y(r).ln())).collect();
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - mx) * (p.1 - my)) / mean(&|p| (p.0 - mx).powi(2))
}

/// The largest share of spheres of R2 in those that R1 needs for the same rms distance
/// (power law between and beyond its runs).
fn fewer(nodes: &[&Run], replaced: &[&Run]) -> f64 {
    let power = slope(nodes, |r| r.rms, |r| r.spheres as f64);
    let n = nodes.len() as f64;
    let centre = |of: &dyn Fn(&Run) -> f64| nodes.iter().map(|r| of(r).ln()).sum::<f64>() / n;
    let (rms, spheres) = (centre(&|r| r.rms), centre(&|r| r.spheres as f64));
    let needed = |error: f64| (spheres + power * (error.ln() - rms)).exp();
    replaced.iter().map(|r| r.spheres as f64 / needed(r.rms)).fold(f64::NAN, f64::max)
}

fn spread(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most / values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn sheet_of_statements(statements: &[Statement]) -> Sheet {
    let row = |s: &Statement| -> Vec<Cell> {
        vec![
            s.id.into(),
            s.says.into(),
            s.solid.as_str().into(),
            s.what.into(),
            s.measured.into(),
            s.least.into(),
            s.most.into(),
            if s.holds() { "holds" } else { "does not hold" }.into(),
        ]
    };
    Sheet {
        key: "statements".into(),
        title: "Statements".into(),
        caption: "What is measured must lie between least and most.".into(),
        columns: [
            "method",
            "what the source says",
            "solid",
            "what is measured",
            "measured",
            "least",
            "most",
            "verdict",
        ]
        .map(String::from)
        .to_vec(),
        rows: statements.iter().map(row).collect(),
    }
}

fn sheet_of_runs(runs: &[Run]) -> Sheet {
    let row = |r: &Run| -> Vec<Cell> {
        vec![
            r.solid.as_str().into(),
            r.method.into(),
            r.setting.into(),
            r.value.into(),
            r.repeat.into(),
            (r.spheres as u64).into(),
            r.rms.into(),
            r.largest.into(),
            r.seconds.into(),
        ]
    };
    Sheet {
        key: "runs".into(),
        title: "Every set of spheres".into(),
        caption: "R1 and R2 inscribed, R3 with 10 spheres and one start, R4 with 20 spheres and 10 000 draws, R5 in random order and inscribed; CPU seconds of the fit alone.".into(),
        columns: ["solid", "method", "setting", "value", "start", "spheres", "rms distance [%]", "largest distance [%]", "CPU [s]"]
            .map(String::from)
            .to_vec(),
        rows: runs.iter().map(row).collect(),
    }
}

fn charts(runs: &[Run], solids: &[Solid]) -> Vec<(String, Chart)> {
    let line = |solid: &str, method: &str, x: &dyn Fn(&Run) -> f64, y: &dyn Fn(&Run) -> f64| {
        let own = runs.iter().filter(|r| r.solid == solid && r.method == method);
        own.map(|r| (x(r), y(r))).collect::<Vec<_>>()
    };
    let each = |method: &str, x: &dyn Fn(&Run) -> f64, y: &dyn Fn(&Run) -> f64, name: &str| {
        solids
            .iter()
            .map(|solid| Series {
                name: format!("{name}{}", solid.name),
                points: line(&solid.name, method, x, y),
                dots: true,
            })
            .collect::<Vec<_>>()
    };
    let chart = |title: &str, caption: &str, x: Axis, y: Axis, series: Vec<Series>| Chart {
        title: title.into(),
        caption: caption.into(),
        x,
        y,
        series,
        mark: None,
    };
    let rms = || Axis::log("rms distance / diameter", "%");
    let spheres = |r: &Run| r.spheres as f64;
    let mut first = each("nodes", &spheres, &|r| r.rms, "R1 ");
    first.extend(each("replaced", &spheres, &|r| r.rms, "R2 "));
    let starts = solids.iter().map(|solid| {
        let values = STIFFNESSES.iter().filter_map(|&k| {
            let own: Vec<f64> = runs
                .iter()
                .filter(|r| r.solid == solid.name && r.method == "dynamic" && r.value == k)
                .map(|r| r.rms)
                .collect();
            Some((k, statistics::median(&own)?, own.iter().copied().fold(0.0, f64::max)))
        });
        Series::up_to(&solid.name, values.collect::<Vec<_>>().into_iter())
    });
    vec![
        (
            "r1-r2".into(),
            chart(
                "R1 and R2: error over number of spheres",
                "Inscribed, the same grids.",
                Axis::log("spheres", ""),
                rms(),
                first,
            ),
        ),
        (
            "r3".into(),
            chart(
                "R3: the start and the stiffnesses",
                "Ten spheres. Median over random starts; bars reach to the worst.",
                Axis::log("stiffness of growth over motion", ""),
                rms(),
                starts.collect(),
            ),
        ),
        (
            "r4".into(),
            chart(
                "R4: what the second step costs",
                "20 spheres, 10 000 draws; 0, 10, 30, 100 and 300 rounds.",
                Axis::log("CPU time of the fit", "s"),
                rms(),
                each("four_points", &|r| r.seconds, &|r| r.rms, ""),
            ),
        ),
        (
            "r5".into(),
            chart(
                "R5: spheres over the threshold",
                "Random order, inscribed.",
                Axis::log("threshold / diameter", ""),
                Axis::log("spheres", ""),
                each("normals", &|r| r.value, &spheres, ""),
            ),
        ),
        (
            "r5-error".into(),
            chart(
                "R5: error over the threshold",
                "Random order, inscribed.",
                Axis::log("threshold / diameter", ""),
                rms(),
                each("normals", &|r| r.value, &|r| r.rms, ""),
            ),
        ),
    ]
}

fn examples() -> Vec<(&'static str, Method)> {
    vec![
        ("R1", method("nodes", 12.0)),
        ("R2", method("replaced", 12.0)),
        ("R3", method("dynamic", 1.0)),
        ("R4", method("four_points", 100.0)),
        ("R5", method("normals", 0.02)),
    ]
}

fn picture(
    solid: &Solid,
    id: &str,
    method: &Method,
    job: &Job,
) -> Result<Option<(String, String, String, Picture)>, StudyError> {
    let clump = match clump::reproduce(solid, method, MassSource::Solid, 0, 0, job) {
        Err(ClumpError::NoSphere { .. }) => return Ok(None),
        found => found.map_err(|error| StudyError::Work(error.to_string()))?,
    };
    let rms = clump.fidelity.map_or(f64::NAN, |f| 100.0 * f.rms_distance / f.equivalent_diameter);
    Ok(Some((
        format!("clump-{}", id.to_lowercase()),
        format!("{} and {id}", solid.name),
        format!("{} spheres, root mean square distance {rms:.2} %", clump.balls.len()),
        solid_beside_clump(solid, &clump, 640, 320),
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn a_run(method: &'static str, spheres: usize, rms: f64) -> Run {
        let solid = "cube".to_owned();
        Run {
            solid,
            method,
            setting: "",
            value: 1.0,
            repeat: 0,
            spheres,
            rms,
            largest: rms,
            seconds: 1.0,
        }
    }

    #[test]
    fn shares_of_spheres_are_taken_at_equal_error() {
        // R1 needs 8 times the spheres for half the error.
        let nodes = [a_run("nodes", 100, 4.0), a_run("nodes", 800, 2.0), a_run("nodes", 6400, 1.0)];
        let replaced = [a_run("replaced", 80, 2.0), a_run("replaced", 320, 1.0)];
        let share = fewer(&nodes.iter().collect::<Vec<_>>(), &replaced.iter().collect::<Vec<_>>());
        assert!((share - 0.1).abs() < 1e-9, "{share}");
        assert!((spread(&[1.0, 3.0, 2.0]) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_statement_out_of_its_limits_or_without_a_number_does_not_hold() {
        let statement = |measured| Statement {
            id: "R2",
            says: "fewer",
            solid: "cube".into(),
            what: "ratio",
            measured,
            least: 0.0,
            most: 0.7,
        };
        assert!(statement(0.3).holds());
        assert!(!statement(0.8).holds() && !statement(f64::NAN).holds());
        assert!(statement(0.8).sentence().contains("does not hold"));
    }
}
