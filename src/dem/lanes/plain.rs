//! Four numbers on any processor: what the others are checked against.

use super::{Lanes, Line, Triple, Wide};
use crate::num::Vec3;
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four numbers.
#[derive(Debug, Clone, Copy)]
pub struct Plain<const FUSED: bool = false>([f64; 4]);

macro_rules! operator {
    ($trait:ident, $name:ident, $sign:tt) => {
        impl<const FUSED: bool> $trait for Plain<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, o: Self) -> Self {
                let (a, b) = (self.0, o.0);
                Self([a[0] $sign b[0], a[1] $sign b[1], a[2] $sign b[2], a[3] $sign b[3]])
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<const FUSED: bool> Neg for Plain<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const FUSED: bool> Lanes for Plain<FUSED> {
    type Mask = [bool; 4];
    const FUSED: bool = FUSED;
    // `mul_add` rounds once everywhere; where the processor cannot do it, it is computed with integers, slowly.
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            return Self(from_fn(|l| a.0[l].mul_add(b.0[l], self.0[l])));
        }
        self + a * b
    }
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            return Self(from_fn(|l| (-a.0[l]).mul_add(b.0[l], self.0[l])));
        }
        self - a * b
    }
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; 4])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn below(self, other: Self) -> [bool; 4] {
        from_fn(|l| self.0[l] < other.0[l])
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> [bool; 4] {
        from_fn(|l| self.0[l] <= other.0[l])
    }
    #[inline(always)]
    fn pick(mask: [bool; 4], yes: Self, no: Self) -> Self {
        Self(from_fn(|l| if mask[l] { yes.0[l] } else { no.0[l] }))
    }
    #[inline(always)]
    fn both(a: [bool; 4], b: [bool; 4]) -> [bool; 4] {
        from_fn(|l| a[l] & b[l])
    }
    #[inline(always)]
    fn either(a: [bool; 4], b: [bool; 4]) -> [bool; 4] {
        from_fn(|l| a[l] | b[l])
    }
    #[inline(always)]
    fn not(a: [bool; 4]) -> [bool; 4] {
        a.map(|yes| !yes)
    }
    #[inline(always)]
    fn all(answer: bool) -> [bool; 4] {
        [answer; 4]
    }
    #[inline(always)]
    fn any(mask: [bool; 4]) -> bool {
        mask[0] | mask[1] | mask[2] | mask[3]
    }
}

impl<const FUSED: bool> Wide<4> for Plain<FUSED> {
    type Row = [f64; 8];
    #[inline(always)]
    fn row(line: &Line) -> [f64; 8] {
        line.0
    }
    #[inline(always)]
    fn keep(row: [f64; 8], line: &mut Line) {
        line.0 = row;
    }
    #[inline(always)]
    fn sum(a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        from_fn(|l| a[l] + b[l])
    }
    #[inline(always)]
    fn add_half(row: [f64; 8], line: &mut Line) {
        line.0.iter_mut().zip(&row[..4]).for_each(|(number, more)| *number += more);
    }
    #[inline(always)]
    fn signed_sum(a: [f64; 8], b: [f64; 8], signs: [f64; 8]) -> [f64; 8] {
        from_fn(|l| a[l] + b[l] * signs[l])
    }
    #[inline(always)]
    fn take_half(row: [f64; 8], line: &mut Line) {
        line.0.iter_mut().zip(&row[..4]).for_each(|(number, less)| *number -= less);
    }
    #[inline(always)]
    fn keep_six([a, b, c, _, d, e, f, _]: [f64; 8], values: &mut [Vec3; 2]) {
        *values = [Vec3::new(a, b, c), Vec3::new(d, e, f)];
    }
    #[inline(always)]
    fn difference(a: [f64; 8], b: [f64; 8]) -> [f64; 8] {
        from_fn(|l| a[l] - b[l])
    }
    #[inline(always)]
    fn columns(rows: [[f64; 8]; 4]) -> [Self; 8] {
        from_fn(|c| Self(from_fn(|l| rows[l][c])))
    }
    #[inline(always)]
    fn rows(columns: [Self; 8]) -> [[f64; 8]; 4] {
        from_fn(|l| from_fn(|c| columns[c].0[l]))
    }
    #[inline(always)]
    fn triples(values: [&Vec3; 4]) -> Triple<Self> {
        let axis = |axis: usize| Self(values.map(|v| v[axis]));
        Triple { x: axis(0), y: axis(1), z: axis(2) }
    }
    #[inline(always)]
    fn triple_sums(a: [&Vec3; 4], b: [&Vec3; 4]) -> Triple<Self> {
        Self::triples(a) + Self::triples(b)
    }
    #[inline(always)]
    fn three(value: &Vec3) -> Self {
        Self([value.x, value.y, value.z, 0.0])
    }
    #[inline(always)]
    fn keep_three(self, value: &mut Vec3) {
        *value = Vec3::new(self.0[0], self.0[1], self.0[2]);
    }
    #[inline(always)]
    fn rolled(self) -> Self {
        let [x, y, z, w] = self.0;
        Self([y, z, x, w])
    }
    #[inline(always)]
    fn load_single(values: &[f32; 4]) -> Self {
        Self(values.map(f64::from))
    }
    #[inline(always)]
    fn store_single(self, values: &mut [f32; 4]) {
        *values = self.0.map(|value| value as f32);
    }
    #[inline(always)]
    fn load(values: &[f64; 4]) -> Self {
        Self(*values)
    }
    #[inline(always)]
    fn store(self, values: &mut [f64; 4]) {
        *values = self.0;
    }
    #[inline(always)]
    fn bits(mask: [bool; 4]) -> u8 {
        (0..4).map(|l| u8::from(mask[l]) << l).sum()
    }
    #[inline(always)]
    fn mask(bits: u8) -> [bool; 4] {
        from_fn(|l| bits >> l & 1 == 1)
    }
}
