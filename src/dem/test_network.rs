//! The step bound against eigenvalues of matrices put together independently, and
//! against runs just below and above the limit.

use super::network::Network;
use super::setting::Setting;
use super::state::State;
use super::test_scenes::*;
use super::*;
use crate::model::*;
use crate::num::random::{self, RngExt};
use crate::num::{Rotation, Vec3};
use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen};

/// Stiffness and dashpot matrices of a model at time 0, scaled by masses: every pair of
/// spheres and every sphere at a still plane; written without the kernels' helpers.
fn matrices(model: &Model) -> (DMatrix<f64>, DMatrix<f64>) {
    let size = 6 * model.bodies.len();
    let (mut stiff, mut damp) =
        (DMatrix::<f64>::zeros(size, size), DMatrix::<f64>::zeros(size, size));
    let centres = model.sphere_centres(&model.initial_states());
    let mut add = |first: u32, second: Option<u32>, normal: Vec3, point: Vec3| {
        let law = model.contacts.between(0, 0);
        for (direction, k, c) in frame(normal, law) {
            let mut row = DVector::<f64>::zeros(size);
            for (body, sign) in [(Some(first), 1.0), (second, -1.0)] {
                let Some(body) = body else { continue };
                let of = &model.bodies[body as usize];
                let axes = of.orientation.to_rotation_matrix().into_inner();
                let root = axes
                    * Matrix3::from_diagonal(&of.inertia.map(|i| 1.0 / i.sqrt()))
                    * axes.transpose();
                let push = direction * (sign / of.mass.sqrt());
                let twist = root * (point - of.position).cross(&direction) * sign;
                for axis in 0..3 {
                    row[6 * body as usize + axis] += push[axis];
                    row[6 * body as usize + 3 + axis] += twist[axis];
                }
            }
            stiff.ger(k, &row, &row, 1.0);
            damp.ger(c, &row, &row, 1.0);
        }
    };
    for (a, first) in model.spheres.iter().enumerate() {
        for (b, second) in model.spheres.iter().enumerate().skip(a + 1) {
            let between = centres[a] - centres[b];
            let overlap = first.radius + second.radius - between.norm();
            if first.body != second.body && overlap >= -1e-12 * first.radius {
                let normal = between.normalize();
                let point = centres[a] - normal * (first.radius - 0.5 * overlap);
                add(first.body, Some(second.body), normal, point);
            }
        }
        for wall in &model.walls {
            let WallShape::Plane { point, normal } = &wall.shape else { continue };
            let height = (centres[a] - point).dot(normal);
            if height.abs() <= first.radius {
                let normal = normal * height.signum();
                let arm = 0.5 * (first.radius + height.abs());
                add(first.body, None, normal, centres[a] - normal * arm);
            }
        }
    }
    (stiff, damp)
}

fn frame(normal: Vec3, law: &Contact) -> [(Vec3, f64, f64); 3] {
    let first =
        if normal.z.abs() < 0.9 { normal.cross(&Vec3::z()) } else { normal.cross(&Vec3::x()) };
    let first = first.normalize();
    [(normal, law.kn, law.cn), (first, law.kt, law.ct), (first.cross(&normal), law.kt, law.ct)]
}

/// Largest stable step of leapfrog with lagging dashpots, by bisection.
fn true_limit(model: &Model) -> f64 {
    let (stiff, damp) = matrices(model);
    let top = |step: f64| {
        SymmetricEigen::new(&stiff * (step * step) + &damp * (2.0 * step)).eigenvalues.max()
    };
    let mut high = 2.0 / SymmetricEigen::new(stiff.clone()).eigenvalues.max().sqrt();
    if damp.norm() == 0.0 {
        return high;
    }
    let mut low = 0.0;
    // Down to digits of a limit far below that without dashpots.
    for _ in 0..26 {
        let middle = 0.5 * (low + high);
        if top(middle) > 4.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Block bound and sharpened bound, s.
fn bounds(model: &Model) -> [f64; 2] {
    let setting = Setting::new(model);
    let mut state = State::new(&setting);
    neighbours::rebuild(&setting, &mut state, &crate::dem::crew::Crew::new(1));
    let network = Network::new(&setting, &state, 0.0);
    [0.0, f64::INFINITY].map(|enough| network.limit(enough).expect("contacts").step)
}

/// Spheres at places in radii.
fn spheres(kt: f64, places: &[Vec3]) -> Model {
    let mut model = empty(Scheme::Leapfrog, contact(kt * KN, 0.0, 0.0, 1.0));
    for place in places {
        add_sphere(&mut model, place * RADIUS, RADIUS, Vec3::zeros(), Vec3::zeros());
    }
    model
}

fn grid(n: i32) -> impl Iterator<Item = Vec3> {
    (0..n * n * n)
        .map(move |i| 2.0 * Vec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n)))
}

/// A heap of grains pushed into each other at random: about 7 contacts each.
fn heap(law: Contact, count: u32, clumps: bool, ratio: f64, seed: u64) -> Model {
    let mut model = empty(Scheme::Leapfrog, law);
    let mut source = random::stream(seed, "heap", 0);
    for i in 0..count {
        let cell = Vec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9));
        let jitter = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.15, 0.15));
        let mut place = (cell * 1.9 + jitter + Vec3::repeat(0.95)) * RADIUS;
        if clumps && i % 2 == 0 {
            let turn = random::rotation(&mut source);
            add_clump(&mut model, place, turn, Vec3::zeros(), Vec3::zeros());
        } else {
            let radius = RADIUS * ratio.powf(-source.random::<f64>());
            if let (true, Some(last)) = (ratio > 2.0, model.spheres.last()) {
                // On the surface of the last, which is on that of the one before.
                let away = random::direction(&mut source) * (0.99 * (radius + last.radius));
                place = model.bodies[last.body as usize].position + away;
            }
            add_sphere(&mut model, place, radius, Vec3::zeros(), Vec3::zeros());
        }
    }
    add_plane(&mut model, Vec3::zeros(), Vec3::z(), Motion::Still);
    add_plane(&mut model, Vec3::zeros(), Vec3::new(1.0, 0.0, 0.3), Motion::Still);
    model
}

fn judge(name: &str, model: &Model, least: f64) {
    let limit = true_limit(model);
    // Where dashpots rule, the step goes with the eigenvalue and not with its root.
    let damped = model.contacts.between(0, 0).cn > 0.0;
    let least = if damped { least * least } else { least };
    let [block, sharp] = bounds(model).map(|bound| bound / limit);
    println!("{name}: block {block:.3}, sharpened {sharp:.3}");
    assert!(block <= 1.0 + 1e-6 && block > least, "{name}: block {block}");
    assert!(sharp <= 1.0 + 1e-6 && sharp > 0.9, "{name}: sharpened {sharp}");
}

#[test]
fn lattices_have_their_known_limits_and_bounds_below_them() {
    let root = std::f64::consts::SQRT_2;
    let faces = grid(2).flat_map(|p| {
        [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0)]
            .map(|(x, y, z)| (p + Vec3::new(x, y, z)) * root)
    });
    // Limits of infinite lattices, and of a pair, in √(m/kn) by kt/kn = 0, 2/7, 0.5, 0.8, 1, 2.
    let cases: [(&str, Vec<Vec3>, [f64; 6], f64); 3] = [
        (
            "pair",
            vec![Vec3::zeros(), Vec3::x() * 2.0],
            [1.414, 1.414, 1.069, 0.845, 0.756, 0.535],
            2e-3,
        ),
        ("cubic", grid(3).collect(), [1.052, 0.831, 0.654, 0.517, 0.463, 0.327], 0.12),
        ("face-centred", faces.collect(), [0.732, 0.610, 0.461, 0.364, 0.326, 0.230], 0.2),
    ];
    for (name, places, limits, larger) in cases {
        for (kt, known) in [0.0, 2.0 / 7.0, 0.5, 0.8, 1.0, 2.0].iter().zip(limits) {
            let model = spheres(*kt, &places);
            let limit = true_limit(&model) / (MASS / KN).sqrt();
            // A piece of a lattice is a little softer than the whole.
            assert!(limit > known * 0.999 && limit < known * (1.0 + larger), "{name} {kt} {limit}");
            judge(&format!("{name} {kt}"), &model, 0.8);
        }
    }
}

#[test]
fn beds_clumps_and_wide_sizes_have_bounds_close_below_their_limits() {
    for (kt, cn, ct) in
        [(0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (1.0, 20.0, 0.0), (0.3, 20.0, 12.0), (0.0, 5.0, 90.0)]
    {
        let law = contact(kt * KN, cn, ct, 0.5);
        for (clumps, ratio, seed) in
            [(false, 1.2, 1), (true, 1.2, 2), (false, 30.0, 3), (true, 5.0, 4)]
        {
            let model = heap(law, 18, clumps, ratio, seed);
            judge(&format!("kt {kt} cn {cn} ct {ct} clumps {clumps} ratio {ratio}"), &model, 0.8);
        }
    }
    // One sphere a thousand times the size of another: the small one alone governs.
    let mut model = spheres(0.3, &[]);
    add_sphere(&mut model, Vec3::zeros(), 1000.0 * RADIUS, Vec3::zeros(), Vec3::zeros());
    add_sphere(&mut model, Vec3::x() * 1001.0 * RADIUS, RADIUS, Vec3::zeros(), Vec3::zeros());
    judge("1 : 1000", &model, 0.99);
}

/// Largest kinetic energy of a run from a state at rest with a small kick, over that of the
/// kick. An unstable pack may shake itself loose and come to rest again.
fn largest_energy(model: &Model, step: f64) -> f64 {
    let mut model = model.clone();
    (model.plan.step, model.plan.insist) = (step, true);
    (model.plan.steps, model.plan.series_every) = (1500, 20);
    for (i, body) in model.bodies.iter_mut().enumerate() {
        body.velocity = Vec3::new(1.0, 0.5, -0.7) * (if i % 2 == 0 { 1e-7 } else { -1e-7 });
    }
    model.plan.guard.gain = 0.0;
    let run = run(&model, &Job::quiet()).expect("a usable model");
    if run.outcome != Outcome::Finished {
        return f64::INFINITY;
    }
    let largest = run.series.iter().map(|row| row.kinetic).fold(0.0, f64::max);
    largest / run.series[0].kinetic
}

#[test]
fn runs_are_quiet_below_the_limit_and_grow_above_it() {
    // A block pressed together by prestress: contacts stay closed while motions are small.
    let places: Vec<Vec3> = grid(2).map(|p| p * 0.995).collect();
    for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade, Scheme::PathAveraged] {
        for cn in [0.0, 15.0] {
            let mut model = spheres(0.5, &places);
            model.contacts = ContactTable::uniform(1, contact(0.5 * KN, cn, 0.5 * cn, 1e3));
            model.plan.scheme = scheme;
            model.plan.law = scheme.law();
            // Held together by walls.
            for axis in 0..3 {
                let mut normal = Vec3::zeros();
                normal[axis] = 1.0;
                add_plane(&mut model, normal * -0.99 * RADIUS, normal, Motion::Still);
                add_plane(&mut model, normal * 2.98 * RADIUS, -normal, Motion::Still);
            }
            for place in model.bodies.iter_mut() {
                place.orientation = Rotation::identity();
            }
            let [_, sharp] = bounds(&model);
            let quiet = largest_energy(&model, sharp);
            assert!(quiet < 30.0, "{scheme:?} {cn} below: {quiet}");
            let wild = largest_energy(&model, 1.15 * sharp);
            println!("{scheme:?} {cn}: {quiet:.2e} {wild:.2e}");
            assert!(wild > 1e3, "{scheme:?} {cn} above: {wild}");
        }
    }
}
