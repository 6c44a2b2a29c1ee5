//! Solids that clump methods are tried on.

use super::StudyError;
use crate::geometry::{Mesh, Primitive};
use crate::num::{Rotation, Vec3};
use crate::shape::{self, Shape, Solid};
use std::path::Path;

/// Eight solids of about unit size: four smooth or sharp random ones, four of simple form.
pub fn solids() -> Result<Vec<Solid>, StudyError> {
    // Off the axes, so that no method gains from a grid that lies along the faces.
    let turn = Rotation::from_euler_angles(0.4, 0.7, 1.1);
    let plain = |name: &str, mesh: Mesh| {
        let mesh = mesh.mapped(|point| turn * point);
        let mass = mesh.mass_properties();
        Solid { name: name.to_owned(), mesh, mass, recipe: name.to_owned() }
    };
    let random = |family: &str, index: u64| {
        let text = serde_json::json!({ "union": { "family": family, "solids": [2, 4] } });
        let shape: Shape =
            serde_json::from_value(text).map_err(|error| StudyError::Work(error.to_string()))?;
        let name = format!("{family}-{index}");
        shape::generate(&shape, &name, index, Some(1.0), 2015, "study", Path::new("."))
            .map(|solid| Solid { name, ..solid })
            .map_err(|error| StudyError::Work(error.to_string()))
    };
    let ellipsoid = Primitive::Ellipsoid { axes: Vec3::new(2.0, 1.0, 1.0) }.mesh(64);
    let cube = Primitive::Box { edges: Vec3::repeat(1.0) }.mesh(4);
    let cylinder = Primitive::Cylinder { diameter: 1.0, height: 1.0 }.mesh(64);
    Ok(vec![
        plain("ellipsoid", ellipsoid),
        plain("cube", cube),
        random("smooth", 0)?,
        random("sharp", 0)?,
        random("sharp", 1)?,
        random("smooth", 1)?,
        plain("octahedron", octahedron()),
        plain("cylinder", cylinder),
    ])
}

fn octahedron() -> Mesh {
    let vertices =
        [Vec3::x(), Vec3::y(), Vec3::z()].iter().flat_map(|axis| [*axis, -axis]).collect();
    let triangles = (0..8u32)
        .map(|i| {
            let [a, b, c] = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)];
            if i.count_ones() % 2 == 0 { [a, b, c] } else { [a, c, b] }
        })
        .collect();
    Mesh { vertices, triangles }
}
