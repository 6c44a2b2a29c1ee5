//! Force, moments and energy of one bond.
//!
//! Ours is hyperelastic: everything follows from an energy of the places and orientations
//! of the two spheres,
//!     U = ½ kn (l − l₀)² + ½ ks |s|² + ½ kb |θ|² + ½ (kt − kb) (θ·n)²,
//! with d the way between the centres, l = |d|, n = d/l; a and b the ways from each centre to
//! the middle of the bond at time 0, which turn with their spheres (b counted towards the
//! second centre), c = a + b; s = −(c − n (n·c)) the shear displacement; θ the rotation vector
//! of the second sphere against the first since time 0. U does not change when the pair
//! moves as one, so forces and moments turn with the pair, balance, and give back all
//! that was put in, at any size of rotation below half a turn. The springs are those of the
//! parallel bond (Potyondy & Cundall 2004, eqs. 14–18) integrated exactly; the way of
//! following large rotations from orientations alone is that of Wang (2009).
//!
//! In the `yade` scheme the bond is `Law2_ScGeom6D_CohFrictPhys_CohesionMoment`: the same
//! normal spring, a shear spring that grows by increments and turns with the contact, and
//! moments kb θ⊥ + kt θ∥. The two agree to first order in strain and rotation.
//!
//! Symbols: kn, ks [N/m]; kb, kt [N m/rad]; θ [rad]. O(1) a bond; cannot fail.

use crate::model::{Bond, BreakMode, Section, Strength};
use crate::num::{Rotation, Vec3};

/// How the two spheres of a bond stand to each other.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// From the first centre to the second, m.
    pub between: Vec3,
    /// Its length less that at time 0, m.
    pub stretch: f64,
    /// From the first centre to the middle of the bond, and from there to the second centre,
    /// each turned with its sphere, m.
    pub arms: [Vec3; 2],
    /// Rotation vector of the second sphere against the first since time 0.
    pub turn: Vec3,
}

/// What a bond does.
#[derive(Debug, Clone, Copy)]
pub struct Action {
    /// Force on the second sphere, N; the first feels the opposite.
    pub force: Vec3,
    /// Torques about both centres, N m.
    pub torques: [Vec3; 2],
    /// Shear displacement, m.
    pub slip: Vec3,
    /// Pull along the line of centres, N; negative when pushing.
    pub pull: f64,
    /// Force across it, N.
    pub shear: f64,
    /// Bending and twisting moments, N m.
    pub moments: [f64; 2],
    /// Elastic energy, J.
    pub energy: f64,
}

/// The rotation vector of `second · rest · first⁻¹`, shorter than π.
pub fn relative_turn(first: &Rotation, second: &Rotation, rest: &Rotation) -> Vec3 {
    let turn = second * rest * first.inverse();
    // q and −q are one rotation; near identity the arc sine keeps all digits.
    let (w, v) = (turn.w, turn.imag());
    let (w, v) = if w < 0.0 { (-w, -v) } else { (w, v) };
    let sine = v.norm();
    if sine == 0.0 { Vec3::zeros() } else { v * (2.0 * sine.atan2(w) / sine) }
}

/// The hyperelastic bond.
pub fn elastic(bond: &Bond, pose: &Pose) -> Action {
    let length = pose.between.norm();
    let normal = pose.between / length;
    let [a, b] = pose.arms;
    let whole = a + b;
    let along = normal.dot(&whole);
    let across = whole - normal * along;
    let pull = bond.normal * pose.stretch;
    let tug = across * bond.shear;
    let mut action = Action {
        force: tug * (along / length) - normal * pull,
        torques: [-a.cross(&tug), -b.cross(&tug)],
        slip: -across,
        pull,
        shear: tug.norm(),
        moments: [0.0; 2],
        energy: 0.5 * (bond.normal * pose.stretch * pose.stretch + tug.dot(&across)),
    };
    if bond.has_moments() {
        add_moments(bond, &pose.turn, &normal, length, &mut action);
    }
    action
}

/// Adds the part of the energy that depends on θ, and what follows from it.
fn add_moments(bond: &Bond, turn: &Vec3, normal: &Vec3, length: f64, action: &mut Action) {
    let twist = turn.dot(normal);
    let bend = turn - normal * twist;
    let more = (bond.twisting - bond.bending) * twist;
    // δθ = J⁻¹ δφ: J⁻¹ n = n ∓ ½ θ×n + κ θ×(θ×n) for rotations of the second (first) sphere.
    let square = turn.norm_squared();
    let kappa = if square < 1e-4 {
        1.0 / 12.0 + square / 720.0
    } else {
        let angle = square.sqrt();
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / square
    };
    let lean = turn.cross(normal);
    let even = turn * bond.bending + (normal + turn.cross(&lean) * kappa) * more;
    let odd = lean * (0.5 * more);
    action.torques[0] += even - odd;
    action.torques[1] -= even + odd;
    action.force -= bend * (more / length);
    action.moments = [bond.bending * bend.norm(), bond.twisting * twist.abs()];
    action.energy += 0.5 * (bond.bending * square + more * twist);
}

/// The bond of YADE, with `slip` the shear spring after its increment and `arms` the distances
/// of the middle of the contact from both centres, m.
pub fn as_yade(bond: &Bond, pose: &Pose, slip: Vec3, arms: [f64; 2]) -> Action {
    let normal = pose.between.normalize();
    let pull = bond.normal * pose.stretch;
    let tug = slip * -bond.shear;
    let couple = normal.cross(&tug);
    let twist = pose.turn.dot(&normal);
    let bend = pose.turn - normal * twist;
    let moment = bend * bond.bending + normal * (bond.twisting * twist);
    Action {
        force: tug - normal * pull,
        torques: [moment - couple * arms[0], -moment - couple * arms[1]],
        slip,
        pull,
        shear: tug.norm(),
        moments: [bond.bending * bend.norm(), bond.twisting * twist.abs()],
        energy: 0.5
            * (bond.normal * pose.stretch * pose.stretch
                + bond.shear * slip.norm_squared()
                + bond.bending * bend.norm_squared()
                + bond.twisting * twist * twist),
    }
}

/// What breaks the bond under `action`; `None` if it holds. `planar`: two dimensions.
pub fn breaks(bond: &Bond, action: &Action, section: impl Fn(f64) -> Section) -> Option<BreakMode> {
    match bond.strength {
        Strength::Unbreakable => None,
        Strength::Forces { tension, .. } if action.pull > tension => Some(BreakMode::Tension),
        Strength::Forces { shear, .. } => (action.shear > shear).then_some(BreakMode::Shear),
        Strength::Stresses { radius, tension, shear } => {
            let Section { area, bending, twisting, .. } = section(radius);
            let (pull, bend) = (action.pull / area, action.moments[0] * radius / bending);
            if pull + bend > tension {
                return Some(if bend > pull { BreakMode::Bending } else { BreakMode::Tension });
            }
            let (across, twist) = (action.shear / area, action.moments[1] * radius / twisting);
            (across + twist > shear).then_some(if twist > across {
                BreakMode::Twisting
            } else {
                BreakMode::Shear
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Dimension;
    use proptest::prelude::*;

    fn vector(size: f64) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    /// Places and orientations of both spheres.
    #[derive(Debug, Clone, Copy)]
    struct Both {
        places: [Vec3; 2],
        turns: [Rotation; 2],
    }

    const REST: [f64; 2] = [0.7, 0.5];

    fn pose(both: &Both) -> Pose {
        let between = both.places[1] - both.places[0];
        Pose {
            between,
            stretch: between.norm() - REST[0] - REST[1],
            arms: [0, 1].map(|i| both.turns[i] * (Vec3::x() * REST[i])),
            turn: relative_turn(&both.turns[0], &both.turns[1], &Rotation::identity()),
        }
    }

    fn bond() -> Bond {
        Bond {
            first: 0,
            second: 1,
            normal: 3.0,
            shear: 2.0,
            bending: 0.8,
            twisting: 1.7,
            viscosity: 0.0,
            strength: Strength::Unbreakable,
        }
    }

    fn boths() -> impl Strategy<Value = Both> {
        (vector(0.3), vector(0.8), vector(0.8), vector(2.0)).prop_map(|(shift, a, b, all)| {
            let all = Rotation::from_scaled_axis(all);
            Both {
                places: [shift, all * (Vec3::x() * 1.2 + shift) + shift],
                turns: [a, b].map(|turn| all * Rotation::from_scaled_axis(turn)),
            }
        })
    }

    fn energy(both: &Both) -> f64 {
        elastic(&bond(), &pose(both)).energy
    }

    proptest! {
        #[test]
        fn forces_and_moments_are_the_slope_of_the_energy(both in boths(), way in vector(1.0)) {
            let h = 1e-5;
            let action = elastic(&bond(), &pose(&both));
            for i in 0..2 {
                let moved = |step: f64| {
                    let mut to = both;
                    to.places[i] += way * step;
                    energy(&to)
                };
                let force = if i == 1 { action.force } else { -action.force };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                prop_assert!((slope + force.dot(&way)).abs() < 1e-7, "{slope} {force:?}");
                let turned = |step: f64| {
                    let mut to = both;
                    to.turns[i] = Rotation::from_scaled_axis(way * step) * to.turns[i];
                    energy(&to)
                };
                let slope = (turned(h) - turned(-h)) / (2.0 * h);
                let torque = action.torques[i];
                prop_assert!((slope + torque.dot(&way)).abs() < 1e-7, "{i} {slope} {torque:?}");
            }
        }

        #[test]
        fn a_bond_turns_with_its_pair_and_balances(both in boths(), by in vector(3.0), shift in vector(5.0)) {
            let action = elastic(&bond(), &pose(&both));
            let between = both.places[1] - both.places[0];
            let balance = action.torques[0] + action.torques[1] + between.cross(&action.force);
            prop_assert!(balance.norm() < 1e-12);
            let turn = Rotation::from_scaled_axis(by);
            let moved = Both {
                places: both.places.map(|place| turn * place + shift),
                turns: both.turns.map(|old| turn * old),
            };
            let then = elastic(&bond(), &pose(&moved));
            prop_assert!((then.force - turn * action.force).norm() < 1e-12);
            for i in 0..2 {
                prop_assert!((then.torques[i] - turn * action.torques[i]).norm() < 1e-12);
            }
            prop_assert!((then.energy - action.energy).abs() < 1e-12);
        }

        #[test]
        fn both_forms_agree_for_small_displacements(shift in vector(1e-6), a in vector(1e-6), b in vector(1e-6)) {
            let both = Both {
                places: [Vec3::zeros(), Vec3::x() * 1.2 + shift],
                turns: [a, b].map(Rotation::from_scaled_axis),
            };
            let ours = elastic(&bond(), &pose(&both));
            let cross = |v: &Vec3| Vec3::new(0.0, v.y, v.z);
            let slip = cross(&(shift - a.cross(&(Vec3::x() * 0.7)) - b.cross(&(Vec3::x() * 0.5))));
            let theirs = as_yade(&bond(), &pose(&both), slip, REST);
            prop_assert!((ours.force - theirs.force).norm() < 1e-10);
            prop_assert!((ours.torques[0] - theirs.torques[0]).norm() < 1e-10);
            prop_assert!((ours.torques[1] - theirs.torques[1]).norm() < 1e-10);
            prop_assert!((ours.energy - theirs.energy).abs() < 1e-15);
        }
    }

    fn action(pull: f64, shear: f64, moments: [f64; 2]) -> Action {
        let zero = Vec3::zeros();
        Action { force: zero, torques: [zero; 2], slip: zero, pull, shear, moments, energy: 0.0 }
    }

    #[test]
    fn breaks_exactly_above_its_strength() {
        let section = |radius| Section::new(Dimension::Three, radius);
        let mut bond = bond();
        bond.strength = Strength::Forces { tension: 2.0, shear: 1.0 };
        let broken = |bond: &Bond, a: Action| breaks(bond, &a, section);
        assert_eq!(broken(&bond, action(2.0, 1.0, [9.0, 9.0])), None);
        let above = 1.0 + f64::EPSILON;
        assert_eq!(broken(&bond, action(2.0 * above, 9.0, [0.0; 2])), Some(BreakMode::Tension));
        assert_eq!(broken(&bond, action(-5.0, above, [0.0; 2])), Some(BreakMode::Shear));
        bond.strength = Strength::Stresses { radius: 0.1, tension: 4.0, shear: 3.0 };
        let Section { area, bending, twisting, .. } = section(0.1);
        for (action, mode) in [
            (action(4.0 * area, 0.0, [0.0; 2]), BreakMode::Tension),
            (action(0.0, 3.0 * area, [0.0; 2]), BreakMode::Shear),
            (action(1.0 * area, 0.0, [30.0 * bending, 0.0]), BreakMode::Bending),
            (action(0.0, 1.0 * area, [0.0, 20.0 * twisting]), BreakMode::Twisting),
        ] {
            let scaled = |f: f64| {
                let moments = action.moments.map(|m| m * f);
                Action { pull: action.pull * f, shear: action.shear * f, moments, ..action }
            };
            assert_eq!(broken(&bond, scaled(1.0 - 1e-12)), None);
            assert_eq!(broken(&bond, scaled(1.0 + 1e-12)), Some(mode));
        }
    }
}
