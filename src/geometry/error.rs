//! What this room refuses.

use super::check::MeshFault;
use thiserror::Error;

/// A geometric operation that has no sound result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GeometryError {
    /// The result, or an input, is no solid.
    #[error("{what} is no solid: {fault}")]
    NoSolid {
        /// Which mesh: "solid 3", "the union".
        what: String,
        /// Why.
        fault: MeshFault,
    },
    /// There is nothing to work on.
    #[error("nothing to unite")]
    NothingToUnite,
    /// The boolean kernel could not do it.
    #[error("solid {index} could not be united with those before it: {reason}")]
    Union {
        /// Number of the solid, from 0.
        index: usize,
        /// What the kernel says.
        reason: String,
    },
    /// A random method gave nothing to make a surface of.
    #[error("{reason}")]
    Method {
        /// Why.
        reason: String,
    },
    /// Points without a hull.
    #[error("no convex hull: {reason}")]
    NoHull {
        /// Why.
        reason: String,
    },
}
