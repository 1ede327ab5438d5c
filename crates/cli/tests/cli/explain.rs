//! Codes of errors, their explanations, and errors drawn on the line where they are.

use std::fs;

use serde_json::Value;

use crate::program::{run, shipped};

#[test]
fn codes_are_listed_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let list = run(folder.path(), &["explain"]);
    list.assert_good();
    let codes: Vec<&str> = list
        .stdout
        .lines()
        .filter_map(|line| line.split("  ").next())
        .collect();
    assert!(codes.len() > 90, "{}", codes.len());
    for code in codes {
        let outcome = run(folder.path(), &["explain", code]);
        outcome.assert_good();
        assert!(
            outcome.stdout.starts_with(&format!("{code}: ")),
            "{}",
            outcome.stdout
        );
        assert!(
            outcome.stdout.contains("\nWhat to do: "),
            "{}",
            outcome.stdout
        );
    }
    run(folder.path(), &["explain", "e101"]).assert_good();
    run(folder.path(), &["explain", "E999"]).assert_failed("unknown", 2, "no code E999");
}

/// With `--json` an error is one document on standard output beside the words on standard error.
#[test]
fn errors_are_told_to_programs() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = fs::read_to_string(shipped("rotary-stage").join("campaign.json")).unwrap();
    let damaged = campaign.replacen("carried_by", "caried_by", 1);
    fs::write(folder.path().join("campaign.json"), &damaged).unwrap();
    let line = 1 + damaged.lines().position(|l| l.contains("caried")).unwrap();
    let told = |args: &[&str]| -> (Option<i32>, Value) {
        let outcome = run(folder.path(), args);
        assert!(outcome.stderr.contains("error["), "{}", outcome.stderr);
        (outcome.code, serde_json::from_str(&outcome.stdout).unwrap())
    };
    for verb in ["check", "calibrate", "diagnose", "montecarlo"] {
        let (code, error) = told(&[verb, "campaign.json", "--json"]);
        assert_eq!(code, Some(3));
        assert_eq!(error["format"], "trueaxis-error");
        assert_eq!(error["code"], "E101");
        assert_eq!(error["exit_code"], 3);
        assert_eq!(error["file"], "campaign.json");
        assert_eq!(
            (&error["line"], &error["column"]),
            (&line.into(), &5.into())
        );
        let message = error["message"].as_str().unwrap();
        assert!(message.contains("field targets[0].caried_by"), "{message}");
        let help = error["help"].as_str().unwrap();
        assert!(help.contains("What to do: "), "{help}");
    }
    // An error that is in no line.
    let (code, error) = told(&["check", "no.json", "--json"]);
    assert_eq!((code, &error["code"]), (Some(3), &"E001".into()));
    assert!(error["line"].is_null() && error["column"].is_null());
    let words = run(folder.path(), &["check", "campaign.json"]);
    assert_eq!(words.stdout, "", "data only where they are asked for");
}

#[test]
fn errors_are_drawn_on_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let campaign = fs::read_to_string(shipped("rotary-stage").join("campaign.json")).unwrap();
    let lengths = fs::read_to_string(shipped("rotary-stage").join("lengths.csv")).unwrap();
    let check = || run(folder.path(), &["check", "campaign.json"]);

    write(
        "campaign.json",
        &campaign.replacen("carried_by", "caried_by", 1),
    );
    check().assert_failed(
        "field",
        3,
        "error[E101]: campaign.json line 29, field targets[0].caried_by: unknown field … \
         \n  --> campaign.json:29:5\n   |\n29 |     \"caried_by\": \"C\"\n   |     ^^^^^^^^^^^^^^^^\n … \
         \nmore: trueaxis explain E101\n",
    );
    write(
        "campaign.json",
        &campaign.replacen("\"rotary stage\",", "\"rotary stage\"", 1),
    );
    check().assert_failed(
        "syntax",
        3,
        "error[E008] … --> campaign.json:8:5\n … 8 |     \"kinematics\": {\n  |     ^\n",
    );

    write("campaign.json", &campaign);
    write(
        "lengths.csv",
        &lengths.replacen("4,S1,1,c,1,0,P,149.7952535", "4,S1,1,c,1,0,P,\"NaN\"", 1),
    );
    check().assert_failed(
        "cell",
        3,
        "error[E220] … \
         --> lengths.csv:2:16\n  |\n2 | 4,S1,1,c,1,0,P,\"NaN\"\n  |                ^^^^^\n",
    );
    write("lengths.csv", &lengths.replacen("repeat", "repaet", 1));
    check().assert_failed(
        "column",
        3,
        "error[E204] … 1 | time_s,station,repaet,run …   |                ^^^^^^\n",
    );
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/examples");
    let map = fs::read_to_string(format!("{docs}/turntable.toml")).unwrap();
    let export = format!("{docs}/turntable.txt");
    let import = |map: &str| {
        write("map.toml", map);
        run(
            folder.path(),
            &["import", "points", &export, "--map", "map.toml"],
        )
    };
    import(&map.replacen("\"in\"", "\"inn\"", 1)).assert_failed(
        "unit",
        3,
        "error[E104] … \
         x_mm = { column = \"X\", unit = \"inn\" }\n  |                                ^^^\n",
    );
    import(&map.replacen("decimal", "# decimal", 1)).assert_failed(
        "decimal",
        3,
        "error[E236] … 7 | P_000;26,068146;-14,632530 …   |       ^^^^^^^^^\n",
    );
    run(folder.path(), &["check", "none.json"]).assert_failed(
        "none",
        3,
        "error[E001]: none.json: there is no such file",
    );
}
