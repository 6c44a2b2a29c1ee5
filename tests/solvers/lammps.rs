//! LAMMPS against our own DEM in its scheme.

use super::bench::*;

/// LAMMPS against our own run of its scheme and of the law of `granular`.
fn lammps_differs(model: &Model) -> Option<f64> {
    let lammps = solver::all()[2];
    let mut model = model.clone();
    (model.plan.scheme, model.plan.law) = lammps.scheme(false);
    twin_differences(lammps, &model).map(|[place, spin]| place.max(spin))
}

#[test]
fn pairs_in_lammps_are_our_own() {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    let spin = Vec3::new(200.0, -150.0, 300.0);
    add_sphere(&mut model, Vec3::zeros(), Vec3::new(0.5, 0.1, 0.0), spin);
    add_sphere(&mut model, Vec3::new(1.9e-3, 0.7e-3, 0.3e-3), Vec3::zeros(), -spin);
    model.spheres[1].radius = 0.7e-3;
    let body = &mut model.bodies[1];
    *body = Body::sphere(Dimension::Three, body.position, 0.7e-3, 2500.0, 0, 1);
    (body.velocity, body.spin) = (Vec3::new(-0.4, 0.0, 0.1), -spin);
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
}

#[test]
fn beds_in_lammps_are_our_own() {
    let mut model = model(Dimension::Three, Contact { ct: 0.1, ..CONTACT });
    model.gravity = Vec3::new(1.0, 0.0, -9.81);
    for i in 0..27_u32 {
        let [x, y, z] = [i % 3, i / 3 % 3, i / 9].map(f64::from);
        let at = Vec3::new(x + 0.07 * z, y - 0.05 * z, z + 0.52) * 2.02e-3;
        let spin = Vec3::new(20.0 * x, -30.0 * y, 10.0);
        add_sphere(&mut model, at, Vec3::new(0.05 * y, 0.0, -0.2), spin);
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    add_plane(&mut model, "side", Vec3::new(5.5e-3, 0.0, 0.0), -Vec3::x(), Motion::Still);
    add_plane(&mut model, "belt", Vec3::new(-1.05e-3, 0.0, 0.0), Vec3::x(), slide(0.0, 0.1, 0.0));
    model.plan.steps = 2000;
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
}

#[test]
fn clumps_in_lammps_are_our_own() {
    // Two spheres do not tell how their clump has turned about their line.
    let mut model = tumbling();
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(300.0, -150.0, 450.0);
    model.bodies.clear();
    model.spheres.clear();
    for x in [0.0, 3.5e-3] {
        let at = Vec3::new(x, 0.2 * x, 3e-3 + 0.3 * x);
        add_clump(&mut model, at, Vec3::new(0.1 - 100.0 * x, 0.0, -0.5), spin, inertia);
    }
    add_sphere(&mut model, Vec3::new(0.2e-3, 0.0, 1.0e-3), Vec3::zeros(), Vec3::zeros());
    if let Some(worst) = lammps_differs(&model) {
        assert!(worst < 1e-10, "{worst:e}");
    }
    let mut flat = flat_scene(Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let at = Vec3::new(-6e-3, 2.05e-3, 0.0);
    let inertia = Vec3::new(3e-9, 5e-9, 8e-9);
    add_clump(&mut flat, at, Vec3::new(0.1, -0.5, 0.0), Vec3::z() * 30.0, inertia);
    flat.bodies[2].mass = 0.02;
    if let Some(worst) = lammps_differs(&flat) {
        assert!(worst < 1e-10, "in two dimensions: {worst:e}");
    }
}

#[test]
fn pistons_and_discs_in_lammps_are_our_own() {
    let close = |what: &str, model: &Model| {
        if let Some(worst) = lammps_differs(model) {
            assert!(worst < 1e-10, "{what}: {worst:e}");
        }
    };
    let piston = |contact: Contact, normal: Vec3| {
        let (mut model, normal) = (model(Dimension::Three, contact), normal.normalize());
        add_sphere(&mut model, normal * 1.01e-3, normal * -0.2, Vec3::new(0.0, 20.0, 0.0));
        add_plane(&mut model, "piston", Vec3::zeros(), normal, slide(0.1, 0.0, 0.3));
        model
    };
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    let mut model = piston(CONTACT, Vec3::z());
    close("piston", &model);
    close("oblique piston", &piston(smooth, Vec3::new(0.3, 0.1, 1.0)));
    model.extra.drag = 1e-4;
    close("drag", &model);
    let meets = |normal: Vec3, motion: Motion| {
        let (mut model, normal) =
            (super::bench::model(Dimension::Three, CONTACT), normal.normalize());
        // Not a whole number of steps away: rounding would say in which one they meet.
        let velocity = Vec3::new(0.05, 0.02, 0.0) - normal * 0.2;
        add_sphere(&mut model, normal * 1.0103e-3, velocity, Vec3::new(0.0, 20.0, 0.0));
        add_plane(&mut model, "wall", Vec3::zeros(), normal, motion);
        model
    };
    close("slope", &meets(Vec3::new(0.3, 0.1, 1.0), Motion::Still));
    close("oblique piston with friction", &piston(CONTACT, Vec3::new(0.3, 0.1, 1.0)));
    close("table", &meets(Vec3::z(), turn(Vec3::z())));
    close("paddle", &meets(Vec3::z(), turn(Vec3::y())));
    close("oblique paddle", &meets(Vec3::new(0.3, 0.1, 1.0), turn(Vec3::new(0.6, 0.0, 0.8))));
    close("discs without friction", &flat_scene(smooth));
    close("discs", &flat_scene(CONTACT));
}
