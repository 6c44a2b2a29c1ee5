//! Random places to start from: without overlap where there is room, or with any overlap.
//!
//! O(tries) searches a ball. A ball that finds no free place in its tries lies where it was drawn last.

use super::space::Space;
use crate::geometry::BallGrid;
use crate::num::Vec3;
use crate::num::random::{Stream, stream};

/// Places for balls of these radii (m), largest first, without overlap if each finds one
/// in `tries` tries; and how many did not. `None` if the space has no inside.
pub fn apart(space: &Space, radii: &[f64], tries: u32, seed: u64) -> Option<(Vec<Vec3>, usize)> {
    let mut order: Vec<u32> = (0..radii.len() as u32).collect();
    order.sort_by(|&a, &b| radii[b as usize].total_cmp(&radii[a as usize]).then(a.cmp(&b)));
    let largest = order.first().map_or(0.0, |&i| radii[i as usize]);
    let smallest = order.last().map_or(1.0, |&i| radii[i as usize]);
    let mut source = stream(seed, "pack.scatter", 0);
    let mut grid = BallGrid::new(smallest);
    let mut centres = vec![Vec3::zeros(); radii.len()];
    let mut failed = 0;
    for i in order {
        let radius = radii[i as usize];
        let mut centre = space.sample(&mut source)?;
        let mut free = false;
        for _ in 0..tries {
            if space.clearance(&centre) >= radius
                && !space.overlaps(&grid, &centre, radius, largest)
            {
                free = true;
                break;
            }
            centre = space.sample(&mut source)?;
        }
        failed += usize::from(!free);
        grid.insert(centre, radius);
        centres[i as usize] = centre;
    }
    Some((centres, failed))
}

/// Random places that overlap as they come, each inside if it can be in 100 tries.
pub fn anywhere(space: &Space, radii: &[f64], seed: u64) -> Option<Vec<Vec3>> {
    let mut source = stream(seed, "pack.anywhere", 0);
    radii.iter().map(|&radius| inside(space, radius, &mut source)).collect()
}

fn inside(space: &Space, radius: f64, source: &mut Stream) -> Option<Vec3> {
    let mut best = space.sample(source)?;
    for _ in 0..100 {
        if space.clearance(&best) >= radius {
            break;
        }
        let other = space.sample(source)?;
        if space.clearance(&other) > space.clearance(&best) {
            best = other;
        }
    }
    Some(best)
}

/// What to say where a space has no inside that random points find.
pub fn no_inside() -> crate::num::Fault {
    crate::num::Fault::new(
        "",
        "finds no point inside the container",
        "a container that fills more of its bounds",
    )
}
