//! Tangential springs that contacts have at the start: YADE's interactions are made one by one
//! and given their shear force.

use crate::model::{Model, Partner, Spring, WallShape};
use crate::num::Vec3;
use crate::solver::Limit;
use crate::solver::table::{Cell, Table};

/// Springs: sphere, kind of its partner, the partner (sphere or wall), triangle, force on the sphere.
pub fn table(model: &Model) -> Table<'_> {
    const COLUMNS: &[&str] = &["sphere", "kind", "other", "triangle", "fx", "fy", "fz"];
    Table::new("springs", COLUMNS, move |rows| {
        for spring in &model.springs {
            let (kind, other, triangle) = partner(model, spring.other);
            let force = force(model, spring);
            let mut cells =
                [spring.sphere as usize, kind, other, triangle, 0, 0, 0].map(Cell::from);
            for (cell, part) in cells[4..].iter_mut().zip(force.iter()) {
                *cell = (*part).into();
            }
            rows.put(&cells)?;
        }
        Ok(())
    })
}

/// 0 sphere, 1 wall of one body, 2 triangle of a wall; its number; the triangle.
fn partner(model: &Model, partner: Partner) -> (usize, usize, usize) {
    match partner {
        Partner::Sphere(other) => (0, other as usize, 0),
        Partner::Plane(wall) if super::values::is_plane(&model.walls[usize::from(wall)]) => {
            (1, usize::from(wall), 0)
        }
        Partner::Plane(wall) => (2, usize::from(wall), 0),
        Partner::Face { wall, triangle } => (2, usize::from(wall), triangle as usize),
    }
}

/// Force of a spring on its sphere, N.
fn force(model: &Model, spring: &Spring) -> Vec3 {
    let material =
        |sphere: u32| model.bodies[model.spheres[sphere as usize].body as usize].material;
    let other = match spring.other {
        Partner::Sphere(other) => material(other),
        Partner::Plane(wall) | Partner::Face { wall, .. } => {
            model.walls[usize::from(wall)].material
        }
    };
    spring.stretch * -model.contacts.between(material(spring.sphere), other).kt
}

/// What YADE cannot be given.
pub fn limits(model: &Model) -> Vec<Limit> {
    let mut limits = Vec::new();
    if model.springs.is_empty() {
        return limits;
    }
    if model.periodic.is_some() {
        limits.push(Limit::refused(
            "tangential springs at the start in a periodic box: interactions that are made one by one do not reach over its sides",
        ));
    }
    let many = |spring: &Spring| match spring.other {
        Partner::Plane(wall) => !super::values::is_plane(&model.walls[usize::from(wall)]),
        Partner::Face { wall, .. } => match &model.walls[usize::from(wall)].shape {
            WallShape::Mesh { mesh } => mesh.triangles.len() > 1,
            WallShape::Plane { .. } => false,
        },
        Partner::Sphere(_) => false,
    };
    if model.springs.iter().any(many) {
        limits.push(Limit::refused(
            "tangential springs at the start of contacts with meshes or oblique planes: YADE touches each facet near an edge, and which spring each had is not known",
        ));
    }
    limits
}
