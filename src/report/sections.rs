//! The sections of the page: data in, finished texts and figures out.

use super::compare::{Comparison, Statistics, Trajectory, measure};
use super::figure::Figure;
use super::gallery;
use super::input::PageInput;
use super::number::{bytes, count, per_cent, significant, with_unit};
use super::table::Table;
use super::verdict::{Verdict, span, verdict};
use super::{ReportError, curves};
use crate::model::{Dimension, Frame, Model, Motion, Outcome, Run, StepReason, WallShape};
use crate::num::Vec3;
use crate::num::statistics::quantile;
use serde::Serialize;
use std::collections::BTreeSet;

/// Grains shown in a gallery at most.
const GALLERY: usize = 24;
/// Rows of tables of grains at most.
const ROWS: usize = 12;

/// Everything the template sees.
#[derive(Serialize)]
pub(super) struct Sections {
    title: String,
    version: String,
    verdict: Option<Verdict>,
    scene: Option<Scene>,
    grains: Option<Plain>,
    clumps: Option<Plain>,
    packing: Option<Plain>,
    run: Option<Plain>,
    measures: Option<Plain>,
    finals: Option<Plain>,
    trajectories: Option<Plain>,
    cost: Option<Plain>,
    notes: Vec<Note>,
    commands: Vec<String>,
}

/// Facts, figures, a table: what most sections are.
#[derive(Serialize, Default)]
struct Plain {
    facts: Vec<[String; 2]>,
    figures: Vec<Figure>,
    table: Option<Table>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct Scene {
    facts: Vec<[String; 2]>,
    has: Vec<String>,
    left_out: Vec<String>,
    materials: Table,
    contacts: Table,
    walls: Option<Table>,
}

#[derive(Serialize)]
struct Note {
    solver: String,
    sentences: Vec<String>,
}

fn fact(name: &str, value: impl Into<String>) -> [String; 2] {
    [name.into(), value.into()]
}

fn texts(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|cell| (*cell).into()).collect()
}

impl Sections {
    /// Every section that has data.
    /// Pictures come out `shrink` times smaller than they should.
    pub(super) fn of(input: &PageInput, shrink: usize) -> Result<Self, ReportError> {
        let runs: Vec<&Run> = input.ours.into_iter().chain(input.others).collect();
        // With a comparison, the verdict shows what ours is like.
        let own = match (input.model, input.ours, input.comparison) {
            (Some(model), Some(ours), None) => measure(model, ours),
            _ => None,
        };
        Ok(Self {
            title: input.title.into(),
            version: input.version.into(),
            verdict: input.comparison.map(|found| verdict(found, input.missing)),
            scene: input.model.map(scene),
            grains: grains(input, shrink)?,
            clumps: clumps(input, shrink)?,
            packing: packing(input, shrink)?,
            run: input.ours.map(|ours| run(ours, own.as_ref())),
            measures: measures(input),
            finals: finals(input, &runs, shrink)?,
            trajectories: trajectories(input, &runs, own.as_ref()),
            cost: cost(&runs),
            notes: notes(&runs),
            commands: input.commands.to_vec(),
        })
    }
}

fn vector(v: &Vec3, unit: &str) -> String {
    let parts: Vec<String> = v.iter().map(|x| significant(*x, 4)).collect();
    format!("({}) {unit}", parts.join(", "))
}

fn scene(model: &Model) -> Scene {
    let plan = &model.plan;
    let table = model.needs().table();
    let pick = |wanted: bool| {
        table.iter().filter(|need| need.2 == wanted).map(|need| need.1.to_owned()).collect()
    };
    let reason = match &plan.reason {
        StepReason::Given => "given in the scene".to_owned(),
        StepReason::Auto(text) => text.clone(),
    };
    let mut facts = vec![
        fact("Dimensions", model.dimension.count().to_string()),
        fact("Bodies", count(model.bodies.len() as u64)),
        fact("Spheres", count(model.spheres.len() as u64)),
        fact("Radii", radii(model)),
        fact("Gravity", vector(&model.gravity, "m/s²")),
        fact("Step", with_unit(plan.step, "s")),
        fact("Reason for the step", reason),
        fact("Steps", count(plan.steps)),
        fact("Simulated time", with_unit(plan.duration(), "s")),
        fact("Scheme of our DEM", plan.scheme.key()),
        fact("Seed", model.seed.to_string()),
    ];
    if !plan.ledger {
        facts.push(fact("Energy ledger", "off: what contacts take is not counted"));
    }
    if plan.insist {
        facts.push(fact("Caution", "the user insisted on a step above the stability limit"));
    }
    Scene {
        facts,
        has: pick(true),
        left_out: pick(false),
        materials: materials(model),
        contacts: contacts(model),
        walls: walls(model),
    }
}

fn radii(model: &Model) -> String {
    let radii = model.spheres.iter().map(|sphere| sphere.radius);
    let least = radii.clone().fold(f64::INFINITY, f64::min);
    let most = radii.fold(0.0, f64::max);
    if least >= most {
        return with_unit(most, "m");
    }
    format!("{} to {}", with_unit(least, "m"), with_unit(most, "m"))
}

fn materials(model: &Model) -> Table {
    Table {
        columns: texts(&["material", "density, kg/m³"]),
        rows: model
            .materials
            .iter()
            .map(|material| {
                let known = material.density > 0.0;
                let density = if known { significant(material.density, 5) } else { "–".into() };
                vec![material.name.clone(), density]
            })
            .collect(),
    }
}

fn contacts(model: &Model) -> Table {
    let materials = model.materials.len();
    let of_bodies = |index: usize| model.bodies.iter().any(|b| usize::from(b.material) == index);
    let used: Vec<bool> = (0..materials).map(of_bodies).collect();
    let pairs = (0..materials).flat_map(|a| (a..materials).map(move |b| (a, b)));
    // Walls never touch walls.
    let pairs = pairs.filter(|(a, b)| used[*a] || used[*b]);
    Table {
        columns: texts(&["pair", "kn, N/m", "kt, N/m", "cn, N s/m", "ct, N s/m", "friction"]),
        rows: pairs
            .map(|(a, b)| {
                let contact = model.contacts.between(a as u16, b as u16);
                let names = format!("{} – {}", model.materials[a].name, model.materials[b].name);
                let values = [contact.kn, contact.kt, contact.cn, contact.ct, contact.friction];
                std::iter::once(names).chain(values.map(|value| significant(value, 4))).collect()
            })
            .collect(),
    }
}

fn walls(model: &Model) -> Option<Table> {
    let row = |wall: &crate::model::Wall| {
        let shape = match &wall.shape {
            WallShape::Plane { point, normal } => match wall.shape.axis_plane() {
                Some((axis, place, side)) => {
                    let (name, sign) = (["x", "y", "z"][axis], if side > 0.0 { "+" } else { "−" });
                    format!("plane {name} = {}, faces {sign}{name}", with_unit(place, "m"))
                }
                None => {
                    format!("plane through {}, normal {}", vector(point, "m"), vector(normal, ""))
                }
            },
            WallShape::Mesh { mesh } => format!("mesh of {} triangles", mesh.triangles.len()),
        };
        let motion = match &wall.motion {
            Motion::Still => "still".to_owned(),
            Motion::Translate { velocity } => format!("moves at {}", vector(velocity, "m/s")),
            Motion::Oscillate { amplitude, frequency, .. } => {
                format!("oscillates by {} at {frequency} Hz", vector(amplitude, "m"))
            }
            Motion::Servo { force, direction, .. } => {
                format!("pushes with {} along {}", with_unit(*force, "N"), vector(direction, ""))
            }
            Motion::Rotate { rate, axis, .. } => {
                format!("turns at {} rad/s about {}", significant(*rate, 4), vector(axis, ""))
            }
        };
        vec![wall.name.clone(), shape, motion, model.materials[wall.material as usize].name.clone()]
    };
    (!model.walls.is_empty()).then(|| Table {
        columns: texts(&["wall", "shape", "motion", "material"]),
        rows: model.walls.iter().map(row).collect(),
    })
}

fn grains(input: &PageInput, shrink: usize) -> Result<Option<Plain>, ReportError> {
    if input.solids.is_empty() {
        return Ok(None);
    }
    let picture = gallery::solids(input.solids, GALLERY, shrink);
    let total = input.solids.len();
    let caption =
        format!("{} of {} grains, each filling its cell.", total.min(GALLERY), count(total as u64));
    let mut table = input.shape_table.cloned().unwrap_or_else(|| shape_table(input));
    let remarks = shorten(&mut table, "grains", "shapes/shapes.csv");
    let figures = vec![Figure::picture(&picture, "Grains", &caption)?];
    Ok(Some(Plain { facts: shape_facts(input), figures, table: Some(table), remarks }))
}

/// Range and median of all grains.
fn shape_facts(input: &PageInput) -> Vec<[String; 2]> {
    let sizes: Vec<[f64; 2]> = input.solids.iter().map(size_and_sphericity).collect();
    let range = |at: usize, unit: &str| spread_of(sizes.iter().map(|size| size[at]), unit);
    vec![
        fact("Distinct grains", count(input.solids.len() as u64)),
        fact("Equivalent diameter", range(0, "m")),
        fact("Sphericity (Wadell)", range(1, "")),
    ]
}

/// Diameter of the sphere of equal volume, m, and its surface over that of the solid.
fn size_and_sphericity(solid: &crate::shape::Solid) -> [f64; 2] {
    let diameter = (6.0 * solid.mass.volume / std::f64::consts::PI).cbrt();
    [diameter, std::f64::consts::PI * diameter * diameter / solid.mesh.area()]
}

/// "9.1 mm to 12.8 mm, median 10.9 mm".
fn spread_of(values: impl Iterator<Item = f64>, unit: &str) -> String {
    let values: Vec<f64> = values.collect();
    let at = |fraction| with_unit(quantile(&values, fraction).unwrap_or(0.0), unit);
    let (least, most) = (at(0.0), at(1.0));
    if least == most { most } else { format!("{least} to {most}, median {}", at(0.5)) }
}

/// Cuts a table to what a page can hold and says where the rest is.
fn shorten(table: &mut Table, what: &str, file: &str) -> Vec<String> {
    let total = table.rows.len();
    table.rows.truncate(ROWS);
    if total <= ROWS {
        return Vec::new();
    }
    vec![format!("The first {ROWS} of {total} {what}; all of them in {file}.")]
}

fn shape_table(input: &PageInput) -> Table {
    let row = |solid: &crate::shape::Solid| {
        let [diameter, sphericity] = size_and_sphericity(solid);
        vec![
            solid.name.clone(),
            with_unit(diameter, "m"),
            significant(solid.mass.volume, 4),
            significant(sphericity, 3),
            solid.mesh.triangles.len().to_string(),
            solid.recipe.clone(),
        ]
    };
    let columns = [
        "grain",
        "equivalent diameter",
        "volume, m³",
        "sphericity (Wadell)",
        "triangles",
        "made by",
    ];
    Table { columns: texts(&columns), rows: input.solids.iter().map(row).collect() }
}

fn clumps(input: &PageInput, shrink: usize) -> Result<Option<Plain>, ReportError> {
    let real: Vec<&crate::clump::Clump> =
        input.clumps.iter().filter(|clump| clump.balls.len() > 1).collect();
    if real.is_empty() {
        return Ok(None);
    }
    let solid = |name: &str| input.solids.iter().find(|solid| solid.name == name);
    let pairs: Vec<_> =
        real.iter().filter_map(|clump| Some((solid(&clump.name)?, *clump))).collect();
    let mut figures = Vec::new();
    if !pairs.is_empty() {
        let picture = gallery::clumps(&pairs, 6, shrink);
        let caption = "Left of each pair the solid, right the clump that stands for it.";
        figures.push(Figure::picture(&picture, "Solids and their clumps", caption)?);
    }
    figures.extend(curves::fidelity(input.clumps).as_ref().and_then(Figure::chart));
    let mut table = Table {
        columns: texts(&[
            "clump",
            "spheres",
            "volume error",
            "surface distance, rms / D",
            "largest / D",
            "centroid error / D",
            "inertia error",
        ]),
        rows: worst_first(&real).into_iter().map(fidelity_row).collect(),
    };
    let mut remarks = vec!["D: equivalent-volume diameter of the solid.".to_owned()];
    if table.rows.len() > ROWS {
        let total = table.rows.len();
        table.rows.truncate(ROWS);
        remarks.push(format!(
            "The {ROWS} of {total} clumps with the largest surface distance; all of them in \
             clumps/clumps.json."
        ));
    }
    Ok(Some(Plain { facts: fidelity_facts(&real), figures, table: Some(table), remarks }))
}

/// The clumps with the largest surface distance first.
fn worst_first<'a>(clumps: &[&'a crate::clump::Clump]) -> Vec<&'a crate::clump::Clump> {
    let distance = |clump: &crate::clump::Clump| {
        clump.fidelity.as_ref().map_or(0.0, |found| found.rms_distance / found.equivalent_diameter)
    };
    let mut sorted = clumps.to_vec();
    sorted.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
    sorted
}

/// Range and median of all clumps.
fn fidelity_facts(clumps: &[&crate::clump::Clump]) -> Vec<[String; 2]> {
    let spheres = clumps.iter().map(|clump| clump.balls.len() as f64);
    let mut facts = vec![
        fact("Clumps of several spheres", count(clumps.len() as u64)),
        fact("Spheres in a clump", spread_of(spheres, "")),
    ];
    // What stands before the colon is the method, behind it what became of one clump.
    let method = |clump: &&crate::clump::Clump| clump.method.split(':').next().map(str::to_owned);
    let methods: BTreeSet<String> = clumps.iter().filter_map(method).collect();
    facts.push(fact("Made by", Vec::from_iter(methods).join("; ")));
    let known: Vec<_> = clumps.iter().filter_map(|clump| clump.fidelity.as_ref()).collect();
    if !known.is_empty() {
        let share = |value: fn(&crate::clump::Fidelity) -> f64| {
            let values: Vec<f64> = known.iter().map(|f| 100.0 * value(f).abs()).collect();
            let at = |fraction| significant(quantile(&values, fraction).unwrap_or(0.0), 2);
            format!("{} % median, {} % at most", at(0.5), at(1.0))
        };
        facts.extend([
            fact("Volume error", share(|f| f.volume_error)),
            fact("Surface distance (rms) / D", share(|f| f.rms_distance / f.equivalent_diameter)),
            fact("Inertia error", share(|f| f.inertia_error)),
        ]);
    }
    facts
}

fn fidelity_row(clump: &crate::clump::Clump) -> Vec<String> {
    let mut row = vec![clump.name.clone(), clump.balls.len().to_string()];
    match &clump.fidelity {
        Some(found) => {
            let share = |value: f64| {
                format!("{} %", significant(100.0 * value / found.equivalent_diameter, 3))
            };
            row.extend([
                per_cent(found.volume_error),
                share(found.rms_distance),
                share(found.largest_distance),
                share(found.centroid_error),
                format!("{} %", significant(100.0 * found.inertia_error, 3)),
            ]);
        }
        None => row.extend(std::iter::repeat_n("–".to_owned(), 5)),
    }
    row
}

fn packing(input: &PageInput, shrink: usize) -> Result<Option<Plain>, ReportError> {
    let Some(packing) = input.packing else { return Ok(None) };
    let measures = &packing.measures;
    let flat = input.model.is_some_and(|model| model.dimension == Dimension::Two);
    let mut facts = vec![
        fact("Outcome", packing.outcome.clone()),
        fact("Placed", count(packing.placements.len() as u64)),
        fact("Found no place", count(packing.dropped.len() as u64)),
        fact(
            "Coordination number",
            format!(
                "{} (gaps up to {})",
                significant(measures.coordination, 4),
                with_unit(measures.gap_tolerance, "m")
            ),
        ),
        fact(
            "Worst overlap",
            match measures.worst_overlap > 0.0 {
                true => format!("{} of the smaller radius", significant(measures.worst_overlap, 3)),
                false => "none".into(),
            },
        ),
    ];
    if input.model.is_none_or(|model| !model.walls.is_empty()) {
        let (porosity, error) = (measures.porosity, measures.porosity_error);
        let text = match error > 0.0 {
            true => format!("{} ± {}", significant(porosity, 4), significant(error, 2)),
            false => significant(porosity, 4),
        };
        let unit = if flat { "m²" } else { "m³" };
        let volume = significant(measures.container_volume, 4);
        facts.extend([fact("Porosity", text), fact("Container", format!("{volume} {unit}"))]);
    }
    if let Some(gap) = measures.least_gap {
        facts.push(fact("Least gap", with_unit(gap, "m")));
    }
    let mut figures = Vec::new();
    if let Some(model) = input.model {
        let picture = gallery::state(model, &start(model), 800 / shrink, 600 / shrink);
        figures.push(Figure::picture(&picture, "Packing", "Bodies at the start of the run.")?);
    }
    Ok(Some(Plain { facts, figures, ..Plain::default() }))
}

fn measures(input: &PageInput) -> Option<Plain> {
    let (verdicts, charts) = input.measures;
    let figures = charts.iter().filter_map(Figure::chart).collect();
    (!verdicts.is_empty()).then(|| Plain { facts: verdicts.to_vec(), figures, ..Plain::default() })
}

/// The model at time 0.
fn start(model: &Model) -> Frame {
    let bodies = model.initial_states();
    let none = vec![Vec3::zeros(); model.spheres.len()];
    Frame {
        step: 0,
        time: 0.0,
        centres: model.sphere_centres(&bodies),
        velocities: none.clone(),
        spins: none.clone(),
        forces: none,
        bodies,
    }
}

fn outcome(run: &Run) -> String {
    match &run.outcome {
        Outcome::Finished => "finished".into(),
        Outcome::Cancelled { step } => format!("stopped by the user at step {step}"),
        Outcome::Stopped { time, reason, .. } => {
            format!("stopped at t = {}: {reason}", with_unit(*time, "s"))
        }
        Outcome::Failed { reason } => format!("failed: {reason}"),
    }
}

fn run(run: &Run, own: Option<&Statistics>) -> Plain {
    let mut facts = vec![fact("Solver", run.solver.clone()), fact("Outcome", outcome(run))];
    if let Some(last) = run.series.last() {
        let worst = run.series.iter().map(|row| row.worst_overlap).fold(0.0, f64::max);
        facts.extend([
            fact("Kinetic energy at the end", with_unit(last.kinetic, "J")),
            fact("Contacts at the end", count(last.contacts)),
            fact("Sphere contacts of a body at the end", significant(last.coordination, 4)),
            fact(
                "Worst overlap at any time",
                format!("{} of the smaller radius", significant(worst, 3)),
            ),
        ]);
    }
    let mut figures = Vec::new();
    if !run.series.is_empty() {
        figures.extend(Figure::chart(&curves::energies(&run.series)));
        figures.extend(Figure::chart(&curves::energy_error(&run.series)));
    }
    let table = own.map(|own| Table {
        columns: texts(&["quantity", "mean", "standard error over time"]),
        rows: own
            .means
            .iter()
            .filter(|mean| mean.value != 0.0)
            .map(|mean| {
                let unit = mean.quantity.unit();
                let [value, error] = [mean.value, mean.time_error].map(|v| with_unit(v, unit));
                vec![mean.quantity.name().to_owned(), value, error]
            })
            .collect(),
    });
    let remarks = own.map(span).into_iter().collect();
    Plain { facts, figures, table, remarks }
}

fn finals(input: &PageInput, runs: &[&Run], shrink: usize) -> Result<Option<Plain>, ReportError> {
    let Some(model) = input.model else { return Ok(None) };
    let fits = |frame: &&Frame| frame.centres.len() == model.spheres.len();
    let shown: Vec<(&str, &Frame)> = runs
        .iter()
        .filter_map(|run| Some((run.solver.as_str(), run.frames.last().filter(fits)?)))
        .collect();
    let frames: Vec<&Frame> = shown.iter().map(|(_, frame)| *frame).collect();
    let pictures = gallery::states(model, &frames, 560 / shrink, 420 / shrink);
    let mut figures = Vec::new();
    for ((solver, frame), picture) in shown.iter().zip(&pictures) {
        let caption = format!("t = {}", with_unit(frame.time, "s"));
        figures.push(Figure::picture(picture, solver, &caption)?);
    }
    let several = figures.len() > 1;
    let remarks = several
        .then(|| "The same body has the same colour everywhere.".to_owned())
        .into_iter()
        .collect();
    Ok((!figures.is_empty()).then(|| Plain { figures, remarks, ..Plain::default() }))
}

fn trajectories(input: &PageInput, runs: &[&Run], own: Option<&Statistics>) -> Option<Plain> {
    let mut figures = Vec::new();
    if let Some(model) = input.model {
        if !model.walls.is_empty() {
            figures.extend(Figure::chart(&curves::heights(model, runs)));
        }
        figures.extend(Figure::chart(&curves::kinetic(model, runs)));
    }
    let mut table = None;
    if let (Some(own), Some(ours)) = (own.filter(|own| !own.forces.is_empty()), input.ours) {
        figures.extend(Figure::chart(&curves::forces(&[(ours.solver.as_str(), own)])));
    }
    if let Some(found) = input.comparison {
        figures.extend(Figure::chart(&curves::divergence(found)));
        let sides = std::iter::once(&found.ours).chain(found.others.iter().map(|o| &o.side));
        let sides: Vec<_> = sides
            .filter_map(|side| Some((side.solver.as_str(), side.statistics.as_ref()?)))
            .filter(|(_, statistics)| !statistics.forces.is_empty())
            .collect();
        figures.extend(Figure::chart(&curves::forces(&sides)));
        table = divergence_table(found);
    }
    (!figures.is_empty()).then(|| Plain { figures, table, ..Plain::default() })
}

fn divergence_table(found: &Comparison) -> Option<Table> {
    let row = |solver: &str, against: String, t: &Trajectory| {
        let time = |value: Option<f64>| value.map_or("–".into(), |value| with_unit(value, "s"));
        let worst = t.worst.as_ref();
        vec![
            solver.to_owned(),
            against,
            time(t.agrees_until),
            time(t.leaves_at),
            worst.map_or("–".into(), |point| significant(point.largest, 3)),
            worst.map_or("–".into(), |point| significant(point.rms, 3)),
            worst.map_or("–".into(), |point| with_unit(point.largest_velocity, "m/s")),
            time(t.growth_time),
        ]
    };
    let rows: Vec<_> = found
        .others
        .iter()
        .flat_map(|other| {
            let name = other.side.solver.as_str();
            let twin = other
                .twin
                .as_ref()
                .map(|twin| row(name, format!("our DEM as {}", twin.scheme), &twin.trajectory));
            twin.into_iter().chain([row(name, found.ours.solver.clone(), &other.against_ours)])
        })
        .collect();
    let columns = [
        "solver",
        "against",
        "comparable until",
        "parts at",
        "worst distance, smallest radii",
        "rms then",
        "worst velocity difference then",
        "e-fold time",
    ];
    (!rows.is_empty()).then(|| Table { columns: texts(&columns), rows })
}

fn cost(runs: &[&Run]) -> Option<Plain> {
    if runs.is_empty() {
        return None;
    }
    let row = |run: &&Run| {
        let cost = &run.cost;
        vec![
            run.solver.clone(),
            match cost.cpu_seconds > 0.0 {
                true => with_unit(cost.cpu_seconds, "s"),
                false => "< 10 ms".into(),
            },
            with_unit(cost.wall_seconds, "s"),
            cost.loop_seconds.map_or("–".into(), |seconds| with_unit(seconds, "s")),
            count(cost.steps),
            cost.speed().map_or("–".into(), |speed| count(speed.round() as u64)),
            cost.peak_bytes.map_or("–".into(), bytes),
            outcome(run),
        ]
    };
    let columns = [
        "solver",
        "CPU",
        "wall",
        "time loop",
        "steps",
        "sphere-steps per second",
        "peak memory",
        "outcome",
    ];
    let table = Table { columns: texts(&columns), rows: runs.iter().map(row).collect() };
    let figures = Figure::bars(&curves::cpu(runs)).into_iter().collect();
    Some(Plain { figures, table: Some(table), ..Plain::default() })
}

fn notes(runs: &[&Run]) -> Vec<Note> {
    runs.iter()
        .filter(|run| !run.notes.is_empty())
        .map(|run| Note { solver: run.solver.clone(), sentences: run.notes.clone() })
        .collect()
}
