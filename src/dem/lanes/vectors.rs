//! Vectors in three columns, one a component: the sweeps read several of them side by side without
//! turning them. One vector at a time goes in and out here, groups of them in [`super::super::contacts`].

use super::Triple;
use crate::num::Vec3;
use std::ops::{Deref, DerefMut, Range};

impl Triple<Vec<f64>> {
    /// `count` vectors of 0.
    pub fn zeros(count: usize) -> Self {
        Self { x: vec![0.0; count], y: vec![0.0; count], z: vec![0.0; count] }
    }
}

impl<C> Triple<C> {
    /// All three columns.
    pub fn all(&self) -> [&C; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// All three columns, to be written.
    pub fn all_mut(&mut self) -> [&mut C; 3] {
        [&mut self.x, &mut self.y, &mut self.z]
    }
}

impl<C: Deref<Target = [f64]>> Triple<C> {
    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Vector `k`.
    #[inline(always)]
    pub fn at(&self, k: usize) -> Vec3 {
        Vec3::new(self.x[k], self.y[k], self.z[k])
    }

    /// Vector `k`, if it is there.
    pub fn get(&self, k: usize) -> Option<Vec3> {
        (k < self.len()).then(|| self.at(k))
    }

    /// One vector after the other.
    pub fn iter(&self) -> impl Iterator<Item = Vec3> {
        (0..self.len()).map(|k| self.at(k))
    }
}

impl<C: DerefMut<Target = [f64]>> Triple<C> {
    /// Writes vector `k`.
    #[inline(always)]
    pub fn put(&mut self, k: usize, value: Vec3) {
        (self.x[k], self.y[k], self.z[k]) = (value.x, value.y, value.z);
    }

    /// The columns as slices.
    #[inline(always)]
    pub fn view(&mut self) -> Triple<&mut [f64]> {
        Triple { x: &mut self.x, y: &mut self.y, z: &mut self.z }
    }

    /// Writes as many vectors of `other`.
    #[inline(always)]
    pub fn copy(&mut self, to: Range<usize>, other: &Triple<&mut [f64]>, from: Range<usize>) {
        self.x[to.clone()].copy_from_slice(&other.x[from.clone()]);
        self.y[to.clone()].copy_from_slice(&other.y[from.clone()]);
        self.z[to].copy_from_slice(&other.z[from]);
    }
}

impl Triple<&mut [f64]> {
    /// The first `at` vectors and the rest; without vectors twice none.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let at = at.min(self.len());
        let ((a, x), (b, y), (c, z)) =
            (self.x.split_at_mut(at), self.y.split_at_mut(at), self.z.split_at_mut(at));
        (Self { x: a, y: b, z: c }, Self { x, y, z })
    }
}
