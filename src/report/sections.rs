//! (sections)
