//! The stage that places grains: `packing.csv`, `packing.json`, `packing.vtp`.

use super::file::Loaded;
use super::grading::{self, Curves};
use super::grains::Grain;
use super::inserting;
use super::road::{Grains, Packed, Road, RoadError};
use super::store::key;
use super::walls::Room;
use crate::format::{self, Particles};
use crate::geometry::Region;
use crate::num::Fault;
use crate::pack::{self, PackError, Packing};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;

impl Road {
    /// The packing, in `packing.csv`.
    ///
    /// # Errors
    /// Grains that cannot be placed as asked; a folder that cannot be written.
    pub fn packed(&mut self) -> Result<Packed, RoadError> {
        let mut grains = self.grains_with_solids()?;
        let room = Room::of(&self.loaded).map_err(|fault| self.wrong(fault))?;
        let method = self.parameters(&|scene| {
            json!([
                scene.seed,
                scene.dimension,
                scene.container.as_ref().map(|c| &c.shape),
                scene.packing,
                scene.grains.iter().map(|family| family.insertion.is_some()).collect::<Vec<_>>(),
                // What the DEM of a preparation depends on.
                scene.packing.is_prepared().then_some((
                    &scene.materials,
                    &scene.contact,
                    &scene.pairs,
                    &scene.walls,
                    &scene.plan
                ))
            ])
        });
        let key = key(&grains.key, &[method], self.loaded.base());
        let mut packing = if self.store.is_done("pack", &key) {
            self.unchanged("packing", "packing.csv");
            self.read_packing()?
        } else {
            self.pack(&grains, &room, &key)?
        };
        adopt_scales(&mut grains, &mut packing, self.loaded.scene.dimension);
        Ok(Packed { room, grains, packing, key })
    }

    fn pack(&mut self, grains: &Grains, room: &Room, key: &str) -> Result<Packing, RoadError> {
        let mut running = self.store.begin("pack", key)?;
        let sooner = Sooner::of(&self.loaded, grains);
        let (these, some_come) = (sooner.as_ref().map_or(grains, |s| &s.grains), sooner.is_some());
        let mut packing = self.place(these, room, some_come)?;
        if let Some(sooner) = &sooner {
            sooner.number_among_all(&mut packing);
        }
        let list = listed(grains);
        if let Some(shares) = grading::shares(&self.loaded, &packing, &list) {
            packing.outcome.push_str(&format!("; {shares}"));
        }
        if self.job.is_cancelled() {
            return Err(RoadError::Cancelled);
        }
        if packing.placements.is_empty() && !some_come {
            let problem = "places no grain at all in this container";
            return Err(self.wrong(Fault::new(
                "packing",
                problem,
                "a larger container or smaller grains",
            )));
        }
        let path = self.store.prepare(&mut running, "packing.csv")?;
        pack::file::write(&path, &packing.placements, &list)
            .map_err(|error| self.refused(error))?;
        let path = self.store.prepare(&mut running, "packing.vtp")?;
        format::vtp::write_particles(&path, &spheres(&packing, &list))?;
        // A summary without the placements, which are in the table; a copy of them would be the
        // peak of the memory.
        let placements = std::mem::take(&mut packing.placements);
        self.store.write(&mut running, "packing.json", |out| {
            Ok(serde_json::to_writer_pretty(out, &packing)?)
        })?;
        packing.placements = placements;
        if let Some(curves) = Curves::of(&self.loaded, &packing, &list) {
            self.store.write(&mut running, "grading.csv", |out| curves.csv(out))?;
            if let Some(svg) = curves.chart().svg() {
                self.store
                    .write(&mut running, "grading.svg", |out| out.write_all(svg.as_bytes()))?;
            }
            self.job.finished(&curves.summary());
        }
        running.count("placed", packing.placements.len());
        running.count("dropped", packing.dropped.len());
        let made = format!("packed {} grains", packing.placements.len());
        self.close(running, &made)?;
        Ok(packing)
    }

    /// Places the grains with the scene's method; `some_come`: others come during the run.
    fn place(&self, these: &Grains, room: &Room, some_come: bool) -> Result<Packing, RoadError> {
        let scene = &self.loaded.scene;
        let list = listed(these);
        let names: Vec<&str> = scene.grains.iter().map(|family| family.name.as_str()).collect();
        let dimension = scene.dimension as usize;
        let packed = match (&room.region, &scene.packing) {
            (region, _) if list.is_empty() && some_come => Ok(nothing(region.as_ref())),
            (Some(region), pack::Method::Compression(wanted)) => {
                Ok(self.compressed(these, room, region, wanted)?)
            }
            (Some(region), pack::Method::Deposition(wanted)) => {
                Ok(self.deposited(these, room, region, wanted)?)
            }
            (Some(region), method) => {
                pack::pack(&list, &names, region, method, scene.seed, &self.job)
            }
            (None, pack::Method::Placed(placed)) => {
                pack::pack_freely(&list, &names, dimension, placed, &self.job)
            }
            (None, _) => Err(Fault::new("", "needs a container", "a [container]").into()),
        };
        packed.map_err(|error| self.refused(error))
    }

    fn read_packing(&self) -> Result<Packing, RoadError> {
        let mut packing: Packing = self.store.read_json("packing.json")?;
        packing.placements =
            pack::file::read(&self.store.path("packing.csv")).map_err(|error| match error {
                PackError::File(error) => error.of_own_file().into(),
                other => self.refused(other),
            })?;
        Ok(packing)
    }

    pub(super) fn refused(&self, error: PackError) -> RoadError {
        match error {
            PackError::Wrong(fault) => self.wrong(fault.under("packing")),
            PackError::File(error) => error.into(),
        }
    }
}

/// The grains that are there from the start, where others come during the run.
struct Sooner {
    grains: Grains,
    /// Number of each among all.
    numbers: Vec<u32>,
}

impl Sooner {
    /// `None` where all grains are there from the start.
    fn of(loaded: &Loaded, grains: &Grains) -> Option<Self> {
        let there = |copy: &u32| {
            let distinct = grains.copies[*copy as usize] as usize;
            !inserting::comes(loaded, grains.distinct[distinct].family)
        };
        let all = 0..grains.copies.len() as u32;
        if all.clone().all(|copy| there(&copy)) {
            return None;
        }
        let numbers: Vec<u32> = all.filter(there).collect();
        let copies = numbers.iter().map(|copy| grains.copies[*copy as usize]).collect();
        let grains = Grains { distinct: grains.distinct.clone(), copies, key: String::new() };
        Some(Self { grains, numbers })
    }

    /// From numbers among these grains to those among all.
    fn number_among_all(&self, packing: &mut Packing) {
        for laid in &mut packing.placements {
            laid.grain = self.numbers[laid.grain as usize];
        }
        for dropped in &mut packing.dropped {
            *dropped = self.numbers[*dropped as usize];
        }
    }
}

/// What is packed where all grains come later.
fn nothing(region: Option<&Region>) -> Packing {
    Packing {
        placements: Vec::new(),
        dropped: Vec::new(),
        outcome: "all grains come during the run".to_owned(),
        measures: pack::Measures {
            container_volume: region.map_or(0.0, Region::volume),
            porosity: 1.0,
            porosity_error: 0.0,
            coordination: 0.0,
            gap_tolerance: 0.0,
            worst_overlap: 0.0,
            least_gap: None,
        },
    }
}

/// Makes grains whose size the packing has changed grains of their own, so that what
/// follows knows nothing of scales.
fn adopt_scales(grains: &mut Grains, packing: &mut Packing, dimension: u8) {
    let mut known: BTreeMap<(u32, u64), u32> = BTreeMap::new();
    for laid in packing.placements.iter_mut().filter(|laid| laid.scale != 1.0) {
        let before = grains.copies[laid.grain as usize];
        let number = *known.entry((before, laid.scale.to_bits())).or_insert_with(|| {
            let grain = &grains.distinct[before as usize];
            grains.distinct.push(Grain {
                family: grain.family,
                solid: grain.solid.as_ref().map(|solid| solid.scaled(laid.scale)),
                clump: grain.clump.scaled(laid.scale, u32::from(dimension)),
            });
            grains.distinct.len() as u32 - 1
        });
        grains.copies[laid.grain as usize] = number;
        laid.scale = 1.0;
    }
}

/// The spheres of all placed grains, each with its body; velocities and spins where something moves.
fn spheres(packing: &Packing, list: &[pack::Grain]) -> Particles {
    let balls = |laid: &pack::Placement| &list[laid.grain as usize].clump.balls;
    let count = packing.placements.iter().map(|laid| balls(laid).len()).sum();
    let moving =
        packing.placements.iter().any(|laid| laid.velocity.norm() > 0.0 || laid.spin.norm() > 0.0);
    let mut table = Particles {
        positions: Vec::with_capacity(count),
        radii: Vec::with_capacity(count),
        bodies: Some(Vec::with_capacity(count)),
        velocities: moving.then(|| Vec::with_capacity(count)),
        spins: moving.then(|| Vec::with_capacity(count)),
        ..Particles::default()
    };
    for (body, laid) in packing.placements.iter().enumerate() {
        for ball in balls(laid) {
            let arm = laid.orientation * (ball.centre * laid.scale);
            table.positions.push(laid.position + arm);
            table.radii.push(ball.radius * laid.scale);
            table.bodies.iter_mut().for_each(|bodies| bodies.push(body as u64));
            table
                .velocities
                .iter_mut()
                .for_each(|all| all.push(laid.velocity + laid.spin.cross(&arm)));
            table.spins.iter_mut().for_each(|all| all.push(laid.spin));
        }
    }
    table
}

/// One entry a single grain, as the packing methods take them.
pub(super) fn listed(grains: &Grains) -> Vec<pack::Grain<'_>> {
    grains
        .copies
        .iter()
        .map(|&copy| {
            let grain = &grains.distinct[copy as usize];
            pack::Grain { clump: &grain.clump, solid: grain.solid.as_ref(), family: grain.family }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clump;
    use crate::num::{Rotation, Vec3};

    #[test]
    fn scaled_grains_become_grains_of_their_own_once_each() {
        let ball = Grain { family: 0, solid: None, clump: clump::sphere("ball", 1.0) };
        let mut grains = Grains { distinct: vec![ball], copies: vec![0; 3], key: String::new() };
        let placement = |grain, scale| pack::Placement {
            grain,
            position: Vec3::zeros(),
            orientation: Rotation::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            scale,
        };
        let container = crate::geometry::Container::Box(crate::geometry::container::BoxContainer {
            size: Some(vec![crate::num::units::Length(1.0); 3]),
            ..Default::default()
        });
        let region = container.region(3, None).expect("a box");
        let list = [];
        let placements = vec![placement(0, 0.5), placement(1, 1.0), placement(2, 0.5)];
        let measures = pack::measure::measure(&[], &list, &region);
        let mut packing =
            Packing { placements, dropped: Vec::new(), outcome: String::new(), measures };
        adopt_scales(&mut grains, &mut packing, 3);
        assert_eq!(grains.copies, [1, 0, 1]);
        assert_eq!(
            grains.distinct[1].clump,
            clump::Clump { name: "ball".into(), ..clump::sphere("ball", 0.5) }
        );
        assert!(packing.placements.iter().all(|laid| laid.scale == 1.0));
    }
}
