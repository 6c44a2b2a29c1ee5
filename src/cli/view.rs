//! `riprap view`: shaded pictures side by side.

use super::arguments::View;
use super::{Ending, Screen};
use crate::format::{self, Data, particles::Particles};
use crate::geometry::Bounds;
use crate::num::Vec3;
use crate::report::gallery;
use crate::report::picture::Picture;
use serde_json::json;

pub fn view(arguments: &View, screen: &Screen) -> Result<(), Ending> {
    let size = [arguments.width as usize, arguments.height as usize];
    let png = arguments.output.extension().is_some_and(|end| end.eq_ignore_ascii_case("png"));
    if !png {
        let name = arguments.output.display();
        return Err(Ending::Input(format!("{name}: pictures are PNG files; name it so: NAME.png")));
    }
    let things =
        arguments.inputs.iter().map(|path| format::read(path)).collect::<Result<Vec<_>, _>>()?;
    // States (tables that say which body a sphere belongs to) are drawn to one scale.
    let room = things.iter().fold(Bounds::EMPTY, |room, thing| match thing {
        Data::Particles(table) if table.bodies.is_some() => room.union(&extent(table)),
        _ => room,
    });
    let room = (!room.is_empty()).then_some(room);
    let pictures: Vec<Picture> = things
        .iter()
        .map(|thing| match thing {
            Data::Mesh(mesh) => gallery::view_mesh(mesh, size),
            Data::Particles(table) => {
                let room = room.filter(|_| table.bodies.is_some());
                gallery::view_spheres(&table.positions, &table.radii, &groups(table), room, size)
            }
        })
        .collect();
    Picture::beside(&pictures).write(&arguments.output)?;
    screen.result(
        &json!({ "picture": arguments.output }),
        &format!("{}\n", arguments.output.display()),
    )
}

/// Spheres of one body get one colour; without bodies every sphere is its own.
fn groups(table: &Particles) -> Vec<u32> {
    match &table.bodies {
        Some(bodies) => bodies.iter().map(|body| *body as u32).collect(),
        None => (0..table.len() as u32).collect(),
    }
}

fn extent(table: &Particles) -> Bounds {
    table.positions.iter().zip(&table.radii).fold(Bounds::EMPTY, |room, (centre, radius)| {
        let reach = Vec3::repeat(*radius);
        room.with(&(centre - reach)).with(&(centre + reach))
    })
}
