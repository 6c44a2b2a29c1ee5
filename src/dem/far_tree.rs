//! An octree over point masses, and walks through it.
//!
//! Barnes & Hut (1986, Nature 324, 446): a cube around all bodies is cut into
//! eighths until a cell holds at most [`LEAF`] bodies. A body at distance d from the
//! centre of mass of a cell of edge s takes it as one if d > s/θ + δ, δ the distance
//! of the centre of mass from the middle of the cell (Barnes 1994); otherwise it looks
//! inside. Bodies in one plane make a quadtree of it.
//!
//! With m the mass of a cell, S = Σ mᵢ (xᵢ − c)(xᵢ − c)ᵀ its second moments about its centre
//! of mass c, d = x − c, ρ² = d² + ε²:
//!     φ(x) = −[ m/ρ + ½ (3 dᵀS d/ρ⁵ − tr S/ρ³) ]      (Taylor series of 1/ρ to second order)
//!     g(x) = −m d/ρ³ + 3 S d/ρ⁵ + (3/2) (tr S/ρ⁵ − 5 dᵀS d/ρ⁷) d
//! times the gravitational constant; monopoles leave S out.
//!
//! Cost: build n log n, walk of one body log n / θ³. The tree depends on the bodies only and
//! each walk on the tree only: the numbers do not depend on threads. Cannot fail; bodies
//! at one place end in a leaf together at depth [`DEPTH`].

use crate::num::Vec3;

/// Bodies in a leaf, at most: below this looking at each is cheaper than more cells.
pub const LEAF: usize = 8;
/// Levels: what 63 bits of a key hold.
const DEPTH: u32 = 21;

/// A cell.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Centre of mass, m.
    centre: Vec3,
    /// Mass, kg.
    mass: f64,
    /// Square of the distance beyond which the cell counts as one, m².
    open: f64,
    /// Second moments xx, yy, zz, xy, xz, yz about the centre of mass, kg m².
    second: [f64; 6],
    /// The node after this one and all inside it.
    next: u32,
    /// Bodies of a leaf: first and one past the last; equal in other nodes.
    bodies: (u32, u32),
}

/// A tree over bodies.
#[derive(Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    places: Vec<Vec3>,
    masses: Vec<f64>,
    /// Body at each place of the tree's order.
    pub order: Vec<u32>,
    keys: Vec<(u64, u32)>,
    theta: f64,
    leaf: usize,
}

/// What a walk finds, without the gravitational constant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pull {
    /// Acceleration over G, kg/m².
    pub field: Vec3,
    /// Potential over G, kg/m.
    pub potential: f64,
    /// Bodies and cells that counted.
    pub terms: u64,
}

impl Tree {
    /// Builds the tree of `places` and `masses` for θ = `theta`, with at most `leaf` bodies a leaf.
    pub fn build(&mut self, places: &[Vec3], masses: &[f64], theta: f64, leaf: usize) {
        (self.theta, self.leaf) = (theta, leaf.max(1));
        self.nodes.clear();
        let low = places.iter().fold(Vec3::repeat(f64::INFINITY), |low, p| low.inf(p));
        let high = places.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
        let side = (high - low).max().max(f64::MIN_POSITIVE);
        self.keys.clear();
        self.keys.extend((0u32..).zip(places).map(|(body, p)| (key(&((p - low) / side)), body)));
        self.keys.sort_unstable();
        self.order.clear();
        self.order.extend(self.keys.iter().map(|entry| entry.1));
        self.places.clear();
        self.places.extend(self.order.iter().map(|body| places[*body as usize]));
        self.masses.clear();
        self.masses.extend(self.order.iter().map(|body| masses[*body as usize]));
        if !places.is_empty() {
            self.add(0, places.len(), 0, low, side);
        }
    }

    /// Adds the cell at `low` of edge `side` that holds bodies `from..to`, and all in it; returns its number.
    fn add(&mut self, from: usize, to: usize, depth: u32, low: Vec3, side: f64) -> usize {
        let number = self.nodes.len();
        let leaf = to - from <= self.leaf || depth == DEPTH;
        let bodies = if leaf { (from as u32, to as u32) } else { (0, 0) };
        let empty =
            Node { centre: Vec3::zeros(), mass: 0.0, open: 0.0, second: [0.0; 6], next: 0, bodies };
        self.nodes.push(empty);
        let mut parts: [(Vec3, f64, [f64; 6]); 8] = [(Vec3::zeros(), 0.0, [0.0; 6]); 8];
        if !leaf {
            let half = 0.5 * side;
            let shift = 3 * (DEPTH - 1 - depth);
            let mut first = from;
            for (octant, part) in parts.iter_mut().enumerate() {
                let many = self.keys[first..to]
                    .partition_point(|entry| (entry.0 >> shift & 7) as usize <= octant);
                if many > 0 {
                    let corner = Vec3::from_fn(|axis, _| (octant >> axis & 1) as f64 * half);
                    let child = self.add(first, first + many, depth + 1, low + corner, half);
                    let node = &self.nodes[child];
                    *part = (node.centre, node.mass, node.second);
                }
                first += many;
            }
        }
        let points = || (from..to).map(|i| (self.places[i], self.masses[i], [0.0; 6]));
        let (centre, mass, second) =
            if leaf { moments(points) } else { moments(|| parts.iter().copied()) };
        let middle = low + Vec3::repeat(0.5 * side);
        let far = side / self.theta + (centre - middle).norm();
        let next = self.nodes.len() as u32;
        self.nodes[number] = Node { centre, mass, open: far * far, second, next, bodies };
        number
    }

    /// Field and potential at the place of body number `own` of the tree's order, without its own;
    /// `soft` is the square of the softening length, m².
    pub fn walk<const QUADRUPOLE: bool>(&self, own: usize, soft: f64) -> Pull {
        let at = self.places[own];
        let mut pull = Pull::default();
        let mut number = 0;
        while let Some(node) = self.nodes.get(number) {
            let way = at - node.centre;
            let square = way.norm_squared();
            if square > node.open {
                pull.add_point(&way, square + soft, node.mass);
                if QUADRUPOLE {
                    pull.add_second(&way, square + soft, &node.second);
                }
                number = node.next as usize;
            } else if node.bodies.0 < node.bodies.1 {
                for other in node.bodies.0 as usize..node.bodies.1 as usize {
                    if other != own {
                        let way = at - self.places[other];
                        pull.add_point(&way, way.norm_squared() + soft, self.masses[other]);
                    }
                }
                number = node.next as usize;
            } else {
                number += 1;
            }
        }
        pull
    }
}

impl Pull {
    /// Adds a point mass at −`way`, `square` = way² + ε². Nothing if both are at one place.
    #[inline(always)]
    pub fn add_point(&mut self, way: &Vec3, square: f64, mass: f64) {
        self.terms += 1;
        if square > 0.0 {
            let near = mass / square.sqrt();
            self.potential -= near;
            self.field -= way * (near / square);
        }
    }

    /// Adds the second moments of a group.
    #[inline(always)]
    fn add_second(&mut self, way: &Vec3, square: f64, second: &[f64; 6]) {
        let [xx, yy, zz, xy, xz, yz] = second;
        let turned = Vec3::new(
            xx * way.x + xy * way.y + xz * way.z,
            xy * way.x + yy * way.y + yz * way.z,
            xz * way.x + yz * way.y + zz * way.z,
        );
        let (trace, along) = (xx + yy + zz, way.dot(&turned));
        let inverse = square.recip();
        let fifth = inverse * inverse * inverse.sqrt();
        self.potential -= 0.5 * fifth * (3.0 * along - trace * square);
        self.field += (turned * 3.0 + way * (1.5 * (trace - 5.0 * along * inverse))) * fifth;
    }
}

/// Centre of mass, mass and second moments of parts that have their own.
fn moments<I: Iterator<Item = (Vec3, f64, [f64; 6])>>(
    parts: impl Fn() -> I,
) -> (Vec3, f64, [f64; 6]) {
    let mass: f64 = parts().map(|part| part.1).sum();
    let centre = parts().map(|part| part.0 * part.1).sum::<Vec3>() / mass;
    let mut second = [0.0; 6];
    for (place, mass, inner) in parts() {
        let d = place - centre;
        let outer = [d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z];
        for (sum, (inner, outer)) in second.iter_mut().zip(inner.iter().zip(outer)) {
            *sum += inner + mass * outer;
        }
    }
    (centre, mass, second)
}

/// Morton key of a place within the unit cube: three bits a level, z y x, coarsest first.
fn key(place: &Vec3) -> u64 {
    let scale = f64::from(1u32 << DEPTH);
    // Saturating casts: what is not a number lands in cell 0 and is caught by the guard.
    let cell = place.map(|c| ((c * scale) as u64).min((1 << DEPTH) - 1));
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

/// Moves bit i to bit 3 i, for 21 bits.
fn spread(value: u64) -> u64 {
    let mut v = value;
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random;

    /// Equal masses, uniform in a ball of radius 1.
    fn ball(count: usize, seed: u64) -> (Vec<Vec3>, Vec<f64>) {
        let mut source = random::stream(seed, "ball", 0);
        let mut places = Vec::new();
        while places.len() < count {
            let p = Vec3::from_fn(|_, _| random::uniform(&mut source, -1.0, 1.0));
            if p.norm() <= 1.0 {
                places.push(p);
            }
        }
        (places, vec![1.0 / count as f64; count])
    }

    fn walk(tree: &Tree, own: usize, quadrupole: bool) -> Pull {
        if quadrupole { tree.walk::<true>(own, 0.0) } else { tree.walk::<false>(own, 0.0) }
    }

    /// Root mean square of the errors of the field, each over the field there.
    fn error(places: &[Vec3], masses: &[f64], theta: f64, quadrupole: bool, leaf: usize) -> f64 {
        let mut tree = Tree::default();
        tree.build(places, masses, theta, leaf);
        let picked = (0..places.len()).step_by(places.len().div_ceil(500));
        let many = picked.len() as f64;
        let square = |own: usize| {
            let (exact, found) = (direct(&tree, own), walk(&tree, own, quadrupole));
            assert!((found.potential / exact.potential - 1.0).abs() < 0.02);
            (found.field - exact.field).norm_squared() / exact.field.norm_squared()
        };
        (picked.map(square).sum::<f64>() / many).sqrt()
    }

    fn direct(tree: &Tree, own: usize) -> Pull {
        let mut exact = Pull::default();
        for (other, (place, mass)) in tree.places.iter().zip(&tree.masses).enumerate() {
            if other != own {
                let way = tree.places[own] - place;
                exact.add_point(&way, way.norm_squared(), *mass);
            }
        }
        exact
    }

    /// Errors of an independent implementation with one body a leaf, 2 000 bodies uniform in a ball.
    const TABLE: [(f64, f64, f64); 4] = [
        (0.3, 1.27e-3, 1.2e-4),
        (0.5, 6.2e-3, 1.0e-3),
        (0.7, 1.75e-2, 3.6e-3),
        (1.0, 3.6e-2, 1.5e-2),
    ];

    #[test]
    fn error_against_theta_is_that_of_the_table() {
        let (places, masses) = ball(2000, 1);
        for (theta, monopole, quadrupole) in TABLE {
            for (order, published) in [(false, monopole), (true, quadrupole)] {
                let single = error(&places, &masses, theta, order, 1);
                let ratio = single / published;
                assert!((0.7..1.3).contains(&ratio), "{theta} {order} {single:.3e}");
                assert!(error(&places, &masses, theta, order, LEAF) < 1.05 * single);
            }
        }
    }

    #[test]
    fn a_small_theta_is_the_direct_sum() {
        let (places, masses) = ball(300, 2);
        assert!(error(&places, &masses, 1e-3, false, LEAF) < 1e-14);
    }

    #[test]
    fn terms_a_body_grow_with_the_logarithm() {
        let terms = |count: usize| {
            let (places, masses) = ball(count, 3);
            let mut tree = Tree::default();
            tree.build(&places, &masses, 0.8, LEAF);
            let picked = (0..count).step_by(count / 250);
            let many = picked.len() as f64;
            picked.map(|own| walk(&tree, own, true).terms as f64).sum::<f64>() / many
        };
        let [small, middle, large] = [1_000, 8_000, 64_000].map(terms);
        // Equal factors in n add equal numbers of terms, up to what the surface of the ball takes away.
        assert!(
            middle < 2.0 * small && large - middle < 1.3 * (middle - small),
            "{small} {middle} {large}"
        );
        assert!(large < 1_000.0, "{large}");
    }

    #[test]
    fn planes_points_and_lines_are_trees_too() {
        let (mut places, masses) = ball(400, 4);
        places.iter_mut().for_each(|p| p.z = 0.25);
        assert!(error(&places, &masses, 0.4, true, LEAF) < 3e-3);
        let mut tree = Tree::default();
        tree.build(&places, &masses, 0.4, LEAF);
        assert!((0..400).all(|own| walk(&tree, own, true).field.z == 0.0));
        tree.build(&[Vec3::x(); 30], &[1.0; 30], 0.5, LEAF);
        assert_eq!(walk(&tree, 3, true).field, Vec3::zeros());
        tree.build(&[Vec3::x()], &[2.0], 0.5, LEAF);
        assert_eq!(walk(&tree, 0, true), Pull::default());
        tree.build(&[], &[], 0.5, LEAF);
        tree.build(&[Vec3::x(), -Vec3::x()], &[2.0, 1.0], 0.5, 1);
        let heavy = tree.order.iter().position(|body| *body == 0).expect("is there");
        assert_eq!(walk(&tree, heavy, true).field, -Vec3::x() * 0.25);
    }

    #[test]
    fn softened_quadrupoles_are_the_series_of_the_softened_law() {
        let (places, masses) = ball(200, 6);
        let (soft, mut tree) = (0.3f64.powi(2), Tree::default());
        let mut errors = [0.0; 2];
        for (theta, sum) in [0.8, 1e-3].into_iter().zip(&mut errors) {
            tree.build(&places, &masses, theta, 1);
            let own = tree.order.iter().position(|body| *body == 7).expect("is there");
            *sum = tree.walk::<true>(own, soft).field.norm();
        }
        assert!((errors[0] / errors[1] - 1.0).abs() < 5e-3, "{errors:?}");
    }
}
