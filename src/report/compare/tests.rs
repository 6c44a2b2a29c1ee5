//! What passes, what fails, and why.

use super::*;
use crate::model::{Contact, ContactTable, Scheme};
use crate::num::Vec3;
use crate::report::fixture;

fn scene() -> (Model, Run) {
    let model = fixture::model(3);
    let ours = fixture::run(&model, "riprap (leapfrog)", |_| Vec3::zeros());
    (model, ours)
}

fn twin(run: &Run) -> Twin {
    Twin { of: 0, scheme: "liggghts".into(), run: run.clone() }
}

#[test]
fn equal_runs_agree_in_everything() {
    let (model, ours) = scene();
    let other = Run { solver: "LIGGGHTS 3.8.0".into(), ..ours.clone() };
    let found = compare(&model, &ours, &[other], &[twin(&ours)], &Tolerances::default());
    assert!(found.passed(), "{:#?}", found.others[0].reasons);
    assert_eq!(found.others[0].rows.len(), 8);
    assert!(found.others[0].rows.iter().all(|row| row.relative == 0.0 && row.chance == 0.0));
    assert_eq!(found.others[0].twin.as_ref().and_then(|t| t.worst_in_window), Some(0.0));
}

#[test]
fn a_wrong_computation_fails_and_says_so() {
    let (model, ours) = scene();
    // A hundredth of a radius off from the first frame on.
    let shift = |step: u64| if step > 0 { Vec3::x() * 5e-5 } else { Vec3::zeros() };
    let other = fixture::run(&model, "LIGGGHTS 3.8.0", shift);
    let found = compare(&model, &ours, &[other], &[twin(&ours)], &Tolerances::default());
    let opponent = &found.others[0];
    assert!(!found.passed());
    assert!(opponent.rows.iter().all(|row| row.passed), "the bed is the same");
    assert!(opponent.reasons[0].contains("Not the same computation"), "{:?}", opponent.reasons);
    let worst = opponent.twin.as_ref().and_then(|t| t.worst_in_window).expect("frames");
    assert!((worst - 0.01).abs() < 1e-9);
}

#[test]
fn parting_after_the_window_is_chaos_not_failure() {
    let (model, ours) = scene();
    let late = |step: u64| Vec3::x() * (5e-5 * f64::from(u8::from(step >= 800)));
    let other = fixture::run(&model, "LIGGGHTS 3.8.0", late);
    let tolerances = Tolerances { contact_durations: 10.0, ..Tolerances::default() };
    let found = compare(&model, &ours, &[other], &[twin(&ours)], &tolerances);
    // tc = π √(m/2 / kn), m = ρ 4/3 π r³.
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005_f64.powi(3);
    let expected = std::f64::consts::PI * (0.5 * mass / 1e5_f64).sqrt();
    assert!((found.contact_duration / expected - 1.0).abs() < 1e-12);
    assert!(found.window_end < 8e-3 && found.window_end > 1e-3, "{}", found.window_end);
    assert!(found.passed(), "{:?}", found.others[0].reasons);
    assert!(found.others[0].reasons.iter().any(|r| r.contains("chaotic")));
}

#[test]
fn a_lifted_bed_fails_by_its_height_alone() {
    let (model, ours) = scene();
    let other = fixture::run(&model, "YADE", |step| Vec3::z() * (3e-6 * step as f64));
    let found = compare(&model, &ours, &[other], &[], &Tolerances::default());
    let failed: Vec<_> =
        found.others[0].rows.iter().filter(|row| !row.passed).map(|r| r.quantity).collect();
    assert_eq!(failed, [Quantity::TopHeight, Quantity::MeanHeight, Quantity::Porosity]);
    let top = found.others[0].rows[0];
    // Mean over the frames at steps 800, 900 and 1000.
    assert!((top.theirs - top.ours - 2.7e-3).abs() < 1e-12);
}

/// Ours and two twins that parted late, each with its bed a little higher.
fn realisations(model: &Model, heights: [f64; 3]) -> [Run; 3] {
    heights.map(|height| {
        let late = move |step: u64| {
            let jump = f64::from(u8::from(step >= 700));
            (Vec3::x() * 40.0 + Vec3::z()) * (height * jump)
        };
        fixture::run(model, "riprap", late)
    })
}

fn twins([_, first, second]: &[Run; 3]) -> [Twin; 2] {
    [(0, first), (1, second)].map(|(of, run)| Twin { of, ..twin(run) })
}

#[test]
fn a_bed_within_the_scatter_of_its_twins_passes_and_a_lifted_one_does_not() {
    let (model, _) = scene();
    let runs = realisations(&model, [0.0, 1e-4, 2e-4]);
    let tolerances = Tolerances { contact_durations: 5.0, height: 0.02, ..Tolerances::default() };
    let found = |lift: f64| {
        let other = realisations(&model, [lift; 3])[0].clone();
        compare(&model, &runs[0], &[other], &twins(&runs), &tolerances)
    };
    let near = found(5e-4);
    assert_eq!(near.realisations.runs.len(), 3);
    let scatter = &near.realisations.scatter[0];
    assert!((scatter.deviation - 1e-4).abs() < 1e-12, "{scatter:?}");
    let row = near.others[0].rows[0];
    // Student's 4.30 for two degrees of freedom times √2 s.
    assert!((row.chance * row.scale - 4.303 * 2_f64.sqrt() * 1e-4).abs() < 1e-9);
    assert!(row.passed && row.relative > 0.016, "{row:?}");
    let far = found(1.8e-3);
    let row = far.others[0].rows[0];
    assert!(!row.passed && row.relative > row.allowed, "{row:?}");
}

#[test]
fn chance_is_allowed_three_tolerances_at_most() {
    let (model, _) = scene();
    let runs = realisations(&model, [0.0, 4e-3, 9e-3]);
    let other = realisations(&model, [7e-3; 3])[0].clone();
    let tolerances = Tolerances { contact_durations: 5.0, ..Tolerances::default() };
    let found = compare(&model, &runs[0], &[other], &twins(&runs), &tolerances);
    let row = found.others[0].rows[0];
    assert!((row.allowed - 0.15).abs() < 1e-12 && row.chance > 0.5 && !row.passed);
    assert!(found.others[0].reasons.iter().any(|r| r.contains("more grains")));
}

#[test]
fn twins_that_never_parted_are_no_realisations() {
    let (model, ours) = scene();
    let other = fixture::run(&model, "YADE", |step| Vec3::z() * (3e-6 * step as f64));
    let twins = [twin(&ours), Twin { of: 1, ..twin(&ours) }];
    let found = compare(&model, &ours, &[other], &twins, &Tolerances::default());
    assert_eq!(found.realisations.runs.len(), 1);
    assert!(found.realisations.scatter.is_empty());
    assert!(!found.passed());
}

#[test]
fn a_denser_bed_fails() {
    let (model, ours) = scene();
    // A tenth lower, layer pressed into layer.
    let mut other = ours.clone();
    for frame in &mut other.frames {
        for centre in &mut frame.centres {
            centre.z *= 0.9;
        }
        for body in &mut frame.bodies {
            body.position.z *= 0.9;
        }
    }
    let found = compare(&model, &ours, &[other], &[], &Tolerances::default());
    let failed: Vec<_> =
        found.others[0].rows.iter().filter(|row| !row.passed).map(|r| r.quantity).collect();
    assert!(failed.contains(&Quantity::Porosity) && failed.contains(&Quantity::MeanForce));
}

/// A column of spheres on a floor without sides, run by our DEM.
fn collapse(friction: f64, scheme: Scheme, model: &Model) -> Run {
    let mut model = model.clone();
    let contact = Contact { friction, ..*model.contacts.between(0, 0) };
    model.contacts = ContactTable::uniform(1, contact);
    model.plan.scheme = scheme;
    model.plan.law = scheme.law();
    crate::dem::run(&model, &crate::num::Job::quiet()).expect("a sound model")
}

#[test]
fn wrong_friction_fails_although_chance_is_allowed_for() {
    let mut model = fixture::model(3);
    model.walls.truncate(1);
    let contact = Contact { kn: 2e3, kt: 1e3, cn: 0.8, ct: 0.0, friction: 0.6 };
    model.contacts = ContactTable::uniform(1, contact);
    model.domain = model.domain.grown(1.0);
    (model.plan.step, model.plan.steps, model.plan.frame_every) = (2e-5, 15_000, 500);
    for (index, body) in model.bodies.iter_mut().enumerate() {
        body.position.x += 1e-3 * (index as f64).sin();
    }
    let ours = collapse(0.6, Scheme::Leapfrog, &model);
    let twins = [(0, Scheme::Liggghts), (1, Scheme::Yade)].map(|(of, scheme)| Twin {
        of,
        scheme: scheme.key().into(),
        run: collapse(0.6, scheme, &model),
    });
    let compared = |friction| {
        let other = collapse(friction, Scheme::Liggghts, &model);
        compare(&model, &ours, &[other], &twins, &Tolerances::default())
    };
    let same = compared(0.6);
    assert!(same.passed(), "{:?}", same.others[0].reasons);
    let wrong = compared(0.05);
    assert!(!wrong.passed());
    let rows = &wrong.others[0].rows;
    assert!(rows.iter().any(|row| row.quantity == Quantity::Spread && !row.passed), "{rows:?}");
}

#[test]
fn kinetic_energy_is_held_against_what_was_put_in() {
    let (model, ours) = scene();
    let mut other = ours.clone();
    let last = other.frames.last_mut().expect("eleven frames");
    last.bodies[0].velocity = Vec3::x() * 1e-4;
    let found = compare(&model, &ours, &[other], &[], &Tolerances::default());
    let row = found.others[0].rows.iter().find(|r| r.quantity == Quantity::Kinetic);
    let row = row.expect("kinetic energy is always there");
    assert!(row.ours == 0.0 && row.theirs > 0.0 && row.passed && row.relative < 1e-6);
    assert!((found.energy_scale - 1e-3).abs() < 1e-12);
}

#[test]
fn broken_runs_fail_without_spreading_bad_numbers() {
    let (model, ours) = scene();
    let mut bad = ours.clone();
    bad.frames[4].centres[2].y = f64::NAN;
    let mut none = ours.clone();
    none.frames.clear();
    none.outcome = Outcome::Failed { reason: "lost atoms".into() };
    let mut short = ours.clone();
    short.frames.truncate(6);
    let found = compare(&model, &ours, &[bad, none, short], &[], &Tolerances::default());
    assert!(found.others.iter().all(|other| !other.passed));
    assert!(found.others[1].reasons[0].contains("lost atoms"));
    assert!(found.others[2].reasons.iter().any(|r| r.contains("ended at")));
    let json = serde_json::to_string(&found).expect("finite numbers");
    assert!(!json.contains("null,null"), "no NaN was written as null");
    assert!(!found.csv().contains("NaN"));
}

#[test]
fn nothing_compared_is_no_pass() {
    let (model, ours) = scene();
    assert!(!compare(&model, &ours, &[], &[], &Tolerances::default()).passed());
}

#[test]
fn too_few_frames_leave_the_question_open() {
    let (model, mut ours) = scene();
    let mut other = fixture::run(&model, "YADE", |step| Vec3::x() * (5e-8 * step as f64));
    for run in [&mut ours, &mut other] {
        run.frames.retain(|frame| frame.step % 1000 == 0);
    }
    let tolerances = Tolerances { contact_durations: 5.0, ..Tolerances::default() };
    let found = compare(&model, &ours, &[other], &[twin(&ours)], &tolerances);
    assert_eq!(found.others[0].twin.as_ref().and_then(|t| t.agrees), None);
    assert!(found.others[0].reasons.iter().any(|r| r.contains("not answered")));
}

#[test]
fn files_read_back() {
    let (model, ours) = scene();
    let other = Run { solver: "LIGGGHTS 3.8.0, \"our\" build".into(), ..ours.clone() };
    let found = compare(&model, &ours, &[other], &[twin(&ours)], &Tolerances::default());
    let folder = tempfile::tempdir().expect("a temporary folder");
    found.write(folder.path()).expect("writable");
    let json = std::fs::read(folder.path().join("compare.json")).expect("written");
    assert_eq!(serde_json::from_slice::<Comparison>(&json).expect("JSON"), found);
    let csv = std::fs::read_to_string(folder.path().join("compare.csv")).expect("written");
    assert!(csv.contains("\"LIGGGHTS 3.8.0, \"\"our\"\" build\",porosity,,"));
    let names = std::fs::read_dir(folder.path()).expect("there").count();
    assert_eq!(names, 2, "no temporary is left behind");
}
