//! `riprap view`: a shaded picture.

use super::arguments::View;
use super::{Ending, Screen};
use crate::format::{self, Data};
use crate::report::gallery;
use serde_json::json;

pub fn view(arguments: &View, screen: &Screen) -> Result<(), Ending> {
    let picture = match format::read(&arguments.input)? {
        Data::Mesh(mesh) => gallery::view_mesh(&mesh),
        Data::Particles(table) => {
            let groups: Vec<u64> =
                table.bodies.clone().unwrap_or_else(|| (0..table.len() as u64).collect());
            let groups: Vec<u32> = groups.into_iter().map(|group| group as u32).collect();
            gallery::view_spheres(&table.positions, &table.radii, &groups)
        }
    };
    picture.write(&arguments.output)?;
    screen.result(
        &json!({ "picture": arguments.output }),
        &format!("{}\n", arguments.output.display()),
    )
}
