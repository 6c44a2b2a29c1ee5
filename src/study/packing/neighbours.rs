//! What finding near balls costs, over the ratio of sizes (P18, D11): two searches, two mixtures.
//!
//! *Even*: mass spread evenly in the logarithm of the size, n(r) ∝ r⁻⁴ between the smallest and the largest radius,
//! by quantiles, the last one the largest itself. *Two sizes*: [`LARGE`] large balls among small ones. Balls stand at
//! random without overlap at a solid fraction of 0.25 in a cube whose sides repeat. *Pairs* is the list that packing
//! methods make again and again (surfaces nearer than a fifth of the smallest radius); *contacts* the search of the
//! measures, from nothing. CPU time, medians of five.

use super::super::{StudyError, go_on, timed};
use super::methods::unit_box;
use crate::geometry::Cell;
use crate::num::Job;
use crate::num::statistics::median;
use crate::pack::measure::contacts_of;
use crate::pack::pairs::Pairs;
use crate::pack::scatter;
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::Sheet;
use std::f64::consts::PI;

/// Large balls of the mixture of two sizes.
const LARGE: usize = 50;
/// Solid fraction.
const SOLID: f64 = 0.25;

/// One mixture at one ratio.
pub struct Search {
    mixture: &'static str,
    ratio: f64,
    balls: usize,
    pairs: f64,
    pairs_time: f64,
    contacts_time: f64,
}

/// Both mixtures at ratios 1 to 100.
pub fn searches(full: bool, job: &Job) -> Result<Vec<Search>, StudyError> {
    let count = if full { 100_000 } else { 20_000 };
    let mut found = Vec::new();
    for ratio in [1.0, 3.0, 10.0, 30.0, 100.0] {
        go_on(job)?;
        found.push(search("even", ratio, &even(count, ratio)));
        if ratio > 1.0 {
            go_on(job)?;
            found.push(search("two sizes", ratio, &two_sizes(count, ratio)));
        }
    }
    Ok(found)
}

fn even(count: usize, ratio: f64) -> Vec<f64> {
    let mut radii: Vec<f64> = (0..count)
        .map(|i| {
            let share = (i as f64 + 0.5) / count as f64;
            (1.0 - share * (1.0 - ratio.powi(-3))).powf(-1.0 / 3.0)
        })
        .collect();
    if let Some(last) = radii.last_mut() {
        *last = ratio;
    }
    radii
}

fn two_sizes(count: usize, ratio: f64) -> Vec<f64> {
    (0..count).map(|i| if i < LARGE { ratio } else { 1.0 }).collect()
}

fn search(mixture: &'static str, ratio: f64, sizes: &[f64]) -> Search {
    let volume: f64 = sizes.iter().map(|r| 4.0 / 3.0 * PI * r.powi(3)).sum();
    let factor = (SOLID / volume).cbrt();
    let radii: Vec<f64> = sizes.iter().map(|r| r * factor).collect();
    let space = unit_box(3);
    let skin = 0.2 * factor;
    let balls = radii.len();
    let Some((centres, _)) = scatter::apart(&space, &radii, 1000, 1) else {
        return Search {
            mixture,
            ratio,
            balls,
            pairs: f64::NAN,
            pairs_time: f64::NAN,
            contacts_time: f64::NAN,
        };
    };
    let mut pairs = Pairs::default();
    let pairs_time = each(10, balls, || pairs.find(&space, &centres, &radii, 1.0, skin));
    let body: Vec<u32> = (0..balls as u32).collect();
    let cell = Cell { bounds: space.bounds, periodic: space.periodic };
    let contacts_time = each(3, balls, || {
        contacts_of(&centres, &radii, &body, skin, Some(&cell));
    });
    let near = pairs.list.len() as f64 / balls as f64;
    Search { mixture, ratio, balls, pairs: near, pairs_time, contacts_time }
}

/// CPU time of `work` over the number of balls, µs: median of five times `often` (the clock ticks every 10 ms).
fn each(often: u32, balls: usize, mut work: impl FnMut()) -> f64 {
    let seconds: Vec<f64> =
        (0..5).map(|_| timed(|| (0..often).for_each(|_| work())).1 / f64::from(often)).collect();
    1e6 * median(&seconds).unwrap_or(f64::NAN) / balls as f64
}

/// All figures.
pub fn sheet(searches: &[Search]) -> Sheet {
    let columns = [
        "mixture",
        "largest over smallest",
        "balls",
        "pairs a ball",
        "pairs [µs a ball]",
        "contacts [µs a ball]",
    ];
    Sheet {
        key: "neighbours".into(),
        title: "What finding near balls costs, over the ratio of sizes".into(),
        caption: format!(
            "Even: mass spread evenly in the logarithm of the size. Two sizes: {LARGE} large balls. Solid fraction {SOLID}, \
             CPU time, medians of five."
        ),
        columns: columns.map(String::from).to_vec(),
        rows: searches
            .iter()
            .map(|search| {
                vec![
                    search.mixture.into(),
                    search.ratio.into(),
                    (search.balls as u64).into(),
                    search.pairs.into(),
                    search.pairs_time.into(),
                    search.contacts_time.into(),
                ]
            })
            .collect(),
    }
}

/// Cost over the ratio.
pub fn charts(searches: &[Search]) -> Vec<(String, Chart)> {
    let line = |name: &str, mixture: &str, of: fn(&Search) -> f64| Series {
        name: format!("{name}, {mixture}"),
        points: searches
            .iter()
            .filter(|search| search.mixture == mixture)
            .map(|search| (search.ratio, of(search)))
            .collect(),
        dots: true,
    };
    let mut series = Vec::new();
    for mixture in ["even", "two sizes"] {
        series.push(line("pairs", mixture, |search| search.pairs_time));
        series.push(line("contacts", mixture, |search| search.contacts_time));
    }
    let chart = Chart {
        title: "Finding near balls: cost over the ratio of sizes".into(),
        caption: "CPU time a ball; equal balls are the left end.".into(),
        x: Axis::log("largest over smallest radius", ""),
        y: Axis::linear("CPU time a ball", "µs"),
        series,
        mark: None,
    };
    vec![("packing-neighbours".into(), chart)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mass_is_spread_evenly_over_the_logarithm_of_the_size() {
        let sizes = even(100_000, 30.0);
        let mass = |low: f64, high: f64| -> f64 {
            sizes.iter().filter(|r| (low..high).contains(*r)).map(|r| r.powi(3)).sum()
        };
        assert_eq!((sizes[99_999], sizes.len()), (30.0, 100_000));
        let (fine, coarse) = (mass(1.0, 4.0), mass(4.0, 16.0));
        assert!((fine / coarse - 1.0).abs() < 0.01, "{fine} {coarse}");
        assert!((two_sizes(100, 7.0).iter().sum::<f64>() - 400.0).abs() < 1e-12);
    }

    #[test]
    fn a_search_counts_pairs_and_takes_time() {
        let found = search("even", 3.0, &even(2000, 3.0));
        assert!(found.pairs > 0.05 && found.pairs < 3.0, "{}", found.pairs);
        assert!(found.pairs_time.is_finite() && found.contacts_time.is_finite());
    }
}
