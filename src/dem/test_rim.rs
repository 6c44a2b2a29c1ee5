//! A sphere that slides over a corner of the rim of two coplanar pairs of triangles, against LIGGGHTS 3.8.0.

use super::run;
use super::test_scenes::{add_sphere, contact, empty};
use crate::geometry::Mesh;
use crate::model::{Model, Motion, Scheme, Wall, WallShape};
use crate::num::{Job, Vec3};
use std::f64::consts::TAU;

/// Two neighbouring sides of a cone of 24, two triangles each, and a sphere of 10 mm on their lower rim.
fn rim(scheme: Scheme) -> Model {
    let mut model = empty(scheme, contact(5e4, CN, 0.0, 0.4));
    model.gravity = Vec3::new(0.0, 0.0, -9.81);
    let at = |k: u32, radius: f64, z: f64| {
        let angle = TAU * f64::from(k) / 24.0;
        Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let low = [18, 19, 20].map(|k| at(k, 0.032, 0.04));
    let high = [18, 19, 20].map(|k| at(k, 0.07, 0.078));
    let vertices = [low, high].concat();
    let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
    let shape = WallShape::Mesh { mesh: Mesh { vertices, triangles } };
    model.walls.push(Wall { name: "cone".into(), shape, motion: Motion::Still, material: 0 });
    let place = Vec3::new(0.00564, -0.02419, 0.04709);
    let (velocity, spin) = (Vec3::new(0.23, -0.68, -0.74), Vec3::new(20.0, -30.0, 10.0));
    add_sphere(&mut model, place, 0.01, velocity, spin);
    (model.plan.step, model.plan.steps) = (1e-6, 2000);
    model
}

/// Dashpot of restitution 0.6 at walls, N s/m.
const CN: f64 = 11.705305934027006;

#[test]
#[allow(clippy::excessive_precision)] // digits as LIGGGHTS wrote them
fn an_edge_or_corner_begins_without_the_spring_of_a_coplanar_triangle_in_liggghts() {
    // Place, velocity, angular velocity after 2 000 steps of LIGGGHTS.
    const END: [[f64; 3]; 3] = [
        [0.005_367_097_833_031_137_5, -0.023_834_037_862_358_923, 0.047_628_699_089_725_224],
        [-0.196_893_078_557_414_34, 0.313_414_063_392_177_1, 0.424_567_272_702_724_26],
        [-10.188_420_767_443_711, 3.318_704_806_468_066, -28.544_760_569_997_262],
    ];
    let last = |scheme: Scheme| {
        let run = run(&rim(scheme), &Job::quiet()).expect("runs");
        let frame = run.frames.into_iter().last().expect("frames");
        [frame.centres[0], frame.velocities[0], frame.spins[0]]
    };
    let found = last(Scheme::Liggghts);
    for (value, end) in found.iter().zip(END) {
        let end = Vec3::from(end);
        assert!((value - end).norm() < 1e-10 * end.norm(), "{value:?} {end:?}");
    }
    // Our own scheme hands the spring on.
    assert!((last(Scheme::Leapfrog)[0] - found[0]).norm() > 1e-8);
}
