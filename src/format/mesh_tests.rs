//! Round trips and refusals of the surface formats.

use super::error::FormatError;
use super::{obj, ply, stl};
use crate::geometry::{Mesh, Primitive, check};
use crate::num::Vec3;
use std::fs;
use std::path::Path;

type Writer = fn(&Path, &Mesh) -> Result<(), FormatError>;
type Reader = fn(&Path) -> Result<Mesh, FormatError>;

/// Small meshes with coordinates that lose digits easily.
fn zoo() -> Vec<Mesh> {
    let cone = Primitive::Cone { diameter: 1.0, height: 2.0 }.mesh(7);
    vec![
        cone.mapped(|p| p / 3.0),
        cone.mapped(|p| p * 1e-9),
        cone.mapped(|p| p + Vec3::repeat(1e3)),
        cone.mapped(|p| p * 1e3),
        cone.mapped(|p| Vec3::new(p.x.abs() * -0.0, p.y, 1e-300 * p.z)),
        Mesh { vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()], triangles: vec![[0, 1, 2]] },
    ]
}

fn corners(mesh: &Mesh) -> Vec<[[u64; 3]; 3]> {
    mesh.facets().map(|t| t.map(|p| [p.x, p.y, p.z].map(f64::to_bits))).collect()
}

#[test]
fn double_precision_survives_text_stl_ply_and_obj() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let formats: [(&str, Writer, Reader); 3] = [
        ("a.stl", stl::write_ascii, stl::read),
        ("a.ply", ply::write, ply::read),
        ("a.obj", obj::write, obj::read),
    ];
    for (name, write, read) in formats {
        for mesh in zoo() {
            let path = folder.path().join(name);
            write(&path, &mesh).expect("writes");
            assert_eq!(corners(&read(&path).expect("reads")), corners(&mesh), "{name}");
        }
    }
}

#[test]
fn binary_stl_is_exact_for_gated_solids() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.stl");
    for mesh in &zoo()[..4] {
        let (solid, _) = check::solid(mesh.clone()).expect("a cone");
        stl::write(&path, &solid).expect("writes");
        let back = stl::read(&path).expect("reads");
        assert_eq!(corners(&back), corners(&solid));
        let (again, _) = check::solid(back).expect("still a cone");
        assert_eq!(again.mass_properties().volume, solid.mass_properties().volume);
    }
}

#[test]
fn a_binary_header_that_says_solid_is_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.stl");
    let mesh = zoo().remove(0);
    stl::write(&path, &mesh).expect("writes");
    let mut bytes = fs::read(&path).expect("reads");
    bytes[..20].copy_from_slice(b"solid made by a tool");
    fs::write(&path, &bytes).expect("writes");
    assert_eq!(stl::read(&path).expect("binary all the same").triangles.len(), 14);
}

fn refusal(read: Reader, name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("writes");
    read(&path).expect_err("must be refused").to_string()
}

#[test]
fn broken_stl_files_are_refused_with_a_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("good.stl");
    stl::write(&path, &zoo()[0]).expect("writes");
    let good = fs::read(&path).expect("reads");
    let check = |bytes: &[u8], expected: &str| {
        let message = refusal(stl::read, "bad.stl", bytes);
        assert!(message.contains("bad.stl: ") && message.contains(expected), "{message}");
    };
    check(b"", "is empty (0 bytes)");
    check(b"abc", "too short");
    check(&good[..good.len() - 7], "has 777 bytes, but its count of 14 triangles needs 784");
    check(&[&good[..], b"x"].concat(), "needs 784");
    let mut count = good.clone();
    count[80] = 15;
    check(&count, "count of 15 triangles needs 834");
    let mut nan = good.clone();
    nan[84 + 50 * 3 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    check(&nan, "byte 246: triangle 3 has a corner at (NaN");
    check(&[[0u8; 80].as_slice(), &[0; 4]].concat(), "holds no triangle");
    check(b"solid x\nendsolid x\n", "holds no triangle");
    check(b"solid x\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n", "no `endsolid`");
    check(b"solid x\nfacet normal 0 0 1\nvertex 0 nan 0\n", "line 3: `nan` is no finite number");
    check(b"solid x\nfacet\nvertex 0 0 0\nendfacet\nendsolid", "line 4: a facet of 1 vertices");
    let missing = stl::read(Path::new("no/such/file.stl")).expect_err("missing").to_string();
    assert!(missing.contains("no/such/file.stl: cannot read"), "{missing}");
}

#[test]
fn text_stl_takes_capitals_and_carriage_returns() {
    let text = "SOLID\r\n\tFACET NORMAL 0 0 0\r\nOUTER LOOP\r\nVERTEX 0 0 0\r\nvertex 1e0 0 0\r\n\
                vertex 0 +1 0\r\nENDLOOP\r\nENDFACET\r\nENDSOLID\r\n\r\n";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.stl");
    fs::write(&path, text).expect("writes");
    assert_eq!(stl::read(&path).expect("reads").vertices, zoo()[5].vertices);
}

#[test]
fn polygons_relative_indices_and_other_elements() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.obj");
    let text = "# a square\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nusemtl x\n\
                f -4//1 -3//1 \\\n 3/2/1 4\n";
    fs::write(&path, text).expect("writes");
    assert_eq!(obj::read(&path).expect("reads").triangles, vec![[0, 1, 2], [0, 2, 3]]);
    let path = folder.path().join("a.ply");
    let text = "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\n\
                property float y\nproperty float z\nproperty uchar red\nelement edge 1\n\
                property int a\nproperty int b\nelement face 1\n\
                property list uchar int vertex_index\nproperty float quality\nend_header\n\
                0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n0 1\n4 0 1 2 3 0.5\n";
    fs::write(&path, text).expect("writes");
    assert_eq!(ply::read(&path).expect("reads").triangles, vec![[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn big_endian_ply_is_read() {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\n\
        property double y\nproperty short z\nelement face 1\n\
        property list uchar uint vertex_indices\nend_header\n"
        .to_vec();
    for (x, y, z) in [(0.5f32, 0.25f64, -2i16), (1.0, 0.0, 0), (0.0, 1.0, 300)] {
        bytes.extend(x.to_be_bytes());
        bytes.extend(y.to_be_bytes());
        bytes.extend(z.to_be_bytes());
    }
    bytes.push(3);
    [2u32, 0, 1].iter().for_each(|i| bytes.extend(i.to_be_bytes()));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.ply");
    fs::write(&path, bytes).expect("writes");
    let mesh = ply::read(&path).expect("reads");
    assert_eq!(mesh.vertices[0], Vec3::new(0.5, 0.25, -2.0));
    assert_eq!((mesh.vertices[2].z, &mesh.triangles[..]), (300.0, &[[2, 0, 1]][..]));
}

#[test]
fn broken_ply_and_obj_files_are_refused_with_a_reason() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (body, expected) in [
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "a face names vertex 7, but there are 3"),
        ("0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "vertex 2 lies at (0, NaN, 0)"),
        ("0 0 0\n1 0 x\n", "line 11: `x` is no number"),
        ("0 0 0\n1 0 0\n", "truncated"),
        ("0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "a face of 2 corners"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "no index"),
        ("0 0 0\n1 0 0\n0 1 0\n-3 0 1 1\n", "-3 is no possible length"),
    ] {
        let message = refusal(ply::read, "b.ply", format!("{head}{body}").as_bytes());
        assert!(message.contains(expected), "{message}");
    }
    assert!(refusal(ply::read, "b.ply", b"").contains("no PLY file"));
    assert!(refusal(ply::read, "b.ply", b"plx\n").contains("begins with"));
    for (text, expected) in [
        ("v 0 0 0\nf 1 2 3\n", "line 2: corner 2 names no vertex: 1 were given so far"),
        ("v 0 0\n", "line 1: a vertex has 3 coordinates"),
        ("v 0 0 inf\n", "`inf` is no finite number"),
        ("v 0 0 0\nf 1 1\n", "a face of 2 corners"),
        ("", "holds no face"),
    ] {
        let message = refusal(obj::read, "b.obj", text.as_bytes());
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn nothing_unusable_is_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut nan = zoo().remove(5);
    nan.vertices[1].y = f64::NAN;
    let far = zoo()[5].mapped(|p| p * 1e39);
    for (name, write) in
        [("a.stl", stl::write as Writer), ("a.ply", ply::write), ("a.obj", obj::write)]
    {
        let path = folder.path().join(name);
        assert!(write(&path, &Mesh::default()).is_err());
        assert!(write(&path, &nan).expect_err("NaN").to_string().contains("triangle 0"));
    }
    assert!(stl::write(&folder.path().join("far.stl"), &far).is_err());
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
