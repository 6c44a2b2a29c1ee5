//! Two runs, sphere by sphere, at their common times.
//!
//! Frames pair up when their times differ by less than half a step. Symbols:
//! Δx position difference over the smallest radius, Δv velocity difference in m/s
//! (YADE's velocities lag half a step, so its Δv never falls below |a| Δt/2 unless
//! the twin lags as well). Cost O(frames × spheres).

use crate::model::{Frame, Model};
use crate::report::number::with_unit;
use serde::{Deserialize, Serialize};

/// Difference of two runs at one time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    /// Step number.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Largest |Δx| over all spheres, in smallest radii.
    pub largest: f64,
    /// Root mean square of |Δx|, in smallest radii.
    pub rms: f64,
    /// The sphere with the largest |Δx|.
    pub sphere: u32,
    /// Largest |Δv|, m/s.
    pub largest_velocity: f64,
    /// Root mean square of |Δv|, m/s.
    pub rms_velocity: f64,
}

/// Difference of two runs over time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Trajectory {
    /// One entry each common frame, in rising time.
    pub points: Vec<Divergence>,
    /// Time of the last frame before the first that is out of tolerance, s; `None`: never agreed.
    pub agrees_until: Option<f64>,
    /// Time of the first frame out of tolerance, s; `None`: all agree.
    pub leaves_at: Option<f64>,
    /// The frame with the largest difference.
    pub worst: Option<Divergence>,
    /// Time in which small differences grow e-fold, s, fitted to ln rms between 1e-12 and
    /// 1e-2 smallest radii; `None` with fewer than four such frames or no growth.
    pub growth_time: Option<f64>,
}

impl Trajectory {
    /// Compares frames of the same spheres of `model`; `radius` is the unit of length,
    /// `tolerance` in that unit.
    pub fn between(a: &[Frame], b: &[Frame], model: &Model, radius: f64, tolerance: f64) -> Self {
        let step = model.plan.step;
        let mut points = Vec::new();
        let mut place = 0;
        for frame in a {
            while b.get(place).is_some_and(|f| f.time < frame.time - 0.5 * step) {
                place += 1;
            }
            if let Some(other) = b.get(place).filter(|f| f.time <= frame.time + 0.5 * step) {
                points.push(difference(model, frame, other, radius));
            }
        }
        let first_out = points.iter().position(|point| point.largest > tolerance);
        let last_in = first_out.unwrap_or(points.len()).checked_sub(1);
        Self {
            agrees_until: last_in.map(|at| points[at].time),
            leaves_at: first_out.map(|at| points[at].time),
            worst: points.iter().copied().reduce(|a, b| if b.largest > a.largest { b } else { a }),
            growth_time: growth_time(&points),
            points,
        }
    }

    /// Says plainly that trajectories have parted, and whether that means
    /// something; `window_end` as in [`super::Comparison`].
    pub fn parting(&self, window_end: f64) -> Option<String> {
        let parts = self.leaves_at?;
        let leaves = with_unit(parts, "s");
        if parts <= window_end {
            return Some(format!(
                "Sphere by sphere it parts from our run at t = {leaves}, too early for chaos: \
                 schemes or contact laws differ."
            ));
        }
        let growth = self.growth_time.map_or(String::new(), |time| {
            format!(", small differences growing e-fold in {}", with_unit(time, "s"))
        });
        Some(format!(
            "Sphere by sphere it parts from our run at t = {leaves}{growth}: contact dynamics \
             is chaotic, from then on only statistics can be compared."
        ))
    }
}

fn difference(model: &Model, a: &Frame, b: &Frame, radius: f64) -> Divergence {
    let mut point = Divergence {
        step: a.step,
        time: a.time,
        largest: 0.0,
        rms: 0.0,
        sphere: 0,
        largest_velocity: 0.0,
        rms_velocity: 0.0,
    };
    let count = a.centres.len().max(1) as f64;
    for (index, (x, y)) in a.centres.iter().zip(&b.centres).enumerate() {
        let distance = model.way(x - y).norm() / radius;
        point.rms += distance * distance / count;
        if distance > point.largest {
            (point.largest, point.sphere) = (distance, index as u32);
        }
    }
    for (u, v) in a.velocities.iter().zip(&b.velocities) {
        let speed = (u - v).norm();
        point.rms_velocity += speed * speed / count;
        point.largest_velocity = point.largest_velocity.max(speed);
    }
    (point.rms, point.rms_velocity) = (point.rms.sqrt(), point.rms_velocity.sqrt());
    point
}

/// Least-squares slope of ln rms over time, inverted.
fn growth_time(points: &[Divergence]) -> Option<f64> {
    let small: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| (1e-12..1e-2).contains(&point.rms))
        .map(|point| (point.time, point.rms.ln()))
        .collect();
    if small.len() < 4 {
        return None;
    }
    let count = small.len() as f64;
    let (mt, ml) = small.iter().fold((0.0, 0.0), |(t, l), p| (t + p.0 / count, l + p.1 / count));
    let covariance: f64 = small.iter().map(|(t, l)| (t - mt) * (l - ml)).sum();
    let variance: f64 = small.iter().map(|(t, _)| (t - mt).powi(2)).sum();
    let time = variance / covariance;
    (time.is_finite() && time > 0.0).then_some(time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;
    use crate::report::fixture;

    #[test]
    fn a_known_growth_is_found() {
        let model = fixture::model(2);
        let radius = 0.005;
        // 1e-10 radii at the start, e-fold every 0.5 ms (50 steps).
        let apart = |step: u64| Vec3::x() * (radius * 1e-10 * (step as f64 / 50.0).exp());
        let a = fixture::run(&model, "a", |_| Vec3::zeros());
        let b = fixture::run(&model, "b", apart);
        let found = Trajectory::between(&a.frames, &b.frames, &model, radius, 1e-4);
        assert_eq!(found.points.len(), 11);
        let third = found.points[3];
        assert!((third.largest / (1e-10 * 6_f64.exp()) - 1.0).abs() < 1e-3, "{third:?}");
        assert!((third.rms / third.largest - 1.0).abs() < 1e-3, "all moved alike");
        assert!((found.growth_time.expect("grows") / 5e-4 - 1.0).abs() < 1e-3);
        // ln(1e6) = 13.8 e-folds = 6.9 ms: frames at 6 ms agree, at 7 ms not.
        assert!((found.agrees_until.expect("agrees at first") - 6e-3).abs() < 1e-9);
        assert!((found.leaves_at.expect("parts") - 7e-3).abs() < 1e-9);
    }

    #[test]
    fn frames_pair_up_by_time() {
        let model = fixture::model(1);
        let a = fixture::run(&model, "a", |_| Vec3::zeros());
        let mut b = a.clone();
        b.frames.retain(|frame| frame.step % 300 == 0);
        let found = Trajectory::between(&a.frames, &b.frames, &model, 0.005, 1e-3);
        let steps: Vec<u64> = found.points.iter().map(|point| point.step).collect();
        assert_eq!(steps, [0, 300, 600, 900]);
        assert_eq!(found.leaves_at, None);
        assert_eq!(found.growth_time, None);
    }
}
