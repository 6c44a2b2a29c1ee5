//! Gravity between bodies: error of the tree code over θ and over run time, and what a pass
//! costs over the number of bodies.
//!
//! Bodies of equal mass, uniform in a ball. The error of a field is the root mean square over
//! bodies of |g − g₀|/|g₀|, g₀ from all pairs. Cost: terms (bodies and cells) summed a body, and
//! CPU seconds of one pass on one thread, the tree's building included. O(n²) for the reference.

use super::{Effort, StudyError, go_on};
use crate::dem::{Pull, attraction};
use crate::model::{FarMethod, MutualGravity, TreeParameters};
use crate::num::units::Length;
use crate::num::{Job, Vec3, clock, random};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::curves::work_precision;
use crate::report::findings::{Findings, Sheet};
use std::time::Instant;

const THETAS: [f64; 6] = [0.3, 0.4, 0.5, 0.7, 0.85, 1.0];
/// θ of the cost over the number of bodies: the default.
const USUAL: f64 = 0.5;

/// CPU seconds after which a time is known well enough, and passes that are enough in any case.
const LONG_ENOUGH: f64 = 0.3;
const MOST_PASSES: u32 = 100;

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let (bodies, counts): (usize, &[usize]) = match effort {
        Effort::Quick => (2_000, &[1_000, 2_000, 4_000, 8_000]),
        Effort::Full => (20_000, &[1_000, 2_000, 4_000, 8_000, 16_000, 32_000, 64_000]),
    };
    let (errors, mut charts, mut remarks) = errors(bodies, job)?;
    let (costs, chart, remark) = costs(counts, job)?;
    charts.push(("tree-cost".into(), chart));
    remarks.push(remark);
    Ok(Findings {
        title: "Gravity between bodies: error against run time".into(),
        question: "How far is the tree code (Barnes & Hut 1986; a cell of edge s counts as one beyond s/θ + δ, Barnes 1994) from the sum over all pairs, at which θ and cost? Does its cost grow as n log n?".into(),
        remarks,
        tables: vec![errors, costs],
        charts,
        pictures: Vec::new(),
    })
}

type Parts = (Sheet, Vec<(String, Chart)>, Vec<String>);

/// Error and cost of `bodies` bodies over θ.
fn errors(bodies: usize, job: &Job) -> Result<Parts, StudyError> {
    let (places, masses) = ball(bodies);
    let (exact, all_pairs) = timed(&places, &masses, FarMethod::AllPairs);
    let mut sheet = Sheet {
        key: "tree-error".into(),
        title: format!("Error of the field, {bodies} bodies"),
        caption: format!(
            "Equal masses, uniform in a ball; error: root mean square over bodies of |g − g₀|/|g₀|. All pairs take {all_pairs:.4} s a pass."
        ),
        columns: ["order", "θ", "rms error", "largest error", "terms a body", "CPU a pass [s]"]
            .map(String::from)
            .to_vec(),
        rows: Vec::new(),
    };
    let (mut over_theta, mut over_time, mut remarks) = (Vec::new(), Vec::new(), Vec::new());
    for (name, quadrupole) in [("monopole", false), ("quadrupole", true)] {
        let (mut points, mut timed_points) = (Vec::new(), Vec::new());
        for theta in THETAS {
            go_on(job)?;
            let method = FarMethod::Tree(TreeParameters { theta, quadrupole });
            let (found, seconds) = timed(&places, &masses, method);
            let (rms, worst) = error(&found, &exact);
            let terms = found.iter().map(|pull| pull.terms as f64).sum::<f64>() / bodies as f64;
            sheet.rows.push(vec![
                name.into(),
                theta.into(),
                rms.into(),
                worst.into(),
                terms.into(),
                seconds.into(),
            ]);
            points.push((theta, rms));
            timed_points.push((seconds, rms));
            if theta == USUAL {
                remarks.push(format!(
                    "θ = {theta}, {name}: rms error {rms:.1e}, {:.0} terms a body instead of {}.",
                    terms,
                    bodies - 1
                ));
            }
        }
        over_theta.push(Series { name: name.into(), points, dots: true });
        over_time.push((name.to_owned(), timed_points));
    }
    let chart = Chart {
        title: "Error of the field over θ".into(),
        caption: format!("{bodies} equal bodies, uniform in a ball, against all pairs."),
        x: Axis::log("θ", ""),
        y: Axis::log("rms error of the field", ""),
        series: over_theta,
        mark: None,
    };
    let time = work_precision(
        "Error of the field over CPU time of a pass",
        &over_time,
        "rms error of the field",
        "",
        None,
    );
    Ok((sheet, vec![("tree-theta".into(), chart), ("tree-time".into(), time)], remarks))
}

/// Cost of a pass over the number of bodies.
fn costs(counts: &[usize], job: &Job) -> Result<(Sheet, Chart, String), StudyError> {
    let mut sheet = Sheet {
        key: "tree-cost".into(),
        title: "Cost of a pass".into(),
        caption: format!("θ = {USUAL}, quadrupoles; one thread; terms: bodies and cells summed."),
        columns: [
            "bodies",
            "terms a body",
            "terms a body / log2 n",
            "tree, CPU a pass [s]",
            "all pairs, CPU a pass [s]",
        ]
        .map(String::from)
        .to_vec(),
        rows: Vec::new(),
    };
    let (mut tree_points, mut pair_points, mut growth) = (Vec::new(), Vec::new(), Vec::new());
    for &count in counts {
        go_on(job)?;
        let (places, masses) = ball(count);
        let method = FarMethod::Tree(TreeParameters { theta: USUAL, quadrupole: true });
        let (found, tree) = timed(&places, &masses, method);
        // All pairs of more take longer than they tell.
        let pairs = if count <= 16_000 {
            let seconds = timed(&places, &masses, FarMethod::AllPairs).1;
            pair_points.push((count as f64, seconds));
            seconds
        } else {
            f64::NAN
        };
        let n = count as f64;
        let terms = found.iter().map(|pull| pull.terms as f64).sum::<f64>() / n;
        sheet.rows.push(vec![
            (count as u64).into(),
            terms.into(),
            (terms / n.log2()).into(),
            tree.into(),
            pairs.into(),
        ]);
        tree_points.push((n, tree));
        growth.push(terms);
    }
    let chart = Chart {
        title: "Cost of a pass over the number of bodies".into(),
        caption: format!("θ = {USUAL}, quadrupoles; one thread."),
        x: Axis::log("bodies", ""),
        y: Axis::log("CPU time of a pass", "s"),
        series: vec![
            Series { name: "tree".into(), points: tree_points, dots: true },
            Series { name: "all pairs".into(), points: pair_points, dots: true },
        ],
        mark: None,
    };
    // Every study has several counts.
    let (first, last) =
        (growth.first().copied().unwrap_or(0.0), growth.last().copied().unwrap_or(0.0));
    let doublings = (counts[counts.len() - 1] as f64 / counts[0] as f64).log2();
    let remark = format!(
        "Terms a body grow from {first:.0} to {last:.0} over {doublings:.0} doublings of n, {:.0} a doubling: n log n.",
        (last - first) / doublings
    );
    Ok((sheet, chart, remark))
}

/// Field and CPU seconds of a pass.
fn timed(places: &[Vec3], masses: &[f64], method: FarMethod) -> (Vec<Pull>, f64) {
    let law = MutualGravity { constant: 1.0, method, softening: Length(0.0) };
    let (begun, cpu) = (Instant::now(), clock::cpu_seconds());
    // The clock ticks every 10 ms.
    for passes in 1.. {
        let found = attraction(places, masses, &law, 1);
        let seconds = clock::since(cpu, begun);
        if seconds > LONG_ENOUGH || passes == MOST_PASSES {
            return (found, seconds / f64::from(passes));
        }
    }
    (Vec::new(), f64::NAN)
}

/// Root mean square and largest of |g − g₀|/|g₀|.
fn error(found: &[Pull], exact: &[Pull]) -> (f64, f64) {
    let (mut square, mut worst) = (0.0, 0.0f64);
    for (a, b) in found.iter().zip(exact) {
        let one = (a.field - b.field).norm() / b.field.norm();
        square += one * one;
        worst = worst.max(one);
    }
    ((square / exact.len().max(1) as f64).sqrt(), worst)
}

/// Equal masses, 1 kg together, uniform in a ball of radius 1 m.
fn ball(count: usize) -> (Vec<Vec3>, Vec<f64>) {
    let mut source = random::stream(1, "study.tree", count as u64);
    let mut places = Vec::with_capacity(count);
    while places.len() < count {
        let place = Vec3::from_fn(|_, _| random::uniform(&mut source, -1.0, 1.0));
        if place.norm_squared() <= 1.0 {
            places.push(place);
        }
    }
    (places, vec![1.0 / count as f64; count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_study_has_all_its_parts() {
        let (sheet, charts, remarks) = errors(300, &Job::quiet()).expect("it runs");
        assert_eq!((sheet.rows.len(), charts.len(), remarks.len()), (12, 2, 2));
        let (sheet, _, remark) = costs(&[200, 400], &Job::quiet()).expect("it runs");
        assert_eq!(sheet.rows.len(), 2);
        assert!(remark.contains("doubling"));
    }
}
