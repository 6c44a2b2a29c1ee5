//! The container, other walls, and how they move.

use super::validate_name;
use crate::geometry::Container;
use crate::num::Fault;
use crate::num::units::{Angle, Length, Pressure, Speed, Spin};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The room that is filled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContainerParameters {
    /// Its shape.
    pub shape: Container,
    /// Material of its walls by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
    /// How all its walls move. Default: they stand still.
    #[serde(default)]
    pub motion: MotionParameters,
}

/// A wall besides those of the container.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallParameters {
    /// Name: letters, digits and `_`; different for each wall.
    pub name: String,
    /// Its surface.
    pub shape: WallShapeParameters,
    /// Material by name. May be left out if there is only one material.
    #[serde(default)]
    pub material: Option<String>,
    /// How it moves. Default: it stands still.
    #[serde(default)]
    pub motion: MotionParameters,
}

/// Surface of a wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WallShapeParameters {
    /// An infinite plane.
    Plane {
        /// A point on it.
        point: [Length; 3],
        /// Normal towards the grains, any length.
        normal: [f64; 3],
    },
    /// All sides of a container shape (box, cylinder), or a closed mesh.
    Sides(Container),
    /// A triangle mesh, open or closed.
    Mesh {
        /// STL, PLY or OBJ file, relative to the scene file.
        file: String,
        /// Unit of the numbers in the file. Default 1 m.
        #[serde(default = "metre")]
        unit: Length,
    },
}

fn metre() -> Length {
    Length(1.0)
}

/// Motion of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionParameters {
    /// At rest.
    #[default]
    Still,
    /// Constant velocity.
    Translate {
        /// Velocity.
        velocity: [Speed; 3],
    },
    /// Back and forth: displacement A (sin(2π f t + φ) − sin φ).
    Oscillate {
        /// Amplitude A.
        amplitude: [Length; 3],
        /// Frequency f, Hz, greater than 0.
        frequency: f64,
        /// Phase φ at time 0. Default 0.
        #[serde(default = "no_angle")]
        phase: Angle,
    },
    /// Moves along a direction so that it pushes the grains that way with `force`, or with
    /// `stress` on `area`.
    Servo {
        /// Direction in which it pushes and moves, any length. For a plane: along its normal.
        direction: [f64; 3],
        /// Force, N, greater than 0.
        #[serde(default)]
        force: Option<f64>,
        /// Stress in place of `force`.
        #[serde(default)]
        stress: Option<Pressure>,
        /// Area that `stress` acts on, m² (m in two dimensions).
        #[serde(default)]
        area: Option<f64>,
        /// Largest speed.
        speed: Speed,
    },
    /// Constant rotation about an axis, right-handed.
    Rotate {
        /// A point on the axis.
        origin: [Length; 3],
        /// Direction of the axis, any length.
        axis: [f64; 3],
        /// Rate of rotation.
        rate: Spin,
    },
}

fn no_angle() -> Angle {
    Angle(0.0)
}

impl ContainerParameters {
    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
        self.shape.validate().map_err(|fault| fault.under("shape"))?;
        self.motion.validate(dimension).map_err(|fault| fault.under("motion"))
    }
}

impl WallParameters {
    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
        validate_name(&self.name)?;
        match &self.shape {
            WallShapeParameters::Plane { point, normal } => {
                for (axis, value) in point.iter().enumerate() {
                    if !value.0.is_finite() {
                        return Err(Fault::new(
                            format!("shape.plane.point[{axis}]"),
                            "is not finite",
                            "a length",
                        ));
                    }
                }
                validate_direction("shape.plane.normal", normal)?;
                if dimension == 2 && normal[2] != 0.0 {
                    let problem = "leaves the x–y plane";
                    return Err(Fault::new(
                        "shape.plane.normal",
                        problem,
                        "a third component of 0",
                    ));
                }
            }
            WallShapeParameters::Sides(container) => {
                container.validate().map_err(|fault| fault.under("shape.sides"))?;
            }
            WallShapeParameters::Mesh { unit, .. } => {
                Fault::positive("shape.mesh.unit", unit.0)?;
                if dimension == 2 {
                    return Err(Fault::new(
                        "shape.mesh",
                        "is a surface in space",
                        "planes in two dimensions",
                    ));
                }
            }
        }
        self.motion.validate(dimension).map_err(|fault| fault.under("motion"))
    }
}

/// A direction: finite and not zero.
fn validate_direction(key: &str, direction: &[f64; 3]) -> Result<(), Fault> {
    let length = direction.iter().map(|c| c * c).sum::<f64>();
    if length.is_finite() && length > 0.0 {
        return Ok(());
    }
    Err(Fault::new(key, format!("is {direction:?}"), "three finite numbers that are not all 0"))
}

impl MotionParameters {
    pub(super) fn validate(&self, dimension: u8) -> Result<(), Fault> {
        match self {
            Self::Still => Ok(()),
            Self::Translate { velocity } if dimension == 2 && velocity[2].0 != 0.0 => Err(
                Fault::new("translate.velocity", "leaves the x–y plane", "a third component of 0"),
            ),
            Self::Translate { .. } => Ok(()),
            Self::Oscillate { amplitude, frequency, .. } => {
                Fault::positive("oscillate.frequency", *frequency)?;
                if dimension == 2 && amplitude[2].0 != 0.0 {
                    let problem = "leaves the x–y plane";
                    let allowed = "a third component of 0";
                    return Err(Fault::new("oscillate.amplitude", problem, allowed));
                }
                Ok(())
            }
            Self::Servo { direction, force, stress, area, speed } => {
                validate_direction("servo.direction", direction)?;
                if dimension == 2 && direction[2] != 0.0 {
                    let problem = "leaves the x–y plane";
                    return Err(Fault::new("servo.direction", problem, "a third component of 0"));
                }
                Fault::positive("servo.speed", speed.0)?;
                match (force, stress, area) {
                    (Some(force), None, None) => Fault::positive("servo.force", *force),
                    (None, Some(stress), Some(area)) => {
                        Fault::positive("servo.stress", stress.0)?;
                        Fault::positive("servo.area", *area)
                    }
                    _ => Err(Fault::new(
                        "servo.force",
                        "is not what is given alone",
                        "`force`, or `stress` together with `area`",
                    )),
                }
            }
            Self::Rotate { axis, .. } => {
                validate_direction("rotate.axis", axis)?;
                if dimension == 2 && (axis[0] != 0.0 || axis[1] != 0.0) {
                    return Err(Fault::new(
                        "rotate.axis",
                        "leaves the x–y plane",
                        "[0, 0, 1] in two dimensions",
                    ));
                }
                Ok(())
            }
        }
    }
}
