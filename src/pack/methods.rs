//! What `riprap list packings` says of this room.

use super::{grading, zones};
use crate::num::MethodEntry;

/// What else of a packing a scene can ask for, for `riprap list packings`.
pub const OPTIONS: &[MethodEntry] = &[
    zones::ENTRY,
    grading::ENTRY,
    grading::MIXTURE,
    MethodEntry {
        key: "insert",
        id: "",
        summary: "grains of a family that come during the run instead of being packed, one every 1/rate, at places drawn before the run; exported",
        source: "",
        example: r#"insert = { rate = 100.0, start = "10 ms", velocity = [0, 0, -1], region.box = { low = [0, 0, 0.8], high = [1, 1, 1] } }"#,
    },
    MethodEntry {
        key: "shape",
        id: "P14",
        summary: "containers of any outline: spheres, cones, polygons, closed surfaces, any of them with holes; for every method",
        source: "PFC (Itasca), GENERATE with a filter",
        example: r#"container.shape.hollow = { outside.sphere = { radius = "5 cm" }, holes = [{ sphere = { radius = "1 cm" } }] }"#,
    },
];

/// Every packing method, for `riprap list packings`.
pub const METHODS: &[MethodEntry] = &[
    MethodEntry {
        key: "random",
        id: "P3",
        summary: "grains one by one at random places and angles; kept where they overlap nothing, dropped after a number of tries",
        source: "random sequential addition: Widom 1966; Feder 1980",
        example: r#"packing.random = { tries = 2000 }"#,
    },
    MethodEntry {
        key: "random",
        id: "P4",
        summary: "as above; a grain that does not fit turns there, moves about the place, and at last shrinks",
        source: "RRAP: Sajjadi & Khalili 2015; Delaney, Hutzler & Aste 2008",
        example: r#"packing.random = { tries = 200, rearrange = { turns = 10, moves = 10, smallest = 0.8 } }"#,
    },
    MethodEntry {
        key: "array",
        id: "P9",
        summary: "rows and layers, square or staggered; for contact forces that are known beforehand",
        source: "square, hexagonal, simple cubic and hexagonal close packing",
        example: r#"packing.array = { pattern = "staggered", gap = "1 mm" }"#,
    },
    MethodEntry {
        key: "apollonian",
        id: "P1",
        summary: "balls tangent to those around each gap, again and again, inside the largest ball of the container; sizes are its own",
        source: "Soddy 1936; Boyd 1973",
        example: r#"packing.apollonian = { smallest = "1 mm" }"#,
    },
    MethodEntry {
        key: "random_apollonian",
        id: "P3",
        summary: "balls at random free places, each as large as fits there; sizes are its own",
        source: "Manna 1992; Delaney, Hutzler & Aste 2008",
        example: r#"packing.random_apollonian = { smallest = "1 mm" }"#,
    },
    MethodEntry {
        key: "simultaneous_growth",
        id: "P5",
        summary: "seeds at random places grow at one speed and stop when they touch; sizes are its own",
        source: "Andrienko, Brilliantov & Krapivsky 1994",
        example: r#"packing.simultaneous_growth = { births = { steady = 10 } }"#,
    },
    MethodEntry {
        key: "packing_limited_growth",
        id: "P6",
        summary: "seeds come one after another, grow at speeds of their own and stop when they touch; sizes are its own",
        source: "Dodds & Weitz 2002",
        example: r#"packing.packing_limited_growth = { slowest = 0.1 }"#,
    },
    MethodEntry {
        key: "drop_and_roll",
        id: "P2",
        summary: "grains fall one by one and roll down to rest in a hollow, or stick where they touch first with a probability",
        source: "Visscher & Bolsterli 1972; Jodrey & Tory 1979",
        example: r#"packing.drop_and_roll = { sticking = 0 }"#,
    },
    MethodEntry {
        key: "radius_expansion",
        id: "P10",
        summary: "grains without overlap grow in stages to a target porosity, at rest after each",
        source: "PFC, GENERATE (Itasca); FIRE: Bitzek et al. 2006",
        example: r#"packing.radius_expansion = { porosity = 0.45 }"#,
    },
    MethodEntry {
        key: "explosive_repulsion",
        id: "P11",
        summary: "grains of final size at random overlapping places push each other apart, velocities set to zero every few steps",
        source: "PFC (Itasca), calm; FIRE: Bitzek et al. 2006",
        example: r#"packing.explosive_repulsion = { porosity = 0.45 }"#,
    },
    MethodEntry {
        key: "moving_boundary",
        id: "P12",
        summary: "grains without overlap in a larger box whose walls move in; says what this costs and how uneven it is",
        source: "PFC (Itasca); FIRE: Bitzek et al. 2006",
        example: r#"packing.moving_boundary = { porosity = 0.45, sides = ["top"] }"#,
    },
    MethodEntry {
        key: "force_biased",
        id: "",
        summary: "overlapping grains move apart while they shrink: dense random packings of any sizes",
        source: "Mościński et al. 1989; Jodrey & Tory 1985",
        example: r#"packing.force_biased = { sizes = "densest" }"#,
    },
    MethodEntry {
        key: "compression",
        id: "DEM",
        summary: "our own DEM compresses grains evenly to a stress, a porosity or a coordination number, with a friction of its own for dense or loose states",
        source: "Cundall & Strack 1979; Thornton 2000",
        example: r#"packing.compression = { until.stress = "10 kPa", friction = 0.5 }"#,
    },
    MethodEntry {
        key: "deposition",
        id: "DEM",
        summary: "grains fall into place under gravity in our own DEM, with a friction of their own for dense or loose beds, until forces balance",
        source: "Cundall & Strack 1979",
        example: r#"packing.deposition = { friction = 0.1 }"#,
    },
    MethodEntry {
        key: "digital",
        id: "P7",
        summary: "container and grains as cells of a lattice; any shape wanders cell by cell, turns, and rebounds",
        source: "Jia & Williams 2001",
        example: r#"packing.digital = { cells = 12, rebound = 0.2 }"#,
    },
    MethodEntry {
        key: "control_points",
        id: "P8",
        summary: "bodies as surface points that move along random unit vectors, with gravity, vibration and a distance of collision",
        source: "Sajjadi & Khalili 2015",
        example: r#"packing.control_points = { points = 500, gravity = 1 }"#,
    },
    MethodEntry {
        key: "replace",
        id: "P16",
        summary: "spheres packed by another method, each replaced by a clump of equal volume and mass and relaxed, velocities zero every 5 steps",
        source: "PFC (Itasca), clumps",
        example: r#"packing.replace = { spheres.radius_expansion = { porosity = 0.5 } }"#,
    },
    MethodEntry {
        key: "placed",
        id: "",
        summary: "bodies one by one at places, angles and speeds of your own",
        source: "",
        example: r#"packing.placed = { bodies = [{ family = "ball", position = [0.0, 0.0, "2 cm"] }] }"#,
    },
];
