//! The tables on the terminal and the schemas of results, line by line as users see them.
//!
//! They are kept in `golden/`. After a change that is meant, `GOLDEN=write cargo test -p trueaxis-cli golden` writes them
//! anew; look at the difference before it is committed.

use std::fs;
use std::path::Path;

use crate::program::{calibrate_shipped, run, shipped};

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
    let said = |args: &[&str]| {
        let outcome = run(folder.path(), args);
        outcome.assert_good();
        outcome.stderr
    };
    let campaign = |name: &str| shipped(name).join("campaign.json").display().to_string();
    let [fxyz, five, lines] = ["fxyz", "five-axis", "fxyz-lines"].map(campaign);
    assert_golden(
        "calibrate-fxyz.txt",
        &said(&["calibrate", &fxyz, "--out", "a"]),
    );
    assert_golden(
        "calibrate-five-axis.txt",
        &said(&["calibrate", &five, "--out", "b", "--by-direction"]),
    );
    assert_golden(
        "verify-fxyz-lines.txt",
        &said(&["verify", "a/calibration.json", &lines, "--out", "a"]),
    );
    assert_golden(
        "diagnose-fxyz-lines.txt",
        &said(&["diagnose", &lines, "--out", "c"]),
    );
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
        let mut args = vec![
            "export",
            format,
            "calibrated/calibration.json",
            "--axis",
            "X",
            "--onto",
            onto,
        ];
        if format == "heidenhain" {
            args.extend(["--sign", "error"]);
        }
        args.extend(["--out", "new"]);
        let outcome = run(folder.path(), &args);
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
