//! Several numbers as one: what the law of a contact is written in, so that it stands once
//! and runs on one contact (`f64`), on four or on eight side by side.
//!
//! Every operation is the one of IEEE 754 on each number by itself; none is reordered, and products are
//! added without rounding them first only where [`Lanes::plus_product`] and its like say so, in types that are `FUSED`.
//! So all widths give the same bytes, on every machine.
//!
//! [`Plain`] is four numbers on any processor, [`Four`] uses AVX2, [`Eight`] AVX-512. The scheme `leapfrog` takes
//! the fused ones for spheres (see [`super::setting::Setting::fused`]); the schemes of solvers do not, since these are not
//! compiled so, and `f64` is not fused.
//!
//! About `unsafe`: the vector instructions of a processor are `unsafe` to call where it is not known
//! to have them. `Four` and `Eight` are used in functions that are compiled for these instructions only
//! ([`super::contacts`]), and these are entered after the processor was asked. Reads and
//! writes go through references to arrays of the full length.

use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers side by side.
pub trait Lanes:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// One yes or no for each number.
    type Mask: Copy;
    /// Whether products are not rounded before they are added.
    const FUSED: bool = false;
    /// `self + a × b`, rounded once if `FUSED`.
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        self + a * b
    }
    /// `self − a × b`, rounded once if `FUSED`.
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        self - a * b
    }
    /// `value` everywhere.
    fn splat(value: f64) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
    /// Where these are below those.
    fn below(self, other: Self) -> Self::Mask;
    /// Where these are below those or equal.
    fn at_most(self, other: Self) -> Self::Mask;
    /// These where the mask says yes, elsewhere those.
    fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// These where the mask says yes, elsewhere 0.
    #[inline(always)]
    fn only(mask: Self::Mask, yes: Self) -> Self {
        Self::pick(mask, yes, Self::splat(0.0))
    }
    /// Where both say yes.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Where one or both say yes.
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Where it says no.
    fn not(a: Self::Mask) -> Self::Mask;
    /// The same answer everywhere.
    fn all(answer: bool) -> Self::Mask;
    /// Whether it says yes anywhere.
    fn any(mask: Self::Mask) -> bool;
}

impl Lanes for f64 {
    type Mask = bool;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn pick(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn both(a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn either(a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn not(a: bool) -> bool {
        !a
    }
    #[inline(always)]
    fn all(answer: bool) -> bool {
        answer
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
}

/// Vectors side by side, or in columns (see [`vectors`]).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Triple<L> {
    /// Component along x.
    pub x: L,
    /// Component along y.
    pub y: L,
    /// Component along z.
    pub z: L,
}

impl<A> Triple<A> {
    /// `change` of every component.
    #[inline(always)]
    pub fn map<B>(self, change: impl Fn(A) -> B) -> Triple<B> {
        Triple { x: change(self.x), y: change(self.y), z: change(self.z) }
    }
}

impl<L: Lanes> Triple<L> {
    /// 0 everywhere.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = L::splat(0.0);
        Self { x: zero, y: zero, z: zero }
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        (self.x * other.x).plus_product(self.y, other.y).plus_product(self.z, other.z)
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: (self.y * other.z).minus_product(self.z, other.y),
            y: (self.z * other.x).minus_product(self.x, other.z),
            z: (self.x * other.y).minus_product(self.y, other.x),
        }
    }

    /// `self + a × b`, a vector product.
    #[inline(always)]
    pub fn plus_cross(self, a: Self, b: Self) -> Self {
        if !L::FUSED {
            return self + a.cross(b);
        }
        Self {
            x: self.x.plus_product(a.y, b.z).minus_product(a.z, b.y),
            y: self.y.plus_product(a.z, b.x).minus_product(a.x, b.z),
            z: self.z.plus_product(a.x, b.y).minus_product(a.y, b.x),
        }
    }

    /// `self + vector × by`.
    #[inline(always)]
    pub fn plus_product(self, vector: Self, by: L) -> Self {
        Self {
            x: self.x.plus_product(vector.x, by),
            y: self.y.plus_product(vector.y, by),
            z: self.z.plus_product(vector.z, by),
        }
    }

    /// `self − vector × by`.
    #[inline(always)]
    pub fn minus_product(self, vector: Self, by: L) -> Self {
        Self {
            x: self.x.minus_product(vector.x, by),
            y: self.y.minus_product(vector.y, by),
            z: self.z.minus_product(vector.z, by),
        }
    }

    /// These where the mask says yes, elsewhere those.
    #[inline(always)]
    pub fn pick(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self {
            x: L::pick(mask, yes.x, no.x),
            y: L::pick(mask, yes.y, no.y),
            z: L::pick(mask, yes.z, no.z),
        }
    }

    /// These where the mask says yes, elsewhere 0.
    #[inline(always)]
    pub fn only(mask: L::Mask, yes: Self) -> Self {
        Self { x: L::only(mask, yes.x), y: L::only(mask, yes.y), z: L::only(mask, yes.z) }
    }
}

impl<L: Lanes> Add for Triple<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<L: Lanes> Sub for Triple<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<L: Lanes> Mul<L> for Triple<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: L) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl From<Vec3> for Triple<f64> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Triple<f64>> for Vec3 {
    #[inline(always)]
    fn from(v: Triple<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

/// Eight numbers of one sphere: a line of the cache.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Line(pub [f64; 8]);

/// `W` numbers of as many contacts, and how they are brought side by side.
pub trait Wide<const W: usize>: Lanes {
    /// A [`Line`].
    type Row: Copy;
    /// Reads a line.
    fn row(line: &Line) -> Self::Row;
    /// Writes a line.
    fn keep(row: Self::Row, line: &mut Line);
    /// Sum of two lines.
    fn sum(a: Self::Row, b: Self::Row) -> Self::Row;
    /// `a + b × signs`, `signs` of ±1 and 0, so that only the sum is rounded.
    fn signed_sum(a: Self::Row, b: Self::Row, signs: Self::Row) -> Self::Row;
    /// Adds the first four numbers of a row to those of a line.
    fn add_half(row: Self::Row, line: &mut Line);
    /// Takes the first four numbers of a row from those of a line.
    fn take_half(row: Self::Row, line: &mut Line);
    /// Writes the first three numbers and those after the fourth.
    fn keep_six(row: Self::Row, values: &mut [Vec3; 2]);
    /// Difference of two lines.
    fn difference(a: Self::Row, b: Self::Row) -> Self::Row;
    /// The first numbers of all lines, the second, ...
    fn columns(rows: [Self::Row; W]) -> [Self; 8];
    /// The lines that have these columns.
    fn rows(columns: [Self; 8]) -> [Self::Row; W];
    /// `W` vectors.
    fn triples(values: [&Vec3; W]) -> Triple<Self>;
    /// `W` sums of two vectors each.
    fn triple_sums(a: [&Vec3; W], b: [&Vec3; W]) -> Triple<Self>;
    /// The three numbers of a vector, then zeros.
    fn three(value: &Vec3) -> Self;
    /// Writes the first three numbers.
    fn keep_three(self, value: &mut Vec3);
    /// The second, third and first of the first three numbers.
    fn rolled(self) -> Self;
    /// Vector product of the first three numbers.
    #[inline(always)]
    fn cross_three(self, other: Self) -> Self {
        (self * other.rolled() - self.rolled() * other).rolled()
    }
    /// `W` numbers in single precision that follow each other.
    fn load_single(values: &[f32; W]) -> Self;
    /// Writes them, rounded to the nearest.
    fn store_single(self, values: &mut [f32; W]);
    /// `W` numbers that follow each other.
    fn load(values: &[f64; W]) -> Self;
    /// Writes them.
    fn store(self, values: &mut [f64; W]);
    /// The mask as bits, the first number lowest.
    fn bits(mask: Self::Mask) -> u8;
    /// The mask with these bits.
    fn mask(bits: u8) -> Self::Mask;
}

mod plain;
mod vectors;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use plain::Plain;
#[cfg(target_arch = "x86_64")]
pub use x86::{Eight, Four};

#[cfg(test)]
mod tests {
    use super::*;

    fn crossed<const W: usize, L: Wide<W>>(a: &Vec3, b: &Vec3) -> [u64; 3] {
        let mut product = Vec3::zeros();
        L::three(a).cross_three(L::three(b)).keep_three(&mut product);
        [0, 1, 2].map(|axis| product[axis].to_bits())
    }

    #[test]
    fn vector_products_have_the_bits_of_one_vector_alone() {
        let (a, b) = (Vec3::new(0.1, -2.7, 3e-5), Vec3::new(-7.3, 0.9, 1e3));
        let expected = [0, 1, 2].map(|axis| a.cross(&b)[axis].to_bits());
        assert_eq!(crossed::<4, Plain>(&a, &b), expected);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                assert_eq!(crossed::<4, Four>(&a, &b), expected);
            }
            if is_x86_feature_detected!("avx512f") {
                assert_eq!(crossed::<8, Eight>(&a, &b), expected);
            }
        }
    }

    /// `a + b × c`, `a − b × c`, then for the vectors v = (a, b, c) and w = (c, a, b) v·w, v × w, and (b, b, a) + v × w.
    fn products<const W: usize, L: Wide<W>>([a, b, c]: [f64; 3]) -> [Vec<u64>; W] {
        let number = |value: f64| L::load(&[value; W]);
        let [l, m, n] = [a, b, c].map(number);
        let (v, w) = (Triple { x: l, y: m, z: n }, Triple { x: n, y: l, z: m });
        let (cross, more) = (v.cross(w), Triple { x: m, y: m, z: l }.plus_cross(v, w));
        let all = [l.plus_product(m, n), l.minus_product(m, n), v.dot(w)];
        let lanes = [all, [cross.x, cross.y, cross.z], [more.x, more.y, more.z]];
        let mut found = std::array::from_fn(|_| Vec::new());
        for lane in lanes.as_flattened() {
            let mut numbers = [0.0; W];
            lane.store(&mut numbers);
            found.iter_mut().zip(numbers).for_each(|(all, one)| all.push(one.to_bits()));
        }
        found
    }

    #[test]
    fn fused_products_are_rounded_once_and_others_twice() {
        let (a, b, c): (f64, f64, f64) = (-4.7, 0.93, 5.1);
        let all = [
            a + b * c,
            a - b * c,
            a * c + b * a + c * b,
            b * b - c * a,
            c * c - a * b,
            a * a - b * c,
            b + (b * b - c * a),
            b + (c * c - a * b),
            a + (a * a - b * c),
        ];
        let rounded = all.map(f64::to_bits).to_vec();
        let all = [
            b.mul_add(c, a),
            (-b).mul_add(c, a),
            c.mul_add(b, b.mul_add(a, a * c)),
            (-c).mul_add(a, b * b),
            (-a).mul_add(b, c * c),
            (-b).mul_add(c, a * a),
            (-c).mul_add(a, b.mul_add(b, b)),
            (-a).mul_add(b, c.mul_add(c, b)),
            (-b).mul_add(c, a.mul_add(a, a)),
        ];
        let once = all.map(f64::to_bits).to_vec();
        assert!(rounded.iter().zip(&once).filter(|(a, b)| a != b).count() > 6);
        assert_eq!(products::<4, Plain>([a, b, c]), [(); 4].map(|()| rounded.clone()));
        assert_eq!(products::<4, Plain<true>>([a, b, c]), [(); 4].map(|()| once.clone()));
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                assert_eq!(products::<4, Four>([a, b, c]), [(); 4].map(|()| rounded.clone()));
                assert_eq!(products::<4, Four<true>>([a, b, c]), [(); 4].map(|()| once.clone()));
            }
            if is_x86_feature_detected!("avx512f") {
                assert_eq!(products::<8, Eight>([a, b, c]), [(); 8].map(|()| rounded.clone()));
                assert_eq!(products::<8, Eight<true>>([a, b, c]), [(); 8].map(|()| once.clone()));
            }
        }
    }
}
