//! `riprap check`: judges a scene, runs nothing.

use super::{Ending, Screen};
use crate::scene::Loaded;
use crate::scene::verdict::{Lists, Verdict};
use std::path::Path;

pub fn check(scene: &Path, screen: &Screen) -> Result<(), Ending> {
    let loaded = Loaded::read(scene)?;
    let verdict = Verdict::of(&loaded, &screen.job())?;
    screen.result(&verdict, &text(&verdict))
}

fn text(v: &Verdict) -> String {
    let mut text = format!("{}\n", v.title);
    let mut line = |name: &str, value: String| text.push_str(&format!("  {name:12} {value}\n"));
    line("grains", format!("{} as about {} spheres, {} walls", v.grains, v.spheres, v.walls));
    for pair in &v.pairs {
        let c = &pair.contact;
        line(
            "contact",
            format!(
                "{} – {}: kn {:.4e} N/m, kt {:.4e} N/m, cn {:.4e} N s/m, ct {:.4e} N s/m, friction {}",
                pair.between[0], pair.between[1], c.kn, c.kt, c.cn, c.ct, c.friction
            ),
        );
        line("", format!("{}; restitution {}", pair.stiffness, range(pair.restitution)));
    }
    line("step", format!("{:.4e} s × {} steps ({})", v.step, v.steps, v.reason));
    line("limit", format!("{:.4e} s", v.advice.limit));
    line(
        "overlap",
        format!(
            "at rest about {:.2} % of a radius, at impact about {:.2} %",
            v.advice.static_overlap * 100.0,
            v.advice.impact_overlap * 100.0
        ),
    );
    line("forecast", format!("{}, about {} on one thread", memory(v.memory), duration(v.seconds)));
    line("lists", lists(&v.lists));
    line("needs", v.needs.join(", "));
    line("left out", v.left_out.join(", "));
    v.warnings.iter().for_each(|warning| line("warning", warning.clone()));
    v.solvers.iter().for_each(|note| line("note", note.clone()));
    text
}

fn lists(lists: &Lists) -> String {
    let mut text = format!("cells of {:.3e} m", lists.cell);
    if let Some(spheres) = lists.spheres_per_cell {
        text.push_str(&format!(", {spheres:.2} spheres a cell on average"));
    }
    text.push_str(&format!("; skin {:.3e} m; ", lists.skin));
    text.push_str(&match lists.steps_between {
        Some(steps) => format!(
            "at most about {} rebuilds, one every {steps} steps at the fastest speed expected",
            lists.rebuilds
        ),
        None => "one build where nothing moves; no speed can be foreseen".to_owned(),
    });
    text
}

fn range([first, second]: [f64; 2]) -> String {
    if (first - second).abs() < 5e-4 {
        return format!("{first:.3}");
    }
    format!("{first:.3} (lightest pair) to {second:.3} (heaviest)")
}

fn memory(bytes: f64) -> String {
    match bytes {
        b if b < 1e6 => format!("{:.0} kB", (b / 1e3).ceil()),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}
