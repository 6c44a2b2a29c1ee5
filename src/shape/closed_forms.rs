//! Every descriptor of solids with closed forms, turned and moved: what riprap says beside
//! what the formula says. Curved solids are faceted; their tolerance is that of the facets.

use super::descriptors::{Descriptors, Zingg, describe};
use crate::geometry::{Mesh, Primitive};
use crate::num::{Vec3, random};
use std::f64::consts::PI;

/// What the formulas give.
struct Form {
    name: &'static str,
    volume: f64,
    area: f64,
    /// L, I, S.
    dimensions: [f64; 3],
    span: f64,
    inscribed: f64,
    class: Zingg,
}

fn turned(mesh: &Mesh) -> Mesh {
    let turn = random::rotation(&mut random::stream(8, "closed forms", 0));
    mesh.mapped(|p| turn * p + Vec3::new(1.0, 2.0, 3.0))
}

fn check(form: &Form, mesh: &Mesh, tolerance: f64) -> Descriptors {
    let d = describe(&turned(mesh)).expect("a hull");
    let [long, intermediate, short] = form.dimensions;
    let volume_diameter = (6.0 * form.volume / PI).cbrt();
    for (what, found, expected) in [
        ("volume", d.volume, form.volume),
        ("area", d.area, form.area),
        ("volume diameter", d.volume_diameter, volume_diameter),
        ("area diameter", d.area_diameter, (form.area / PI).sqrt()),
        ("L", d.long, long),
        ("I", d.intermediate, intermediate),
        ("S", d.short, short),
        ("span", d.span, form.span),
        ("elongation", d.elongation, intermediate / long),
        ("flatness", d.flatness, short / intermediate),
        ("Krumbein", d.krumbein_sphericity, (short * intermediate / long.powi(2)).cbrt()),
        ("Sneed and Folk", d.projection_sphericity, (short.powi(2) / (long * intermediate)).cbrt()),
        ("Wadell", d.wadell_sphericity, PI * volume_diameter.powi(2) / form.area),
        ("convexity", d.convexity, 1.0),
        ("roughness", d.roughness, 1.0),
        ("inscribed diameter", d.inscribed_diameter, form.inscribed),
    ] {
        let off = (found / expected - 1.0).abs();
        assert!(off <= tolerance, "{} {what}: {found}, expected {expected}", form.name);
    }
    assert_eq!(d.zingg, form.class, "{}", form.name);
    d
}

#[test]
fn sphere() {
    let form = Form {
        name: "sphere",
        volume: 4.0 / 3.0 * PI,
        area: 4.0 * PI,
        dimensions: [2.0; 3],
        span: 2.0,
        inscribed: 2.0,
        class: Zingg::Equant,
    };
    let d = check(&form, &Primitive::Sphere { diameter: 2.0 }.mesh(64), 0.01);
    assert!(d.roundness > 0.97, "{}", d.roundness);
}

#[test]
fn boxes_of_every_class() {
    for ([a, b, c], class) in [
        ([2.0, 2.0, 2.0], Zingg::Equant),
        ([4.0, 3.5, 1.0], Zingg::Disc),
        ([4.0, 1.2, 1.0], Zingg::Rod),
        ([4.0, 2.0, 1.0], Zingg::Blade),
    ] {
        let form = Form {
            name: "box",
            volume: a * b * c,
            area: 2.0 * (a * b + b * c + c * a),
            dimensions: [a, b, c],
            span: Vec3::new(a, b, c).norm(),
            inscribed: c,
            class,
        };
        // The inscribed sphere is looked for to 1e-4.
        check(&form, &Primitive::Box { edges: Vec3::new(a, b, c) }.mesh(3), 1e-4);
    }
}

#[test]
fn cylinder_and_cone() {
    let form = Form {
        name: "cylinder",
        volume: 5.0 * PI,
        area: 12.0 * PI,
        dimensions: [5.0, 2.0, 2.0],
        span: 29_f64.sqrt(),
        inscribed: 2.0,
        class: Zingg::Rod,
    };
    check(&form, &Primitive::Cylinder { diameter: 2.0, height: 5.0 }.mesh(96), 3e-3);
    // r = 1, h = 4: slant √17, inscribed radius r h / (r + slant).
    let slant = 17_f64.sqrt();
    let form = Form {
        name: "cone",
        volume: 4.0 / 3.0 * PI,
        area: PI * (1.0 + slant),
        dimensions: [4.0, 2.0, 2.0],
        span: slant,
        inscribed: 8.0 / (1.0 + slant),
        class: Zingg::Rod,
    };
    check(&form, &Primitive::Cone { diameter: 2.0, height: 4.0 }.mesh(96), 3e-3);
}

#[test]
fn ellipsoids() {
    // Prolate: A = 2π b² (1 + c/(b e) asin e), e² = 1 − b²/c², b = 1, c = 2.
    let e = 0.75_f64.sqrt();
    let form = Form {
        name: "prolate ellipsoid",
        volume: 8.0 / 3.0 * PI,
        area: 2.0 * PI * (1.0 + 2.0 / e * e.asin()),
        dimensions: [4.0, 2.0, 2.0],
        span: 4.0,
        inscribed: 2.0,
        class: Zingg::Rod,
    };
    check(&form, &Primitive::Ellipsoid { axes: Vec3::new(4.0, 2.0, 2.0) }.mesh(64), 0.01);
    // Oblate: A = 2π a² (1 + (1 − e²)/e atanh e), a = 2, c = 1.
    let form = Form {
        name: "oblate ellipsoid",
        volume: 16.0 / 3.0 * PI,
        area: 8.0 * PI * (1.0 + (1.0 - e * e) / e * e.atanh()),
        dimensions: [4.0, 4.0, 2.0],
        span: 4.0,
        inscribed: 2.0,
        class: Zingg::Disc,
    };
    check(&form, &Primitive::Ellipsoid { axes: Vec3::new(4.0, 4.0, 2.0) }.mesh(64), 0.01);
}

#[test]
fn octahedron_and_tetrahedron() {
    // Corners at ±1: box flush with a face, whose shadow is a regular hexagon of radius √(2/3).
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let octahedron = Mesh {
        vertices: axes.iter().flat_map(|axis| [*axis, -axis]).collect(),
        triangles: (0..8u32)
            .map(|i| {
                let [a, b, c] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
                if i.count_ones() % 2 == 0 { [a, b, c] } else { [a, c, b] }
            })
            .collect(),
    };
    let form = Form {
        name: "octahedron",
        volume: 4.0 / 3.0,
        area: 4.0 * 3_f64.sqrt(),
        dimensions: [2.0 * (2.0_f64 / 3.0).sqrt(), 2_f64.sqrt(), 2.0 / 3_f64.sqrt()],
        span: 2.0,
        inscribed: 2.0 / 3_f64.sqrt(),
        class: Zingg::Equant,
    };
    check(&form, &octahedron, 1e-4);
    // Edge a = √8: box a × a √3/2 × a √(2/3), inscribed radius a/√24.
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let tetrahedron = Mesh {
        vertices: corners.map(Vec3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]],
    };
    let edge = 8_f64.sqrt();
    let form = Form {
        name: "tetrahedron",
        volume: 8.0 / 3.0,
        area: 8.0 * 3_f64.sqrt(),
        dimensions: [edge, edge * 0.75_f64.sqrt(), edge * (2.0_f64 / 3.0).sqrt()],
        span: edge,
        inscribed: 2.0 * edge / 24_f64.sqrt(),
        class: Zingg::Equant,
    };
    check(&form, &tetrahedron, 1e-4);
}
