//! What LIGGGHTS 3.8.0 refuses or counts wrongly in a wall mesh, found before
//! it does: it ends without a word when its output is a pipe.

use crate::geometry::Mesh;
use std::collections::BTreeMap;

/// Facts about a mesh that decide how its deck looks.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFacts {
    /// Smallest angle of any triangle, rad, and the triangle; `None` for no triangles.
    pub sharpest: Option<(f64, usize)>,
    /// A triangle with the same corners as an earlier one.
    pub duplicate: Option<(usize, usize)>,
    /// Most triangles that share one edge.
    pub crowd: usize,
}

/// Looks at every triangle and edge once. O(n log n).
pub fn inspect(mesh: &Mesh) -> MeshFacts {
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    let mut seen: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    let mut facts = MeshFacts { sharpest: None, duplicate: None, crowd: 0 };
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let angle = smallest_angle(&mesh.corners(index));
        if facts.sharpest.is_none_or(|(least, _)| angle < least) {
            facts.sharpest = Some((angle, index));
        }
        let mut key = *triangle;
        key.sort_unstable();
        if let Some(earlier) = seen.insert(key, index) {
            facts.duplicate.get_or_insert((earlier, index));
        }
        for (a, b) in [(key[0], key[1]), (key[1], key[2]), (key[0], key[2])] {
            let count = edges.entry((a, b)).or_insert(0);
            *count += 1;
            facts.crowd = facts.crowd.max(*count);
        }
    }
    facts
}

/// Smallest angle of a triangle, rad; 0 for one without area.
fn smallest_angle(corners: &[crate::num::Vec3; 3]) -> f64 {
    (0..3)
        .map(|i| {
            let (a, b, c) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let (u, v) = (b - a, c - a);
            u.cross(&v).norm().atan2(u.dot(&v))
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;

    #[test]
    fn needles_duplicates_and_crowds_are_seen() {
        let needle = Mesh {
            vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::new(0.5, 1e-3, 0.0), Vec3::z()],
            triangles: vec![[0, 1, 3], [0, 1, 2], [3, 0, 1]],
        };
        let facts = inspect(&needle);
        let (angle, index) = facts.sharpest.expect("triangles");
        assert_eq!(index, 1);
        assert!((angle - (2e-3_f64).atan()).abs() < 1e-12);
        assert_eq!(facts.duplicate, Some((0, 2)));
        assert_eq!(facts.crowd, 3);
    }

    #[test]
    fn right_isosceles_triangles_have_45_degrees() {
        let mesh = Mesh {
            vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            triangles: vec![[0, 1, 2]],
        };
        let (angle, _) = inspect(&mesh).sharpest.expect("one");
        assert!((angle - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
        assert_eq!(inspect(&Mesh::default()).sharpest, None);
    }
}
