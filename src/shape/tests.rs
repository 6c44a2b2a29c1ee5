use super::union_of_solids::{Family, Kind};
use super::*;
use crate::format::{obj, stl};
use crate::geometry::topology::inspect;
use crate::num::Vec3;

const HERE: &str = ".";

fn grain(shape: &Shape, index: u64, size: Option<f64>) -> Solid {
    generate(shape, "g", index, size, 7, "grains", Path::new(HERE)).expect("a solid")
}

#[test]
fn a_sphere_has_the_volume_of_the_ball() {
    let solid = grain(&Shape::Sphere, 3, Some(2e-3));
    assert!((solid.mass.equivalent_diameter() / 2e-3 - 1.0).abs() < 1e-6);
    assert!(solid.mass.centroid.norm() < 1e-9);
    assert_eq!(solid.name, "g-0003");
}

#[test]
fn unions_are_solids_of_the_wanted_size_at_any_scale() {
    let shape = Shape::Union(UnionParameters::default());
    for (index, size) in [1e-6, 2e-3, 1.0, 1e3].into_iter().enumerate() {
        let solid = grain(&shape, index as u64, Some(size));
        let report = inspect(&solid.mesh);
        assert!(report.is_closed() && report.pieces == 1 && report.euler_characteristic == 2);
        assert!((solid.mass.equivalent_diameter() / size - 1.0).abs() < 1e-6);
        assert!(solid.mesh.vertices.iter().flatten().all(|x| f64::from(*x as f32) == *x));
        assert!(solid.recipe.starts_with("union of "), "{}", solid.recipe);
    }
}

#[test]
fn the_same_seed_gives_the_same_grain_and_another_index_another() {
    let shape = Shape::Union(UnionParameters::default());
    let first = grain(&shape, 1, Some(1.0));
    assert_eq!(first, grain(&shape, 1, Some(1.0)));
    assert_ne!(first.mesh, grain(&shape, 2, Some(1.0)).mesh);
}

#[test]
fn families_and_kinds_limit_what_is_drawn() {
    let drawn = |parameters: &UnionParameters| {
        (0..20)
            .flat_map(|index| {
                let mut stream = random::stream(1, "family", index);
                union_of_solids::draw(parameters, &mut stream)
            })
            .map(|solid| solid.primitive)
            .collect::<Vec<_>>()
    };
    let smooth = UnionParameters { family: Family::Smooth, ..Default::default() };
    assert!(
        drawn(&smooth)
            .iter()
            .all(|p| { matches!(p, Primitive::Ellipsoid { .. } | Primitive::Sphere { .. }) })
    );
    let sharp = UnionParameters { family: Family::Sharp, ..Default::default() };
    assert!(
        !drawn(&sharp)
            .iter()
            .any(|p| { matches!(p, Primitive::Ellipsoid { .. } | Primitive::Sphere { .. }) })
    );
    let boxes = UnionParameters {
        kinds: vec![Kind::Box],
        solids: [2, 2],
        dimensions: [1.0, 2.0],
        ..Default::default()
    };
    let all = drawn(&boxes);
    assert_eq!(all.len(), 40);
    assert!(all.iter().all(|p| matches!(p, Primitive::Box { edges }
        if edges.min() >= 1.0 && edges.max() <= 2.0)));
}

#[test]
fn wrong_parameters_name_their_key() {
    let with = |change: fn(&mut UnionParameters)| {
        let mut parameters = UnionParameters::default();
        change(&mut parameters);
        Shape::Union(parameters).validate().expect_err("wrong").key
    };
    assert_eq!(with(|p| p.solids = [0, 3]), "union.solids[0]");
    assert_eq!(with(|p| p.solids = [5, 3]), "union.solids[1]");
    assert_eq!(with(|p| p.dimensions = [1.0, f64::NAN]), "union.dimensions[1]");
    assert_eq!(with(|p| p.lift = [0.0, 1.0]), "union.lift[1]");
    assert_eq!(with(|p| p.segments = 3), "union.segments");
    assert_eq!(
        with(|p| {
            p.kinds = vec![Kind::Box];
            p.family = Family::Sharp;
        }),
        "union.kinds"
    );
    let wrong = generate(&Shape::Sphere, "g", 0, Some(-1.0), 0, "s", Path::new(HERE));
    assert!(wrong.expect_err("negative").to_string().contains("`size` is -1"));
}

#[test]
fn scene_text_reads_as_expected() {
    #[derive(Deserialize)]
    struct Scene {
        shape: Shape,
    }
    let read = |text: &str| toml::from_str::<Scene>(text).map(|scene| scene.shape);
    assert_eq!(read("shape = 'sphere'"), Ok(Shape::Sphere));
    let Ok(Shape::Union(union)) = read("shape.union = { family = 'smooth', solids = [2, 4] }")
    else {
        panic!("a union")
    };
    assert_eq!((union.family, union.solids, union.segments), (Family::Smooth, [2, 4], 32));
    let Ok(Shape::Files(files)) = read("shape.files = { paths = ['a.stl'], unit = '1 mm' }") else {
        panic!("files")
    };
    assert_eq!(files.unit.0, 1e-3);
    assert!(read("shape.union = { solid = [2, 4] }").is_err());
}

#[test]
fn files_are_taken_in_turn_and_scaled() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let far = |mesh: Mesh| mesh.mapped(|p| p + Vec3::new(1e4, 0.0, 0.0));
    let cube = Primitive::Box { edges: Vec3::repeat(2.0) }.mesh(3);
    let cone = Primitive::Cone { diameter: 1.0, height: 1.0 }.mesh(12);
    std::fs::create_dir(folder.path().join("in")).expect("a folder");
    stl::write(&folder.path().join("in/b cube.stl"), &cube).expect("writes");
    obj::write(&folder.path().join("in/a.OBJ"), &far(cone)).expect("writes");
    std::fs::write(folder.path().join("in/readme.txt"), "no solid").expect("writes");
    let shape = Shape::Files(FileParameters {
        paths: vec![],
        folder: Some("in".into()),
        unit: crate::num::units::Length(1e-3),
    });
    let at = |index, size| generate(&shape, "rock", index, size, 0, "s", folder.path());
    let first = at(0, None).expect("the cone");
    assert_eq!(first.name, "rock-0000-a");
    assert!(first.mesh.bounds().centre().norm() < 1e-3);
    let second = at(1, None).expect("the cube");
    assert_eq!(second.name, "rock-0001-b_cube");
    assert!((second.mass.volume / 8e-9 - 1.0).abs() < 1e-6);
    let third = at(2, Some(0.5)).expect("the cone again");
    assert!((third.mass.equivalent_diameter() / 0.5 - 1.0).abs() < 1e-6);
    assert!(third.recipe.contains("a.OBJ; nothing repaired"), "{}", third.recipe);
}

#[test]
fn files_that_are_no_solids_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut open = Primitive::Sphere { diameter: 1.0 }.mesh(12);
    open.triangles.pop();
    stl::write(&folder.path().join("open.stl"), &open).expect("writes");
    let mut crossing = Primitive::Sphere { diameter: 1.0 }.mesh(12);
    crossing.vertices[0] *= -1.2;
    stl::write(&folder.path().join("crossing.stl"), &crossing).expect("writes");
    let message = |name: &str| {
        let paths = vec![name.into()];
        let unit = crate::num::units::Length(1.0);
        let shape = Shape::Files(FileParameters { paths, folder: None, unit });
        generate(&shape, "r", 0, None, 0, "s", folder.path()).expect_err("refused").to_string()
    };
    assert!(message("open.stl").contains("open.stl: open: 3 edges"), "{}", message("open.stl"));
    assert!(message("crossing.stl").contains("crossing.stl: self-intersecting"));
    assert!(message("missing.ply").contains("missing.ply: cannot read"));
    assert!(message("a.doc").contains("`files.paths[0]` is `a.doc`"));
}
