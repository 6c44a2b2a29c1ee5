//! Bodies: closed forms, clumps as our own DEM has them.

use super::bench::*;

/// Restitution of a linear spring-dashpot contact that may not pull
/// (Schwager & Pöschel 2007, Granular Matter 9, 465, eq. 21).
#[test]
fn one_bounce_has_the_closed_form_restitution() {
    let mut model = model(Dimension::Three, Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let start = Vec3::new(0.0, 0.0, 1.01e-3);
    add_sphere(&mut model, start, Vec3::new(0.0, 0.0, -0.1), Vec3::zeros());
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    (model.plan.step, model.plan.steps) = (1e-7, 4000);
    let mass = model.bodies[0].mass;
    let decay = CONTACT.cn / (2.0 * mass);
    let rate = (CONTACT.kn / mass - decay * decay).sqrt();
    let angle = std::f64::consts::PI - (2.0 * decay * rate).atan2(rate * rate - decay * decay);
    let expected = (-decay / rate * angle).exp();
    for solver in solver::all() {
        let Some(run) = finished(solver, &model) else { continue };
        let got = last_state(&run).velocity.z / 0.1;
        let error = (got - expected).abs() / expected;
        assert!(error < 3e-3, "{}: {got} for {expected}", solver.key());
        assert!(run.cost.cpu_seconds > 0.0 && run.cost.loop_seconds.is_some(), "{:?}", run.cost);
    }
}

/// A symmetric top in free fall: the centre of mass follows the parabola, and
/// the angular velocity circles about the angular momentum at |L| / I₁ (Euler).
#[test]
fn a_spinning_clump_in_free_fall_follows_the_closed_forms() {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(0.5, 0.0, -9.81);
    let (inertia, spin) = (Vec3::new(1.2e-11, 1.2e-11, 1.9e-11), Vec3::new(300.0, -150.0, 450.0));
    let velocity = Vec3::new(0.1, 0.2, 0.3);
    add_clump(&mut model, Vec3::new(1e-3, 0.0, 2e-3), velocity, spin, inertia);
    model.plan.steps = 4000;
    let start = model.bodies[0].clone();
    let axes = start.orientation.to_rotation_matrix();
    let tensor = axes.matrix() * Mat3::from_diagonal(&inertia) * axes.matrix().transpose();
    let momentum = tensor * spin;
    let time = model.plan.duration();
    let circle = Rotation::from_scaled_axis(momentum / inertia.x * time);
    // YADE turns clumps to first order in the step, so its error is the step times the rate.
    for (solver, tolerance) in solver::all().into_iter().zip([1e-6, 5e-3, 1e-6]) {
        let Some(run) = finished(solver, &model) else { continue };
        let state = last_state(&run);
        let place = start.position + velocity * time + model.gravity * (0.5 * time * time);
        assert!((state.position - place).norm() < 1e-15, "{}: place", solver.key());
        let error = (state.spin - circle * spin).norm() / spin.norm();
        assert!(error < tolerance, "{}: spin off by {error:e}", solver.key());
        let turned = state.orientation.to_rotation_matrix();
        let tensor = turned.matrix() * Mat3::from_diagonal(&inertia) * turned.matrix().transpose();
        let error = (tensor * state.spin - momentum).norm() / momentum.norm();
        assert!(error < tolerance, "{}: angular momentum off by {error:e}", solver.key());
    }
}

/// What the solvers make of the mass properties that the deck gives them.
#[test]
fn clumps_weigh_what_the_model_says() {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    let spin = Vec3::new(300.0, -150.0, 450.0);
    add_clump(&mut model, Vec3::new(1e-3, 0.0, 2e-3), Vec3::new(1.0, 2.0, 3.0), spin, inertia);
    model.plan.steps = 10;
    let [liggghts, yade, _] = solver::all();
    if let Some(run) = finished(liggghts, &model) {
        // At step 0 forces are weights, and the spin is what fix rigid makes of L and I.
        let frame = &run.frames[0];
        let weight: Vec3 = frame.forces.iter().sum();
        assert!((weight - model.gravity * 2e-5).norm() < 1e-13 * 2e-4);
        let torque: Vec3 = frame
            .centres
            .iter()
            .zip(&frame.forces)
            .map(|(centre, force)| (centre - model.bodies[0].position).cross(force))
            .sum();
        assert!(torque.norm() < 1e-13 * 2e-4 * 1e-3, "{torque:?}");
        assert!((frame.bodies[0].spin - spin).norm() < 1e-11 * spin.norm());
        assert!((frame.bodies[0].velocity - model.bodies[0].velocity).norm() < 1e-12);
    }
    if !installed(yade) {
        return;
    }
    let room = tempfile::tempdir().expect("temporary folder");
    let folder = room.path().join("yade");
    yade.write(&model, &folder, &DeckOptions::default()).expect("written");
    let script = folder.join("run.py");
    let text = std::fs::read_to_string(&script).expect("there");
    let said =
        "s = O.bodies[clumps[0]].state\nprint('says', digits((s.mass,), s.inertia, s.pos))\n";
    std::fs::write(&script, text.replace("\nsteps = ", &format!("\n{said}steps = ")))
        .expect("written");
    let output = std::process::Command::new("sh").arg(folder.join("run.sh")).output().expect("sh");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find_map(|line| line.strip_prefix("says ")).expect("the line");
    let numbers: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
    let position = model.bodies[0].position;
    let expected = [2e-5, inertia.x, inertia.y, inertia.z, position.x, position.y, position.z];
    for (got, expected) in numbers.iter().zip(expected) {
        assert!((got - expected).abs() <= 1e-14 * expected.abs(), "{numbers:?}");
    }
}

/// The centre of mass lies outside the hull of the sphere centres: no masses of
/// the spheres balance, yet velocity and spin must start right.
#[test]
fn clumps_out_of_balance_start_right_and_fly_straight() {
    let mut model = model(Dimension::Three, CONTACT);
    let (velocity, spin) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(300.0, -150.0, 450.0));
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::zeros(), velocity, spin, inertia);
    model.spheres.iter_mut().for_each(|sphere| sphere.offset.x += 3e-3);
    let liggghts = solver::all()[0];
    let Some(run) = finished(liggghts, &model) else { return };
    let start = run.frames[0].bodies[0];
    assert!((start.spin - spin).norm() < 1e-10 * spin.norm(), "{start:?}");
    assert!((start.velocity - velocity).norm() < 1e-12, "{start:?}");
    let end = last_state(&run);
    assert!((end.position - velocity * model.plan.duration()).norm() < 1e-14, "{end:?}");
}

/// Gravity must act at the centre of mass even where no masses of the spheres
/// balance about it.
#[test]
fn clumps_out_of_balance_fall_and_bounce_like_our_own() {
    let liggghts = solver::all()[0];
    if let Some(worst) = twin_differences(liggghts, &tumbling()) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
    }
    let mut flat = model(Dimension::Two, CONTACT);
    flat.gravity = Vec3::new(0.0, -9.81, 0.0);
    let spin = Vec3::z() * 300.0;
    add_pair(&mut flat, Vec3::new(0.0, 2.5e-3, 0.0), Vec3::new(0.1, -0.5, 0.0), spin);
    add_plane(&mut flat, "floor", Vec3::zeros(), Vec3::y(), Motion::Still);
    flat.plan.steps = 4000;
    if let Some(worst) = twin_differences(liggghts, &flat) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "in two dimensions: {worst:?}");
    }
}

/// YADE's clumps have our axes, so that even their spins are ours to rounding.
#[test]
fn clumps_tumble_in_yade_like_our_own() {
    let mut model = tumbling();
    // YADE may turn the axes of equal moments as it likes, and of falling ones it must.
    model.bodies[1].inertia = Vec3::new(1.4e-11, 1.1e-11, 1.1e-11);
    model.plan.scheme = Scheme::Yade;
    model.plan.law = Scheme::Yade.law();
    if let Some(worst) = twin_differences(solver::all()[1], &model) {
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{worst:?}");
    }
}
