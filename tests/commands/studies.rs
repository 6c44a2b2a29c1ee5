//! study: error against run time.

use super::bench::{BALLS, Bench};

#[test]
fn a_study_writes_tables_charts_and_a_page() {
    let bench = Bench::with(BALLS);
    let said = bench.ok(&["study", "contact", "--quick", "-o", "found", "--json"]).json();
    assert_eq!(said["study"], "contact");
    let files = said["files"].as_array().expect("a list of files");
    assert!(files.len() >= 4);
    let csv = bench.read("found/restitution.csv");
    assert!(csv.starts_with("scheme,") && csv.lines().count() > 10, "{csv}");
    let page = bench.read("found/index.html");
    assert!(page.contains("<svg") && page.contains("riprap study contact --quick"));
}

#[test]
fn a_study_that_there_is_not_names_those_that_there_are() {
    let bench = Bench::with(BALLS);
    let call = bench.call(&["study", "contacts"]);
    assert_eq!(call.code, 2);
    assert!(call.err.contains("contact"), "{}", call.err);
    assert!(!bench.path("study-contacts").exists());
}
