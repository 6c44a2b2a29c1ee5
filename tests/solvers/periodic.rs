//! Periodic boxes.

use super::bench::*;

/// Spheres in a small box that meet across its sides; in LIGGGHTS and LAMMPS on a floor, in YADE in a box
/// that repeats itself along all axes.
fn across_sides(scheme: Scheme) -> Model {
    let mut model = model(Dimension::Three, CONTACT);
    let bounds = Bounds { low: Vec3::zeros(), high: Vec3::new(5e-3, 5.5e-3, 6e-3) };
    let all = scheme == Scheme::Yade;
    model.periodic = Some(Cell { bounds, periodic: [true, true, all] });
    model.domain = bounds;
    (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
    if !all {
        model.gravity = Vec3::new(3.0, 0.0, -9.81);
        add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    }
    let spin = Vec3::new(100.0, -200.0, 50.0);
    let spheres = [
        ([0.9, 1.0, 1.3], [-0.5, 0.0, -0.1]),
        ([3.5, 1.2, 1.5], [0.3, 0.1, 0.0]),
        ([2.2, 4.4, 3.6], [0.2, 0.9, -0.6]),
        ([4.6, 3.2, 1.2], [0.4, 0.3, 0.2]),
    ];
    for (place, velocity) in spheres {
        add_sphere(&mut model, Vec3::from(place) * 1e-3, Vec3::from(velocity), spin);
    }
    model.plan.steps = 5000;
    model
}

#[test]
fn pairs_that_meet_across_a_periodic_side_agree() {
    for (solver, scheme) in
        solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade, Scheme::Lammps])
    {
        let model = across_sides(scheme);
        let mut open = model.clone();
        (open.periodic, open.domain) =
            (None, Bounds { low: Vec3::repeat(-0.1), high: Vec3::repeat(0.1) });
        let end = |model: &Model| {
            let run = dem::run(model, &Job::quiet()).expect("a run");
            run.frames.last().expect("frames").bodies[0].velocity
        };
        assert!((end(&model) - end(&open)).norm() > 0.1, "they meet across the side");
        let Some(worst) = twin_differences(solver, &twin_of(solver, model)) else { continue };
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{}: {worst:?}", solver.key());
    }
}

/// The model in the scheme and law of the solver.
fn twin_of(solver: &dyn Solver, mut model: Model) -> Model {
    model = solver.twin(&model);
    model
}

/// LIGGGHTS and LAMMPS keep clumps whole across a side.
#[test]
fn clumps_cross_a_periodic_side_like_our_own() {
    let mut model = across_sides(Scheme::Liggghts);
    model.bodies.clear();
    model.spheres.clear();
    let cell = model.periodic.as_mut().expect("periodic");
    cell.bounds.high = Vec3::new(10e-3, 9e-3, 9e-3);
    model.domain = cell.bounds;
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(100.0, -200.0, 150.0);
    add_clump(&mut model, Vec3::new(1.5e-3, 4e-3, 3e-3), Vec3::new(-0.6, 0.0, -0.4), spin, inertia);
    add_sphere(&mut model, Vec3::new(7.5e-3, 4.3e-3, 1.5e-3), Vec3::new(0.3, 0.0, 0.0), -spin);
    let [liggghts, _, lammps] = solver::all();
    for solver in [liggghts, lammps] {
        let model = twin_of(solver, model.clone());
        let Some(worst) = twin_differences(solver, &model) else { continue };
        assert!(worst.iter().all(|worst| *worst < 1e-9), "{}: {worst:?}", solver.key());
    }
}
