//! Mesh walls as cells (triangles, inner edges, corners) with weights, so that forces at a
//! distance feel them as surfaces, however these are cut into triangles.
//!
//! A force with the potential U(d) of the distance d to a flat wall has at a mesh the potential
//!     Σ w U(d), d the distance to a cell; w = 1 for a triangle, 1 − m for an edge of m triangles,
//!     1 − n + Σ (m − 1) over its edges for a corner of n triangles
//! (0 at the border of a mesh; −1 and 1 for edges and corners inside of it).
//! By inclusion and exclusion this is ∫ F(r) χ(r) dr, where χ is the Euler characteristic of that
//! part of the surface which lies within r of the sphere's centre (Hatcher 2002, Algebraic Topology, 2.2). As long
//! as that part is in one piece without holes, χ = 1 and the nearest point alone pulls: over faces, cut as finely as
//! you like, over edges and corners that stick out, beyond the border. In a hollow joint it is in two
//! pieces until r reaches the edge between them: both sides pull, less what they have in common, as
//! two half spaces do. Nothing jumps where one cell takes over from the next, so energy is kept, and flat or finely
//! bent surfaces need no angle that says what an edge is.
//!
//! Triangles must share their corners (see [`crate::model::WallShape`]); only meshes that
//! reach some body are here. O(T log T) to build for T triangles; cannot fail.

use crate::dem::setting::Setting;
use crate::dem::surface;
use crate::model::{Model, WallShape};
use crate::num::Vec3;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// All cells: triangles, then edges, then corners.
#[derive(Debug, Clone, Default)]
pub struct Complex {
    /// Corners of the meshes at time 0, m.
    points: Vec<Vec3>,
    /// Index of the wall in `Model::walls` of each point.
    owner: Vec<u16>,
    /// True if some mesh moves.
    moving: bool,
    /// Points of each cell; edges and corners repeat their last.
    corners: Vec<[u32; 3]>,
    weight: Vec<f64>,
    triangles: usize,
    /// Where the triangles around each edge and corner begin.
    start: Vec<u32>,
    around: Vec<u32>,
}

/// Triangles around an edge or a corner.
type Around<K> = BTreeMap<K, Vec<u32>>;

impl Complex {
    /// The mesh walls that act on some body at a distance.
    pub fn new(model: &Model) -> Self {
        let mut all = Self { start: vec![0], ..Self::default() };
        let mut bodies: Vec<u16> = model.bodies.iter().map(|body| body.material).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let acts = |wall: u16| {
            let reaches = |body: &u16| !model.extra.between(*body, wall).at_a_distance().is_empty();
            bodies.iter().any(reaches)
        };
        let mut faces: Vec<[u32; 3]> = Vec::new();
        for (index, wall) in model.walls.iter().enumerate() {
            let WallShape::Mesh { mesh } = &wall.shape else { continue };
            if !acts(wall.material) {
                continue;
            }
            all.moving |= wall.motion.moves();
            let first = all.points.len() as u32;
            all.points.extend_from_slice(&mesh.vertices);
            all.owner.extend(vec![index as u16; mesh.vertices.len()]);
            faces.extend(mesh.triangles.iter().map(|face| face.map(|corner| first + corner)));
        }
        all.join(faces);
        all
    }

    /// Weighs triangles, edges and corners.
    fn join(&mut self, faces: Vec<[u32; 3]>) {
        let (mut edges, mut points): (Around<[u32; 2]>, Around<u32>) = Default::default();
        for (face, number) in faces.iter().zip(0u32..) {
            for side in 0..3 {
                let (a, b) = (face[side], face[(side + 1) % 3]);
                edges.entry([a.min(b), a.max(b)]).or_default().push(number);
                points.entry(a).or_default().push(number);
            }
        }
        let mut shared: BTreeMap<u32, f64> = BTreeMap::new();
        self.triangles = faces.len();
        self.weight = vec![1.0; faces.len()];
        self.corners = faces;
        for ([a, b], faces) in edges {
            let more = faces.len() as f64 - 1.0;
            *shared.entry(a).or_default() += more;
            *shared.entry(b).or_default() += more;
            self.add([a, b, b], -more, &faces);
        }
        for (point, faces) in points {
            let weight = 1.0 - faces.len() as f64 + shared[&point];
            self.add([point; 3], weight, &faces);
        }
    }

    fn add(&mut self, corners: [u32; 3], weight: f64, faces: &[u32]) {
        if weight != 0.0 {
            self.corners.push(corners);
            self.weight.push(weight);
            self.around.extend_from_slice(faces);
            self.start.push(self.around.len() as u32);
        }
    }

    /// True if no mesh acts at a distance.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether a cell is a triangle.
    pub fn is_triangle(&self, cell: u32) -> bool {
        (cell as usize) < self.triangles
    }

    /// Triangles around an edge or a corner.
    pub fn around(&self, cell: u32) -> &[u32] {
        let at = cell as usize - self.triangles;
        &self.around[self.start[at] as usize..self.start[at + 1] as usize]
    }

    /// How often a cell counts.
    pub fn weight(&self, cell: u32) -> f64 {
        self.weight[cell as usize]
    }

    /// Index of the wall in `Model::walls`.
    pub fn wall(&self, cell: u32) -> usize {
        self.owner[self.corners[cell as usize][0] as usize] as usize
    }

    /// The points of all meshes at `time`, s.
    pub fn points_at(&self, setting: &Setting<'_>, time: f64) -> Cow<'_, [Vec3]> {
        if !self.moving {
            return Cow::Borrowed(&self.points);
        }
        let mut now = Vec::with_capacity(self.points.len());
        for owned in self.owner.chunk_by(|a, b| a == b) {
            let (from, wall) = (now.len(), usize::from(owned[0]));
            let place = setting.wall_at(wall, time);
            now.extend(self.points[from..from + owned.len()].iter().map(place));
        }
        Cow::Owned(now)
    }

    /// The corners of a cell among `points`.
    pub fn corners(&self, cell: u32, points: &[Vec3]) -> [Vec3; 3] {
        self.corners[cell as usize].map(|corner| points[corner as usize])
    }

    /// The point of a cell that is nearest to `place`.
    pub fn nearest(&self, cell: u32, points: &[Vec3], place: &Vec3) -> Vec3 {
        let [a, b, c] = self.corners[cell as usize];
        let (from, to) = (&points[a as usize], &points[b as usize]);
        if a == b {
            return *from;
        }
        if b != c {
            return surface::closest(place, &[*from, *to, points[c as usize]]).0;
        }
        let way = to - from;
        let along = (place - from).dot(&way) / way.norm_squared();
        from + way * along.clamp(0.0, 1.0)
    }
}
