//! Four numbers with AVX2, eight with AVX-512. See [`super`] about `unsafe`.

use super::{Lanes, Line, Triple, Wide};
use crate::num::Vec3;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four numbers in an AVX2 register.
#[derive(Debug, Clone, Copy)]
pub struct Four<const FUSED: bool = false>(__m256d);

/// Eight numbers in an AVX-512 register.
#[derive(Debug, Clone, Copy)]
pub struct Eight<const FUSED: bool = false>(__m512d);

macro_rules! operators {
    ($type:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $xor:ident, $set:ident) => {
        impl<const FUSED: bool> Add for $type<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: as all others in this file, see the top of `lanes`.
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl<const FUSED: bool> Sub for $type<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $sub(self.0, other.0) })
            }
        }
        impl<const FUSED: bool> Mul for $type<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        impl<const FUSED: bool> Div for $type<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $div(self.0, other.0) })
            }
        }
        impl<const FUSED: bool> Neg for $type<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see above.
                Self(unsafe { $xor(self.0, $set(-0.0)) })
            }
        }
    };
}
operators!(
    Four,
    _mm256_add_pd,
    _mm256_sub_pd,
    _mm256_mul_pd,
    _mm256_div_pd,
    _mm256_xor_pd,
    _mm256_set1_pd
);
operators!(
    Eight,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_div_pd,
    _mm512_xor_pd,
    _mm512_set1_pd
);

impl<const FUSED: bool> Lanes for Four<FUSED> {
    type Mask = __m256d;
    const FUSED: bool = FUSED;
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            // SAFETY: see above.
            return Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) });
        }
        self + a * b
    }
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            // SAFETY: see above.
            return Self(unsafe { _mm256_fnmadd_pd(a.0, b.0, self.0) });
        }
        self - a * b
    }
    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_set1_pd(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn below(self, other: Self) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn pick(mask: __m256d, yes: Self, no: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask) })
    }
    #[inline(always)]
    fn only(mask: __m256d, yes: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_and_pd(yes.0, mask) })
    }
    #[inline(always)]
    fn both(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_and_pd(a, b) }
    }
    #[inline(always)]
    fn either(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_or_pd(a, b) }
    }
    #[inline(always)]
    fn not(a: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_xor_pd(a, Self::all(true)) }
    }
    #[inline(always)]
    fn all(answer: bool) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_castsi256_pd(_mm256_set1_epi64x(-i64::from(answer))) }
    }
    #[inline(always)]
    fn any(mask: __m256d) -> bool {
        // SAFETY: see above.
        unsafe { _mm256_movemask_pd(mask) != 0 }
    }
}

/// Four vectors of four numbers, of which the first three are wanted, turned.
#[inline(always)]
fn turn4(r: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: see above.
    unsafe {
        let (a, b) = (_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpackhi_pd(r[0], r[1]));
        let (c, d) = (_mm256_unpacklo_pd(r[2], r[3]), _mm256_unpackhi_pd(r[2], r[3]));
        [
            _mm256_permute2f128_pd::<0x20>(a, c),
            _mm256_permute2f128_pd::<0x20>(b, d),
            _mm256_permute2f128_pd::<0x31>(a, c),
            _mm256_permute2f128_pd::<0x31>(b, d),
        ]
    }
}

/// Three numbers and a 0.
#[inline(always)]
fn three(value: &Vec3) -> __m256d {
    // SAFETY: see above; the mask keeps the read within the vector.
    unsafe { _mm256_maskload_pd(value.as_ptr(), _mm256_set_epi64x(0, -1, -1, -1)) }
}

impl<const FUSED: bool> Wide<4> for Four<FUSED> {
    type Row = [__m256d; 2];
    #[inline(always)]
    fn row(line: &Line) -> Self::Row {
        // SAFETY: see above.
        unsafe { [_mm256_loadu_pd(line.0.as_ptr()), _mm256_loadu_pd(line.0[4..].as_ptr())] }
    }
    #[inline(always)]
    fn keep(row: Self::Row, line: &mut Line) {
        // SAFETY: see above.
        unsafe {
            _mm256_storeu_pd(line.0.as_mut_ptr(), row[0]);
            _mm256_storeu_pd(line.0[4..].as_mut_ptr(), row[1]);
        }
    }
    #[inline(always)]
    fn sum(a: Self::Row, b: Self::Row) -> Self::Row {
        // SAFETY: see above.
        unsafe { [_mm256_add_pd(a[0], b[0]), _mm256_add_pd(a[1], b[1])] }
    }
    #[inline(always)]
    fn add_half(row: Self::Row, line: &mut Line) {
        let at = line.0.as_mut_ptr();
        // SAFETY: see above; four of eight numbers.
        unsafe { _mm256_storeu_pd(at, _mm256_add_pd(_mm256_loadu_pd(at), row[0])) }
    }
    #[inline(always)]
    fn signed_sum(a: Self::Row, b: Self::Row, signs: Self::Row) -> Self::Row {
        // SAFETY: see above.
        unsafe { [_mm256_fmadd_pd(b[0], signs[0], a[0]), _mm256_fmadd_pd(b[1], signs[1], a[1])] }
    }
    #[inline(always)]
    fn take_half(row: Self::Row, line: &mut Line) {
        let at = line.0.as_mut_ptr();
        // SAFETY: see above; four of eight numbers.
        unsafe { _mm256_storeu_pd(at, _mm256_sub_pd(_mm256_loadu_pd(at), row[0])) }
    }
    #[inline(always)]
    fn keep_six(row: Self::Row, values: &mut [Vec3; 2]) {
        let at = values.as_mut_ptr().cast::<f64>();
        // SAFETY: see above; two vectors are six numbers.
        unsafe {
            // The fifth, the sixth, and at the end the fourth that is wanted.
            let turned = _mm256_permute4x64_pd::<0b00_10_10_01>(row[1]);
            _mm256_storeu_pd(at, _mm256_blend_pd::<0b1000>(row[0], turned));
            _mm_storeu_pd(at.add(4), _mm256_castpd256_pd128(turned));
        }
    }
    #[inline(always)]
    fn difference(a: Self::Row, b: Self::Row) -> Self::Row {
        // SAFETY: see above.
        unsafe { [_mm256_sub_pd(a[0], b[0]), _mm256_sub_pd(a[1], b[1])] }
    }
    #[inline(always)]
    fn columns(r: [Self::Row; 4]) -> [Self; 8] {
        let [a, b, c, d] = turn4([r[0][0], r[1][0], r[2][0], r[3][0]]);
        let [e, f, g, h] = turn4([r[0][1], r[1][1], r[2][1], r[3][1]]);
        [Self(a), Self(b), Self(c), Self(d), Self(e), Self(f), Self(g), Self(h)]
    }
    #[inline(always)]
    fn rows(c: [Self; 8]) -> [Self::Row; 4] {
        let low = turn4([c[0].0, c[1].0, c[2].0, c[3].0]);
        let high = turn4([c[4].0, c[5].0, c[6].0, c[7].0]);
        [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]], [low[3], high[3]]]
    }
    #[inline(always)]
    fn triples(v: [&Vec3; 4]) -> Triple<Self> {
        let [x, y, z, _] = turn4([three(v[0]), three(v[1]), three(v[2]), three(v[3])]);
        Triple { x: Self(x), y: Self(y), z: Self(z) }
    }
    #[inline(always)]
    fn triple_sums(a: [&Vec3; 4], b: [&Vec3; 4]) -> Triple<Self> {
        // SAFETY: see above.
        let r = unsafe {
            [
                _mm256_add_pd(three(a[0]), three(b[0])),
                _mm256_add_pd(three(a[1]), three(b[1])),
                _mm256_add_pd(three(a[2]), three(b[2])),
                _mm256_add_pd(three(a[3]), three(b[3])),
            ]
        };
        let [x, y, z, _] = turn4(r);
        Triple { x: Self(x), y: Self(y), z: Self(z) }
    }
    #[inline(always)]
    fn three(value: &Vec3) -> Self {
        Self(three(value))
    }
    #[inline(always)]
    fn keep_three(self, value: &mut Vec3) {
        let at = value.as_mut_ptr();
        // SAFETY: see above; two numbers and one.
        unsafe {
            _mm_storeu_pd(at, _mm256_castpd256_pd128(self.0));
            _mm_store_sd(at.add(2), _mm256_extractf128_pd::<1>(self.0));
        }
    }
    #[inline(always)]
    fn rolled(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_permute4x64_pd::<0b11_00_10_01>(self.0) })
    }
    #[inline(always)]
    fn load_single(values: &[f32; 4]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_cvtps_pd(_mm_loadu_ps(values.as_ptr())) })
    }
    #[inline(always)]
    fn store_single(self, values: &mut [f32; 4]) {
        // SAFETY: see above.
        unsafe { _mm_storeu_ps(values.as_mut_ptr(), _mm256_cvtpd_ps(self.0)) }
    }
    #[inline(always)]
    fn load(values: &[f64; 4]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_loadu_pd(values.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, values: &mut [f64; 4]) {
        // SAFETY: see above.
        unsafe { _mm256_storeu_pd(values.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn bits(mask: __m256d) -> u8 {
        // SAFETY: see above. Four bits.
        unsafe { _mm256_movemask_pd(mask) as u8 }
    }
    #[inline(always)]
    fn mask(bits: u8) -> __m256d {
        // SAFETY: see above.
        unsafe {
            let each = _mm256_set_epi64x(8, 4, 2, 1);
            let mine = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), each);
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(mine, each))
        }
    }
}

impl<const FUSED: bool> Lanes for Eight<FUSED> {
    type Mask = __mmask8;
    const FUSED: bool = FUSED;
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            // SAFETY: see above.
            return Self(unsafe { _mm512_fmadd_pd(a.0, b.0, self.0) });
        }
        self + a * b
    }
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        if FUSED {
            // SAFETY: see above.
            return Self(unsafe { _mm512_fnmadd_pd(a.0, b.0, self.0) });
        }
        self - a * b
    }
    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn below(self, other: Self) -> __mmask8 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> __mmask8 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn pick(mask: __mmask8, yes: Self, no: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }
    #[inline(always)]
    fn only(mask: __mmask8, yes: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_maskz_mov_pd(mask, yes.0) })
    }
    #[inline(always)]
    fn both(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline(always)]
    fn either(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }
    #[inline(always)]
    fn not(a: __mmask8) -> __mmask8 {
        !a
    }
    #[inline(always)]
    fn all(answer: bool) -> __mmask8 {
        if answer { 0xff } else { 0 }
    }
    #[inline(always)]
    fn any(mask: __mmask8) -> bool {
        mask != 0
    }
}

/// Every other column of eight lines, of which pairs of numbers stand side by side.
#[inline(always)]
fn gather(r: [__m512d; 4]) -> [__m512d; 4] {
    // SAFETY: see above.
    unsafe {
        let (a, b) =
            (_mm512_shuffle_f64x2::<0x88>(r[0], r[1]), _mm512_shuffle_f64x2::<0x88>(r[2], r[3]));
        let (c, d) =
            (_mm512_shuffle_f64x2::<0xdd>(r[0], r[1]), _mm512_shuffle_f64x2::<0xdd>(r[2], r[3]));
        [
            _mm512_shuffle_f64x2::<0x88>(a, b),
            _mm512_shuffle_f64x2::<0x88>(c, d),
            _mm512_shuffle_f64x2::<0xdd>(a, b),
            _mm512_shuffle_f64x2::<0xdd>(c, d),
        ]
    }
}

/// Eight lines turned: an 8 × 8 transpose.
#[inline(always)]
fn turn8(r: [__m512d; 8]) -> [__m512d; 8] {
    // SAFETY: see above.
    let (even, odd) = unsafe {
        (
            gather([
                _mm512_unpacklo_pd(r[0], r[1]),
                _mm512_unpacklo_pd(r[2], r[3]),
                _mm512_unpacklo_pd(r[4], r[5]),
                _mm512_unpacklo_pd(r[6], r[7]),
            ]),
            gather([
                _mm512_unpackhi_pd(r[0], r[1]),
                _mm512_unpackhi_pd(r[2], r[3]),
                _mm512_unpackhi_pd(r[4], r[5]),
                _mm512_unpackhi_pd(r[6], r[7]),
            ]),
        )
    };
    [even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]]
}

/// Eight vectors of four numbers turned; the fourth numbers are dropped.
#[inline(always)]
fn turn3<const FUSED: bool>(r: [__m256d; 8]) -> Triple<Eight<FUSED>> {
    // SAFETY: see above.
    unsafe {
        let (a, b) = (join(r[0], r[2]), join(r[1], r[3]));
        let (c, d) = (join(r[4], r[6]), join(r[5], r[7]));
        let (e, f) = (_mm512_unpacklo_pd(a, b), _mm512_unpacklo_pd(c, d));
        let (g, h) = (_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d));
        Triple {
            x: Eight(_mm512_shuffle_f64x2::<0x88>(e, f)),
            y: Eight(_mm512_shuffle_f64x2::<0x88>(g, h)),
            z: Eight(_mm512_shuffle_f64x2::<0xdd>(e, f)),
        }
    }
}

#[inline(always)]
fn join(low: __m256d, high: __m256d) -> __m512d {
    // SAFETY: see above.
    unsafe { _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high) }
}

/// Three numbers and a 0.
#[inline(always)]
fn masked(value: &Vec3) -> __m256d {
    // SAFETY: see above; the mask keeps the read within the vector.
    unsafe { _mm256_maskz_loadu_pd(0b111, value.as_ptr()) }
}

impl<const FUSED: bool> Wide<8> for Eight<FUSED> {
    type Row = __m512d;
    #[inline(always)]
    fn row(line: &Line) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_loadu_pd(line.0.as_ptr()) }
    }
    #[inline(always)]
    fn keep(row: __m512d, line: &mut Line) {
        // SAFETY: see above.
        unsafe { _mm512_storeu_pd(line.0.as_mut_ptr(), row) }
    }
    #[inline(always)]
    fn sum(a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_add_pd(a, b) }
    }
    #[inline(always)]
    fn add_half(row: __m512d, line: &mut Line) {
        let at = line.0.as_mut_ptr();
        // SAFETY: see above; four of eight numbers.
        unsafe {
            let half = _mm512_castpd512_pd256(row);
            _mm256_storeu_pd(at, _mm256_add_pd(_mm256_loadu_pd(at), half));
        }
    }
    #[inline(always)]
    fn signed_sum(a: __m512d, b: __m512d, signs: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_fmadd_pd(b, signs, a) }
    }
    #[inline(always)]
    fn take_half(row: __m512d, line: &mut Line) {
        let at = line.0.as_mut_ptr();
        // SAFETY: see above; four of eight numbers.
        unsafe {
            let half = _mm512_castpd512_pd256(row);
            _mm256_storeu_pd(at, _mm256_sub_pd(_mm256_loadu_pd(at), half));
        }
    }
    #[inline(always)]
    fn keep_six(row: __m512d, values: &mut [Vec3; 2]) {
        let at = values.as_mut_ptr().cast::<f64>();
        // SAFETY: see above; two vectors are six numbers.
        unsafe {
            let six = _mm512_maskz_compress_pd(0b0111_0111, row);
            _mm256_storeu_pd(at, _mm512_castpd512_pd256(six));
            _mm_storeu_pd(at.add(4), _mm512_extractf64x2_pd::<2>(six));
        }
    }
    #[inline(always)]
    fn difference(a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: see above.
        unsafe { _mm512_sub_pd(a, b) }
    }
    #[inline(always)]
    fn columns(rows: [__m512d; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = turn8(rows);
        [Self(a), Self(b), Self(c), Self(d), Self(e), Self(f), Self(g), Self(h)]
    }
    #[inline(always)]
    fn rows(c: [Self; 8]) -> [__m512d; 8] {
        turn8([c[0].0, c[1].0, c[2].0, c[3].0, c[4].0, c[5].0, c[6].0, c[7].0])
    }
    #[inline(always)]
    fn triples(v: [&Vec3; 8]) -> Triple<Self> {
        turn3([
            masked(v[0]),
            masked(v[1]),
            masked(v[2]),
            masked(v[3]),
            masked(v[4]),
            masked(v[5]),
            masked(v[6]),
            masked(v[7]),
        ])
    }
    #[inline(always)]
    fn triple_sums(a: [&Vec3; 8], b: [&Vec3; 8]) -> Triple<Self> {
        // SAFETY: see above.
        unsafe {
            turn3([
                _mm256_add_pd(masked(a[0]), masked(b[0])),
                _mm256_add_pd(masked(a[1]), masked(b[1])),
                _mm256_add_pd(masked(a[2]), masked(b[2])),
                _mm256_add_pd(masked(a[3]), masked(b[3])),
                _mm256_add_pd(masked(a[4]), masked(b[4])),
                _mm256_add_pd(masked(a[5]), masked(b[5])),
                _mm256_add_pd(masked(a[6]), masked(b[6])),
                _mm256_add_pd(masked(a[7]), masked(b[7])),
            ])
        }
    }
    #[inline(always)]
    fn three(value: &Vec3) -> Self {
        // SAFETY: see above; the mask keeps the read within the vector.
        Self(unsafe { _mm512_maskz_loadu_pd(0b111, value.as_ptr()) })
    }
    #[inline(always)]
    fn keep_three(self, value: &mut Vec3) {
        // SAFETY: see above.
        unsafe { _mm512_mask_storeu_pd(value.as_mut_ptr(), 0b111, self.0) }
    }
    #[inline(always)]
    fn rolled(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_permutex_pd::<0b11_00_10_01>(self.0) })
    }
    #[inline(always)]
    fn load_single(values: &[f32; 8]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_cvtps_pd(_mm256_loadu_ps(values.as_ptr())) })
    }
    #[inline(always)]
    fn store_single(self, values: &mut [f32; 8]) {
        // SAFETY: see above.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), _mm512_cvtpd_ps(self.0)) }
    }
    #[inline(always)]
    fn load(values: &[f64; 8]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_loadu_pd(values.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, values: &mut [f64; 8]) {
        // SAFETY: see above.
        unsafe { _mm512_storeu_pd(values.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn bits(mask: __mmask8) -> u8 {
        mask
    }
    #[inline(always)]
    fn mask(bits: u8) -> __mmask8 {
        bits
    }
}
