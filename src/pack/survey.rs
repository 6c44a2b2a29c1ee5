//! Measures of a bed in measuring spheres and layers (P18): porosity, coordination numbers, fabric, stress.
//!
//! - Porosity: 1 − volume of the united spheres over that of the probe inside the room (see [`super::solids`]).
//! - Coordination number: mean over bodies whose centre is in the probe, of all bodies that each touches.
//! - Fabric: mean of n ⊗ n over contacts whose point is in the probe, n the contact normal (Satake
//!   1982); trace 1.
//! - Stress, compression positive: σ = (1/V) Σ_c f ⊗ l over all contacts, f the force on the first body and l the
//!   part inside the probe of the broken line from the centre of the first over the contact point to that of
//!   the second (Love 1927, Weber 1966; parts of branches: the average of the momentum flux, Babic 1997).
//!   Of contacts with walls l ends at the contact. Without the flux of moving mass.
//!
//! Cost O(spheres in reach + contacts) a probe.

use super::bed::Bed;
use super::probe::Probe;
use super::solids::solid_volume;
use crate::num::Mat3;
use crate::num::MethodEntry;
use serde::{Deserialize, Serialize};

/// What can be measured, for `riprap list measures`.
pub const METHODS: &[MethodEntry] = &[
    MethodEntry {
        key: "measures",
        id: "P18",
        summary: "measuring spheres (circles) read in every snapshot of a run: porosity, coordination numbers, fabric, stress",
        source: "stress: Love 1927, Weber 1966; fabric: Satake 1982; mechanical coordination number: Thornton 2000",
        example: r#"output.measures = [{ name = "core", at = [0, 0, "3 cm"], radius = "1 cm" }]"#,
    },
    MethodEntry {
        key: "contacts",
        id: "P18",
        summary: "contact forces of the last snapshot in run/contacts.csv, for the stress in `riprap measure --contacts`",
        source: "",
        example: r#"output.contacts = true"#,
    },
    MethodEntry {
        key: "--at --radius",
        id: "P18",
        summary: "the same for any file of spheres, with layers, radial distribution and local porosity: `riprap measure FILE`",
        source: "exact volumes of spheres cut by spheres and boxes: geometry/shared.rs",
        example: "riprap measure run/final.csv --at 0,0,0.03 --radius 0.01 --contacts run/contacts.csv -o measures",
    },
];

/// What a probe measures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Volume of the probe inside the room, m³ (m²).
    pub volume: f64,
    /// Porosity.
    pub porosity: f64,
    /// Its error; 0 where it is exact.
    pub porosity_error: f64,
    /// Number of bodies whose centre is inside.
    pub bodies: u64,
    /// Mean number of bodies that each of them touches; none for no bodies.
    pub coordination: Option<f64>,
    /// Without rattlers (fewer than d + 1 contacts), among those that are none.
    pub coordination_held: Option<f64>,
    /// Mechanical coordination number: without bodies of no contact or one.
    pub coordination_mechanical: Option<f64>,
    /// Share of rattlers.
    pub rattlers: Option<f64>,
    /// Number of contacts inside.
    pub contacts: u64,
    /// Mean of n ⊗ n over them.
    pub fabric: Option<[[f64; 3]; 3]>,
    /// Stress, Pa (N/m in two dimensions), compression positive; none where no forces are known.
    pub stress: Option<[[f64; 3]; 3]>,
    /// Mean of its diagonal, Pa.
    pub mean_stress: Option<f64>,
    /// Deviator: √(3/2 s:s) of spheres, half the difference of the principal stresses of discs, Pa.
    pub deviator: Option<f64>,
}

/// Measures `bed` in `probe`.
pub fn measure(bed: &Bed, probe: &Probe) -> Reading {
    let dimension = bed.dimension();
    let volume = probe.volume(&bed.walls(), dimension);
    let (solid, error) = solid_volume(bed, probe);
    let mut reading = Reading {
        volume,
        porosity: if volume > 0.0 { 1.0 - solid / volume } else { 1.0 },
        porosity_error: if volume > 0.0 { error / volume } else { 0.0 },
        bodies: 0,
        coordination: None,
        coordination_held: None,
        coordination_mechanical: None,
        rattlers: None,
        contacts: 0,
        fabric: None,
        stress: None,
        mean_stress: None,
        deviator: None,
    };
    count(bed, probe, &mut reading);
    fabric(bed, probe, &mut reading);
    stress(bed, probe, &mut reading);
    reading
}

fn count(bed: &Bed, probe: &Probe, reading: &mut Reading) {
    let dimension = bed.dimension();
    let (mut all, mut held, mut holding, mut lone, mut single) =
        (0_u64, 0_u64, 0_u64, 0_u64, 0_u64);
    for (body, centre) in bed.bodies.iter().enumerate() {
        if !probe.holds(&bed.seen_from(probe, centre), dimension) {
            continue;
        }
        reading.bodies += 1;
        all += u64::from(bed.partners[body]);
        lone += u64::from(bed.partners[body] == 0);
        single += u64::from(bed.partners[body] == 1);
        if bed.held[body] > 0 {
            holding += 1;
            held += u64::from(bed.held[body]);
        }
    }
    let ratio = |a: u64, b: u64| (b > 0).then(|| a as f64 / b as f64);
    reading.coordination = ratio(all, reading.bodies);
    reading.coordination_held = ratio(held, holding);
    reading.coordination_mechanical = ratio(all - single, reading.bodies - lone - single);
    reading.rattlers = ratio(reading.bodies - holding, reading.bodies);
}

fn fabric(bed: &Bed, probe: &Probe, reading: &mut Reading) {
    let mut sum = Mat3::zeros();
    let inside = |point| probe.holds(&bed.seen_from(probe, point), bed.dimension());
    for contact in bed.contacts.iter().filter(|contact| inside(&contact.point)) {
        reading.contacts += 1;
        sum += contact.normal * contact.normal.transpose();
    }
    if reading.contacts > 0 {
        reading.fabric = Some(rows(&(sum / reading.contacts as f64)));
    }
}

fn stress(bed: &Bed, probe: &Probe, reading: &mut Reading) {
    let dimension = bed.dimension();
    if bed.spheres.pushes.is_empty() || reading.volume <= 0.0 {
        return;
    }
    let space = bed.space();
    let mut sum = Mat3::zeros();
    for push in &bed.spheres.pushes {
        let point = bed.seen_from(probe, &push.point);
        let mut add = |sphere: u32, sign: f64| {
            let body = bed.spheres.body[sphere as usize] as usize;
            let arm = space.apart(&bed.bodies[body], &push.point);
            let part = probe.part_of_line(&point, &(point + arm), dimension);
            sum += push.force * arm.transpose() * (sign * part);
        };
        add(push.first, 1.0);
        if let Some(second) = push.second {
            add(second, -1.0);
        }
    }
    let stress = sum / reading.volume;
    let mean = (0..dimension).map(|axis| stress[(axis, axis)]).sum::<f64>() / dimension as f64;
    let mut deviator = 0.5 * (stress + stress.transpose());
    for axis in 0..dimension {
        deviator[(axis, axis)] -= mean;
    }
    let size = deviator.norm();
    reading.stress = Some(rows(&stress));
    reading.mean_stress = Some(mean);
    reading.deviator =
        Some(if dimension == 2 { size / 2.0_f64.sqrt() } else { 1.5_f64.sqrt() * size });
}

fn rows(matrix: &Mat3) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

/// Layers of equal thickness through the room along `axis`: the height of the middle of each, m, and what it measures.
pub fn layers(bed: &Bed, axis: usize, count: usize) -> Vec<(f64, Reading)> {
    let (low, size) = (bed.room.low[axis], bed.room.size()[axis]);
    let edge = |i: usize| low + size * i as f64 / count as f64;
    (0..count)
        .map(|i| {
            let mut bounds = bed.room;
            (bounds.low[axis], bounds.high[axis]) = (edge(i), edge(i + 1));
            (0.5 * (edge(i) + edge(i + 1)), measure(bed, &Probe::Box(bounds)))
        })
        .collect()
}

/// The whole room.
pub fn whole(bed: &Bed) -> Reading {
    measure(bed, &Probe::Box(bed.room))
}

#[cfg(test)]
mod tests {
    use super::super::bed::{Push, Spheres};
    use super::super::radial::radial;
    use super::*;
    use crate::geometry::{Bounds, shared};
    use crate::num::Vec3;
    use crate::num::random::{stream, uniform};
    use std::f64::consts::PI;

    /// `cells` cubes of edge 1 a side with `sites` in each, touching; all sides repeat.
    fn lattice(cells: usize, sites: &[[f64; 3]], radius: f64) -> Spheres {
        let mut centres = Vec::new();
        for x in 0..cells {
            for y in 0..cells {
                for z in 0..cells {
                    let corner = Vec3::new(x as f64, y as f64, z as f64);
                    centres.extend(sites.iter().map(|site| corner + Vec3::from(*site)));
                }
            }
        }
        let count = centres.len();
        Spheres {
            radii: vec![radius; count],
            body: (0..count as u32).collect(),
            centres,
            dimension: 3,
            room: Some(Bounds { low: Vec3::zeros(), high: Vec3::repeat(cells as f64) }),
            periodic: [true; 3],
            pushes: Vec::new(),
        }
    }

    const FCC: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];

    #[test]
    fn lattices_have_their_porosity_contacts_and_fabric() {
        let simple = Bed::new(lattice(4, &[[0.0; 3]], 0.5), 1e-9);
        let close = Bed::new(lattice(3, &FCC, 0.125_f64.sqrt()), 1e-9);
        for (bed, solid, contacts) in [(simple, PI / 6.0, 6.0), (close, PI / 18.0_f64.sqrt(), 12.0)]
        {
            let found = whole(&bed);
            assert!((found.porosity - (1.0 - solid)).abs() < 1e-12, "{found:?}");
            assert_eq!(found.porosity_error, 0.0);
            assert_eq!(found.coordination, Some(contacts));
            assert_eq!(found.coordination_held, Some(contacts));
            assert_eq!(found.coordination_mechanical, Some(contacts));
            assert_eq!((found.rattlers, found.stress), (Some(0.0), None));
            let fabric = found.fabric.expect("contacts");
            for (i, row) in fabric.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    let expected = if i == j { 1.0 / 3.0 } else { 0.0 };
                    assert!((value - expected).abs() < 1e-12, "{fabric:?}");
                }
            }
            // A measuring sphere across the sides sees the same.
            let inside = measure(&bed, &Probe::Ball { at: Vec3::new(0.1, 0.2, 0.3), radius: 1.0 });
            let again = measure(&bed, &Probe::Ball { at: Vec3::new(1.1, 1.2, 1.3), radius: 1.0 });
            assert!((inside.porosity - again.porosity).abs() < 1e-12, "{inside:?} {again:?}");
            let layers = layers(&bed, 2, 6);
            let mean = layers.iter().map(|(_, r)| r.porosity).sum::<f64>() / 6.0;
            assert!((mean - (1.0 - solid)).abs() < 1e-12);
        }
    }

    #[test]
    fn shells_of_a_lattice_hold_their_neighbours() {
        // Face-centred cubic: 12, 6, 24, 12 neighbours at 1, √2, √3, 2 diameters.
        let radius = 0.125_f64.sqrt();
        let bed = Bed::new(lattice(4, &FCC, radius), 1e-9);
        let (reach, bins) = (4.4 * radius, 220);
        let found = radial(&bed, reach, bins);
        let width = reach / bins as f64;
        let density = 4.0;
        for (distance, expected) in
            [(1.0, 12.0), (2.0_f64.sqrt(), 6.0), (3.0_f64.sqrt(), 24.0), (2.0, 12.0)]
        {
            let near = |r: f64| (r - 2.0 * radius * distance).abs() < 1.5 * width;
            let shell =
                |r: f64| shared::ball(r + 0.5 * width, 3) - shared::ball(r - 0.5 * width, 3);
            let count: f64 =
                found.iter().filter(|(r, _)| near(*r)).map(|(r, g)| g * density * shell(*r)).sum();
            assert!((count - expected).abs() < 1e-9, "{count} {expected}");
        }
        // Bodies anywhere in a box with walls: 1 everywhere, walls or not.
        let mut source = stream(5, "radial", 0);
        let centres: Vec<Vec3> =
            (0..2000).map(|_| Vec3::from_fn(|_, _| uniform(&mut source, 0.0, 1.0))).collect();
        let spheres = Spheres {
            radii: vec![1e-4; 2000],
            body: (0..2000).collect(),
            centres,
            room: Some(Bounds { low: Vec3::zeros(), high: Vec3::repeat(1.0) }),
            dimension: 3,
            ..Spheres::default()
        };
        for (r, g) in radial(&Bed::new(spheres, 0.0), 0.5, 5).into_iter().skip(1) {
            assert!((g - 1.0).abs() < 0.02, "{r} {g}");
        }
    }

    #[test]
    fn rattlers_count_for_none() {
        // A tetrahedron of spheres, one that hangs on it, and one alone.
        let s = 0.5_f64.sqrt();
        let corners = [[0.0, 0.0, 0.0], [s, s, 0.0], [s, 0.0, s], [0.0, s, s]];
        let mut centres: Vec<Vec3> = corners.iter().map(|c| Vec3::from(*c)).collect();
        centres.push(Vec3::new(-1.0, 0.0, 0.0));
        centres.push(Vec3::new(-5.0, 0.0, 0.0));
        let spheres = Spheres {
            radii: vec![0.5; 6],
            body: (0..6).collect(),
            centres,
            dimension: 3,
            ..Spheres::default()
        };
        let found = whole(&Bed::new(spheres.clone(), 1e-9));
        assert_eq!(found.coordination, Some(14.0 / 6.0));
        assert_eq!(found.coordination_mechanical, Some(13.0 / 4.0));
        // Three contacts do not hold a sphere without friction.
        assert_eq!((found.coordination_held, found.rattlers), (None, Some(1.0)));
        // Discs need three.
        let flat: Vec<Vec3> =
            [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75_f64.sqrt()], [1.5, 0.75_f64.sqrt()]]
                .map(|[x, y]| Vec3::new(x, y, 0.0))
                .to_vec();
        let discs = Spheres {
            radii: vec![0.5; 4],
            body: (0..4).collect(),
            centres: flat,
            dimension: 2,
            ..Spheres::default()
        };
        let found = whole(&Bed::new(discs, 1e-9));
        assert_eq!((found.coordination, found.rattlers), (Some(2.5), Some(1.0)));
    }

    /// Two spheres in touch along x, a force of 6 N between them.
    fn pair() -> Spheres {
        let push = Push {
            first: 0,
            second: Some(1),
            point: Vec3::new(1.0, 0.0, 0.0),
            force: Vec3::new(-6.0, 2.0, 0.0),
        };
        Spheres {
            centres: vec![Vec3::zeros(), Vec3::new(2.0, 0.0, 0.0)],
            radii: vec![1.0; 2],
            body: vec![0, 1],
            dimension: 3,
            room: Some(Bounds { low: Vec3::repeat(-4.0), high: Vec3::repeat(4.0) }),
            pushes: vec![push],
            ..Spheres::default()
        }
    }

    #[test]
    fn stress_of_a_pair_is_force_times_branch() {
        let bed = Bed::new(pair(), 1e-9);
        let found = whole(&bed);
        let stress = found.stress.expect("forces");
        assert!((stress[0][0] - 12.0 / 512.0).abs() < 1e-15, "{stress:?}");
        assert!((stress[1][0] + 4.0 / 512.0).abs() < 1e-15 && stress[0][1] == 0.0);
        assert!((found.mean_stress.expect("forces") - 4.0 / 512.0).abs() < 1e-15);
        // A measuring sphere that holds half of the branch.
        let half = measure(&bed, &Probe::Ball { at: Vec3::zeros(), radius: 1.0 });
        let volume = shared::ball(1.0, 3);
        assert!((half.stress.expect("forces")[0][0] - 6.0 / volume).abs() < 1e-15);
        // Layers across the branch carry the same force over their own width.
        for (middle, layer) in layers(&bed, 0, 8) {
            let carries = (0.0..2.0).contains(&middle);
            let expected = if carries { 6.0 / 64.0 } else { 0.0 };
            assert!((layer.stress.expect("forces")[0][0] - expected).abs() < 1e-15, "{middle}");
        }
        // From a wall only the part up to the wall counts.
        let mut walled = pair();
        walled.pushes[0].second = None;
        let stress = whole(&Bed::new(walled, 1e-9)).stress.expect("forces");
        assert!((stress[0][0] - 6.0 / 512.0).abs() < 1e-15);
    }

    #[test]
    fn discs_have_stress_and_porosity_too() {
        let mut spheres = pair();
        spheres.dimension = 2;
        let found = whole(&Bed::new(spheres, 1e-9));
        assert!((found.porosity - (1.0 - 2.0 * PI / 64.0)).abs() < 1e-12);
        assert!((found.mean_stress.expect("forces") - 6.0 / 64.0).abs() < 1e-15);
    }

    #[test]
    fn overlaps_count_once() {
        let cube = Some(Bounds { low: Vec3::repeat(-2.0), high: Vec3::repeat(3.0) });
        let two = Spheres {
            centres: vec![Vec3::zeros(), Vec3::x()],
            radii: vec![1.0; 2],
            body: vec![0; 2],
            dimension: 3,
            room: cube,
            ..Spheres::default()
        };
        let found = whole(&Bed::new(two.clone(), 1e-9));
        let solid = 2.0 * shared::ball(1.0, 3) - 5.0 * PI / 12.0;
        assert!(
            (found.porosity - (1.0 - solid / 125.0)).abs() < 1e-14 && found.porosity_error == 0.0
        );
        assert_eq!((found.bodies, found.contacts), (1, 0));
        // Three spheres in each other: by lines. One lies within another, so the volume is known.
        let mut three = two;
        three.centres.push(Vec3::new(0.2, 0.0, 0.0));
        three.radii.push(0.7);
        three.body.push(0);
        let found = whole(&Bed::new(three.clone(), 1e-9));
        let off = (found.porosity - (1.0 - solid / 125.0)).abs();
        assert!(found.porosity_error > 0.0 && found.porosity_error < 2e-5, "{found:?}");
        assert!(off < 4.0 * found.porosity_error, "{off} {found:?}");
        // Discs, and a measuring circle that cuts the lens.
        three.dimension = 2;
        let bed = Bed::new(three, 1e-9);
        let flat = whole(&bed);
        let area = 2.0 * PI - (2.0 * PI / 3.0 - 0.5 * 3.0_f64.sqrt());
        assert!(
            (flat.porosity - (1.0 - area / 25.0)).abs() < 4.0 * flat.porosity_error + 1e-9,
            "{flat:?}"
        );
        let cut = measure(&bed, &Probe::Ball { at: Vec3::new(0.5, 0.0, 0.0), radius: 0.5 });
        assert!(cut.porosity.abs() < 1e-3, "{cut:?}");
    }
}
