//! Physical values as users write them: `0.002` means SI, `"2 mm"` says its unit.
//!
//! Each quantity is a newtype over `f64` in SI units. Text with a unit of the
//! wrong dimension, an unknown unit, NaN and infinity are refused while the
//! file is read, so the message points at the line and column of the value.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Unit names of one dimension with the factor that turns them into SI.
type Units = &'static [(&'static str, f64)];

/// Reads `text` as a number followed by one of `units`; a bare number is SI.
fn parse(text: &str, dimension: &str, units: Units) -> Result<f64, String> {
    let text = text.trim();
    let split = text
        .char_indices()
        .rfind(|(_, c)| c.is_ascii_digit() || *c == '.')
        .map_or(0, |(at, c)| at + c.len_utf8());
    let (number, unit) = text.split_at(split);
    // "1 m3" and "1 N/m2" end in a digit: look for the unit after the first blank instead.
    let (number, unit) = match text.split_once(char::is_whitespace) {
        Some((number, unit)) => (number, unit.trim()),
        None => (number, unit.trim()),
    };
    let value: f64 = number.trim().parse().map_err(|_| {
        format!("`{text}` is not a {dimension}; write a number in SI or {}", examples(units))
    })?;
    let factor = if unit.is_empty() {
        1.0
    } else {
        units.iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor).ok_or_else(
            || format!("`{unit}` is not a unit of {dimension}; known: {}", names(units)),
        )?
    };
    finite(value * factor, dimension)
}

/// Largest size of a value: masses, energies and moments of inertia made of such values are
/// still finite.
const BOUND: f64 = 1e40;

fn finite(value: f64, dimension: &str) -> Result<f64, String> {
    if value.abs() <= BOUND {
        return Ok(value);
    }
    if value.is_finite() {
        return Err(format!("{value:e} is no {dimension} of this world; allowed: up to {BOUND:e}"));
    }
    let article = if dimension.starts_with(['a', 'e']) { "an" } else { "a" };
    Err(format!("{article} {dimension} must be a finite number, not {value}"))
}

fn names(units: Units) -> String {
    units.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn examples(units: Units) -> String {
    units.iter().take(2).map(|(name, _)| format!("\"2 {name}\"")).collect::<Vec<_>>().join(" or ")
}

struct QuantityVisitor {
    dimension: &'static str,
    units: Units,
}

impl Visitor<'_> for QuantityVisitor {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {}: a number in SI or text such as {}", self.dimension, examples(self.units))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<f64, E> {
        finite(value, self.dimension).map_err(E::custom)
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<f64, E> {
        parse(text, self.dimension, self.units).map_err(E::custom)
    }
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $dimension:literal, [$(($unit:literal, $factor:expr)),* $(,)?]) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
        pub struct $name(pub f64);

        impl $name {
            const UNITS: Units = &[$(($unit, $factor)),*];

            /// Reads a number in SI or text with a unit, as in a scene file.
            pub fn parse(text: &str) -> Result<Self, String> {
                parse(text, $dimension, Self::UNITS).map(Self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer
                    .deserialize_any(QuantityVisitor { dimension: $dimension, units: Self::UNITS })
                    .map(Self)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_f64(self.0)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({
                    "description": concat!("A ", $dimension, ": a number in SI, or text with a unit."),
                    "anyOf": [
                        { "type": "number" },
                        { "type": "string", "examples": [format!("2 {}", Self::UNITS[0].0)] }
                    ]
                })
            }
        }
    };
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

quantity!(/// Metres.
    Length, "length", [("mm", 1e-3), ("m", 1.0), ("cm", 1e-2), ("um", 1e-6), ("µm", 1e-6), ("nm", 1e-9), ("km", 1e3), ("in", 0.0254)]);
quantity!(/// Seconds.
    Time, "time", [("ms", 1e-3), ("s", 1.0), ("us", 1e-6), ("µs", 1e-6), ("ns", 1e-9), ("min", 60.0), ("h", 3600.0)]);
quantity!(/// Radians.
    Angle, "angle", [("deg", DEGREE), ("rad", 1.0), ("°", DEGREE)]);
quantity!(/// Metres per second.
    Speed, "speed", [("m/s", 1.0), ("mm/s", 1e-3), ("cm/s", 1e-2), ("km/h", 1.0 / 3.6)]);
quantity!(/// Radians per second.
    Spin, "rate of rotation", [("rad/s", 1.0), ("rpm", std::f64::consts::TAU / 60.0), ("deg/s", DEGREE), ("1/s", 1.0)]);
quantity!(/// Metres per second squared.
    Acceleration, "acceleration", [("m/s2", 1.0), ("m/s^2", 1.0), ("m/s²", 1.0), ("g", 9.80665)]);
quantity!(/// Kilograms.
    Mass, "mass", [("g", 1e-3), ("kg", 1.0), ("mg", 1e-6), ("t", 1e3)]);
quantity!(/// Kilograms per cubic metre.
    Density, "density", [("kg/m3", 1.0), ("kg/m^3", 1.0), ("kg/m³", 1.0), ("g/cm3", 1e3), ("g/cm^3", 1e3), ("t/m3", 1e3)]);
quantity!(/// Newtons per metre.
    Stiffness, "stiffness", [("N/m", 1.0), ("kN/m", 1e3), ("MN/m", 1e6), ("N/mm", 1e3)]);
quantity!(/// Newton seconds per metre.
    Damping, "damping coefficient", [("N s/m", 1.0), ("Ns/m", 1.0), ("kg/s", 1.0)]);
quantity!(/// Pascals.
    Pressure, "pressure", [("MPa", 1e6), ("Pa", 1.0), ("kPa", 1e3), ("GPa", 1e9), ("N/m2", 1.0)]);
quantity!(/// Newtons.
    Force, "force", [("mN", 1e-3), ("N", 1.0), ("uN", 1e-6), ("µN", 1e-6), ("nN", 1e-9), ("kN", 1e3)]);
quantity!(/// Joules.
    Energy, "energy", [("J", 1.0), ("mJ", 1e-3), ("uJ", 1e-6), ("µJ", 1e-6), ("nJ", 1e-9), ("zJ", 1e-21), ("eV", 1.602_176_634e-19)]);
quantity!(/// Joules per cubic metre.
    EnergyDensity, "energy density", [("J/m3", 1.0), ("J/m^3", 1.0), ("J/m³", 1.0), ("kJ/m3", 1e3), ("Pa", 1.0), ("kPa", 1e3)]);
quantity!(/// Newtons per metre, joules per square metre.
    SurfaceTension, "surface tension or work of adhesion", [("mN/m", 1e-3), ("N/m", 1.0), ("J/m2", 1.0), ("J/m^2", 1.0), ("mJ/m2", 1e-3)]);
quantity!(/// Cubic metres.
    Volume, "volume", [("mm3", 1e-9), ("m3", 1.0), ("m^3", 1.0), ("ul", 1e-9), ("nl", 1e-12), ("pl", 1e-15), ("ml", 1e-6), ("l", 1e-3)]);
quantity!(/// Coulombs.
    Charge, "charge", [("nC", 1e-9), ("C", 1.0), ("uC", 1e-6), ("µC", 1e-6), ("pC", 1e-12), ("fC", 1e-15), ("e", 1.602_176_634e-19)]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_text_mean_the_same() {
        assert_eq!(Length::parse("2 mm"), Ok(Length(0.002)));
        assert_eq!(Length::parse("2mm"), Ok(Length(0.002)));
        assert_eq!(Length::parse("0.002"), Ok(Length(0.002)));
        assert_eq!(Density::parse("2.65 g/cm3"), Ok(Density(2650.0)));
        assert_eq!(Damping::parse("3 N s/m"), Ok(Damping(3.0)));
        assert_eq!(Time::parse("1e-3 ms"), Ok(Time(1e-6)));
        assert!(
            (Angle::parse("180 deg").map(|a| a.0).unwrap_or(0.0) - std::f64::consts::PI).abs()
                < 1e-15
        );
    }

    #[test]
    fn wrong_units_say_what_is_known() {
        let message = Length::parse("2 kg").expect_err("kilograms are no length");
        assert!(
            message.contains("`kg` is not a unit of length") && message.contains("mm"),
            "{message}"
        );
        assert!(Length::parse("two mm").is_err());
        assert!(Length::parse("nan").is_err());
        assert!(Length::parse("1e400 m").is_err());
        assert!(Length::parse("-1e300 m").is_err_and(|m| m.contains("up to 1e40")));
        assert!(Length::parse("").is_err());
    }
}
