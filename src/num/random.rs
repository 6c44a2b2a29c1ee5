//! Random numbers that survive upgrades and threads: one ChaCha8 stream per
//! body or purpose, derived from the scene's seed, never shared.

use super::{Rotation, Vec3};
use nalgebra::Quaternion;
pub use rand::RngExt;
use rand::SeedableRng;
pub use rand::rngs::ChaCha8Rng as Stream;

/// The stream of `purpose` number `index` under `seed`.
///
/// The purpose and the index choose one of 2^64 independent streams of the
/// generator keyed by the seed, so that the numbers of one grain do not change
/// when another grain is added or when work is spread over threads.
pub fn stream(seed: u64, purpose: &str, index: u64) -> Stream {
    let mut generator = Stream::seed_from_u64(seed);
    generator.set_stream(
        fnv1a(purpose.as_bytes()).wrapping_add(index.wrapping_mul(0x9E37_79B9_7F4A_7C15)),
    );
    generator
}

/// FNV-1a, 64 bits: a hash that is the same on every machine and in every version.
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Uniform in `low..high`; `low` when the two are equal.
pub fn uniform(stream: &mut Stream, low: f64, high: f64) -> f64 {
    low + (high - low) * stream.random::<f64>()
}

/// Uniform among the whole numbers `low..=high`.
pub fn whole(stream: &mut Stream, low: u64, high: u64) -> u64 {
    stream.random_range(low..=high)
}

/// Standard normal deviate (Box–Muller, one of the pair).
pub fn normal(stream: &mut Stream) -> f64 {
    // 1 - u lies in (0, 1], so the logarithm is finite.
    let u = 1.0 - stream.random::<f64>();
    let angle = std::f64::consts::TAU * stream.random::<f64>();
    (-2.0 * u.ln()).sqrt() * angle.cos()
}

/// Unit vector, uniform on the sphere.
pub fn direction(stream: &mut Stream) -> Vec3 {
    let z = uniform(stream, -1.0, 1.0);
    let angle = std::f64::consts::TAU * stream.random::<f64>();
    let ring = (1.0 - z * z).sqrt();
    Vec3::new(ring * angle.cos(), ring * angle.sin(), z)
}

/// Rotation, uniform on SO(3) (Shoemake 1992).
pub fn rotation(stream: &mut Stream) -> Rotation {
    let u: f64 = stream.random();
    let (a, b) = (
        std::f64::consts::TAU * stream.random::<f64>(),
        std::f64::consts::TAU * stream.random::<f64>(),
    );
    let (s, t) = ((1.0 - u).sqrt(), u.sqrt());
    Rotation::from_quaternion(Quaternion::new(t * b.cos(), s * a.sin(), s * a.cos(), t * b.sin()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_stable_and_distinct() {
        let first: u64 = stream(1, "grain", 0).random();
        assert_eq!(first, stream(1, "grain", 0).random::<u64>());
        assert_ne!(first, stream(1, "grain", 1).random::<u64>());
        assert_ne!(first, stream(2, "grain", 0).random::<u64>());
        assert_ne!(first, stream(1, "pack", 0).random::<u64>());
    }

    #[test]
    fn rotations_are_uniform_on_average() {
        let mut source = stream(3, "test", 0);
        let mean = (0..20_000)
            .fold(Vec3::zeros(), |sum, _| sum + rotation(&mut source) * Vec3::x())
            / 20_000.0;
        // Each component has standard error 1/sqrt(3 * 20000) = 0.004.
        assert!(mean.amax() < 0.02, "{mean}");
    }

    #[test]
    fn normal_has_unit_variance() {
        let mut source = stream(4, "test", 0);
        let square = (0..40_000).map(|_| normal(&mut source).powi(2)).sum::<f64>() / 40_000.0;
        assert!((square - 1.0).abs() < 0.03, "{square}");
    }
}
