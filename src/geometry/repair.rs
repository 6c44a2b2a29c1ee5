//! Small repairs of triangle surfaces: rounding to single precision, welding,
//! dropping what has no area or is there twice, consistent orientation.
//!
//! Nothing here invents surface: holes stay holes. Each step says how much it
//! changed; the order of vertices and triangles that stay is kept. Cost
//! O(n log n) for n triangles.

use super::Mesh;
use super::topology::{self, Sets};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What was repaired, in numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Repairs {
    /// Vertices merged into another one.
    pub welded: usize,
    /// Vertices dropped that no triangle used.
    pub unused: usize,
    /// Triangles dropped because two of their corners are one point.
    pub degenerate: usize,
    /// Triangles without area whose longest edge was given to the neighbour's opposite corner.
    pub slivers: usize,
    /// Triangles dropped because the same triangle was there before.
    pub duplicates: usize,
    /// Triangles dropped in pairs that face each other with nothing between.
    pub cancelled: usize,
    /// Triangles whose orientation was reversed.
    pub flipped: usize,
    /// True if the whole surface was inside out.
    pub inside_out: bool,
}

impl Repairs {
    /// True if nothing was changed.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Repairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = Vec::new();
        for (count, what) in [
            (self.welded, "vertices welded"),
            (self.unused, "unused vertices dropped"),
            (self.degenerate, "degenerate triangles dropped"),
            (self.slivers, "triangles without area joined to their neighbour"),
            (self.duplicates, "duplicate triangles dropped"),
            (self.cancelled, "triangles dropped that face each other"),
        ] {
            if count > 0 {
                said.push(format!("{count} {what}"));
            }
        }
        if self.inside_out {
            said.push("the surface was inside out and was turned".to_owned());
        } else if self.flipped > 0 {
            said.push(format!("{} triangles turned over", self.flipped));
        }
        match said.is_empty() {
            true => write!(f, "nothing repaired"),
            false => write!(f, "{}", said.join(", ")),
        }
    }
}

/// Rounds every coordinate to single precision; −0 becomes 0.
pub fn round_to_single(mesh: &mut Mesh) {
    for vertex in &mut mesh.vertices {
        // Adding +0 turns -0 into +0 and leaves all else alone.
        vertex.apply(|x| *x = f64::from(*x as f32 + 0.0));
    }
}

/// Merges vertices that are nearer than `tolerance` (m) to each other (chains
/// of near vertices merge as a whole) into the first of them; with 0, those
/// with equal coordinates. Returns how many vertices went away.
pub fn weld(mesh: &mut Mesh, tolerance: f64) -> usize {
    let points = &mesh.vertices;
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let key = |i: &u32| {
        let p = points[*i as usize];
        [p.x + 0.0, p.y + 0.0, p.z + 0.0]
    };
    order.sort_by(|i, j| {
        let (a, b) = (key(i), key(j));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2])).then(i.cmp(j))
    });
    let mut sets = Sets::new(points.len());
    for (place, i) in order.iter().enumerate() {
        let here = points[*i as usize];
        for j in &order[place + 1..] {
            let there = points[*j as usize];
            if there.x - here.x > tolerance {
                break;
            }
            if (there - here).norm() <= tolerance {
                sets.join(*i, *j);
            } else if tolerance == 0.0 {
                // Equal points stand next to each other in this order.
                break;
            }
        }
    }
    let mut place = vec![0u32; points.len()];
    let mut kept = Vec::new();
    for i in 0..points.len() as u32 {
        let first = sets.find(i);
        if first == i {
            place[i as usize] = kept.len() as u32;
            kept.push(points[i as usize]);
        } else {
            place[i as usize] = place[first as usize];
        }
    }
    let gone = points.len() - kept.len();
    mesh.triangles.iter_mut().flatten().for_each(|corner| *corner = place[*corner as usize]);
    mesh.vertices = kept;
    gone
}

/// Drops vertices that no triangle uses; returns how many.
pub fn drop_unused(mesh: &mut Mesh) -> usize {
    let mut place = vec![u32::MAX; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|corner| place[*corner as usize] = 0);
    let mut kept = Vec::new();
    for (vertex, place) in mesh.vertices.iter().zip(&mut place) {
        if *place == 0 {
            *place = kept.len() as u32;
            kept.push(*vertex);
        }
    }
    mesh.triangles.iter_mut().flatten().for_each(|corner| *corner = place[*corner as usize]);
    let gone = mesh.vertices.len() - kept.len();
    mesh.vertices = kept;
    gone
}

/// Drops triangles with two equal corners; returns how many.
pub fn drop_degenerate(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    before - mesh.triangles.len()
}

/// Removes triangles whose three distinct corners lie on a line, to within
/// `height` (m), without opening the surface: the longest edge is replaced by
/// the one from the middle corner to the opposite corner of the neighbour.
/// A sliver whose longest edge has no neighbour is dropped. Slivers for which
/// the new edge exists already stay. Returns how many were removed.
pub fn drop_slivers(mesh: &mut Mesh, height: f64) -> usize {
    let mut removed = 0;
    // Fans of slivers need several passes; each pass removes at least one.
    loop {
        let done = sliver_pass(mesh, height);
        removed += done;
        if done == 0 || removed > mesh.triangles.len() {
            return removed;
        }
    }
}

fn sliver_pass(mesh: &mut Mesh, height: f64) -> usize {
    let slivers: Vec<usize> =
        (0..mesh.triangles.len()).filter(|index| is_sliver(mesh, *index, height)).collect();
    if slivers.is_empty() {
        return 0;
    }
    let edges = topology::edges(mesh);
    let find = |a: u32, b: u32| {
        edges.binary_search_by_key(&[a.min(b), a.max(b)], |edge| edge.ends).ok().map(|i| &edges[i])
    };
    // An edge found before a change in this pass may be stale near that change.
    let mut touched = vec![false; mesh.vertices.len()];
    let mut dropped = Vec::new();
    let mut done = 0;
    for index in slivers {
        let [a, b, middle] = longest_first(mesh, index);
        let Some(edge) = find(a, b) else { continue };
        let neighbours: Vec<u32> =
            edge.triangles.iter().map(|(t, _)| *t).filter(|t| *t != index as u32).collect();
        if neighbours.is_empty() {
            if [a, b, middle].iter().all(|v| !touched[*v as usize]) {
                [a, b, middle].iter().for_each(|v| touched[*v as usize] = true);
                dropped.push(index);
            }
            continue;
        }
        let [other] = neighbours[..] else { continue };
        let Some(apex) =
            mesh.triangles[other as usize].into_iter().find(|vertex| *vertex != a && *vertex != b)
        else {
            continue;
        };
        let ring = [a, b, middle, apex];
        if apex == middle
            || find(middle, apex).is_some()
            || ring.iter().any(|v| touched[*v as usize])
        {
            continue;
        }
        ring.iter().for_each(|v| touched[*v as usize] = true);
        mesh.triangles[index] = [a, apex, middle];
        mesh.triangles[other as usize] = [apex, b, middle];
        done += 1;
    }
    done += dropped.len();
    let mut place = 0;
    mesh.triangles.retain(|_| {
        place += 1;
        dropped.binary_search(&(place - 1)).is_err()
    });
    done
}

/// The corners of a triangle in their cyclic order, the longest edge between the first two.
fn longest_first(mesh: &Mesh, index: usize) -> [u32; 3] {
    let mut corners = mesh.triangles[index];
    let length = |k: usize| {
        let points = mesh.corners(index);
        (points[(k + 1) % 3] - points[k]).norm_squared()
    };
    let longest = (0..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    corners.rotate_left(longest);
    corners
}

fn is_sliver(mesh: &Mesh, index: usize, height: f64) -> bool {
    let [a, b, c] = longest_first(mesh, index).map(|corner| mesh.vertices[corner as usize]);
    (b - a).cross(&(c - a)).norm() <= height * (b - a).norm()
}

/// Drops repeated triangles. Of triangles with the same three corners, as many
/// facing one way as the other cancel (returned second); of what is left one
/// stays and the others go (returned first). With `keep_one`, nothing cancels
/// and one triangle of each group stays whatever way it faces: right for
/// surfaces that bound nothing, such as walls.
pub fn drop_duplicates(mesh: &mut Mesh, keep_one: bool) -> (usize, usize) {
    let sorted = |triangle: &[u32; 3]| {
        let mut corners = *triangle;
        corners.sort_unstable();
        corners
    };
    let even = |[a, b, c]: [u32; 3]| (a < b) as u8 + (b < c) as u8 + (c < a) as u8 == 2;
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_key(|index| (sorted(&mesh.triangles[*index]), *index));
    let mut keep = vec![true; mesh.triangles.len()];
    let (mut duplicates, mut cancelled) = (0, 0);
    for group in order.chunk_by(|i, j| sorted(&mesh.triangles[*i]) == sorted(&mesh.triangles[*j])) {
        if group.len() == 1 {
            continue;
        }
        group.iter().for_each(|index| keep[*index] = false);
        let (ways, others): (Vec<usize>, Vec<usize>) =
            group.iter().partition(|index| even(mesh.triangles[**index]));
        let stays = match (keep_one, ways.len().cmp(&others.len())) {
            (true, _) => Some(group[0]),
            (false, std::cmp::Ordering::Greater) => Some(ways[0]),
            (false, std::cmp::Ordering::Less) => Some(others[0]),
            (false, std::cmp::Ordering::Equal) => None,
        };
        let pairs = if keep_one { 0 } else { 2 * ways.len().min(others.len()) };
        cancelled += pairs;
        duplicates += group.len() - pairs - usize::from(stays.is_some());
        if let Some(index) = stays {
            keep[index] = true;
        }
    }
    let mut place = 0;
    mesh.triangles.retain(|_| {
        place += 1;
        keep[place - 1]
    });
    (duplicates, cancelled)
}

/// Orients all triangles of a piece alike, and each piece so that the volume
/// it encloses is positive. Only edges with exactly two triangles pass the
/// orientation on. Returns how many triangles were turned over, or the middle
/// of an edge at which that is impossible (a one-sided surface).
pub fn orient(mesh: &mut Mesh) -> Result<usize, Vec3> {
    let edges = topology::edges(mesh);
    let mut neighbours = vec![Vec::new(); mesh.triangles.len()];
    for edge in &edges {
        if let [(s, s_rising), (t, t_rising)] = edge.triangles[..] {
            neighbours[s as usize].push((t as usize, s_rising == t_rising));
            neighbours[t as usize].push((s as usize, s_rising == t_rising));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let middle = mesh.bounds().centre();
    for start in 0..mesh.triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut piece = vec![(start, false)];
        let mut next = 0;
        while let Some(&(here, here_turned)) = piece.get(next) {
            next += 1;
            for &(there, clash) in &neighbours[here] {
                let wanted = here_turned ^ clash;
                match turned[there] {
                    None => {
                        turned[there] = Some(wanted);
                        piece.push((there, wanted));
                    }
                    Some(is) if is != wanted => {
                        return Err(mesh.corners(there).iter().sum::<Vec3>() / 3.0);
                    }
                    Some(_) => {}
                }
            }
        }
        let volume: f64 = piece
            .iter()
            .map(|&(index, turned)| {
                let [a, b, c] = mesh.corners(index).map(|p| p - middle);
                if turned { -a.dot(&b.cross(&c)) } else { a.dot(&b.cross(&c)) }
            })
            .sum();
        if volume < 0.0 {
            piece.iter().for_each(|&(index, is)| turned[index] = Some(!is));
        }
    }
    let mut count = 0;
    for (triangle, turned) in mesh.triangles.iter_mut().zip(turned) {
        if turned == Some(true) {
            triangle.swap(1, 2);
            count += 1;
        }
    }
    Ok(count)
}
