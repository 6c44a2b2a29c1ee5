//! Numbers with names: units, random streams, rotations, statistics, and the
//! two things every long computation is handed: a `Job` (progress, cancelling,
//! threads) and a way to say what is wrong with an input (`Fault`).

pub mod clock;
pub mod eigen;
pub mod entry;
pub mod fault;
pub mod job;
pub mod random;
pub mod statistics;
pub mod units;

pub use entry::MethodEntry;
pub use fault::Fault;
pub use job::Job;

/// A point or vector in space, components in the unit its name says.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3 × 3 matrix, row index first.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A rotation; turns body-frame vectors into world-frame vectors unless said otherwise.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
