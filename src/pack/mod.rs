//! Packing: where each grain goes. One file a method.
//!
//! [`pack`] runs the method of a scene; [`measure`] says what came out, also
//! for states of a run; [`mod@file`] writes and reads `packing.csv`.

pub mod apollonian;
pub mod array;
pub mod bed;
pub mod compression;
pub mod control_points;
pub mod deposition;
pub mod digital;
mod dress;
pub mod drop_and_roll;
pub mod explosive_repulsion;
pub mod file;
pub mod force_biased;
pub mod forms;
pub mod grading;
pub mod growing;
pub mod measure;
mod methods;
pub mod moving_boundary;
mod occupied;
pub mod pairs;
pub mod penetration;
pub mod placed;
pub mod points;
pub mod probe;
pub mod radial;
pub mod radius_expansion;
pub mod random;
pub mod random_apollonian;
pub mod rearrange;
pub mod replace;
pub mod rigid;
pub mod rods;
#[cfg(test)]
mod samples;
pub mod saturation;
pub mod scatter;
pub mod soft;
pub mod solids;
pub mod space;
pub mod survey;
mod target;
pub mod touch_and_stop;
pub mod voxels;
pub mod walk;
pub mod zones;

pub use apollonian::Apollonian;
pub use array::Array;
pub use bed::{Bed, Push, Spheres};
pub use compression::Compression;
pub use control_points::ControlPoints;
pub use deposition::Deposition;
pub use digital::Digital;
pub use drop_and_roll::DropAndRoll;
pub use explosive_repulsion::ExplosiveRepulsion;
pub use force_biased::ForceBiased;
pub use grading::Grading;
pub use growing::{PackingLimitedGrowth, SimultaneousGrowth};
pub use measure::{Contacts, contacts_of};
pub use methods::{METHODS, OPTIONS};
pub use moving_boundary::MovingBoundary;
pub use placed::Placed;
pub use probe::Probe;
pub use radius_expansion::RadiusExpansion;
pub use random::Random;
pub use random_apollonian::RandomApollonian;
pub use replace::Replace;
pub use survey::Reading;

use crate::clump::Clump;
use crate::format::error::FormatError;
use crate::geometry::region::Rectangle;
use crate::geometry::{Bounds, Region};
use crate::num::random::{Stream, rotation, uniform};
use crate::num::units::Speed;
use crate::num::{Fault, Job, Rotation, Vec3};
use crate::shape::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What can go wrong while grains are packed.
#[derive(Debug, Error)]
pub enum PackError {
    /// A parameter, or a body given by the user, that cannot be used.
    #[error(transparent)]
    Wrong(#[from] Fault),
    /// `packing.csv` could not be read or written.
    #[error(transparent)]
    File(#[from] FormatError),
}

/// How grains are placed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// One by one at random places where they overlap nothing.
    Random(Random),
    /// In regular rows and layers.
    Array(Array),
    /// Balls that touch those around each gap, again and again.
    Apollonian(Apollonian),
    /// Balls at random places, each as large as fits.
    RandomApollonian(RandomApollonian),
    /// Seeds that grow at one speed until they touch.
    SimultaneousGrowth(SimultaneousGrowth),
    /// Seeds that come one after another and grow at speeds of their own until they touch.
    PackingLimitedGrowth(PackingLimitedGrowth),
    /// Grains that fall one by one and roll to rest.
    DropAndRoll(DropAndRoll),
    /// Grains that grow from small ones to the target porosity.
    RadiusExpansion(RadiusExpansion),
    /// Overlapping grains at random places that push each other apart.
    ExplosiveRepulsion(ExplosiveRepulsion),
    /// Walls that move in until they are those of the container.
    MovingBoundary(MovingBoundary),
    /// The densest random packing of grains of given proportions.
    ForceBiased(ForceBiased),
    /// Grains that our own DEM compresses to a stress, a porosity or a coordination number.
    Compression(Compression),
    /// Grains that fall into place under gravity in our own DEM.
    Deposition(Deposition),
    /// Grains of cells that wander cell by cell.
    Digital(Digital),
    /// Bodies of surface points that move along random unit vectors.
    ControlPoints(ControlPoints),
    /// Spheres of equal volume, each replaced by its clump.
    Replace(Replace),
    /// Where the user says.
    Placed(Placed),
}

/// How grains are turned when they are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Turn {
    /// Uniform over all rotations; about z only in two dimensions.
    #[default]
    Random,
    /// As the solid lies in its own file.
    Aligned,
}

impl Turn {
    fn draw(self, grain: &Grain, dimension: usize, stream: &mut Stream) -> Rotation {
        match (self, dimension) {
            (Self::Aligned, _) => grain.clump.axes,
            (Self::Random, 2) => {
                let angle = uniform(stream, 0.0, std::f64::consts::TAU);
                Rotation::from_axis_angle(&Vec3::z_axis(), angle)
            }
            (Self::Random, _) => rotation(stream),
        }
    }
}

impl Method {
    /// Its key in a scene file.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Random(_) => "random",
            Self::Array(_) => "array",
            Self::Apollonian(_) => "apollonian",
            Self::RandomApollonian(_) => "random_apollonian",
            Self::SimultaneousGrowth(_) => "simultaneous_growth",
            Self::PackingLimitedGrowth(_) => "packing_limited_growth",
            Self::DropAndRoll(_) => "drop_and_roll",
            Self::RadiusExpansion(_) => "radius_expansion",
            Self::ExplosiveRepulsion(_) => "explosive_repulsion",
            Self::MovingBoundary(_) => "moving_boundary",
            Self::ForceBiased(_) => "force_biased",
            Self::Compression(_) => "compression",
            Self::Deposition(_) => "deposition",
            Self::Digital(_) => "digital",
            Self::ControlPoints(_) => "control_points",
            Self::Replace(_) => "replace",
            Self::Placed(_) => "placed",
        }
    }

    /// Whether our own DEM does it, so that the scene's contacts, walls and plan count.
    pub fn is_prepared(&self) -> bool {
        matches!(self, Self::Compression(_) | Self::Deposition(_))
    }

    /// Whether it scales grains to the places it finds, so that their sizes in the scene do not count.
    pub fn makes_sizes(&self) -> bool {
        matches!(
            self,
            Self::Apollonian(_)
                | Self::RandomApollonian(_)
                | Self::SimultaneousGrowth(_)
                | Self::PackingLimitedGrowth(_)
        )
    }

    /// A fault where it does not fill boxes that repeat along these axes.
    fn fills(&self, periodic: [bool; 3], dimension: usize) -> Result<(), Fault> {
        let fault = |problem: &str, allowed: &str| Err(Fault::new(self.key(), problem, allowed));
        let up = periodic[dimension - 1];
        match self {
            Self::Apollonian(_) if periodic.contains(&true) => fault(
                "does not fill periodic boxes, which repeat",
                "a box without `periodic`, or another method",
            ),
            Self::DropAndRoll(_) if up => fault(
                "falls along an axis that repeats",
                "`periodic` along the level axes only, or another method",
            ),
            Self::Digital(Digital { gravity: true, .. }) if up => fault(
                "has gravity along an axis that repeats",
                "`periodic` along the level axes only, or `gravity = false`",
            ),
            Self::ControlPoints(points) if up && points.gravity > 0.0 => fault(
                "has gravity along an axis that repeats",
                "`periodic` along the level axes only, or `gravity = 0`",
            ),
            _ => Ok(()),
        }
    }

    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Random(parameters) => parameters.validate(),
            Self::Array(parameters) => parameters.validate(),
            Self::Apollonian(parameters) => parameters.validate(),
            Self::RandomApollonian(parameters) => parameters.validate(),
            Self::SimultaneousGrowth(parameters) => parameters.validate(),
            Self::PackingLimitedGrowth(parameters) => parameters.validate(),
            Self::DropAndRoll(parameters) => parameters.validate(),
            Self::RadiusExpansion(parameters) => parameters.validate(),
            Self::ExplosiveRepulsion(parameters) => parameters.validate(),
            Self::MovingBoundary(parameters) => parameters.validate(),
            Self::ForceBiased(parameters) => parameters.validate(),
            Self::Compression(parameters) => parameters.validate(),
            Self::Deposition(parameters) => parameters.validate(),
            Self::Digital(parameters) => parameters.validate(),
            Self::ControlPoints(parameters) => parameters.validate(),
            Self::Replace(parameters) => parameters.validate(),
            Self::Placed(parameters) => parameters.validate(),
        }
        .map_err(|fault| fault.under(self.key()))
    }
}

/// Places `grains` in `region` and measures what came out.
///
/// `families[grain.family]` names the family of a grain. The region says whether
/// the packing is in two dimensions (then every body has z = 0 and turns about
/// z only). Same input and seed give the same bits.
///
/// Errors: parameters that [`Method::validate`] refuses, a velocity along z in
/// two dimensions, bodies of [`Placed`] that do not exist or overlap too much.
/// Grains without a place are no error: see [`Packing::dropped`].
pub fn pack(
    grains: &[Grain],
    families: &[&str],
    region: &Region,
    method: &Method,
    seed: u64,
    job: &Job,
) -> Result<Packing, PackError> {
    method.validate()?;
    for (index, grain) in grains.iter().enumerate() {
        if grain.clump.balls.is_empty() {
            return Err(
                Fault::new(format!("grains[{index}]"), "has no sphere", "one or more").into()
            );
        }
    }
    let reach = grains.iter().map(occupied::clump_radius).fold(0.0, f64::max);
    fits_its_images(region, reach)?;
    if let Some(cell) = region.cell() {
        method.fills(cell.periodic, region.dimension())?;
    }
    let laid = match method {
        Method::Random(parameters) => parameters.lay(grains, families, region, seed, job),
        Method::Array(parameters) => parameters.lay(grains, region, seed, job),
        Method::Apollonian(parameters) => parameters.lay(grains, region, seed, job),
        Method::RandomApollonian(parameters) => parameters.lay(grains, region, seed, job),
        Method::SimultaneousGrowth(parameters) => parameters.lay(grains, region, seed, job),
        Method::PackingLimitedGrowth(parameters) => parameters.lay(grains, region, seed, job),
        Method::DropAndRoll(parameters) => parameters.lay(grains, region, seed, job),
        Method::RadiusExpansion(parameters) => parameters.lay(grains, region, seed, job),
        Method::ExplosiveRepulsion(parameters) => parameters.lay(grains, region, seed, job),
        Method::MovingBoundary(parameters) => parameters.lay(grains, region, seed, job),
        Method::ForceBiased(parameters) => parameters.lay(grains, region, seed, job),
        Method::Compression(_) | Method::Deposition(_) => {
            let problem = "is done by the DEM, which this function stands before";
            Err(Fault::new(method.key(), problem, "a scene, through its road"))
        }
        Method::Digital(parameters) => parameters.lay(grains, region, seed, job),
        Method::ControlPoints(parameters) => parameters.lay(grains, region, seed, job),
        Method::Replace(parameters) => {
            return Ok(measured(
                parameters.lay(grains, families, region, seed, job)?,
                grains,
                region,
            ));
        }
        Method::Placed(parameters) => parameters.lay(grains, families, region),
    }?;
    let grown = laid
        .placements
        .iter()
        .map(|laid| laid.scale * occupied::clump_radius(&grains[laid.grain as usize]));
    fits_its_images(region, grown.fold(0.0, f64::max))?;
    Ok(measured(laid, grains, region))
}

/// A fault for bodies that reach `reach` [m] from their centres in a periodic box too short for them.
fn fits_its_images(region: &Region, reach: f64) -> Result<(), Fault> {
    let Some(axis) = region.cell().and_then(|cell| cell.too_short(reach)) else { return Ok(()) };
    let name = ["x", "y", "z"][axis];
    let problem = format!("is too short along {name} for grains of bounding radius {reach} m");
    let allowed = format!("periodic edges of at least {} m", 4.0 * reach);
    Err(Fault::new("container", problem, allowed))
}

fn measured(mut laid: Laid, grains: &[Grain], region: &Region) -> Packing {
    if let Some(cell) = region.cell() {
        for placement in &mut laid.placements {
            placement.position += cell.home(&placement.position);
        }
    }
    laid.placements.sort_by_key(|placement| placement.grain);
    laid.dropped.sort_unstable();
    let measures = measure::measure(&laid.placements, grains, region);
    let Laid { placements, dropped, outcome } = laid;
    Packing { placements, dropped, outcome, measures }
}

/// A fault for a porosity of `region` that no random packing of `grains` has.
pub fn possible(grains: &[Grain], region: &Region, porosity: f64) -> Result<(), Fault> {
    target::Target::of(grains, region, Some(porosity)).map(drop)
}

/// Places grains one by one where there is no container. The porosity is that
/// of the smallest box along the axes around all spheres.
///
/// Errors: as [`pack`].
pub fn pack_freely(
    grains: &[Grain],
    families: &[&str],
    dimension: usize,
    method: &Placed,
    job: &Job,
) -> Result<Packing, PackError> {
    let open_box = |bounds| {
        Region::Box(Rectangle { bounds, dimension, open: [[true; 2]; 3], periodic: [false; 3] })
    };
    let far = Bounds { low: Vec3::repeat(-FAR), high: Vec3::repeat(FAR) };
    let method = Method::Placed(method.clone());
    let mut packing = pack(grains, families, &open_box(far), &method, 0, job)?;
    let around = packing.placements.iter().fold(Bounds::EMPTY, |bounds, laid| {
        let balls = &grains[laid.grain as usize].clump.balls;
        balls.iter().fold(bounds, |bounds, ball| {
            let centre = laid.position + laid.orientation * ball.centre;
            bounds.union(&Bounds::of([&centre]).grown(ball.radius))
        })
    });
    packing.measures = measure::measure(&packing.placements, grains, &open_box(around));
    Ok(packing)
}

/// Farther than any body of a scene, m.
const FAR: f64 = 1e12;

/// What a method hands back.
struct Laid {
    placements: Vec<Placement>,
    dropped: Vec<u32>,
    outcome: String,
}

impl Laid {
    /// Where no grain was asked for.
    fn nothing() -> Self {
        let outcome = "no grain was asked for".to_owned();
        Self { placements: Vec::new(), dropped: Vec::new(), outcome }
    }
}

/// "placed 9 of 10 grains, 0.9 of 1 m³ (90 %)" and what was dropped, where sizes are those wanted.
fn tally(grains: &[Grain], placements: &[Placement], dropped: &[u32], why: &str) -> String {
    tally_scaled(grains, placements, dropped, why, 3)
}

/// As [`tally`] in `dimension` dimensions, with the volumes of grains whose size was changed.
fn tally_scaled(
    grains: &[Grain],
    placements: &[Placement],
    dropped: &[u32],
    why: &str,
    dimension: usize,
) -> String {
    let wanted: f64 = grains.iter().map(|grain| grain.clump.volume).sum();
    let volume =
        |p: &Placement| grains[p.grain as usize].clump.volume * p.scale.powi(dimension as i32);
    let got: f64 = placements.iter().map(volume).sum();
    let share = if wanted > 0.0 { 100.0 * got / wanted } else { 100.0 };
    let mut text = format!(
        "placed {} of {} grains, {got:.4e} of {wanted:.4e} m³ wanted ({share:.2} %)",
        placements.len(),
        grains.len()
    );
    if !dropped.is_empty() {
        text.push_str(&format!("; dropped {}: {why}", dropped.len()));
    }
    text
}

/// Velocity of all bodies, checked against the dimension.
fn common_velocity(velocity: &[Speed; 3], dimension: usize) -> Result<Vec3, Fault> {
    if dimension == 2 && velocity[2].0 != 0.0 {
        let problem = format!("has {} m/s along z in two dimensions", velocity[2].0);
        return Err(Fault::new("velocity", problem, "0 along z"));
    }
    Ok(Vec3::from_fn(|axis, _| velocity[axis].0))
}

fn finite_velocity(velocity: &[Speed; 3]) -> Result<(), Fault> {
    if velocity.iter().all(|v| v.0.is_finite()) {
        return Ok(());
    }
    Err(Fault::new("velocity", "is not finite", "three finite numbers"))
}

/// One grain to be placed.
#[derive(Debug, Clone, Copy)]
pub struct Grain<'a> {
    /// Spheres and mass properties in the body frame.
    pub clump: &'a Clump,
    /// True shape, in the frame that `clump.centroid` and `clump.axes` refer to;
    /// `None` for plain spheres and discs.
    pub solid: Option<&'a Solid>,
    /// Index of the family in the scene.
    pub family: u16,
}

/// Where one grain went.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Index into the list of grains that was given.
    pub grain: u32,
    /// Centre of mass, m.
    pub position: Vec3,
    /// Turns the body frame into the world frame.
    pub orientation: Rotation,
    /// Velocity, m/s.
    pub velocity: Vec3,
    /// Angular velocity in the world frame, rad/s.
    pub spin: Vec3,
    /// Size of the body over that of the grain, by length; 1 but for methods that change sizes.
    #[serde(default = "unchanged")]
    pub scale: f64,
}

fn unchanged() -> f64 {
    1.0
}

/// A packing and how it came out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Packing {
    /// One entry for each grain that was placed, in the order in which bodies are numbered.
    pub placements: Vec<Placement>,
    /// Grains that found no place.
    pub dropped: Vec<u32>,
    /// How the method ended, one line for people.
    pub outcome: String,
    /// What the packing is like.
    pub measures: Measures,
}

/// Measures of a packing (P18).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// Volume (area in two dimensions) of the container, m³ (m²).
    pub container_volume: f64,
    /// Porosity: 1 − volume of the united grains over that of the container.
    pub porosity: f64,
    /// Standard error of the porosity; 0 where it is exact.
    pub porosity_error: f64,
    /// Mean number of other bodies each body touches (gap ≤ `gap_tolerance`).
    pub coordination: f64,
    /// Gap up to which two bodies count as touching, m.
    pub gap_tolerance: f64,
    /// Largest overlap between spheres of different bodies over the smaller radius.
    pub worst_overlap: f64,
    /// Least gap between spheres of different bodies, m (negative: overlap); `None` for fewer than two bodies
    /// or where no two bodies are near each other.
    pub least_gap: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_names_a_variant_and_text_goes_both_ways() {
        let bodies = "{ bodies = [{ grain = 0, position = [0, 0, 0] }] }";
        for entry in METHODS {
            let text =
                format!("{} = {}", entry.key, if entry.key == "placed" { bodies } else { "{}" });
            let method: Method = toml::from_str(&text).expect("a known key");
            assert_eq!(method.validate(), Ok(()));
            let written = toml::to_string(&method).expect("can be written");
            assert_eq!(toml::from_str::<Method>(&written).expect("can be read"), method);
        }
        let schema = serde_json::to_string(&schemars::schema_for!(Method)).expect("a schema");
        assert!(METHODS.iter().all(|entry| schema.contains(&format!("\"{}\"", entry.key))));
        for typo in ["random = { trys = 3 }", "array = { pattern = 'hex' }", "rain = {}"] {
            assert!(toml::from_str::<Method>(typo).is_err(), "{typo}");
        }
    }

    #[test]
    fn boxes_that_repeat_are_filled_across_their_sides() {
        for (dimension, share) in [(2, 0.5), (3, 0.3)] {
            let volume = share / 60.0;
            let radius = match dimension {
                2 => (volume / std::f64::consts::PI).sqrt(),
                _ => (0.75 * volume / std::f64::consts::PI).cbrt(),
            };
            let clumps: Vec<_> = (0..60).map(|_| samples::sphere(radius, dimension)).collect();
            let grains = samples::of(&clumps);
            let size = &[1.0, 1.0, 1.0][..dimension];
            let all = samples::periodic_room(size, [true, true, dimension == 3]);
            let level = samples::periodic_room(size, [true, dimension == 3, false]);
            for entry in METHODS {
                if ["placed", "compression", "deposition"].contains(&entry.key) {
                    continue;
                }
                let method: Method =
                    toml::from_str(&format!("{} = {{}}", entry.key)).expect("defaults");
                let fill = |room| pack(&grains, &[], room, &method, 1, &Job::quiet());
                let (room, packed) = match fill(&all) {
                    Ok(packing) => (&all, Ok(packing)),
                    Err(error) => {
                        assert!(error.to_string().contains("repeat"), "{}: {error}", entry.key);
                        (&level, fill(&level))
                    }
                };
                if entry.key == "apollonian" {
                    assert!(packed.expect_err("refused").to_string().contains("periodic boxes"));
                    continue;
                }
                let packing = packed.unwrap_or_else(|error| panic!("{}: {error}", entry.key));
                let periodic = room.cell().expect("repeats").periodic;
                let (gap, wall) = samples::brute_force(&packing, &grains, room);
                assert!(packing.placements.len() > 30, "{}: {}", entry.key, packing.outcome);
                // Digital packing may let true forms in by about a cell, a twelfth of the diameter.
                let least = if entry.key == "digital" { -0.17 } else { -1e-3 } * radius;
                assert!(
                    gap > least && wall > least,
                    "{}, {dimension}-D: {gap} {wall} {}",
                    entry.key,
                    packing.outcome
                );
                let crossing = |laid: &Placement| {
                    let reach = laid.scale * radius;
                    (0..dimension).filter(|&axis| periodic[axis]).any(|axis| {
                        laid.position[axis] < reach || laid.position[axis] > 1.0 - reach
                    })
                };
                let inside = |laid: &Placement| {
                    (0..dimension).all(|axis| (0.0..=1.0).contains(&laid.position[axis]))
                };
                assert!(packing.placements.iter().all(inside), "{}", entry.key);
                assert!(
                    entry.key == "array" || packing.placements.iter().any(crossing),
                    "{} keeps off the sides",
                    entry.key
                );
            }
        }
    }

    #[test]
    fn a_grain_without_spheres_is_refused() {
        let clumps = [samples::clump(Vec::new(), 1.0)];
        let method = Method::Array(Array::default());
        let room = samples::room(&[1.0, 1.0]);
        let result = pack(&samples::of(&clumps), &[], &room, &method, 1, &Job::quiet());
        assert!(result.expect_err("no sphere").to_string().contains("grains[0]"));
    }
}
