//! Scenes that come with riprap, to start from.

use crate::format::{self, FormatError};
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
        name: "discs-2d",
        summary: "discs in two dimensions fall into a box",
        text: include_str!("../../templates/scenes/discs-2d.toml"),
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
        let path = folder.join("scene.toml");
        format::atomic::write(&path, |out| out.write_all(self.text.as_bytes()))?;
        Ok(path)
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
