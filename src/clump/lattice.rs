//! A solid filled with touching equal spheres on a lattice: the elements of a deformable block (D4).
//!
//! Cubic: spheres of diameter d at the nodes of a cubic grid of spacing d. Staggered: face-centred
//! cubic, nodes (i, j, k) d/√2 with i + j + k even. A sphere is kept if it lies inside the solid;
//! the grid stands so that as many layers as fit lie evenly between the sides of the bounding box, whose
//! axes are those of the lattice. Spheres that do not hang together with the largest piece are
//! left out. O(nodes of the bounding box).
//!
//! What moduli bonds give such a lattice is in [`Lattice::stiffness`].

use super::ClumpError;
use super::target::{Found, Target};
use crate::geometry::Ball;
use crate::num::{Fault, Job, MethodEntry, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

/// What `riprap list clumps` says.
pub const ENTRY: MethodEntry = MethodEntry {
    key: "lattice",
    id: "D4",
    summary: "touching equal spheres on a cubic or staggered lattice inside the solid, for deformable blocks",
    source: "own; moduli: as Griffiths & Mustoe 2001, Wang & Mora 2008",
    example: r#"clump.lattice = { across = 6, pattern = "staggered" }"#,
};

/// Touching equal spheres on a lattice (D4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lattice {
    /// Layers of spheres over the shortest side of the solid's bounding box; 2 to 60, default 6.
    #[serde(default = "six")]
    pub across: u32,
    /// How spheres are stacked; default `staggered`.
    #[serde(default)]
    pub pattern: Stacking,
}

/// How spheres are stacked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stacking {
    /// Cubic: six neighbours.
    Cubic,
    /// Face-centred cubic: twelve neighbours.
    #[default]
    Staggered,
}

fn six() -> u32 {
    6
}

impl Default for Lattice {
    fn default() -> Self {
        Self { across: six(), pattern: Stacking::default() }
    }
}

impl Lattice {
    /// # Errors
    /// [`Fault`] for a value out of its range.
    pub fn validate(&self) -> Result<(), Fault> {
        if (2..=60).contains(&self.across) {
            return Ok(());
        }
        Err(Fault::new("across", format!("is {}", self.across), "2 to 60"))
    }

    /// Stiffness of contact bonds along and across the line of centres, N/m, that give a lattice
    /// of spheres of `diameter` (m) Young's modulus `young` (Pa) and Poisson's ratio `poisson` for
    /// stress along one of its axes.
    ///
    /// From the energy of a homogeneous strain ε, in which spheres turn with the mean rotation,
    ///     W = 1/(2V) Σ d² [kn (n·εn)² + ks (|εn|² − (n·εn)²)]
    /// over the bonds n of a sphere, each counted half, with V the volume of a sphere's cell.
    /// Face-centred cubic (V = d³/√2): C11 = √2 (kn + ks)/d, C12 = (kn − ks)/(√2 d), so that with
    /// k = ks/kn: ν = (1 − k)/(3 + k), E = 2√2 kn (1 + 3k)/((3 + k) d): from ν = 1/3 (no shear
    /// stiffness) down. In other directions than the axes the lattice is stiffer or softer: C44/((C11 − C12)/2)
    /// is 2(1 + k)/(1 + 3k), 1 for ν = 0 and 2 for ν = 1/3. Cubic (V = d³): E = kn/d with ν = 0;
    /// ks = kn makes C44 = E/2. (The plane case of six neighbours has the same ν: Griffiths &
    /// Mustoe 2001; three dimensions: Wang & Mora 2008, here derived anew.)
    ///
    /// # Errors
    /// A fault at `poisson` for a ratio that the lattice cannot reach.
    pub fn stiffness(&self, diameter: f64, young: f64, poisson: f64) -> Result<[f64; 2], Fault> {
        match self.pattern {
            Stacking::Cubic if poisson == 0.0 => Ok([young * diameter, young * diameter]),
            Stacking::Cubic => {
                Err(Fault::new("poisson", format!("is {poisson}"), "0 for a cubic lattice"))
            }
            Stacking::Staggered if (0.0..=1.0 / 3.0).contains(&poisson) => {
                let ratio = (1.0 - 3.0 * poisson) / (1.0 + poisson);
                let kn = young * diameter * (3.0 + ratio) / (2.0 * SQRT_2 * (1.0 + 3.0 * ratio));
                // Rounding must not make a stiffness of −1e−17 of ν = 1/3.
                Ok([kn, (ratio * kn).max(0.0)])
            }
            Stacking::Staggered => {
                let allowed =
                    "0 to 1/3, as springs between neighbours reach no other on this lattice";
                Err(Fault::new("poisson", format!("is {poisson}"), allowed))
            }
        }
    }

    pub(super) fn find(&self, target: &Target, job: &Job) -> Result<Found, ClumpError> {
        let bounds = target.solid.mesh.bounds();
        let (size, middle) = (bounds.size(), bounds.centre());
        let layers = f64::from(self.across);
        let (diameter, step) = match self.pattern {
            Stacking::Cubic => (size.min() / layers, size.min() / layers),
            Stacking::Staggered => {
                let diameter = size.min() / (1.0 + (layers - 1.0) / SQRT_2);
                (diameter, diameter / SQRT_2)
            }
        };
        let counts = size.map(|side| ((side - diameter) / step + 1.0 + 1e-6).floor().max(1.0));
        if counts.product() > 2e6 {
            let problem = format!("makes {:.1e} nodes around this solid", counts.product());
            return Err(
                Fault::new("lattice.across", problem, "a value that makes at most 2e6").into()
            );
        }
        let start = middle - (counts - Vec3::repeat(1.0)) * (0.5 * step);
        let counts = counts.map(|count| count as i32);
        let mut nodes = BTreeMap::new();
        let mut balls = Vec::new();
        for i in 0..counts.x {
            if job.is_cancelled() {
                return Err(ClumpError::Cancelled);
            }
            for j in 0..counts.y {
                for k in 0..counts.z {
                    if self.pattern == Stacking::Staggered && (i + j + k) % 2 != 0 {
                        continue;
                    }
                    let centre = start + Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * step;
                    // A thousandth for meshes that hold single-precision numbers.
                    if target.distance.at(&centre) <= -0.4995 * diameter {
                        nodes.insert([i, j, k], balls.len());
                        balls.push(Ball { centre, radius: 0.5 * diameter });
                    }
                }
            }
        }
        let all = balls.len();
        let kept = self.largest_piece(&nodes, balls);
        if kept.len() < 2 {
            return Err(ClumpError::NoSphere {
                name: target.solid.name.clone(),
                advice: "raise `across`: fewer than two spheres of the lattice lie inside",
            });
        }
        let note = format!("D4 lattice, {} spheres, {} left out", kept.len(), all - kept.len());
        Ok(Found { balls: kept, note })
    }

    /// Spheres of the largest piece that hangs together by touching neighbours.
    fn largest_piece(&self, nodes: &BTreeMap<[i32; 3], usize>, balls: Vec<Ball>) -> Vec<Ball> {
        let square = if self.pattern == Stacking::Cubic { 1 } else { 2 };
        let ways: Vec<[i32; 3]> = (0..27)
            .map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1])
            .filter(|way| way.iter().map(|c| c * c).sum::<i32>() == square)
            .collect();
        let mut piece = vec![usize::MAX; balls.len()];
        let mut sizes = Vec::new();
        for (node, index) in nodes {
            if piece[*index] != usize::MAX {
                continue;
            }
            let (name, mut open, mut size) = (sizes.len(), vec![*node], 0);
            piece[*index] = name;
            while let Some(here) = open.pop() {
                size += 1;
                for way in &ways {
                    let there = [here[0] + way[0], here[1] + way[1], here[2] + way[2]];
                    if let Some(other) = nodes.get(&there)
                        && piece[*other] == usize::MAX
                    {
                        piece[*other] = name;
                        open.push(there);
                    }
                }
            }
            sizes.push(size);
        }
        let best = (0..sizes.len()).rev().max_by_key(|name| sizes[*name]).unwrap_or(0);
        let members = balls.into_iter().zip(piece);
        members.filter(|(_, name)| *name == best).map(|(ball, _)| ball).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::reproduce::tests::solid;
    use super::*;
    use crate::geometry::samples::box_mesh;

    fn filled(lattice: Lattice, size: Vec3) -> Vec<Ball> {
        let block = solid("block", box_mesh(size));
        let target = Target::new(&block).expect("closed");
        lattice.find(&target, &Job::quiet()).expect("spheres").balls
    }

    #[test]
    fn blocks_are_filled_to_their_sides() {
        let cubic = Lattice { across: 4, pattern: Stacking::Cubic };
        assert_eq!(filled(cubic, Vec3::new(4.0, 5.0, 8.0)).len(), 4 * 5 * 8);
        // Five layers of 13 and 12, nine of them high.
        let staggered = Lattice { across: 5, pattern: Stacking::Staggered };
        let side = 1.0 + 4.0 / SQRT_2;
        let balls = filled(staggered, Vec3::new(side, side, 1.0 + 8.0 / SQRT_2));
        assert_eq!(balls.len(), 5 * 13 + 4 * 12);
        let touching = balls
            .iter()
            .enumerate()
            .flat_map(|(i, a)| balls[i + 1..].iter().map(move |b| (a.centre - b.centre).norm()))
            .inspect(|way| assert!(*way > 1.0 - 1e-9))
            .filter(|way| *way < 1.0 + 1e-9)
            .count();
        assert!(touching > 4 * balls.len());
    }

    #[test]
    fn stiffness_gives_the_moduli_of_a_homogeneous_strain() {
        let staggered = Lattice::default();
        let ways = [[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]].map(
            |[x, y, z]: [i32; 3]| Vec3::new(f64::from(x), f64::from(y), f64::from(z)) / SQRT_2,
        );
        let d: f64 = 0.003;
        for (young, poisson) in [(1e9, 0.0), (2e7, 0.2), (7e10, 1.0 / 3.0)] {
            let [kn, ks] = staggered.stiffness(d, young, poisson).expect("reachable");
            // Stress of a strain e along x and −ν e across: must be E e along x and 0 across.
            let strain = Vec3::new(1.0, -poisson, -poisson);
            let mut stress = Vec3::zeros();
            for n in &ways {
                let turned = strain.component_mul(n);
                let along = n.dot(&turned);
                let force = n * (kn * along) + (turned - n * along) * ks;
                stress += force.component_mul(n) * (d * d / (d.powi(3) / SQRT_2));
            }
            assert!((stress.x / young - 1.0).abs() < 1e-12, "{stress:?}");
            assert!(stress.y.abs() < 1e-12 * young && stress.z.abs() < 1e-12 * young);
        }
        assert!(staggered.stiffness(d, 1e9, 0.34).is_err());
        let cubic = Lattice { pattern: Stacking::Cubic, ..staggered };
        assert!(cubic.stiffness(d, 1e9, 0.2).is_err());
        assert_eq!(cubic.stiffness(d, 1e9, 0.0).expect("reachable"), [3e6, 3e6]);
    }

    #[test]
    fn pieces_that_do_not_touch_the_largest_are_left_out() {
        let lattice = Lattice { across: 3, pattern: Stacking::Cubic };
        let mut nodes = BTreeMap::new();
        for (index, node) in [[0, 0, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]].into_iter().enumerate() {
            nodes.insert(node, index);
        }
        let ball = |x: f64| Ball { centre: Vec3::x() * x, radius: 0.5 };
        let kept = lattice.largest_piece(&nodes, [0.0, 5.0, 6.0, 5.0].map(ball).to_vec());
        assert_eq!(kept.len(), 3);
    }
}
