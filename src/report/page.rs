//! The report as one self-contained HTML page.
//!
//! `templates/report/` holds every tag; this file and `sections` hand
//! it finished texts, numbers and figures. Charts are inline SVG, pictures PNG
//! inside the page; nothing is loaded from anywhere. A section whose data is
//! absent is absent.

use super::input::PageInput;
use super::sections::Sections;
use super::{ReportError, write_whole};
use std::path::Path;
use tera::{Context, Tera};

const PAGE: &str = include_str!("../../templates/report/page.html");

/// What all pages share, by the names under which templates use it.
pub(super) const SHARED: [(&str, &str); 2] = [
    ("style.css", include_str!("../../templates/report/style.css")),
    ("parts.html", include_str!("../../templates/report/parts.html")),
];

/// The page as HTML text.
pub fn page(input: &PageInput) -> Result<String, ReportError> {
    page_with(input, 1)
}

/// The page with every picture `shrink` times smaller, for quick tests.
fn page_with(input: &PageInput, shrink: usize) -> Result<String, ReportError> {
    let mut tera = Tera::default();
    tera.add_raw_templates(SHARED)?;
    tera.add_raw_template("page.html", PAGE)?;
    let sections = Sections::of(input, shrink)?;
    Ok(tera.render("page.html", &Context::from_serialize(&sections)?)?)
}

/// Writes the page, whole or not at all.
pub fn write_page(input: &PageInput, path: &Path) -> Result<(), ReportError> {
    write_whole(path, page(input)?.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Vec3;
    use crate::pack::Packing;
    use crate::report::chart::tests::assert_balanced;
    use crate::report::compare::{Tolerances, Twin, compare};
    use crate::report::fixture;

    const IDS: [&str; 12] = [
        "verdict",
        "scene",
        "grains",
        "clumps",
        "packing",
        "run",
        "measures",
        "final",
        "trajectories",
        "cost",
        "notes",
        "reproduce",
    ];

    fn present(html: &str) -> Vec<&'static str> {
        IDS.into_iter()
            .filter(|id| {
                let count = html.matches(&format!("<section id=\"{id}\">")).count();
                let links = html.matches(&format!("href=\"#{id}\"")).count();
                assert!(count <= 1 && links == count, "{id}: {count} sections, {links} links");
                count == 1
            })
            .collect()
    }

    fn after_picture(part: &str) -> &str {
        part.split_once('"').map_or(part, |(_, rest)| rest)
    }

    /// A page with everything on it.
    fn full(shrink: usize) -> String {
        let model = fixture::model(4);
        let ours = fixture::run(&model, "riprap (leapfrog)", |_| Vec3::zeros());
        let grow = |rate: f64| {
            move |step: u64| Vec3::new(1.0, 0.5, 0.2) * (5e-14 * (step as f64 / rate).exp())
        };
        let mut others = vec![
            fixture::run(&model, "LIGGGHTS 3.8.0", grow(60.0)),
            fixture::run(&model, "YADE 2023.02a", grow(40.0)),
        ];
        others[0].notes.push("Spheres <& walls> have the same lever arm.".into());
        others[1].cost.cpu_seconds = 7.0;
        let twins = [
            Twin {
                of: 0,
                scheme: "liggghts".into(),
                run: fixture::run(&model, "twin", grow(90.0)),
            },
            Twin { of: 1, scheme: "yade".into(), run: ours.clone() },
        ];
        let found = compare(&model, &ours, &others, &twins, &Tolerances::default());
        let solids = vec![fixture::solid("grain-0"), fixture::solid("grain-1")];
        let clumps = vec![fixture::clump("grain-0"), fixture::clump("grain-1")];
        let packing = Packing {
            placements: Vec::new(),
            dropped: vec![1],
            outcome: "reached its porosity".into(),
            measures: crate::pack::Measures {
                container_volume: 1e-3,
                porosity: 0.41,
                porosity_error: 0.001,
                coordination: 4.2,
                gap_tolerance: 1e-6,
                worst_overlap: 0.02,
                least_gap: Some(-1e-4),
            },
        };
        let missing = vec!["LAMMPS was not found.".to_owned()];
        let commands = vec!["riprap compare scene.toml".to_owned()];
        page_with(
            &PageInput {
                title: "A <box> of spheres",
                version: "riprap 0.1.0",
                model: Some(&model),
                solids: &solids,
                clumps: &clumps,
                packing: Some(&packing),
                ours: Some(&ours),
                measures: (
                    &[["core".into(), "last 2 frames: porosity 0.4 within 0.1 %".into()]],
                    &[super::super::curves::heights(&model, &[&ours])],
                ),
                others: &others,
                comparison: Some(&found),
                missing: &missing,
                commands: &commands,
                ..PageInput::default()
            },
            shrink,
        )
        .expect("the template fits")
    }

    #[test]
    fn a_full_page_has_each_section_once_and_needs_nothing_from_outside() {
        let html = full(10);
        assert_eq!(present(&html), IDS);
        assert_balanced(&html);
        assert!(html.contains("A &lt;box&gt; of spheres") && html.contains("&lt;&amp; walls&gt;"));
        // Without the pictures, whose Base64 may hold any three letters.
        let words: String = html.split("data:image/png;base64,").map(after_picture).collect();
        assert!(!words.contains("NaN") && !words.contains("inf"));
        let outside = words.replace("http://www.w3.org/2000/svg", "");
        for sign in ["http:", "https:", "<script", "<link", "@import", "url("] {
            assert!(!outside.contains(sign), "{sign}");
        }
    }

    #[test]
    fn the_page_is_the_same_every_time() {
        assert_eq!(full(20), full(20));
    }

    #[test]
    fn what_is_absent_leaves_no_trace() {
        let empty = page(&PageInput { title: "nothing", ..PageInput::default() }).expect("fits");
        assert_eq!(present(&empty), [""; 0]);
        assert_balanced(&empty);
        let model = fixture::model(2);
        let ours = fixture::run(&model, "riprap (leapfrog)", |_| Vec3::zeros());
        let alone = PageInput { model: Some(&model), ours: Some(&ours), ..PageInput::default() };
        let html = page_with(&alone, 10).expect("fits");
        assert_eq!(present(&html), ["scene", "run", "final", "trajectories", "cost"]);
        assert_balanced(&html);
    }
}
