use super::columns::Column;
use super::faces::waiting;
use super::*;
use crate::dem::averaged::Averaged;
use crate::dem::averaged_pass::{Memory, member_at_plane, members};
use crate::dem::crew::Crew;
use crate::dem::law::{Book, Rule, Slip, for_kind};
use crate::dem::planes::Planes;
use crate::dem::setting::Setting;
use crate::dem::state::{List, State};
use crate::dem::{neighbours, test_scenes};
use crate::model::{Contact, ContactTable, Coulomb, History, Law, Model, Motion, Scheme};
use crate::num::Rotation;

type Bits = Vec<u64>;

/// All bits that a pass leaves, run after run of one version; or of the one that the program has `chosen`.
fn passes<V: Version>(setting: &Setting<'_>, state: &State, chosen: bool) -> Bits {
    let mut state = state.clone();
    let rule =
        Rule { law: setting.law, advance: 1e-5, interval: 1e-5, slip: Slip::Cut, seen: true };
    let owners = |list: &List| -> Vec<u16> {
        let slots = 0..state.balls.len();
        let entries = |slot| list.start[slot]..list.start[slot + 1];
        slots.flat_map(|slot| entries(slot).map(move |_| slot as u16)).collect()
    };
    let (owners, sides) = (owners(&state.pairs), owners(&state.planes));
    let planes = Planes::new(setting.planes_at(0.0));
    let mut faces = Book::open(SWEEP + 5, setting.kept);
    let mut bits = Bits::new();
    let averaged = setting.scheme == Scheme::PathAveraged;
    for _ in 0..3 {
        let mut memory = Memory::default();
        if averaged {
            memory.look(setting, &state);
        }
        let field = Field {
            setting,
            rule: &rule,
            balls: &state.balls,
            spins: &state.spins,
            planes: &planes,
            faces: &[],
            memory: &memory,
            yade: false,
        };
        let List { partner, book, .. } = &mut state.pairs;
        let seats: Vec<u16> = partner.iter().map(|slot| *slot as u16).collect();
        let pairs =
            Pairs { block: 0, first: &owners, second: partner, seats: &seats, kind: Second::Balls };
        let second = &state.planes.partner[..];
        let sides = Pairs { first: &sides, second, seats: &[], kind: Second::Planes, ..pairs };
        let (loads, book) = (&mut state.loads[..], book.view());
        let planes = state.planes.book.view();
        let (pairs, sides) = (Listed::of(pairs), Listed::of(sides));
        let mut part = Part { pairs, at_planes: sides, loads, book, planes, strangers: &mut [] };
        let mut scratch = Scratch::default();
        let (friction, drags) = (setting.kept.friction, setting.kept.pulls);
        let tally = match (averaged, friction, setting.kept.damping, drags) {
            (false, ..) => for_kind!(setting.kept, setting.law, K => {
                if chosen {
                    at_planes::<K>(&field, &mut part, &mut scratch);
                    meet_faces::<K>(&field, &mut faces.view(), &mut scratch, answer_waiting::<K>);
                    let mut bodies = Waiters(field.balls, field.spins);
                    between::<K, _>(&field, &mut bodies, &mut part, &mut scratch);
                } else {
                    begin::<V, K>(&field, &mut part, &mut scratch);
                    meet_faces::<K>(&field, &mut faces.view(), &mut scratch, waiting::<V, K>);
                    meet_others::<V, K>(&field, &mut part, &mut scratch);
                }
                finish(&mut part, &mut scratch)
            }),
            (_, false, false, _) => {
                meet_along::<V, Averaged<false, false, false, true>>(&field, part, scratch)
            }
            (_, false, true, _) => {
                meet_along::<V, Averaged<false, true, false, true>>(&field, part, scratch)
            }
            (_, true, false, _) => {
                meet_along::<V, Averaged<true, false, false, true>>(&field, part, scratch)
            }
            (_, true, true, false) => {
                meet_along::<V, Averaged<true, true, false, true>>(&field, part, scratch)
            }
            (_, true, true, true) => {
                meet_along::<V, Averaged<true, true, true, true>>(&field, part, scratch)
            }
        };
        let loads = state.loads.iter().flat_map(|l| l.force.iter().chain(l.torque.iter()));
        bits.extend(loads.map(|x| x.to_bits()));
        for book in [&state.pairs.book, &state.planes.book, &faces] {
            for column in [&book.spring, &book.normal, &book.pull].map(Triple::all).as_flattened() {
                bits.extend(column.iter().map(|x| x.to_bits()));
            }
            bits.extend(book.lag.iter().map(|x| x.to_bits()));
            bits.extend(book.power.iter().map(|x| u64::from(x.to_bits())));
            bits.extend(book.touching.iter().map(|t| u64::from(*t)));
        }
        let Tally { normal_dashpot, tangential_dashpot, slip, wall_power, .. } = tally;
        let sums = [normal_dashpot, tangential_dashpot, slip, wall_power];
        bits.extend(sums.map(f64::to_bits));
        for (slot, ball) in state.balls.iter_mut().enumerate() {
            ball.place += ball.velocity * (1e-4 * (1.0 + 0.1 * slot as f64));
        }
    }
    bits
}

/// All pairs.
fn meet_others<V: Version, K: Kind>(field: &Field<'_>, part: &mut Part<'_>, scratch: &mut Scratch) {
    let mut bodies = Waiters(field.balls, field.spins);
    sweeps::<V, K, _>(field, &mut bodies, part.pairs, &mut part.book, scratch);
}

/// A pass of the path-averaged scheme, whose first sweep is compared with one pair at a time.
fn meet_along<V: Version, K: Kind>(
    field: &Field<'_>,
    mut part: Part<'_>,
    mut scratch: Scratch,
) -> Tally {
    begin::<V, K>(field, &mut part, &mut scratch);
    meet_others::<V, K>(field, &mut part, &mut scratch);
    let tally = finish(&mut part, &mut scratch);
    scratch.pulls.resize(field.balls.len(), ZEROS);
    for pairs in [part.pairs, part.at_planes] {
        let planes = pairs.kind == Second::Planes;
        let pairs = check(pairs, field, scratch.pulls.len());
        for begin in (0..pairs.first.len() / GROUP * GROUP).step_by(GROUP) {
            let pairs = pairs.slice(begin, begin + GROUP);
            let near = (GROUP, &[true; GROUP][..]);
            match (K::DRAGS, planes) {
                (true, false) => V::meet::<true, 2, true>(field, pairs, near, &mut scratch),
                (true, true) => V::meet_planes::<true, 2>(field, pairs, near, &mut scratch),
                _ => continue,
            }
            for at in 0..GROUP {
                let (slot, other) = (usize::from(pairs.first[at]), pairs.second[at] as usize);
                if !field.balls[slot].alone || !(planes || field.balls[other].alone) {
                    continue;
                }
                let (one, arm) = if planes {
                    member_at_plane::<K>(field, slot, other)
                } else {
                    let (one, arms) = members::<K>(field, slot, other);
                    (one, arms[0])
                };
                let near = |column: &Column, wanted: f64, scale: f64| {
                    let found = column.0[at];
                    assert!((found - wanted).abs() <= 1e-10 * scale, "{found} {wanted}");
                };
                near(&scratch.overlap, -one.gap, 1e-3);
                near(&scratch.arms[0], arm, 1e-3);
                near(&scratch.ease, one.ease, one.ease);
                near(&scratch.across, one.across, one.across);
                for (triple, wanted, scale) in [
                    (&scratch.unit, one.normal, 1.0),
                    (&scratch.velocity, one.velocity, 1.0),
                    (&scratch.early, one.early, 1.0),
                    (&scratch.pull, one.pull, 1e3 + Vec3::from(one.pull).norm()),
                ] {
                    near(&triple.x, wanted.x, scale);
                    near(&triple.y, wanted.y, scale);
                    near(&triple.z, wanted.z, scale);
                }
            }
        }
    }
    tally
}

/// More triangles than wait at a time, some of which no longer touch.
fn meet_faces<K: Kind>(
    field: &Field<'_>,
    book: &mut BookView<'_>,
    scratch: &mut Scratch,
    answer: impl Fn(&Field<'_>, (usize, &mut BookView<'_>), &mut Scratch),
) {
    for entry in 0..SWEEP + 5 {
        let ball = &field.balls[entry % 50];
        let way = ball.velocity + Vec3::new(0.3, 0.1, entry as f64);
        let spot = Spot {
            first: (entry % 50) as u16,
            material: 0,
            entry,
            normal: way.normalize(),
            overlap: ball.velocity.x * 1e-4,
            arm: ball.radius,
            velocity: ball.velocity,
            spins: ball.velocity * 30.0,
            drift: ball.velocity * 0.1,
            touches: ball.velocity.x > 0.0,
        };
        scratch.put(scratch.waiting.count, &spot);
        scratch.waiting.count += 1;
        if scratch.waiting.count == SWEEP || entry == SWEEP + 4 {
            answer(field, (0, book), scratch);
        }
    }
}

/// A crowd in motion, dense enough that most listed pairs touch.
fn crowd(model: &mut Model) {
    for (index, body) in model.bodies.iter_mut().enumerate() {
        let at = index as f64;
        body.position *= 0.15;
        body.velocity = Vec3::new((at * 0.7).sin(), (at * 1.3).cos(), (at * 2.1).sin()) * 0.2;
        body.spin = Vec3::new((at * 0.3).cos(), (at * 1.9).sin(), (at * 0.9).cos()) * 40.0;
    }
}

#[test]
fn all_versions_give_the_same_bytes() {
    let limits = [Coulomb::Sum, Coulomb::SpringThenDashpot, Coulomb::Spring];
    let histories = [History::Projected, History::Rescaled, History::Rotated];
    let (mut touching, mut rests) = (0, 0);
    let crowds = [
        (53, 1.0, true),
        (57, 1.0, true),
        (53, 3.0, true),
        (57, 3.0, true),
        (53, 1.0, false),
        (57, 3.0, false),
    ];
    for ((count, mixed, ledger), coulomb, history) in crowds.into_iter().flat_map(|ratio| {
        limits.into_iter().flat_map(move |c| histories.into_iter().map(move |h| (ratio, c, h)))
    }) {
        let mut model = test_scenes::wide_sizes(count, mixed);
        crowd(&mut model);
        let turn = Motion::Rotate { origin: Vec3::x() * 0.01, axis: Vec3::y(), rate: 3.0 };
        let motion = if mixed == 1.0 { Motion::Still } else { turn };
        test_scenes::add_plane(&mut model, Vec3::zeros(), Vec3::new(0.3, 0.5, 1.0), motion);
        test_scenes::add_plane(&mut model, Vec3::x() * 1e-3, Vec3::x(), Motion::Still);
        model.plan.law = Law { coulomb, history, ..model.plan.law };
        model.plan.ledger = ledger;
        let setting = Setting::new(&model);
        assert_eq!(setting.alike.is_some(), mixed == 1.0);
        let state = listed(&setting);
        rests += state.pairs.partner.len() % GROUP;
        assert!(state.planes.partner.len() > GROUP);
        let plain = compared::<false>(&setting, &state);
        assert_ne!(plain, compared::<true>(&setting, &state), "{mixed} {coulomb:?}");
        touching += count_ones(&plain);
    }
    assert!(touching > 500 && rests > 0, "{touching} {rests}");
}

/// A state with its lists.
fn listed(setting: &Setting<'_>) -> State {
    let mut state = State::new(setting);
    neighbours::rebuild(setting, &mut state, &Crew::new(1));
    state
}

/// What a pass of every version on this processor gives, fused or not: the same bytes.
fn compared<const FUSED: bool>(setting: &Setting<'_>, state: &State) -> Bits {
    let plain = passes::<Plain<FUSED>>(setting, state, false);
    #[cfg(target_arch = "x86_64")]
    {
        if <Four>::is_here() {
            assert_eq!(plain, passes::<Four<FUSED>>(setting, state, false));
        }
        if <Eight>::is_here() {
            assert_eq!(plain, passes::<Eight<FUSED>>(setting, state, false));
        }
    }
    plain
}

/// How often contacts touched, and a little more.
fn count_ones(bits: &Bits) -> usize {
    bits.iter().filter(|bits| **bits == 1).count()
}

#[test]
fn only_leapfrog_is_fused() {
    let schemes = [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Lammps, Scheme::Yade];
    for scheme in schemes {
        let mut model = test_scenes::wide_sizes(57, 3.0);
        crowd(&mut model);
        test_scenes::add_plane(&mut model, Vec3::zeros(), Vec3::new(0.3, 0.5, 1.0), Motion::Still);
        (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
        let setting = Setting::new(&model);
        let state = listed(&setting);
        let found = passes::<Plain>(&setting, &state, true);
        let fused = compared::<true>(&setting, &state);
        let rounded = compared::<false>(&setting, &state);
        assert_ne!(fused, rounded);
        let wanted = if scheme == Scheme::Leapfrog { fused } else { rounded };
        assert!(found == wanted, "{scheme:?}");
    }
}

#[test]
fn all_versions_average_alike() {
    let laws = [
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (2e3, 0.0, 0.0, 0.4),
        (2e3, 1.0, 0.0, 0.4),
        (2e3, 1.0, 0.5, 0.4),
    ];
    let mut touching = 0;
    let crowds = [(53, 1.0), (57, 3.0)];
    for ((count, mixed), (kt, cn, ct, friction), clumps) in crowds
        .into_iter()
        .flat_map(|crowd| laws.into_iter().map(move |law| (crowd, law)))
        .flat_map(|(crowd, law)| [(crowd, law, 0), (crowd, law, 4)])
    {
        let mut model = test_scenes::wide_sizes(count, mixed);
        let contact = Contact { kn: 1e4, kt, cn, ct, friction };
        model.contacts = ContactTable::uniform(1, contact);
        (model.plan.scheme, model.plan.law) = (Scheme::PathAveraged, Scheme::PathAveraged.law());
        model.plan.step = 1e-5;
        for at in 0..clumps {
            let place = Vec3::new(0.01 * f64::from(at), 0.0, 0.01);
            let turn = Rotation::from_scaled_axis(place * 30.0);
            test_scenes::add_clump(&mut model, place, turn, Vec3::zeros(), Vec3::zeros());
        }
        crowd(&mut model);
        let turn = Motion::Rotate { origin: Vec3::x() * 0.01, axis: Vec3::y(), rate: 3.0 };
        let motion = if mixed == 1.0 { Motion::Still } else { turn };
        test_scenes::add_plane(&mut model, Vec3::zeros(), Vec3::new(0.3, 0.5, 1.0), motion);
        test_scenes::add_plane(&mut model, Vec3::x() * 1e-3, Vec3::x(), Motion::Still);
        let setting = Setting::new(&model);
        assert_eq!(setting.alike.is_some(), mixed == 1.0 && clumps == 0);
        touching += count_ones(&compared::<false>(&setting, &listed(&setting)));
    }
    assert!(touching > 2000, "{touching}");
}

#[test]
#[should_panic(expected = "assertion failed")]
fn spheres_that_do_not_exist_are_refused() {
    let mut model = test_scenes::wide_sizes(53, 1.0);
    crowd(&mut model);
    let setting = Setting::new(&model);
    let mut state = State::new(&setting);
    neighbours::rebuild(&setting, &mut state, &Crew::new(1));
    let mut partner = Vec::from(std::mem::take(&mut state.pairs.partner));
    let middle = partner.len() / 2;
    partner[middle] = state.balls.len() as u32;
    state.pairs.partner = partner.into();
    passes::<Plain>(&setting, &state, false);
}
