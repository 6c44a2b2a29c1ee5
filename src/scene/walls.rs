//! Walls of a scene: those of the container and those given one by one.

use super::Loaded;
use super::parameters::{MotionParameters, WallShapeParameters};
use crate::format;
use crate::geometry::{Bounds, Container, Region, Surface, check};
use crate::model::{Motion, Wall, WallShape};
use crate::num::{Fault, Vec3};
use std::path::Path;

/// Container and walls of a scene.
pub struct Room {
    /// The region that is filled, if any.
    pub region: Option<Region>,
    /// Walls at time 0; `material` is an index into the scene's materials.
    pub walls: Vec<Wall>,
}

impl Room {
    /// Reads meshes and resolves shapes.
    ///
    /// # Errors
    /// A fault that names the container or wall whose mesh cannot be used.
    pub fn of(loaded: &Loaded) -> Result<Self, Fault> {
        let region = match &loaded.scene.container {
            Some(container) => Some(
                resolve(&container.shape, loaded)
                    .map_err(|fault| fault.under("container.shape"))?,
            ),
            None => None,
        };
        let walls = walls(loaded, region.as_ref())?;
        Ok(Self { region, walls })
    }
}

/// The region of a container of the scene, its surface files read.
pub(super) fn resolve(container: &Container, loaded: &Loaded) -> Result<Region, Fault> {
    let read = |file: &str| {
        format::read_mesh(&loaded.base().join(file)).map_err(|error| {
            Fault::new("mesh.file", error.to_string(), "a readable STL, PLY or OBJ file")
        })
    };
    let surfaces = container.files().into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    container.region_of(loaded.scene.dimension as usize, &surfaces)
}

fn walls(loaded: &Loaded, region: Option<&Region>) -> Result<Vec<Wall>, Fault> {
    let scene = &loaded.scene;
    let mut walls = Vec::new();
    if let (Some(container), Some(region)) = (&scene.container, region) {
        let material =
            scene.material(container.material.as_deref()).map_err(|f| f.under("container"))?;
        walls.extend(sides("container", region, motion(&container.motion), material));
    }
    for (index, parameters) in scene.walls.iter().enumerate() {
        let here = format!("walls[{index}]");
        let material =
            scene.material(parameters.material.as_deref()).map_err(|f| f.under(&here))?;
        let motion = motion(&parameters.motion);
        let name = parameters.name.replace('-', "_");
        match &parameters.shape {
            WallShapeParameters::Plane { point, normal } => {
                let shape = WallShape::Plane {
                    point: Vec3::from(point.map(|c| c.0)),
                    normal: Vec3::from(*normal).normalize(),
                };
                walls.push(Wall { name, shape, motion, material });
            }
            WallShapeParameters::Sides(container) => {
                let region =
                    resolve(container, loaded).map_err(|f| f.under("shape.sides").under(&here))?;
                walls.extend(sides(&name, &region, motion, material));
            }
            WallShapeParameters::Mesh { file, unit } => {
                let mesh = wall_mesh(&loaded.base().join(file), unit.0)
                    .map_err(|f| f.under("shape.mesh.file").under(&here))?;
                walls.push(Wall { name, shape: WallShape::Mesh { mesh }, motion, material });
            }
        }
    }
    Ok(walls)
}

/// The sides of a region as walls called `name_side`.
fn sides(name: &str, region: &Region, motion: Motion, material: u16) -> Vec<Wall> {
    region
        .walls()
        .into_iter()
        .map(|(side, surface)| {
            let shape = match surface {
                Surface::Plane { point, normal } => WallShape::Plane { point, normal },
                Surface::Mesh(mesh) => WallShape::Mesh { mesh },
            };
            Wall { name: format!("{name}_{side}"), shape, motion, material }
        })
        .collect()
}

/// An open or closed wall mesh, welded, without degenerate triangles.
fn wall_mesh(path: &Path, unit: f64) -> Result<crate::geometry::Mesh, Fault> {
    let bad = |problem: String| {
        Fault::new("", problem, "a readable STL, PLY or OBJ file with at least one triangle")
    };
    let mesh = format::read_mesh(path).map_err(|error| bad(error.to_string()))?;
    let (mesh, _) =
        check::surface(mesh.mapped(|v| v * unit)).map_err(|error| bad(error.to_string()))?;
    Ok(mesh)
}

fn motion(parameters: &MotionParameters) -> Motion {
    match parameters {
        MotionParameters::Still => Motion::Still,
        MotionParameters::Translate { velocity } => {
            Motion::Translate { velocity: Vec3::from(velocity.map(|c| c.0)) }
        }
        MotionParameters::Oscillate { amplitude, frequency, phase } => Motion::Oscillate {
            amplitude: Vec3::from(amplitude.map(|c| c.0)),
            frequency: *frequency,
            phase: phase.0,
        },
        MotionParameters::Servo { direction, force, stress, area, speed } => Motion::Servo {
            direction: Vec3::from(*direction).normalize(),
            force: force.unwrap_or_else(|| stress.map_or(0.0, |s| s.0) * area.unwrap_or(0.0)),
            speed: speed.0,
        },
        MotionParameters::Rotate { origin, axis, rate } => Motion::Rotate {
            origin: Vec3::from(origin.map(|c| c.0)),
            axis: Vec3::from(*axis).normalize(),
            rate: rate.0,
        },
    }
}

/// The smallest box around all mesh walls over their motion, up to `duration`.
pub fn swept_bounds(walls: &[Wall], duration: f64) -> Bounds {
    walls.iter().fold(Bounds::EMPTY, |bounds, wall| {
        let WallShape::Mesh { mesh } = &wall.shape else { return bounds };
        mesh.vertices.iter().fold(bounds, |bounds, vertex| match &wall.motion {
            Motion::Still | Motion::Servo { .. } => bounds.with(vertex),
            Motion::Oscillate { amplitude, .. } => {
                let reach = amplitude * 2.0;
                bounds.with(vertex).with(&(vertex - reach)).with(&(vertex + reach))
            }
            Motion::Translate { .. } => {
                bounds.with(vertex).with(&wall.motion.place(vertex, duration))
            }
            Motion::Rotate { origin, axis, .. } => {
                let arm = vertex - origin;
                let along = axis * arm.dot(axis);
                let radius = (arm - along).norm();
                // A circle of this radius across the axis reaches this far along each coordinate.
                let reach =
                    Vec3::from_fn(|c, _| radius * (1.0 - axis[c] * axis[c]).max(0.0).sqrt());
                let centre = origin + along;
                bounds.with(&(centre - reach)).with(&(centre + reach))
            }
        })
    })
}
