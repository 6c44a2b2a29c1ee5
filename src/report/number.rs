//! Numbers as people read them.

/// SI prefixes with their factor, falling.
const PREFIXES: [(&str, f64); 9] = [
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("", 1.0),
    ("m", 1e-3),
    ("µ", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
    ("f", 1e-15),
];

/// `value` with `digits` significant digits: plain from 1e-3 to 1e6, else with
/// a power of ten; a dash for what is no number.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let rounded = format!("{:.*e}", digits.max(1) - 1, value);
    // `{:e}` of a finite number always holds an `e` followed by a whole number.
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return trimmed(&format!("{value:.decimals$}")).to_owned();
    }
    format!("{}e{exponent}", trimmed(mantissa))
}

/// Without zeros at the end of a decimal fraction.
pub(crate) fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// A relative number as per cent with a sign: `+1.3 %`; `≈ 0 %` for what is
/// less than a hundred-thousandth of a per cent.
pub fn per_cent(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-7 {
        return "≈ 0 %".into();
    }
    let text = significant(value * 100.0, 3);
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{text} %")
}

/// The SI prefix that brings `largest` to 1–1000, with its factor; none for
/// units that are not prefixed (empty, `%`, `kg…`) or have a power.
pub fn prefix(largest: f64, unit: &str) -> (&'static str, f64) {
    let plain = ["J", "m", "s", "N", "m/s", "N/m", "Pa", "B", "W", "1/s"].contains(&unit);
    if !plain || !largest.is_finite() || largest <= 0.0 {
        return ("", 1.0);
    }
    PREFIXES.into_iter().find(|(_, factor)| largest >= *factor * 0.9999).unwrap_or(("", 1.0))
}

/// `value` with its unit and a fitting SI prefix: `2.5 mm`.
pub fn with_unit(value: f64, unit: &str) -> String {
    let (prefix, factor) = prefix(value.abs(), unit);
    let number = significant(value / factor, 3);
    if unit.is_empty() { number } else { format!("{number} {prefix}{unit}") }
}

/// A number of bytes: `12.3 MB`.
pub fn bytes(count: u64) -> String {
    with_unit(count as f64, "B")
}

/// A count with thin spaces between thousands: `1 234 567`.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits() {
        assert_eq!(significant(0.0123456, 3), "0.0123");
        assert_eq!(significant(1234.0, 3), "1234");
        assert_eq!(significant(2.0, 3), "2");
        assert_eq!(significant(-9.9996e-5, 3), "-1e-4");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(0.0, 3), "0");
    }

    #[test]
    fn units_and_counts() {
        assert_eq!(with_unit(0.0025, "m"), "2.5 mm");
        assert_eq!(with_unit(2.5e-7, "J"), "250 nJ");
        assert_eq!(with_unit(0.3, "kg/m³"), "0.3 kg/m³");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(per_cent(0.0132), "+1.32 %");
        assert_eq!(bytes(12_300_000), "12.3 MB");
    }
}
