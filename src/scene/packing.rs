//! The stage that places grains: `packing.csv`, `packing.json`, `packing.vtp`.

use super::road::{Grains, Packed, Road, RoadError};
use super::store::key;
use super::walls::Room;
use crate::format::{self, Particles};
use crate::num::Fault;
use crate::pack::{self, PackError, Packing};
use serde_json::json;

impl Road {
    /// The packing, in `packing.csv`.
    ///
    /// # Errors
    /// Grains that cannot be placed as asked; a folder that cannot be written.
    pub fn packed(&mut self) -> Result<Packed, RoadError> {
        let grains = self.grains()?;
        let room = Room::of(&self.loaded).map_err(|fault| self.wrong(fault))?;
        let method = self.parameters(&|scene| {
            json!([
                scene.seed,
                scene.dimension,
                scene.container.as_ref().map(|c| &c.shape),
                scene.packing
            ])
        });
        let key = key(&grains.key, &[method], self.loaded.base());
        let packing = if self.store.is_done("pack", &key) {
            self.unchanged("packing", "packing.csv");
            self.read_packing()?
        } else {
            self.pack(&grains, &room, &key)?
        };
        Ok(Packed { room, grains, packing, key })
    }

    fn pack(&mut self, grains: &Grains, room: &Room, key: &str) -> Result<Packing, RoadError> {
        let mut running = self.store.begin("pack", key)?;
        let list = listed(grains);
        let scene = &self.loaded.scene;
        let names: Vec<&str> = scene.grains.iter().map(|family| family.name.as_str()).collect();
        let dimension = scene.dimension as usize;
        let packed = match (&room.region, &scene.packing) {
            (Some(region), method) => {
                pack::pack(&list, &names, region, method, scene.seed, &self.job)
            }
            (None, pack::Method::Placed(placed)) => {
                pack::pack_freely(&list, &names, dimension, placed, &self.job)
            }
            (None, _) => Err(Fault::new("", "needs a container", "a [container]").into()),
        };
        let packing = packed.map_err(|error| self.refused(error))?;
        if self.job.is_cancelled() {
            return Err(RoadError::Cancelled);
        }
        if packing.placements.is_empty() {
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
        self.store.write(&mut running, "packing.json", |out| {
            let summary = Packing { placements: Vec::new(), ..packing.clone() };
            Ok(serde_json::to_writer_pretty(out, &summary)?)
        })?;
        running.count("placed", packing.placements.len());
        running.count("dropped", packing.dropped.len());
        let made = format!("packed {} grains", packing.placements.len());
        self.close(running, &made)?;
        Ok(packing)
    }

    fn read_packing(&self) -> Result<Packing, RoadError> {
        let mut packing: Packing = self.store.read_json("packing.json")?;
        packing.placements = pack::file::read(&self.store.path("packing.csv"))
            .map_err(|error| self.refused(error))?;
        Ok(packing)
    }

    fn refused(&self, error: PackError) -> RoadError {
        match error {
            PackError::Wrong(fault) => self.wrong(fault.under("packing")),
            PackError::File(error) => error.into(),
        }
    }
}

/// The spheres of all placed grains, each with its body.
fn spheres(packing: &Packing, list: &[pack::Grain]) -> Particles {
    let mut table = Particles::default();
    let (mut bodies, mut velocities, mut spins) = (Vec::new(), Vec::new(), Vec::new());
    for (body, laid) in packing.placements.iter().enumerate() {
        for ball in &list[laid.grain as usize].clump.balls {
            let arm = laid.orientation * ball.centre;
            table.positions.push(laid.position + arm);
            table.radii.push(ball.radius);
            bodies.push(body as u64);
            velocities.push(laid.velocity + laid.spin.cross(&arm));
            spins.push(laid.spin);
        }
    }
    table.bodies = Some(bodies);
    table.velocities = Some(velocities);
    table.spins = Some(spins);
    table
}

/// One entry a single grain, as the packing methods take them.
fn listed(grains: &Grains) -> Vec<pack::Grain<'_>> {
    grains
        .copies
        .iter()
        .map(|&copy| {
            let grain = &grains.distinct[copy as usize];
            pack::Grain { clump: &grain.clump, solid: grain.solid.as_ref(), family: grain.family }
        })
        .collect()
}
