//! Grains whose spheres are bonded instead of rigid (D9): a body for each sphere, and the bonds.

use super::Scene;
use super::parameters::{BondLaw, BondParameters, Hold};
use crate::clump::{Lattice, Method};
use crate::model::{Body, Bond, ContactTable, Dimension, Section, Sphere, Strength};
use crate::num::Vec3;
use crate::pack::Placement;

/// Stands for a strength that is not given: nothing reaches it.
const NEVER: f64 = 1e300;

/// Splits a rigid body that has just been put at the end of both lists into one body a sphere.
/// Masses go with the volume of the spheres and add up to that of the body; velocities are those of
/// the rigid motion.
pub fn split(
    dimension: Dimension,
    whole: Body,
    placement: &Placement,
    bodies: &mut Vec<Body>,
    spheres: &mut [Sphere],
) {
    let power = if dimension == Dimension::Two { 2 } else { 3 };
    let own = &mut spheres[whole.first_sphere as usize..];
    let share: f64 = own.iter().map(|sphere| sphere.radius.powi(power)).sum();
    for (number, sphere) in own.iter_mut().enumerate() {
        let arm = placement.orientation * sphere.offset;
        let first = whole.first_sphere + number as u32;
        let made = Body::sphere(
            dimension,
            placement.position + arm,
            sphere.radius,
            1.0,
            whole.material,
            first,
        );
        let mass = whole.mass * sphere.radius.powi(power) / share;
        sphere.offset = Vec3::zeros();
        sphere.body = bodies.len() as u32;
        bodies.push(Body {
            mass,
            inertia: made.inertia * (mass / made.mass),
            velocity: placement.velocity + placement.spin.cross(&arm),
            spin: placement.spin,
            family: whole.family,
            grain: whole.grain,
            ..made
        });
    }
}

/// Bonds between the spheres of every bonded grain. `copies`: the first sphere of each grain in
/// the packing, and the number of all spheres at the end.
pub fn bonds(
    scene: &Scene,
    dimension: Dimension,
    copies: &[u32],
    bodies: &[Body],
    spheres: &[Sphere],
    contacts: &ContactTable,
) -> Vec<Bond> {
    let mut bonds = Vec::new();
    for grain in copies.windows(2) {
        let (first, end) = (grain[0], grain[1]);
        let family = bodies[spheres[first as usize].body as usize].family;
        let family = &scene.grains[family as usize];
        let Hold::Bonded(parameters) = &family.body else { continue };
        let lattice = match &family.clump {
            Some(Method::Lattice(lattice)) => *lattice,
            _ => Lattice::default(),
        };
        let maker = Maker { lattice, parameters, dimension, bodies, spheres, contacts };
        maker.join(first, end, &mut bonds);
    }
    bonds
}

struct Maker<'a> {
    lattice: Lattice,
    parameters: &'a BondParameters,
    dimension: Dimension,
    bodies: &'a [Body],
    spheres: &'a [Sphere],
    contacts: &'a ContactTable,
}

impl Maker<'_> {
    /// Joins near spheres of one grain, sorted along x so that not all pairs are looked at.
    fn join(&self, first: u32, end: u32, bonds: &mut Vec<Bond>) {
        let start = bonds.len();
        let place = |sphere: u32| self.bodies[self.spheres[sphere as usize].body as usize].position;
        let radius = |sphere: u32| self.spheres[sphere as usize].radius;
        let largest = (first..end).map(radius).fold(0.0, f64::max);
        let mut order: Vec<u32> = (first..end).collect();
        order.sort_by(|a, b| place(*a).x.total_cmp(&place(*b).x).then(a.cmp(b)));
        for (at, one) in order.iter().enumerate() {
            for two in &order[at + 1..] {
                let reach = radius(*one) + (2.0 + self.parameters.gap) * largest;
                if place(*two).x - place(*one).x > reach {
                    break;
                }
                let distance = (place(*two) - place(*one)).norm();
                let smaller = radius(*one).min(radius(*two));
                // A hair more, so that rounding does not decide about spheres that just touch.
                let gap = (self.parameters.gap + 1e-9) * smaller;
                if distance <= radius(*one) + radius(*two) + gap {
                    bonds.push(self.bond([*one, *two], distance, smaller));
                }
            }
        }
        bonds[start..].sort_by_key(|bond| (bond.first, bond.second));
    }

    fn bond(&self, pair: [u32; 2], distance: f64, smaller: f64) -> Bond {
        let [one, two] =
            pair.map(|sphere| &self.bodies[self.spheres[sphere as usize].body as usize]);
        let mut bond = match &self.parameters.law {
            BondLaw::Contact(law) => {
                let contact = self.contacts.between(one.material, two.material);
                let strength = match (law.tension, law.shear) {
                    (None, None) => Strength::Unbreakable,
                    (tension, shear) => Strength::Forces {
                        tension: tension.map_or(NEVER, |force| force.0),
                        shear: shear.map_or(NEVER, |force| force.0),
                    },
                };
                let kn = law.kn.map_or(contact.kn, |kn| kn.0);
                let kt = law.kt.map_or(contact.kt, |kt| kt.0);
                Bond::contact(pair, kn, kt, strength)
            }
            BondLaw::Solid(law) => {
                let area = std::f64::consts::PI * smaller * smaller;
                let strength = match (law.tension, law.shear) {
                    (None, None) => Strength::Unbreakable,
                    (tension, shear) => Strength::Forces {
                        tension: tension.map_or(NEVER, |stress| stress.0 * area),
                        shear: shear.map_or(NEVER, |stress| stress.0 * area),
                    },
                };
                // Reachable: the family was validated with these moduli.
                let [kn, ks] = self
                    .lattice
                    .stiffness(distance, law.young.0, law.poisson)
                    .unwrap_or([law.young.0 * distance, 0.0]);
                Bond::contact(pair, kn, ks, strength)
            }
            BondLaw::Beam(law) => {
                let radius = law.radius * smaller;
                let strength = match (law.tension, law.shear) {
                    (None, None) => Strength::Unbreakable,
                    (tension, shear) => Strength::Stresses {
                        radius,
                        tension: tension.map_or(NEVER, |stress| stress.0),
                        shear: shear.map_or(NEVER, |stress| stress.0),
                    },
                };
                let moduli = [law.young.0, law.young.0 / (2.0 * (1.0 + law.poisson))];
                let section = Section::new(self.dimension, radius);
                Bond::beam(pair, section, distance, moduli, strength)
            }
        };
        // β = c/kn with c = 2 ζ √(m_eff kn).
        let mass = one.mass * two.mass / (one.mass + two.mass);
        bond.viscosity = 2.0 * self.parameters.damping * (mass / bond.normal).sqrt();
        bond
    }
}
