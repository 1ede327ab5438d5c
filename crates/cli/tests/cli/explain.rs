//! Codes of errors, their explanations, and errors drawn on the line where they are.

use std::fs;

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
        assert!(outcome.stdout.contains("\nMend it: "), "{}", outcome.stdout);
    }
    run(folder.path(), &["explain", "e101"]).assert_good();
    run(folder.path(), &["explain", "E999"]).assert_failed("unknown", 2, &["no code E999"]);
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
        &[
            "error[E101]: campaign.json line 28, field targets[0].caried_by: unknown field",
            "\n  --> campaign.json:28:5\n   |\n28 |     \"caried_by\": \"C\"\n   |     ^^^^^^^^^^^^^^^^\n",
            "\nmore: trueaxis explain E101\n",
        ],
    );
    write(
        "campaign.json",
        &campaign.replacen("\"rotary stage\",", "\"rotary stage\"", 1),
    );
    check().assert_failed(
        "syntax",
        3,
        &[
            "error[E008]",
            "--> campaign.json:7:5\n",
            "7 |     \"kinematics\": {\n  |     ^\n",
        ],
    );

    write("campaign.json", &campaign);
    write(
        "lengths.csv",
        &lengths.replacen("4,S1,1,c,1,0,P,149.7952535", "4,S1,1,c,1,0,P,\"NaN\"", 1),
    );
    check().assert_failed(
        "cell",
        3,
        &[
            "error[E220]",
            " --> lengths.csv:2:16\n  |\n2 | 4,S1,1,c,1,0,P,\"NaN\"\n  |                ^^^^^\n",
        ],
    );
    write("lengths.csv", &lengths.replacen("repeat", "repaet", 1));
    check().assert_failed(
        "column",
        3,
        &[
            "error[E204]",
            "1 | time_s,station,repaet,run",
            "  |                ^^^^^^\n",
        ],
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
        &[
            "error[E104]",
            "x_mm = { column = \"X\", unit = \"inn\" }\n  |                                ^^^\n",
        ],
    );
    import(&map.replacen("decimal", "# decimal", 1)).assert_failed(
        "decimal",
        3,
        &[
            "error[E236]",
            "7 | P_000;26,068146;-14,632530",
            "  |       ^^^^^^^^^\n",
        ],
    );
    run(folder.path(), &["check", "none.json"]).assert_failed(
        "none",
        3,
        &["error[E001]: none.json: there is no such file"],
    );
}
