//! One wrong value in an input: where, what, and what would be right.

use std::fmt;

/// A value that cannot be used.
///
/// `key` is the dotted path of the value inside the parameters that were
/// validated, for example `grains[0].size`; the scene reader finds the line
/// and column that belong to it. Validators of inner structs name keys
/// relative to themselves; callers put their own key in front with [`Fault::under`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Dotted path of the offending key, `[i]` for elements of arrays.
    pub key: String,
    /// What is wrong, in a short clause that names the value: "is -1 mm".
    pub problem: String,
    /// What would be right: "a length greater than 0".
    pub allowed: String,
}

impl Fault {
    /// A fault at `key`.
    pub fn new(
        key: impl Into<String>,
        problem: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self { key: key.into(), problem: problem.into(), allowed: allowed.into() }
    }

    /// The same fault seen from the struct that holds this one under `outer`.
    pub fn under(mut self, outer: impl AsRef<str>) -> Self {
        let outer = outer.as_ref();
        self.key = match (outer.is_empty(), self.key.is_empty(), self.key.starts_with('[')) {
            (true, _, _) => self.key,
            (false, true, _) => outer.to_owned(),
            (false, false, true) => format!("{outer}{}", self.key),
            (false, false, false) => format!("{outer}.{}", self.key),
        };
        self
    }

    /// A fault when `value` is not finite and greater than zero.
    pub fn positive(key: &str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(Self::new(key, format!("is {value}"), "a finite number greater than 0"))
    }

    /// A fault when `value` is not finite or less than zero.
    pub fn not_negative(key: &str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value >= 0.0 {
            return Ok(());
        }
        Err(Self::new(key, format!("is {value}"), "a finite number, 0 or greater"))
    }

    /// A fault when `value` lies outside `low..=high`.
    pub fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), Self> {
        if value.is_finite() && (low..=high).contains(&value) {
            return Ok(());
        }
        Err(Self::new(key, format!("is {value}"), format!("a number from {low} to {high}")))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.key.is_empty() {
            return write!(f, "the file {}; allowed: {}", self.problem, self.allowed);
        }
        write!(f, "`{}` {}; allowed: {}", self.key, self.problem, self.allowed)
    }
}

impl std::error::Error for Fault {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_grow_outwards() {
        let fault = Fault::new("min", "is -1", "more").under("size").under("[0]").under("grains");
        assert_eq!(fault.key, "grains[0].size.min");
    }

    #[test]
    fn nan_is_never_in_range() {
        assert!(Fault::positive("a", f64::NAN).is_err());
        assert!(Fault::not_negative("a", f64::INFINITY).is_err());
        assert!(Fault::within("a", f64::NAN, 0.0, 1.0).is_err());
    }
}
