//! (curves)
