//! Measuring spheres, layers, radial distribution and local porosity of any file of spheres (P18), as tables
//! and charts: packings and frames of our own, dumps and tables of other codes.

use super::measuring;
use super::road::RoadError;
use crate::format::{self, Data, FormatError, Particles};
use crate::geometry::Bounds;
use crate::num::Vec3;
use crate::num::statistics::{mean, median};
use crate::pack::radial::radial;
use crate::pack::survey::{layers, measure, whole};
use crate::pack::{Bed, Probe, Push, Reading, Spheres};
use crate::report::chart::{Axis, Chart, Series};
use crate::report::findings::{Cell, Findings, Sheet};
use std::path::{Path, PathBuf};

/// What to measure of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// Measuring spheres (circles): middle and radius, m.
    pub probes: Vec<(Vec3, f64)>,
    /// 2 for discs, 3 for spheres.
    pub dimension: usize,
    /// The container, m; default: the box in the file, or that around all spheres.
    pub room: Option<Bounds>,
    /// Axes along which it repeats.
    pub periodic: [bool; 3],
    /// Gap up to which bodies touch, m; default 1e-6 of the median radius.
    pub gap: Option<f64>,
    /// File of contact forces, as `run/contacts.csv`.
    pub contacts: Option<PathBuf>,
    /// Stiffness of springs that forces are computed with from overlaps, N/m.
    pub stiffness: Option<f64>,
    /// Number of layers along the last axis.
    pub layers: usize,
    /// Local porosity: measuring spheres of this radius (m) side by side through the room.
    pub field: Option<f64>,
}

impl Default for Survey {
    fn default() -> Self {
        Self {
            probes: Vec::new(),
            dimension: 3,
            room: None,
            periodic: [false; 3],
            gap: None,
            contacts: None,
            stiffness: None,
            layers: 20,
            field: None,
        }
    }
}

/// Gap up to which two bodies count as touching, over the median radius.
const GAP: f64 = 1e-6;
/// Measuring spheres of a field at most.
const MOST: usize = 200_000;

/// Measures the spheres in the file at `path`; of `packing.csv` those in `packing.vtp` beside it.
///
/// # Errors
/// [`RoadError::Format`] for files that cannot be read or hold no spheres; forces of spheres that are not there.
pub fn survey(path: &Path, wanted: &Survey) -> Result<Findings, RoadError> {
    let path = format::spheres_beside(path);
    let Data::Particles(table) = format::read(&path)? else {
        return Err(FormatError::file(&path, "holds a surface, no spheres").into());
    };
    if table.is_empty() {
        return Err(FormatError::file(&path, "holds no spheres").into());
    }
    let bed = bed(&table.sorted_by_id(), wanted)?;
    let mut found = findings(&bed, wanted);
    found.title = format!("Measures of {}", path.display());
    Ok(found)
}

fn bed(table: &Particles, wanted: &Survey) -> Result<Bed, RoadError> {
    let body = match &table.bodies {
        Some(bodies) => measuring::numbered(bodies),
        None => (0..table.len() as u32).collect(),
    };
    let pushes = match &wanted.contacts {
        Some(file) => read_pushes(file, table.len())?,
        None => Vec::new(),
    };
    let spheres = Spheres {
        centres: table.positions.clone(),
        radii: table.radii.clone(),
        body,
        dimension: wanted.dimension,
        room: wanted.room.or(table.bounds),
        periodic: wanted.periodic,
        pushes,
    };
    let gap = wanted.gap.unwrap_or_else(|| GAP * median(&table.radii).unwrap_or(0.0));
    let bed = Bed::new(spheres, gap);
    let Some(stiffness) = wanted.stiffness.filter(|_| wanted.contacts.is_none()) else {
        return Ok(bed);
    };
    let pushes = bed
        .contacts
        .iter()
        .filter(|contact| contact.gap < 0.0)
        .map(|contact| Push {
            first: contact.first,
            second: Some(contact.second),
            point: contact.point,
            force: contact.normal * (-contact.gap * stiffness),
        })
        .collect();
    Ok(Bed::new(Spheres { pushes, ..bed.spheres }, gap))
}

/// First line of a file of contact forces: spheres by their numbers, second empty at a wall.
pub const CONTACTS: &str = "first,second,x,y,z,fx,fy,fz";

/// Writes contact forces.
pub fn write_pushes(out: &mut dyn std::io::Write, pushes: &[Push]) -> std::io::Result<()> {
    writeln!(out, "{CONTACTS}")?;
    for push in pushes {
        let second = push.second.map(|sphere| sphere.to_string()).unwrap_or_default();
        write!(out, "{},{second}", push.first)?;
        for value in push.point.iter().chain(&push.force) {
            write!(out, ",{}", format::number(*value))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn read_pushes(path: &Path, spheres: usize) -> Result<Vec<Push>, RoadError> {
    let text = std::fs::read_to_string(path).map_err(|e| FormatError::io(path, "read", e))?;
    let mut lines = text.lines();
    if lines.next() != Some(CONTACTS) {
        return Err(
            FormatError::line(path, 1, format!("the first line is not `{CONTACTS}`")).into()
        );
    }
    let parsed = |line: &str| {
        let mut fields = line.split(',');
        let sphere = |text: &str| text.parse::<u32>().ok().filter(|s| (*s as usize) < spheres);
        let first = sphere(fields.next()?)?;
        let second = match fields.next()? {
            "" => None,
            text => Some(sphere(text)?),
        };
        let numbers: Vec<f64> = fields.map(str::parse).collect::<Result<_, _>>().ok()?;
        let good = numbers.len() == 6 && numbers.iter().all(|x| x.is_finite());
        let vector = |at: usize| Vec3::new(numbers[at], numbers[at + 1], numbers[at + 2]);
        good.then(|| Push { first, second, point: vector(0), force: vector(3) })
    };
    lines
        .enumerate()
        .map(|(row, line)| {
            parsed(line).ok_or_else(|| {
                let problem =
                    format!("is no contact of two of {spheres} spheres, or of one and a wall");
                FormatError::line(path, row + 2, problem).into()
            })
        })
        .collect()
}

fn findings(bed: &Bed, wanted: &Survey) -> Findings {
    let all = whole(bed);
    let probes: Vec<(Vec3, f64, Reading)> = wanted
        .probes
        .iter()
        .map(|&(at, radius)| (at, radius, measure(bed, &Probe::Ball { at, radius })))
        .collect();
    let axis = wanted.dimension - 1;
    let layers = layers(bed, axis, wanted.layers.max(1));
    let diameter = 2.0 * mean(&bed.spheres.radii).unwrap_or(0.0);
    let size = bed.room.size();
    let shortest = (0..wanted.dimension).map(|a| size[a]).fold(f64::INFINITY, f64::min);
    let reach = (4.0 * diameter).min(0.5 * shortest);
    let shells = radial(bed, reach, 200);
    let field = field(bed, wanted);
    let mut tables = vec![whole_sheet(bed, &all)];
    if !probes.is_empty() {
        tables.push(readings_sheet("spheres", "Measuring spheres", &rows_of(&probes)));
    }
    let heights: Vec<_> = layers.iter().map(|(h, r)| (vec![Cell::Number(*h)], *r)).collect();
    tables.push(readings_sheet("layers", "Layers", &(vec!["height [m]"], heights)));
    tables.push(radial_sheet(&shells, diameter));
    tables.push(partners_sheet(bed));
    if !field.is_empty() {
        tables.push(readings_sheet("field", "Local measures", &rows_of(&field)));
    }
    Findings {
        title: String::new(),
        question: format!(
            "Porosity of the united spheres, coordination numbers (gap up to {:.3e} m), fabric, stress (compression \
             positive) and radial distribution of {} spheres of {} bodies in a box of {:.4e} by {:.4e} by {:.4e} m.",
            bed.tolerance,
            bed.spheres.radii.len(),
            bed.bodies.len(),
            size.x,
            size.y,
            size.z
        ),
        remarks: remarks(&all, &probes),
        tables,
        charts: charts(&layers, &shells, diameter, bed),
        pictures: Vec::new(),
    }
}

type Rows = (Vec<&'static str>, Vec<(Vec<Cell>, Reading)>);

fn rows_of(probes: &[(Vec3, f64, Reading)]) -> Rows {
    let rows = probes.iter().map(|(at, radius, reading)| {
        (vec![at.x.into(), at.y.into(), at.z.into(), (*radius).into()], *reading)
    });
    (vec!["x [m]", "y [m]", "z [m]", "radius [m]"], rows.collect())
}

/// Measuring spheres of radius `wanted.field` in a square grid through the room.
fn field(bed: &Bed, wanted: &Survey) -> Vec<(Vec3, f64, Reading)> {
    let Some(radius) = wanted.field else { return Vec::new() };
    let (low, size) = (bed.room.low, bed.room.size());
    let count = |axis: usize| match axis < wanted.dimension {
        true => (size[axis] / (2.0 * radius)).floor().max(1.0) as usize,
        false => 1,
    };
    let counts = [count(0), count(1), count(2)];
    if counts.iter().product::<usize>() > MOST {
        return Vec::new();
    }
    let mut found = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                let mut at = Vec3::zeros();
                for (axis, index) in [x, y, z].into_iter().enumerate().take(wanted.dimension) {
                    at[axis] = low[axis] + size[axis] * (index as f64 + 0.5) / counts[axis] as f64;
                }
                found.push((at, radius, measure(bed, &Probe::Ball { at, radius })));
            }
        }
    }
    found
}

fn or_nothing(value: Option<f64>) -> Cell {
    Cell::Number(value.unwrap_or(f64::NAN))
}

fn whole_sheet(bed: &Bed, all: &Reading) -> Sheet {
    let worst = bed.contacts.iter().fold(0.0_f64, |worst, contact| {
        let (i, j) = (contact.first as usize, contact.second as usize);
        worst.max(-contact.gap / bed.spheres.radii[i].min(bed.spheres.radii[j]))
    });
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row = |name: &str, value: Cell| rows.push(vec![name.into(), value]);
    row("volume [m3]", all.volume.into());
    row("porosity", all.porosity.into());
    row("error of the porosity", all.porosity_error.into());
    row("bodies", all.bodies.into());
    row("coordination number", or_nothing(all.coordination));
    row("coordination number without rattlers", or_nothing(all.coordination_held));
    row("mechanical coordination number", or_nothing(all.coordination_mechanical));
    row("share of rattlers", or_nothing(all.rattlers));
    row("contacts", all.contacts.into());
    row("largest overlap over the smaller radius", worst.into());
    for (name, tensor) in [("fabric", all.fabric), ("stress [Pa]", all.stress)] {
        for (i, j, which) in
            [(0, 0, "xx"), (1, 1, "yy"), (2, 2, "zz"), (0, 1, "xy"), (0, 2, "xz"), (1, 2, "yz")]
        {
            if let Some(tensor) = tensor {
                row(&format!("{name} {which}"), tensor[i][j].into());
            }
        }
    }
    if all.stress.is_some() {
        row("mean stress [Pa]", or_nothing(all.mean_stress));
        row("deviator stress [Pa]", or_nothing(all.deviator));
    }
    Sheet {
        key: "whole".into(),
        title: "The whole room".into(),
        caption: "Rattlers: fewer than d + 1 contacts, taken out again and again. Mechanical: without bodies of no contact or one (Thornton 2000).".into(),
        columns: vec!["quantity".into(), "value".into()],
        rows,
    }
}

fn readings_sheet(key: &str, title: &str, (heads, rows): &Rows) -> Sheet {
    let forces = rows.iter().any(|(_, reading)| reading.stress.is_some());
    let mut columns: Vec<String> = heads.iter().map(|head| (*head).to_owned()).collect();
    let names = [
        "volume [m3]",
        "porosity",
        "error",
        "bodies",
        "coordination",
        "without rattlers",
        "mechanical",
        "contacts",
        "fabric xx",
        "fabric yy",
        "fabric zz",
    ];
    columns.extend(names.map(String::from));
    if forces {
        let names = [
            "sxx [Pa]",
            "syy [Pa]",
            "szz [Pa]",
            "sxy [Pa]",
            "sxz [Pa]",
            "syz [Pa]",
            "mean stress [Pa]",
            "deviator [Pa]",
        ];
        columns.extend(names.map(String::from));
    }
    let cells = |(head, reading): &(Vec<Cell>, Reading)| {
        let mut row = head.clone();
        row.extend([
            reading.volume.into(),
            reading.porosity.into(),
            reading.porosity_error.into(),
            Cell::Count(reading.bodies),
            or_nothing(reading.coordination),
            or_nothing(reading.coordination_held),
            or_nothing(reading.coordination_mechanical),
            Cell::Count(reading.contacts),
        ]);
        row.extend((0..3).map(|i| or_nothing(reading.fabric.map(|f| f[i][i]))));
        if forces {
            let of = |i: usize, j: usize| or_nothing(reading.stress.map(|s| s[i][j]));
            row.extend([of(0, 0), of(1, 1), of(2, 2), of(0, 1), of(0, 2), of(1, 2)]);
            row.extend([or_nothing(reading.mean_stress), or_nothing(reading.deviator)]);
        }
        row
    };
    Sheet {
        key: key.into(),
        title: title.into(),
        caption: String::new(),
        columns,
        rows: rows.iter().map(cells).collect(),
    }
}

fn radial_sheet(shells: &[(f64, f64)], diameter: f64) -> Sheet {
    Sheet {
        key: "radial".into(),
        title: "Radial distribution".into(),
        caption:
            "g(r) of the centres of bodies; shells cut by the room count with their volume inside."
                .into(),
        columns: vec!["r [m]".into(), "r over mean diameter".into(), "g".into()],
        rows: shells
            .iter()
            .map(|(r, g)| vec![(*r).into(), (r / diameter).into(), (*g).into()])
            .collect(),
    }
}

/// How many bodies touch how many others.
fn partners(bed: &Bed) -> Vec<u64> {
    let mut counts = Vec::new();
    for &partners in &bed.partners {
        let at = partners as usize;
        if counts.len() <= at {
            counts.resize(at + 1, 0);
        }
        counts[at] += 1;
    }
    counts
}

fn partners_sheet(bed: &Bed) -> Sheet {
    let rows = partners(bed).into_iter().enumerate();
    Sheet {
        key: "partners".into(),
        title: "Bodies by the number of others that they touch".into(),
        caption: String::new(),
        columns: vec!["touching".into(), "bodies".into()],
        rows: rows
            .map(|(touching, bodies)| vec![(touching as u64).into(), bodies.into()])
            .collect(),
    }
}

fn remarks(all: &Reading, probes: &[(Vec3, f64, Reading)]) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or("none".to_owned(), |z| format!("{z:.3}"));
    let said = |name: String, reading: &Reading| {
        let stress =
            reading.mean_stress.map_or(String::new(), |p| format!(", mean stress {p:.4e} Pa"));
        format!(
            "{name}: porosity {:.5} ± {:.0e}, coordination number {} ({} without rattlers){stress}.",
            reading.porosity,
            reading.porosity_error,
            number(reading.coordination),
            number(reading.coordination_held)
        )
    };
    let mut lines = vec![said("Whole room".into(), all)];
    lines.extend(probes.iter().map(|(at, radius, reading)| {
        said(
            format!("Sphere of {radius:.4e} m about ({:.4e}, {:.4e}, {:.4e})", at.x, at.y, at.z),
            reading,
        )
    }));
    lines
}

fn charts(
    layers: &[(f64, Reading)],
    shells: &[(f64, f64)],
    diameter: f64,
    bed: &Bed,
) -> Vec<(String, Chart)> {
    let series =
        |name: &str, points: Vec<(f64, f64)>, dots| Series { name: name.into(), points, dots };
    let over = |of: &dyn Fn(&Reading) -> Option<f64>| -> Vec<(f64, f64)> {
        layers.iter().filter_map(|(height, reading)| Some((*height, of(reading)?))).collect()
    };
    let height = || Axis::linear("height of the layer", "m");
    let chart = |key: &str, texts: [&str; 2], x: Axis, y: Axis, series: Vec<Series>| {
        let [title, caption] = texts.map(str::to_owned);
        (key.to_owned(), Chart { title, caption, x, y, series, mark: None })
    };
    let radial = shells.iter().map(|(r, g)| (r / diameter, *g)).collect();
    let partners = partners(bed).iter().enumerate().map(|(n, b)| (n as f64, *b as f64)).collect();
    let mut all = vec![
        chart(
            "radial",
            ["Radial distribution of centres", "1: as likely as anywhere."],
            Axis::linear("distance over mean diameter", ""),
            Axis::linear("g", ""),
            vec![series("g", radial, false)],
        ),
        chart(
            "layers-porosity",
            ["Porosity over height", "Each layer as thick as the others."],
            height(),
            Axis::linear("porosity", ""),
            vec![series("porosity", over(&|r| Some(r.porosity)), true)],
        ),
        chart(
            "layers-coordination",
            ["Coordination number over height", ""],
            height(),
            Axis::linear("bodies touched", ""),
            vec![
                series("all bodies", over(&|r| r.coordination), true),
                series("without rattlers", over(&|r| r.coordination_held), true),
            ],
        ),
        chart(
            "partners",
            ["Bodies by the number of others that they touch", ""],
            Axis::linear("others touched", ""),
            Axis::linear("bodies", ""),
            vec![series("bodies", partners, true)],
        ),
    ];
    if !bed.spheres.pushes.is_empty() {
        let component = |i: usize| over(&move |r| r.stress.map(|s| s[i][i]));
        let names = ["xx", "yy", "zz"];
        let lines = (0..bed.dimension()).map(|i| series(names[i], component(i), true)).collect();
        let texts = ["Normal stresses over height", "Compression positive."];
        all.push(chart("layers-stress", texts, height(), Axis::linear("stress", "Pa"), lines));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Particles {
        let mut positions = Vec::new();
        for x in 0..5 {
            for y in 0..5 {
                for z in 0..5 {
                    positions.push(Vec3::new(f64::from(x), f64::from(y), f64::from(z)) * 1e-3);
                }
            }
        }
        Particles { radii: vec![0.5e-3; 125], positions, ..Particles::default() }
    }

    #[test]
    fn a_file_becomes_tables_and_charts() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("cubic.csv");
        format::csv::write(&path, &table()).expect("written");
        let contacts = folder.path().join("contacts.csv");
        let push = Push {
            first: 0,
            second: Some(1),
            point: Vec3::new(0.0, 0.0, 0.5e-3),
            force: Vec3::new(0.0, 0.0, -2.0),
        };
        let mut bytes = Vec::new();
        let wall =
            Push { second: None, point: Vec3::new(0.0, 0.0, -0.5e-3), force: -push.force, ..push };
        write_pushes(&mut bytes, &[push, wall]).expect("written");
        std::fs::write(&contacts, &bytes).expect("written");
        let wanted = Survey {
            probes: vec![(Vec3::repeat(2e-3), 1.4e-3)],
            contacts: Some(contacts.clone()),
            field: Some(0.8e-3),
            ..Survey::default()
        };
        let found = survey(&path, &wanted).expect("measured");
        let keys: Vec<&str> = found.tables.iter().map(|sheet| sheet.key.as_str()).collect();
        assert_eq!(keys, ["whole", "spheres", "layers", "radial", "partners", "field"]);
        assert_eq!(found.charts.len(), 5);
        assert!(found.charts.iter().all(|(_, chart)| chart.svg().is_some()));
        let value = |name: &str| {
            let rows = &found.tables[0].rows;
            rows.iter().find(|row| row[0] == Cell::from(name)).map(|row| row[1].clone())
        };
        let Some(Cell::Number(porosity)) = value("porosity") else { panic!() };
        assert!((porosity - (1.0 - std::f64::consts::PI / 6.0)).abs() < 1e-12);
        assert_eq!(value("coordination number"), Some(Cell::Number(2.0 * 300.0 / 125.0)));
        let Some(Cell::Number(stress)) = value("stress [Pa] zz") else { panic!() };
        // 2 N over a branch of 1 mm and 2 N over half of one, in (5 mm)³.
        assert!((stress - 2.0 * 1.5e-3 / 125e-9).abs() < 1e-6, "{stress}");
        std::fs::write(&contacts, format!("{CONTACTS}\n0,125,0,0,0,0,0,0\n")).expect("written");
        let error = survey(&path, &wanted).expect_err("no such sphere").to_string();
        assert!(error.contains("line 2") && error.contains("125 spheres"), "{error}");
    }

    #[test]
    fn springs_give_forces_where_no_file_does() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("pair.csv");
        let two = Particles {
            positions: vec![Vec3::zeros(), Vec3::new(0.0, 0.0, 1.9)],
            radii: vec![1.0; 2],
            ..Particles::default()
        };
        format::csv::write(&path, &two).expect("written");
        let room = Bounds { low: Vec3::repeat(-5.0), high: Vec3::repeat(5.0) };
        let wanted = Survey { stiffness: Some(100.0), room: Some(room), ..Survey::default() };
        let found = survey(&path, &wanted).expect("measured");
        let row = found.tables[0].rows.iter().find(|r| r[0] == Cell::from("stress [Pa] zz"));
        let Some(Cell::Number(stress)) = row.map(|row| row[1].clone()) else { panic!() };
        assert!((stress - 10.0 * 1.9 / 1000.0).abs() < 1e-12, "{stress}");
    }
}
