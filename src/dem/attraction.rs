//! Central forces besides the contact spring, each with its potential energy.
//!
//! Symbols: h gap between the surfaces [m], negative in contact; r distance of the centres
//! [m]; R₁, R₂ radii [m]; R* = R₁R₂/(R₁+R₂) (R₁ at a plane); F [N] positive when pushing apart;
//! U [J], F = −dU/dh, 0 at the cut-off.
//!
//! - linear cohesion: F = −F₀ for h ≤ 0, −F₀ (1 − h/D) for 0 < h < D.
//! - sjkr: F = −k A, A = −π/4 (r²−(R₁+R₂)²)(r²−(R₁−R₂)²)/r², at a plane A = π (R²−r²)
//!   (LIGGGHTS-PUBLIC 3.8.0 `cohesion sjkr`); sjkr2: A = 4 π R* δ, at a plane 2 π R δ (`sjkr2`).
//! - DMT: F = −2 π w R* for h ≤ 0 (Derjaguin, Muller & Toporov 1975); JKR: the pull-off force
//!   3/2 π w R* (Johnson, Kendall & Roberts 1971) instead.
//! - liquid bridge: F = −2 π R γ cos θ / (1 + 2.1 s + 10 s²), s = (h/2) √(R/V), R = 2 R*
//!   (Willett, Adams, Johnson & Seville 2000, Langmuir 16, 9396, closed-form fit for small V); for
//!   h < 0 as at h = 0. Breaks at (1 + θ/2) V^⅓ (Lian, Thornton & Adams 1993).
//! - van der Waals (Hamaker 1937): U = −A/6 (p/X + p/Y + ln(X/Y)), F = −4 A r p³/(3 X² Y²) with
//!   p = 2 R₁R₂, X = r² − (R₁+R₂)², Y = r² − (R₁−R₂)²; at a plane
//!   U = −A/6 (R/h + R/(h+2R) + ln(h/(h+2R))), F = −2 A R³/(3 h² (h+2R)²). Below the least gap
//!   F stays what it is there.
//! - Born–Mayer (1932): U = B exp(−h/ρ). Lennard-Jones (1931): U = 4 ε ((σ/r)¹² − (σ/r)⁶).
//! - charges: U = q₁q₂/(4 π ε₀ ε r).
//!
//! Cut-off at c: U(h) − U(c), and with the shifted force F(h) − F(c), U(h) − U(c) + (h − c) F(c)
//! (Toxvaerd & Dyre 2011). O(1); cannot fail: parameters are checked before.

use crate::model::extra::{
    BornMayer, Bridge, Cohesion, CutOff, LennardJones, PairForces, VanDerWaals,
};
use std::f64::consts::PI;
use std::ops::{Add, AddAssign};

/// Coulomb's constant 1/(4 π ε₀), N m²/C² (CODATA 2018).
pub const COULOMB: f64 = 8.987_551_792_261_171e9;

/// A central force and its potential energy.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Central {
    /// Force, N, positive when pushing apart.
    pub push: f64,
    /// Potential energy, J.
    pub energy: f64,
}

impl Add for Central {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { push: self.push + other.push, energy: self.energy + other.energy }
    }
}

impl AddAssign for Central {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Two surfaces: radii (infinite for a plane) and gap, m.
#[derive(Debug, Clone, Copy)]
pub struct Between {
    /// Radius of the sphere.
    pub first: f64,
    /// Radius of the other sphere; infinite for a plane.
    pub second: f64,
    /// Gap, negative in contact.
    pub gap: f64,
}

impl Between {
    fn plane(&self) -> bool {
        self.second.is_infinite()
    }

    /// R₁R₂/(R₁+R₂), R₁ at a plane.
    pub fn reduced(&self) -> f64 {
        if self.plane() {
            self.first
        } else {
            self.first * self.second / (self.first + self.second)
        }
    }

    /// The same surfaces at another gap.
    pub fn at(&self, gap: f64) -> Self {
        Self { gap, ..*self }
    }
}

/// Sum of all laws of a pair that act at this gap; `bridged` says whether a liquid bridge is there.
pub fn total(forces: &PairForces, between: &Between, bridged: bool) -> Central {
    sum(forces, between, bridged, bridge)
}

/// The force of [`total`] alone, N: the energy of a bridge costs more than its force.
pub fn push(forces: &PairForces, between: &Between, bridged: bool) -> f64 {
    let bare = |law: &Bridge, b: &Between| Central { push: bridge_push(law, b), energy: 0.0 };
    sum(forces, between, bridged, bare).push
}

fn sum(
    forces: &PairForces,
    between: &Between,
    bridged: bool,
    bridge: impl Fn(&Bridge, &Between) -> Central,
) -> Central {
    let mut sum = Central::default();
    if let Some(law) = &forces.cohesion {
        sum += cohesion(law, between);
    }
    if let (Some(law), true) = (&forces.bridge, bridged) {
        sum += bridge(law, between);
    }
    if let Some(law) = &forces.van_der_waals {
        sum += van_der_waals(law, between);
    }
    if let Some(law) = &forces.born_mayer {
        sum += born_mayer(law, between);
    }
    if let (Some(law), false) = (&forces.lennard_jones, between.plane()) {
        sum += lennard_jones(law, between.first + between.second + between.gap);
    }
    sum
}

/// Gap beyond which no law of a pair of spheres acts, m.
pub fn reach(forces: &PairForces, first: f64, second: f64) -> f64 {
    let mut reach = 0.0f64;
    if let Some(Cohesion::Linear { range, .. }) = forces.cohesion {
        reach = reach.max(range.0);
    }
    if let Some(law) = &forces.bridge {
        reach = reach.max(law.rupture());
    }
    if let Some(law) = &forces.van_der_waals {
        reach = reach.max(law.cutoff.0);
    }
    if let Some(law) = &forces.born_mayer {
        reach = reach.max(law.cutoff.0);
    }
    if let Some(law) = &forces.lennard_jones {
        reach = reach.max(law.cutoff.0 - first - second);
    }
    reach
}

/// Largest stiffness |dF/dh| of the laws of a pair, N/m, for the step limit. That of
/// Lennard-Jones is taken at 0.9 σ, inside which pairs with less than 5 ε do not come.
pub fn stiffness(forces: &PairForces, first: f64, second: f64) -> f64 {
    let between = Between { first, second, gap: 0.0 };
    let slope =
        |law: &dyn Fn(f64) -> f64, at: f64, step: f64| ((law(at + step) - law(at)) / step).abs();
    let mut sum = 0.0;
    match forces.cohesion {
        Some(Cohesion::Linear { pull, range }) => sum += pull.0 / range.0,
        Some(Cohesion::Sjkr2 { energy_density }) => {
            sum += energy_density.0 * 4.0 * PI * between.reduced();
        }
        Some(law @ Cohesion::Sjkr { .. }) => {
            let small = 1e-3 * between.reduced();
            sum += slope(&|gap| cohesion(&law, &between.at(gap)).push, -small, small);
        }
        Some(Cohesion::Dmt { .. } | Cohesion::Jkr { .. }) | None => {}
    }
    if let Some(law) = &forces.bridge {
        let small = 1e-4 * law.rupture();
        sum += slope(&|gap| bridge(law, &between.at(gap)).push, 0.0, small);
    }
    if let Some(law) = &forces.van_der_waals {
        let (least, small) = (law.least_gap.0, 1e-4 * law.least_gap.0);
        sum += slope(&|gap| van_der_waals(law, &between.at(gap)).push, least, small);
    }
    if let Some(law) = &forces.born_mayer {
        sum += law.strength.0 / law.decay.0.powi(2);
    }
    if let Some(law) = &forces.lennard_jones {
        let (at, small) = (0.9 * law.size.0, 1e-5 * law.size.0);
        sum += slope(&|r| lennard_jones(law, r).push, at, small);
    }
    sum
}

/// dF/dh at this gap, N/m, by a difference over a thousandth of the shortest length of the laws.
pub fn slope(forces: &PairForces, between: &Between, bridged: bool) -> f64 {
    let range = match forces.cohesion {
        Some(Cohesion::Linear { range, .. }) => range.0,
        _ => f64::INFINITY,
    };
    let rupture = forces.bridge.map_or(f64::INFINITY, |law| law.rupture());
    let least = forces.van_der_waals.map_or(f64::INFINITY, |law| law.least_gap.0);
    let decay = forces.born_mayer.map_or(f64::INFINITY, |law| law.decay.0);
    let step = 1e-3 * between.first.min(range).min(rupture).min(least).min(decay);
    let at = |gap: f64| push(forces, &between.at(gap), bridged);
    (at(between.gap + step) - at(between.gap - step)) / (2.0 * step)
}

fn cohesion(law: &Cohesion, b: &Between) -> Central {
    let gap = b.gap;
    let steady = |pull: f64| match gap {
        h if h <= 0.0 => Central { push: -pull, energy: pull * h },
        _ => Central::default(),
    };
    match law {
        Cohesion::Linear { pull, range } => {
            let (pull, range) = (pull.0, range.0);
            if gap <= 0.0 {
                Central { push: -pull, energy: pull * (gap - 0.5 * range) }
            } else if gap < range {
                let left = range - gap;
                Central { push: -pull * left / range, energy: -0.5 * pull * left * left / range }
            } else {
                Central::default()
            }
        }
        _ if gap >= 0.0 => Central::default(),
        Cohesion::Sjkr { energy_density } => sjkr(energy_density.0, b),
        Cohesion::Sjkr2 { energy_density } => {
            let slope = energy_density.0 * if b.plane() { 2.0 } else { 4.0 } * PI * b.reduced();
            Central { push: slope * gap, energy: -0.5 * slope * gap * gap }
        }
        Cohesion::Dmt { work } => steady(2.0 * PI * work.0 * b.reduced()),
        Cohesion::Jkr { work } => steady(1.5 * PI * work.0 * b.reduced()),
    }
}

fn sjkr(density: f64, b: &Between) -> Central {
    if b.plane() {
        let (radius, r) = (b.first, b.first + b.gap);
        let area = (radius * radius - r * r) * PI;
        // ∫ A dr from contact.
        let whole = |r: f64| PI * (radius * radius * r - r.powi(3) / 3.0);
        return Central { push: -density * area, energy: density * (whole(r) - whole(radius)) };
    }
    let (i, j) = (b.first, b.second);
    let (sum, difference, r) = (i + j, i - j, i + j + b.gap);
    let area = -PI / 4.0 * ((r - i - j) * (r + i - j) * (r - i + j) * (r + i + j)) / (r * r);
    let (s, d) = (sum * sum, difference * difference);
    let whole = |r: f64| -PI / 4.0 * (r.powi(3) / 3.0 - (s + d) * r - s * d / r);
    Central { push: -density * area, energy: density * (whole(r) - whole(sum)) }
}

/// Force at contact, N, and s over the gap, 1/m.
fn bridge_scales(law: &Bridge, b: &Between) -> (f64, f64) {
    let (radius, volume) = (2.0 * b.reduced(), law.volume.0);
    let most = 2.0 * PI * radius * law.surface_tension.0 * law.angle.0.cos();
    (most, 0.5 * (radius / volume).sqrt())
}

fn bridge_push(law: &Bridge, b: &Between) -> f64 {
    if law.breaks(b.gap) {
        return 0.0;
    }
    let (most, scale) = bridge_scales(law, b);
    let s = b.gap.max(0.0) * scale;
    -most / (1.0 + 2.1 * s + 10.0 * s * s)
}

fn bridge(law: &Bridge, b: &Between) -> Central {
    if law.breaks(b.gap) {
        return Central::default();
    }
    let (most, scale) = bridge_scales(law, b);
    // ∫ ds/(1 + 2.1 s + 10 s²).
    let root = (40.0f64 - 2.1 * 2.1).sqrt();
    let whole = |s: f64| 2.0 / root * ((20.0 * s + 2.1) / root).atan();
    let (s, end) = (b.gap.max(0.0) * scale, whole(law.rupture() * scale));
    let energy = -most / scale * (end - whole(s)) + most * b.gap.min(0.0);
    Central { push: bridge_push(law, b), energy }
}

fn van_der_waals(law: &VanDerWaals, b: &Between) -> Central {
    let plain = |gap: f64| hamaker(law.hamaker.0, &b.at(gap));
    let (least, cutoff) = (law.least_gap.0, law.cutoff.0);
    if b.gap >= cutoff {
        return Central::default();
    }
    let mut here = plain(b.gap.max(least));
    if b.gap < least {
        here.energy -= here.push * (b.gap - least);
    }
    shifted(here, plain(cutoff), b.gap - cutoff, law.cut)
}

/// Hamaker's force without bounds.
fn hamaker(constant: f64, b: &Between) -> Central {
    let (i, h) = (b.first, b.gap);
    if b.plane() {
        let far = h + 2.0 * i;
        let energy = -constant / 6.0 * (i / h + i / far + (-2.0 * i / far).ln_1p());
        return Central { push: -2.0 * constant * i.powi(3) / (3.0 * (h * far).powi(2)), energy };
    }
    let j = b.second;
    let (p, r) = (2.0 * i * j, i + j + h);
    let (x, y) = (h * (h + 2.0 * (i + j)), (h + 2.0 * i) * (h + 2.0 * j));
    let energy = -constant / 6.0 * (p / x + p / y + (-2.0 * p / y).ln_1p());
    Central { push: -4.0 * constant * r * p.powi(3) / (3.0 * (x * y).powi(2)), energy }
}

fn born_mayer(law: &BornMayer, b: &Between) -> Central {
    let plain = |gap: f64| {
        let energy = law.strength.0 * (-gap / law.decay.0).exp();
        Central { push: energy / law.decay.0, energy }
    };
    if b.gap >= law.cutoff.0 {
        return Central::default();
    }
    shifted(plain(b.gap), plain(law.cutoff.0), b.gap - law.cutoff.0, law.cut)
}

fn lennard_jones(law: &LennardJones, distance: f64) -> Central {
    let plain = |r: f64| {
        let six = (law.size.0 / r).powi(6);
        let push = 24.0 * law.depth.0 * (2.0 * six * six - six) / r;
        Central { push, energy: 4.0 * law.depth.0 * (six * six - six) }
    };
    if distance >= law.cutoff.0 {
        return Central::default();
    }
    shifted(plain(distance), plain(law.cutoff.0), distance - law.cutoff.0, law.cut)
}

/// Force between charges whose product over the permittivity is `product` [C²].
pub fn coulomb(product: f64, distance: f64, cutoff: f64, cut: CutOff) -> Central {
    let plain = |r: f64| {
        let energy = COULOMB * product / r;
        Central { push: energy / r, energy }
    };
    if distance >= cutoff {
        return Central::default();
    }
    shifted(plain(distance), plain(cutoff), distance - cutoff, cut)
}

/// `here` with what it is at the cut-off (`end`) taken off; `inside` is the (negative) way from there.
fn shifted(here: Central, end: Central, inside: f64, cut: CutOff) -> Central {
    match cut {
        CutOff::ShiftedPotential => Central { energy: here.energy - end.energy, ..here },
        CutOff::ShiftedForce => Central {
            push: here.push - end.push,
            energy: here.energy - end.energy + inside * end.push,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::units::{Angle, Energy, EnergyDensity, Force, Length, SurfaceTension, Volume};
    use proptest::prelude::*;

    fn vdw(cut: CutOff) -> VanDerWaals {
        VanDerWaals { hamaker: Energy(1e-19), least_gap: Length(1e-9), cutoff: Length(3e-7), cut }
    }

    /// Every law alone, with the gaps between which it acts smoothly.
    fn laws(cut: CutOff) -> Vec<(PairForces, f64, f64)> {
        let none = PairForces::default();
        let with = |cohesion| PairForces { cohesion: Some(cohesion), ..none };
        vec![
            (with(Cohesion::Linear { pull: Force(1e-6), range: Length(2e-7) }), -1e-7, 4e-7),
            (with(Cohesion::Sjkr { energy_density: EnergyDensity(1e5) }), -2e-7, -1e-9),
            (with(Cohesion::Sjkr2 { energy_density: EnergyDensity(1e5) }), -2e-7, -1e-9),
            (with(Cohesion::Dmt { work: SurfaceTension(0.05) }), -2e-7, -1e-9),
            (with(Cohesion::Jkr { work: SurfaceTension(0.05) }), -2e-7, -1e-9),
            (PairForces { van_der_waals: Some(vdw(cut)), ..none }, 1.1e-9, 2.9e-7),
            (PairForces { van_der_waals: Some(vdw(cut)), ..none }, -2e-9, 0.9e-9),
            (
                PairForces {
                    born_mayer: Some(BornMayer {
                        strength: Energy(1e-18),
                        decay: Length(2e-8),
                        cutoff: Length(2e-7),
                        cut,
                    }),
                    ..none
                },
                -1e-8,
                1.9e-7,
            ),
            (
                PairForces {
                    lennard_jones: Some(LennardJones {
                        depth: Energy(1e-18),
                        size: Length(1.9e-6),
                        cutoff: Length(4e-6),
                        cut,
                    }),
                    ..none
                },
                0.0,
                1e-6,
            ),
            (
                PairForces {
                    bridge: Some(Bridge {
                        surface_tension: SurfaceTension(0.072),
                        volume: Volume(1e-21),
                        angle: Angle(0.3),
                    }),
                    ..none
                },
                1e-9,
                1e-7,
            ),
        ]
    }

    proptest! {
        #[test]
        fn force_is_minus_the_slope_of_the_potential(
            law in 0usize..10, part in 0.0..1.0f64, plane: bool, shift: bool,
            second in 0.3e-6..3e-6f64,
        ) {
            let cut = if shift { CutOff::ShiftedForce } else { CutOff::ShiftedPotential };
            let (forces, from, to) = laws(cut)[law];
            let second = if plane { f64::INFINITY } else { second };
            // The well of Lennard-Jones stands for radii of 1 micrometre.
            let second = if forces.lennard_jones.is_some() { 1e-6 } else { second };
            let between = Between { first: 1e-6, second, gap: from + part * (to - from) };
            let step = 1e-5 * (to - from);
            let energy = |gap: f64| total(&forces, &between.at(gap), true).energy;
            let slope = (energy(between.gap + step) - energy(between.gap - step)) / (2.0 * step);
            let push = total(&forces, &between, true).push;
            let scale = total(&forces, &between.at(from), true).push.abs().max(push.abs());
            prop_assert!((push + slope).abs() <= 2e-4 * push.abs() + 1e-6 * scale, "{push} {slope}");
        }

        #[test]
        fn energy_and_shifted_force_end_at_the_cut_off(plane: bool) {
            for (forces, _, to) in laws(CutOff::ShiftedForce) {
                let second = if plane { f64::INFINITY } else { 1e-6 };
                let reach = reach(&forces, 1e-6, 1e-6).max(0.0);
                let between = Between { first: 1e-6, second, gap: reach * (1.0 - 1e-9) - 1e-18 };
                let (end, inner) = (total(&forces, &between, true), total(&forces, &between.at(to.min(0.0) - 1e-9), true));
                prop_assert!(end.energy.abs() <= 1e-6 * inner.energy.abs() + 1e-24, "{forces:?} {end:?}");
                prop_assert_eq!(total(&forces, &between.at(reach + 1e-12), true), Central::default());
            }
        }
    }

    #[test]
    fn pull_off_forces_are_the_published_ones() {
        let between = Between { first: 2e-3, second: 2e-3, gap: 0.0 };
        let plane = Between { second: f64::INFINITY, ..between };
        let pull = |law: Cohesion, b: &Between| -cohesion(&law, &b.at(-1e-12)).push;
        let work = SurfaceTension(0.05);
        assert!(
            (pull(Cohesion::Dmt { work }, &between) / (2.0 * PI * 0.05 * 1e-3) - 1.0).abs() < 1e-12
        );
        assert!(
            (pull(Cohesion::Jkr { work }, &plane) / (1.5 * PI * 0.05 * 2e-3) - 1.0).abs() < 1e-12
        );
        // A bridge at contact: 2 π R γ cos θ between equal spheres, twice that at a plane.
        let law = Bridge {
            surface_tension: SurfaceTension(0.072),
            volume: Volume(1e-12),
            angle: Angle(0.0),
        };
        assert!((bridge(&law, &between).push / (-2.0 * PI * 2e-3 * 0.072) - 1.0).abs() < 1e-12);
        assert!((bridge(&law, &plane).push / (-4.0 * PI * 2e-3 * 0.072) - 1.0).abs() < 1e-12);
        assert_eq!(bridge(&law, &between.at(1.0001e-4)), Central::default());
    }

    #[test]
    fn hamaker_tends_to_derjaguin_near_and_to_london_far_away() {
        let (a, radius) = (1e-19, 1e-6);
        let near = Between { first: radius, second: radius, gap: 1e-10 };
        // F = −A R*/(6 h²), R* = R/2.
        let derjaguin = -a * 0.5 * radius / (6.0 * 1e-20);
        assert!((hamaker(a, &near).push / derjaguin - 1.0).abs() < 1e-3);
        // U = −16 A R₁³R₂³/(9 r⁶).
        let far = near.at(1e-4);
        let r: f64 = 1e-4 + 2.0 * radius;
        let london = -16.0 * a * radius.powi(6) / (9.0 * r.powi(6));
        let force = 6.0 * london / r;
        assert!((hamaker(a, &far).push / force - 1.0).abs() < 1e-3);
        let plane = Between { second: f64::INFINITY, ..near };
        assert!((hamaker(a, &plane).push / (2.0 * derjaguin) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn stiffness_is_that_of_the_steepest_place() {
        let forces =
            PairForces { van_der_waals: Some(vdw(CutOff::ShiftedPotential)), ..Default::default() };
        // 2 A R*/(6 h³) at the least gap.
        let close = 1e-19 * 0.5e-6 / (3.0 * 1e-27);
        assert!((stiffness(&forces, 1e-6, 1e-6) / close - 1.0).abs() < 0.01);
    }
}
