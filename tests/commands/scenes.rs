//! new, list, check, and what is said about scenes.

use super::bench::{Bench, CLUMPS};
use serde_json::Value;

const SHIPPED: [&str; 10] = [
    "demo",
    "two-spheres",
    "spheres-box",
    "own-grains",
    "drum",
    "wet-drum",
    "discs-2d",
    "deformable-block",
    "cluster-impact",
    "star-cluster",
];

#[test]
fn every_shipped_scene_is_judged_usable() {
    let bench = Bench::new();
    for name in SHIPPED {
        let made = bench.ok(&["new", name]);
        let scene = format!("{name}/scene.toml");
        assert!(made.out.contains(&format!("riprap check {scene}")), "{}", made.out);
        let verdict = bench.ok(&["check", &scene]).out;
        for line in [
            "\n  step ",
            "\n  limit ",
            "\n  overlap ",
            "\n  forecast ",
            "\n  needs ",
            "\n  left out ",
        ] {
            assert!(verdict.contains(line), "{name}: {line}\n{verdict}");
        }
        assert!(!bench.path(&format!("{name}/scene.out")).exists(), "check writes nothing");
        assert_eq!(bench.call(&["new", name]).code, 2, "an existing scene is not overwritten");
    }
    assert!(bench.path("own-grains/grains/sample-2.stl").exists());
    let listed = bench.ok(&["list", "scenes", "--json"]).json();
    let names: Vec<&str> = listed["entries"]
        .as_array()
        .expect("rows")
        .iter()
        .filter_map(|row| row["key"].as_str())
        .collect();
    assert_eq!(names, SHIPPED);
    assert_eq!(bench.call(&["new", "no-such-scene"]).code, 2);
}

#[test]
fn check_forecasts_step_cost_and_needs() {
    let bench = Bench::with(CLUMPS);
    let verdict = bench.ok(&["check", "s.toml", "--json"]).json();
    assert_eq!(verdict["grains"], 6);
    assert!(
        verdict["spheres"].as_u64().is_some_and(|count| (12..=36).contains(&count)),
        "{verdict}"
    );
    assert_eq!(verdict["walls"], 6);
    let (step, limit) = (verdict["step"].as_f64(), verdict["advice"]["limit"].as_f64());
    assert!(step > Some(0.0) && step < limit, "{verdict}");
    assert!(verdict["memory"].as_f64() > Some(0.0) && verdict["seconds"].as_f64() > Some(0.0));
    assert_eq!(verdict["pairs"][0]["contact"]["friction"], 0.5);
    let keys = |name: &str| -> Vec<String> {
        serde_json::from_value(verdict[name].clone()).expect("keys")
    };
    let (needs, left_out) = (keys("needs"), keys("left_out"));
    assert!(needs.contains(&"clumps".into()) && needs.contains(&"friction".into()), "{needs:?}");
    assert!(left_out.contains(&"discs".into()) && left_out.contains(&"meshes".into()));
    assert!(needs.iter().all(|key| !left_out.contains(key)));
}

#[test]
fn lists_name_keys_sources_and_an_example() {
    let bench = Bench::new();
    let all = bench.ok(&["list"]).out;
    for kind in [
        "scenes", "shapes", "clumps", "packings", "measures", "contacts", "solvers", "formats",
        "studies",
    ] {
        let part = bench.ok(&["list", kind]).out;
        assert!(part.starts_with(&format!("{kind}\n")), "{part}");
        let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        // The table of what decks can say stands only where solvers are asked for.
        let (entries, table) = part.split_once("\nwhat decks can say\n").unwrap_or((&part, ""));
        assert!(plain(&all).contains(&plain(entries)), "{kind}");
        assert_eq!(table.is_empty(), kind != "solvers");
        let rows = bench.ok(&["list", kind, "--json"]).json();
        assert!(rows["entries"].as_array().is_some_and(|rows| !rows.is_empty()), "{kind}");
    }
    let clumps = bench.ok(&["list", "clumps"]).out;
    assert!(clumps.contains("Ferellec & McDowell 2010"), "{clumps}");
    assert!(clumps.contains("clump.normals = { spheres = 20 }"), "{clumps}");
    let left = std::fs::read_dir(bench.path(".")).expect("listed").count();
    assert_eq!(left, 0, "asking the solvers for their version leaves no file behind");
}

/// Fields without a description, and all field names met.
fn fields(schema: &Value, place: &str, bare: &mut Vec<String>, names: &mut Vec<String>) {
    if let Some(properties) = schema["properties"].as_object() {
        for (name, field) in properties {
            names.push(name.clone());
            // A method's key is described beside it, as the choice that it is.
            let choice = properties.len() == 1 && schema["description"].is_string();
            let said = field["description"].as_str().unwrap_or_default();
            if !choice && said.len() < 4 {
                bare.push(format!("{place}.{name}"));
            }
        }
    }
    match schema {
        Value::Object(map) => {
            map.iter()
                .for_each(|(key, inner)| fields(inner, &format!("{place}/{key}"), bare, names));
        }
        Value::Array(items) => items.iter().for_each(|item| fields(item, place, bare, names)),
        _ => {}
    }
}

fn keys_of(table: &toml::Table, into: &mut Vec<String>) {
    for (key, value) in table {
        into.push(key.clone());
        keys_of_value(value, into);
    }
}

fn keys_of_value(value: &toml::Value, into: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => keys_of(table, into),
        toml::Value::Array(items) => items.iter().for_each(|item| keys_of_value(item, into)),
        _ => {}
    }
}

#[test]
fn the_schema_names_and_describes_every_key() {
    let bench = Bench::new();
    let schema = bench.ok(&["list", "--schema"]).json();
    assert!(schema["$schema"].as_str().is_some_and(|uri| uri.contains("json-schema.org")));
    let (mut bare, mut names) = (Vec::new(), Vec::new());
    fields(&schema, "", &mut bare, &mut names);
    assert!(bare.is_empty(), "fields without a description: {bare:#?}");
    assert!(names.len() > 80, "{}", names.len());
    for name in SHIPPED {
        bench.ok(&["new", name, "-q"]);
        let scene: toml::Table = bench.read(&format!("{name}/scene.toml")).parse().expect("TOML");
        let mut used = Vec::new();
        keys_of(&scene, &mut used);
        // Materials have names of the user's own.
        let own: Vec<&String> = scene["materials"].as_table().expect("materials").keys().collect();
        let unknown: Vec<&String> =
            used.iter().filter(|key| !names.contains(key) && !own.contains(key)).collect();
        assert!(unknown.is_empty(), "{name}: {unknown:?}");
    }
}
