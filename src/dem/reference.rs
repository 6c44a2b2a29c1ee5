//! A plain twin of the solver for tests: every pair, plane and triangle is
//! looked at in every step; no lists, no blocks, no threads, no shared kernels.
//! Written from the schemes' definitions. O(N²) a step.

use crate::dem::setting::{Setting, wall_spin};
use crate::dem::surface::{Feature, closest};
use crate::dem::turn;
use crate::model::*;
use crate::num::{Rotation, Vec3};
use std::collections::BTreeMap;

/// A contact of sphere `.0` with sphere, plane or triangle `.2` of kind `.1`.
type Key = (usize, u8, usize);

#[derive(Clone, Copy)]
struct Spring {
    stretch: Vec3,
    normal: Vec3,
    /// Force of the last pass on the sphere.
    force: Vec3,
}

/// State of the twin.
pub struct Twin<'a> {
    setting: Setting<'a>,
    model: &'a Model,
    /// States of all bodies, velocities as the scheme stores them.
    pub states: Vec<BodyState>,
    momenta: Vec<Vec3>,
    springs: BTreeMap<Key, Spring>,
    force: Vec<Vec3>,
    torque: Vec<Vec3>,
    steps: u64,
    single: Vec<bool>,
    /// Forces and torques of the last pass.
    before: (Vec<Vec3>, Vec<Vec3>),
}

/// A sphere at one moment.
struct Grain {
    place: Vec3,
    velocity: Vec3,
    spin: Vec3,
    radius: f64,
    body: usize,
}

/// The other side of a contact.
struct Other {
    key: Key,
    normal: Vec3,
    overlap: f64,
    arms: [f64; 2],
    /// Arms of the sliding velocity.
    slides: [f64; 2],
    /// From the other side to the centre half a step before, and how the arm depends on the gap.
    before: Vec3,
    lean: f64,
    velocity: Vec3,
    spin: Vec3,
    body: Option<usize>,
    material: u16,
}

impl<'a> Twin<'a> {
    /// The twin of a run at time 0, after its first force pass.
    pub fn new(model: &'a Model) -> Self {
        let setting = Setting::new(model);
        let mut states = model.initial_states();
        if model.plan.scheme == Scheme::Yade {
            for state in &mut states {
                state.velocity -= setting.gravity * (0.5 * model.plan.step);
            }
        }
        let momenta = states
            .iter()
            .zip(&model.bodies)
            .map(|(s, b)| turn::momentum(&s.orientation, &b.inertia, &s.spin))
            .collect();
        let single = model
            .bodies
            .iter()
            .enumerate()
            .map(|(i, b)| b.sphere_count == 1 && model.spheres_of(i)[0].offset == Vec3::zeros())
            .collect();
        let count = model.bodies.len();
        let mut twin = Self {
            setting,
            model,
            states,
            momenta,
            springs: BTreeMap::new(),
            force: vec![Vec3::zeros(); count],
            torque: vec![Vec3::zeros(); count],
            steps: 0,
            single,
            before: Default::default(),
        };
        let advances = model.plan.scheme == Scheme::Yade;
        twin.forces(if advances { model.plan.step } else { 0.0 });
        twin
    }

    /// One step: from one force pass to after the next.
    pub fn step(&mut self) {
        let h = self.model.plan.step;
        let scheme = self.model.plan.scheme;
        if scheme == Scheme::PathAveraged {
            self.averaged_step(h);
            return;
        }
        let kick = if scheme == Scheme::Yade { h } else { 0.5 * h };
        for body in 0..self.states.len() {
            self.push(body, kick);
            let velocity = self.states[body].velocity;
            self.states[body].position += velocity * h;
            self.turn(body, h);
        }
        self.steps += 1;
        self.forces(h);
        if scheme != Scheme::Yade {
            for body in 0..self.states.len() {
                self.push(body, kick);
                if self.single[body] {
                    self.twist(body, kick);
                } else {
                    self.momenta[body] += self.torque[body] * kick;
                    self.follow(body);
                }
            }
        }
    }

    fn averaged_step(&mut self, h: f64) {
        self.averaged_drift(0.5 * h);
        self.steps += 1;
        self.forces(h);
        for body in 0..self.states.len() {
            self.push(body, h);
            if self.single[body] {
                self.twist(body, h);
            } else {
                self.momenta[body] += self.torque[body] * h;
            }
        }
        self.averaged_drift(0.5 * h);
    }

    fn averaged_drift(&mut self, h: f64) {
        for body in 0..self.states.len() {
            let velocity = self.states[body].velocity;
            self.states[body].position += velocity * h;
            if !self.single[body] {
                self.turn(body, h);
            }
        }
    }

    fn push(&mut self, body: usize, span: f64) {
        let mass = self.model.bodies[body].mass;
        self.states[body].velocity += (self.force[body] / mass + self.setting.gravity) * span;
    }

    fn twist(&mut self, body: usize, span: f64) {
        self.states[body].spin += self.torque[body] / self.model.bodies[body].inertia.z * span;
    }

    /// Spin from angular momentum.
    fn follow(&mut self, body: usize) {
        let inertia = &self.model.bodies[body].inertia;
        let state = &mut self.states[body];
        state.spin = turn::spin(&state.orientation, inertia, &self.momenta[body]);
    }

    fn turn(&mut self, body: usize, h: f64) {
        let scheme = self.model.plan.scheme;
        if self.single[body] {
            self.twist(body, if scheme == Scheme::Yade { h } else { 0.5 * h });
            return;
        }
        let inertia = self.model.bodies[body].inertia;
        let from = self.states[body].orientation;
        match scheme {
            Scheme::Yade if self.setting.planar => {
                let moment = turn::momentum(&from, &inertia, &Vec3::z()).z;
                let state = &mut self.states[body];
                state.spin.z += h * self.torque[body].z / moment;
                state.orientation = Rotation::from_scaled_axis(state.spin * h) * from;
            }
            Scheme::Yade => {
                let (to, momentum, spin) =
                    turn::yade(&from, &inertia, &self.momenta[body], &self.torque[body], h);
                self.momenta[body] = momentum;
                (self.states[body].orientation, self.states[body].spin) = (to, spin);
            }
            Scheme::Liggghts | Scheme::Lammps => {
                self.momenta[body] += self.torque[body] * (0.5 * h);
                let (to, spin) = turn::richardson(&from, &inertia, &self.momenta[body], h);
                (self.states[body].orientation, self.states[body].spin) = (to, spin);
            }
            // Only half a step, without a kick.
            Scheme::PathAveraged => {
                self.states[body].orientation =
                    turn::split(&from, &inertia, &self.momenta[body], h);
                self.follow(body);
            }
            Scheme::Leapfrog => {
                self.momenta[body] += self.torque[body] * (0.5 * h);
                self.states[body].orientation =
                    turn::split(&from, &inertia, &self.momenta[body], h);
                self.follow(body);
            }
        }
    }

    fn grain(&self, sphere: usize) -> Grain {
        let shape = &self.model.spheres[sphere];
        let state = &self.states[shape.body as usize];
        let arm = state.orientation * shape.offset;
        Grain {
            place: state.position + arm,
            velocity: state.velocity + state.spin.cross(&arm),
            spin: state.spin,
            radius: shape.radius,
            body: shape.body as usize,
        }
    }

    fn forces(&mut self, advance: f64) {
        self.before = (self.force.clone(), self.torque.clone());
        self.force.fill(Vec3::zeros());
        self.torque.fill(Vec3::zeros());
        let grains: Vec<Grain> = (0..self.model.spheres.len()).map(|s| self.grain(s)).collect();
        let old = std::mem::take(&mut self.springs);
        for (index, grain) in grains.iter().enumerate() {
            let mut others = Vec::new();
            self.spheres_at(index, &grains, &mut others);
            self.planes_at(index, grain, &mut others);
            self.faces_at(index, grain, &mut others);
            for other in others {
                let spring = self.inherited(&old, &other.key);
                self.touch(grain, &grains, other, spring, advance);
            }
        }
        if self.setting.planar {
            for (force, torque) in self.force.iter_mut().zip(&mut self.torque) {
                force.z = 0.0;
                (torque.x, torque.y) = (0.0, 0.0);
            }
        }
    }

    fn inherited(&self, old: &BTreeMap<Key, Spring>, key: &Key) -> Option<Spring> {
        if let Some(spring) = old.get(key) {
            return Some(*spring);
        }
        (key.1 == 2).then_some(())?;
        old.range((key.0, 2, 0)..(key.0, 3, 0))
            .find(|(name, _)| self.setting.surfaces.coplanar(key.2 as u32, name.2 as u32))
            .map(|(_, spring)| *spring)
    }

    fn spheres_at(&self, index: usize, grains: &[Grain], others: &mut Vec<Other>) {
        let (grain, share) = (&grains[index], self.setting.share);
        let slide = self.setting.slide_share;
        for (there, other) in grains.iter().enumerate().skip(index + 1) {
            let between = grain.place - other.place;
            let overlap = grain.radius + other.radius - between.norm();
            if other.body == grain.body || (overlap <= 0.0 && !self.averaged()) {
                continue;
            }
            others.push(Other {
                key: (index, 0, there),
                normal: between.normalize(),
                overlap,
                arms: [grain.radius - share * overlap, other.radius - share * overlap],
                slides: [grain.radius - slide * overlap, other.radius - slide * overlap],
                before: between - (grain.velocity - other.velocity) * (0.5 * self.span()),
                lean: share,
                velocity: other.velocity,
                spin: other.spin,
                body: Some(other.body),
                material: self.model.bodies[other.body].material,
            });
        }
    }

    fn planes_at(&self, index: usize, grain: &Grain, others: &mut Vec<Other>) {
        let time = self.setting.pass_time(self.steps);
        for (number, plane) in self.setting.planes_at(time).iter().enumerate() {
            let motion = self.seen(self.setting.planes[number] as usize, plane.motion);
            let height = (grain.place - plane.point).dot(&plane.normal);
            let overlap = grain.radius - height.abs();
            if overlap < 0.0 && !self.averaged() {
                continue;
            }
            let normal = plane.normal * height.signum();
            let foot = grain.place - plane.normal * height;
            // YADE takes the velocity where the arm ends.
            let deep = self.model.plan.scheme == Scheme::Yade;
            let depth = if deep { (1.0 - plane.share) * overlap } else { 0.0 };
            others.push(Other {
                key: (index, 1, number),
                normal,
                overlap,
                arms: [grain.radius - plane.share * overlap, 0.0],
                slides: [grain.radius - plane.share * overlap, 0.0],
                before: normal * height.abs()
                    - plane.normal
                        * ((grain.velocity - motion.velocity(&foot)).dot(&plane.normal)
                            * 0.5
                            * self.span()),
                lean: plane.share,
                velocity: motion.velocity(&(foot - normal * depth)),
                spin: wall_spin(&motion),
                body: None,
                material: plane.material,
            });
        }
    }

    fn faces_at(&self, index: usize, grain: &Grain, others: &mut Vec<Other>) {
        let time = self.setting.pass_time(self.steps);
        let surfaces = &self.setting.surfaces;
        let mut met: Vec<u32> = Vec::new();
        for face in 0..surfaces.start.len() {
            let number = surfaces.wall[face] as usize;
            let wall = &self.model.walls[number];
            let motion = self.seen(number, wall.motion);
            let corners = surfaces.start[face].map(|p| wall.motion.place(&p, time));
            let (point, feature) = closest(&grain.place, &corners);
            let away = grain.place - point;
            let again = feature == Feature::Face
                && met.iter().any(|other| surfaces.coplanar(face as u32, *other));
            let reach = match self.averaged() {
                true if self.steps > 0 => {
                    let rate = (grain.velocity - wall.motion.velocity(&point)).dot(&away);
                    grain.radius + 0.5 * self.model.plan.step * rate.abs() / away.norm()
                }
                _ => grain.radius,
            };
            if away.norm() > reach || !surfaces.acts(face, feature) || again {
                continue;
            }
            met.push(face as u32);
            let overlap = grain.radius - away.norm();
            let deep = self.model.plan.scheme == Scheme::Yade;
            let depth = if deep { (1.0 - self.setting.wall_share) * overlap } else { 0.0 };
            others.push(Other {
                key: (index, 2, face),
                normal: away.normalize(),
                overlap,
                arms: [grain.radius - self.setting.wall_share * overlap, 0.0],
                slides: [grain.radius - self.setting.wall_share * overlap, 0.0],
                before: {
                    let drift = grain.velocity - wall.motion.velocity(&point);
                    let place = grain.place - drift * (0.5 * self.span());
                    place - closest(&place, &corners).0
                },
                lean: self.setting.wall_share,
                velocity: motion.velocity(&(point - away.normalize() * depth)),
                spin: wall_spin(&motion),
                body: None,
                material: wall.material,
            });
        }
    }

    /// Motion of a wall as the pass of this step sees it.
    fn seen(&self, wall: usize, motion: Motion) -> Motion {
        let rests = self.model.walls[wall].rests_at_set_up(self.model.plan.scheme);
        if self.steps == 0 && rests { Motion::Still } else { motion }
    }

    /// How far back the beginning of the step lies, s.
    fn span(&self) -> f64 {
        if self.steps == 0 { 0.0 } else { self.model.plan.step }
    }

    fn averaged(&self) -> bool {
        self.model.plan.scheme == Scheme::PathAveraged
    }

    fn touch(
        &mut self,
        grain: &Grain,
        grains: &[Grain],
        other: Other,
        old: Option<Spring>,
        advance: f64,
    ) {
        let law = self.model.plan.law;
        let pair =
            self.model.contacts.between(self.model.bodies[grain.body].material, other.material);
        let n = other.normal;
        let mine = grain.velocity + grain.spin.cross(&(n * -other.slides[0]));
        let theirs = other.velocity
            + if other.body.is_some() {
                other.spin.cross(&(n * other.slides[1]))
            } else {
                Vec3::zeros()
            };
        let relative = mine - theirs;
        let normal_part = relative.dot(&n);
        let slide = relative - n * normal_part;
        if self.averaged() {
            self.touch_along_path((grain, grains), &other, old, (normal_part, slide), advance);
            return;
        }
        let mut normal = pair.kn * other.overlap - pair.cn * normal_part;
        if !law.tension {
            normal = normal.max(0.0);
        }
        let mut stretch = old.map_or(Vec3::zeros(), |spring| {
            let s = spring.stretch;
            match law.history {
                History::Projected => s,
                History::Rescaled => {
                    let flat = s - n * s.dot(&n);
                    if flat.norm() > 0.0 { flat * (s.norm() / flat.norm()) } else { flat }
                }
                History::Rotated => {
                    let a = s - s.cross(&spring.normal.cross(&n));
                    let twist = 0.5 * advance * spring.normal.dot(&(grain.spin + other.spin));
                    a - a.cross(&(spring.normal * twist))
                }
            }
        });
        stretch += slide * advance;
        if law.history == History::Projected {
            stretch -= n * stretch.dot(&n);
        }
        let limit = pair.friction * normal.abs();
        let lammps_starts = self.model.plan.scheme == Scheme::Lammps && self.steps == 0;
        let tangent = match law.coulomb {
            Coulomb::SpringThenDashpot if pair.kt * stretch.norm() > limit => {
                stretch *= limit / (pair.kt * stretch.norm());
                stretch * -pair.kt
            }
            Coulomb::SpringThenDashpot => stretch * -pair.kt - slide * pair.ct,
            Coulomb::Spring => {
                let size = pair.kt * stretch.norm();
                if size > limit {
                    stretch *= limit / size;
                }
                stretch * -pair.kt - slide * pair.ct
            }
            Coulomb::Sum => {
                let pull = stretch * pair.kt + slide * pair.ct;
                let size = pull.norm();
                if size > limit && lammps_starts && stretch == Vec3::zeros() {
                    Vec3::zeros()
                } else if size > limit {
                    stretch = (pull * (limit / size) - slide * pair.ct) / pair.kt;
                    pull * (-limit / size)
                } else {
                    -pull
                }
            }
        };
        self.springs.insert(other.key, Spring { stretch, normal: n, force: Vec3::zeros() });
        self.load(grain, grains, &other, n * normal + tangent);
    }

    /// Adds the force of a contact.
    fn load(&mut self, grain: &Grain, grains: &[Grain], other: &Other, force: Vec3) {
        let n = other.normal;
        let (body, second) = (grain.body, other.body);
        self.force[body] += force;
        let lever = grain.place - n * other.arms[0] - self.states[body].position;
        self.torque[body] += lever.cross(&force);
        if let Some(second) = second {
            let point = grains[other.key.2].place + n * other.arms[1];
            self.force[second] -= force;
            self.torque[second] -= (point - self.states[second].position).cross(&force);
        }
    }

    /// Acceleration of the point of a body at `lever` from its centre of mass by force and torque.
    fn acceleration(&self, body: usize, lever: Vec3, force: Vec3, torque: Vec3) -> Vec3 {
        let (state, of) = (&self.states[body], &self.model.bodies[body]);
        let local = state.orientation.inverse_transform_vector(&torque);
        let twist = if self.single[body] {
            torque / of.inertia.z
        } else {
            state.orientation * local.component_div(&of.inertia)
        };
        force / of.mass + twist.cross(&lever)
    }

    /// Mean force of a contact over the step; `rate` of the gap and sliding velocity before the kick.
    fn touch_along_path(
        &mut self,
        (grain, grains): (&Grain, &[Grain]),
        other: &Other,
        old: Option<Spring>,
        (rate, slide): (f64, Vec3),
        h: f64,
    ) {
        let pair =
            *self.model.contacts.between(self.model.bodies[grain.body].material, other.material);
        let n = other.normal;
        let (g0, g1) = (-other.overlap - 0.5 * h * rate, -other.overlap + 0.5 * h * rate);
        if g0 >= 0.0 && g1 >= 0.0 {
            return;
        }
        let from = if g0 >= 0.0 { g0 / (g0 - g1) } else { 0.0 };
        let to = if g1 >= 0.0 { g0 / (g0 - g1) } else { 1.0 };
        let part = to - from;
        let gap_at = |s: f64| g0 + (g1 - g0) * s;
        // Levers of both bodies, and what a unit force along d does to the relative motion.
        let first = grain.place - n * other.arms[0] - self.states[grain.body].position;
        let second = other.body.map(|body| {
            let point = grains[other.key.2].place + n * other.arms[1];
            (body, point - self.states[body].position)
        });
        let yields = |d: Vec3| {
            let mine = self.acceleration(grain.body, first, d, first.cross(&d)).dot(&d);
            let theirs = second.map_or(0.0, |(body, lever)| {
                self.acceleration(body, lever, d, lever.cross(&d)).dot(&d)
            });
            mine + theirs
        };
        let (force, torque) = &self.before;
        let by_loads = |body: usize, lever: Vec3| {
            self.acceleration(body, lever, force[body], torque[body]) + self.setting.gravity
        };
        let pull = by_loads(grain.body, first)
            - second.map_or(Vec3::zeros(), |(body, lever)| by_loads(body, lever));
        // Velocity of the centre and spin half a step before.
        let earlier = |body: usize, place: Vec3, velocity: Vec3, spin: Vec3| {
            if self.single[body] {
                return (velocity, spin);
            }
            let state = &self.states[body];
            let lever = place - state.position;
            let torque = self.momenta[body].cross(&state.spin);
            let local = state.orientation.inverse_transform_vector(&torque);
            let twist = state.orientation * local.component_div(&self.model.bodies[body].inertia);
            let pull = twist.cross(&lever) + state.spin.cross(&state.spin.cross(&lever));
            (velocity - pull * (0.5 * h), spin - twist * (0.5 * h))
        };
        let early = {
            let away = other.before.normalize();
            let gap = match other.body {
                Some(_) => other.before.norm() - grain.radius - grains[other.key.2].radius,
                None => other.before.norm() - grain.radius,
            };
            let (v, w) = earlier(grain.body, grain.place, grain.velocity, grain.spin);
            let mine = v - w.cross(&away) * (grain.radius + other.lean * gap);
            let theirs = other.body.map_or(other.velocity, |body| {
                let there = &grains[other.key.2];
                let (v, w) = earlier(body, there.place, there.velocity, there.spin);
                v + w.cross(&away) * (there.radius + other.lean * gap)
            });
            let whole = mine - theirs;
            let flat = whole - away * whole.dot(&away);
            flat - n * flat.dot(&n)
        };
        let own = old.map_or(Vec3::zeros(), |spring| spring.force);
        let ease = yields(n);
        // The normal force of the last pass is kept as a number, along the normal of then.
        let own_normal = old.map_or(0.0, |spring| spring.force.dot(&spring.normal));
        let free = rate + 0.5 * h * (pull.dot(&n) - own_normal * ease);
        let spring_force = -pair.kn * gap_at(0.5 * (from + to)) * part;
        let mut normal =
            (spring_force - pair.cn * part * free) / (1.0 + 0.5 * h * pair.cn * part * ease);
        // Over the window the force falls or rises linearly by kn times the change of the gap.
        let change = pair.kn * (gap_at(to) - gap_at(from)).abs();
        let weakest = (normal / part - 0.5 * change).max(0.0);
        if !self.model.plan.law.tension && pair.cn + pair.ct > 0.0 {
            let (high, low) = (normal / part + 0.5 * change, normal / part - 0.5 * change);
            if high <= 0.0 {
                normal = 0.0;
            } else if low < 0.0 {
                normal = 0.5 * high * (high / (high - low)) * part;
            }
        }
        let turned = old.map(|spring| {
            let flat = spring.stretch - n * spring.stretch.dot(&n);
            let size = flat.norm();
            if size > 0.0 { flat * (spring.stretch.norm() / size) } else { flat }
        });
        let dashed = pair.ct > 0.0;
        let begun = match turned {
            Some(kept) => kept + early * (0.5 * h),
            None if dashed && pair.kt > 0.0 && early.norm() > 0.0 => {
                let over = pair.ct * early.norm() - pair.friction * weakest;
                early.normalize() * (-over.max(0.0) / pair.kt)
            }
            None => Vec3::zeros(),
        };
        let mut stretch = begun + early * (0.5 * part * h);
        let mut sliding = slide;
        if pair.ct > 0.0 && slide.norm() > 0.0 {
            let ease = yields(slide.normalize());
            let before = old.map_or(Vec3::zeros(), |s| own - s.normal * own.dot(&s.normal));
            let others = pull - before * ease;
            let others = others - n * others.dot(&n);
            let implicit = 0.5 * h * ease * part;
            sliding = (slide + others * (0.5 * h) - stretch * (implicit * pair.kt))
                / (1.0 + implicit * pair.ct);
        }
        let limit = pair.friction * normal.abs() / part;
        let mut pull = stretch * pair.kt + sliding * pair.ct;
        let slips = pull.norm() > limit;
        if slips {
            let back = match old {
                Some(spring) if dashed => {
                    let side = spring.force - spring.normal * spring.force.dot(&spring.normal);
                    (n * side.dot(&n) - side).try_normalize(0.0)
                }
                Some(_) => turned.and_then(|turned| turned.try_normalize(0.0)),
                None => None,
            };
            pull = match back.filter(|back| back.dot(&pull) > 0.0 && pair.kt > 0.0) {
                // limit n1 = pull - cut (back + n1) / 2
                Some(back) => {
                    let cut = (pull.norm_squared() - limit * limit) / (limit + pull.dot(&back));
                    (pull - back * (0.5 * cut)).normalize() * limit
                }
                None => pull * (limit / pull.norm()),
            };
            if pair.kt > 0.0 {
                stretch = (pull - sliding * pair.ct) / pair.kt;
            }
        }
        let force = n * normal - pull * part;
        if to == 1.0 {
            let end = if old.is_none() && slips && !dashed {
                stretch * 2.0
            } else {
                stretch + early * (0.5 * part * h)
            };
            let stretch = end - early * (0.5 * self.model.plan.step);
            self.springs.insert(other.key, Spring { stretch, normal: n, force });
        }
        self.load(grain, grains, other, force);
    }
}
