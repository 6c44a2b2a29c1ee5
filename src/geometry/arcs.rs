//! Parts of a circle that nothing covers.

use std::f64::consts::TAU;

/// Covered parts of one circle, angles in radians.
#[derive(Debug, Clone, Default)]
pub struct Cover {
    covered: Vec<(f64, f64)>,
}

impl Cover {
    /// Forgets everything, keeps the memory.
    pub fn clear(&mut self) {
        self.covered.clear();
    }

    /// Covers the angles within `half` of `middle`; `half` from 0 to π.
    pub fn cover(&mut self, middle: f64, half: f64) {
        let from = (middle - half).rem_euclid(TAU);
        let to = from + 2.0 * half;
        if to > TAU {
            self.covered.push((from, TAU));
            self.covered.push((0.0, to - TAU));
        } else {
            self.covered.push((from, to));
        }
    }

    /// Calls `free(from, to)` for each uncovered arc, 0 ≤ from < to ≤ 2π; an arc
    /// that runs through the angle 0 comes in two parts.
    pub fn each_free(&mut self, mut free: impl FnMut(f64, f64)) {
        self.covered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = 0.0;
        for &(from, to) in &self.covered {
            if from > reached {
                free(reached, from);
            }
            reached = to.max(reached);
        }
        if reached < TAU {
            free(reached, TAU);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(cover: &mut Cover) -> Vec<(f64, f64)> {
        let mut arcs = Vec::new();
        cover.each_free(|from, to| arcs.push((from, to)));
        arcs
    }

    #[test]
    fn arcs_wrap_and_merge() {
        let mut cover = Cover::default();
        assert_eq!(free(&mut cover), vec![(0.0, TAU)]);
        cover.cover(0.0, 0.5);
        let arcs = free(&mut cover);
        assert_eq!(arcs.len(), 1);
        assert!((arcs[0].0 - 0.5).abs() < 1e-12 && (arcs[0].1 - (TAU - 0.5)).abs() < 1e-12);
        // From 0.2 to 1.8, of which 0.3 was covered before; then 0.2 by itself.
        cover.cover(1.0, 0.8);
        cover.cover(4.0, 0.1);
        let total: f64 = free(&mut cover).iter().map(|(from, to)| to - from).sum();
        assert!((total - (TAU - 1.0 - 1.3 - 0.2)).abs() < 1e-12);
        cover.cover(2.0, std::f64::consts::PI);
        assert!(free(&mut cover).is_empty());
    }
}
