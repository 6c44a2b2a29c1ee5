//! The stage that runs our own DEM: streams frames to disk, keeps checkpoints,
//! goes on from the last one, and writes what people read.

use super::build::Built;
use super::readings::{Readings, Row};
use super::road::{Packed, Road, RoadError};
use super::store::{self, Running};
use super::watching::Watch;
use crate::dem::{self, Observer};
use crate::format::{self, FormatError, atomic, particles::Particles};
use crate::geometry::Region;
use crate::model::{Break, Frame, Lost, Model, Outcome, Run, SeriesRow};
use crate::num::clock::{peak_bytes, resident_bytes};
use crate::pack::Push;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

const FRAMES: &str = "run/frames.bin";
const MEASURES: &str = "run/measures.json";
const CHECKPOINT: &str = "run/checkpoint.bin";

/// A checkpoint with what the files held at that time.
#[derive(Serialize, Deserialize)]
struct Saved {
    key: String,
    frames_bytes: u64,
    rows: Vec<SeriesRow>,
    readings: Vec<Row>,
    state: Vec<u8>,
}

/// Frames go to disk as they come, rows stay here until the end.
struct Recorder {
    frames: BufWriter<File>,
    rows: Vec<SeriesRow>,
    /// Rows left out, as they held numbers that are not finite.
    wild: usize,
    key: String,
    checkpoint: PathBuf,
    watch: Option<Watch>,
    failure: Option<std::io::Error>,
}

impl Recorder {
    fn attempt(&mut self, work: impl FnOnce(&mut Self) -> std::io::Result<()>) {
        if self.failure.is_none() {
            self.failure = work(self).err();
        }
    }
}

impl Observer for Recorder {
    fn frame(&mut self, frame: &Frame) {
        self.attempt(|me| {
            let written = postcard::to_io(frame, &mut me.frames).map(drop);
            // postcard keeps the system's reason to itself; writing what is left over tells it.
            written.map_err(|error| {
                me.frames.flush().err().unwrap_or_else(|| std::io::Error::other(error))
            })
        });
    }

    fn row(&mut self, row: &SeriesRow) {
        match row.is_finite() {
            true => self.rows.push(*row),
            false => self.wild += 1,
        }
    }

    fn checkpoint(&mut self, state: &[u8]) {
        self.attempt(|me| {
            let saved = Saved {
                key: me.key.clone(),
                frames_bytes: me.frames.stream_position()?,
                rows: me.rows.clone(),
                readings: me
                    .watch
                    .as_ref()
                    .map(|watch| watch.readings.rows.clone())
                    .unwrap_or_default(),
                state: state.to_vec(),
            };
            let bytes = postcard::to_stdvec(&saved).map_err(std::io::Error::other)?;
            atomic::write(&me.checkpoint, |out| out.write_all(&bytes))
                .map_err(std::io::Error::other)
        });
    }

    fn wants_pushes(&self, last: bool) -> bool {
        self.watch.as_ref().is_some_and(|watch| watch.wants(last))
    }

    fn pushes(&mut self, frame: &Frame, pushes: Vec<Push>) {
        if let Some(watch) = &mut self.watch {
            watch.look(frame, pushes);
        }
    }
}

impl Road {
    /// Runs our own DEM, or takes the finished run from the folder. With `resume`,
    /// an interrupted run goes on from its last checkpoint, bit for bit.
    ///
    /// # Errors
    /// As [`Road::built`]; a step that the DEM refuses; a folder that cannot be written.
    /// [`RoadError::Paused`] after Ctrl-C, with a checkpoint kept.
    pub fn run(&mut self, resume: bool) -> Result<(Packed, Built, Run), RoadError> {
        let (packed, built) = self.built()?;
        let key = self.run_key(&packed);
        if self.store.is_done("run", &key) {
            self.unchanged("run", "run");
            let run = self.read_run()?;
            return Ok((packed, built, run));
        }
        let run = self.simulate(&built.model, packed.room.region.as_ref(), &key, resume)?;
        Ok((packed, built, run))
    }

    /// Key of the run that starts from `packed`.
    pub(super) fn run_key(&self, packed: &Packed) -> String {
        let scene = &self.loaded.scene;
        let made_of: Vec<_> =
            scene.grains.iter().map(|f| (&f.material, &f.body, &f.insertion)).collect();
        let rest = json!([
            made_of,
            scene.materials,
            scene.contact,
            scene.pairs,
            scene.container,
            scene.walls,
            scene.plan,
            scene.output
        ]);
        store::key(&packed.key, &[rest], self.loaded.base())
    }

    fn simulate(
        &mut self,
        model: &Model,
        region: Option<&Region>,
        key: &str,
        resume: bool,
    ) -> Result<Run, RoadError> {
        let saved = if resume { self.saved(key) } else { None };
        if saved.is_some() {
            self.job.finished("going on from the last checkpoint");
        }
        let mut running = self.store.begin("run", key)?;
        let frames_path = self.store.prepare(&mut running, FRAMES)?;
        let frames = open_frames(&frames_path, saved.as_ref())
            .map_err(|source| FormatError::io(&frames_path, "write", source))?;
        let mut recorder = Recorder {
            frames: BufWriter::new(frames),
            rows: saved.as_ref().map(|s| s.rows.clone()).unwrap_or_default(),
            wild: 0,
            key: key.to_owned(),
            checkpoint: self.store.path(CHECKPOINT),
            watch: Watch::new(
                &self.loaded.scene.output.measures,
                self.loaded.scene.output.contacts,
                model,
                region,
                saved.as_ref().map(|s| s.readings.clone()).unwrap_or_default(),
            ),
            failure: None,
        };
        let state = saved.as_ref().map(|saved| saved.state.as_slice());
        let before = resident_bytes();
        let summary = dem::simulate(model, state, &self.job, &mut recorder)?;
        if let (Some(before), Some(peak)) = (before, peak_bytes()) {
            running.count("dem_bytes", peak.saturating_sub(before) as usize);
        }
        let flushed = recorder.frames.flush();
        if let Some(failure) = recorder.failure.or(flushed.err()) {
            return Err(FormatError::io(&frames_path, "write", failure).into());
        }
        if let Outcome::Cancelled { step } = summary.outcome {
            let scene = self.loaded.path.display().to_string();
            return Err(RoadError::Paused { scene, step });
        }
        let mut notes = summary.notes;
        if recorder.wild > 0 {
            notes.push(format!(
                "{} rows of the series are left out: energies or momenta beyond the range of numbers",
                recorder.wild
            ));
        }
        let run = Run {
            solver: format!("riprap {} ({})", crate::VERSION, model.plan.scheme.key()),
            outcome: summary.outcome,
            frames: Vec::new(),
            touches: Some(summary.touches),
            breaks: Some(summary.breaks),
            springs: summary.springs,
            series: recorder.rows,
            cost: summary.cost,
            notes,
        };
        self.write_run(&mut running, model, &run)?;
        if let Some(watch) = &recorder.watch {
            self.write_measures(&mut running, watch)?;
        }
        running.count("steps", run.cost.steps as usize);
        running.count("spheres", model.spheres.len());
        self.close(running, &format!("ran {} steps", run.cost.steps))?;
        // The checkpoint has done its duty; a finished run starts over only when its inputs change.
        // Where the guard stopped it, it is the state to look at.
        if run.outcome == Outcome::Finished {
            let _ = std::fs::remove_file(self.store.path(CHECKPOINT));
        }
        self.read_run()
    }

    fn saved(&mut self, key: &str) -> Option<Saved> {
        let Ok(bytes) = std::fs::read(self.store.path(CHECKPOINT)) else {
            self.remarks.push("there is no checkpoint; started from the packing".to_owned());
            return None;
        };
        let saved = postcard::from_bytes(&bytes).ok().filter(|saved: &Saved| saved.key == key);
        if saved.is_none() {
            self.remarks.push(
                "the checkpoint belongs to other inputs; started from the packing".to_owned(),
            );
        }
        let frames = std::fs::metadata(self.store.path(FRAMES)).map_or(0, |data| data.len());
        if saved.as_ref().is_some_and(|saved| frames < saved.frames_bytes) {
            let remark = "frames before the checkpoint are lost; started from the packing";
            self.remarks.push(remark.to_owned());
            return None;
        }
        saved
    }

    fn write_run(&self, running: &mut Running, model: &Model, run: &Run) -> Result<(), RoadError> {
        self.store.write(running, "run/run.json", |out| Ok(serde_json::to_writer(out, run)?))?;
        let needs = model.needs();
        let zeroing = model.plan.zero_every > 0;
        let losing = model.plan.guard.lost == Lost::Remove;
        let columns = Columns {
            ledger: model.plan.ledger,
            extra: needs.extra() || needs.drag,
            bonds: needs.bonds,
            zeroing,
            losing,
        };
        self.store
            .write(running, "run/series.csv", |out| write_series(out, &run.series, columns))?;
        if let (true, Some(breaks)) = (needs.bonds, &run.breaks) {
            self.store.write(running, "run/bonds.csv", |out| write_breaks(out, model, breaks))?;
        }
        let mut last = None;
        for (number, frame) in Frames::open(&self.store.path(FRAMES))?.enumerate() {
            let frame = frame?;
            if self.loaded.scene.output.vtp {
                let name = format!("run/frame-{number:05}.vtp");
                let path = self.store.prepare(running, &name)?;
                format::vtp::write_particles(&path, &particles(model, &frame))?;
            }
            last = Some(frame);
        }
        if let Some(frame) = last {
            let path = self.store.prepare(running, "run/final.csv")?;
            format::csv::write(&path, &particles(model, &frame))?;
            let path = self.store.prepare(running, "run/final.vtp")?;
            format::vtp::write_particles(&path, &particles(model, &frame))?;
        }
        Ok(())
    }

    /// Tables and charts of the measuring spheres, contact forces of the last frame.
    fn write_measures(&mut self, running: &mut Running, watch: &Watch) -> Result<(), RoadError> {
        if watch.keeps_pushes() {
            self.store.write(running, "run/contacts.csv", |out| watch.contacts(out))?;
        }
        if !watch.has_rows() {
            return Ok(());
        }
        let readings = &watch.readings;
        self.store.write(running, MEASURES, |out| Ok(serde_json::to_writer(out, readings)?))?;
        self.store.write(running, "run/measures.csv", |out| readings.csv(out))?;
        for (name, chart) in readings.charts() {
            if let Some(svg) = chart.svg() {
                self.store.write(running, name, |out| out.write_all(svg.as_bytes()))?;
            }
        }
        for [name, told] in readings.verdicts() {
            self.job.finished(&format!("measuring sphere {name}, {told}"));
        }
        Ok(())
    }

    /// What the measuring spheres of the finished run have read, if the scene has any.
    pub(super) fn read_measures(&self) -> Result<Option<Readings>, RoadError> {
        if self.loaded.scene.output.measures.is_empty() {
            return Ok(None);
        }
        Ok(Some(self.store.read_json(MEASURES)?))
    }

    fn read_run(&self) -> Result<Run, RoadError> {
        let mut run: Run = self.store.read_json("run/run.json")?;
        let frames: Result<_, _> = Frames::open(&self.store.path(FRAMES))?.collect();
        run.frames = frames.map_err(FormatError::of_own_file)?;
        Ok(run)
    }
}

/// Opens the file of frames: empty, or cut back to what it held at the checkpoint.
fn open_frames(path: &Path, saved: Option<&Saved>) -> std::io::Result<File> {
    match saved {
        Some(saved) => {
            let mut file = File::options().read(true).write(true).open(path)?;
            file.set_len(saved.frames_bytes)?;
            file.seek(std::io::SeekFrom::End(0))?;
            Ok(file)
        }
        None => File::create(path),
    }
}

/// Frames in a file, one after the other.
struct Frames {
    path: PathBuf,
    file: BufReader<File>,
}

impl Frames {
    fn open(path: &Path) -> Result<Self, FormatError> {
        let file = File::open(path).map_err(|source| FormatError::io(path, "read", source))?;
        Ok(Self { path: path.to_owned(), file: BufReader::new(file) })
    }

    fn read(&mut self) -> std::io::Result<Option<Frame>> {
        if self.file.fill_buf()?.is_empty() {
            return Ok(None);
        }
        // Frames hold no borrowed data: the scratch space only has to hold one number.
        let mut scratch = [0; 64];
        let read = postcard::from_io((&mut self.file, &mut scratch[..]));
        read.map(|(frame, _)| Some(frame)).map_err(std::io::Error::other)
    }
}

impl Iterator for Frames {
    type Item = Result<Frame, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read().map_err(|source| FormatError::io(&self.path, "read", source)).transpose()
    }
}

/// A frame as a table of spheres.
pub fn particles(model: &Model, frame: &Frame) -> Particles {
    Particles {
        ids: Some((0..model.spheres.len() as u64).collect()),
        bodies: Some(model.spheres.iter().map(|sphere| u64::from(sphere.body)).collect()),
        materials: Some(
            model
                .spheres
                .iter()
                .map(|s| u32::from(model.bodies[s.body as usize].material))
                .collect(),
        ),
        velocities: Some(frame.velocities.clone()),
        spins: Some(frame.spins.clone()),
        forces: Some(frame.forces.clone()),
        step: Some(frame.step),
        time: Some(frame.time),
        positions: frame.centres.clone(),
        radii: model.spheres.iter().map(|s| s.radius).collect(),
        ..Particles::default()
    }
}

/// Columns of `run/series.csv` that not every scene has.
#[derive(Clone, Copy)]
struct Columns {
    /// What contacts take, and what the ledger misses.
    ledger: bool,
    /// Forces besides the linear contact.
    extra: bool,
    bonds: bool,
    /// Velocities set to zero.
    zeroing: bool,
    /// Bodies taken out.
    losing: bool,
}

/// `run/series.csv`.
fn write_series(out: &mut dyn Write, rows: &[SeriesRow], columns: Columns) -> std::io::Result<()> {
    let Columns { ledger, extra, bonds, zeroing, losing } = columns;
    let of = |there: bool, names: &'static str| if there { names } else { "" };
    write!(out, "t,step,kinetic,elastic,gravitational")?;
    write!(out, "{}", of(ledger, ",normal_dashpot,tangential_dashpot,slip"))?;
    write!(out, ",local_damping,wall_work{}", of(ledger, ",energy_error"))?;
    write!(out, ",contacts,coordination,worst_overlap,momentum")?;
    if extra {
        write!(out, ",attraction,rolling,wetting,drag")?;
    }
    if bonds {
        write!(out, ",bond_elastic,bond_damping,bond_released,bonds")?;
    }
    write!(out, "{}", if zeroing { ",zeroed" } else { "" })?;
    writeln!(out, "{}", if losing { ",lost,lost_energy" } else { "" })?;
    for r in rows {
        write!(
            out,
            "{:e},{},{:e},{:e},{:e}",
            r.time, r.step, r.kinetic, r.elastic, r.gravitational
        )?;
        if ledger {
            write!(out, ",{:e},{:e},{:e}", r.normal_dashpot, r.tangential_dashpot, r.slip)?;
        }
        write!(out, ",{:e},{:e}", r.local_damping, r.wall_work)?;
        if let Some(error) = r.energy_error {
            write!(out, ",{error:e}")?;
        }
        write!(out, ",{},{:e},{:e},{:e}", r.contacts, r.coordination, r.worst_overlap, r.momentum)?;
        if extra {
            write!(out, ",{:e},{:e},{:e},{:e}", r.attraction, r.rolling, r.wetting, r.drag)?;
        }
        if bonds {
            let (elastic, damped, freed) = (r.bond_elastic, r.bond_damping, r.bond_released);
            write!(out, ",{elastic:e},{damped:e},{freed:e},{}", r.bonds)?;
        }
        if zeroing {
            write!(out, ",{:e}", r.zeroed)?;
        }
        if losing {
            write!(out, ",{},{:e}", r.lost, r.lost_energy)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// `run/bonds.csv`: bonds that broke, in the order of time.
fn write_breaks(out: &mut dyn Write, model: &Model, breaks: &[Break]) -> std::io::Result<()> {
    writeln!(out, "t,step,bond,first,second,mode,energy")?;
    for b in breaks {
        let bond = &model.bonds[b.bond as usize];
        let (first, second, mode) = (bond.first, bond.second, b.mode.key());
        writeln!(out, "{:e},{},{},{first},{second},{mode},{:e}", b.time, b.step, b.bond, b.energy)?;
    }
    Ok(())
}
