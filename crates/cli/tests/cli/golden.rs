//! The tables on the terminal and the schemas of results, line by line as users see them.
//!
//! They are kept in `golden/`. After a change that is meant, `GOLDEN=write cargo test -p trueaxis-cli golden` writes them
//! anew; look at the difference before it is committed.

use std::fs;
use std::path::Path;

use crate::program::{calibrate_shipped, run, run_line};

#[track_caller]
fn assert_golden(name: &str, said: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/cli/golden")
        .join(name);
    if std::env::var_os("GOLDEN").is_some() {
        fs::write(&file, said).unwrap();
    }
    let golden = fs::read_to_string(&file).unwrap_or_default();
    for (number, (said, golden)) in (1..).zip(said.lines().zip(golden.lines())) {
        assert_eq!(said, golden, "{name} line {number}");
    }
    assert_eq!(
        said.lines().count(),
        golden.lines().count(),
        "{name}: lines"
    );
}

#[test]
fn golden_tables() {
    let folder = tempfile::tempdir().unwrap();
    for (name, line) in [
        ("calibrate-fxyz.txt", "calibrate @fxyz --out a"),
        (
            "calibrate-five-axis.txt",
            "calibrate @five-axis --out b --by-direction",
        ),
        (
            "verify-fxyz-lines.txt",
            "verify a/calibration.json @fxyz-lines --out a",
        ),
        ("diagnose-fxyz-lines.txt", "diagnose @fxyz-lines --out c"),
    ] {
        let outcome = run_line(folder.path(), line);
        outcome.assert_good();
        assert_golden(name, &outcome.stderr);
    }
}

#[test]
fn golden_help_of_export() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["export", "--help"]);
    outcome.assert_good();
    assert_golden("help-export.txt", &outcome.stdout);
}

/// What is said of old tables that are none.
#[test]
fn golden_old_tables() {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "fxyz");
    let text = "0 0 0\n440 440.01 440.01\n";
    fs::create_dir(folder.path().join("old")).unwrap();
    fs::create_dir(folder.path().join("cut")).unwrap();
    for (name, text) in [
        ("X_old.comp", text),
        ("X.com.csv", text),
        ("type1.comp", text),
        ("old/X.comp", text),
        ("old/notes.txt", text),
        ("cut/X.comp", &text[..20]),
        ("X.comp", "0 0 0\n440 0.01 0.01\n"),
        ("Y.comp", ""),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let mut all = String::new();
    for (format, onto) in [
        ("linuxcnc", "X_old.comp"),
        ("linuxcnc", "X.comp"),
        ("linuxcnc", "Y.comp"),
        ("linuxcnc", "old"),
        ("linuxcnc", "cut"),
        ("linuxcnc", "."),
        ("heidenhain", "X_old.comp"),
        ("heidenhain", "X.com.csv"),
        ("heidenhain", "old"),
        ("sinumerik", "X_old.comp"),
        ("isg", "X_old.comp"),
        ("etalon", "X_old.comp"),
        ("grid", "X_old.comp"),
        ("marlin", "X_old.comp"),
        ("klipper", "X_old.comp"),
    ] {
        let sign = match format {
            "heidenhain" => " --sign error",
            _ => "",
        };
        let line = format!(
            "export {format} calibrated/calibration.json --axis X --onto {onto}{sign} --out new"
        );
        let outcome = run_line(folder.path(), &line);
        let code = outcome.code.unwrap();
        all.push_str(&format!(
            "--- export {format} --onto {onto}: exit code {code}\n{}",
            outcome.stderr
        ));
    }
    assert_golden("export-onto.txt", &all);
}

/// Those of campaigns and scenarios are shipped.
#[test]
fn golden_schemas() {
    let folder = tempfile::tempdir().unwrap();
    for document in [
        "effects",
        "calibration",
        "diagnosis",
        "verification",
        "volume",
        "comparison",
        "montecarlo",
        "check",
        "truth",
        "error",
    ] {
        let outcome = run(folder.path(), &["schema", document]);
        outcome.assert_good();
        assert_golden(&format!("{document}.schema.json"), &outcome.stdout);
    }
}
