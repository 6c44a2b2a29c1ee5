//! Numbers as text, without loss.

/// `value` with up to 17 significant digits, as C's `%.17g` chooses them:
/// reading the text back gives the same bits, −0 included.
///
/// The writers of this room refuse values that are not finite before they come
/// here ([`Particles::check`](super::Particles::check)).
pub fn number(value: f64) -> String {
    let mut text = String::with_capacity(24);
    push_number(&mut text, value);
    text
}

/// Puts [`number`]`(value)` at the end of `out`.
pub fn push_number(out: &mut String, value: f64) {
    let scientific = format!("{:.16e}", value.abs());
    let parts = scientific.split_once('e').and_then(|(mantissa, exponent)| {
        Some((mantissa.replace('.', ""), exponent.parse::<i32>().ok()?))
    });
    let Some((digits, exponent)) = parts else {
        out.push_str(&scientific);
        return;
    };
    if value.is_sign_negative() {
        out.push('-');
    }
    let digits = match digits.trim_end_matches('0') {
        "" => "0",
        trimmed => trimmed,
    };
    match exponent {
        -4..0 => {
            out.push_str("0.");
            out.extend(std::iter::repeat_n('0', (-exponent - 1) as usize));
            out.push_str(digits);
        }
        0..17 => {
            let whole = exponent as usize + 1;
            let (front, back) = digits.split_at(whole.min(digits.len()));
            out.push_str(front);
            out.extend(std::iter::repeat_n('0', whole - front.len()));
            push_fraction(out, back);
        }
        _ => {
            let (front, back) = digits.split_at(1);
            out.push_str(front);
            push_fraction(out, back);
            out.push('e');
            out.push_str(&exponent.to_string());
        }
    }
}

fn push_fraction(out: &mut String, digits: &str) {
    if !digits.is_empty() {
        out.push('.');
        out.push_str(digits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn looks_like_percent_17_g() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (1500.0, "1500"),
            (0.1, "0.10000000000000001"),
            (1.0 / 3.0, "0.33333333333333331"),
            (1e-4, "0.0001"),
            (1e-9, "1.0000000000000001e-9"),
            (1e16, "10000000000000000"),
            (1e17, "1e17"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    proptest! {
        #[test]
        fn reads_back_to_the_same_bits(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(number(value).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
        }
    }
}
