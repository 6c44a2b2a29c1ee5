//! The law keeps its limits, gives no energy, and does not know in which frame or from which side it is looked at.

use super::law::*;
use crate::model::{Arm, Contact, Coulomb, History, Law, Scheme};
use crate::num::Vec3;
use proptest::prelude::*;

fn vector(size: f64) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

fn laws() -> impl Strategy<Value = Law> {
    let coulomb =
        prop_oneof![Just(Coulomb::Sum), Just(Coulomb::Spring), Just(Coulomb::SpringThenDashpot)];
    let history =
        prop_oneof![Just(History::Projected), Just(History::Rescaled), Just(History::Rotated)];
    (any::<bool>(), coulomb, history).prop_map(|(tension, coulomb, history)| Law {
        tension,
        coulomb,
        history,
        arm: Arm::Half,
        plane_arm: Arm::Half,
    })
}

const KEPT: Kept =
    Kept { friction: true, damping: true, normals: true, pulls: false, ledger: true };

/// A book of one contact with this spring and normal.
fn book_of(spring: Vec3, normal: Vec3) -> Book {
    let mut book = Book::open(1, KEPT);
    book.touching[0] = true;
    book.spring.put(0, spring);
    book.normal.put(0, normal);
    book
}

proptest! {
    #[test]
    fn limits_hold_and_nothing_gives_energy(
        law in laws(), old in vector(1e-4), velocity in vector(2.0),
        tilt in vector(1e-3), overlap in 0.0..1e-3f64, friction in 0.0..1.0f64,
    ) {
        let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction };
        let normal = (Vec3::z() + tilt).normalize();
        let mut book = book_of(Vec3::new(old.x, old.y, 0.0), Vec3::z());
        let rule = Rule { law, advance: 1e-6, interval: 1e-6, slip: Slip::Cut, seen: true };
        let approach = Approach::new(normal, overlap, velocity, Vec3::zeros());
        let mut tally = Tally::default();
        let reply = for_kind!(KEPT, law, K => advance::<K>(
            &rule, &pair, &approach, true, (&mut book.view(), 0), &mut tally,
        ));
        prop_assert!(law.tension || reply.normal >= 0.0);
        let limit = friction * reply.normal.abs() * (1.0 + 1e-12);
        match law.coulomb {
            Coulomb::Sum => prop_assert!(reply.tangent.norm() <= limit),
            Coulomb::SpringThenDashpot | Coulomb::Spring => {
                prop_assert!(pair.kt * book.spring.at(0).norm() <= limit);
            }
        }
        prop_assert!(reply.tangent.dot(&normal).abs() <= 1e-5 * reply.tangent.norm() + 1e-12);
        prop_assert!(tally.tangential_dashpot >= 0.0);
        prop_assert!(tally.normal_dashpot >= 0.0);
    }

    #[test]
    fn rescaling_keeps_length_and_plane(old in vector(1e-4), tilt in vector(0.3)) {
        let normal = (Vec3::z() + tilt).normalize();
        let flat = Vec3::new(old.x, old.y, 0.0);
        prop_assume!(flat.norm() > 1e-8);
        let turned = Vec3::from(rescale::<f64>(flat.into(), normal.into()));
        prop_assert!((turned.norm() / flat.norm() - 1.0).abs() < 1e-12);
        prop_assert!(turned.dot(&normal).abs() < 1e-12 * flat.norm());
    }

    #[test]
    fn the_frame_does_not_matter(
        law in laws(), old in vector(1e-4), velocity in vector(2.0), spins in vector(30.0),
        tilt in vector(1e-2), overlap in 0.0..1e-3f64, axis in vector(3.0),
    ) {
        let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction: 0.4 };
        let rule = Rule { law, advance: 1e-6, interval: 1e-6, slip: Slip::Cut, seen: true };
        let frame = crate::num::Rotation::from_scaled_axis(axis);
        let flat = Vec3::new(old.x, old.y, 0.0);
        let seen = |turn: &dyn Fn(Vec3) -> Vec3| {
            let mut book = book_of(turn(flat), turn(Vec3::z()));
            let normal = turn((Vec3::z() + tilt).normalize());
            let approach = Approach::new(normal, overlap, turn(velocity), turn(spins));
            let mut tally = Tally::default();
            let reply = for_kind!(KEPT, law, K => advance::<K>(
                &rule, &pair, &approach, true, (&mut book.view(), 0), &mut tally,
            ));
            (reply, book.spring.at(0), tally)
        };
        let (here, there) = (seen(&|v| v), seen(&|v| frame * v));
        let scale = here.0.tangent.norm() + 1e-9;
        prop_assert!((here.0.normal - there.0.normal).abs() <= 1e-12 * (here.0.normal.abs() + 1.0));
        prop_assert!((frame * here.0.tangent - there.0.tangent).norm() <= 1e-9 * scale);
        prop_assert!((frame * here.1 - there.1).norm() <= 1e-9 * (here.1.norm() + 1e-9));
        prop_assert!((here.2.slip - there.2.slip).abs() <= 1e-9 * here.2.slip.abs() + 1e-15);
    }

    /// The contact point goes round a closed path in the plane, twice, while the overlap goes up and
    /// down; the work done on the contact is not less than what its springs hold.
    #[test]
    fn a_closed_cycle_gives_no_energy(
        law in laws(), reach in 1e-6..3e-4f64, deep in 1e-5..3e-4f64, lag in 0.0..6.0f64,
        damped: bool, tilt in 0.0..3.0f64,
    ) {
        let dashpot = if damped { 2.0 } else { 0.0 };
        let pair = Contact { kn: 1e4, kt: 7e3, cn: dashpot, ct: dashpot, friction: 0.4 };
        let steps = 2000u32;
        let work = |count: u32| {
            let step = 1e-3 / f64::from(count);
            let rule = Rule { law, advance: step, interval: step, slip: Slip::Cut, seen: true };
            let mut book = book_of(Vec3::zeros(), Vec3::z());
            let (mut sum, mut last, mut held) = (0.0, None::<Vec3>, 0.0);
            for i in 0..=2 * count {
                let place = |s: f64| {
                    let phase = std::f64::consts::TAU * s / f64::from(count);
                    let (x, y) = (reach * phase.sin(), reach * tilt * (2.0 * phase + lag).sin());
                    Vec3::new(x, y, -deep * (1.0 - 0.9 * phase.cos()))
                };
                let (now, before) = (place(f64::from(i)), place(f64::from(i) - 1.0));
                let velocity = (now - before) / step;
                let approach =
                    Approach::new(Vec3::z(), -now.z, velocity, Vec3::zeros());
                let mut tally = Tally::default();
                let reply = for_kind!(KEPT, law, K => advance::<K>(
                &rule, &pair, &approach, true, (&mut book.view(), 0), &mut tally,
            ));
                let force = Vec3::z() * reply.normal + reply.tangent;
                if let Some(earlier) = last {
                    sum -= (earlier + force).dot(&(now - before)) * 0.5;
                } else {
                    held -= 0.5 * pair.kn * now.z * now.z + 0.5 * pair.kt * book.spring.at(0).norm_squared();
                }
                last = Some(force);
                if i == 2 * count {
                    held += 0.5 * pair.kn * now.z * now.z + 0.5 * pair.kt * book.spring.at(0).norm_squared();
                }
            }
            (sum - held, pair.kn * deep * deep + pair.kt * reach * reach * (1.0 + tilt * tilt))
        };
        let (lost, scale) = work(steps);
        prop_assert!(lost >= -1e-4 * scale, "{law:?} {lost} {scale}");
    }

    #[test]
    fn a_contact_seen_from_the_other_side_is_the_same(
        law in laws(), velocity in vector(1.0), overlap in 0.0..1e-3f64,
    ) {
        let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction: 0.4 };
        let rule = Rule { law, advance: 1e-6, interval: 1e-6, slip: Slip::Cut, seen: true };
        let mut forces = [1.0, -1.0].map(|side| {
            let mut book = Book::open(1, KEPT);
            let approach =
                Approach::new(Vec3::x() * side, overlap, velocity * side, Vec3::zeros());
            let mut tally = Tally::default();
            let reply = for_kind!(KEPT, law, K => advance::<K>(
                &rule, &pair, &approach, true, (&mut book.view(), 0), &mut tally,
            ));
            (reply.normal, reply.tangent, tally)
        });
        forces[1].1 = -forces[1].1;
        prop_assert_eq!(forces[0], forces[1]);
    }
}

#[test]
fn set_up_passes_cut_the_force_of_a_long_spring_and_that_of_liggghts_leaves_its_length() {
    let (mut law, long) = (Scheme::Liggghts.law(), Vec3::new(1e-4, 0.0, 0.0));
    let pair = Contact { kn: 1e4, kt: 7e3, cn: 2.0, ct: 1.0, friction: 0.5 };
    let approach = Approach::new(Vec3::z(), 1e-4, Vec3::zeros(), Vec3::zeros());
    for (slip, left) in [(Slip::Cut, 0.5 / 7e3), (Slip::Bare, 0.5 / 7e3), (Slip::Kept, 1e-4)] {
        for coulomb in [Coulomb::Sum, Coulomb::SpringThenDashpot, Coulomb::Spring] {
            law.coulomb = coulomb;
            let rule = Rule { law, advance: 0.0, interval: 0.0, slip, seen: true };
            let (mut book, mut tally) = (book_of(long, Vec3::z()), Tally::default());
            let reply = for_kind!(KEPT, law, K => advance::<K>(
                &rule, &pair, &approach, true, (&mut book.view(), 0), &mut tally,
            ));
            assert!((reply.tangent + Vec3::x() * 0.5).norm() < 1e-15, "{slip:?} {coulomb:?}");
            assert!((book.spring.at(0) - Vec3::x() * left).norm() < 1e-18, "{slip:?} {coulomb:?}");
        }
    }
}
