//! Random placement (P3): grains of the wanted sizes go one by one to random
//! places with random rotations and stay where they overlap nothing.
//!
//! Source: random sequential addition (Widom 1966, J. Chem. Phys. 44, 3888;
//! Feder 1980, J. Theor. Biol. 87, 237), here with sizes given beforehand and
//! the largest first, which packs denser. Equal spheres jam near a solid fraction of 0.384,
//! equal discs near 0.547, and the time to get there has no bound, so each
//! grain has a number of tries and is dropped after them; sizes change only where
//! `rearrange` asks for it (P4, see `rearrange.rs`).
//!
//! Cost: O(tries · spheres of the grain) a grain for clumps; for solids each
//! try meets the few neighbours whose bounding spheres overlap, surface against
//! surface. Memory O(spheres).

use super::occupied::{Occupied, placement};
use super::rearrange::{Gain, How, Rearrange, STAGES};
use super::zones::{self, Zone};
use super::{Grain, Laid, Turn, common_velocity, finite_velocity, tally_scaled};
use crate::geometry::{Bounds, Region};
use crate::num::random::{Stream, direction, stream, uniform};
use crate::num::units::{Length, Speed};
use crate::num::{Fault, Job, Rotation, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of random placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Random {
    /// Places tried for a grain before it is dropped, 1 to 10 000 000; default 1000.
    pub tries: u32,
    /// What must not overlap; default `clump`.
    pub test: Test,
    /// Least distance between bodies and between bodies and the boundary, m, 0 or more; default 0.
    pub gap: Length,
    /// Which grains go first; default `largest_first`.
    pub order: Order,
    /// How grains are turned; default `random`.
    pub orientation: Turn,
    /// Velocity of all bodies at the start, m/s; default 0.
    pub velocity: [Speed; 3],
    /// Boxes that the grains of a family are kept to; default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<Zone>,
    /// Turning, moving and shrinking where a grain does not fit; default none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rearrange: Option<Rearrange>,
}

impl Default for Random {
    fn default() -> Self {
        Self {
            tries: 1000,
            test: Test::Clump,
            gap: Length(0.0),
            order: Order::LargestFirst,
            orientation: Turn::Random,
            velocity: [Speed(0.0); 3],
            zones: Vec::new(),
            rearrange: None,
        }
    }
}

/// What is tested for overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Test {
    /// The spheres of clumps: a run starts without overlap.
    Clump,
    /// The true shapes; spheres that stick out of their solid may then overlap (the measures say by how much).
    Solid,
}

/// Which grains are placed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// By falling volume: packs denser.
    LargestFirst,
    /// In the order of the list of grains.
    AsGiven,
}

impl Random {
    /// A fault for parameters that cannot be used.
    pub fn validate(&self) -> Result<(), Fault> {
        Fault::within("tries", f64::from(self.tries), 1.0, 1e7)?;
        Fault::not_negative("gap", self.gap.0)?;
        for (index, zone) in self.zones.iter().enumerate() {
            zone.validate().map_err(|fault| fault.under(format!("zones[{index}]")))?;
        }
        if let Some(rearrange) = &self.rearrange {
            rearrange.validate().map_err(|fault| fault.under("rearrange"))?;
        }
        finite_velocity(&self.velocity)
    }

    pub(super) fn lay(
        &self,
        grains: &[Grain],
        families: &[&str],
        region: &Region,
        seed: u64,
        job: &Job,
    ) -> Result<Laid, Fault> {
        let dimension = region.dimension();
        let velocity = common_velocity(&self.velocity, dimension).map_err(|f| f.under("random"))?;
        let mut occupied = match self.test {
            Test::Clump => Occupied::of_clumps(grains, region, self.gap.0),
            Test::Solid => Occupied::of_solids(grains, region, self.gap.0),
        };
        let zones = zones::of_grains(&self.zones, grains, families, dimension)
            .map_err(|fault| fault.under("random"))?;
        let order = self.sequence(grains);
        let mut gain = Gain::default();
        let (mut placements, mut dropped) = (Vec::with_capacity(grains.len()), Vec::new());
        for (done, &grain) in order.iter().enumerate() {
            if job.is_cancelled() {
                dropped.extend(order[done..].iter().map(|&grain| grain as u32));
                break;
            }
            let mut search = Search {
                parameters: self,
                grain,
                what: &grains[grain],
                zone: zones[grain],
                region,
                source: stream(seed, "pack.random", grain as u64),
                gain: &mut gain,
            };
            match search.place(&mut occupied) {
                Some((at, how, scale)) => {
                    occupied.add(grain, at);
                    let mut laid = placement(grain, at, velocity);
                    laid.scale = scale;
                    let volume = grains[grain].clump.volume * scale.powi(dimension as i32);
                    gain.add(how, volume, scale);
                    placements.push(laid);
                }
                None => dropped.push(grain as u32),
            }
            if done % 64 == 0 {
                job.report("grains placed", done as u64, grains.len() as u64);
            }
        }
        job.report("grains placed", grains.len() as u64, grains.len() as u64);
        let why = match job.is_cancelled() {
            true => "stopped before all were tried".to_owned(),
            false => format!("no free place in {} tries each", self.tries),
        };
        let mut outcome = tally_scaled(grains, &placements, &dropped, &why, dimension);
        if self.rearrange.is_some() {
            outcome.push_str(&format!("; {}", gain.text()));
        }
        Ok(Laid { placements, dropped, outcome })
    }

    fn sequence(&self, grains: &[Grain]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..grains.len()).collect();
        if self.order == Order::LargestFirst {
            let volume = |grain: usize| grains[grain].clump.volume;
            order.sort_by(|&a, &b| volume(b).total_cmp(&volume(a)).then(a.cmp(&b)));
        }
        order
    }
}

/// The search for a place of one grain.
struct Search<'a> {
    parameters: &'a Random,
    grain: usize,
    what: &'a Grain<'a>,
    zone: Option<(Bounds, bool)>,
    region: &'a Region,
    source: Stream,
    gain: &'a mut Gain,
}

impl Search<'_> {
    /// A free place, how it was found, and the size over the wanted one; `None` after all tries.
    fn place(&mut self, occupied: &mut Occupied) -> Option<((Vec3, Rotation), How, f64)> {
        if let Some((at, how)) = self.find(self.parameters.tries, occupied) {
            return Some((at, how, 1.0));
        }
        let sizes = self.parameters.rearrange.map(|r| r.sizes()).unwrap_or_default();
        for scale in sizes {
            occupied.resize(self.grain, scale);
            if let Some((at, _)) = self.find(self.parameters.tries.div_ceil(STAGES), occupied) {
                return Some((at, How::Shrunk, scale));
            }
        }
        None
    }

    /// A try draws a rotation, then a centre where the turned grain's bounds lie inside those
    /// of the region, then rearranges.
    fn find(&mut self, tries: u32, occupied: &Occupied) -> Option<((Vec3, Rotation), How)> {
        for _ in 0..tries {
            let turn = self.draw();
            let Some(bounds) = self.allowed(&turn, occupied) else { continue };
            let centre = self.region.sample_within(&bounds, &mut self.source)?;
            if self.fits(&(centre, turn), occupied) {
                return Some(((centre, turn), How::Drawn));
            }
            if let Some(found) = self.rearranged(centre, turn, occupied) {
                return Some(found);
            }
        }
        None
    }

    fn rearranged(
        &mut self,
        centre: Vec3,
        turn: Rotation,
        occupied: &Occupied,
    ) -> Option<((Vec3, Rotation), How)> {
        let rearrange = self.parameters.rearrange?;
        let allowed = |search: &Self, at: &(Vec3, Rotation)| {
            search.allowed(&at.1, occupied).is_some_and(|bounds| bounds.contains(&at.0))
        };
        for _ in 0..rearrange.turns {
            let at = (centre, self.draw());
            if allowed(self, &at) && self.fits(&at, occupied) {
                return Some((at, How::Turned));
            }
        }
        let reach = rearrange.within * occupied.radius(self.grain);
        for _ in 0..rearrange.moves {
            // Near places are tried more often than far ones.
            let far = reach * uniform(&mut self.source, 0.0, 1.0);
            let shift = match self.region.dimension() {
                2 => {
                    let angle = uniform(&mut self.source, 0.0, std::f64::consts::TAU);
                    Vec3::new(angle.cos(), angle.sin(), 0.0)
                }
                _ => direction(&mut self.source),
            };
            let mut place = centre + shift * far;
            if let Some(cell) = self.region.cell() {
                place += cell.home(&place);
            }
            let at = (place, turn);
            if allowed(self, &at) && self.fits(&at, occupied) {
                return Some((at, How::Moved));
            }
        }
        None
    }

    fn draw(&mut self) -> Rotation {
        self.parameters.orientation.draw(self.what, self.region.dimension(), &mut self.source)
    }

    fn fits(&mut self, at: &(Vec3, Rotation), occupied: &Occupied) -> bool {
        self.gain.tests += 1;
        occupied.fits(self.grain, at)
    }

    /// Where the centre may be so that the turned grain's bounds lie inside those of region and zone.
    fn allowed(&self, turn: &Rotation, occupied: &Occupied) -> Option<Bounds> {
        let room = self.region.bounds().grown(-self.parameters.gap.0);
        let extent = occupied.extent(self.grain, turn);
        let mut bounds = Bounds { low: room.low - extent.low, high: room.high - extent.high };
        if let Some(cell) = self.region.cell() {
            for axis in (0..self.region.dimension()).filter(|axis| cell.periodic[*axis]) {
                bounds.low[axis] = cell.bounds.low[axis];
                bounds.high[axis] = cell.bounds.high[axis];
            }
        }
        if let Some((zone, walls)) = self.zone {
            let own = if walls { extent } else { Bounds::of([&Vec3::zeros()]) };
            bounds.low = bounds.low.sup(&(zone.low - own.low));
            bounds.high = bounds.high.inf(&(zone.high - own.high));
        }
        let axes = self.region.dimension();
        if axes == 2 {
            (bounds.low.z, bounds.high.z) = (-1.0, 1.0);
        }
        (0..axes).all(|axis| bounds.low[axis] <= bounds.high[axis]).then_some(bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{
        brute_force, clump, dumbbell, of, periodic_room, room, solid, sphere,
    };
    use super::super::{Grain, Method, Packing, pack};
    use super::*;
    use crate::geometry::region::{CylinderRegion, MeshRegion};
    use crate::geometry::samples::{icosphere, l_mesh};
    use crate::geometry::{Ball, Collider};
    use crate::num::random::whole;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn lay(grains: &[Grain], region: &Region, parameters: Random, seed: u64) -> Packing {
        pack(grains, &[], region, &Method::Random(parameters), seed, &Job::quiet())
            .expect("right parameters")
    }

    fn cylinder() -> Region {
        Region::Cylinder(CylinderRegion {
            base: Vec3::new(0.5, 0.5, 0.0),
            axis: 2,
            radius: 0.5,
            height: 1.0,
            segments: 12,
            open: [false; 2],
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn nothing_overlaps_and_all_is_inside(
            seed in 0_u64..1000, kind in 0_usize..3, gap in 0.0..0.02_f64,
        ) {
            let mut source = stream(seed, "sizes", 0);
            let region = match kind {
                0 => room(&[1.0, 0.8, 0.9]),
                1 => cylinder(),
                _ => room(&[1.0, 1.0]),
            };
            let clumps: Vec<_> = (0..60)
                .map(|_| {
                    let r = 10.0_f64.powf(uniform_in(&mut source, -2.3, -1.0));
                    let balls = (0..whole(&mut source, 1, 4)).map(|i| Ball {
                        centre: Vec3::new(0.7 * r * i as f64, 0.0, 0.0),
                        radius: r * (1.0 - 0.1 * i as f64),
                    });
                    clump(balls.collect(), r.powi(3))
                })
                .collect();
            let grains = of(&clumps);
            let parameters = Random { tries: 60, gap: Length(gap), ..Random::default() };
            let packing = lay(&grains, &region, parameters.clone(), seed);
            let (least, wall) = brute_force(&packing, &grains, &region);
            prop_assert!(least >= gap - 1e-12 && wall >= gap - 1e-12, "{} {}", least, wall);
            prop_assert_eq!(packing.placements.len() + packing.dropped.len(), 60);
            prop_assert_eq!(&packing, &lay(&grains, &region, parameters, seed));
            if region.dimension() == 2 {
                prop_assert!(packing.placements.iter().all(|p| p.position.z == 0.0
                    && p.orientation.i == 0.0 && p.orientation.j == 0.0));
            }
        }
    }

    fn uniform_in(source: &mut crate::num::random::Stream, low: f64, high: f64) -> f64 {
        crate::num::random::uniform(source, low, high)
    }

    #[test]
    fn periodic_rooms_are_filled_across_their_sides() {
        let clumps = vec![dumbbell(0.03, 0.05); 150];
        let grains = of(&clumps);
        let region = periodic_room(&[0.5, 0.6, 0.7], [true, false, true]);
        let packing = lay(&grains, &region, Random { gap: Length(0.002), ..Random::default() }, 5);
        let (least, wall) = brute_force(&packing, &grains, &region);
        assert!(least >= 0.002 - 1e-12 && wall >= 0.002 - 1e-12, "{least} {wall}");
        let out = |p: &super::super::Placement| {
            let tip = p.orientation * Vec3::x() * 0.055;
            [p.position + tip, p.position - tip].iter().any(|t| t.x < 0.0 || t.x > 0.5)
        };
        assert!(packing.placements.iter().filter(|p| out(p)).count() > 10);
        assert!(packing.placements.iter().all(|p| (0.0..=0.5).contains(&p.position.x)));
        let volume = packing.placements.len() as f64 * 8.0 / 3.0 * PI * 0.03_f64.powi(3);
        assert!((packing.measures.porosity - (1.0 - volume / 0.21)).abs() < 1e-12);
        let few = periodic_room(&[0.2, 0.6, 0.7], [true, false, true]);
        let method = Method::Random(Random::default());
        assert!(pack(&grains, &[], &few, &method, 1, &Job::quiet()).is_err());
    }

    #[test]
    fn solids_keep_apart_across_the_side() {
        let mesh = l_mesh();
        let (clump, solid) = solid(mesh.mapped(|v| v * 0.1));
        let size = solid.mesh.bounds().diagonal();
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 60];
        let region = periodic_room(&[2.2 * size; 3], [true; 3]);
        let parameters = Random { tries: 60, test: Test::Solid, ..Random::default() };
        let packing = lay(&grains, &region, parameters, 11);
        let (all, cell) = (colliders(&grains, &packing), region.cell().expect("periodic"));
        for (i, (a, at)) in all.iter().enumerate() {
            for (b, there) in &all[..i] {
                let way = cell.way(&(there.0 - at.0));
                assert!(!a.nearer_than(at, b, &(at.0 + way, there.1), 0.0));
            }
        }
        assert!(packing.placements.len() > 8);
    }

    #[test]
    fn a_full_room_drops_and_says_so() {
        let clumps = vec![sphere(0.1, 3); 300];
        let grains = of(&clumps);
        let region = room(&[1.0, 1.0, 1.0]);
        let packing = lay(&grains, &region, Random { tries: 200, ..Random::default() }, 7);
        let (placed, dropped) = (packing.placements.len(), packing.dropped.len());
        assert_eq!(placed + dropped, 300);
        assert!(dropped > 150, "{dropped}");
        // Equal spheres jam at 0.384 without walls; with walls and few tries it is less.
        let fraction = placed as f64 * 4.0 / 3.0 * PI * 1e-3;
        assert!((0.2..0.39).contains(&fraction), "{fraction}");
        assert!((packing.measures.porosity - (1.0 - fraction)).abs() < 1e-12);
        assert_eq!(packing.measures.porosity_error, 0.0);
        assert!(
            packing.outcome.contains(&format!("placed {placed} of 300")),
            "{}",
            packing.outcome
        );
        assert!(packing.outcome.contains(&format!("dropped {dropped}")), "{}", packing.outcome);
        // Sizes are those asked for: each body is a whole grain, used once.
        let mut seen: Vec<u32> = packing.placements.iter().map(|p| p.grain).collect();
        seen.extend(&packing.dropped);
        seen.sort_unstable();
        assert_eq!(seen, (0..300).collect::<Vec<u32>>());
    }

    #[test]
    fn discs_come_near_the_jamming_fraction() {
        let clumps = vec![sphere(0.02, 2); 450];
        let grains = of(&clumps);
        let region = room(&[1.0, 1.0]);
        let packing = lay(&grains, &region, Random { tries: 500, ..Random::default() }, 2);
        let fraction = 1.0 - packing.measures.porosity;
        // 0.547 at saturation far from walls.
        assert!((0.44..0.547).contains(&fraction), "{fraction}");
    }

    #[test]
    fn largest_first_packs_denser() {
        let mut source = stream(4, "sizes", 0);
        let clumps: Vec<_> =
            (0..400).map(|_| sphere(uniform_in(&mut source, 0.02, 0.16), 3)).collect();
        let grains = of(&clumps);
        let region = room(&[1.0, 1.0, 1.0]);
        let fraction = |order| {
            let parameters = Random { tries: 100, order, ..Random::default() };
            1.0 - lay(&grains, &region, parameters, 3).measures.porosity
        };
        let (first, given) = (fraction(Order::LargestFirst), fraction(Order::AsGiven));
        assert!(first > given + 0.02, "{first} against {given}");
    }

    #[test]
    fn clumps_turn_every_way_and_only_about_z_in_the_plane() {
        let clumps = vec![dumbbell(0.01, 0.04); 200];
        let grains = of(&clumps);
        let along = |region: &Region| {
            let packing = lay(&grains, region, Random::default(), 5);
            packing.placements.iter().map(|p| (p.orientation * Vec3::x()).z.powi(2)).sum::<f64>()
                / packing.placements.len() as f64
        };
        assert!((along(&room(&[1.0, 1.0, 1.0])) - 1.0 / 3.0).abs() < 0.1);
        assert!(along(&room(&[2.0, 2.0])) < 1e-24);
    }

    fn colliders(
        grains: &[Grain],
        packing: &Packing,
    ) -> Vec<(Collider, (Vec3, crate::num::Rotation))> {
        packing
            .placements
            .iter()
            .map(|laid| {
                let grain = &grains[laid.grain as usize];
                let (mesh, clump) = (&grain.solid.expect("a solid").mesh, grain.clump);
                let body = mesh.mapped(|v| clump.axes.inverse() * (v - clump.centroid));
                let collider = Collider::new(&body, 1.0).expect("triangles");
                (collider, (laid.position, laid.orientation))
            })
            .collect()
    }

    #[test]
    fn l_shaped_solids_never_overlap() {
        let mesh = l_mesh();
        let (clump, solid) = solid(mesh.mapped(|v| v * 0.1));
        let size = solid.mesh.bounds().diagonal();
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 60];
        for region in [room(&[2.2 * size; 3]), {
            let ball = icosphere(2).mapped(|v| v * (1.3 * size));
            Region::Mesh(Box::new(MeshRegion::new(ball).expect("closed")))
        }] {
            let parameters = Random { tries: 60, test: Test::Solid, ..Random::default() };
            let packing = lay(&grains, &region, parameters, 11);
            assert!(packing.placements.len() > 8, "{}", packing.outcome);
            assert!(!packing.dropped.is_empty());
            let all = colliders(&grains, &packing);
            // Points spread over each surface must lie inside the room and outside all other solids.
            let points: Vec<Vec<Vec3>> = all
                .iter()
                .map(|(collider, at)| {
                    let body = collider.vertices();
                    let mixed = body.iter().flat_map(|a| body.iter().map(move |b| 0.5 * (a + b)));
                    mixed.chain(body.iter().copied()).map(|v| at.0 + at.1 * v).collect()
                })
                .collect();
            for (i, (collider, at)) in all.iter().enumerate() {
                let vertices = collider.vertices().len();
                let own = &points[i][points[i].len() - vertices..];
                assert!(own.iter().all(|p| region.clearance(p) >= 0.0));
                for (j, (other, other_at)) in all.iter().enumerate().filter(|&(j, _)| j != i) {
                    assert!(!collider.nearer_than(at, other, other_at, 0.0), "{i} {j}");
                    // Vertices and face diagonals of a convex part lie in the solid.
                    let corners = points[j].iter().rev().take(other.vertices().len());
                    assert!(corners.into_iter().all(|p| !collider.holds(at, p)), "{i} {j}");
                }
            }
        }
    }

    #[test]
    fn spheres_stay_clear_of_solids() {
        let (l_clump, l_solid) = solid(l_mesh().mapped(|v| v * 0.2));
        let ball = sphere(0.06, 3);
        let mut grains = vec![Grain { clump: &l_clump, solid: Some(&l_solid), family: 0 }; 6];
        grains.extend(vec![Grain { clump: &ball, solid: None, family: 1 }; 60]);
        let region = room(&[1.0, 1.0, 1.0]);
        let parameters =
            Random { tries: 100, test: Test::Solid, gap: Length(0.005), ..Random::default() };
        let packing = lay(&grains, &region, parameters, 3);
        let count = |family| {
            let family_of =
                |p: &&super::super::Placement| grains[p.grain as usize].family == family;
            packing.placements.iter().filter(family_of).count()
        };
        assert!(count(0) > 2 && count(1) > 20, "{}", packing.outcome);
        for l in packing.placements.iter().filter(|p| p.grain < 6) {
            let world = l_solid.mesh.mapped(|v| {
                l.position + l.orientation * (l_clump.axes.inverse() * (v - l_clump.centroid))
            });
            let distance = crate::geometry::SignedDistance::new(&world).expect("closed");
            for ball in packing.placements.iter().filter(|p| p.grain >= 6) {
                assert!(distance.at(&ball.position) >= 0.065 - 1e-9);
            }
        }
    }

    #[test]
    fn a_mesh_room_holds_its_grains() {
        let mesh = l_mesh();
        let size = mesh.bounds().size().min();
        let region = Region::Mesh(Box::new(MeshRegion::new(mesh).expect("closed")));
        let clumps = vec![sphere(0.06 * size, 3); 80];
        let grains = of(&clumps);
        let packing = lay(&grains, &region, Random::default(), 3);
        assert!(packing.placements.len() > 40, "{}", packing.outcome);
        let (gap, wall) = brute_force(&packing, &grains, &region);
        assert!(gap >= 0.0 && wall >= 0.0, "{gap} {wall}");
    }

    #[test]
    fn rearranging_finds_places_that_draws_do_not() {
        for dimension in [2, 3] {
            let clumps = vec![super::super::samples::dumbbell(0.04, 0.08); 500];
            let grains = of(&clumps);
            let region = room(&vec![if dimension == 2 { 1.4 } else { 0.8 }; dimension]);
            let placed = |rearrange| {
                let parameters = Random { tries: 40, rearrange, ..Random::default() };
                let packing = lay(&grains, &region, parameters, 2);
                let (gap, wall) = brute_force(&packing, &grains, &region);
                assert!(gap >= 0.0 && wall >= 0.0, "{gap} {wall}");
                packing
            };
            let (plain, moved) = (placed(None), placed(Some(Rearrange::default())));
            assert!(moved.placements.len() > plain.placements.len(), "{}", moved.outcome);
            assert!(moved.outcome.contains("sizes as wanted"), "{}", moved.outcome);
            let shrink = Rearrange { turns: 0, moves: 0, smallest: 0.5, ..Rearrange::default() };
            let shrunk = placed(Some(shrink));
            assert!(shrunk.placements.len() > moved.placements.len(), "{}", shrunk.outcome);
            assert!(shrunk.placements.iter().all(|p| (0.5..=1.0).contains(&p.scale)));
            assert!(shrunk.placements.iter().any(|p| p.scale < 1.0));
        }
    }

    #[test]
    fn shrunk_solids_fit_too() {
        let (clump, solid) = solid(l_mesh().mapped(|v| v * 0.1));
        let size = solid.mesh.bounds().diagonal();
        let grains = vec![Grain { clump: &clump, solid: Some(&solid), family: 0 }; 40];
        let parameters = Random {
            tries: 16,
            test: Test::Solid,
            rearrange: Some(Rearrange { smallest: 0.3, ..Rearrange::default() }),
            ..Random::default()
        };
        let packing = lay(&grains, &room(&[1.8 * size; 3]), parameters, 6);
        assert!(packing.placements.iter().any(|p| p.scale < 1.0), "{}", packing.outcome);
        let all: Vec<(Collider, (Vec3, crate::num::Rotation))> = packing
            .placements
            .iter()
            .map(|laid| {
                let body =
                    solid.mesh.mapped(|v| clump.axes.inverse() * (v - clump.centroid) * laid.scale);
                (Collider::new(&body, 1.0).expect("triangles"), (laid.position, laid.orientation))
            })
            .collect();
        for (i, (a, at)) in all.iter().enumerate() {
            for (b, there) in &all[..i] {
                assert!(!a.nearer_than(at, b, there, 0.0));
            }
        }
    }

    #[test]
    fn cancelled_work_is_an_outcome() {
        use std::sync::{Arc, atomic::AtomicBool};
        let clumps = vec![sphere(0.1, 3); 5];
        let grains = of(&clumps);
        let stop = Arc::new(AtomicBool::new(true));
        let job = Job::new(1, Arc::new(crate::num::job::Silent), stop);
        let method = Method::Random(Random::default());
        let packing = pack(&grains, &[], &room(&[1.0; 3]), &method, 1, &job).expect("no error");
        assert_eq!(packing.dropped, [0, 1, 2, 3, 4]);
        assert!(packing.outcome.contains("stopped"), "{}", packing.outcome);
    }

    #[test]
    fn wrong_parameters_name_their_key() {
        let fault = |p: Random| Method::Random(p).validate().expect_err("is wrong").key;
        assert_eq!(fault(Random { tries: 0, ..Random::default() }), "random.tries");
        assert_eq!(fault(Random { gap: Length(-1.0), ..Random::default() }), "random.gap");
        let up = Random { velocity: [Speed(0.0), Speed(0.0), Speed(1.0)], ..Random::default() };
        let result = pack(&[], &[], &room(&[1.0, 1.0]), &Method::Random(up), 1, &Job::quiet());
        assert!(result.expect_err("z in the plane").to_string().contains("random.velocity"));
        let text = r#"random = { tries = 50, test = "solid", gap = "0.1 mm", velocity = [0, 0, "-1 m/s"] }"#;
        let Ok(Method::Random(read)) = toml::from_str(text) else { panic!("well formed") };
        assert_eq!((read.tries, read.test, read.gap), (50, Test::Solid, Length(1e-4)));
    }
}
