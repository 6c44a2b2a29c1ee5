//! The largest eigenvalue of a network of contacts, bounded from above by Lanczos' method: see [`super::network`].
//! About 45 products with the matrix, O(contacts) each; cannot fail.

use super::network::{Stepping, Strand};
use crate::num::random;
use nalgebra::{DMatrix, SymmetricEigen, Vector6};

/// Relative error of the largest eigenvalue allowed for.
const MISSED: f64 = 0.09;
/// Probability of a larger one.
const CHANCE: f64 = 1e-9;

/// All strands of a network, kept for many products with its matrix.
pub struct Chords {
    /// Effective stiffness of a step.
    pub stepping: Stepping,
    /// Seed of the model, for the start.
    pub seed: u64,
    /// Bodies that touch, numbered for this.
    pub size: usize,
    /// First and second body of each strand; the same twice at walls.
    pub strands: Vec<(u32, u32, Strand)>,
}

impl Chords {
    /// An upper bound of the largest eigenvalue at the effective stiffness of `step`; stops
    /// early once it is known to be above `enough`.
    pub fn top(&self, step: f64, enough: f64) -> f64 {
        let stiffness: Vec<f64> =
            self.strands.iter().map(|s| self.stepping.effective(&s.2, step)).collect();
        let size = 6.0 * self.size as f64;
        let needed = (1.648 * size.sqrt() / CHANCE).ln() / MISSED.sqrt();
        let most = (0.5 * (needed + 1.0)).ceil() as usize;
        let mut source = random::stream(self.seed, "network", 0);
        let mut now: Vec<Vector6<f64>> =
            (0..self.size).map(|_| Vector6::from_fn(|_, _| random::normal(&mut source))).collect();
        let scale = norm(&now);
        now.iter_mut().for_each(|v| *v /= scale);
        let mut before = vec![Vector6::zeros(); self.size];
        let (mut diagonal, mut beside) = (Vec::new(), Vec::<f64>::new());
        loop {
            let mut next = vec![Vector6::zeros(); self.size];
            for ((first, second, strand), k) in self.strands.iter().zip(&stiffness) {
                let (a, b) = (*first as usize, *second as usize);
                let pull = (strand.mine.dot(&now[a]) + strand.other.dot(&now[b])) * *k;
                next[a] += strand.mine * pull;
                next[b] += strand.other * pull;
            }
            let alpha: f64 = next.iter().zip(&now).map(|(x, y)| x.dot(y)).sum();
            let beta = beside.last().copied().unwrap_or(0.0);
            for ((x, y), z) in next.iter_mut().zip(&now).zip(&before) {
                *x -= y * alpha + z * beta;
            }
            diagonal.push(alpha);
            let rest = norm(&next);
            let done = diagonal.len() >= most;
            let exhausted = rest <= 1e-9 * diagonal.iter().fold(0.0, |a: f64, b| a.max(*b));
            if done || exhausted || diagonal.len() % 8 == 0 {
                let ritz = largest_of(&diagonal, &beside);
                if exhausted {
                    return ritz * (1.0 + 1e-6);
                }
                if done || ritz > enough {
                    return ritz / (1.0 - MISSED);
                }
            }
            beside.push(rest);
            next.iter_mut().for_each(|v| *v /= rest);
            before = std::mem::replace(&mut now, next);
        }
    }
}

fn norm(vector: &[Vector6<f64>]) -> f64 {
    vector.iter().map(Vector6::norm_squared).sum::<f64>().sqrt()
}

/// Largest eigenvalue of a symmetric tridiagonal matrix.
fn largest_of(diagonal: &[f64], beside: &[f64]) -> f64 {
    let size = diagonal.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    SymmetricEigen::new(matrix).eigenvalues.max()
}
