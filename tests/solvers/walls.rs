//! Walls of every kind and motion.

use super::bench::*;

/// A sphere on a table of triangles that turns, far from the axis.
#[test]
fn turning_facets_agree_with_our_own() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        let mut model = model(Dimension::Three, CONTACT);
        let corner = |x: f64, y: f64| Vec3::new(x * 15e-3, y * 15e-3, 0.0);
        let mesh = Mesh {
            vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
            triangles: vec![[0, 1, 2]],
        };
        let axis = Vec3::new(0.1, 0.0, 1.0).normalize();
        let motion = Motion::Rotate { origin: Vec3::new(-6e-3, 0.0, 0.0), axis, rate: -40.0 };
        let shape = WallShape::Mesh { mesh };
        model.walls.push(Wall { name: "table".into(), shape, motion, material: 0 });
        let down = Vec3::new(0.0, 0.0, -0.2);
        add_sphere(&mut model, Vec3::new(0.0, -2e-3, 1.01e-3), down, Vec3::zeros());
        (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
        model.gravity = Vec3::new(0.0, 0.0, -300.0);
        model.plan.steps = 3000;
        let Some(worst) = twin_differences(solver, &model) else { continue };
        assert!(worst.iter().all(|worst| *worst < 1e-10), "{}: {worst:?}", solver.key());
    }
}

/// A sphere that meets a plane which a solver has to take in another form.
fn wall_agrees(name: &str, normal: Vec3, motion: Motion) {
    let mut model = model(Dimension::Three, CONTACT);
    let normal = normal.normalize();
    // Not a whole number of steps away: rounding would say in which one they meet.
    add_sphere(&mut model, normal * 1.0103e-3, normal * -0.2, Vec3::new(0.0, 20.0, 0.0));
    add_plane(&mut model, name, Vec3::zeros(), normal, motion);
    model.plan.steps = 500;
    let Some(worst) = worst_difference(&model) else { return };
    // What is left is the lever arm at planes and how the spring turns: 0.3 % of
    // the tangential motion, some 0.02 m/s over 0.4 ms.
    assert!(worst < 5e-8, "{name}: {worst:e} m");
}

#[test]
fn oblique_planes_agree() {
    wall_agrees("slope", Vec3::new(0.3, 0.1, 1.0), Motion::Still);
}

#[test]
fn sliding_planes_agree() {
    wall_agrees("belt", Vec3::z(), slide(0.2, 0.0, 0.0));
    wall_agrees("belt_two_ways", Vec3::z(), slide(0.2, 0.1, 0.0));
}

#[test]
fn pistons_agree() {
    wall_agrees("piston", Vec3::z(), slide(0.0, 0.0, 0.3));
}

#[test]
fn oblique_pistons_agree() {
    wall_agrees("oblique_piston", Vec3::new(0.3, 0.1, 1.0), slide(0.1, 0.0, 0.3));
}

#[test]
fn turning_planes_agree() {
    wall_agrees("table", Vec3::z(), turn(Vec3::z()));
}

#[test]
fn paddles_agree() {
    wall_agrees("paddle", Vec3::z(), turn(Vec3::y()));
}

/// Two spheres that meet on a floor of another, softer material without dashpot.
fn rubber_floor(contact: Contact) -> Model {
    let mut model = model(Dimension::Three, contact);
    model.materials.push(Material { name: "rubber".into(), density: 1000.0 });
    model.contacts = ContactTable::uniform(2, contact);
    let soft = Contact {
        kn: 2e3,
        kt: 0.2 * contact.kt,
        cn: 0.0,
        ct: 0.0,
        friction: 2.0 * contact.friction,
    };
    model.contacts.set(0, 1, soft);
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    for x in [0.0, 2.05e-3] {
        let at = Vec3::new(x, 0.0, 1.01e-3);
        add_sphere(&mut model, at, Vec3::new(0.1 - 50.0 * x, 0.0, -0.2), Vec3::zeros());
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    model.walls[0].material = 1;
    model
}

#[test]
fn walls_of_another_material_agree() {
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    if let Some(worst) = worst_difference(&rubber_floor(smooth)) {
        assert!(worst < 1e-14, "without friction: {worst:e} m");
    }
    // The lever arms differ by 0.7 % here (overlap 14 um), of 0.1 m/s over 1 ms.
    if let Some(worst) = worst_difference(&rubber_floor(CONTACT)) {
        assert!(worst < 7e-7, "{worst:e} m");
    }
}

/// A fan of triangles so sharp that LIGGGHTS refuses it with its own settings.
#[test]
fn needle_triangles_do_not_stop_liggghts() {
    let mut model = model(Dimension::Three, CONTACT);
    let corner = |x: f64, y: f64| Vec3::new(x * 5e-3, y * 5e-3, 0.0);
    let mesh = Mesh {
        vertices: vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
            corner(1.0, 0.994),
        ],
        triangles: vec![[0, 1, 4], [0, 4, 2], [0, 2, 3]],
    };
    add_sphere(
        &mut model,
        Vec3::new(2e-3, -2e-3, 1.01e-3),
        Vec3::new(0.0, 0.0, -0.2),
        Vec3::zeros(),
    );
    let shape = WallShape::Mesh { mesh };
    model.walls.push(Wall { name: "plate".into(), shape, motion: Motion::Still, material: 0 });
    let liggghts = solver::all()[0];
    let limits = liggghts.limits(&model);
    assert!(limits.iter().any(|l| l.kind == LimitKind::Differs && l.what.contains("curvature")));
    let Some(run) = finished(liggghts, &model) else { return };
    assert!(last_state(&run).velocity.z > 0.0);
}

/// One large triangle that stands for a plane.
fn sheet(height: f64) -> WallShape {
    let corner = |x: f64, y: f64| Vec3::new(x * 18e-3, y * 18e-3, height);
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)];
    WallShape::Mesh { mesh: Mesh { vertices, triangles: vec![[0, 1, 2]] } }
}

#[test]
fn walls_that_oscillate_agree_with_our_own() {
    for (solver, scheme) in solver::all().into_iter().zip([Scheme::Liggghts, Scheme::Yade]) {
        for mesh in [false, true] {
            let mut model = model(Dimension::Three, CONTACT);
            let motion = Motion::Oscillate {
                amplitude: Vec3::new(0.3e-3, 0.1e-3, 0.2e-3),
                frequency: 180.0,
                // LIGGGHTS starts at 0.
                phase: if scheme == Scheme::Yade { 0.7 } else { 0.0 },
            };
            add_plane(&mut model, "shaker", Vec3::zeros(), Vec3::z(), motion);
            if mesh {
                model.walls[0].shape = sheet(0.0);
            }
            let down = Vec3::new(0.05, 0.0, -0.2);
            add_sphere(&mut model, Vec3::new(0.0, -1e-3, 1.01e-3), down, Vec3::y() * 40.0);
            (model.plan.scheme, model.plan.law) = (scheme, scheme.law());
            model.gravity = Vec3::new(0.0, 0.0, -80.0);
            model.plan.steps = 6000;
            let Some(worst) = twin_differences(solver, &model) else { continue };
            let both = (solver.key(), mesh);
            assert!(worst.iter().all(|worst| *worst < 1e-10), "{both:?}: {worst:?}");
        }
    }
}

#[test]
fn a_servo_lid_on_a_heap_agrees_with_our_own() {
    let [liggghts, yade, _] = solver::all();
    for mesh in [false, true] {
        let mut model = model(Dimension::Three, CONTACT);
        (model.plan.scheme, model.plan.law) = (Scheme::Yade, Scheme::Yade.law());
        let still = Vec3::zeros();
        for angle in [0.1_f64, 2.2, 4.3] {
            let at = Vec3::new(1.17e-3 * angle.cos(), 1.17e-3 * angle.sin(), 1.0e-3);
            add_sphere(&mut model, at, still, still);
        }
        add_sphere(&mut model, Vec3::new(0.0, 0.0, 2.66e-3), still, still);
        add_plane(&mut model, "floor", still, Vec3::z(), Motion::Still);
        // The lid meets the heap within a step, not at the end of one, where a rounding error decides.
        let height = 3.68037e-3;
        let motion = Motion::Servo { direction: -Vec3::z(), force: 0.2, speed: 0.1 };
        add_plane(&mut model, "lid", Vec3::z() * height, -Vec3::z(), motion);
        if mesh {
            model.walls[1].shape = sheet(height);
        }
        model.plan.steps = 6000;
        let limits = liggghts.limits(&model);
        let refused = |l: &solver::Limit| l.kind == LimitKind::Refused && l.what.contains("servo");
        assert!(limits.iter().any(refused), "{limits:?}");
        let ours = dem::run(&model, &Job::quiet()).expect("a run");
        let load = ours.frames.last().expect("frames").forces[3].norm();
        assert!(load < 0.1, "the heap carries the lid: {load} N are left");
        let Some(worst) = twin_differences(yade, &model) else { return };
        assert!(worst.iter().all(|worst| *worst < 1e-8), "{mesh}: {worst:?}");
    }
}
