//! Cohesion, rolling, drag, and what is refused.

use super::bench::*;

/// Two spheres and a clump that spin and meet each other and a floor, with forces besides the
/// linear contact.
fn clinging(forces: PairForces, drag: f64) -> Model {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    model.extra = Extra::uniform(1, forces);
    model.extra.drag = drag;
    model.gravity = Vec3::new(1.0, 0.0, -9.81);
    let spin = Vec3::new(200.0, -150.0, 300.0);
    add_sphere(&mut model, Vec3::new(0.0, 0.0, 1.02e-3), Vec3::new(0.1, 0.0, -0.2), spin);
    add_sphere(&mut model, Vec3::new(1.2e-3, 0.3e-3, 2.8e-3), Vec3::new(0.0, 0.1, -0.4), -spin);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::new(6e-3, 0.0, 2.4e-3), Vec3::new(-0.3, 0.0, -0.3), spin, inertia);
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.plan.steps = 4000;
    model
}

/// Cohesion, resistance to rolling and drag as LIGGGHTS computes them, to rounding.
#[test]
fn cohesion_rolling_and_drag_agree_with_liggghts() {
    let liggghts = solver::all()[0];
    let energy_density = EnergyDensity(3e4);
    let cases = [
        (Some(Cohesion::Sjkr { energy_density }), Some(Rolling::Cdt { coefficient: 0.2 }), 0.0),
        (Some(Cohesion::Sjkr2 { energy_density }), Some(Rolling::Epsd2 { coefficient: 0.2 }), 0.0),
        (None, Some(Rolling::Epsd { coefficient: 0.3, damping: 0.0 }), 1e-3),
    ];
    for (cohesion, rolling, drag) in cases {
        let forces = PairForces { cohesion, rolling, ..PairForces::default() };
        let mut model = clinging(forces, drag);
        if drag > 0.0 {
            // LIGGGHTS' set-up pass does not know the spins of clumps yet.
            model.bodies[2].spin = Vec3::zeros();
        }
        if let Some(worst) = twin_differences(liggghts, &model) {
            assert!(worst.iter().all(|worst| *worst < 1e-9), "{forces:?} {drag}: {worst:?}");
        }
    }
    // The damped rolling spring, without the clump.
    let law = Rolling::Epsd { coefficient: 0.3, damping: 0.4 };
    let mut model = clinging(PairForces { rolling: Some(law), ..PairForces::default() }, 0.0);
    model.spheres.truncate(2);
    model.bodies.truncate(2);
    if let Some(worst) = twin_differences(liggghts, &model) {
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{worst:?}");
    }
}

/// What the decks cannot say is refused, not dropped.
#[test]
fn forces_that_decks_cannot_say_are_refused() {
    let bridge = Bridge {
        surface_tension: SurfaceTension(0.07),
        volume: Volume(1e-13),
        angle: Default::default(),
    };
    let linear = Cohesion::Linear { pull: Force(1e-3), range: Length(1e-4) };
    let none = PairForces::default();
    let cases = [
        (PairForces { bridge: Some(bridge), ..none }, "liquid bridges"),
        (PairForces { cohesion: Some(linear), ..none }, "cohesion"),
    ];
    for (forces, what) in cases {
        let model = clinging(forces, 0.0);
        let mut in_a_mesh = model.clone();
        in_a_mesh.walls[0].shape = sheet();
        for (solver, model) in
            solver::all().into_iter().flat_map(|s| [(s, &model), (s, &in_a_mesh)])
        {
            let limits = solver.limits(model);
            let refused = |limit: &solver::Limit| {
                limit.kind == LimitKind::Refused && limit.what.contains(what)
            };
            assert!(limits.iter().any(refused), "{} {what}", solver.key());
        }
    }
}

/// A floor of two triangles.
fn sheet() -> WallShape {
    let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0) * 0.02;
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    WallShape::Mesh { mesh: Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] } }
}
