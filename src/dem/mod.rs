//! (dem)
