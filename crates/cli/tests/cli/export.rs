//! `trueaxis export`: files, streams, exit codes. Numbers are tested in the library.

use std::fs;

use tempfile::TempDir;

use crate::program::{Outcome, calibrate_shipped, contents, file_names, run};

/// A folder with the calibration of the three-axis machine in `calibrated`.
fn calibrated() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "fxyz");
    folder
}

fn export(folder: &TempDir, format: &str, options: &[&str]) -> Outcome {
    let args = ["export", format, "calibrated/calibration.json"];
    run(folder.path(), &[&args, options].concat())
}

/// What the format cannot do without.
fn sign_of(format: &str) -> &'static [&'static str] {
    match format {
        "heidenhain" => &["--sign", "correction"],
        _ => &[],
    }
}

#[test]
fn every_format_writes_its_files() {
    let folder = calibrated();
    let at = ["--at", "175.6,497.5,312.1", "--out", "tables"];
    let written = folder.path().join("tables");
    for (format, files, is_experimental) in [
        ("grid", &["grid.csv"][..], false),
        (
            "linuxcnc",
            &["X.comp", "Y.comp", "Z.comp", "matrixkins.hal"],
            false,
        ),
        ("isg", &["volcomp.csv"], true),
        ("etalon", &["etalon.txt"], true),
        ("sinumerik", &["AX_EEC.INI", "NC_CEC.INI"], true),
        (
            "heidenhain",
            &[
                "README.txt",
                "X.com.csv",
                "Y.com.csv",
                "Z.com.csv",
                "config.cma.csv",
            ],
            true,
        ),
        ("marlin", &["skew.gcode"], false),
        ("klipper", &["skew.gcode"], false),
    ] {
        let at = [&at[..], sign_of(format)].concat();
        let outcome = export(&folder, format, &at);
        outcome.assert_good();
        assert_eq!(outcome.stdout, "");
        assert_eq!(file_names(&written), files, "{format}");
        let of_old = match format {
            "isg" | "etalon" | "marlin" | "klipper" => "if the control's own correction was off",
            _ => "add these tables to the old ones",
        };
        for says in [
            "volumetric error, rms",
            "tool point (175.6, 497.5, 312.1) mm at home",
            of_old,
        ] {
            assert!(
                outcome.stderr.contains(says),
                "{format}: {}",
                outcome.stderr
            );
        }
        if ["isg", "etalon"].contains(&format) {
            assert!(outcome.stderr.contains("tool X Y Z; workpiece none"));
        }
        assert_eq!(
            outcome.stderr.contains("experimental"),
            is_experimental,
            "{format}"
        );
        // The same bytes again.
        let before = contents(&written);
        export(&folder, format, &at).assert_good();
        assert_eq!(contents(&written), before, "{format}");
        fs::remove_dir_all(&written).unwrap();
    }
}

#[test]
fn what_cannot_be_made_is_refused_and_nothing_is_written() {
    let folder = calibrated();
    let names = file_names(folder.path());
    for (format, options, says) in [
        (
            "linuxcnc",
            ["--step", "1"],
            "axis X: 441 points, and linuxcnc holds 256 at most",
        ),
        (
            "sinumerik",
            ["--step", "33"],
            "does not divide the range of its steps, 440 mm",
        ),
        (
            "isg",
            ["--axis", "W"],
            "axis W was not measured; measured are X, Y, Z",
        ),
        ("isg", ["--step", "0"], "expected a number above zero"),
        (
            "heidenhain",
            ["--axis", "X"],
            "if in the positive one, --sign correction",
        ),
        ("grid", ["--sign", "error"], "grid takes no sign"),
        (
            "heidenhain",
            ["--levers", "--sign=error"],
            "heidenhain takes no levers; only sinumerik multiplies tables",
        ),
        (
            "sinumerik",
            ["--levers", "--axis=Z"],
            "acts along another one; these axes have none",
        ),
        ("fanuc", ["--axis", "X"], "possible values: grid, linuxcnc"),
    ] {
        let outcome = export(&folder, format, &options);
        outcome.assert_failed(format, 2, says);
        assert_eq!(file_names(folder.path()), names, "{format}");
    }
    let outcome = run(
        folder.path(),
        &["export", "grid", "nowhere/calibration.json"],
    );
    outcome.assert_failed("no file", 3, "give the path of a calibration.json");
}

/// Errors of rotary axes and of linear ones may cancel each other: tables for the linear ones alone are no gain then.
#[test]
fn tables_that_make_it_worse_say_so() {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "five-axis");
    for (format, is_worse) in [("grid", true), ("isg", false)] {
        let outcome = export(&folder, format, &["--at", "0,0,100", "--out", "tables"]);
        outcome.assert_good();
        let says = "with these tables the volumetric error, rms or largest, is larger";
        assert_eq!(
            outcome.stderr.contains(says),
            is_worse,
            "{}",
            outcome.stderr
        );
    }
}

/// The tables of the levers, and the trial that goes before them.
#[test]
fn levers_are_experimental_in_every_file() {
    let folder = calibrated();
    let outcome = export(&folder, "sinumerik", &["--levers", "--out", "tables"]);
    outcome.assert_good();
    for says in [
        "load LEVER_TRIAL.INI first",
        "16 sag compensation tables",
        "is experimental",
    ] {
        assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    }
    let written = folder.path().join("tables");
    let files = ["AX_EEC.INI", "LEVER_TRIAL.INI", "NC_CEC.INI"];
    assert_eq!(file_names(&written), files);
    for file in files {
        let text = fs::read_to_string(written.join(file)).unwrap();
        let second = text.lines().nth(1).unwrap();
        assert!(second.starts_with("; EXPERIMENTAL"), "{file}: {second}");
    }
    let onto = ["--levers", "--onto", "tables", "--out", "sum"];
    let outcome = export(&folder, "sinumerik", &onto);
    outcome.assert_good();
    let says =
        "contain what the targets saw of the old AX_EEC.INI, NC_CEC.INI; not read: LEVER_TRIAL.INI";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("16 sag compensation tables"));
}

#[test]
fn old_tables_are_kept() {
    let folder = calibrated();
    let current = folder.path();
    fs::create_dir(current.join("old")).unwrap();
    fs::write(current.join("old/X.comp"), "0 0 0\n440 440.01 440.01\n").unwrap();
    let onto = ["--onto", "old", "--axis", "X", "--out", "new"];
    let outcome = export(&folder, "linuxcnc", &onto);
    outcome.assert_good();
    assert!(
        !outcome.stderr.contains("must keep doing so"),
        "{}",
        outcome.stderr
    );
    export(&folder, "linuxcnc", &["--axis", "X", "--out", "alone"]).assert_good();
    let last = |name: &str| {
        let text = fs::read_to_string(current.join(name)).unwrap();
        let line = text.lines().last().unwrap().to_owned();
        line.split(' ')
            .map(|cell| cell.parse().unwrap())
            .collect::<Vec<f64>>()
    };
    let (new, alone) = (last("new/X.comp"), last("alone/X.comp"));
    assert!((new[1] - alone[1] - 0.01).abs() < 1e-6, "{new:?} {alone:?}");
    fs::write(current.join("old/X.comp"), "# 0 0 0\n").unwrap();
    let outcome = export(&folder, "linuxcnc", &onto);
    outcome.assert_failed(
        "a comment",
        3,
        "X.comp line 1 … the control reads no further",
    );
    let outcome = export(&folder, "linuxcnc", &["--onto", "nowhere"]);
    outcome.assert_failed(
        "no folder",
        3,
        "nowhere cannot be read; --onto wants the folder of the old tables",
    );
    let outcome = export(&folder, "grid", &["--onto", "old"]);
    outcome.assert_failed("another format", 3, "old has none of grid.csv");
    for format in ["isg", "etalon", "klipper"] {
        let outcome = export(&folder, format, &["--onto", "old"]);
        outcome.assert_failed("no old ones", 2, &format!("{format} takes no old tables"));
    }
    // A folder of the format's own files, and one file.
    for format in ["sinumerik", "heidenhain", "grid"] {
        let out = ["--out", "tables"];
        export(&folder, format, &[&out, sign_of(format)].concat()).assert_good();
        let onto = ["--onto", "tables", "--out", "sum"];
        export(&folder, format, &[&onto, sign_of(format)].concat()).assert_good();
    }
    let onto = ["--onto", "tables/grid.csv", "--out", "sum"];
    export(&folder, "grid", &onto).assert_good();
    // Made again, it would be added to its own sum.
    let itself = ["--onto", "tables/grid.csv", "--out", "./tables"];
    let before = contents(current);
    let outcome = export(&folder, "grid", &itself);
    outcome.assert_failed("onto itself", 3, "give another --out");
    assert_eq!(contents(current), before);
}
