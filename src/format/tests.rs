//! Tests that hold for every format: what is written comes back, damaged files
//! are errors and never panics, conversions say what they lose.

use super::*;
use crate::geometry::Bounds;
use crate::num::Vec3;
use proptest::prelude::*;
use std::path::PathBuf;

const THIRD: f64 = 1.0 / 3.0;

/// Small tables that writers get wrong.
fn tables() -> Vec<(&'static str, Particles)> {
    let full = Particles {
        positions: vec![
            Vec3::new(THIRD, -0.0, 1e-9),
            Vec3::new(-1e3, 0.1 + 0.2, 2.0 / 3.0),
            Vec3::new(0.0, -THIRD * 1e-9, 1e3 + THIRD),
        ],
        radii: vec![THIRD * 1e-3, 1e-9, 7.7e2],
        ids: Some(vec![12, 0, 5]),
        bodies: Some(vec![4, 4, 1]),
        materials: Some(vec![0, 2, 1]),
        densities: Some(vec![2650.0, THIRD * 1e4, 1e-3]),
        velocities: Some(vec![Vec3::new(-0.0, 1e-300, THIRD); 3]),
        spins: Some(vec![Vec3::new(1e9, -THIRD, 0.0); 3]),
        forces: Some(vec![Vec3::new(f64::MIN_POSITIVE, 1e17, -1e-5); 3]),
        time: Some(THIRD),
        step: Some(123_456_789_012),
        bounds: Some(Bounds { low: Vec3::repeat(-2e3), high: Vec3::repeat(3e3 + THIRD) }),
    };
    let singles = Particles { bodies: Some(vec![2, 0, 1]), ..full.clone() };
    let bare = Particles {
        positions: vec![Vec3::new(-0.0, THIRD, 1e-9)],
        radii: vec![THIRD],
        ..Particles::default()
    };
    vec![("full", full), ("singles", singles), ("bare", bare), ("none", Particles::default())]
}

/// Small surfaces whose coordinates single precision holds exactly.
fn surfaces() -> Vec<(&'static str, Mesh)> {
    let third = f64::from(1.0f32 / 3.0);
    let vertices = vec![
        Vec3::new(third, 0.0, -f64::from(1e-9f32)),
        Vec3::new(1e3, 0.0, third),
        Vec3::new(0.0, 0.5, 0.0),
        Vec3::new(third, third, 1.0),
    ];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let one = Mesh { vertices: vertices[..3].to_vec(), triangles: vec![[0, 1, 2]] };
    vec![("tetrahedron", Mesh { vertices, triangles }), ("triangle", one)]
}

fn file(folder: &tempfile::TempDir, format: &Format, name: &str) -> PathBuf {
    folder.path().join(format!("{name}.{}", format.extensions[0]))
}

fn bits(vectors: &[Vec3]) -> Vec<[u64; 3]> {
    vectors.iter().map(|v| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()]).collect()
}

/// The columns of `written` that `column` stands for came back bit for bit.
fn survived(column: Column, written: &Particles, back: &Particles) -> bool {
    let vectors = |column: &Option<Vec<Vec3>>| column.as_deref().map(bits);
    match column {
        Column::Ids => written.ids == back.ids,
        Column::Bodies => written.bodies == back.bodies,
        Column::Materials => written.materials == back.materials,
        Column::Densities => written.densities == back.densities,
        Column::Velocities => vectors(&written.velocities) == vectors(&back.velocities),
        Column::Spins => vectors(&written.spins) == vectors(&back.spins),
        Column::Forces => vectors(&written.forces) == vectors(&back.forces),
        Column::Time => written.time == back.time,
        Column::Step => written.step == back.step,
        Column::Box => match (&written.bounds, &back.bounds) {
            // Formats that keep origin and edges round once.
            (Some(a), Some(b)) => (a.high - b.high).amax() <= 1e-12 && a.low == b.low,
            _ => false,
        },
    }
}

#[test]
fn spheres_come_back_from_every_format_but_for_what_it_says() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for format in FORMATS.iter().filter(|format| format.write_particles.is_some()) {
        for (name, table) in tables() {
            let path = file(&folder, format, name);
            let notes = write(&path, &Data::Particles(table.clone()))
                .unwrap_or_else(|error| panic!("{}, {name}: {error}", format.name));
            let back = match read(&path) {
                Ok(Data::Particles(back)) => back,
                other => panic!("{}, {name}: {other:?}", format.name),
            };
            assert_eq!(bits(&back.positions), bits(&table.positions), "{}, {name}", format.name);
            assert_eq!(back.radii, table.radii, "{}, {name}", format.name);
            for column in Column::ALL.iter().filter(|column| column.is_in(&table)) {
                let said = notes.iter().any(|note| note.starts_with(column.name()));
                assert!(
                    said != survived(*column, &table, &back),
                    "{}, {name}: {} in {notes:?}",
                    format.name,
                    column.name()
                );
            }
        }
    }
}

#[test]
fn line_ends_of_windows_and_blank_lines_do_not_matter() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, table) = tables().swap_remove(0);
    for format in FORMATS.iter().filter(|format| format.write_particles.is_some()) {
        let path = file(&folder, format, "a");
        write(&path, &Data::Particles(table.clone())).expect("written");
        let plain = read(&path).expect("read");
        let text = std::fs::read_to_string(&path).expect("text");
        std::fs::write(&path, text.replace('\n', "\r\n\r\n")).expect("written");
        assert_eq!(read(&path).expect(format.name), plain, "{}", format.name);
    }
}

#[test]
fn surfaces_come_back_from_every_format() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for format in FORMATS.iter().filter(|format| format.write_mesh.is_some()) {
        for (name, mesh) in surfaces() {
            let path = file(&folder, format, name);
            write(&path, &Data::Mesh(mesh.clone()))
                .unwrap_or_else(|error| panic!("{}, {name}: {error}", format.name));
            match read(&path) {
                Ok(Data::Mesh(back)) => {
                    let corners = |mesh: &Mesh| mesh.facets().collect::<Vec<_>>();
                    assert_eq!(corners(&back), corners(&mesh), "{}, {name}", format.name);
                }
                other => panic!("{}, {name}: {other:?}", format.name),
            }
        }
    }
}

#[test]
fn content_chooses_where_the_extension_does_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, table) = tables().swap_remove(0);
    for format in FORMATS.iter().filter(|format| format.write_particles.is_some()) {
        let path = file(&folder, format, "known");
        write(&path, &Data::Particles(table.clone())).expect("written");
        for name in ["a.txt", "dump5000.chute", "bare"] {
            let other = folder.path().join(name);
            std::fs::copy(&path, &other).expect("copied");
            let found = format_of(&other).expect("known by content");
            assert_eq!(found.name, format.name, "{name}");
        }
    }
}

#[test]
fn single_precision_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, mesh) = surfaces().swap_remove(0);
    let notes = write(&folder.path().join("a.stl"), &Data::Mesh(mesh.clone())).expect("written");
    assert!(notes.is_empty(), "{notes:?}");
    let doubled = Data::Mesh(mesh.mapped(|p| p * THIRD));
    let notes = write(&folder.path().join("a.stl"), &doubled).expect("written");
    assert!(
        notes[0].starts_with("coordinates rounded to single precision, by up to 1.0e-5 m"),
        "{notes:?}"
    );
}

#[test]
fn conversions_say_what_they_lose() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, table) = tables().swap_remove(0);
    let dump = folder.path().join("a.dump");
    write(&dump, &Data::Particles(table)).expect("written");
    let report = convert(&dump, &folder.path().join("a.txt")).expect("converted");
    assert_eq!((report.from, report.to), ("LAMMPS dump", "YADE text"));
    let text = report.to_string();
    assert!(text.starts_with("3 spheres: LAMMPS dump to YADE text\n"), "{text}");
    for part in ["\n  velocities not written", "\n  materials not written", "\n  box not written"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn surfaces_do_not_become_spheres() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, mesh) = surfaces().swap_remove(0);
    let surface = folder.path().join("a.vtp");
    write(&surface, &Data::Mesh(mesh)).expect("written");
    let target = folder.path().join("a.dump");
    let error = convert(&surface, &target).expect_err("a surface is no dump").to_string();
    assert!(
        error.contains("the data is a surface, and LAMMPS dump files hold spheres only"),
        "{error}"
    );
    assert!(error.ends_with("for a surface there are .vtp .stl .ply .obj"), "{error}");
    assert!(!target.exists());
}

#[test]
fn unknown_extensions_list_the_known_ones() {
    let error =
        write(Path::new("a.foo"), &Data::Mesh(Mesh::default())).expect_err("no such format");
    let text = error.to_string();
    assert!(text.starts_with("a.foo: format not known; known extensions: .csv .vtp"), "{text}");
}

#[test]
fn what_is_not_finite_is_not_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, mut table) = tables().swap_remove(0);
    table.positions[1].y = f64::NAN;
    let (_, mut mesh) = surfaces().swap_remove(1);
    mesh.vertices.push(Vec3::repeat(f64::NAN));
    for format in FORMATS {
        let path = file(&folder, format, "nan");
        if format.write_particles.is_some() {
            let error = format.write(&path, &Data::Particles(table.clone())).expect_err("NaN");
            assert!(error.to_string().contains("positions[1]"), "{error}");
        }
        if format.write_mesh.is_some() {
            assert!(format.write(&path, &Data::Mesh(mesh.clone())).is_err(), "{}", format.name);
        }
        assert!(!path.exists());
    }
}

#[test]
fn a_huge_count_of_nothing_costs_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in [
        ("a.ply", "ply\nformat ascii 1.0\nelement x 18446744073709551615\nend_header\n"),
        ("a.xyz", "9007199254740992\nProperties=pos:R:3:radius:R:1\n"),
        ("a.dump", "ITEM: NUMBER OF ATOMS\n9007199254740992\nITEM: ATOMS x y z radius\n"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        assert!(read(&path).is_err(), "{name}");
    }
}

/// A good file of each kind in each format, as bytes.
fn good_files() -> Vec<(&'static Format, Vec<u8>)> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, table) = tables().swap_remove(0);
    let (_, mesh) = surfaces().swap_remove(0);
    let mut files = Vec::new();
    for format in FORMATS {
        for data in [Data::Particles(table.clone()), Data::Mesh(mesh.clone())] {
            let path = file(&folder, format, "good");
            if format.write(&path, &data).is_ok() {
                files.push((format, std::fs::read(&path).expect("just written")));
            }
        }
    }
    files
}

/// Reads `bytes` as `format`; what comes back, if anything, can be written.
fn read_damaged(folder: &tempfile::TempDir, format: &Format, bytes: &[u8]) {
    let path = file(folder, format, "damaged");
    std::fs::write(&path, bytes).expect("a temporary file");
    match (format.read)(&path) {
        Ok((Data::Particles(particles), _)) => {
            assert_eq!(particles.check(), Ok(()), "{}", format.name);
        }
        Ok((Data::Mesh(mesh), _)) => {
            let count = mesh.vertices.len();
            assert!(mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < count));
            assert!(mesh.vertices.iter().flat_map(|v| v.iter()).all(|v| v.is_finite()));
        }
        Err(error) => assert!(error.to_string().contains("damaged"), "{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for format in FORMATS {
            read_damaged(&folder, format, &bytes);
        }
    }

    #[test]
    fn damaged_files_are_read_or_refused(
        cut in 0.0..1.0f64,
        place in 0.0..1.0f64,
        patch in prop_oneof![
            proptest::collection::vec(any::<u8>(), 1..4),
            prop_oneof!["-1", "99999999999999999999", "nan", "1e999", "1e307", "9007199254740993", "\n", " ", "4294967296"]
                .prop_map(String::into_bytes),
        ],
        truncate in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (format, bytes) in good_files() {
            let mut damaged = bytes.clone();
            let at = (place * bytes.len() as f64) as usize;
            let end = (at + patch.len()).min(bytes.len());
            damaged.splice(at..end, patch.iter().copied());
            if truncate {
                damaged.truncate((cut * damaged.len() as f64) as usize);
            }
            read_damaged(&folder, format, &damaged);
        }
    }
}
