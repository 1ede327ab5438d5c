//! `trueaxis schema`: what is shipped and what the program writes fits, and what is damaged does not.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::json_schema::faults;
use crate::program::{contents, run, run_line, shipped};

fn schema(name: &str) -> Value {
    let outcome = run(Path::new("."), &["schema", name]);
    outcome.assert_good();
    serde_json::from_str(&outcome.stdout).unwrap()
}

/// Asserts that the documents of these formats below a folder fit their schemas; returns how many there are of each.
#[track_caller]
fn assert_fit<const N: usize>(folder: &Path, names: [&str; N]) -> [usize; N] {
    let schemas = names.map(schema);
    let mut counts = [0; N];
    for (path, bytes) in contents(folder) {
        let Ok(document) = serde_json::from_slice::<Value>(&bytes) else {
            continue;
        };
        let format = document["format"].as_str().unwrap_or_default();
        let Some(index) = names
            .iter()
            .position(|name| format == format!("trueaxis-{name}"))
        else {
            continue;
        };
        let faults = faults(&schemas[index], &document);
        assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
        counts[index] += 1;
    }
    counts
}

#[test]
fn shipped_documents_fit() {
    let all = shipped("fxyz").join("..");
    let counts = assert_fit(&all, ["campaign", "scenario", "truth"]);
    assert_eq!(counts, [7, 3, 3]);
}

/// Campaigns and scenarios that are shipped name the schemas beside them, which are those of the program.
#[test]
fn shipped_schemas_are_those_of_the_program() {
    let all = shipped("fxyz").join("..");
    for name in ["campaign", "scenario"] {
        let file = format!("{name}.schema.json");
        let shipped = fs::read_to_string(all.join(&file)).unwrap();
        let outcome = run(Path::new("."), &["schema", name]);
        assert!(
            outcome.stdout == shipped,
            "make it again: trueaxis schema {name} > campaigns/{file}"
        );
        let named = contents(&all).into_iter().filter(|(path, _)| {
            path.file_name().unwrap().to_str() == Some(&format!("{name}.json"))
        });
        for (path, bytes) in named {
            let document: Value = serde_json::from_slice(&bytes).unwrap();
            assert_eq!(
                document["$schema"],
                format!("../{file}"),
                "{}",
                path.display()
            );
        }
    }
}

/// Results of all methods, of campaigns with causes, gross errors, contradictions and readings.
#[test]
fn results_fit() {
    let folder = tempfile::tempdir().unwrap();
    let current = folder.path();
    let good = |line: &str| {
        let outcome = run_line(current, line);
        outcome.assert_good();
        outcome.stdout
    };
    good("calibrate @fxyz --out a --no-report");
    good("calibrate @fxyz --out b --no-report --method six");
    good("calibrate @rotary-stage --out c --no-report --method nine");
    good("calibrate @five-axis --out d --no-report --by-direction");
    good("calibrate @five-axis --out e --no-report");
    good("compare a/calibration.json b/calibration.json --out a");
    good("verify a/calibration.json @fxyz-lines --out a --no-report");
    good("volume a/calibration.json --points 3 --out a");
    good("volume e/calibration.json --points 2 --out e --draws 0");
    good("diagnose @fxyz-lines --out l --no-report");
    // Its lost motion moves axes: results in µm, mm and arcsec.
    good("diagnose @five-axis --out m --no-report");
    good("montecarlo @rotary-stage --trials 100 --out c");
    let checked = good("check @five-axis --json");
    fs::write(current.join("check.json"), checked).unwrap();
    let refused = run(current, &["check", "no.json", "--json"]).stdout;
    fs::write(current.join("error.json"), refused).unwrap();

    let text = fs::read(shipped("fxyz").join("scenario.json")).unwrap();
    let mut scenario: Value = serde_json::from_slice(&text).unwrap();
    scenario["effects"] = json!([{
        "effect": "dead_path_jump", "subject": { "station": "S2" },
        "parameters": [ { "name": "jump", "value": 4.0, "unit": "um" },
                        { "name": "time", "value": 4000.0, "unit": "s" } ]
    }]);
    fs::write(current.join("scenario.json"), scenario.to_string()).unwrap();
    good("simulate scenario.json --out measured");
    good("diagnose measured/campaign.json --out f --no-report");
    good("calibrate measured/campaign.json --out f --with-effects f/effects.json --no-report");

    let names = [
        "campaign",
        "scenario",
        "effects",
        "calibration",
        "diagnosis",
        "verification",
        "volume",
        "comparison",
        "montecarlo",
        "check",
        "error",
        "truth",
    ];
    let counts = assert_fit(current, names);
    assert_eq!(counts, [1, 3, 2, 6, 3, 1, 2, 1, 1, 1, 1, 1]);

    // What was changed by hand does not fit.
    let text = fs::read(current.join("a/calibration.json")).unwrap();
    let calibration: Value = serde_json::from_slice(&text).unwrap();
    let damages: [fn(&mut Value); 5] = [
        |c| c["axes"][0]["components"]["EXX"]["value_nm"] = json!([1]),
        |c| c["adjustment"]["sigma0"] = json!("1"),
        |c| c["version"] = json!(2),
        |c| c["axes"][0]["kind"] = json!("curved"),
        |c| {
            c.as_object_mut().unwrap().remove("machine");
        },
    ];
    let schema = schema("calibration");
    for damage in damages {
        let mut damaged = calibration.clone();
        damage(&mut damaged);
        assert_eq!(faults(&schema, &damaged).len(), 1);
    }
}

/// Every field of a campaign, one after the other, left out, of another type, and beside an unknown one: schema and
/// reader say the same of its form.
#[test]
fn schema_and_reader_agree_on_damaged_campaigns() {
    let schema = schema("campaign");
    let mut campaign: Value =
        serde_json::from_slice(&fs::read(shipped("fxyz").join("campaign.json")).unwrap()).unwrap();
    campaign["$schema"] = json!("campaign.schema.json");
    campaign["date"] = json!("2026-03-31");
    campaign["targets"][0]["reflector"] = json!("R1");
    campaign["stations"][0]["approx_mm"] = json!([1000, 1000, 1000]);
    campaign["stations"].as_array_mut().unwrap().truncate(1);
    campaign["known_lengths"] =
        json!([{ "targets": ["P", "Q"], "length_mm": 272.6, "sigma_um": 1.0 }]);
    campaign["verification"] = json!([{ "name": "LI", "kind": "positioning", "axis": "X", "target_mm": [1, 2, 3],
                                        "readings": "li.csv" }]);
    assert_eq!(faults(&schema, &campaign), [""; 0]);
    let folder = tempfile::tempdir().unwrap();
    let (mut count, mut refused) = (0, 0);
    let pointers = pointers(&campaign, String::new());
    // The reader ignores it, whatever it is.
    for pointer in pointers.into_iter().filter(|pointer| pointer != "/$schema") {
        let (parent, name) = pointer.rsplit_once('/').unwrap();
        let is_field = campaign.pointer(parent).unwrap().is_object();
        let damages: [&dyn Fn(&mut Value); 3] = [
            &|c| {
                if let Some(fields) = c.pointer_mut(parent).unwrap().as_object_mut() {
                    fields.remove(name);
                }
            },
            &|c| *c.pointer_mut(&pointer).unwrap() = json!({ "odd": true }),
            &|c| c.pointer_mut(parent).unwrap()[format!("{name}_odd")] = json!(1),
        ];
        for damage in &damages[..if is_field { 3 } else { 2 }] {
            let mut damaged = campaign.clone();
            damage(&mut damaged);
            if damaged == campaign {
                continue;
            }
            fs::write(folder.path().join("campaign.json"), damaged.to_string()).unwrap();
            let outcome = run(folder.path(), &["check", "campaign.json"]);
            assert_ne!(outcome.code, Some(0));
            // Its form: fields, types and names of kinds. What names and numbers mean is the reader's alone.
            let is_form = ["[E011]", "[E012]", "[E101]", "[E102]", "[E103]", "[E104]"]
                .iter()
                .any(|code| outcome.stderr.contains(code));
            let faults = faults(&schema, &damaged);
            assert!(
                is_form || faults.is_empty(),
                "{pointer}: only the schema refuses: {faults:?}; {}",
                outcome.stderr
            );
            let by_meaning = outcome.stderr.contains("invalid")
                || outcome.stderr.contains("unknown field")
                || outcome.stderr.contains("is missing; add it") && is_field;
            assert!(
                !by_meaning || !faults.is_empty(),
                "{pointer}: only the reader refuses: {}",
                outcome.stderr
            );
            count += 1;
            refused += usize::from(!faults.is_empty());
        }
    }
    assert!(count > 150 && refused > 110, "{refused} of {count}");
}

/// All fields and elements at every depth, as JSON pointers.
fn pointers(value: &Value, path: String) -> Vec<String> {
    let children: Vec<(String, &Value)> = match value {
        Value::Object(fields) => fields
            .iter()
            .map(|(name, value)| (name.clone(), value))
            .collect(),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .map(|(i, item)| (i.to_string(), item))
            .collect(),
        _ => Vec::new(),
    };
    let mut all = Vec::new();
    for (name, child) in children {
        let path = format!("{path}/{}", name.replace('/', "~1"));
        all.push(path.clone());
        all.extend(pointers(child, path));
    }
    all
}
