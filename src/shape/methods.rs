//! What `riprap list shapes` says of the methods of this room.

use crate::num::MethodEntry;

const PAPER: &str = "Sajjadi & Khalili 2015";

/// The methods of this room.
pub const METHODS: &[MethodEntry] = &[
    MethodEntry {
        key: "sphere",
        id: "",
        summary: "a sphere",
        source: "",
        example: r#"shape = "sphere""#,
    },
    MethodEntry {
        key: "union",
        id: "G1",
        summary: "union of random boxes, cylinders, cones, ellipsoids and spheres through one point",
        source: PAPER,
        example: r#"shape.union = { solids = [2, 5] }"#,
    },
    MethodEntry {
        key: "union",
        id: "G2",
        summary: "families of the union: smooth, sharp, chosen kinds and ranges of dimensions",
        source: PAPER,
        example: r#"shape.union = { family = "sharp", solids = [2, 4] }"#,
    },
    MethodEntry {
        key: "files",
        id: "",
        summary: "the user's own closed surfaces: STL, PLY, OBJ",
        source: "",
        example: r#"shape.files = { folder = "grains" }"#,
    },
    MethodEntry {
        key: "node_spheres",
        id: "G3",
        summary: "spheres at a random subset of the mesh nodes of a volume, united",
        source: PAPER,
        example: r#"shape.node_spheres = { base.sphere = 1.0, probability = 0.6 }"#,
    },
    MethodEntry {
        key: "balloon",
        id: "G4",
        summary: "a base volume inflated step by step from chosen or random centres",
        source: PAPER,
        example: r#"shape.balloon = { base.box = [1.0, 0.8, 0.7], centres = [2, 5] }"#,
    },
    MethodEntry {
        key: "rain",
        id: "G5",
        summary: "cubes that fall on a grid of columns, with or without sticking to neighbours",
        source: "Sajjadi & Khalili 2015; Vold 1959",
        example: r#"shape.rain = { grid = [4, 4], cubes = [30, 60] }"#,
    },
    MethodEntry {
        key: "turned_rain",
        id: "G6",
        summary: "cubes turned at random that fall until they touch, united",
        source: PAPER,
        example: r#"shape.turned_rain = { cubes = [10, 20], sink = 0.15 }"#,
    },
    MethodEntry {
        key: "growth",
        id: "G7",
        summary: "a cube that grows by random expansion of its boundary",
        source: "Sajjadi & Khalili 2015; Eden 1961",
        example: r#"shape.growth = { cells = [80, 200], smoothing = 1.0 }"#,
    },
    MethodEntry {
        key: "patir",
        id: "G8",
        summary: "rough ball, slab or sheet with given autocorrelation, skewness and kurtosis",
        source: "Patir 1977; Hu & Tonder 1992",
        example: r#"shape.patir = { rms = 0.02, correlation = [0.1, 0.1], autocorrelation = "exponential", skewness = -0.3 }"#,
    },
    MethodEntry {
        key: "whitehouse",
        id: "G9",
        summary: "rough ball, slab or sheet whose correlation falls to near zero at a given length",
        source: "Whitehouse 1983",
        example: r#"shape.whitehouse = { rms = 0.02, correlation = [0.15, 0.15], level = 0.1 }"#,
    },
    MethodEntry {
        key: "crumple",
        id: "G10",
        summary: "crumpled sheet: facets between random creases, or crushed by folds",
        source: "Sajjadi & Khalili 2015",
        example: r#"shape.crumple = { creases = [8, 16], rms = 0.04, body.slab = { thickness = 0.3 } }"#,
    },
    MethodEntry {
        key: "midpoint",
        id: "G11",
        summary: "fractal ball, slab or sheet of given dimension by midpoint displacement",
        source: "Fournier, Fussell & Carpenter 1982",
        example: r#"shape.midpoint = { dimension = 2.3, rms = 0.03, level = 5 }"#,
    },
    MethodEntry {
        key: "sponge",
        id: "G12",
        summary: "Sierpinski (Menger) sponge with cubes removed at random; seldom a valid grain",
        source: PAPER,
        example: r#"shape.sponge = { level = 1, probability = 0.95, pieces = "largest" }"#,
    },
    MethodEntry {
        key: "harmonics",
        id: "",
        summary: "spherical harmonics with a given spectrum over degrees",
        source: "Grigoriu et al. 2006; Mollon & Zhao 2014",
        example: r#"shape.harmonics = { degrees = [2, 15], rms = 0.12, decay = 1.5 }"#,
    },
    MethodEntry {
        key: "polyhedron",
        id: "",
        summary: "convex polyhedra: ellipsoids cut by random planes",
        source: "",
        example: r#"shape.polyhedron = { cuts = [10, 24], depth = [0.0, 0.3] }"#,
    },
    MethodEntry {
        key: "voronoi",
        id: "",
        summary: "Voronoi cells of random points",
        source: "Voronoi 1908",
        example: r#"shape.voronoi = { regularity = 0.4 }"#,
    },
    MethodEntry {
        key: "superquadric",
        id: "",
        summary: "superquadrics with random axes and exponents",
        source: "Barr 1981",
        example: r#"shape.superquadric = { axes = [0.6, 1.4], side = [0.3, 1.0] }"#,
    },
    MethodEntry {
        key: "noise",
        id: "",
        summary: "ellipsoids displaced by noise of several octaves",
        source: "Perlin 1985",
        example: r#"shape.noise = { axes = [0.7, 1.3], rms = 0.06, octaves = 4 }"#,
    },
    MethodEntry {
        key: "tailored",
        id: "",
        summary: "made to measure: wanted distributions of elongation, flatness, sphericity, roundness, convexity, or those of a folder of scanned grains",
        source: "",
        example: r#"shape.tailored = { elongation = [0.75, 0.08], flatness = [0.7, 0.1], sphericity = [0.85, 0.03] }"#,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Scene {
        shape: Shape,
    }

    #[test]
    fn every_example_is_a_shape_that_can_be_used() {
        for entry in METHODS {
            let text = entry.example;
            let scene: Scene = toml::from_str(text).expect(text);
            assert!(scene.shape.validate().is_ok(), "{text}");
        }
    }
}
