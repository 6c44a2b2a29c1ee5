//! From a solid to a clump: the method finds spheres, the rest is the same for all.

use super::fidelity::{POINTS, compare};
use super::target::{Found, Target};
use super::{
    Axial, Clump, ClumpError, Dynamic, Euclidean, Fitted, FourPoints, Lattice, Nodes, Normals,
    Replaced,
};
use crate::geometry::{Ball, MassProperties, united};
use crate::num::random::{Stream, stream};
use crate::num::{Fault, Job};
use crate::shape::Solid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How spheres are found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Greedy cover, then all centres and radii by least squares.
    Fitted(Fitted),
    /// Equal spheres at all inner nodes of a grid (R1).
    Nodes(Nodes),
    /// Small spheres, groups of which are replaced by larger ones (R2).
    Replaced(Replaced),
    /// Random spheres moved and grown by virtual forces (R3).
    Dynamic(Dynamic),
    /// Spheres through four surface points (R4).
    FourPoints(FourPoints),
    /// Spheres grown along inward normals (R5).
    Normals(Normals),
    /// Spheres along the long axis.
    Axial(Axial),
    /// Largest spheres of a voxel image.
    Euclidean(Euclidean),
    /// Touching equal spheres on a lattice (D4).
    Lattice(Lattice),
}

/// What the mass, centre and inertia of a clump are taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MassSource {
    /// The solid it stands for.
    #[default]
    Solid,
    /// The union of its spheres, overlaps counted once.
    Union,
    /// The union of its spheres, its density corrected so that the mass is that of the solid.
    Corrected,
}

impl Method {
    /// The method with this key, set up for at most `spheres` spheres (R1: the
    /// grid whose nodes in a ball of the solid's volume come nearest to that).
    pub fn with_spheres(key: &str, spheres: u32) -> Option<Self> {
        let count = spheres as usize;
        match key {
            "fitted" => Some(Self::Fitted(Fitted { spheres: count, ..Fitted::default() })),
            "replaced" => Some(Self::Replaced(Replaced { spheres: count, ..Replaced::default() })),
            "dynamic" => Some(Self::Dynamic(Dynamic { spheres: count, ..Dynamic::default() })),
            "four_points" => {
                Some(Self::FourPoints(FourPoints { spheres: count, ..FourPoints::default() }))
            }
            "axial" => Some(Self::Axial(Axial { spheres: count, ..Axial::default() })),
            "euclidean" => {
                Some(Self::Euclidean(Euclidean { spheres: count, ..Euclidean::default() }))
            }
            "nodes" => {
                let across =
                    (6.0 * f64::from(spheres) / std::f64::consts::PI).cbrt().clamp(2.0, 100.0);
                Some(Self::Nodes(Nodes { across, ..Nodes::default() }))
            }
            "normals" => {
                // The more spheres, the less each of them may stick out (measured on eight rocks).
                let protrusion = (0.4 / f64::from(spheres)).clamp(0.002, 0.03);
                let smallest = (0.6 / f64::from(spheres)).clamp(0.01, 0.03);
                Some(Self::Normals(Normals {
                    spheres: count,
                    protrusion,
                    smallest,
                    ..Normals::default()
                }))
            }
            _ => None,
        }
    }

    /// # Errors
    /// [`Fault`] for a parameter out of its range, under the key of the method.
    pub fn validate(&self) -> Result<(), Fault> {
        let (checked, key) = match self {
            Self::Fitted(method) => (method.validate(), "fitted"),
            Self::Nodes(method) => (method.validate(), "nodes"),
            Self::Replaced(method) => (method.validate(), "replaced"),
            Self::Dynamic(method) => (method.validate(), "dynamic"),
            Self::FourPoints(method) => (method.validate(), "four_points"),
            Self::Normals(method) => (method.validate(), "normals"),
            Self::Axial(method) => (method.validate(), "axial"),
            Self::Euclidean(method) => (method.validate(), "euclidean"),
            Self::Lattice(method) => (method.validate(), "lattice"),
        };
        checked.map_err(|fault| fault.under(key))
    }

    fn find(&self, target: &Target, source: &mut Stream, job: &Job) -> Result<Found, ClumpError> {
        match self {
            Self::Fitted(method) => method.find(target, job),
            Self::Nodes(method) => method.find(target, job),
            Self::Replaced(method) => method.find(target, job),
            Self::Dynamic(method) => method.find(target, source, job),
            Self::FourPoints(method) => method.find(target, source, job),
            Self::Normals(method) => method.find(target, source, job),
            Self::Axial(method) => method.find(target, job),
            Self::Euclidean(method) => method.find(target, job),
            Self::Lattice(method) => method.find(target, job),
        }
    }
}

/// The spheres that `method` finds for `solid`, in the frame of the solid; nothing is measured.
///
/// # Errors
/// As [`reproduce`].
pub fn spheres(
    solid: &Solid,
    method: &Method,
    seed: u64,
    index: u64,
    job: &Job,
) -> Result<Vec<Ball>, ClumpError> {
    method.validate()?;
    Ok(method.find(&Target::new(solid)?, &mut stream(seed, "clump", index), job)?.balls)
}

/// The clump that stands for `solid`, which is grain `index` of a scene with `seed`.
///
/// The body frame has its origin at the centre of mass and its axes along the
/// principal axes of what `mass` names; with [`MassSource::Solid`] the spheres may
/// have their own centroid elsewhere, by what [`super::Fidelity::centroid_error`]
/// says. Spheres form one connected piece.
///
/// # Errors
/// [`ClumpError`]: bad parameters, a surface that is not closed, no place for a
/// sphere, or cancelled.
pub fn reproduce(
    solid: &Solid,
    method: &Method,
    mass: MassSource,
    seed: u64,
    index: u64,
    job: &Job,
) -> Result<Clump, ClumpError> {
    method.validate()?;
    let target = Target::new(solid)?;
    let found = method.find(&target, &mut stream(seed, "clump", index), job)?;
    let properties = match mass {
        MassSource::Solid => solid.mass,
        MassSource::Union => united::balls(&found.balls, 4 * united::PANELS).mass,
        MassSource::Corrected => {
            let union = united::balls(&found.balls, 4 * united::PANELS).mass;
            let density = solid.mass.volume / union.volume;
            MassProperties { volume: solid.mass.volume, inertia: union.inertia * density, ..union }
        }
    };
    let (inertia, axes) = properties.principal();
    let balls = found
        .balls
        .iter()
        .map(|b| Ball {
            centre: axes.inverse_transform_vector(&(b.centre - properties.centroid)),
            radius: b.radius,
        })
        .collect();
    Ok(Clump {
        name: solid.name.clone(),
        method: found.note,
        balls,
        volume: properties.volume,
        inertia,
        centroid: properties.centroid,
        axes,
        fidelity: Some(compare(&target, &found.balls, POINTS)),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{Order, Place, measure, pieces};
    use super::*;
    use crate::geometry::Mesh;
    use crate::geometry::SignedDistance;
    use crate::geometry::samples::{box_mesh, ellipsoid_mesh, icosphere, l_mesh, random_star};
    use crate::num::{Mat3, Rotation, Vec3};

    pub fn solid(name: &str, mesh: Mesh) -> Solid {
        let mass = mesh.mass_properties();
        Solid { name: name.to_owned(), mesh, mass, recipe: String::new() }
    }

    fn zoo() -> Vec<Solid> {
        let off = Vec3::new(0.3, -2.0, 1.0);
        vec![
            solid("box", box_mesh(Vec3::new(1.0, 1.4, 2.0)).mapped(|v| v + off)),
            solid("ellipsoid", ellipsoid_mesh(Vec3::new(1.0, 0.7, 0.5)).mapped(|v| v * 1e-3)),
            solid("l", l_mesh()),
            solid("star", random_star(7, 0.5)),
        ]
    }

    fn make(solid: &Solid, method: &Method, mass: MassSource) -> Clump {
        reproduce(solid, method, mass, 1, 2, &Job::quiet()).expect("a clump")
    }

    fn rms(clump: &Clump) -> f64 {
        let f = clump.fidelity.expect("measured");
        f.rms_distance / f.equivalent_diameter
    }

    fn nodes(across: f64, place: Place) -> Method {
        Method::Nodes(Nodes { across, place, ..Nodes::default() })
    }

    fn normals(spheres: usize, protrusion: f64) -> Method {
        Method::Normals(Normals { spheres, protrusion, points: 500, ..Normals::default() })
    }

    #[test]
    fn inscribed_spheres_never_stick_out_and_hang_together() {
        for solid in zoo() {
            let distance = SignedDistance::new(&solid.mesh).expect("closed");
            let diameter = solid.mass.equivalent_diameter();
            for method in [nodes(8.0, Place::Inscribed), normals(30, 0.0), normals(30, 0.03)] {
                let allowed = if method == normals(30, 0.03) { 0.03 * diameter } else { 0.0 };
                let clump = make(&solid, &method, MassSource::Solid);
                for ball in clump.in_solid_frame() {
                    let out = ball.radius + distance.at(&ball.centre);
                    assert!(out <= allowed + 1e-9 * diameter, "{} {out:e}", clump.method);
                }
                assert!(pieces::label(&clump.balls).iter().all(|&piece| piece == 0));
                let f = clump.fidelity.expect("measured");
                assert!(allowed > 0.0 || f.volume_error < 0.0);
                assert!(f.largest_distance < 0.6 * diameter && f.rms_distance > 0.0);
            }
        }
    }

    #[test]
    fn error_falls_with_more_spheres() {
        for solid in zoo() {
            let fit: Vec<f64> = [3, 12, 48]
                .map(|n| rms(&make(&solid, &normals(n, 0.01), MassSource::Solid)))
                .into();
            assert!(fit[1] < fit[0] && fit[2] < fit[1], "{} {fit:?}", solid.name);
            // Turned, because on a grid-aligned solid the error depends on where the grid falls.
            let turn = Rotation::from_euler_angles(0.4, 0.7, 1.1);
            let solid = self::solid(&solid.name, solid.mesh.mapped(|v| turn * v));
            let grid: Vec<f64> = [4.0, 10.0]
                .map(|n| rms(&make(&solid, &nodes(n, Place::Straddling), MassSource::Solid)))
                .into();
            assert!(grid[1] < 0.7 * grid[0], "{} {grid:?}", solid.name);
        }
    }

    #[test]
    fn balanced_nodes_keep_the_volume_better_than_either_side() {
        for solid in zoo() {
            let volume = |place| {
                let clump = make(&solid, &nodes(9.0, place), MassSource::Solid);
                clump.fidelity.expect("measured").volume_error
            };
            let [low, middle, high] =
                [Place::Inscribed, Place::Balanced, Place::Straddling].map(volume);
            assert!(low < middle && middle < high, "{} {low} {middle} {high}", solid.name);
            assert!(middle.abs() < low.abs() && middle.abs() < high.abs());
        }
    }

    #[test]
    fn nodes_of_a_cube_are_those_of_the_grid() {
        // Edge 1 about the origin: spacing h, nodes at −0.5 < i·h < 0.5, radius 0.9 h.
        let cube = solid("cube", box_mesh(Vec3::repeat(1.0)));
        let across = cube.mass.equivalent_diameter() / 0.24;
        assert_eq!(
            make(&cube, &nodes(across, Place::Straddling), MassSource::Solid).balls.len(),
            125
        );
        // |i|·0.24 ≤ 0.5 − 0.216.
        assert_eq!(
            make(&cube, &nodes(across, Place::Inscribed), MassSource::Solid).balls.len(),
            27
        );
    }

    #[test]
    fn the_same_seed_gives_the_same_clump_and_another_a_different_one() {
        let star = solid("star", random_star(9, 0.4));
        for order in [Order::Fit, Order::Random] {
            let method = Method::Normals(Normals { order, points: 400, ..Normals::default() });
            let run = |seed| reproduce(&star, &method, MassSource::Solid, seed, 0, &Job::quiet());
            let first = run(5).expect("a clump");
            assert_eq!(first, run(5).expect("a clump"));
            assert_ne!(first.balls, run(6).expect("a clump").balls);
        }
    }

    #[test]
    fn size_does_not_matter() {
        let base = random_star(9, 0.4);
        let method = normals(15, 0.02);
        let unit = make(&solid("a", base.clone()), &method, MassSource::Union);
        let small =
            make(&solid("a", base.mapped(|v| v * 2f64.powi(-14))), &method, MassSource::Union);
        assert_eq!(unit.balls.len(), small.balls.len());
        for (a, b) in unit.balls.iter().zip(&small.balls) {
            assert!((a.centre - b.centre * 2f64.powi(14)).norm() < 1e-9);
            assert!((a.radius - b.radius * 2f64.powi(14)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_corrected_density_keeps_the_mass_and_turns_like_the_union() {
        let solid = solid("l", l_mesh());
        let [of_solid, of_union, corrected] =
            [MassSource::Solid, MassSource::Union, MassSource::Corrected]
                .map(|mass| make(&solid, &normals(8, 0.05), mass));
        assert!((of_union.volume / of_solid.volume - 1.0).abs() > 0.01);
        assert_eq!(corrected.volume, of_solid.volume);
        for (a, b) in corrected.balls.iter().zip(&of_union.balls) {
            assert!((a.centre - b.centre).norm() < 1e-12 && a.radius == b.radius);
        }
        let [a, b] = [&corrected, &of_union].map(|clump| clump.inertia / clump.volume);
        assert!((a - b).norm() < 1e-12 * b.norm());
    }

    #[test]
    fn the_frame_is_principal_and_centred() {
        for solid in zoo() {
            let clump = make(&solid, &normals(10, 0.02), MassSource::Solid);
            let body = solid
                .mesh
                .mapped(|v| clump.axes.inverse_transform_vector(&(v - clump.centroid)))
                .mass_properties();
            let scale = body.inertia.norm();
            let diagonal = Mat3::from_diagonal(&clump.inertia);
            assert!((body.inertia - diagonal).norm() < 1e-12 * scale, "{}", solid.name);
            assert!(body.centroid.norm() < 1e-13 * solid.mesh.bounds().diagonal() + 1e-15);
            assert!(clump.inertia.x <= clump.inertia.y && clump.inertia.y <= clump.inertia.z);
            assert_eq!(clump.volume, solid.mass.volume);

            let own = make(&solid, &normals(10, 0.02), MassSource::Union);
            let union = united::balls(&own.balls, 4 * united::PANELS).mass;
            let diameter = solid.mass.equivalent_diameter();
            assert!((union.volume / own.volume - 1.0).abs() < 1e-5);
            assert!(union.centroid.norm() < 1e-5 * diameter);
            let wrong = (union.inertia - Mat3::from_diagonal(&own.inertia)).norm();
            assert!(wrong < 1e-4 * union.inertia.norm());
        }
    }

    #[test]
    fn a_ball_becomes_one_sphere() {
        let ball = solid("ball", icosphere(3));
        let method = Method::Normals(Normals { coverage: 0.99, ..Normals::default() });
        let clump = make(&ball, &method, MassSource::Solid);
        assert_eq!(clump.balls.len(), 1, "{}", clump.method);
        // Touching on one side it may stick out by 0.02 diameters on the other.
        assert!((clump.bounding_radius() - 1.0).abs() < 0.045);
        assert!(measure(&ball, &clump.in_solid_frame(), 500).expect("closed").rms_distance < 0.03);
    }

    #[test]
    fn extreme_solids_give_a_clump_or_say_why_not() {
        let shapes = [
            ("needle", box_mesh(Vec3::new(100.0, 1.0, 1.0)), true),
            ("plate", box_mesh(Vec3::new(30.0, 30.0, 1.0)), true),
            ("leaf", box_mesh(Vec3::new(100.0, 100.0, 0.01)), false),
            ("sliver", ellipsoid_mesh(Vec3::new(1.0, 0.05, 0.02)), true),
            ("spiky", random_star(3, 0.95), true),
            // A grain of a micrometre, and one a thousand sizes away from the origin.
            ("dust", random_star(3, 0.5).mapped(|v| v * 1e-6), true),
            ("far", random_star(3, 0.5).mapped(|v| v + Vec3::repeat(1e3)), true),
        ];
        let turn = Rotation::from_euler_angles(0.4, 0.7, 1.1);
        for (name, mesh, fits) in shapes {
            let solid = solid(name, mesh.mapped(|v| turn * v));
            let result =
                reproduce(&solid, &normals(25, 0.02), MassSource::Union, 1, 0, &Job::quiet());
            assert_eq!(result.is_ok(), fits, "{name}");
            let Ok(clump) = result else { continue };
            let f = clump.fidelity.expect("measured");
            let numbers = [clump.volume, clump.inertia.x, f.rms_distance, f.inertia_error];
            assert!(numbers.iter().all(|n| n.is_finite() && *n > 0.0), "{name} {f:?}");
            assert!(clump.inertia.x + clump.inertia.y >= clump.inertia.z * (1.0 - 1e-9));
            assert!(f.largest_distance <= solid.mesh.bounds().diagonal());
        }
        let needle = solid("needle", box_mesh(Vec3::new(100.0, 0.1, 0.1)).mapped(|v| turn * v));
        let failed = reproduce(
            &needle,
            &nodes(100.0, Place::Balanced),
            MassSource::Solid,
            1,
            0,
            &Job::quiet(),
        );
        assert!(matches!(failed, Err(ClumpError::Input(fault)) if fault.key == "nodes.across"));
    }

    #[test]
    fn wrong_input_is_named() {
        let method = Method::Nodes(Nodes { across: -1.0, ..Nodes::default() });
        assert_eq!(method.validate().expect_err("negative").key, "nodes.across");
        let method = Method::Normals(Normals { protrusion: f64::NAN, ..Normals::default() });
        assert_eq!(method.validate().expect_err("nan").key, "normals.protrusion");
        let text = "normals = { spheres = 5, orden = \"fit\" }";
        assert!(
            toml::from_str::<Method>(text).expect_err("misspelt").to_string().contains("orden")
        );
        let method: Method = toml::from_str("nodes = {}").expect("all defaults");
        assert_eq!(method, Method::Nodes(Nodes::default()));
        let mut open = solid("open", box_mesh(Vec3::repeat(1.0)));
        open.mesh.triangles.pop();
        let failed = reproduce(&open, &method, MassSource::Solid, 1, 0, &Job::quiet());
        assert!(matches!(failed, Err(ClumpError::Surface { .. })));
        let flat = solid("flat", box_mesh(Vec3::new(1.0, 1.0, 0.001)));
        let failed = reproduce(&flat, &method, MassSource::Solid, 1, 0, &Job::quiet());
        assert!(matches!(failed, Err(ClumpError::NoSphere { .. })));
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(24))]

        /// Random solids, thin, long, spiky, tiny or huge, by every method: a clump of finite
        /// spheres in one piece, or a reason; never a panic.
        #[test]
        fn any_solid_gets_a_clump_or_a_reason(
            seed in 0u64..10_000,
            spikes in 0.05f64..0.9,
            stretch in proptest::array::uniform3(-1.5f64..1.5),
            power in -12i32..12,
            spheres in 1u32..12,
        ) {
            let factors = Vec3::from(stretch.map(|s| 10f64.powf(s))) * 10f64.powi(power);
            let mesh = random_star(seed, spikes).mapped(|p| p.component_mul(&factors));
            let Ok((mesh, _)) = crate::geometry::check::solid(mesh) else { return Ok(()) };
            let solid = solid("any", mesh);
            let key = super::super::counted().nth(seed as usize % 8).unwrap_or("fitted");
            let method = Method::with_spheres(key, spheres).expect("a counted method");
            let made = reproduce(&solid, &method, MassSource::Solid, seed, 0, &Job::quiet());
            if let Ok(clump) = made {
                let finite = |b: &Ball| b.centre.iter().all(|x| x.is_finite()) && b.radius > 0.0;
                proptest::prop_assert!(clump.balls.iter().all(finite), "{}", clump.method);
                proptest::prop_assert!(pieces::touching(&clump.balls), "{}", clump.method);
                let f = clump.fidelity.expect("measured");
                proptest::prop_assert!(f.rms_distance.is_finite() && f.volume_error.is_finite());
            }
        }
    }
}
