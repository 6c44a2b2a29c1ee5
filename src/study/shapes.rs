//! Shapes: how loosely and how densely each packs by which method, beside published solid fractions; and
//! what the method of control points depends on.
//!
//! Every shape has a true surface and a clump. Compression by our own DEM takes the clump (frictionless: the dense
//! end; friction 1: the loose end; solid fraction from the united volume of the clump), digital packing and control
//! points the true surface (solid fraction of the core). References are for the true shapes.

use super::{Effort, StudyError, go_on, models, timed};
use crate::clump::{self, Axial, Clump, Fitted, MassSource, Method};
use crate::dem;
use crate::geometry::region::Rectangle;
use crate::geometry::{Bounds, Mesh, Primitive, Region};
use crate::num::units::{Length, Pressure};
use crate::num::{Job, Vec3};
use crate::pack::compression::{Compression, Until};
use crate::pack::control_points::{ControlPoints, Vibration};
use crate::pack::digital::Digital;
use crate::pack::random::Test;
use crate::pack::walk::Insertion;
use crate::pack::{self, Grain, penetration};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Findings, Sheet};
use crate::shape::Solid;
use std::f64::consts::{PI, TAU};

/// A shape of equivalent diameter 1 m.
struct Form {
    name: &'static str,
    solid: Solid,
    clump: Clump,
    /// Published solid fractions: loose, dense; NaN where none is known to us.
    known: [f64; 2],
    source: &'static str,
}

/// One packing.
struct Row {
    shape: &'static str,
    body: String,
    method: &'static str,
    grains: usize,
    fraction: f64,
    error: f64,
    contacts: f64,
    known: [f64; 2],
    source: &'static str,
    seconds: f64,
    outcome: String,
}

/// One packing by control points with one thing changed.
struct Influence {
    shape: &'static str,
    what: &'static str,
    value: f64,
    whole: f64,
    seconds: f64,
}

/// See [`super::STUDIES`].
pub fn study(effort: Effort, job: &Job) -> Result<Findings, StudyError> {
    let full = effort == Effort::Full;
    let mut rows = Vec::new();
    for form in forms(full, job)? {
        for friction in [0.0, 1.0] {
            go_on(job)?;
            rows.push(compressed(&form, friction, if full { 150 } else { 40 }, job)?);
        }
        if full {
            go_on(job)?;
            rows.push(digital(&form, job)?);
            go_on(job)?;
            rows.push(by_points(&form, job)?);
        }
    }
    let mut influences = Vec::new();
    for form in forms(full, job)?.iter().filter(|form| ["sphere", "cube"].contains(&form.name)) {
        influences.extend(influence(form, full, job)?);
    }
    Ok(findings(&rows, &influences))
}

fn forms(full: bool, job: &Job) -> Result<Vec<Form>, StudyError> {
    let fitted = |spheres| Method::Fitted(Fitted { spheres, ..Fitted::default() });
    let axial = |spheres| Method::Axial(Axial { spheres, ..Axial::default() });
    let baker = "Baker & Kudrolli 2010 (with friction)";
    let cube = Primitive::Box { edges: Vec3::repeat(1.0) }.mesh(4);
    let ellipsoid = Primitive::Ellipsoid { axes: Vec3::new(1.25, 1.0, 0.8) }.mesh(48);
    let unknown = f64::NAN;
    let mut list = vec![
        (
            "sphere",
            lathe(&arc(0.0, 0.0), 48),
            fitted(1),
            [0.55, 0.64],
            "Onoda & Liniger 1990; random close packing",
        ),
        (
            "dimer 1.4",
            lathe(&arc(0.4, 0.0), 48),
            fitted(2),
            [unknown, 0.70],
            "Baule et al. 2013: at most 0.707",
        ),
    ];
    if full {
        list.extend([
            (
                "spherocylinder 1.5",
                lathe(&arc(0.0, 0.5), 48),
                axial(9),
                [unknown, 0.721],
                "PMC10405222: largest, L/D 0.45",
            ),
            (
                "ellipsoid 1.25:1:0.8",
                ellipsoid,
                fitted(16),
                [unknown, 0.735],
                "Man et al. 2005 (frictionless)",
            ),
            ("cube", cube, fitted(32), [0.54, 0.67], baker),
            ("tetrahedron", tetrahedron(), fitted(32), [0.51, 0.64], baker),
        ]);
    }
    let mut found = Vec::new();
    for (name, mesh, method, known, source) in list {
        go_on(job)?;
        let unit = mesh.mass_properties().equivalent_diameter();
        let centre = mesh.mass_properties().centroid;
        let mesh = mesh.mapped(|point| (point - centre) / unit);
        let mass = mesh.mass_properties();
        let solid = Solid { name: name.to_owned(), mesh, mass, recipe: name.to_owned() };
        let clump = match name {
            "sphere" => clump::sphere(name, 0.5),
            _ => clump::reproduce(&solid, &method, MassSource::Union, 1, 0, job)
                .map_err(|error| StudyError::Work(error.to_string()))?,
        };
        found.push(Form { name, solid, clump, known, source });
    }
    Ok(found)
}

/// Half a section (z, r) of one sphere of radius 0.5, of two with centres `apart`, or of one drawn out by `length`.
fn arc(apart: f64, length: f64) -> Vec<(f64, f64)> {
    let steps = 24;
    // Where the two spheres of a dimer meet.
    let from = (0.5 * apart / 0.5_f64).asin();
    let half: Vec<(f64, f64)> = (0..=steps)
        .map(|i| -from + (0.5 * PI + from) * f64::from(i) / f64::from(steps))
        .map(|angle| (0.5 * (apart + length) + 0.5 * angle.sin(), 0.5 * angle.cos().max(0.0)))
        .collect();
    let other = half.iter().rev().map(|&(z, r)| (-z, r));
    // Of rings that both halves have, one stays.
    let skip = usize::from(length == 0.0);
    other.chain(half.iter().copied().skip(skip)).collect()
}

/// The closed surface that a half section (z rising, r = 0 at both ends) sweeps.
fn lathe(section: &[(f64, f64)], sectors: u32) -> Mesh {
    let rings = &section[1..section.len() - 1];
    let mut vertices = vec![Vec3::new(0.0, 0.0, section[0].0)];
    for &(z, r) in rings {
        vertices.extend((0..sectors).map(|k| {
            let angle = TAU * f64::from(k) / f64::from(sectors);
            Vec3::new(r * angle.cos(), r * angle.sin(), z)
        }));
    }
    vertices.push(Vec3::new(0.0, 0.0, section[section.len() - 1].0));
    let top = vertices.len() as u32 - 1;
    let at = |ring: u32, k: u32| 1 + ring * sectors + k % sectors;
    let last = rings.len() as u32 - 1;
    let mut triangles = Vec::new();
    for k in 0..sectors {
        triangles.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..last {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(last, k), at(last, k + 1), top]);
    }
    Mesh { vertices, triangles }
}

fn tetrahedron() -> Mesh {
    let corner = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let vertices = vec![
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ];
    Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]] }
}

/// The clump compressed by the DEM in a periodic box.
fn compressed(form: &Form, friction: f64, count: usize, job: &Job) -> Result<Row, StudyError> {
    let start = 0.2;
    let model = models::loose_clumps(&form.clump, count, start, friction, job)
        .map_err(|error| StudyError::Work(error.to_string()))?;
    let wanted = Compression {
        // Overlaps of about 1e-4 of the radius.
        until: Until::Stress(Pressure(25.0)),
        friction,
        tolerance: 0.1,
        ..Compression::default()
    };
    let (done, seconds) = timed(|| dem::compress(&model, 1.0, start, &wanted, job));
    let done = done.map_err(|error| StudyError::Work(error.to_string()))?;
    Ok(Row {
        shape: form.name,
        body: format!("clump of {}", form.clump.balls.len()),
        method: if friction > 0.0 { "compression, friction 1" } else { "compression, friction 0" },
        grains: count,
        fraction: start * done.scale.powi(3),
        error: 0.0,
        contacts: done.coordination,
        known: form.known,
        source: form.source,
        seconds,
        outcome: done.outcome,
    })
}

/// A box with walls and a floor, in diameters.
fn room(width: f64, height: f64) -> Region {
    Region::Box(Rectangle {
        bounds: Bounds { low: Vec3::zeros(), high: Vec3::new(width, width, height) },
        dimension: 3,
        open: [[false; 2]; 3],
        periodic: [false; 3],
    })
}

/// Packs the true shape and looks at it independently of the method.
fn placed(
    form: &Form,
    count: usize,
    room: &Region,
    method: &pack::Method,
    job: &Job,
) -> Result<(pack::Packing, penetration::Report), StudyError> {
    let grain = Grain { clump: &form.clump, solid: Some(&form.solid), family: 0 };
    let grains = vec![grain; count];
    let packing = pack::pack(&grains, &[form.name], room, method, 1, job)
        .map_err(|error| StudyError::Work(error.to_string()))?;
    let report = penetration::check(&packing.placements, &grains, test(form), room, 1);
    Ok((packing, report))
}

/// A sphere is exact by itself, everything else is its surface.
fn test(form: &Form) -> Test {
    if form.clump.balls.len() == 1 { Test::Clump } else { Test::Solid }
}

fn digital(form: &Form, job: &Job) -> Result<Row, StudyError> {
    let method = pack::Method::Digital(Digital {
        test: test(form),
        rebound: 0.4,
        turning: 0.3,
        sweeps: 6000,
        settled: 0.02,
        ..Digital::default()
    });
    core_row(form, "digital", 350, &room(7.0, 12.0), &method, job)
}

fn points_of(form: &Form) -> ControlPoints {
    ControlPoints {
        points: 1500,
        distance: Some(Length(0.06)),
        inset: Length(0.03),
        test: test(form),
        ..ControlPoints::default()
    }
}

fn by_points(form: &Form, job: &Job) -> Result<Row, StudyError> {
    let method = pack::Method::ControlPoints(points_of(form));
    core_row(form, "control points", 300, &room(7.0, 12.0), &method, job)
}

fn core_row(
    form: &Form,
    name: &'static str,
    count: usize,
    room: &Region,
    method: &pack::Method,
    job: &Job,
) -> Result<Row, StudyError> {
    let (done, seconds) = timed(|| placed(form, count, room, method, job));
    let (packing, report) = done?;
    let (fraction, error) = report.core.unwrap_or((f64::NAN, f64::NAN));
    Ok(Row {
        shape: form.name,
        body: "true shape".into(),
        method: name,
        grains: packing.placements.len(),
        fraction,
        error,
        contacts: f64::NAN,
        known: form.known,
        source: form.source,
        seconds,
        outcome: packing.outcome,
    })
}

/// Control points with one thing changed at a time: insertion rate, manner of insertion, boundary, gravity, vibration.
fn influence(form: &Form, full: bool, job: &Job) -> Result<Vec<Influence>, StudyError> {
    let base = points_of(form);
    let mut list = vec![("base", f64::NAN, base.clone(), 7.0)];
    let shaken = |moves| Vibration { moves, probability: 0.05 };
    if full {
        for rate in [1, 10, 1000] {
            list.push((
                "insertion rate [1/sweep]",
                f64::from(rate),
                ControlPoints { rate, ..base.clone() },
                7.0,
            ));
        }
        let rain = ControlPoints { insertion: Insertion::Top, ..base.clone() };
        list.push(("insertion from the top", f64::NAN, rain, 7.0));
        for width in [4.0, 5.0, 10.0] {
            list.push(("width of the box [diameters]", width, base.clone(), width));
        }
        for gravity in [0.3, 3.0] {
            list.push(("gravity bias", gravity, ControlPoints { gravity, ..base.clone() }, 7.0));
        }
        for moves in [0, 2, 12] {
            let vibration = shaken(moves);
            list.push((
                "moves of a burst",
                f64::from(moves),
                ControlPoints { vibration, ..base.clone() },
                7.0,
            ));
        }
    } else {
        list.push(("moves of a burst", 0.0, ControlPoints { vibration: shaken(0), ..base }, 7.0));
    }
    let mut found = Vec::new();
    for (what, value, parameters, width) in list {
        go_on(job)?;
        // As high as the others: as many grains over the ground.
        let count = (if full { 300.0 } else { 100.0 } * (width / 7.0_f64).powi(2)).round() as usize;
        let method = pack::Method::ControlPoints(parameters);
        let (done, seconds) = timed(|| placed(form, count, &room(width, 12.0), &method, job));
        let (packing, _) = done?;
        found.push(Influence {
            shape: form.name,
            what,
            value,
            whole: between_quartiles(form, &packing, width),
            seconds,
        });
    }
    Ok(found)
}

/// Solid fraction from wall to wall between the heights that a quarter and three quarters of the centres lie below.
fn between_quartiles(form: &Form, packing: &pack::Packing, width: f64) -> f64 {
    let mut heights: Vec<f64> = packing.placements.iter().map(|laid| laid.position.z).collect();
    heights.sort_by(f64::total_cmp);
    let count = heights.len();
    let (low, high) = (heights[count / 4], heights[3 * count / 4]);
    let volume = if test(form) == Test::Solid { form.solid.mass.volume } else { form.clump.volume };
    (3 * count / 4 - count / 4) as f64 * volume / (width * width * (high - low))
}

fn findings(rows: &[Row], influences: &[Influence]) -> Findings {
    let mut charts = vec![("shapes".to_owned(), chart(rows))];
    if influences.len() > 6 {
        charts.push(("control-points".to_owned(), influence_chart(influences)));
    }
    Findings {
        title: "How loosely and how densely shapes pack".into(),
        question: "Which solid fraction does each method reach with each shape, beside published loose and dense values; and what does packing by control points depend on?".into(),
        remarks: remarks(rows),
        tables: vec![sheet(rows), influence_sheet(influences)],
        charts,
        pictures: Vec::new(),
    }
}

/// One line a shape: from its loosest to its densest packing.
fn remarks(rows: &[Row]) -> Vec<String> {
    let mut shapes: Vec<&str> = rows.iter().map(|row| row.shape).collect();
    shapes.dedup();
    let line = |shape: &str| {
        let mut mine: Vec<&Row> = rows.iter().filter(|row| row.shape == shape).collect();
        mine.sort_by(|a, b| a.fraction.total_cmp(&b.fraction));
        let (loosest, densest) = (mine.first()?, mine.last()?);
        Some(format!(
            "{shape}: solid fraction {:.3} ({}) to {:.3} ({}).",
            loosest.fraction, loosest.method, densest.fraction, densest.method
        ))
    };
    shapes.into_iter().filter_map(line).collect()
}

fn sheet(rows: &[Row]) -> Sheet {
    let columns = [
        "shape",
        "body",
        "method",
        "grains",
        "solid fraction",
        "standard error",
        "contacts a grain",
        "published loose",
        "published dense",
        "source",
        "CPU [s]",
        "how it ended",
    ];
    Sheet {
        key: "shapes".into(),
        title: "Solid fractions by shape and method".into(),
        caption: "One seed. Compression: all of a periodic box. Others: the core, two diameters off the walls. Contacts: other grains touched, without rattlers (friction 0), without grains of one contact (friction 1).".into(),
        columns: columns.map(String::from).to_vec(),
        rows: rows
            .iter()
            .map(|row| {
                vec![
                    row.shape.into(),
                    row.body.clone().into(),
                    row.method.into(),
                    (row.grains as u64).into(),
                    row.fraction.into(),
                    row.error.into(),
                    row.contacts.into(),
                    row.known[0].into(),
                    row.known[1].into(),
                    row.source.into(),
                    row.seconds.into(),
                    row.outcome.split([':', ';']).next().unwrap_or_default().into(),
                ]
            })
            .collect(),
    }
}

fn influence_sheet(influences: &[Influence]) -> Sheet {
    let columns = ["shape", "changed", "to", "solid fraction", "CPU [s]"];
    Sheet {
        key: "control-points".into(),
        title: "What packing by control points depends on".into(),
        caption: "Base: 300 grains, 1 500 points, d = 0.06 diameters, points d/2 below the surface, 100 insertions a sweep anywhere, box 7 diameters wide, gravity bias 1, bursts of 4 moves. Solid fraction from wall to wall between the quartiles of the heights: walls lower it.".into(),
        columns: columns.map(String::from).to_vec(),
        rows: influences
            .iter()
            .map(|one| {
                vec![
                    one.shape.into(),
                    one.what.into(),
                    one.value.into(),
                    one.whole.into(),
                    one.seconds.into(),
                ]
            })
            .collect(),
    }
}

/// Shapes along x, a series a method.
fn chart(rows: &[Row]) -> Chart {
    let mut names: Vec<&str> = rows.iter().map(|row| row.shape).collect();
    names.dedup();
    let place =
        |shape: &str| names.iter().position(|name| *name == shape).unwrap_or(0) as f64 + 1.0;
    let mut series: Vec<Series> = Vec::new();
    for row in rows.iter().filter(|row| row.fraction.is_finite()) {
        let point = (place(row.shape), row.fraction);
        match series.iter_mut().find(|one| one.name == row.method) {
            Some(one) => one.points.push(point),
            None => {
                series.push(Series { name: row.method.into(), points: vec![point], dots: true })
            }
        }
    }
    for (index, name) in ["published loose", "published dense"].into_iter().enumerate() {
        let mut points: Vec<(f64, f64)> =
            rows.iter().map(|row| (place(row.shape), row.known[index])).collect();
        points.dedup();
        points.retain(|point| point.1.is_finite());
        series.push(Series { name: name.into(), points, dots: true });
    }
    let list: Vec<String> =
        names.iter().enumerate().map(|(index, name)| format!("{} {name}", index + 1)).collect();
    Chart {
        title: "Solid fraction by shape".into(),
        caption: format!("Shapes: {}.", list.join(", ")),
        x: Axis::linear("shape", ""),
        y: Axis::linear("solid fraction", ""),
        series,
        mark: None,
    }
}

/// Change of the solid fraction from the base, numbered along x.
fn influence_chart(influences: &[Influence]) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    let mut labels: Vec<String> = Vec::new();
    let mut base = f64::NAN;
    for one in influences {
        if one.what == "base" {
            base = one.whole;
            continue;
        }
        let value = if one.value.is_finite() { format!(" {}", one.value) } else { String::new() };
        let label = format!("{}{value}", one.what);
        let place = labels.iter().position(|known| *known == label).unwrap_or_else(|| {
            labels.push(label);
            labels.len() - 1
        });
        let point = (place as f64 + 1.0, one.whole - base);
        match series.iter_mut().find(|known| known.name == one.shape) {
            Some(known) => known.points.push(point),
            None => series.push(Series { name: one.shape.into(), points: vec![point], dots: true }),
        }
    }
    let list: Vec<String> =
        labels.iter().enumerate().map(|(index, label)| format!("{} {label}", index + 1)).collect();
    Chart {
        title: "Control points: change of the solid fraction when one thing changes".into(),
        caption: format!("{}.", list.join("; ")),
        x: Axis::linear("change", ""),
        y: Axis::linear("solid fraction − base", ""),
        series,
        mark: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_sweep_closed_bodies_of_the_right_volume() {
        let lens = |h: f64| PI * h * h * (1.5 - h) / 3.0;
        let ball = PI / 6.0;
        for (mesh, volume) in [
            (lathe(&arc(0.0, 0.0), 96), ball),
            // Two spheres less the two caps in which they lie in each other.
            (lathe(&arc(0.4, 0.0), 96), 2.0 * ball - 2.0 * lens(0.3)),
            (lathe(&arc(0.0, 0.5), 96), ball + PI / 4.0 * 0.5),
        ] {
            assert!(crate::geometry::check::solid(mesh.clone()).is_ok());
            let found = mesh.mass_properties().volume;
            assert!((found / volume - 1.0).abs() < 5e-3, "{found} {volume}");
        }
        assert!(tetrahedron().mass_properties().volume > 0.0);
    }
}
