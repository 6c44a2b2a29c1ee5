//! Size distributions (P17): diameters of grains by number or by mass.
//!
//! Every distribution becomes a quantile function of the number of grains. Grain i of N gets the quantile
//! of a random place in the i-th of N equal strata, and the list is shuffled: so a small sample follows its
//! curve to one grain a class (the aim of deficit feeding) instead of to √N.
//!
//! Curves by mass (Fuller: Fuller & Thompson 1907; Rosin & Rammler 1933; a sieve curve): between two sieves the
//! mass is spread evenly in the logarithm of the size, so the density of numbers is ∝ d^−(D+1), with D = 3 (2 for discs,
//! whose mass is ∝ d²): d = (a^−D − u (a^−D − b^−D))^(−1/D), and a class holds m (a^−D − b^−D) / (D ln(b/a)) grains.
//!
//! Diameters in m. Cost O(N log classes).

use crate::num::random::{stream, uniform, whole};
use crate::num::units::Length;
use crate::num::{Fault, MethodEntry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What `riprap list packings` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "size",
    id: "P17",
    summary: "sizes: one, uniform, gaussian, lognormal, weibull, fuller, rosin_rammler, or a sieve curve by mass; grading.csv and grading.svg beside the wanted curve",
    source: "Fuller & Thompson 1907; Rosin & Rammler 1933",
    example: r#"size = { fuller = { smallest = "5 mm", largest = "20 mm" } }"#,
};

/// What `riprap list packings` says of several families by mass.
pub const MIXTURE: MethodEntry = MethodEntry {
    key: "mixture",
    id: "P17",
    summary: "families by `fraction` of the mass of a number or a mass of grains; the shares placed are in the outcome",
    source: "PFC (Itasca), ball distribute by volume fraction",
    example: r#"mixture.mass = "2 kg""#,
};

/// A size distribution; sizes are equivalent-volume diameters (diameters for spheres and discs).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Grading {
    /// Normal by number, cut off on both sides.
    Gaussian(Gaussian),
    /// The logarithm is normal, by number, cut off on both sides.
    Lognormal(Lognormal),
    /// Weibull by number, without the rarest on both sides.
    Weibull(Weibull),
    /// Share of the mass below d: ((d/largest)^q − (smallest/largest)^q) / (1 − (smallest/largest)^q).
    Fuller(Fuller),
    /// Share of the mass below d: 1 − exp(−(d/size)^exponent), between two sizes.
    RosinRammler(RosinRammler),
    /// A curve of your own: share of the mass that passes each sieve.
    Sieve(Sieve),
}

/// Normal sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gaussian {
    /// Mean diameter, m, greater than 0.
    pub mean: Length,
    /// Standard deviation before it is cut off, m, 0 or more.
    pub deviation: Length,
    /// Sizes farther than this many deviations from the mean are left out, 0.1 to 6; default 3.
    #[serde(default = "three")]
    pub cut: f64,
}

/// Lognormal sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lognormal {
    /// Median diameter, m, greater than 0.
    pub median: Length,
    /// Standard deviation of the natural logarithm, 0 to 3.
    pub sigma: f64,
    /// Sizes farther than this many deviations from the median are left out, 0.1 to 6; default 3.
    #[serde(default = "three")]
    pub cut: f64,
}

fn three() -> f64 {
    3.0
}

/// Weibull sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weibull {
    /// Diameter that 63.2 % of the grains are smaller than, m, greater than 0.
    pub scale: Length,
    /// Exponent, 0.3 to 100.
    pub shape: f64,
    /// Share of the number that is left out on each side, 1e-6 to 0.4; default 0.001.
    #[serde(default = "thousandth")]
    pub cut: f64,
}

fn thousandth() -> f64 {
    1e-3
}

/// Fuller curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fuller {
    /// Smallest diameter, m, greater than 0.
    pub smallest: Length,
    /// Largest diameter, m, above the smallest.
    pub largest: Length,
    /// Exponent q, 0.05 to 3; default 0.5.
    #[serde(default = "half")]
    pub exponent: f64,
}

fn half() -> f64 {
    0.5
}

/// Rosin-Rammler curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RosinRammler {
    /// Diameter that 63.2 % of the mass is finer than, m, greater than 0.
    pub size: Length,
    /// Exponent, 0.1 to 20.
    pub exponent: f64,
    /// Smallest diameter, m, greater than 0; what is finer is left out.
    pub smallest: Length,
    /// Largest diameter, m, above the smallest; what is coarser is left out.
    pub largest: Length,
}

/// A sieve curve: `points` or `file`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sieve {
    /// Sieve size (m) and what passes it (% of the mass): sizes rise, shares rise from 0 to 100.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<(Length, f64)>,
    /// CSV file, relative to the scene file: two columns, sieve size and what passes (%); lines that begin with
    /// neither a digit nor a point are passed over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Unit of the sizes in `file`, m; default 1 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<Length>,
}

/// Quantiles of the number of grains.
#[derive(Debug, Clone)]
enum Quantiles {
    Gaussian { mean: f64, deviation: f64, cut: f64 },
    Lognormal { median: f64, sigma: f64, cut: f64 },
    Weibull { scale: f64, shape: f64, cut: f64 },
    Classes(Classes),
}

/// Sieve classes: mass spread evenly in the logarithm of the size.
#[derive(Debug, Clone)]
struct Classes {
    dimension: i32,
    /// Lower size, upper size, share of the number below and including.
    list: Vec<(f64, f64, f64)>,
}

impl Grading {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        match self {
            Self::Gaussian(g) => g.validate().map_err(|f| f.under("gaussian")),
            Self::Lognormal(g) => g.validate().map_err(|f| f.under("lognormal")),
            Self::Weibull(g) => g.validate().map_err(|f| f.under("weibull")),
            Self::Fuller(g) => g.validate().map_err(|f| f.under("fuller")),
            Self::RosinRammler(g) => g.validate().map_err(|f| f.under("rosin_rammler")),
            Self::Sieve(g) => g.validate().map_err(|f| f.under("sieve")),
        }
    }

    /// Diameters of `count` grains in `dimension` dimensions (m), in random order; `base` is the folder that
    /// file names start from.
    ///
    /// Errors: parameters that [`Grading::validate`] refuses, a sieve file that cannot be read or used.
    pub fn sizes(
        &self,
        count: usize,
        dimension: usize,
        base: &Path,
        seed: u64,
        purpose: &str,
    ) -> Result<Vec<f64>, Fault> {
        let quantiles = self.quantiles(dimension, base)?;
        let mut source = stream(seed, purpose, 0);
        let mut sizes: Vec<f64> = (0..count)
            .map(|i| {
                let place = (i as f64 + uniform(&mut source, 0.0, 1.0)) / count as f64;
                quantiles.at(place.min(1.0))
            })
            .collect();
        for i in (1..count).rev() {
            sizes.swap(i, whole(&mut source, 0, i as u64) as usize);
        }
        Ok(sizes)
    }

    /// Mean of d^dimension: what the mean mass of a grain goes with. By 4096 quantiles.
    ///
    /// Errors: as [`Grading::sizes`].
    pub fn mean_volume(&self, dimension: usize, base: &Path) -> Result<f64, Fault> {
        let quantiles = self.quantiles(dimension, base)?;
        let count = 4096;
        let sum: f64 = (0..count)
            .map(|i| quantiles.at((f64::from(i) + 0.5) / f64::from(count)).powi(dimension as i32))
            .sum();
        Ok(sum / f64::from(count))
    }

    /// Share of the mass that is finer than each of `sizes`, as wanted.
    ///
    /// Errors: as [`Grading::sizes`].
    pub fn passing(&self, sizes: &[f64], dimension: usize, base: &Path) -> Result<Vec<f64>, Fault> {
        let quantiles = self.quantiles(dimension, base)?;
        if let Quantiles::Classes(classes) = &quantiles {
            return Ok(sizes.iter().map(|size| classes.passing(*size)).collect());
        }
        let count = 20_000;
        let list: Vec<f64> =
            (0..count).map(|i| quantiles.at((f64::from(i) + 0.5) / f64::from(count))).collect();
        Ok(passing_of(&list, sizes, dimension))
    }

    fn quantiles(&self, dimension: usize, base: &Path) -> Result<Quantiles, Fault> {
        self.validate()?;
        Ok(match self {
            Self::Gaussian(g) => {
                Quantiles::Gaussian { mean: g.mean.0, deviation: g.deviation.0, cut: g.cut }
            }
            Self::Lognormal(g) => {
                Quantiles::Lognormal { median: g.median.0, sigma: g.sigma, cut: g.cut }
            }
            Self::Weibull(g) => Quantiles::Weibull { scale: g.scale.0, shape: g.shape, cut: g.cut },
            Self::Fuller(g) => {
                let curve = |d: f64| d.powf(g.exponent);
                Quantiles::Classes(Classes::of_curve(&curve, g.smallest.0, g.largest.0, dimension))
            }
            Self::RosinRammler(g) => {
                let curve = |d: f64| -(-(d / g.size.0).powf(g.exponent)).exp();
                Quantiles::Classes(Classes::of_curve(&curve, g.smallest.0, g.largest.0, dimension))
            }
            Self::Sieve(g) => {
                let points = g.read(base).map_err(|fault| fault.under("sieve"))?;
                Quantiles::Classes(Classes::of_points(&points, dimension))
            }
        })
    }
}

/// Share of the mass of grains of diameters `list` that is finer than each of `sizes`.
pub fn passing_of(list: &[f64], sizes: &[f64], dimension: usize) -> Vec<f64> {
    let mut sorted = list.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut sums = Vec::with_capacity(sorted.len() + 1);
    let mut sum = 0.0;
    sums.push(sum);
    for size in &sorted {
        sum += size.powi(dimension as i32);
        sums.push(sum);
    }
    let share = |size: &f64| {
        let finer = sorted.partition_point(|d| d <= size);
        if sum > 0.0 { sums[finer] / sum } else { 0.0 }
    };
    sizes.iter().map(share).collect()
}

impl Gaussian {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("mean", self.mean.0)?;
        Fault::not_negative("deviation", self.deviation.0)?;
        Fault::within("cut", self.cut, 0.1, 6.0)?;
        let least = self.mean.0 - self.cut * self.deviation.0;
        if least <= 0.0 {
            let problem = format!("lets the smallest grain be {least} m across");
            let allowed =
                format!("below {:.4}, or a smaller deviation", self.mean.0 / self.deviation.0);
            return Err(Fault::new("cut", problem, allowed));
        }
        Ok(())
    }
}

impl Lognormal {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("median", self.median.0)?;
        Fault::within("sigma", self.sigma, 0.0, 3.0)?;
        Fault::within("cut", self.cut, 0.1, 6.0)
    }
}

impl Weibull {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("scale", self.scale.0)?;
        Fault::within("shape", self.shape, 0.3, 100.0)?;
        Fault::within("cut", self.cut, 1e-6, 0.4)
    }
}

fn between(smallest: Length, largest: Length) -> Result<(), Fault> {
    Fault::positive("smallest", smallest.0)?;
    Fault::positive("largest", largest.0)?;
    if largest.0 <= smallest.0 {
        let problem = format!("is {} m, not above `smallest`", largest.0);
        return Err(Fault::new("largest", problem, format!("more than {} m", smallest.0)));
    }
    Ok(())
}

impl Fuller {
    fn validate(&self) -> Result<(), Fault> {
        between(self.smallest, self.largest)?;
        Fault::within("exponent", self.exponent, 0.05, 3.0)
    }
}

impl RosinRammler {
    fn validate(&self) -> Result<(), Fault> {
        Fault::positive("size", self.size.0)?;
        Fault::within("exponent", self.exponent, 0.1, 20.0)?;
        between(self.smallest, self.largest)
    }
}

impl Sieve {
    fn validate(&self) -> Result<(), Fault> {
        match (&self.file, self.points.is_empty()) {
            (Some(_), false) => {
                return Err(Fault::new("file", "stands beside `points`", "one of the two"));
            }
            (None, true) => return Err(Fault::new("points", "is missing", "`points` or `file`")),
            _ => {}
        }
        if let Some(unit) = self.unit {
            Fault::positive("unit", unit.0)?;
        }
        if self.points.is_empty() {
            return Ok(());
        }
        let points: Vec<(f64, f64)> =
            self.points.iter().map(|(size, share)| (size.0, *share)).collect();
        validate_curve(&points).map_err(|(index, problem, allowed)| {
            Fault::new(format!("points[{index}]"), problem, allowed)
        })
    }

    fn read(&self, base: &Path) -> Result<Vec<(f64, f64)>, Fault> {
        let Some(file) = &self.file else {
            return Ok(self.points.iter().map(|(size, share)| (size.0, *share)).collect());
        };
        let path = base.join(file);
        let wrong = |problem: String, allowed: &str| Fault::new("file", problem, allowed);
        let text = std::fs::read_to_string(&path).map_err(|error| {
            wrong(format!("{}: {error}", path.display()), "a file that can be read")
        })?;
        let unit = self.unit.map_or(1e-3, |unit| unit.0);
        let (mut points, mut lines) = (Vec::new(), Vec::new());
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            if !line.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
                continue;
            }
            let mut fields = line.split([',', ';', '\t']).map(|field| field.trim().parse::<f64>());
            let (Some(Ok(size)), Some(Ok(share))) = (fields.next(), fields.next()) else {
                let problem = format!("{}: line {} is not two numbers", path.display(), number + 1);
                return Err(wrong(
                    problem,
                    "sieve size and what passes in %, separated by a comma",
                ));
            };
            points.push((size * unit, share));
            lines.push(number + 1);
        }
        validate_curve(&points).map_err(|(index, problem, allowed)| {
            let line = lines.get(index).map_or_else(String::new, |line| format!("line {line} "));
            wrong(format!("{}: {line}{problem}", path.display()), &allowed)
        })?;
        Ok(points)
    }
}

/// Index, problem and what would be right of the first wrong point of a sieve curve.
fn validate_curve(points: &[(f64, f64)]) -> Result<(), (usize, String, String)> {
    let fail = |index, problem: String, allowed: &str| Err((index, problem, allowed.to_owned()));
    if points.len() < 2 {
        return fail(0, format!("is one of {} points", points.len()), "two points or more");
    }
    for (index, &(size, share)) in points.iter().enumerate() {
        if !(size.is_finite() && size > 0.0) {
            return fail(index, format!("has the size {size} m"), "a finite size greater than 0");
        }
        if !(0.0..=100.0).contains(&share) {
            return fail(index, format!("lets {share} % pass"), "0 to 100 %");
        }
        let Some(&(before, passed)) = index.checked_sub(1).and_then(|i| points.get(i)) else {
            continue;
        };
        if size <= before {
            return fail(index, format!("has the size {size} m after {before} m"), "rising sizes");
        }
        if share < passed {
            return fail(
                index,
                format!("falls from {passed} % to {share} %"),
                "shares that do not fall",
            );
        }
    }
    let last = points.len() - 1;
    if points[0].1 != 0.0 {
        let problem =
            format!("lets {} % pass the finest sieve: of what size is that?", points[0].1);
        return fail(0, problem, "a first point with 0 %, the size of the finest grain");
    }
    if points[last].1 != 100.0 {
        let problem = format!("lets only {} % pass the coarsest sieve", points[last].1);
        return fail(last, problem, "a last point with 100 %");
    }
    Ok(())
}

impl Classes {
    /// 64 classes between two sizes, evenly in the logarithm.
    fn of_curve(curve: &dyn Fn(f64) -> f64, low: f64, high: f64, dimension: usize) -> Self {
        const CLASSES: i32 = 64;
        let at = |i: i32| low * (high / low).powf(f64::from(i) / f64::from(CLASSES));
        let points: Vec<(f64, f64)> = (0..=CLASSES).map(|i| (at(i), curve(at(i)))).collect();
        Self::of_points(&points, dimension)
    }

    /// `points`: size and mass below it, in any unit, rising.
    fn of_points(points: &[(f64, f64)], dimension: usize) -> Self {
        let power = dimension as i32;
        let mut list = Vec::new();
        let mut total = 0.0;
        for pair in points.windows(2) {
            let ((a, below), (b, to)) = (pair[0], pair[1]);
            let mass = to - below;
            if mass > 0.0 {
                total += mass * (a.powi(-power) - b.powi(-power)) / (b / a).ln();
                list.push((a, b, total));
            }
        }
        list.iter_mut().for_each(|class| class.2 /= total);
        Self { dimension: power, list }
    }

    /// Mass below `size` over the mass of all.
    fn passing(&self, size: f64) -> f64 {
        let (mut finer, mut all, mut before) = (0.0, 0.0, 0.0);
        for &(a, b, upto) in &self.list {
            let mass = (upto - before) * (b / a).ln()
                / (a.powi(-self.dimension) - b.powi(-self.dimension));
            before = upto;
            all += mass;
            finer += mass * ((size / a).ln() / (b / a).ln()).clamp(0.0, 1.0);
        }
        if all > 0.0 { finer / all } else { 0.0 }
    }
}

impl Quantiles {
    fn at(&self, u: f64) -> f64 {
        let normal = |cut: f64| {
            let tail = below(-cut);
            normal_quantile(tail + u * (1.0 - 2.0 * tail)).clamp(-cut, cut)
        };
        match self {
            Self::Gaussian { mean, deviation, cut } => mean + deviation * normal(*cut),
            Self::Lognormal { median, sigma, cut } => median * (sigma * normal(*cut)).exp(),
            Self::Weibull { scale, shape, cut } => {
                let u = cut + u * (1.0 - 2.0 * cut);
                scale * (-(1.0 - u).ln()).powf(1.0 / shape)
            }
            Self::Classes(classes) => {
                let list = &classes.list;
                let i = list.partition_point(|class| class.2 < u).min(list.len().saturating_sub(1));
                let Some(&(a, b, upto)) = list.get(i) else { return 0.0 };
                let from = if i == 0 { 0.0 } else { list[i - 1].2 };
                let v = ((u - from) / (upto - from)).clamp(0.0, 1.0);
                let d = classes.dimension;
                let (fine, coarse) = (a.powi(-d), b.powi(-d));
                (fine - v * (fine - coarse)).powf(-1.0 / f64::from(d)).clamp(a, b)
            }
        }
    }
}

/// Share of normal deviates below `x`: the inverse of [`normal_quantile`], by halving.
fn below(x: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if normal_quantile(middle) < x { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Quantile of the standard normal distribution: P. J. Acklam's rational approximation, relative error 1.2e-9.
pub fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -3.969_683_028_665_376e1,
        2.209_460_984_245_205e2,
        -2.759_285_104_469_687e2,
        1.383_577_518_672_69e2,
        -3.066_479_806_614_716e1,
        2.506_628_277_459_239,
    ];
    const B: [f64; 5] = [
        -5.447_609_879_822_406e1,
        1.615_858_368_580_409e2,
        -1.556_989_798_598_866e2,
        6.680_131_188_771_972e1,
        -1.328_068_155_288_572e1,
    ];
    const C: [f64; 6] = [
        -7.784_894_002_430_293e-3,
        -3.223_964_580_411_365e-1,
        -2.400_758_277_161_838,
        -2.549_732_539_343_734,
        4.374_664_141_464_968,
        2.938_163_982_698_783,
    ];
    const D: [f64; 4] = [
        7.784_695_709_041_462e-3,
        3.224_671_290_700_398e-1,
        2.445_134_137_142_996,
        3.754_408_661_907_416,
    ];
    let ratio = |a: &[f64], b: &[f64], x: f64| {
        let up = a.iter().fold(0.0, |sum, c| sum * x + c);
        up / (b.iter().fold(0.0, |sum, c| sum * x + c) * x + 1.0)
    };
    let tail = |p: f64| ratio(&C, &D, (-2.0 * p.ln()).sqrt());
    match p {
        p if p <= 0.0 => f64::NEG_INFINITY,
        p if p >= 1.0 => f64::INFINITY,
        p if p < 0.02425 => tail(p),
        p if p > 1.0 - 0.02425 => -tail(1.0 - p),
        p => {
            let q = p - 0.5;
            q * ratio(&A, &B, q * q)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn read(text: &str) -> Grading {
        toml::from_str(text).expect("well formed")
    }

    fn sizes(text: &str, count: usize, dimension: usize) -> Vec<f64> {
        read(text).sizes(count, dimension, Path::new("."), 1, "test").expect("right")
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
        let list = sizes("gaussian = { mean = 1.0, deviation = 0.1, cut = 6 }", 2000, 3);
        let deviation = mean(&list.iter().map(|d| (d - 1.0).powi(2)).collect::<Vec<_>>()).sqrt();
        assert!((mean(&list) - 1.0).abs() < 1e-3 && (deviation - 0.1).abs() < 1e-3, "{deviation}");
        let list = sizes("lognormal = { median = 2.0, sigma = 0.4, cut = 6 }", 4000, 3);
        assert!((mean(&list) / (2.0 * (0.08_f64).exp()) - 1.0).abs() < 2e-3, "{}", mean(&list));
        let list = sizes("weibull = { scale = 1.0, shape = 2.0, cut = 1e-6 }", 4000, 3);
        assert!((mean(&list) - 0.886_226_925).abs() < 2e-3, "{}", mean(&list));
    }

    #[test]
    fn curves_by_mass_come_back_from_the_grains() {
        let curves = [
            "fuller = { smallest = 0.5, largest = 2.0 }",
            "rosin_rammler = { size = 1.0, exponent = 2.0, smallest = 0.4, largest = 2.0 }",
            "sieve = { points = [[0.5, 0], [0.7, 20], [1.0, 20], [1.4, 90], [2.0, 100]] }",
            "gaussian = { mean = 1.0, deviation = 0.2 }",
        ];
        let at: Vec<f64> = (0..16).map(|i| 0.5 * 4.0_f64.powf(f64::from(i) / 15.0)).collect();
        for text in curves {
            for dimension in [2, 3] {
                let list = sizes(text, 1000, dimension);
                let wanted = read(text).passing(&at, dimension, Path::new(".")).expect("right");
                let got = passing_of(&list, &at, dimension);
                // One grain of the coarsest class is up to 8 of 1000 mean masses.
                for (size, (w, g)) in at.iter().zip(wanted.iter().zip(&got)) {
                    assert!((w - g).abs() < 0.015, "{text} {dimension} {size}: {w} {g}");
                }
            }
        }
        let fuller = read(curves[0]).passing(&[1.0], 3, Path::new(".")).expect("right")[0];
        assert!((fuller - (1.0 - 0.5_f64.sqrt()) / (2.0_f64.sqrt() - 0.5_f64.sqrt())).abs() < 2e-3);
    }

    #[test]
    fn a_small_sample_follows_to_one_grain_a_class() {
        let text = "sieve = { points = [[1, 0], [2, 50], [4, 100]] }";
        for seed in 0..20 {
            let list = read(text).sizes(90, 3, Path::new("."), seed, "x").expect("right");
            // Equal masses: 8 times as many grains in the finer class.
            let coarse = list.iter().filter(|d| **d > 2.0).count();
            assert!((9..=11).contains(&coarse), "{coarse}");
        }
    }

    #[test]
    fn sieve_files_are_read_and_wrong_ones_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let sieve = |text: &str| {
            let mut file = std::fs::File::create(folder.path().join("s.csv")).expect("created");
            write!(file, "{text}").expect("written");
            read("sieve = { file = 's.csv' }").sizes(50, 3, folder.path(), 1, "x")
        };
        let list = sieve("size mm, passing %\n1, 0\n2, 40\n4, 100\n").expect("right");
        assert!(list.iter().all(|d| (1e-3..=4e-3).contains(d)));
        let wrong = [
            ("1, 0\n2, 50\n3, 40\n4, 100\n", "line 3 falls from 50 % to 40 %"),
            ("1, 0\n2, 150\n", "150 %"),
            ("0, 0\n2, 100\n", "size 0 m"),
            ("2, 0\n1, 100\n", "after"),
            ("1, 5\n2, 100\n", "finest"),
            ("1, 0\n2, 90\n", "coarsest"),
            ("1, 0\n2\n", "line 2 is not two numbers"),
            ("1, 0\n", "one of 1 points"),
        ];
        for (text, part) in wrong {
            let fault = sieve(text).expect_err("is wrong").to_string();
            assert!(fault.contains(part), "{text}: {fault}");
        }
        assert!(read("sieve = { file = 'none.csv' }").sizes(5, 3, folder.path(), 1, "x").is_err());
    }

    #[test]
    fn wrong_parameters_name_their_key() {
        let key = |text: &str| read(text).validate().expect_err("is wrong").key;
        assert_eq!(key("gaussian = { mean = 1, deviation = 0.5 }"), "gaussian.cut");
        assert_eq!(key("gaussian = { mean = 0, deviation = 0.5 }"), "gaussian.mean");
        assert_eq!(key("lognormal = { median = 1, sigma = -1 }"), "lognormal.sigma");
        assert_eq!(key("weibull = { scale = 1, shape = 0 }"), "weibull.shape");
        assert_eq!(key("fuller = { smallest = 2, largest = 1 }"), "fuller.largest");
        assert_eq!(key("sieve = {}"), "sieve.points");
        assert_eq!(key("sieve = { points = [[1, 0], [2, 101]] }"), "sieve.points[1]");
    }

    #[test]
    fn the_normal_quantile_is_right() {
        for (p, x) in [(0.5, 0.0), (0.975, 1.959_963_985), (0.001, -3.090_232_306)] {
            assert!((normal_quantile(p) - x).abs() < 1e-7);
        }
        assert!((below(-3.0) - 1.349_898e-3).abs() < 1e-8);
    }
}
