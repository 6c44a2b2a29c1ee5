//! The road from a scene to its results: each stage asks for the one before it,
//! is done once, and is taken from the output folder where nothing has changed.

use super::build::{self, Built};
use super::grains::{self, Draw, Grain};
use super::inserting;
use super::statistics;
use super::store::{Running, Store, key};
use super::walls::Room;
use super::{Loaded, SceneError};
use crate::clump::{self, Clump, ClumpError};
use crate::format::{self, FormatError};
use crate::num::{Fault, Job};
use crate::pack::Packing;
use crate::shape::descriptors::{Descriptors, describe};
use crate::shape::{Fact, Made, Shape, Solid};
use crate::solver::SolverError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Why the road ended early.
#[derive(Debug, thiserror::Error)]
pub enum RoadError {
    /// The scene or a file that it names cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file could not be read or written.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A clump could not be made, written or read.
    #[error(transparent)]
    Clump(#[from] ClumpError),
    /// Our own DEM could not run the model.
    #[error(transparent)]
    Dem(#[from] crate::dem::DemError),
    /// An outside solver is missing or failed.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// The work was done but not as it should have been.
    #[error("{0}")]
    Work(String),
    /// The user asked to stop in the middle of a run that has a checkpoint.
    #[error("stopped; `riprap run {scene} --resume` goes on from step {step}, bit for bit")]
    Paused {
        /// The scene file.
        scene: String,
        /// Step of the checkpoint.
        step: u64,
    },
    /// The user asked to stop; what is finished is kept.
    #[error("stopped; what is finished is kept in the output folder")]
    Cancelled,
}

/// A scene on its way.
pub struct Road {
    /// The scene.
    pub loaded: Loaded,
    /// Its output folder.
    pub store: Store,
    /// Progress, threads, cancelling.
    pub job: Job,
    /// What the user should know of and may not expect.
    pub remarks: Vec<String>,
}

/// True shapes of a scene.
pub struct Shapes {
    /// Distinct grains: what each is drawn from.
    pub draws: Vec<Draw>,
    /// For each of them its shape; `None` for spheres and discs.
    pub described: Vec<Option<Described>>,
    /// Key of the stage, for those that build on it.
    pub key: String,
}

/// Grains of a scene.
pub struct Grains {
    /// Distinct grains.
    pub distinct: Vec<Grain>,
    /// For every single grain the index of its distinct one.
    pub copies: Vec<u32>,
    /// Key of the stage, for those that build on it.
    pub key: String,
}

/// A packing with what it was made of.
pub struct Packed {
    /// Container and walls.
    pub room: Room,
    /// Grains.
    pub grains: Grains,
    /// Where they went.
    pub packing: Packing,
    /// Key of the stage.
    pub key: String,
}

/// What `shapes/shapes.json` remembers of a solid besides its STL file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Described {
    /// Name of the solid and of its STL file.
    pub name: String,
    /// How it was made.
    pub recipe: String,
    /// Its measures.
    pub measures: Descriptors,
}

impl Road {
    /// Reads the scene at `path` and opens its output folder: `out`, or `NAME.out` beside the scene.
    ///
    /// # Errors
    /// A scene that cannot be used; a folder that cannot be written.
    pub fn open(path: &Path, out: Option<&Path>, job: Job) -> Result<Self, RoadError> {
        let loaded = Loaded::read(path)?;
        let root = out.map_or_else(|| path.with_extension("out"), Path::to_owned);
        let store = Store::open(&root, path, &loaded.text, loaded.scene.seed)?;
        Ok(Self { loaded, store, job, remarks: Vec::new() })
    }

    /// An error that points at the place of `fault` in the scene file.
    pub fn wrong(&self, fault: Fault) -> RoadError {
        RoadError::Scene(self.loaded.wrong(&[fault]))
    }

    pub(super) fn parameters(
        &self,
        of: &dyn Fn(&super::Scene) -> serde_json::Value,
    ) -> serde_json::Value {
        of(&self.loaded.scene)
    }

    /// True if some stage had to be done; false if all was taken from the output folder.
    pub fn has_worked(&self) -> bool {
        self.store.has_worked()
    }

    /// Ends a stage and says what it made.
    pub(super) fn close(&mut self, running: Running, made: &str) -> Result<(), RoadError> {
        let seconds = self.store.finish(running)?;
        self.job.finished(&format!("{made} in {seconds:.1} s"));
        Ok(())
    }

    /// Says that a stage need not be done again.
    pub(super) fn unchanged(&self, stage: &str, file: &str) {
        let path = self.store.path(file);
        self.job.detail(&format!("{stage}: unchanged, taken from {}", path.display()));
    }

    /// True shapes of all distinct grains, in `shapes/`.
    ///
    /// # Errors
    /// A shape that cannot be made; a folder that cannot be written.
    pub fn solids(&mut self) -> Result<Shapes, RoadError> {
        let draws = grains::draws(&self.loaded).map_err(|fault| self.wrong(fault))?;
        let families = self.parameters(&|scene| {
            let part = |f: &super::parameters::Family| {
                json!([f.name, f.count, f.size, f.shape, f.distinct, f.cluster.is_some()])
            };
            let families: Vec<_> = scene.grains.iter().map(part).collect();
            // 2: `shapes.json` holds measures.
            json!([2, scene.seed, scene.dimension, families])
        });
        let key = key("", &[families], self.loaded.base());
        if !self.store.is_done("generate", &key) {
            self.generate(&draws, &key)?;
        } else if !self.is_plain() {
            self.unchanged("shapes", "shapes");
        }
        let described = self.read_described(&draws)?;
        Ok(Shapes { draws, described, key })
    }

    /// Each shape is written and measured as soon as it is made, so that no more of them are
    /// in memory than there are threads.
    fn generate(&mut self, draws: &[Draw], key: &str) -> Result<(), RoadError> {
        let mut running = self.store.begin("generate", key)?;
        if !self.is_plain() {
            let folder = self.store.path("shapes");
            std::fs::create_dir_all(&folder)
                .map_err(|source| FormatError::io(&folder, "write", source))?;
        }
        let done = std::sync::atomic::AtomicU64::new(0);
        let written = Mutex::new(Vec::new());
        let made = in_pool(&self.job, || {
            draws
                .par_iter()
                .map(|draw| {
                    if self.job.is_cancelled() {
                        return Err(RoadError::Cancelled);
                    }
                    let made =
                        grains::made(&self.loaded, draw).map_err(|fault| self.wrong(fault))?;
                    let made = made.map(|made| self.keep(made, &written)).transpose()?;
                    let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                    self.job.report("grains", count, draws.len() as u64);
                    Ok(made)
                })
                .collect::<Result<_, _>>()
        });
        // A stage that did not end leaves no surfaces behind that look like all of them.
        if made.is_err() {
            for path in written.into_inner().unwrap_or_default() {
                let _ = std::fs::remove_file(path);
            }
        }
        let made: Vec<Option<(Described, Vec<Fact>)>> = made?;
        let (described, facts): (Vec<Option<Described>>, Vec<Vec<Fact>>) = made
            .into_iter()
            .map(|made| made.map_or((None, Vec::new()), |(known, facts)| (Some(known), facts)))
            .unzip();
        let shapes = described.iter().flatten().count();
        self.write_described(&mut running, draws, &described, &facts)?;
        running.count("shapes", shapes);
        if shapes == 0 {
            self.store.finish(running)?;
            return Ok(());
        }
        self.close(running, &format!("made {shapes} shapes"))
    }

    /// Tables and charts of the shapes; `described` and `facts` hold one entry a draw.
    fn write_described(
        &self,
        running: &mut Running,
        draws: &[Draw],
        described: &[Option<Described>],
        facts: &[Vec<Fact>],
    ) -> Result<(), RoadError> {
        let solids: Vec<&Described> = described.iter().flatten().collect();
        for solid in &solids {
            self.store.prepare(running, &format!("shapes/{}.stl", solid.name))?;
        }
        if !solids.is_empty() {
            self.store.write(running, "shapes/shapes.json", |out| {
                Ok(serde_json::to_writer_pretty(out, &solids)?)
            })?;
            self.store.write(running, "shapes/shapes.csv", |out| write_table(out, &solids))?;
        }
        if facts.iter().any(|facts| !facts.is_empty()) {
            let rows: Vec<_> = described
                .iter()
                .zip(facts)
                .filter_map(|(known, facts)| Some((known.as_ref()?.name.as_str(), &facts[..])))
                .collect();
            self.store.write(running, "shapes/statistics.csv", |out| {
                statistics::write_facts(out, &rows)
            })?;
            for (name, svg) in statistics::distributions(&self.loaded, draws, facts) {
                self.store.write(running, &name, |out| out.write_all(svg.as_bytes()))?;
            }
        }
        Ok(())
    }

    /// Writes the surface of a grain, and keeps what is smaller.
    fn keep(
        &self,
        made: Made,
        written: &Mutex<Vec<PathBuf>>,
    ) -> Result<(Described, Vec<Fact>), RoadError> {
        let Made { solid, facts } = made;
        let path = self.store.path(&format!("shapes/{}.stl", solid.name));
        if let Ok(mut written) = written.lock() {
            written.push(path.clone());
        }
        format::stl::write(&path, &solid.mesh)?;
        let measures =
            describe(&solid.mesh).map_err(|error| FormatError::file(&path, error.to_string()))?;
        Ok((Described { name: solid.name, recipe: solid.recipe, measures }, facts))
    }

    /// True if no grain has a shape of its own: spheres and discs only.
    fn is_plain(&self) -> bool {
        self.loaded.scene.grains.iter().all(|family| matches!(family.shape, Shape::Sphere))
    }

    fn read_described(&self, draws: &[Draw]) -> Result<Vec<Option<Described>>, RoadError> {
        if self.is_plain() {
            return Ok(vec![None; draws.len()]);
        }
        let mut known = self.store.read_json::<Vec<Described>>("shapes/shapes.json")?.into_iter();
        draws
            .iter()
            .map(|draw| {
                let family = &self.loaded.scene.grains[draw.family as usize];
                if matches!(family.shape, Shape::Sphere) {
                    return Ok(None);
                }
                let Some(described) = known.next() else {
                    let path = self.store.path("shapes/shapes.json");
                    let problem = format!("has no entry for {}; remove the folder", draw.name);
                    return Err(FormatError::file(&path, problem).into());
                };
                Ok(Some(described))
            })
            .collect()
    }

    /// A solid as it lies in the folder, so that a fresh run and a resumed one see the same bits.
    fn solid(&self, described: &Described) -> Result<Solid, RoadError> {
        let Described { name, recipe, .. } = described.clone();
        let mesh = format::stl::read(&self.store.path(&format!("shapes/{name}.stl")))?;
        let mass = mesh.mass_properties();
        Ok(Solid { name, mesh, mass, recipe })
    }

    /// Clumps of all distinct grains with their true shapes, all in memory, for packing and pictures.
    ///
    /// # Errors
    /// As [`Road::grains`].
    pub fn grains_with_solids(&mut self) -> Result<Grains, RoadError> {
        let (mut grains, described) = self.clumped()?;
        for (grain, known) in grains.distinct.iter_mut().zip(&described) {
            grain.solid = known.as_ref().map(|known| self.solid(known)).transpose()?;
        }
        Ok(grains)
    }

    /// Clumps of all distinct grains, in `clumps/`; true shapes stay on disk.
    ///
    /// # Errors
    /// A clump that cannot be made; a folder that cannot be written.
    pub fn grains(&mut self) -> Result<Grains, RoadError> {
        Ok(self.clumped()?.0)
    }

    fn clumped(&mut self) -> Result<(Grains, Vec<Option<Described>>), RoadError> {
        let Shapes { draws, described, key: upstream } = self.solids()?;
        let methods = self.parameters(&|scene| {
            scene
                .grains
                .iter()
                .map(|family| json!([family.clump, family.mass, family.cluster]))
                .collect()
        });
        let key = key(&upstream, &[methods], self.loaded.base());
        let clumps = if self.is_plain() {
            self.reproduce_all(&draws, &described)?
        } else if self.store.is_done("reproduce", &key) {
            self.unchanged("clumps", "clumps");
            clump::file::read_all(&self.store.path("clumps"))?
        } else {
            self.write_clumps(&draws, &described, &key)?
        };
        let copies = grains::copies(&self.loaded, &draws);
        let distinct = draws
            .iter()
            .zip(clumps)
            .map(|(draw, clump)| Grain { family: draw.family, solid: None, clump })
            .collect();
        Ok((Grains { distinct, copies, key }, described))
    }

    fn reproduce_all(
        &self,
        draws: &[Draw],
        described: &[Option<Described>],
    ) -> Result<Vec<Clump>, RoadError> {
        let done = std::sync::atomic::AtomicU64::new(0);
        let alone = self.job.with_threads(1);
        in_pool(&self.job, || {
            draws
                .par_iter()
                .zip(described)
                .map(|(draw, known)| {
                    if self.job.is_cancelled() {
                        return Err(RoadError::Cancelled);
                    }
                    let solid = known.as_ref().map(|known| self.solid(known)).transpose()?;
                    let clump = grains::reproduce(&self.loaded, draw, solid.as_ref(), &alone)
                        .map_err(|fault| {
                            if self.job.is_cancelled() {
                                return RoadError::Cancelled;
                            }
                            self.wrong(fault)
                        })?;
                    let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                    self.job.report("clumps", count, draws.len() as u64);
                    Ok(clump)
                })
                .collect()
        })
    }

    fn write_clumps(
        &mut self,
        draws: &[Draw],
        described: &[Option<Described>],
        key: &str,
    ) -> Result<Vec<Clump>, RoadError> {
        let mut running = self.store.begin("reproduce", key)?;
        let clumps = self.reproduce_all(draws, described)?;
        for clump in &clumps {
            self.store.prepare(&mut running, &format!("clumps/{}.csv", clump.name))?;
        }
        self.store.prepare(&mut running, "clumps/clumps.json")?;
        clump::file::write_all(&self.store.path("clumps"), &clumps)?;
        let spheres = clumps.iter().map(|clump| clump.balls.len()).sum();
        running.count("clumps", clumps.len());
        running.count("spheres", spheres);
        let made = format!("reproduced {} grains as {spheres} spheres", clumps.len());
        self.close(running, &made)?;
        Ok(clumps)
    }

    /// The model that all solvers share.
    ///
    /// # Errors
    /// As [`Road::packed`]; contact parameters or a step that cannot be used.
    pub fn built(&mut self) -> Result<(Packed, Built), RoadError> {
        let packed = self.packed()?;
        let built = self.build(&packed)?;
        Ok((packed, built))
    }

    fn build(&self, packed: &Packed) -> Result<Built, RoadError> {
        let Packed { room, grains, packing, .. } = packed;
        let arrivals = inserting::arrivals(
            &self.loaded,
            &grains.distinct,
            &grains.copies,
            &packing.placements,
        )
        .map_err(|fault| self.wrong(fault))?;
        build::build(
            &self.loaded,
            room.region.as_ref(),
            &room.walls,
            &grains.distinct,
            &grains.copies,
            packing,
            &arrivals,
        )
        .map_err(|fault| self.wrong(fault))
    }
}

/// `shapes.csv`: descriptors in SI units, one row a solid.
fn write_table(out: &mut dyn Write, solids: &[&Described]) -> std::io::Result<()> {
    writeln!(
        out,
        "name,volume,area,volume_diameter,area_diameter,long,intermediate,short,elongation,flatness,\
         zingg,krumbein_sphericity,projection_sphericity,wadell_sphericity,convexity,roundness,\
         roughness,inscribed_diameter,recipe"
    )?;
    for solid in solids {
        let d = &solid.measures;
        writeln!(
            out,
            "{},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:?},{:e},{:e},{:e},{:e},{:e},{:e},{:e},\"{}\"",
            solid.name,
            d.volume,
            d.area,
            d.volume_diameter,
            d.area_diameter,
            d.long,
            d.intermediate,
            d.short,
            d.elongation,
            d.flatness,
            d.zingg,
            d.krumbein_sphericity,
            d.projection_sphericity,
            d.wadell_sphericity,
            d.convexity,
            d.roundness,
            d.roughness,
            d.inscribed_diameter,
            solid.recipe.replace('"', "'")
        )?;
    }
    Ok(())
}

/// Runs `work` on a pool of the job's threads; on the caller's thread where no pool can be had.
fn in_pool<T: Send>(job: &Job, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(job.threads).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::samples::box_mesh;
    use crate::num::Vec3;

    const SCENE: &str = r#"
title = "scans"
seed = 1

[[grains]]
name = "scan"
count = 6
size = "10 mm"
shape.files = { folder = "scans" }
clump.fitted = { spheres = 4 }

[materials.rock]
density = "2650 kg/m3"

[contact]
kn = "20 kN/m"
restitution = 0.4
friction = 0.5

[container]
shape.box = { size = ["100 mm", "100 mm", "100 mm"] }

[packing.random]
tries = 100

[plan]
duration = "1 ms"
"#;

    #[test]
    fn a_bad_file_among_scans_is_named_and_no_surface_is_left() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scans = folder.path().join("scans");
        std::fs::create_dir_all(&scans).expect("can be written");
        let good = box_mesh(Vec3::new(1.0, 2.0, 1.5));
        let mut open = good.clone();
        open.triangles.pop();
        for (name, mesh) in [("a", &good), ("b", &good), ("c", &open)] {
            format::stl::write(&scans.join(format!("{name}.stl")), mesh).expect("writes");
        }
        let scene = folder.path().join("scene.toml");
        std::fs::write(&scene, SCENE).expect("can be written");
        let surfaces = || {
            std::fs::read_dir(folder.path().join("scene.out/shapes"))
                .map_or(0, |entries| entries.flatten().count())
        };
        let mut road = Road::open(&scene, None, Job::quiet()).expect("a good scene");
        let said = road.solids().err().expect("one file is open").to_string();
        assert!(said.contains("c.stl") && said.contains("open"), "{said}");
        assert_eq!(surfaces(), 0);
        // Once the file is good, so is the scene.
        format::stl::write(&scans.join("c.stl"), &good).expect("writes");
        let mut road = Road::open(&scene, None, Job::quiet()).expect("a good scene");
        assert_eq!(road.solids().expect("all are good").described.len(), 3);
        assert!(surfaces() > 3);
    }
}
