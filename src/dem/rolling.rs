//! Resistance to rolling in one contact.
//!
//! ω relative angular velocity [rad/s], ω_t its part in the contact plane, R* reduced radius [m],
//! δ overlap [m], Fn normal force [N], μr coefficient of rolling friction. Moment against ω:
//! - cdt (constant directional torque; Zhou et al. 1999, as LIGGGHTS-PUBLIC 3.8.0 has it):
//!   M = μr kn δ R* ω_t/|ω|. Its direction jumps where rolling ends, so a grain at rest trembles
//!   with a spin of some M Δt/I.
//! - epsd, epsd2 (Iwashita & Oda 1998; Ai et al. 2011, model C): spring moment Mk grows by
//!   kr ω_t Δt and is cut to μr |Fn| R*; kr = 2.25 kn μr² R*² (epsd), kt R*² (epsd2); epsd adds
//!   2 η √(I kr) ω_t while not cut, I the inertia of rolling about the contact (7/5 m R² a side, 3/2 for
//!   discs, in series). The spring is kept in the world frame, as LIGGGHTS does.
//!
//! O(1); cannot fail.

use crate::model::Contact;
use crate::model::extra::Rolling;
use crate::num::Vec3;

/// A contact as rolling sees it.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Unit normal.
    pub normal: Vec3,
    /// Relative angular velocity, first minus second, rad/s.
    pub spin: Vec3,
    /// Overlap, m.
    pub overlap: f64,
    /// Reduced radius, m.
    pub radius: f64,
    /// Normal force, N.
    pub force: f64,
    /// Inertia of rolling, kg m².
    pub inertia: f64,
}

/// Moment, the spring it leaves and what that stores.
#[derive(Debug, Clone, Copy, Default)]
pub struct Resistance {
    /// Moment, N m: taken from the first body and given to the second.
    pub moment: Vec3,
    /// Spring moment to remember, N m.
    pub spring: Vec3,
    /// Energy in the spring, J.
    pub elastic: f64,
}

/// Rotational stiffness over R*², N/m; 0 for laws without a spring.
pub fn stiffness(law: &Rolling, pair: &Contact) -> f64 {
    match law {
        Rolling::Cdt { .. } => 0.0,
        Rolling::Epsd { coefficient, .. } => 2.25 * pair.kn * coefficient * coefficient,
        Rolling::Epsd2 { .. } => pair.kt,
    }
}

/// Resistance of a contact whose spring was `old`, after the time `advance` [s].
pub fn resist(law: &Rolling, pair: &Contact, turn: &Turn, old: Vec3, advance: f64) -> Resistance {
    let coefficient = law.coefficient();
    if let Rolling::Cdt { .. } = law {
        let size = turn.spin.norm();
        if size == 0.0 {
            return Resistance::default();
        }
        let full = turn.spin * (coefficient * pair.kn * turn.overlap * turn.radius / size);
        let moment = full - turn.normal * full.dot(&turn.normal);
        return Resistance { moment, ..Resistance::default() };
    }
    let across = turn.spin - turn.normal * turn.spin.dot(&turn.normal);
    let stiffness = stiffness(law, pair) * turn.radius * turn.radius;
    let trial = old + across * (advance * stiffness);
    let limit = turn.force.abs() * turn.radius * coefficient;
    let size = trial.norm();
    let slips = size > limit;
    let spring = if slips { trial * (limit / size) } else { trial };
    let damping = match law {
        Rolling::Epsd { damping, .. } if !slips => {
            across * (damping * 2.0 * (turn.inertia * stiffness).sqrt())
        }
        _ => Vec3::zeros(),
    };
    let elastic = if stiffness > 0.0 { 0.5 * spring.norm_squared() / stiffness } else { 0.0 };
    Resistance { moment: spring + damping, spring, elastic }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Rotation;
    use proptest::prelude::*;

    fn vector(size: f64) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    fn laws() -> impl Strategy<Value = Rolling> {
        prop_oneof![
            (0.01..1.0f64).prop_map(|coefficient| Rolling::Cdt { coefficient }),
            (0.01..1.0f64).prop_map(|coefficient| Rolling::Epsd2 { coefficient }),
            (0.01..1.0f64, 0.0..1.0f64)
                .prop_map(|(coefficient, damping)| Rolling::Epsd { coefficient, damping }),
        ]
    }

    const PAIR: Contact = Contact { kn: 1e5, kt: 3e4, cn: 0.0, ct: 0.0, friction: 0.5 };

    proptest! {
        #[test]
        fn moments_stay_below_their_limit_in_the_contact_plane_and_turn_with_the_frame(
            law in laws(), spin in vector(50.0), old in vector(1e-3), axis in vector(3.0),
        ) {
            let old = Vec3::new(old.x, old.y, 0.0);
            let turn = Turn { normal: Vec3::z(), spin, overlap: 1e-5, radius: 5e-3, force: 1.0, inertia: 1e-7 };
            let found = resist(&law, &PAIR, &turn, old, 1e-6);
            prop_assert!(found.spring.norm() <= law.coefficient() * 5e-3 * (1.0 + 1e-12));
            prop_assert!(found.moment.z.abs() <= 1e-12 * found.moment.norm());
            let frame = Rotation::from_scaled_axis(axis);
            let seen = Turn { normal: frame * turn.normal, spin: frame * spin, ..turn };
            let again = resist(&law, &PAIR, &seen, frame * old, 1e-6);
            prop_assert!((again.moment - frame * found.moment).norm() <= 1e-12 * found.moment.norm() + 1e-18);
        }

        #[test]
        fn a_closed_cycle_gives_no_energy(law in laws(), size in 0.1..30.0f64, force in 0.1..5.0f64) {
            // The relative angle goes to and fro; the work done against the moment is what is lost.
            let (steps, step) = (4000, 1e-6);
            let (mut spring, mut last, mut work) = (Vec3::zeros(), Vec3::zeros(), 0.0);
            let mut stored = 0.0;
            for i in 0..steps {
                let phase = std::f64::consts::TAU * (f64::from(i) + 0.5) / f64::from(steps);
                let spin = Vec3::new(size * phase.cos(), 0.3 * size * (2.0 * phase).cos(), 0.0);
                let turn = Turn { normal: Vec3::z(), spin, overlap: 1e-5, radius: 5e-3, force, inertia: 1e-7 };
                let found = resist(&law, &PAIR, &turn, spring, step);
                work += 0.5 * step * (last + found.moment).dot(&spin);
                (spring, last, stored) = (found.spring, found.moment, found.elastic);
            }
            let scale = law.coefficient() * (force + PAIR.kn * 1e-5) * 5e-3 * size * step * f64::from(steps);
            prop_assert!(work - stored >= -1e-5 * scale, "{law:?} {work} {stored} {scale}");
        }
    }
}
