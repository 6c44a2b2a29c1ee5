//! Refuses models that hold NaN or infinity before any template sees them:
//! templates print `NaN`, and solvers read it without a word.

use super::SolverError;
use crate::model::{Model, Motion, WallShape};
use crate::num::Vec3;

/// An error that names the first number of `model` that is not finite.
pub fn check(model: &Model) -> Result<(), SolverError> {
    vector("gravity", &model.gravity)?;
    vector("domain.low", &model.domain.low)?;
    vector("domain.high", &model.domain.high)?;
    number("local_damping", model.local_damping)?;
    number("plan.step", model.plan.step)?;
    for (index, body) in model.bodies.iter().enumerate() {
        let at = |field: &str| format!("bodies[{index}].{field}");
        vector_at(|| at("position"), &body.position)?;
        vector_at(|| at("velocity"), &body.velocity)?;
        vector_at(|| at("spin"), &body.spin)?;
        vector_at(|| at("inertia"), &body.inertia)?;
        number_at(|| at("mass"), body.mass)?;
        for value in body.orientation.coords.iter() {
            number_at(|| at("orientation"), *value)?;
        }
    }
    for (index, sphere) in model.spheres.iter().enumerate() {
        vector_at(|| format!("spheres[{index}].offset"), &sphere.offset)?;
        number_at(|| format!("spheres[{index}].radius"), sphere.radius)?;
    }
    for (index, material) in model.materials.iter().enumerate() {
        number_at(|| format!("materials[{index}].density"), material.density)?;
    }
    if let Some(value) = model.extra.odd_number() {
        number("extra", value)?;
    }
    contacts(model)?;
    model.walls.iter().try_for_each(wall)
}

fn contacts(model: &Model) -> Result<(), SolverError> {
    let size = model.contacts.size() as u16;
    for a in 0..size {
        for b in a..size {
            let c = model.contacts.between(a, b);
            for (name, value) in
                [("kn", c.kn), ("kt", c.kt), ("cn", c.cn), ("ct", c.ct), ("friction", c.friction)]
            {
                number_at(|| format!("contacts[{a},{b}].{name}"), value)?;
            }
        }
    }
    Ok(())
}

fn wall(wall: &crate::model::Wall) -> Result<(), SolverError> {
    let at = |field: &str| format!("wall `{}` {field}", wall.name);
    match &wall.shape {
        WallShape::Plane { point, normal } => {
            vector_at(|| at("point"), point)?;
            vector_at(|| at("normal"), normal)?;
        }
        WallShape::Mesh { mesh } => {
            for (index, vertex) in mesh.vertices.iter().enumerate() {
                vector_at(|| at(&format!("vertex {index}")), vertex)?;
            }
        }
    }
    match &wall.motion {
        Motion::Still => Ok(()),
        Motion::Oscillate { amplitude, .. } => vector_at(|| at("amplitude"), amplitude),
        Motion::Servo { direction, .. } => vector_at(|| at("direction"), direction),
        Motion::Translate { velocity } => vector_at(|| at("velocity"), velocity),
        Motion::Rotate { origin, axis, rate } => {
            vector_at(|| at("origin"), origin)?;
            vector_at(|| at("axis"), axis)?;
            number_at(|| at("rate"), *rate)
        }
    }
}

fn number(what: &str, value: f64) -> Result<(), SolverError> {
    number_at(|| what.to_owned(), value)
}

fn vector(what: &str, value: &Vec3) -> Result<(), SolverError> {
    vector_at(|| what.to_owned(), value)
}

fn number_at(what: impl FnOnce() -> String, value: f64) -> Result<(), SolverError> {
    if value.is_finite() {
        return Ok(());
    }
    Err(SolverError::NotFinite { what: what(), value })
}

fn vector_at(what: impl FnOnce() -> String, value: &Vec3) -> Result<(), SolverError> {
    match value.iter().find(|component| !component.is_finite()) {
        None => Ok(()),
        Some(component) => Err(SolverError::NotFinite { what: what(), value: *component }),
    }
}
