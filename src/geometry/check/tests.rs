use super::*;
use crate::geometry::Primitive;
use crate::geometry::topology::inspect;
use crate::num::{Rotation, random};
use proptest::prelude::*;

fn cube() -> Mesh {
    Primitive::Box { edges: Vec3::repeat(2.0) }.mesh(3)
}

fn both(mut first: Mesh, second: Mesh) -> Mesh {
    let shift = first.vertices.len() as u32;
    first.vertices.extend(second.vertices);
    first.triangles.extend(second.triangles.iter().map(|t| t.map(|corner| corner + shift)));
    first
}

#[test]
fn a_good_solid_passes_unchanged() {
    let (mesh, repairs) = solid(cube()).expect("a cube is a solid");
    assert_eq!(mesh, cube());
    assert!(repairs.is_none(), "{repairs}");
    let report = inspect(&mesh);
    assert!(report.is_closed());
    assert_eq!((report.euler_characteristic, report.pieces, report.edges), (2, 1, 18));
}

#[test]
fn inside_out_is_turned_and_reported() {
    let mut wrong = cube();
    wrong.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let (mesh, repairs) = solid(wrong).expect("repairable");
    assert!(repairs.inside_out && repairs.flipped == 12);
    assert!((mesh.mass_properties().volume - 8.0).abs() < 1e-12);
    assert!(repairs.to_string().contains("inside out"), "{repairs}");
}

#[test]
fn single_turned_triangles_are_turned_back() {
    for first in [0, 5] {
        let mut wrong = cube();
        wrong.triangles[first].swap(0, 2);
        let (mesh, repairs) = solid(wrong).expect("repairable");
        assert_eq!((repairs.flipped, repairs.inside_out), (1, false));
        assert!(inspect(&mesh).is_closed());
    }
}

#[test]
fn a_triangle_soup_is_welded() {
    let soup = cube().facets().fold(Mesh::default(), |mesh, corners| {
        both(mesh, Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] })
    });
    let (mesh, repairs) = solid(soup).expect("a soup of a cube");
    assert_eq!((mesh.vertices.len(), repairs.welded), (8, 28));
}

#[test]
fn nearly_equal_vertices_are_welded_only_when_needed() {
    let shaken = cube().facets().enumerate().fold(Mesh::default(), |mesh, (i, corners)| {
        let shift = Vec3::repeat(1e-6 * (i % 2) as f64);
        let vertices = corners.iter().map(|p| p + shift).collect();
        both(mesh, Mesh { vertices, triangles: vec![[0, 1, 2]] })
    });
    let (mesh, repairs) = solid(shaken).expect("within the loose tolerance");
    assert_eq!((mesh.vertices.len(), repairs.welded), (8, 28));
}

#[test]
fn holes_are_refused_with_number_and_place() {
    let mut open = cube();
    open.triangles.truncate(10);
    let fault = solid(open).expect_err("one face is missing");
    let message = fault.to_string();
    assert!(
        message.starts_with("open: 4 edges belong to one triangle only, first at ("),
        "{message}"
    );
}

#[test]
fn what_is_no_number_names_its_triangle() {
    for bad in [f64::NAN, f64::INFINITY, 1e39] {
        let mut wrong = cube();
        wrong.vertices[7].y = bad;
        let fault = solid(wrong).expect_err("not finite in single precision");
        assert!(matches!(fault, MeshFault::NotFinite { triangle: 3, .. }), "{fault}");
    }
    let mut wrong = cube();
    wrong.triangles[4][2] = 8;
    assert!(solid(wrong).expect_err("bad index").to_string().contains("triangle 4 names vertex 8"));
}

#[test]
fn nothing_and_flat_things_are_refused() {
    assert_eq!(solid(Mesh::default()), Err(MeshFault::Empty { dropped: 0 }));
    let flat = cube().mapped(|p| Vec3::new(p.x, p.y, 0.0));
    assert!(solid(flat).is_err());
    let thin = cube().mapped(|p| Vec3::new(p.x, p.y, 1e-8 * p.z));
    assert!(matches!(solid(thin), Err(MeshFault::NoVolume { .. })));
    let point = cube().mapped(|_| Vec3::repeat(1.0));
    assert_eq!(solid(point), Err(MeshFault::Empty { dropped: 12 }));
}

#[test]
fn two_pieces_are_refused_apart_nested_and_touching() {
    for (shift, scale) in [(5.0, 1.0), (0.0, 0.5)] {
        let other = cube().mapped(|p| p * scale + Vec3::repeat(shift));
        let fault = solid(both(cube(), other)).expect_err("two pieces");
        assert!(matches!(fault, MeshFault::Pieces { pieces: 2, .. }), "{fault}");
    }
    let corner = cube().mapped(|p| p + Vec3::repeat(2.0));
    assert!(matches!(solid(both(cube(), corner)), Err(MeshFault::Pieces { pieces: 2, .. })));
    let edge = cube().mapped(|p| p + Vec3::new(2.0, 2.0, 0.0));
    assert!(matches!(solid(both(cube(), edge)), Err(MeshFault::NonManifold { edges: 1, .. })));
}

#[test]
fn a_shared_face_of_two_boxes_cancels() {
    let mut other = cube().mapped(|p| Vec3::new(2.0 - p.x, p.y, p.z));
    other.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let (mesh, repairs) = solid(both(cube(), other)).expect("one box of edges 4, 2, 2");
    assert_eq!((repairs.cancelled, repairs.welded), (4, 4));
    assert!((mesh.mass_properties().volume - 16.0).abs() < 1e-12);
}

#[test]
fn fins_duplicates_and_degenerate_triangles_go() {
    let mut wrong = cube();
    wrong.triangles.push(wrong.triangles[3]);
    wrong.triangles.push([2, 2, 5]);
    wrong.vertices.push(Vec3::repeat(9.0));
    let (mesh, repairs) = solid(wrong).expect("repairable");
    assert_eq!((repairs.duplicates, repairs.degenerate, repairs.unused), (1, 1, 1));
    assert_eq!(mesh, cube());
}

#[test]
fn a_collinear_triangle_is_given_to_its_neighbour() {
    // The edge 0-2 of a face is split at its middle on one side only, with a
    // triangle of no area in the gap: closed, but degenerate.
    let mut wrong = cube();
    let middle = (wrong.vertices[0] + wrong.vertices[2]) * 0.5;
    wrong.vertices.push(middle);
    let first = wrong.triangles.iter().position(|t| *t == [0, 2, 1]).expect("a face of the box");
    wrong.triangles.splice(first..=first, [[0, 8, 1], [8, 2, 1], [0, 2, 8]]);
    assert_eq!(inspect(&wrong).degenerate, 1);
    assert!((wrong.mass_properties().volume - 8.0).abs() < 1e-12);
    let (mesh, repairs) = solid(wrong).expect("repairable");
    assert_eq!(repairs.slivers, 1);
    let report = inspect(&mesh);
    assert!(report.is_closed() && report.degenerate == 0 && report.triangles == 14);
    assert!((report.volume - 8.0).abs() < 1e-12);
}

#[test]
fn a_one_sided_surface_is_refused() {
    // The projective plane on six vertices: closed, every edge twice, one side.
    let triangles = vec![
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 4],
        [0, 4, 5],
        [0, 5, 1],
        [1, 2, 4],
        [2, 3, 5],
        [3, 4, 1],
        [4, 5, 2],
        [5, 1, 3],
    ];
    let mut source = random::stream(1, "one-sided", 0);
    let vertices = (0..6).map(|_| random::direction(&mut source)).collect();
    let fault = solid(Mesh { vertices, triangles }).expect_err("one side only");
    assert!(matches!(fault, MeshFault::OneSided { .. }), "{fault}");
}

#[test]
fn walls_may_be_open_and_keep_double_precision() {
    let third = 1.0 / 3.0;
    let plate = Mesh {
        vertices: vec![Vec3::zeros(), Vec3::new(third, 0.0, 0.0), Vec3::new(0.0, third, 0.0)],
        triangles: vec![[0, 1, 2], [2, 1, 0], [0, 0, 1]],
    };
    let (mesh, repairs) = surface(plate.clone()).expect("a wall");
    assert_eq!(mesh.triangles, vec![[0, 1, 2]]);
    assert_eq!(mesh.vertices, plate.vertices);
    assert_eq!((repairs.duplicates, repairs.degenerate), (1, 1));
}

#[test]
fn two_cubes_that_meet_in_a_vertex_are_a_pinch() {
    let mut pair = both(cube(), cube().mapped(|p| p + Vec3::repeat(2.0)));
    repair::weld(&mut pair, 0.0);
    let report = inspect(&pair);
    assert_eq!((report.pinched_vertices, report.pieces, report.vertices), (1, 2, 15));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Triangles between few vertices, with repeated, equal, huge, tiny and flat ones: judged,
    /// never a panic, and what passes is a solid.
    #[test]
    fn wild_meshes_are_judged(
        corners in prop::collection::vec(prop::array::uniform3(-3i32..=3), 3..12),
        triangles in prop::collection::vec(prop::array::uniform3(0u32..12), 1..40),
        power in -40i32..=38,
        odd in 0usize..20,
    ) {
        let scale = 10f64.powi(power);
        let mut vertices: Vec<Vec3> =
            corners.iter().map(|c| Vec3::from(c.map(f64::from)) * scale).collect();
        if odd < 3 {
            vertices[odd].x = [f64::NAN, f64::INFINITY, 1e308][odd];
        }
        let wild = Mesh { vertices, triangles };
        if let Ok((mesh, _)) = solid(wild.clone()) {
            let report = inspect(&mesh);
            prop_assert!(report.is_closed() && report.pieces == 1 && report.volume > 0.0);
            let _ = simple(&mesh);
            if let Ok(distance) = crate::geometry::SignedDistance::new(&mesh) {
                prop_assert!(distance.at(&mesh.bounds().centre()).is_finite());
            }
        }
        let _ = solid_in_double(wild.clone());
        let _ = surface(wild);
    }

    /// Solids with some triangles turned, repeated, taken away or split off: mended or refused.
    #[test]
    fn damaged_solids_are_mended_or_refused(
        seed in 0u64..10_000,
        damage in prop::collection::vec((0usize..4, 0usize..1000), 0..6),
        power in -30i32..=30,
    ) {
        let star = crate::geometry::samples::random_star(seed, 0.5);
        let whole = star.mass_properties().volume * 10f64.powi(3 * power);
        let mut mesh = star.mapped(|p| p * 10f64.powi(power));
        let mut may_open = false;
        for (kind, at) in damage {
            let index = at % mesh.triangles.len();
            match kind {
                0 => mesh.triangles[index].swap(0, 1),
                1 => { let again = mesh.triangles[index]; mesh.triangles.push(again); may_open = true; }
                2 => {
                    let twin = mesh.vertices[mesh.triangles[index][0] as usize];
                    mesh.vertices.push(twin);
                    mesh.triangles[index][0] = mesh.vertices.len() as u32 - 1;
                }
                _ => { mesh.triangles.swap_remove(index); may_open = true; }
            }
        }
        match solid(mesh) {
            Ok((mended, _)) => {
                // A repeated triangle can stand in for one that was taken away, or, turned, cancel it.
                let volume = mended.mass_properties().volume;
                prop_assert!((volume / whole - 1.0).abs() < 1e-5, "{} {}", volume, whole);
            }
            Err(fault) => prop_assert!(may_open, "{}", fault),
        }
    }

    #[test]
    fn mass_properties_follow_the_motion(seed in any::<u64>(), scale in 1e-4f64..1e3) {
        let mut source = random::stream(seed, "motion", 0);
        let rotation: Rotation = random::rotation(&mut source);
        let shift = random::direction(&mut source) * (3.0 * scale);
        let edges = Vec3::from_fn(|_, _| random::uniform(&mut source, 0.2, 2.0) * scale);
        let mesh = Primitive::Ellipsoid { axes: edges }.mesh(10);
        let (here, there) = (
            mesh.mass_properties(),
            mesh.mapped(|p| rotation * p + shift).mass_properties(),
        );
        prop_assert!((there.volume / here.volume - 1.0).abs() < 1e-12);
        prop_assert!((there.centroid - rotation * here.centroid - shift).norm() < 1e-12 * scale);
        let turn = rotation.to_rotation_matrix();
        let expected = turn.matrix() * here.inertia * turn.matrix().transpose();
        prop_assert!((there.inertia - expected).norm() < 1e-12 * expected.norm());
        prop_assert!((there.principal().0 - here.principal().0).norm() < 1e-11 * expected.norm());
    }

    #[test]
    fn the_gate_is_idempotent(seed in any::<u64>(), scale in 1e-6f64..1e6) {
        let mut source = random::stream(seed, "gate", 0);
        let rotation: Rotation = random::rotation(&mut source);
        let mesh = Primitive::Cylinder { diameter: scale, height: 0.3 * scale }
            .mesh(24)
            .mapped(|p| rotation * p);
        let (once, _) = solid(mesh).expect("a cylinder is a solid");
        let (twice, repairs) = solid(once.clone()).expect("still a solid");
        prop_assert!(repairs.is_none());
        prop_assert_eq!(once, twice);
    }
}
