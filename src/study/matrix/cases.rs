//! The cases of the comparison matrix: each a scene that anybody can open and run by itself,
//! with what it shows, its tolerance and the reason for it.

mod late;

use std::f64::consts::TAU;

/// One case.
pub struct Case {
    /// Name of its folder.
    pub key: String,
    /// What it shows.
    pub what: String,
    /// Largest distance of a sphere from riprap in the solver's own scheme, smallest radii.
    pub tolerance: f64,
    /// Why this tolerance.
    pub reason: &'static str,
    /// Steps from start to start and steps of a segment, where codes run in lock-step.
    pub lock_step: Option<(u64, u64)>,
    /// Whether it is also run on two MPI ranks.
    pub ranks: bool,
    /// Whether decks are also taken back to a restart file and resumed.
    pub resumes: bool,
    /// Whether the limit of small steps is looked at too.
    pub limit: bool,
    /// Solvers of which it is known that they differ, and why.
    pub known: &'static [(&'static str, &'static str)],
    /// The scene.
    pub scene: String,
    /// Files beside it.
    pub files: Vec<(&'static str, String)>,
}

const ROUNDING: &str = "one event: rounding, amplified by the contact";
const SEGMENTS: &str = "rounding, amplified by chaos within a segment";

fn case(key: impl Into<String>, what: impl Into<String>, scene: String) -> Case {
    Case {
        key: key.into(),
        what: what.into(),
        tolerance: 1e-9,
        reason: ROUNDING,
        lock_step: None,
        ranks: false,
        resumes: false,
        limit: false,
        known: &[],
        scene,
        files: Vec::new(),
    }
}

/// Spheres in numbers: codes start again from riprap's states at four times.
fn segments(key: &str, what: &str, scene: String) -> Case {
    Case {
        tolerance: 1e-6,
        reason: SEGMENTS,
        lock_step: Some((7500, 500)),
        ..case(key, what, scene)
    }
}

/// Material, contact and plan that most cases share.
struct Usual {
    restitution: f64,
    friction: f64,
    extra: &'static str,
    gravity: [f64; 3],
    steps: u64,
    /// Step, us.
    step: u32,
}

const USUAL: Usual = Usual {
    restitution: 0.6,
    friction: 0.4,
    extra: "",
    gravity: [0.0, 0.0, -9.81],
    steps: 2000,
    step: 1,
};

impl Usual {
    /// Spheres of 20 and 14 mm (and of 4 mm), `bodies` and `walls` as TOML.
    fn scene(&self, title: &str, bodies: &str, walls: &str) -> String {
        let families: String = [("large", 20), ("small", 14), ("tiny", 4)]
            .into_iter()
            .filter_map(|(name, size)| {
                let count = bodies.matches(&format!("\"{name}\"")).count();
                let family = format!(
                    "[[grains]]\nname = \"{name}\"\ncount = {count}\nsize = \"{size} mm\"\nshape = \"sphere\"\n\n"
                );
                (count > 0).then_some(family)
            })
            .collect();
        self.around(title, &families, &format!("[packing.placed]\nbodies = [\n{bodies}]\n"), walls)
    }

    fn around(&self, title: &str, families: &str, packing: &str, walls: &str) -> String {
        let Self { restitution, friction, extra, gravity, steps, step } = self;
        let duration = *steps as f64 * f64::from(*step) * 1e-6;
        format!(
            "title = \"{title}\"\nseed = 1\n\n{families}[materials.glass]\ndensity = \"2500 kg/m3\"\n\n\
             [contact]\nkn = \"100 kN/m\"\nkt = \"50 kN/m\"\nrestitution = {restitution:?}\n\
             friction = {friction:?}\n{extra}\n{walls}{packing}\n[plan]\nduration = {duration:?}\n\
             step = \"{step} us\"\ngravity = {gravity:?}\n\n[output]\nframes = 20\n\n\
             [compare.tolerance]\ntrajectory = 1e-9\ncontact_durations = 1e6\n"
        )
    }
}

fn body(family: &str, place: [f64; 3], velocity: [f64; 3], spin: [f64; 3]) -> String {
    format!(
        "  {{ family = \"{family}\", position = {place:?}, velocity = {velocity:?}, spin = {spin:?} }},\n"
    )
}

fn plane(name: &str, point: [f64; 3], normal: [f64; 3], motion: &str) -> String {
    format!(
        "[[walls]]\nname = \"{name}\"\nshape.plane = {{ point = {point:?}, normal = {normal:?} }}\n{motion}\n"
    )
}

fn floor() -> String {
    plane("floor", [0.0; 3], [0.0, 0.0, 1.0], "")
}

const STILL: [f64; 3] = [0.0; 3];

/// An oblique impact of two spinning spheres.
fn pair(usual: &Usual) -> String {
    let bodies = body("large", STILL, [0.5, 0.1, 0.0], [20.0, -35.0, 90.0])
        + &body("small", [0.015, 0.0076, 0.002], [-0.7, -0.2, 0.05], [-40.0, 10.0, 60.0]);
    usual.scene("Oblique impact of two spinning spheres", &bodies, "")
}

/// An STL file of triangles.
fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = "solid wall\n".to_owned();
    for corners in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in corners {
            text.push_str(&format!("vertex {x:?} {y:?} {z:?}\n"));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid wall\n");
    text
}

fn mesh_wall(file: &str) -> String {
    format!("[[walls]]\nname = \"mesh\"\nshape.mesh = {{ file = \"{file}\" }}\n\n")
}

/// Places on a lattice, layers shifted against each other.
fn lattice(counts: [u32; 3], pitch: f64, corner: [f64; 3]) -> Vec<[f64; 3]> {
    let [nx, ny, nz] = counts;
    (0..nx * ny * nz)
        .map(|i| {
            let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)].map(f64::from);
            let lean = 0.21 * (z % 2.0);
            [
                corner[0] + pitch * (x + lean),
                corner[1] + pitch * (y + 0.6 * lean),
                corner[2] + pitch * z,
            ]
        })
        .collect()
}

fn crowd(places: &[[f64; 3]]) -> String {
    places
        .iter()
        .enumerate()
        .map(|(i, place)| {
            let family = if i % 3 == 0 { "small" } else { "large" };
            let spin = [f64::from(i as u32 % 5) * 3.0, f64::from(i as u32 % 7) * -2.0, 1.0];
            body(family, *place, [0.0, 0.0, -0.3], spin)
        })
        .collect()
}

const CLUMP: &str = "[[grains]]\nname = \"grain\"\ncount = COUNT\nsize = \"12 mm\"\n\
    shape.union = { family = \"any\", solids = [3, 3] }\nclump.normals = { spheres = 8 }\n\n";

fn clumps(title: &str, bodies: &[String], walls: &str) -> String {
    let families = CLUMP.replace("COUNT", &bodies.len().to_string());
    let packing = format!("[packing.placed]\nbodies = [\n{}]\n", bodies.concat());
    Usual { steps: 4000, ..USUAL }.around(title, &families, &packing, walls)
}

/// All cases, quick ones first.
pub fn all() -> Vec<Case> {
    let mut cases = impacts();
    cases.extend(walls());
    cases.extend(bodies());
    cases.extend(laws());
    cases.extend(bulk());
    cases
}

fn impacts() -> Vec<Case> {
    let mut cases = Vec::new();
    for restitution in [0.95, 0.6, 0.3, 0.1] {
        for friction in [0.0, 0.3, 1.0] {
            let usual = Usual { restitution, friction, ..USUAL };
            cases.push(Case {
                limit: restitution == 0.6 && friction == 0.3,
                ..case(
                    format!("pair-e{restitution}-mu{friction}"),
                    format!(
                        "oblique impact of spinning spheres, e = {restitution}, mu = {friction}"
                    ),
                    pair(&usual),
                )
            });
        }
    }
    let head_on = body("large", STILL, [0.4, 0.0, 0.0], STILL)
        + &body("large", [0.0202, 0.0, 0.0], [-0.4, 0.0, 0.0], STILL);
    let scene = Usual { gravity: STILL, ..USUAL }.scene("Head-on impact", &head_on, "");
    cases.push(Case {
        limit: true,
        ..case("pair-normal", "head-on impact of equal spheres", scene)
    });
    let unequal = body("large", STILL, [0.2, 0.0, 0.0], [0.0, 0.0, 30.0])
        + &body("tiny", [0.0119, 0.002, 0.0005], [-0.8, 0.1, 0.0], [0.0, 50.0, -80.0]);
    let scene = USUAL.scene("Radii 10 and 2 mm", &unequal, "");
    cases.push(Case { limit: true, ..case("pair-unequal", "radii 5 : 1, oblique", scene) });
    cases
}

fn walls() -> Vec<Case> {
    let thrown = |place: [f64; 3]| body("large", place, [0.3, 0.05, -0.5], [10.0, -30.0, 20.0]);
    let sheet = stl(&[
        [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0]],
        [[-0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]],
    ]);
    let ridge = stl(&[
        [[0.0, -0.1, 0.0], [0.1, 0.0, -0.08], [0.0, 0.1, 0.0]],
        [[0.0, -0.1, 0.0], [0.0, 0.1, 0.0], [-0.1, 0.0, -0.08]],
    ]);
    let corners = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]];
    let peak: Vec<[[f64; 3]; 3]> = (0..4)
        .map(|k| {
            let ([a, b], [c, d]) = (corners[k], corners[(k + 1) % 4]);
            [[0.0, 0.0, 0.0], [a, b, -0.1], [c, d, -0.1]]
        })
        .collect();
    const FACETS: &[(&str, &str)] =
        &[("yade", "every facet that a sphere touches counts, at edges and corners several")];
    let mut all = vec![
        Case {
            limit: true,
            ..case(
                "wall-plane",
                "oblique impact on a plane",
                USUAL.scene("Impact on a plane", &thrown([0.0, 0.0, 0.0101]), &floor()),
            )
        },
        Case {
            files: vec![("sheet.stl", sheet)],
            ..case(
                "wall-mesh",
                "oblique impact on the face of a mesh",
                USUAL.scene(
                    "Impact on a mesh",
                    &thrown([0.02, -0.03, 0.0101]),
                    &mesh_wall("sheet.stl"),
                ),
            )
        },
        Case {
            files: vec![("ridge.stl", ridge)],
            known: FACETS,
            ..case(
                "wall-edge",
                "impact on an edge of a mesh",
                USUAL.scene(
                    "Impact on an edge",
                    &thrown([-0.002, 0.01, 0.0101]),
                    &mesh_wall("ridge.stl"),
                ),
            )
        },
        Case {
            files: vec![("peak.stl", stl(&peak))],
            known: FACETS,
            ..case(
                "wall-corner",
                "impact on a corner of a mesh",
                USUAL.scene(
                    "Impact on a corner",
                    &thrown([-0.001, 0.0005, 0.0101]),
                    &mesh_wall("peak.stl"),
                ),
            )
        },
    ];
    // Two neighbours of the cone of the silo: of coplanar triangles one begins to touch with its
    // corner while the other touches with its edge.
    let at = |k: u32, radius: f64, z: f64| {
        let angle = TAU * f64::from(k) / 24.0;
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let cone: Vec<[[f64; 3]; 3]> = [18, 19]
        .into_iter()
        .flat_map(|k| {
            let [a, b] = [at(k, 0.032, 0.04), at(k + 1, 0.032, 0.04)];
            let [c, d] = [at(k, 0.07, 0.078), at(k + 1, 0.07, 0.078)];
            [[a, b, d], [a, d, c]]
        })
        .collect();
    let slides =
        body("large", [0.00564, -0.02419, 0.04709], [0.23, -0.68, -0.74], [20.0, -30.0, 10.0]);
    all.push(Case {
        files: vec![("cone.stl", stl(&cone))],
        known: FACETS,
        ..case(
            "wall-rim",
            "a sphere slides over a corner of the rim of a cone",
            USUAL.scene("A sphere on a rim", &slides, &mesh_wall("cone.stl")),
        )
    });
    let rest = body("large", [0.0, 0.0, 0.00999], [0.5, 0.0, 0.0], STILL);
    let long = Usual { steps: 8000, ..USUAL };
    all.push(case(
        "sliding-to-rolling",
        "a sphere that slides on a plane until it rolls",
        Usual { gravity: [0.0, 0.0, -200.0], ..long }.scene("Sliding to rolling", &rest, &floor()),
    ));
    let (sine, cosine) = (0.5_f64, 0.75_f64.sqrt());
    let above = body("large", [0.00999 * sine, 0.0, 0.00999 * cosine], STILL, STILL);
    let slope = plane("slope", STILL, [sine, 0.0, cosine], "");
    all.push(case(
        "incline",
        "a sphere from rest on a slope of 30 degrees",
        long.scene("Slope of 30 degrees", &above, &slope),
    ));
    let tower: String =
        [0.00999, 0.02997, 0.04995].map(|z| body("large", [0.0, 0.0, z], STILL, STILL)).concat();
    all.push(case(
        "stack",
        "three spheres on top of each other, let go",
        long.scene("A stack of three", &tower, &floor()),
    ));
    let piston = plane(
        "piston",
        STILL,
        [0.0, 0.0, 1.0],
        "motion.translate = { velocity = [0.1, 0.0, 0.4] }",
    );
    all.push(case(
        "moving-piston",
        "a piston that moves obliquely hits a sphere",
        USUAL.scene(
            "A piston hits a sphere",
            &body("large", [0.0, 0.0, 0.0102], STILL, [0.0, 20.0, 0.0]),
            &piston,
        ),
    ));
    let paddle = plane(
        "paddle",
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        "motion.rotate = { origin = [0.05, 0.0, 0.0], axis = [0, 1, 0], rate = \"60 rpm\" }",
    );
    all.push(Case {
        known: &[(
            "yade",
            "a plane that turns is made of facets: arm R - overlap/2, not R - overlap",
        )],
        ..case(
            "turning-wall",
            "a plane that turns about an axis hits a sphere",
            USUAL.scene(
                "A paddle hits a sphere",
                &body("large", [0.0, 0.0, 0.0102], STILL, STILL),
                &paddle,
            ),
        )
    });
    all
}

fn grain(place: [f64; 3], velocity: [f64; 3], spin: [f64; 3]) -> String {
    body("grain", place, velocity, spin)
}

fn bodies() -> Vec<Case> {
    let spin = [30.0, -20.0, 15.0];
    vec![
        Case {
            tolerance: 1e-8,
            ..case(
                "clump-plane",
                "a spinning clump falls on a plane",
                clumps(
                    "A clump on a plane",
                    &[grain([0.0, 0.0, 0.009], [0.1, 0.0, -0.4], spin)],
                    &floor(),
                ),
            )
        },
        Case {
            tolerance: 1e-8,
            ..case(
                "clump-pair",
                "two spinning clumps collide",
                clumps(
                    "Two clumps",
                    &[
                        grain([0.0, 0.0, 0.1], [0.8, 0.0, 0.0], spin),
                        grain([0.014, 0.001, 0.1005], [-0.8, 0.0, 0.0], [-10.0, 40.0, 5.0]),
                    ],
                    "",
                ),
            )
        },
        Case {
            tolerance: 1e-8,
            ..case(
                "clump-multisphere",
                "two clumps on each other and on a plane; LIGGGHTS by fix multisphere",
                clumps(
                    "Clumps by fix multisphere",
                    &[
                        grain([0.0, 0.0, 0.009], [0.1, 0.0, -0.4], spin),
                        grain([0.003, 0.002, 0.022], [0.0, 0.0, -0.6], [-10.0, 40.0, 5.0]),
                    ],
                    &floor(),
                ) + "\n[decks]\nliggghts_clumps = \"multisphere\"\n",
            )
        },
        case(
            "clump-free",
            "a clump tumbles in free fall",
            clumps(
                "A clump in free fall",
                &[grain([0.0, 0.0, 0.1], [0.3, 0.2, 0.5], [300.0, -200.0, 150.0])],
                "",
            ),
        ),
    ]
}

fn laws() -> Vec<Case> {
    let cohesive = Usual { extra: "cohesion = { sjkr = { energy_density = 3e4 } }\n", ..USUAL };
    let rolling =
        Usual { extra: "rolling = { epsd2 = { coefficient = 0.2 } }\n", steps: 6000, ..USUAL };
    let rest = body("large", [0.0, 0.0, 0.00999], [0.3, 0.0, 0.0], [0.0, 25.0, 0.0]);
    let two = pair(&USUAL)
        .replace(
            "shape = \"sphere\"\n\n[[grains]]\nname = \"small\"",
            "shape = \"sphere\"\nmaterial = \"glass\"\n\n[[grains]]\nname = \"small\"",
        )
        .replace(
            "size = \"14 mm\"\nshape = \"sphere\"",
            "size = \"14 mm\"\nshape = \"sphere\"\nmaterial = \"steel\"",
        )
        .replace("[contact]", "[materials.steel]\ndensity = \"7800 kg/m3\"\n\n[contact]");
    let discs = Usual { gravity: [0.0, -9.81, 0.0], ..USUAL };
    let flat = discs
        .scene(
            "Two discs on a plane",
            &(body("large", [0.0, 0.0101, 0.0], [0.2, -0.5, 0.0], [0.0, 0.0, 30.0])
                + &body("small", [0.017, 0.0102, 0.0], [-0.3, -0.1, 0.0], STILL)),
            &plane("floor", STILL, [0.0, 1.0, 0.0], ""),
        )
        .replace("seed = 1\n", "seed = 1\ndimension = 2\n")
        .replace("100 kN/m", "100 MN/m")
        .replace("50 kN/m", "50 MN/m");
    vec![
        case("two-materials", "spheres of two materials", two),
        case("discs", "two discs and a plane, two dimensions", flat),
        case("cohesive-pair", "sjkr cohesion: two spheres that stick", pair(&cohesive)),
        case(
            "rolling-resistance",
            "epsd2: a rolling sphere comes to rest",
            rolling.scene("Resistance to rolling", &rest, &floor()),
        ),
        Case {
            tolerance: 1e-6,
            reason: "bonds break within a step: rounding, amplified by breakage",
            ..case(
                "bonded-cluster",
                "a cluster of seven bonded spheres breaks on a plane",
                include_str!("../../../templates/scenes/cluster-impact.toml").to_owned()
                    + "\n[compare.tolerance]\ntrajectory = 1e-6\ncontact_durations = 1e6\n",
            )
        },
    ]
}

fn bulk() -> Vec<Case> {
    let bed = |counts, corner| crowd(&lattice(counts, 0.0203, corner));
    let usual = Usual { steps: 30_000, step: 10, ..USUAL };
    let side = |name: &str, axis: usize, at: f64| {
        let mut point = [0.0; 3];
        let mut normal = [0.0; 3];
        point[axis] = at;
        normal[axis] = if at < 0.03 { 1.0 } else { -1.0 };
        plane(name, point, normal, "")
    };
    let r#box = floor()
        + &side("left", 0, 0.0)
        + &side("right", 0, 0.09)
        + &side("front", 1, 0.0)
        + &side("back", 1, 0.09);
    let inside = [0.0105, 0.0105, 0.0105];
    let lid = plane(
        "lid",
        [0.0, 0.0, 0.0845],
        [0.0, 0.0, -1.0],
        "motion.translate = { velocity = [0.0, 0.0, -0.09] }",
    );
    let turns = 24_u32;
    let at = |k: u32, radius: f64, z: f64| {
        let angle = TAU * f64::from(k % turns) / f64::from(turns);
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let ring = |radius: f64, z: f64, other: f64, top: f64| -> Vec<[[f64; 3]; 3]> {
        (0..turns)
            .flat_map(|k| {
                let [a, b] = [at(k, radius, z), at(k + 1, radius, z)];
                let [c, d] = [at(k, other, top), at(k + 1, other, top)];
                [[a, b, d], [a, d, c]]
            })
            .collect()
    };
    let funnel = ring(0.03, 0.05, 0.1, 0.12);
    // A cone of 45 degrees under a cylinder.
    let silo = [ring(0.032, 0.04, 0.07, 0.078), ring(0.07, 0.078, 0.07, 0.2)].concat();
    let filled: Vec<[f64; 3]> = lattice([6, 6, 4], 0.0203, [-0.052, -0.052, 0.09])
        .into_iter()
        .filter(|place| place[0].hypot(place[1]) < 0.058)
        .collect();
    let drum = include_str!("../../../templates/scenes/drum.toml")
        .replace("count = 400", "count = 120")
        .replace("duration = \"0.5 s\"", "duration = \"0.3 s\"\nstep = \"10 us\"")
        + "\n[compare.tolerance]\ntrajectory = 1e-6\n";
    const INNER: (&str, &str) =
        ("yade", "inner edges of the mesh: every facet that a sphere touches counts");
    let settled = usual.scene("A bed goes on", &bed([4, 4, 4], inside), &r#box);
    vec![
        Case {
            tolerance: 1e-6,
            reason: SEGMENTS,
            ..case(
                "bed-springs",
                "a settled bed goes on for 500 steps with the tangential springs of its contacts",
                settled + "\n[compare]\nstart = \"final_with_springs\"\nsteps = 500\n",
            )
        },
        Case {
            ranks: true,
            ..segments(
                "settled-bed",
                "spheres settle in a box of planes",
                usual.scene("A bed settles", &bed([4, 4, 4], inside), &r#box),
            )
        },
        Case {
            tolerance: 1e-9,
            resumes: true,
            known: &[(
                "liggghts",
                "read_restart is followed by a set-up pass with full-step velocities; chaos makes the difference grow",
            )],
            ..segments(
                "restarts",
                "a bed that settles is taken back to half its run and resumed (run.sh --resume)",
                usual.scene("A bed is resumed", &bed([4, 4, 2], inside), &r#box)
                    + "\n[decks]\nrestarts = 2\n",
            )
        },
        segments(
            "insertion",
            "spheres come one every 1.2 ms into a box of planes",
            late::raining(&usual, &r#box),
        ),
        Case {
            tolerance: 1e-6,
            reason: SEGMENTS,
            ..case(
                "insertion-start",
                "twelve spheres come into an empty box, one every 8 ms, and settle: the whole run",
                late::from_nothing(&usual, &r#box),
            )
        },
        segments(
            "compression",
            "a lid presses a bed",
            usual.scene("Uniaxial compression", &bed([4, 4, 4], inside), &(r#box.clone() + &lid)),
        ),
        segments(
            "column-collapse",
            "a column collapses on a rough plane",
            Usual { friction: 0.8, ..usual }.scene(
                "Column collapse",
                &bed([3, 3, 7], inside),
                &floor(),
            ),
        ),
        segments(
            "heap",
            "a heap forms: angle of repose",
            Usual { friction: 0.5, restitution: 0.3, ..usual }.scene(
                "A heap",
                &bed([2, 2, 14], inside),
                &floor(),
            ),
        ),
        Case {
            files: vec![("funnel.stl", stl(&funnel))],
            known: &[INNER],
            ..segments(
                "hopper",
                "spheres run out of a funnel (STL)",
                usual.scene(
                    "Hopper discharge",
                    &bed([4, 4, 3], [-0.03, -0.03, 0.1]),
                    &(floor() + &mesh_wall("funnel.stl")),
                ),
            )
        },
        Case {
            known: &[INNER],
            ..segments("drum", "a rotating drum (mesh), DEM2020 case 2 with the linear law", drum)
        },
        Case {
            files: vec![("silo.stl", stl(&silo))],
            known: &[INNER],
            ..segments(
                "silo",
                "a silo runs out: cylinder and cone (STL), DEM2020 case 1 with the linear law",
                usual.scene("Silo discharge", &crowd(&filled), &(floor() + &mesh_wall("silo.stl"))),
            )
        },
        penetration(),
    ]
}

/// A ball of 20 mm falls into a bed of spheres of 4 mm in a box of planes.
fn penetration() -> Case {
    let mut bodies = body("large", [0.0203, 0.0213, 0.0265], [0.0, 0.0, -2.0], STILL);
    for place in lattice([10, 10, 4], 0.0041, [0.0022, 0.0022, 0.0021]) {
        bodies += &body("tiny", place, STILL, STILL);
    }
    let mut walls = floor();
    for (name, axis, at) in
        [("left", 0, 0.0), ("right", 0, 0.042), ("front", 1, 0.0), ("back", 1, 0.042)]
    {
        let (mut point, mut normal) = ([0.0; 3], [0.0; 3]);
        point[axis] = at;
        normal[axis] = if at > 0.0 { -1.0 } else { 1.0 };
        walls += &plane(name, point, normal, "");
    }
    Case {
        lock_step: Some((2000, 500)),
        ..segments(
            "penetration",
            "a ball falls into a bed, sizes 5 : 1, DEM2020 case 3 with the linear law",
            Usual { steps: 8000, step: 4, friction: 0.3, ..USUAL }.scene(
                "A ball falls into a bed",
                &bodies,
                &walls,
            ),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Loaded;
    use std::path::Path;

    #[test]
    fn every_scene_is_read_and_no_key_is_there_twice() {
        let cases = all();
        assert!(cases.len() >= 24, "{}", cases.len());
        let keys: std::collections::BTreeSet<&str> =
            cases.iter().map(|case| case.key.as_str()).collect();
        assert_eq!(keys.len(), cases.len());
        for case in &cases {
            let read = Loaded::parse(Path::new("scene.toml"), case.scene.clone());
            let problem = read.err().map(|error| error.to_string()).unwrap_or_default();
            assert!(problem.is_empty(), "{}: {problem}\n{}", case.key, case.scene);
        }
    }
}
