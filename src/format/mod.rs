//! (format)

pub mod atomic;
pub mod error;
