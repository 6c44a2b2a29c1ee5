//! Scenes that come with riprap, to start from.

use crate::format::{self, FormatError};
use crate::geometry::Mesh;
use crate::num::Vec3;
use crate::num::units::Length;
use crate::shape::{self, Shape, ShapeError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A scene that comes with riprap.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// Name for `riprap new`.
    pub name: &'static str,
    /// What it shows.
    pub summary: &'static str,
    /// The scene file.
    pub text: &'static str,
}

/// Every shipped scene.
pub const SCENES: &[Shipped] = &[
    Shipped {
        name: "demo",
        summary: "150 random grains of two families, as clumps, dropped into a box",
        text: include_str!("../../templates/scenes/demo.toml"),
    },
    Shipped {
        name: "two-spheres",
        summary: "oblique impact of two spinning spheres with friction",
        text: include_str!("../../templates/scenes/two-spheres.toml"),
    },
    Shipped {
        name: "spheres-box",
        summary: "1 000 spheres of two sizes settle in a box",
        text: include_str!("../../templates/scenes/spheres-box.toml"),
    },
    Shipped {
        name: "own-grains",
        summary: "your own STL, PLY or OBJ grains settle in a cylinder",
        text: include_str!("../../templates/scenes/own-grains.toml"),
    },
    Shipped {
        name: "drum",
        summary: "spheres in a rotating drum whose wall is a mesh",
        text: include_str!("../../templates/scenes/drum.toml"),
    },
    Shipped {
        name: "wet-drum",
        summary: "wet beads held by liquid bridges in a rotating drum",
        text: include_str!("../../templates/scenes/wet-drum.toml"),
    },
    Shipped {
        name: "discs-2d",
        summary: "discs in two dimensions fall into a box",
        text: include_str!("../../templates/scenes/discs-2d.toml"),
    },
    Shipped {
        name: "deformable-block",
        summary: "a block of given modulus and Poisson's ratio pressed between two plates",
        text: include_str!("../../templates/scenes/deformable-block.toml"),
    },
    Shipped {
        name: "cluster-impact",
        summary: "a grain of seven bonded spheres hits a floor and breaks",
        text: include_str!("../../templates/scenes/cluster-impact.toml"),
    },
    Shipped {
        name: "star-cluster",
        summary: "600 bodies attract each other from afar (tree code), fall together and collide",
        text: include_str!("../../templates/scenes/star-cluster.toml"),
    },
];

/// The shipped scene called `name`.
pub fn find(name: &str) -> Option<&'static Shipped> {
    SCENES.iter().find(|scene| scene.name == name)
}

impl Shipped {
    /// Writes the scene as `scene.toml` into `folder`, with the files that it needs; returns its path.
    ///
    /// # Errors
    /// A folder that cannot be made or written.
    pub fn copy_to(&self, folder: &Path) -> Result<PathBuf, ShapeError> {
        make_folder(folder)?;
        if self.name == "own-grains" {
            let grains = folder.join("grains");
            make_folder(&grains)?;
            write_sample_grains(&grains)?;
        }
        if self.name == "deformable-block" {
            let grains = folder.join("grains");
            make_folder(&grains)?;
            // Five by five by nine layers of 10 mm on the staggered lattice.
            let side = |layers: f64| 0.01 * (1.0 + (layers - 1.0) / std::f64::consts::SQRT_2);
            let block = box_of(Vec3::new(side(5.0), side(5.0), side(9.0)));
            format::stl::write(&grains.join("block.stl"), &block)?;
        }
        let path = folder.join("scene.toml");
        format::atomic::write(&path, |out| out.write_all(self.text.as_bytes()))?;
        Ok(path)
    }
}

/// Surface of a box of the given edges about the origin.
fn box_of(edges: Vec3) -> Mesh {
    let corner = |n: usize| {
        let part = |bit: usize| if n >> bit & 1 == 1 { 0.5 } else { -0.5 };
        Vec3::new(part(0), part(1), part(2)).component_mul(&edges)
    };
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        vertices: (0..8).map(corner).collect(),
        triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

fn make_folder(path: &Path) -> Result<(), ShapeError> {
    std::fs::create_dir_all(path).map_err(|source| FormatError::io(path, "write", source).into())
}

/// Writes the sample grains that `own-grains` starts with into `folder`.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_sample_grains(folder: &Path) -> Result<(), ShapeError> {
    let shape: Shape = Shape::Union(shape::UnionParameters::default());
    for index in 0..3 {
        let size = Length(0.01);
        let solid = shape::generate(
            &shape,
            &format!("sample-{index}"),
            index,
            Some(size.0),
            11,
            "sample",
            folder,
        )?;
        format::stl::write(&folder.join(format!("sample-{index}.stl")), &solid.mesh)?;
    }
    Ok(())
}
