//! G3: spheres at a random subset of the mesh nodes of a volume (Sajjadi &
//! Khalili 2015, second method).
//!
//! The nodes are those of a regular grid (cubes of edge `spacing`) in a random
//! position and orientation that lie in the base volume. Each is kept with
//! probability p and gets a sphere. The paper's rule is that every sphere
//! touches another (`touching`: others are dropped); that allows several
//! pieces, which are no grain, so the default keeps the largest piece
//! (`one_piece`). Two spheres count as touching where they share at least 5 %
//! of the smaller radius in depth, so that their surfaces, made of triangles,
//! meet as well. The spheres are united (O(n log n) boolean operations on
//! halves), and cavities between them are filled. What cannot be finished: no node kept, or a union that the kernel
//! refuses, is drawn again.

use super::base::{Base, Body};
use super::draw::{Draw, Drawn, Fact, ordered};
use crate::geometry::{GeometryError, Posed, Primitive, union};
use crate::num::random::{self, Stream};
use crate::num::{Fault, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which spheres stay.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Those of the largest piece.
    #[default]
    OnePiece,
    /// Those that touch another one (the paper's rule); may be several pieces, which the gate refuses.
    Touching,
}

/// Spheres at random nodes of a volume.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NodeSphereParameters {
    /// Base volume, for example `sphere = 1.0` or `union = { … }`; default a sphere.
    pub base: Base,
    /// Distance of nodes over the equivalent diameter of the base volume, from 0.05 to 0.5; default 0.22.
    pub spacing: f64,
    /// Probability that a node gets a sphere, from 0.01 to 1; default 0.6.
    pub probability: f64,
    /// Least and largest radius over the distance of nodes, from 0.4 to 2; default [0.65, 0.9].
    pub radius: [f64; 2],
    /// `one_piece` (default) or `touching`.
    pub rule: Rule,
    /// Pieces that a sphere has in a turn, from 6 to 60; default 15.
    pub segments: u32,
}

impl Default for NodeSphereParameters {
    fn default() -> Self {
        Self {
            base: Base::Sphere(1.0),
            spacing: 0.22,
            probability: 0.6,
            radius: [0.65, 0.9],
            rule: Rule::OnePiece,
            segments: 15,
        }
    }
}

/// Common depth over the smaller radius from which on spheres touch.
const DEPTH: f64 = 0.05;

impl Draw for NodeSphereParameters {
    fn validate(&self) -> Result<(), Fault> {
        self.base.validate().map_err(|fault| fault.under("base"))?;
        Fault::within("spacing", self.spacing, 0.05, 0.5)?;
        Fault::within("probability", self.probability, 0.01, 1.0)?;
        ordered("radius", self.radius, 0.4, 2.0)?;
        Fault::within("segments", f64::from(self.segments), 6.0, 60.0)
    }

    fn draw(&self, stream: &mut Stream) -> Result<Drawn, GeometryError> {
        let body = self.base.draw(stream)?;
        let spacing = self.spacing * body.mesh.mass_properties().equivalent_diameter();
        let nodes = nodes(&body, spacing, stream);
        let mut spheres: Vec<(Vec3, f64)> = Vec::new();
        for node in &nodes {
            let kept = random::uniform(stream, 0.0, 1.0) < self.probability;
            let radius = spacing * random::uniform(stream, self.radius[0], self.radius[1]);
            if kept {
                spheres.push((*node, radius));
            }
        }
        let placed = spheres.len();
        let kept = kept(&spheres, self.rule);
        if kept.is_empty() {
            let reason = format!("no sphere left of {placed} at {} nodes", nodes.len());
            return Err(GeometryError::Method { reason });
        }
        let parts: Vec<_> = kept
            .iter()
            .map(|(centre, radius)| {
                let primitive = Primitive::Sphere { diameter: 2.0 * radius };
                // Each turned its own way, so that no faces of two lie in one plane.
                let rotation = random::rotation(stream);
                Posed { primitive, rotation, centre: *centre }.mesh(self.segments)
            })
            .collect();
        let (mesh, cavities) = union::unite_filled(&parts)?;
        Ok(Drawn {
            mesh,
            recipe: format!(
                "{} spheres at nodes of {} ({} nodes, {placed} chosen, {} dropped), {cavities} \
                 cavities filled",
                kept.len(),
                self.base.name(),
                nodes.len(),
                placed - kept.len()
            ),
            facts: vec![
                Fact::asked(
                    "share of nodes chosen",
                    self.probability,
                    placed as f64 / nodes.len() as f64,
                ),
                Fact::found("spheres", kept.len() as f64),
            ],
        })
    }
}

/// Nodes of a grid, turned and shifted at random, that lie in `body`.
fn nodes(body: &Body, spacing: f64, stream: &mut Stream) -> Vec<Vec3> {
    let turn = random::rotation(stream);
    let shift = Vec3::from_fn(|_, _| random::uniform(stream, 0.0, spacing));
    let bounds = body.mesh.bounds();
    let reach = (0.5 * bounds.diagonal() / spacing).ceil() as i64 + 1;
    let mut nodes = Vec::new();
    for z in -reach..=reach {
        for y in -reach..=reach {
            for x in -reach..=reach {
                let cell = Vec3::new(x as f64, y as f64, z as f64) * spacing + shift;
                let node = bounds.centre() + turn * cell;
                if bounds.contains(&node) && body.contains(&node) {
                    nodes.push(node);
                }
            }
        }
    }
    nodes
}

/// The spheres that stay under `rule`.
fn kept(spheres: &[(Vec3, f64)], rule: Rule) -> Vec<(Vec3, f64)> {
    let touch =
        |a: &(Vec3, f64), b: &(Vec3, f64)| (a.0 - b.0).norm() < a.1 + b.1 - DEPTH * a.1.min(b.1);
    let mut piece: Vec<usize> = vec![usize::MAX; spheres.len()];
    let mut sizes = Vec::new();
    for start in 0..spheres.len() {
        if piece[start] != usize::MAX {
            continue;
        }
        piece[start] = sizes.len();
        let mut members = vec![start];
        let mut next = 0;
        while let Some(&here) = members.get(next) {
            next += 1;
            for there in 0..spheres.len() {
                if piece[there] == usize::MAX && touch(&spheres[here], &spheres[there]) {
                    piece[there] = sizes.len();
                    members.push(there);
                }
            }
        }
        sizes.push(members.len());
    }
    let largest = (0..sizes.len()).fold(0, |b, p| if sizes[p] > sizes[b] { p } else { b });
    let stays = |index: &usize| match rule {
        Rule::OnePiece => piece[*index] == largest,
        Rule::Touching => sizes[piece[*index]] > 1,
    };
    (0..spheres.len()).filter(stays).map(|index| spheres[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::topology::inspect;
    use crate::shape::UnionParameters;

    #[test]
    fn a_full_grid_of_large_spheres_covers_the_volume() {
        let parameters = NodeSphereParameters {
            spacing: 0.3,
            probability: 1.0,
            radius: [0.9, 0.9],
            segments: 10,
            ..Default::default()
        };
        let drawn = parameters.draw(&mut random::stream(1, "nodes", 0)).expect("a union");
        let report = inspect(&drawn.mesh);
        assert!(report.is_closed() && report.pieces == 1, "{report:?}");
        assert!(report.volume > 0.9 * std::f64::consts::PI / 6.0, "{}", report.volume);
        assert_eq!(drawn.facts[0].measured, 1.0);
    }

    #[test]
    fn isolated_spheres_go_and_the_rules_differ() {
        let row =
            |xs: &[f64]| xs.iter().map(|x| (Vec3::new(*x, 0.0, 0.0), 1.0)).collect::<Vec<_>>();
        let spheres = row(&[0.0, 1.5, 3.0, 10.0, 11.5, 20.0]);
        assert_eq!(kept(&spheres, Rule::OnePiece), row(&[0.0, 1.5, 3.0]));
        assert_eq!(kept(&spheres, Rule::Touching), row(&[0.0, 1.5, 3.0, 10.0, 11.5]));
        assert_eq!(kept(&[], Rule::OnePiece), vec![]);
    }

    #[test]
    fn a_union_is_a_base_too() {
        let base = Base::Union(UnionParameters { segments: 12, ..Default::default() });
        let parameters =
            NodeSphereParameters { base, spacing: 0.35, segments: 10, ..Default::default() };
        let drawn = parameters.draw(&mut random::stream(5, "nodes", 0)).expect("a union");
        assert!(inspect(&drawn.mesh).is_closed());
    }
}
