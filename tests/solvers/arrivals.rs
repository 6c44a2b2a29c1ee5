//! Spheres that come during the run.

use super::bench::*;

/// Spheres that rain on each other and on a floor, some of them there from the start.
fn rain(dimension: Dimension, from_start: usize) -> Model {
    let mut model = match dimension {
        Dimension::Two => flat_scene(CONTACT),
        Dimension::Three => {
            let mut model = model(dimension, Contact { ct: 0.05, ..CONTACT });
            model.gravity = Vec3::new(1.5, 0.5, -9.81);
            add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
            add_plane(&mut model, "side", Vec3::x() * 4e-3, -Vec3::x(), Motion::Still);
            model
        }
    };
    let flat = dimension == Dimension::Two;
    let up = if flat { Vec3::y() } else { Vec3::z() };
    let spin = if flat { Vec3::z() * 40.0 } else { Vec3::new(20.0, -60.0, 5.0) };
    for i in 0..9_u32 {
        // Discs start above the two that `flat_scene` holds, and bounce higher.
        let [first, later] = if flat { [4e-3, 9e-3] } else { [3e-3, 6e-3] };
        let height = if (i as usize) < from_start { first } else { later };
        let place = Vec3::x() * (-3e-3 + 2.7e-3 * f64::from(i % 3)) + up * height;
        add_sphere(&mut model, place, up * -1.5 + Vec3::x() * 0.1, spin);
        let (body, first) = (model.bodies.len() - 1, model.spheres.len() - 1);
        if i % 2 == 1 && !flat {
            // Two sizes.
            model.spheres[first].radius = 0.7e-3;
            let other = Body::sphere(dimension, place, 0.7e-3, 2500.0, 0, first as u32);
            (model.bodies[body].mass, model.bodies[body].inertia) = (other.mass, other.inertia);
        }
        if i as usize >= from_start {
            model.arrivals.push(f64::from(1 + 700 * (i - from_start as u32)) * 1e-6);
        }
    }
    // Discs collide more often, which lets rounding grow.
    (model.plan.step, model.plan.frame_every) = (1e-6, 500);
    model.plan.steps = if flat { 5500 } else { 7000 };
    model
}

fn agrees(solver: &dyn Solver, mut model: Model) {
    (model.plan.scheme, model.plan.law) = solver.scheme(false);
    let Some([place, spin]) = twin_differences(solver, &model) else { return };
    assert!(place < 1e-8 && spin < 1e-7, "{}: {place:e} radii, spin {spin:e}", solver.key());
    println!("{}: {place:e} radii, spin {spin:e}", solver.key());
}

#[test]
fn spheres_that_come_are_where_our_own_are() {
    for solver in solver::all() {
        agrees(solver, rain(Dimension::Three, 3));
    }
}

#[test]
fn a_piston_meets_spheres_that_come() {
    for solver in solver::all() {
        let mut model = rain(Dimension::Three, 3);
        // A sphere touches the piston (closing at 0.3 m/s over 0.2 mm) when the second comes;
        // where the last would come the piston is already.
        model.walls[1].shape = WallShape::Plane { point: Vec3::x() * 3.6e-3, normal: -Vec3::x() };
        model.walls[1].motion = slide(-0.2, 0.0, 0.05);
        model.bodies.pop();
        model.spheres.pop();
        model.arrivals.pop();
        agrees(solver, model);
    }
}

#[test]
fn a_run_may_begin_without_any_sphere() {
    for solver in solver::all() {
        agrees(solver, rain(Dimension::Three, 0));
    }
}

#[test]
fn discs_that_come_are_where_our_own_are() {
    let [liggghts, yade, lammps] = solver::all();
    assert!(!can(liggghts, &rain(Dimension::Two, 3)));
    for solver in [yade, lammps] {
        agrees(solver, rain(Dimension::Two, 3));
    }
}

#[test]
fn two_ranks_of_liggghts_insert_as_one() {
    let liggghts = solver::all()[0];
    let model = rain(Dimension::Three, 3);
    let ends = [1, 2].map(|ranks| {
        let options = DeckOptions { ranks, ..DeckOptions::default() };
        run(liggghts, &model, &options).and_then(|run| run.frames.into_iter().last())
    });
    let [Some(one), Some(two)] = ends else { return };
    let far = one.centres.iter().zip(&two.centres).map(|(a, b)| (a - b).norm() / 1e-3);
    assert!(far.fold(0.0, f64::max) < 1e-8);
}

#[test]
fn what_cannot_be_inserted_is_refused() {
    let mut clumps = rain(Dimension::Three, 3);
    let still = Vec3::zeros();
    add_clump(
        &mut clumps,
        Vec3::new(0.0, 9e-3, 2e-3),
        still,
        still,
        Vec3::new(1.1e-11, 1.4e-11, 1.9e-11),
    );
    let mut periodic = rain(Dimension::Three, 3);
    periodic.walls.clear();
    periodic.periodic = Some(Cell { bounds: periodic.domain, periodic: [true; 3] });
    let mut restarts = rain(Dimension::Three, 3);
    restarts.decks.restarts = 2;
    for solver in solver::all() {
        assert!(can(solver, &rain(Dimension::Three, 3)), "{}", solver.key());
        for model in [&clumps, &periodic, &restarts] {
            assert!(!can(solver, model), "{}", solver.key());
        }
    }
}
