//! What a scene needs. Computed here and nowhere else; kernels, deck templates,
//! memory and reports read it, so "left out when not needed" has one meaning.

use super::{Dimension, Model, Motion, WallShape};
use serde::Serialize;

/// Which physics and which objects a scene has. Deck templates see it as `needs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
pub struct Needs {
    /// Discs instead of spheres.
    pub discs: bool,
    /// At least one body that is a single sphere.
    pub spheres: bool,
    /// At least one body of several spheres, or with mass properties of its own.
    pub clumps: bool,
    /// Radii differ.
    pub sizes: bool,
    /// More than one material.
    pub materials: bool,
    /// Gravity is not zero.
    pub gravity: bool,
    /// Gravity between bodies.
    pub mutual_gravity: bool,
    /// Some contact has μ > 0 and kt or ct > 0: tangential force, history and rotation.
    pub friction: bool,
    /// Some contact has cn > 0.
    pub normal_damping: bool,
    /// Friction, and some contact has ct > 0.
    pub tangential_damping: bool,
    /// Local (non-viscous) damping.
    pub local_damping: bool,
    /// Space repeats itself along some axes.
    pub periodic: bool,
    /// Attraction in contact.
    pub cohesion: bool,
    /// Liquid bridges.
    pub bridges: bool,
    /// Van der Waals, Born-Mayer or Lennard-Jones forces.
    pub molecular: bool,
    /// Electrostatic forces.
    pub charges: bool,
    /// Resistance to rolling.
    pub rolling: bool,
    /// Drag on every sphere.
    pub drag: bool,
    /// At least one plane wall along an axis.
    pub planes: bool,
    /// At least one plane wall that is not along an axis.
    pub oblique_planes: bool,
    /// At least one mesh wall.
    pub meshes: bool,
    /// At least one wall that translates.
    pub sliding_walls: bool,
    /// At least one wall that seeks a force.
    pub servo_walls: bool,
    /// At least one wall that rotates.
    pub turning_walls: bool,
    /// Bonds between bodies.
    pub bonds: bool,
    /// Some bond has a dashpot.
    pub bond_damping: bool,
    /// Velocities are set to zero now and then.
    pub zeroing: bool,
    /// Contacts have tangential springs at the start.
    pub springs: bool,
    /// Decks write restart files.
    pub restarts: bool,
    /// Bodies come during the run.
    pub arrivals: bool,
    /// Bodies turn: friction, or clumps, or bonds, or a spin at the start.
    pub rotation: bool,
    /// Contacts take energy, and it is counted.
    pub ledger: bool,
}

#[cfg(test)]
std::thread_local! {
    /// How often this thread has read a model's needs.
    pub static ASKED: std::cell::Cell<u64> = const { std::cell::Cell::new(0) };
}

impl Needs {
    /// Reads a model.
    pub fn of(model: &Model) -> Self {
        #[cfg(test)]
        ASKED.set(ASKED.get() + 1);
        let pairs = || {
            let size = model.contacts.size() as u16;
            (0..size).flat_map(move |a| (a..size).map(move |b| model.contacts.between(a, b)))
        };
        let friction = pairs().any(|c| c.friction > 0.0 && (c.kt > 0.0 || c.ct > 0.0));
        let clumps = model.bodies.iter().any(|body| body.sphere_count > 1);
        let damping = pairs().any(|c| c.cn > 0.0);
        let first = model.spheres.first().map(|sphere| sphere.radius);
        let wall = |test: &dyn Fn(&super::Wall) -> bool| model.walls.iter().any(test);
        Self {
            discs: model.dimension == Dimension::Two,
            spheres: model.bodies.iter().any(|body| body.sphere_count == 1),
            clumps,
            sizes: model.spheres.iter().any(|sphere| Some(sphere.radius) != first),
            materials: model.materials.len() > 1,
            gravity: model.gravity.norm_squared() > 0.0,
            mutual_gravity: model.mutual.is_some(),
            friction,
            normal_damping: damping,
            tangential_damping: friction && pairs().any(|c| c.ct > 0.0),
            local_damping: model.local_damping > 0.0,
            periodic: model.periodic.is_some(),
            cohesion: model.extra.any(|f| f.cohesion.is_some()),
            bridges: model.extra.any(|f| f.bridge.is_some()),
            molecular: model.extra.any(|f| {
                f.van_der_waals.is_some() || f.born_mayer.is_some() || f.lennard_jones.is_some()
            }),
            charges: model.extra.charges.is_some(),
            rolling: model.extra.any(|f| f.rolling.is_some()),
            drag: model.extra.drag > 0.0,
            planes: wall(&|w| w.shape.axis_plane().is_some()),
            oblique_planes: wall(&|w| {
                matches!(w.shape, WallShape::Plane { .. }) && w.shape.axis_plane().is_none()
            }),
            meshes: wall(&|w| matches!(w.shape, WallShape::Mesh { .. })),
            sliding_walls: wall(&|w| {
                matches!(w.motion, Motion::Translate { .. } | Motion::Oscillate { .. })
            }),
            servo_walls: wall(&|w| matches!(w.motion, Motion::Servo { .. })),
            turning_walls: wall(&|w| matches!(w.motion, Motion::Rotate { .. })),
            bonds: !model.bonds.is_empty(),
            bond_damping: model.bonds.iter().any(|bond| bond.viscosity > 0.0),
            zeroing: model.plan.zero_every > 0,
            springs: !model.springs.is_empty(),
            restarts: model.decks.restarts > 0,
            arrivals: !model.arrivals.is_empty(),
            rotation: friction
                || clumps
                || !model.bonds.is_empty()
                || model.bodies.iter().any(|body| body.spin.norm_squared() > 0.0),
            ledger: model.plan.ledger && (friction || damping),
        }
    }

    /// Whether the pass for forces besides the linear contact is made at all.
    pub fn extra(&self) -> bool {
        self.cohesion || self.bridges || self.molecular || self.charges || self.rolling
    }

    /// Every need with its key, what it is for people, and whether this scene has it.
    pub fn table(&self) -> [(&'static str, &'static str, bool); 32] {
        [
            ("discs", "two dimensions (discs of unit thickness)", self.discs),
            ("spheres", "single spheres", self.spheres),
            ("clumps", "rigid clumps", self.clumps),
            ("sizes", "radius of each sphere", self.sizes),
            ("materials", "table of material pairs", self.materials),
            ("gravity", "gravity", self.gravity),
            ("mutual_gravity", "gravity between bodies", self.mutual_gravity),
            ("friction", "friction and tangential history", self.friction),
            ("normal_damping", "normal dashpot", self.normal_damping),
            ("tangential_damping", "tangential dashpot", self.tangential_damping),
            ("local_damping", "local (non-viscous) damping", self.local_damping),
            ("cohesion", "attraction in contact", self.cohesion),
            ("bridges", "liquid bridges", self.bridges),
            ("molecular", "van der Waals and repulsive potentials", self.molecular),
            ("charges", "electrostatic forces", self.charges),
            ("rolling", "resistance to rolling", self.rolling),
            ("drag", "viscous drag on every sphere", self.drag),
            ("periodic", "periodic box", self.periodic),
            ("planes", "plane walls along the axes", self.planes),
            ("oblique_planes", "oblique plane walls", self.oblique_planes),
            ("meshes", "mesh walls", self.meshes),
            ("sliding_walls", "walls that translate", self.sliding_walls),
            ("servo_walls", "walls that seek a force", self.servo_walls),
            ("turning_walls", "walls that rotate", self.turning_walls),
            ("bonds", "bonds between bodies", self.bonds),
            ("bond_damping", "dashpots in bonds", self.bond_damping),
            ("zeroing", "velocities set to zero every so many steps", self.zeroing),
            ("springs", "tangential springs at the start", self.springs),
            ("restarts", "restart files of decks", self.restarts),
            ("arrivals", "grains inserted over time", self.arrivals),
            ("rotation", "rotation of bodies", self.rotation),
            ("ledger", "count of the energies that contacts take", self.ledger),
        ]
    }
}
