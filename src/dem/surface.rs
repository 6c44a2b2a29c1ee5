//! Mesh walls: which features of which triangle may touch, and the closest point.
//!
//! Rule (that of LIGGGHTS 3.8.0 `mesh/surface`, found by experiment): each
//! triangle is a wall of its own, from both sides. Its face always acts. An
//! edge acts if no other triangle shares it, or if none of those that share it
//! is coplanar and this triangle has the highest index among them; a corner
//! acts if this triangle has the highest index among all that share it, unless
//! all of them are coplanar and surround it. Of coplanar triangles (within
//! 0.256235°, sharing a corner) only the first to touch a sphere counts, and a face that begins to
//! touch takes the spring of a coplanar one (in LIGGGHTS an edge or corner does not).
//! So a convex edge gives one contact from outside its faces, but near it, over
//! the face of lower index, the other triangle's edge touches as well; a
//! concave joint gives one contact a face.
//!
//! Closest point: Ericson 2005, Real-Time Collision Detection, 5.1.5.
//! O(1) a triangle; set-up O(T log T) for T triangles. Cannot fail.

use crate::model::{Model, WallShape};
use crate::num::Vec3;
use std::collections::BTreeMap;

/// Two triangles whose normals differ by less than this are one face.
const COPLANAR: f64 = 0.256_235 * std::f64::consts::PI / 180.0;

/// All triangles of all mesh walls.
#[derive(Debug, Clone, Default)]
pub struct Surfaces {
    /// Corners at time 0.
    pub start: Vec<[Vec3; 3]>,
    /// Index of the wall in `Model::walls`.
    pub wall: Vec<u16>,
    /// Bits 0–2: edge (0–1, 1–2, 2–0) acts; bits 3–5: corner acts.
    pub acts: Vec<u8>,
    /// True if some mesh moves.
    pub moving: bool,
    flat_start: Vec<u32>,
    flat: Vec<u32>,
}

/// The part of a triangle that is closest to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// Inside, borders included.
    Face,
    /// Edge 0 (corners 0–1), 1 (1–2) or 2 (2–0).
    Edge(u8),
    /// Corner 0, 1 or 2.
    Corner(u8),
}

impl Surfaces {
    /// Reads the mesh walls of a model.
    pub fn new(model: &Model) -> Self {
        let mut all = Self { flat_start: vec![0], ..Self::default() };
        for (index, wall) in model.walls.iter().enumerate() {
            let WallShape::Mesh { mesh } = &wall.shape else { continue };
            all.moving |= wall.motion.moves();
            let first = all.start.len();
            all.start.extend(mesh.facets());
            all.wall.extend(vec![index as u16; mesh.triangles.len()]);
            all.join(first, &mesh.triangles);
        }
        all
    }

    /// Whether feature `feature` of triangle `index` may touch.
    pub fn acts(&self, index: usize, feature: Feature) -> bool {
        match feature {
            Feature::Face => true,
            Feature::Edge(edge) => self.acts[index] >> edge & 1 == 1,
            Feature::Corner(corner) => self.acts[index] >> (3 + corner) & 1 == 1,
        }
    }

    /// Whether two different triangles share a corner and a plane.
    pub fn coplanar(&self, a: u32, b: u32) -> bool {
        let (low, high) = (self.flat_start[a as usize], self.flat_start[a as usize + 1]);
        self.flat[low as usize..high as usize].binary_search(&b).is_ok()
    }

    /// Works out neighbours of the triangles from `first` on.
    fn join(&mut self, first: usize, triangles: &[[u32; 3]]) {
        let normals: Vec<Vec3> = self.start[first..]
            .iter()
            .map(|[a, b, c]| (b - a).cross(&(c - a)).normalize())
            .collect();
        // |sin| of the angle, so that flipped neighbours count as coplanar too.
        let flat = |a: usize, b: usize| normals[a].cross(&normals[b]).norm() < COPLANAR.sin();
        let mut at_corner: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        let mut at_edge: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
        for (index, corners) in triangles.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                at_corner.entry(a).or_default().push(index);
                at_edge.entry((a.min(b), a.max(b))).or_default().push(index);
            }
        }
        let smooth = |edge: &Vec<usize>| edge.len() > 1 && edge.iter().all(|t| flat(edge[0], *t));
        let mut rough = std::collections::BTreeSet::new();
        for ((a, b), edge) in &at_edge {
            if !smooth(edge) {
                rough.extend([*a, *b]);
            }
        }
        for (index, corners) in triangles.iter().enumerate() {
            let mut bits = 0u8;
            let mut neighbours = Vec::new();
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                let edge = &at_edge[&(a.min(b), a.max(b))];
                let last = edge.iter().all(|other| *other <= index);
                let bent = edge.iter().all(|other| *other == index || !flat(index, *other));
                bits |= u8::from(last && bent) << side;
                let fan = &at_corner[&a];
                let highest = fan.iter().all(|other| *other <= index);
                bits |= u8::from(highest && rough.contains(&a)) << (3 + side);
                neighbours.extend(
                    fan.iter()
                        .filter(|other| **other != index && flat(index, **other))
                        .map(|o| (first + o) as u32),
                );
            }
            neighbours.sort_unstable();
            neighbours.dedup();
            self.acts.push(bits);
            self.flat.extend(neighbours);
            self.flat_start.push(self.flat.len() as u32);
        }
    }
}

/// True only if the plane of triangle `corners` is farther than `radius` from `p`.
#[inline]
pub fn misses(p: &Vec3, radius: f64, [a, b, c]: &[Vec3; 3]) -> bool {
    let area = (b - a).cross(&(c - a));
    let height = (p - a).dot(&area);
    height * height > radius * radius * area.norm_squared() * (1.0 + 1e-9)
}

/// The point of triangle `corners` closest to `p`, and where it lies.
#[inline]
pub fn closest(p: &Vec3, corners: &[Vec3; 3]) -> (Vec3, Feature) {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let area = ab.cross(&ac);
    let whole = area.norm_squared();
    let ap = p - a;
    // Barycentric coordinates of the foot; borders within rounding belong to the face.
    let v = ap.cross(&ac).dot(&area) / whole;
    let w = ab.cross(&ap).dot(&area) / whole;
    let u = 1.0 - v - w;
    if u >= -1e-12 && v >= -1e-12 && w >= -1e-12 {
        return (p - area * (ap.dot(&area) / whole), Feature::Face);
    }
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, Feature::Corner(0));
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, Feature::Corner(1));
    }
    if d1 * d4 - d3 * d2 <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, Feature::Corner(2));
    }
    if d5 * d2 - d1 * d6 <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    let (e, f) = (d4 - d3, d5 - d6);
    (b + (c - b) * (e / (e + f)), Feature::Edge(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from)
    }

    /// Triangles of a square mesh wall, and the model that owns them.
    fn surfaces(slope: f64) -> Surfaces {
        use crate::dem::test_scenes as scenes;
        use crate::model::{Motion, Scheme};
        let mut model = scenes::empty(Scheme::Leapfrog, scenes::contact(0.0, 0.0, 0.0, 0.0));
        scenes::add_sheet(&mut model, 2, 0.1, 0.0, slope, Motion::Still);
        Surfaces::new(&model)
    }

    /// Indices of the triangles that act on a sphere of radius 0.01 at `place`.
    fn acting(surfaces: &Surfaces, place: Vec3) -> Vec<usize> {
        let mut met: Vec<u32> = Vec::new();
        for (index, corners) in surfaces.start.iter().enumerate() {
            let (point, feature) = closest(&place, corners);
            let again = feature == Feature::Face
                && met.iter().any(|other| surfaces.coplanar(index as u32, *other));
            if (point - place).norm() <= 0.01 && surfaces.acts(index, feature) && !again {
                met.push(index as u32);
            }
        }
        met.into_iter().map(|index| index as usize).collect()
    }

    #[test]
    fn flat_mesh_acts_as_one_surface() {
        let flat = surfaces(0.0);
        // On a diagonal, on an inner edge, on the inner corner, over a face, all from both sides.
        for (x, y) in [(-0.05, -0.05), (0.0, -0.05), (0.0, 0.0), (0.03, 0.08), (-0.0001, 0.0002)] {
            for side in [1.0, -1.0] {
                assert_eq!(
                    acting(&flat, Vec3::new(x, y, 0.0095 * side)).len(),
                    1,
                    "{x} {y} {side}"
                );
            }
        }
        // Beyond the border: its edge, or its corner, once.
        assert_eq!(acting(&flat, Vec3::new(-0.103, -0.05, 0.0088)).len(), 1);
        assert_eq!(acting(&flat, Vec3::new(0.103, 0.103, 0.0088)).len(), 1);
    }

    #[test]
    fn bent_edge_acts_as_in_liggghts() {
        // Fold along x = 0, shared by triangle 0 on its left and 3 on its right for y < 0.
        let ridge = surfaces(0.7);
        let normal = Vec3::new(0.7, 0.0, 1.0).normalize();
        // Above the fold: one edge, of the triangle of highest index that shares it.
        assert_eq!(acting(&ridge, Vec3::new(0.0001, -0.02, 0.0095)), [3]);
        // Over the face of lower index near the fold the other's edge acts as well ...
        assert_eq!(acting(&ridge, Vec3::new(-0.001, -0.02, 0.0095)), [0, 3]);
        // ... over the face of higher index only that face.
        let over = Vec3::new(0.001, -0.02, -0.0007) + normal * 0.0095;
        assert_eq!(acting(&ridge, over), [3]);
        // From the hollow side both faces act.
        assert_eq!(acting(&ridge, Vec3::new(-0.001, -0.02, -0.0095)), [0, 3]);
    }

    proptest! {
        #[test]
        fn closest_is_closest(p in point(), a in point(), b in point(), c in point()) {
            prop_assume!((b - a).cross(&(c - a)).norm() > 1e-3);
            let (best, _) = closest(&p, &[a, b, c]);
            for i in 0..=20 {
                for j in 0..=(20 - i) {
                    let (s, t) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let other = a + (b - a) * s + (c - a) * t;
                    prop_assert!((best - p).norm() <= (other - p).norm() + 1e-9);
                }
            }
        }
    }
}
