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
        key: "sponge",
        id: "G12",
        summary: "Sierpinski (Menger) sponge with cubes removed at random; seldom a valid grain",
        source: PAPER,
        example: r#"shape.sponge = { level = 1, probability = 0.95, pieces = "largest" }"#,
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
