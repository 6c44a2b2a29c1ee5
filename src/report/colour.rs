//! Colours: distinct under the common colour-vision deficiencies, calm, the
//! same in charts and pictures.

/// A colour, red, green, blue in 0..=1 (sRGB).
pub type Rgb = [f32; 3];

/// Lines and bars in charts (from the palette of Okabe & Ito 2008, mid-tones
/// that hold on white and on black).
pub const SERIES: [&str; 6] = ["#2b7bba", "#d9731a", "#1f9e77", "#b5569b", "#8a8f98", "#b59b00"];

/// Grains in pictures: tones of stone with enough hue to tell neighbours apart.
const STONES: [Rgb; 10] = [
    [0.353, 0.545, 0.678],
    [0.878, 0.604, 0.322],
    [0.427, 0.639, 0.549],
    [0.788, 0.451, 0.400],
    [0.847, 0.776, 0.631],
    [0.580, 0.522, 0.667],
    [0.663, 0.690, 0.706],
    [0.729, 0.639, 0.322],
    [0.310, 0.431, 0.490],
    [0.757, 0.569, 0.627],
];

/// One stone colour for plain surfaces.
pub const STONE: Rgb = [0.80, 0.73, 0.62];
/// The colour of clumps beside their stone-coloured solid.
pub const CLUMP: Rgb = [0.36, 0.56, 0.70];

/// Colour of group `index`.
pub fn group(index: usize) -> Rgb {
    STONES[index % STONES.len()]
}

/// Colour of body `index`: neighbours in the numbering get different tones,
/// and no two bodies quite the same.
pub fn body(index: usize) -> Rgb {
    let hash = crate::num::random::fnv1a(&(index as u64).to_le_bytes());
    let shade = 0.9 + 0.2 * ((hash >> 40) & 0xff) as f32 / 255.0;
    group((hash >> 20) as usize).map(|channel| (channel * shade).min(1.0))
}

/// `colour` a little lighter or darker, by the number of a sphere in its clump.
pub fn varied(colour: Rgb, index: usize) -> Rgb {
    let hash = crate::num::random::fnv1a(&(index as u64).to_le_bytes());
    let shade = 0.88 + 0.24 * ((hash >> 33) & 0xff) as f32 / 255.0;
    colour.map(|channel| (channel * shade).min(1.0))
}

/// Between `a` (0) and `b` (1).
pub fn mix(a: Rgb, b: Rgb, fraction: f32) -> Rgb {
    std::array::from_fn(|channel| a[channel] + (b[channel] - a[channel]) * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_keep_their_colour() {
        assert_eq!(body(17), body(17));
        assert_ne!(body(17), body(18));
    }
}
