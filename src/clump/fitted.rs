//! Spheres fitted by least squares: riprap's own method, for the least error with a given
//! number of spheres or the fewest spheres for a given error.
//!
//! 1. Points: M evenly spread over the surface, and some inside, which only have to be
//!    covered. 2. A greedy cover by maximal inner balls ([`super::cover`]); where it runs out
//!    of useful balls before their number, it goes on after a refinement with balls that stick
//!    out less. 3. All centres and radii refined against the surface and spheres of
//!    little use taken elsewhere ([`super::refine`]). 4. All radii changed by one length so
//!    that the union has the volume of the solid (secant on the exact volume).
//!
//! The parts are known: maximal balls by shrinking (Ma, Bae & Choi 2012), greedy cover, Lloyd
//! alternation over spheres (Wang et al. 2006, ACM Trans. Graph. 25, 1147), reweighted
//! Gauss–Newton; their combination for clumps is riprap's.
//!
//! Spheres straddle the surface unless `protrusion` says how far they may stick out; 0 keeps
//! them inside. Error falls about as N⁻² on smooth solids and as N^−0.7 on solids with edges.
//! Cost O(N·M) at worst, mostly O(M) a sweep: figures in `validation/16-clump-peers`.

use super::ClumpError;
use super::cover;
use super::fidelity::distances;
use super::hollows::{farthest, filled};
use super::maximal::{FREE, Maximal, depth_to_cover, inner_points};
use super::patches::Patches;
use super::pieces;
use super::refine::{Fit, Refiner, SWEEPS, TRIAL_SWEEPS};
use super::target::{Found, Target};
use crate::geometry::{Ball, united};
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "fitted",
    id: "",
    summary: "greedy cover by inner balls, then all centres and radii by least squares",
    source: "riprap's own; after Ma et al. 2012, Wang et al. 2006",
    example: r#"clump.fitted = { spheres = 20 }"#,
};

/// Points of the coarse set a sphere, and the fewest and most of them: for the cover.
const COARSE: (f64, f64, f64) = (12.0, 800.0, 2400.0);
/// The same for the fine set: for the refinement.
const FINE: (f64, f64, f64) = (70.0, 2000.0, 20_000.0);
/// Candidate balls a sphere, and the fewest and most of them.
const CANDIDATES: (f64, f64, f64) = (45.0, 450.0, 900.0);
/// Weight of points inside a sphere where spheres may not stick out freely.
const INWARD: f64 = 8.0;
/// Distance of a surface point from all spheres from which on much is left bare.
const BARE: f64 = 0.2;
/// Surface points each way when the error is compared with its target.
const CHECKS: usize = 2000;
/// Root mean square distance over the diameter from which on fewer spheres are tried too, and how
/// many fewer: spheres that are far too few for a long or flat solid, but have to hang together, may do worse.
const POOR: f64 = 0.1;
const FEWER: usize = 6;

/// Spheres fitted by least squares. Lengths are shares of the solid's equivalent diameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Fitted {
    /// Most spheres; 1 to 5000, default 20. Fewer are used where more come no nearer to the solid (its mesh has
    /// facets) or, far too few for a long or flat one, come less near because they have to hang together.
    #[serde(default = "default_spheres")]
    pub spheres: usize,
    /// Root mean square distance of the surfaces that is good enough: the fewest spheres that
    /// reach it are used, at most `spheres`; 0.0001 to 0.5. Left out: all spheres are used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// How far a sphere may stick out of the solid; 0 (inscribed) to 0.5. Left out: up to 0.12, for the least error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub protrusion: Option<f64>,
    /// Whether the union gets the volume of the solid; default `matched`. Without effect where `protrusion` is given.
    #[serde(default)]
    pub volume: Volume,
    /// Least radius; 0.0005 to 0.5, default 0.02.
    #[serde(default = "default_smallest")]
    pub smallest: f64,
    /// p: the mean of |distance|^p is made least; 1 (least volume of the symmetric difference)
    /// to 8 (lower largest distance), default 2 (least root mean square distance).
    #[serde(default = "default_power")]
    pub power: f64,
    /// How often spheres of little use are taken elsewhere; 0 to 1000, default 3; more lower the error by a few per cent.
    #[serde(default = "default_trials")]
    pub trials: usize,
}

/// Whether the union gets the volume of the solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Volume {
    /// All radii are changed by one length so that it does.
    #[default]
    Matched,
    /// As the least squares leave it: within 1 % mostly.
    Free,
}

fn default_spheres() -> usize {
    20
}
fn default_smallest() -> f64 {
    0.02
}
fn default_power() -> f64 {
    2.0
}
fn default_trials() -> usize {
    3
}

impl Default for Fitted {
    fn default() -> Self {
        Self {
            spheres: default_spheres(),
            error: None,
            protrusion: None,
            volume: Volume::default(),
            smallest: default_smallest(),
            power: default_power(),
            trials: default_trials(),
        }
    }
}

impl Fitted {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("spheres", self.spheres as f64, 1.0, 5000.0)?;
        if let Some(error) = self.error {
            Fault::within("error", error, 1e-4, 0.5)?;
        }
        if let Some(protrusion) = self.protrusion {
            Fault::within("protrusion", protrusion, 0.0, 0.5)?;
        }
        Fault::within("smallest", self.smallest, 5e-4, 0.5)?;
        Fault::within("power", self.power, 1.0, 8.0)?;
        Fault::within("trials", self.trials as f64, 0.0, 1000.0)
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let (Made { balls, matched }, rms) = match self.error {
            None => (self.fit_or_fewer(target, job)?, None),
            Some(error) => self.fewest(target, error, job)?,
        };
        Ok(Found { note: self.note(balls.len(), rms, matched), balls })
    }

    /// The spheres asked for, or fewer where those are nearer.
    fn fit_or_fewer(&self, target: &Target, job: &Job) -> Result<Made, ClumpError> {
        let rms = |made: &Made| distances(target, &made.balls, CHECKS).rms() / target.diameter;
        let mut best = self.fit(target, self.spheres, job)?;
        // Only few spheres can be that far off a solid that has room for one.
        if self.spheres > 100 || rms(&best) < POOR {
            return Ok(best);
        }
        for fewer in (1..self.spheres).rev().take(FEWER) {
            let trial = self.fit(target, fewer, job)?;
            if rms(&trial) < rms(&best) {
                best = trial;
            }
        }
        Ok(best)
    }

    /// The fewest spheres that reach `error`, and the error that they reach: counts rise by a
    /// half until one is good enough, then the last gap is halved until it is a tenth.
    fn fewest(
        &self,
        target: &Target,
        error: f64,
        job: &Job,
    ) -> Result<(Made, Option<f64>), ClumpError> {
        let rms = |balls: &[Ball]| distances(target, balls, CHECKS).rms() / target.diameter;
        let mut low = 0;
        let mut high = 4.min(self.spheres);
        let mut best = self.fit(target, high, job)?;
        let mut reached = rms(&best.balls);
        while reached > error && high < self.spheres {
            low = high;
            high = (high + high.div_ceil(2)).min(self.spheres);
            best = self.fit(target, high, job)?;
            reached = rms(&best.balls);
        }
        while reached <= error && high - low > (high / 10).max(1) {
            let middle = (low + high) / 2;
            let trial = self.fit(target, middle, job)?;
            let error_of_trial = rms(&trial.balls);
            if error_of_trial <= error {
                (high, best, reached) = (middle, trial, error_of_trial);
            } else {
                low = middle;
            }
        }
        Ok((best, Some(reached)))
    }

    /// At most `count` spheres.
    fn fit(&self, target: &Target, count: usize, job: &Job) -> Result<Made, ClumpError> {
        let mesh = &target.solid.mesh;
        let diameter = target.diameter;
        let points = |(each, fewest, most): (f64, f64, f64)| {
            (each * count as f64).clamp(fewest, most) as usize
        };
        let mut coarse = Patches::new(mesh, points(COARSE));
        let maximal = Maximal {
            target,
            protrusion: self.protrusion,
            smallest: self.smallest * diameter,
            stride: coarse.points.len().div_ceil(points(CANDIDATES)),
        };
        let at_most = self.protrusion.unwrap_or(f64::INFINITY);
        let allowed = (0.4 / count as f64).clamp(0.002, 0.03).min(at_most) * diameter;
        let candidates = maximal.balls(&coarse, allowed);
        let deep = depth_to_cover(&candidates, count);
        let inner = inner_points(&candidates, diameter, deep);
        coarse.add_inner(inner.clone(), 0.0);
        let mut fine = Patches::new(mesh, points(FINE));
        fine.add_inner(inner, 0.0);
        let limit = |centre: &Vec3| maximal.limit(centre);
        let refiner = Refiner {
            patches: &fine,
            scouts: &coarse,
            power: self.power,
            inner_weight: if self.protrusion.is_none() { 1.0 } else { INWARD },
            smallest: maximal.smallest,
            limit: &limit,
        };
        let balls = cover::greedy(&coarse, &candidates, Vec::new(), count);
        if balls.is_empty() {
            return Err(self.no_sphere(target));
        }
        let (balls, candidates) =
            self.covering(&maximal, &refiner, (balls, candidates), count, allowed, job)?;
        job.report("spheres", balls.len() as u64, count as u64);
        self.stop_if_asked(job)?;
        let fit = refiner.sweeps(refiner.assign(balls), SWEEPS);
        let fit = self.relocated(&refiner, fit, &candidates, job)?;
        Ok(self.finished(&refiner, fit, target, deep))
    }

    fn no_sphere(&self, target: &Target) -> ClumpError {
        ClumpError::NoSphere {
            name: target.solid.name.clone(),
            advice: match self.protrusion {
                None => {
                    "it is thinner than its smallest sphere: lower `smallest` of `clump.fitted` in a scene"
                }
                Some(_) => "lower `smallest`, or raise `protrusion` or leave it out",
            },
        }
    }

    /// `count` balls that cover the surface, or nearly as many, and the candidates that they are from; the first
    /// ones, balls and candidates, stick out by `allowed` [m].
    fn covering(
        &self,
        maximal: &Maximal,
        refiner: &Refiner,
        (mut balls, mut candidates): (Vec<Ball>, Vec<Ball>),
        count: usize,
        mut allowed: f64,
        job: &Job,
    ) -> Result<(Vec<Ball>, Vec<Ball>), ClumpError> {
        let (coarse, diameter) = (refiner.scouts, maximal.target.diameter);
        // Inner balls of a plate or blade are small, and so far apart that they may not even hang
        // together: where much is left bare, larger ones.
        let mut wider = allowed;
        while self.protrusion.is_none()
            && wider < FREE * diameter
            && largest_gap(coarse, &balls) > BARE * diameter
        {
            self.stop_if_asked(job)?;
            wider = (2.0 * wider).min(FREE * diameter);
            let others = maximal.balls(coarse, wider);
            let trial = cover::greedy(coarse, &others, Vec::new(), count);
            if !trial.is_empty()
                && refiner.assign(trial.clone()).cost < refiner.assign(balls.clone()).cost
            {
                (balls, candidates) = (trial, others);
            }
        }
        // Maximal balls of a smooth solid cover all points once they stick out enough.
        while balls.len() < count && allowed > 1e-6 * diameter {
            self.stop_if_asked(job)?;
            allowed *= 0.2;
            let settled = refiner.sweeps(refiner.assign(balls), TRIAL_SWEEPS).balls;
            candidates = maximal.balls(coarse, allowed);
            balls = cover::greedy(coarse, &candidates, settled, count);
        }
        Ok((balls, candidates))
    }

    /// `fit` with its hollows filled, or as it is where that is nearer once the volume is matched, which moves
    /// all radii.
    fn finished(&self, refiner: &Refiner, fit: Fit, target: &Target, deep: f64) -> Made {
        let matched = |mut balls: Vec<Ball>| {
            let free = self.protrusion.is_none() && self.volume == Volume::Matched;
            let matched = free.then(|| match_volume(&mut balls, target, refiner.smallest));
            Made { balls, matched }
        };
        let plain = fit.balls.clone();
        let filled = filled(refiner, fit, target, deep).balls;
        if filled == plain {
            return matched(plain);
        }
        let (filled, plain) = (matched(filled), matched(plain));
        let farthest = |made: &Made| farthest(&refiner.assign(made.balls.clone()), refiner, target);
        if farthest(&filled) < farthest(&plain) { filled } else { plain }
    }

    fn relocated(
        &self,
        refiner: &Refiner,
        fit: Fit,
        candidates: &[Ball],
        job: &Job,
    ) -> Result<Fit, ClumpError> {
        if self.trials == 0 {
            return Ok(fit);
        }
        let before = fit.cost;
        let fit = refiner.relocate(fit, candidates, self.trials, TRIAL_SWEEPS);
        self.stop_if_asked(job)?;
        Ok(if fit.cost < before { refiner.sweeps(fit, SWEEPS) } else { fit })
    }

    fn stop_if_asked(&self, job: &Job) -> Result<(), ClumpError> {
        if job.is_cancelled() { Err(ClumpError::Cancelled) } else { Ok(()) }
    }

    fn note(&self, count: usize, rms: Option<f64>, matched: Option<bool>) -> String {
        let place = match self.protrusion {
            None => "straddling".to_owned(),
            Some(0.0) => "inscribed".to_owned(),
            Some(protrusion) => format!("protrusion {protrusion}"),
        };
        let target = match (self.error, rms) {
            (Some(error), Some(rms)) if rms > error => {
                format!(", error {rms:.5} where {error} was asked for")
            }
            (Some(error), _) => format!(", the fewest found for error {error}"),
            _ => String::new(),
        };
        let volume = match matched {
            Some(true) => ", volume matched",
            Some(false) => ", volume matched as nearly as spheres that hang together allow",
            None => "",
        };
        let fewer = match self.error {
            None if count < self.spheres => " (more come no nearer)",
            _ => "",
        };
        format!(
            "fitted (least squares): {count} of at most {} spheres{fewer}, {place}{volume}, power {}{target}",
            self.spheres, self.power
        )
    }
}

/// Distance of the surface point that is farthest outside all spheres, m.
fn largest_gap(patches: &Patches, balls: &[Ball]) -> f64 {
    let gap = |point: &Vec3| {
        balls.iter().map(|b| (point - b.centre).norm() - b.radius).fold(f64::INFINITY, f64::min)
    };
    patches.points[..patches.normals.len()].iter().map(gap).fold(0.0, f64::max)
}

/// Spheres of a clump, and whether the union has the volume of the solid, where that was wanted.
struct Made {
    balls: Vec<Ball>,
    matched: Option<bool>,
}

/// Changes all radii by one length so that the union has the volume of the solid: with a
/// coarse quadrature, whose errors are nearly the same at both ends, to find the slope, then
/// with a fine one until 1e-5 is reached. Where few spheres on a thin plate come apart when they
/// shrink, the nearest two stay large enough to touch. False where 1e-3 is not reached so.
fn match_volume(balls: &mut [Ball], target: &Target, smallest: f64) -> bool {
    let wanted = target.solid.mass.volume;
    let grown = |balls: &[Ball], by: f64| -> Vec<Ball> {
        let radius = |b: &Ball| (b.radius + by).max(smallest);
        let mut balls: Vec<Ball> =
            balls.iter().map(|b| Ball { centre: b.centre, radius: radius(b) }).collect();
        pieces::glue(&mut balls);
        balls
    };
    let excess = |by: f64, panels: usize| {
        united::balls(&grown(balls, by), panels).mass.volume / wanted - 1.0
    };
    // A fit is never so far off that more is needed.
    let most = 0.1 * target.diameter;
    let start = excess(0.0, united::PANELS / 16);
    let first = (-start * wanted / target.solid.mesh.area()).clamp(-most, most);
    let mut slope = (excess(first, united::PANELS / 16) - start) / first;
    if !(slope.is_finite() && slope > 0.0) {
        slope = target.solid.mesh.area() / wanted;
    }
    let mut x = (-start / slope).clamp(-most, most);
    let mut best = (f64::INFINITY, 0.0);
    for _ in 0..5 {
        let left = excess(x, united::PANELS / 4);
        if left.abs() < best.0 {
            best = (left.abs(), x);
        }
        if left.abs() < 1e-5 {
            break;
        }
        x = (x - left / slope).clamp(-most, most);
    }
    let moved = grown(balls, best.1);
    balls.copy_from_slice(&moved);
    best.0 <= 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump::pieces::touching;
    use crate::clump::refine::one_piece;
    use crate::clump::reproduce::tests::solid;
    use crate::clump::{Clump, MassSource, Method, Normals, reproduce};
    use crate::geometry::Mesh;
    use crate::geometry::samples::{box_mesh, ellipsoid_mesh, icosphere, l_mesh, random_star};
    use crate::shape::Solid;
    use std::f64::consts::TAU;

    /// A torus of radius `large` with a tube of radius `small`.
    fn ring_mesh(large: f64, small: f64) -> Mesh {
        let (n, m) = (48u32, 16u32);
        let at = |i: u32, j: u32| {
            let [a, b] = [(i, n), (j, m)].map(|(k, of)| TAU * f64::from(k) / f64::from(of));
            let r = large + small * b.cos();
            Vec3::new(r * a.cos(), r * a.sin(), small * b.sin())
        };
        let vertices = (0..n * m).map(|k| at(k / m, k % m)).collect();
        let corner = |i: u32, j: u32| (i % n) * m + j % m;
        let triangles = (0..n * m)
            .flat_map(|k| {
                let (i, j) = (k / m, k % m);
                let [p, q, r, s] =
                    [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                [[p, q, r], [p, r, s]]
            })
            .collect();
        Mesh { vertices, triangles }
    }

    fn make(solid: &Solid, method: Fitted) -> Clump {
        let job = Job::quiet();
        reproduce(solid, &Method::Fitted(method), MassSource::Solid, 1, 2, &job).expect("a clump")
    }

    fn rms(clump: &Clump) -> f64 {
        let f = clump.fidelity.expect("measured");
        f.rms_distance / f.equivalent_diameter
    }

    fn quick(spheres: usize) -> Fitted {
        Fitted { spheres, trials: 3, ..Fitted::default() }
    }

    #[test]
    fn half_the_error_of_growth_along_normals_and_the_volume_kept() {
        for (name, mesh) in [
            ("box", box_mesh(Vec3::new(1.0, 1.4, 2.0))),
            ("l", l_mesh()),
            ("star", random_star(7, 0.5)),
        ] {
            let solid = solid(name, mesh.mapped(|v| v * 1e-3 + Vec3::repeat(2e-3)));
            let clump = make(&solid, quick(24));
            let normals = Method::Normals(Normals { spheres: 24, ..Normals::default() });
            let other = reproduce(&solid, &normals, MassSource::Solid, 1, 2, &Job::quiet())
                .expect("a clump");
            assert!(rms(&clump) < 0.75 * rms(&other), "{name} {} {}", rms(&clump), rms(&other));
            let f = clump.fidelity.expect("measured");
            assert!(f.volume_error.abs() < 1e-3, "{name} {}", f.volume_error);
            assert!(one_piece(&clump.balls));
        }
    }

    #[test]
    fn a_smooth_solid_gets_all_its_spheres() {
        let egg = solid("egg", ellipsoid_mesh(Vec3::new(2.0, 1.0, 1.0)));
        let few = make(&egg, quick(6));
        let many = make(&egg, quick(30));
        assert_eq!((few.balls.len(), many.balls.len()), (6, 30));
        assert!(rms(&many) < 0.3 * rms(&few));
        assert!(rms(&make(&solid("ball", icosphere(3)), quick(1))) < 0.005);
    }

    #[test]
    fn inscribed_spheres_stay_inside_and_others_within_what_is_allowed() {
        for mesh in [l_mesh(), random_star(8, 0.5)] {
            let solid = solid("x", mesh);
            let target = Target::new(&solid).expect("closed");
            for protrusion in [0.0, 0.01] {
                let method = Fitted { protrusion: Some(protrusion), ..quick(20) };
                let clump = make(&solid, method);
                for ball in clump.in_solid_frame() {
                    let out = ball.radius + target.distance.at(&ball.centre);
                    assert!(out <= (protrusion + 1e-9) * target.diameter, "{out:e}");
                }
            }
        }
    }

    #[test]
    fn plates_do_not_tempt_spheres_to_grow_without_bound() {
        for (edges, spheres, largest) in [
            ([12.0, 10.0, 2.0], 16, 0.2),
            ([12.0, 10.0, 1.0], 50, 0.15),
            ([20.0, 1.0, 1.0], 16, 0.2),
        ] {
            let plate = solid("plate", box_mesh(Vec3::from(edges)));
            let clump = make(&plate, quick(spheres));
            let f = clump.fidelity.expect("measured");
            assert!(f.volume_error.abs() < 1e-3, "{edges:?} {f:?}");
            assert!(f.largest_distance < largest * f.equivalent_diameter, "{edges:?} {f:?}");
            assert!(clump.balls.iter().all(|b| b.radius < 0.5 * f.equivalent_diameter));
        }
    }

    #[test]
    fn a_plate_thinner_than_what_may_stick_out_is_no_room_for_large_balls() {
        // Thickness 0.08 diameters, less than the 0.12 by which free spheres may stick out.
        let plate = solid("plate", box_mesh(Vec3::new(10.0, 10.0, 0.25)));
        let clump = make(&plate, quick(60));
        let f = clump.fidelity.expect("measured");
        let target = Target::new(&plate).expect("closed");
        for ball in clump.in_solid_frame() {
            // What is free, and what the matching of the volume may add.
            let out = ball.radius + target.distance.at(&ball.centre);
            assert!(out < 0.22 * f.equivalent_diameter, "{out}");
        }
        let foil = solid("foil", box_mesh(Vec3::new(1.0, 1.0, 1e-6)));
        let method = Method::Fitted(quick(10));
        let refused = reproduce(&foil, &method, MassSource::Solid, 1, 2, &Job::quiet());
        assert!(matches!(refused, Err(ClumpError::NoSphere { .. })), "{refused:?}");
    }

    #[test]
    fn thin_plates_get_all_their_spheres() {
        let plate = solid("plate", box_mesh(Vec3::new(10.0, 10.0, 0.25)));
        let clump = make(&plate, Fitted { trials: 0, ..quick(60) });
        let f = clump.fidelity.expect("measured");
        assert_eq!(clump.balls.len(), 60);
        assert!(f.rms_distance < 0.25 * f.equivalent_diameter, "{f:?}");
        assert!(f.volume_error.abs() < 1e-3, "{f:?}");
    }

    #[test]
    fn too_few_spheres_for_a_blade_are_no_worse_than_fewer() {
        let blade = solid("blade", box_mesh(Vec3::new(12.0, 4.0, 0.6)));
        let mut last = f64::INFINITY;
        for spheres in 1..=4 {
            let clump = make(&blade, quick(spheres));
            assert!(rms(&clump) < 1.01 * last, "{spheres}: {} {last}", rms(&clump));
            assert!(one_piece(&clump.balls) || touching(&clump.balls));
            assert_eq!(clump.balls.len() < spheres, clump.method.contains("more come no nearer"));
            last = rms(&clump);
        }
    }

    #[test]
    fn hollows_are_filled_only_where_that_is_nearer() {
        let ring = solid("ring", ring_mesh(1.0, 0.35));
        let target = Target::new(&ring).expect("closed");
        let method = quick(10);
        let clump = make(&ring, method.clone());
        let f = clump.fidelity.expect("measured");
        assert!(f.largest_distance < 0.14 * f.equivalent_diameter, "{f:?}");
        // A fit without hollows is left alone.
        let patches = Patches::new(&ring.mesh, 1500);
        let limit = &|centre: &Vec3| 0.1 - target.distance.at(centre);
        let refiner = Refiner {
            patches: &patches,
            scouts: &patches,
            power: 2.0,
            inner_weight: 1.0,
            smallest: 0.01,
            limit,
        };
        let fit = refiner.assign(clump.in_solid_frame());
        let (before, plain) = (farthest(&fit, &refiner, &target), fit.balls.clone());
        let free = Fitted { volume: Volume::Free, ..method };
        let made = free.finished(&refiner, fit, &target, 0.05);
        let after = farthest(&refiner.assign(made.balls.clone()), &refiner, &target);
        assert!(made.balls == plain || after < before, "{after} {before}");
    }

    #[test]
    fn a_smaller_error_takes_more_spheres_and_what_is_not_reached_is_said() {
        let solid = solid("l", l_mesh());
        let with = |error, spheres| {
            make(&solid, Fitted { error: Some(error), trials: 0, spheres, ..Fitted::default() })
        };
        let (rough, fine) = (with(0.06, 100), with(0.03, 100));
        assert!(rough.balls.len() < fine.balls.len());
        // Measured again with more points.
        assert!(rms(&rough) < 0.063 && rms(&fine) < 0.0315, "{} {}", rms(&rough), rms(&fine));
        let short = with(1e-4, 5);
        assert_eq!(short.balls.len(), 5);
        assert!(short.method.contains("was asked for"), "{}", short.method);
    }

    #[test]
    fn a_high_power_lowers_the_largest_distance() {
        let cube = solid("cube", box_mesh(Vec3::repeat(1.0)));
        let largest = |power| {
            let clump = make(&cube, Fitted { power, volume: Volume::Free, ..quick(12) });
            clump.fidelity.expect("measured").largest_distance
        };
        let (one, two, six) = (largest(1.0), largest(2.0), largest(6.0));
        assert!(six < two && six < one, "{one} {two} {six}");
    }

    #[test]
    fn wrong_values_are_named() {
        let key = |method: Fitted| method.validate().expect_err("wrong").key;
        assert_eq!(key(Fitted { power: 0.5, ..Fitted::default() }), "power");
        assert_eq!(key(Fitted { error: Some(0.0), ..Fitted::default() }), "error");
        assert_eq!(key(Fitted { protrusion: Some(f64::NAN), ..Fitted::default() }), "protrusion");
        assert_eq!(key(Fitted { spheres: 0, ..Fitted::default() }), "spheres");
    }
}
