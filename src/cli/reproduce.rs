//! `riprap reproduce`: clumps for the grains of a scene, or for one mesh.

use super::arguments::Reproduce;
use super::{Ending, Screen};
use crate::clump::{self, Clump, Fidelity, MassSource, Method};
use crate::format;
use crate::geometry::check;
use crate::scene::road::Road;
use crate::shape::Solid;
use serde_json::json;

pub fn reproduce(arguments: &Reproduce, screen: &Screen) -> Result<(), Ending> {
    let is_scene = arguments.input.extension().is_some_and(|extension| extension == "toml");
    if is_scene { of_scene(arguments, screen) } else { of_mesh(arguments, screen) }
}

fn of_scene(arguments: &Reproduce, screen: &Screen) -> Result<(), Ending> {
    let mut road = Road::open(&arguments.input, arguments.output.as_deref(), screen.job())?;
    let grains = road.grains()?;
    screen.remarks(&mut road);
    let clumps: Vec<&Clump> = grains
        .distinct
        .iter()
        .map(|grain| &grain.clump)
        .filter(|clump| clump.fidelity.is_some())
        .collect();
    let mut text = header();
    clumps.iter().take(12).for_each(|clump| text.push_str(&row(clump)));
    if clumps.len() > 12 {
        text.push_str(&format!(
            "… {} more in {}\n",
            clumps.len() - 12,
            road.store.path("clumps").display()
        ));
    }
    let facts: Vec<_> = clumps.iter().map(|clump| facts(clump)).collect();
    screen.result(&json!({ "output": road.store.root(), "clumps": facts }), &text)
}

fn of_mesh(arguments: &Reproduce, screen: &Screen) -> Result<(), Ending> {
    let output =
        arguments.output.clone().unwrap_or_else(|| arguments.input.with_extension("clump.csv"));
    if !output.extension().is_some_and(|end| end.eq_ignore_ascii_case("csv")) {
        return Err(Ending::Input(format!(
            "{}: clumps are CSV files, x,y,z,r a sphere: name it so, NAME.csv; `riprap convert` \
             makes other formats of it",
            output.display()
        )));
    }
    let name = arguments
        .input
        .file_stem()
        .map_or("mesh".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let mesh = format::read_mesh(&arguments.input)?;
    let (mesh, repairs) = check::solid(mesh)
        .and_then(|(mesh, repairs)| check::simple(&mesh).map(|()| (mesh, repairs)))
        .map_err(|fault| Ending::Input(format!("{}: {fault}", arguments.input.display())))?;
    if !repairs.is_none() {
        screen.warn(&format!("{}: {repairs}", arguments.input.display()));
    }
    let mass = mesh.mass_properties();
    let solid = Solid { name, mesh, mass, recipe: arguments.input.display().to_string() };
    let job = screen.job();
    let clump = match arguments.error {
        Some(error) => clump::reproduce_to_error(&solid, &arguments.method, error, &job)?,
        None => {
            let spheres = arguments.spheres.unwrap_or(20);
            let method = Method::by_key(&arguments.method, spheres)?;
            clump::reproduce(&solid, &method, MassSource::Solid, 0, 0, &job)?
        }
    };
    clump::file::write_as(&output, &clump)?;
    let text = format!("{}{}{}\n", header(), row(&clump), output.display());
    screen.result(&json!({ "output": output, "clump": facts(&clump) }), &text)
}

fn header() -> String {
    format!(
        "{:24} {:>7} {:>9} {:>8} {:>8} {:>10} {:>10} {:>9}\n",
        "clump", "spheres", "volume %", "mean %", "RMS %", "largest %", "centroid %", "inertia %"
    )
}

fn row(clump: &Clump) -> String {
    let Some(f) = &clump.fidelity else {
        return format!("{:24} {:>7}\n", clump.name, clump.balls.len());
    };
    let [volume, mean, rms, largest, centroid, inertia] = percentages(f);
    format!(
        "{:24} {:>7} {volume:>+9.2} {mean:>8.2} {rms:>8.2} {largest:>10.2} {centroid:>10.2} {inertia:>9.2}\n",
        clump.name,
        clump.balls.len()
    )
}

fn percentages(f: &Fidelity) -> [f64; 6] {
    let d = f.equivalent_diameter;
    [
        f.volume_error,
        f.mean_distance / d,
        f.rms_distance / d,
        f.largest_distance / d,
        f.centroid_error / d,
        f.inertia_error,
    ]
    .map(|value| value * 100.0)
}

fn facts(clump: &Clump) -> serde_json::Value {
    json!({ "name": clump.name, "method": clump.method, "spheres": clump.balls.len(), "fidelity": clump.fidelity })
}
