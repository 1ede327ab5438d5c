//! `trueaxis table1`.

use serde_json::Value;

use crate::program::{file_names, run, run_with_environment};

const USAGE: i32 = 2;

#[test]
fn same_seed_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let table = |seed: &str, threads: &str| {
        let args = ["table1", "--trials", "100", "--seed", seed, "--json"];
        let outcome = run_with_environment(folder.path(), &args, &[("RAYON_NUM_THREADS", threads)]);
        outcome.assert_good();
        outcome.stdout
    };
    let first = table("7", "1");
    assert_eq!(first, table("7", "2"));
    assert_ne!(first, table("8", "2"));

    let value: Value = serde_json::from_str(&first).unwrap();
    assert_eq!(value["format"], "trueaxis-table1");
    assert_eq!(value["points"], 195);
    for arrangement in value["arrangements"].as_array().unwrap() {
        let rows = arrangement["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 4);
        for row in rows {
            for axis in 0..3 {
                let number = |name: &str| row[name][axis].as_f64().unwrap();
                let ratio = number("monte_carlo_um") / number("printed_um");
                assert!((number("ratio") - ratio).abs() < 1e-12);
            }
        }
    }
    assert!(file_names(folder.path()).is_empty());
}

#[test]
fn the_table_is_said_and_not_printed() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["table1", "--trials", "100"]);
    outcome.assert_good();
    assert_eq!(outcome.stdout, "");
    for part in [
        "100 trials, seed 1",
        "regular tetrahedron",
        "0.35  0.41  0.43",
        "of 12 within 12 % of the printed ones",
    ] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
    let help = run(folder.path(), &["--help"]);
    assert!(help.stdout.contains("table1"), "{}", help.stdout);
}

#[test]
fn too_few_trials_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["table1", "--trials", "99"]);
    outcome.assert_failed("99 trials", USAGE, "99 is not in 100..");
}
