//! Sieve curves of a packing: what each graded family should be and what was placed.
//!
//! By mass at one density: the share of the volume (area in two dimensions) of the grains of a family that is finer
//! than a size. Sizes are equivalent-volume diameters, methods that change sizes included.

use super::Loaded;
use super::parameters::Size;
use crate::pack::grading::passing_of;
use crate::pack::{self, Packing};
use crate::report::chart::{Axis, Chart, Series};
use std::f64::consts::PI;
use std::io::{self, Write};

/// Points of each curve.
const POINTS: usize = 48;

/// Shares of the mass that the families of a mixture have among the grains placed, beside those
/// wanted; `None` without a mixture.
pub fn shares(loaded: &Loaded, packing: &Packing, list: &[pack::Grain]) -> Option<String> {
    let scene = &loaded.scene;
    scene.mixture?;
    let mut masses = vec![0.0; scene.grains.len()];
    for laid in &packing.placements {
        let grain = &list[laid.grain as usize];
        let family = usize::from(grain.family);
        let density = scene.density(&scene.grains[family]).unwrap_or(0.0);
        masses[family] +=
            density * grain.clump.volume * laid.scale.powi(i32::from(scene.dimension));
    }
    let mixed = || scene.grains.iter().zip(&masses).filter_map(|(f, m)| Some((f, f.fraction?, *m)));
    let (wanted, placed) =
        mixed().fold((0.0, 0.0), |sum, (_, share, mass)| (sum.0 + share, sum.1 + mass));
    let said: Vec<String> = mixed()
        .map(|(family, share, mass)| {
            format!("{} {:.4} of {:.4}", family.name, mass / placed, share / wanted)
        })
        .collect();
    (placed > 0.0).then(|| format!("shares of the mass: {}", said.join(", ")))
}

/// Curves of the graded families of a scene.
pub struct Curves {
    families: Vec<Curve>,
}

struct Curve {
    name: String,
    sizes: Vec<f64>,
    wanted: Vec<f64>,
    placed: Vec<f64>,
}

impl Curves {
    /// The curves; `None` without graded families.
    pub fn of(loaded: &Loaded, packing: &Packing, list: &[pack::Grain]) -> Option<Self> {
        let scene = &loaded.scene;
        let dimension = scene.dimension as usize;
        let mut families = Vec::new();
        for (number, family) in scene.grains.iter().enumerate() {
            let Some(Size::Graded(grading)) = &family.size else { continue };
            let diameter = |laid: &pack::Placement| {
                let volume = list[laid.grain as usize].clump.volume;
                laid.scale
                    * match dimension {
                        2 => (4.0 * volume / PI).sqrt(),
                        _ => (6.0 * volume / PI).cbrt(),
                    }
            };
            let mine =
                |laid: &&pack::Placement| usize::from(list[laid.grain as usize].family) == number;
            let placed: Vec<f64> = packing.placements.iter().filter(mine).map(diameter).collect();
            let sample = grading.sizes(2000, dimension, loaded.base(), 0, "curve").ok()?;
            let all = || placed.iter().chain(&sample).copied();
            let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
            let sizes: Vec<f64> = (0..POINTS)
                .map(|i| low * (high / low).powf(i as f64 / (POINTS - 1) as f64))
                .collect();
            families.push(Curve {
                name: family.name.clone(),
                wanted: grading.passing(&sizes, dimension, loaded.base()).ok()?,
                placed: passing_of(&placed, &sizes, dimension),
                sizes,
            });
        }
        (!families.is_empty()).then_some(Self { families })
    }

    /// One row a size and family.
    pub fn csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "family,size,wanted,placed")?;
        for family in &self.families {
            for (index, size) in family.sizes.iter().enumerate() {
                let (wanted, placed) = (family.wanted[index], family.placed[index]);
                writeln!(out, "{},{size:e},{wanted:e},{placed:e}", family.name)?;
            }
        }
        Ok(())
    }

    /// Wanted and placed curves of all families.
    pub fn chart(&self) -> Chart {
        let series = |name: String, sizes: &[f64], shares: &[f64], dots| Series {
            name,
            points: sizes.iter().map(|d| 1e3 * d).zip(shares.iter().map(|s| 100.0 * s)).collect(),
            dots,
        };
        Chart {
            title: "Sieve curves".into(),
            caption: "Share of the mass that is finer: wanted, and of the grains that were placed."
                .into(),
            x: Axis::log("size [mm]", ""),
            y: Axis::linear("finer [% of the mass]", ""),
            series: self
                .families
                .iter()
                .flat_map(|f| {
                    [
                        series(format!("{} wanted", f.name), &f.sizes, &f.wanted, false),
                        series(format!("{} placed", f.name), &f.sizes, &f.placed, true),
                    ]
                })
                .collect(),
            mark: None,
        }
    }

    /// The largest distance between the two curves of each family, one line.
    pub fn summary(&self) -> String {
        let far = |family: &Curve| {
            let apart = family.wanted.iter().zip(&family.placed).map(|(w, p)| (w - p).abs());
            format!("{} {:.2} %", family.name, 100.0 * apart.fold(0.0, f64::max))
        };
        let all: Vec<String> = self.families.iter().map(far).collect();
        format!("sieve curves, largest distance from the wanted one: {}", all.join(", "))
    }
}
