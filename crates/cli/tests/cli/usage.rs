//! The command line itself.

use serde_json::Value;

use crate::program::{file_names, run, shipped};

const USAGE: i32 = 2;

#[test]
fn help_names_every_verb_and_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["--help"]);
    outcome.assert_good();
    assert_eq!(outcome.stderr, "");
    for part in ["check", "calibrate", "simulate", "Exit codes: 0 good"] {
        assert!(outcome.stdout.contains(part), "{part}: {}", outcome.stdout);
    }
    for code in ["2 ", "3 ", "4 ", "5 ", "6 ", "70 "] {
        assert!(outcome.stdout.contains(&format!("; {code}")), "{code}");
    }
    for verb in ["check", "calibrate", "simulate"] {
        let outcome = run(folder.path(), &[verb, "--help"]);
        outcome.assert_good();
        let usage = format!("{verb} [OPTIONS]");
        let usage_without_options = format!("{verb} <");
        assert!(
            outcome.stdout.contains(&usage) || outcome.stdout.contains(&usage_without_options),
            "{}",
            outcome.stdout
        );
    }
}

#[test]
fn version() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["--version"]);
    outcome.assert_good();
    let expected = format!("trueaxis {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(outcome.stdout, expected);
}

#[test]
fn quiet_says_nothing_but_errors() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.to_str().unwrap();
    for args in [
        ["calibrate", campaign, "--quiet", "--no-report"].as_slice(),
        &["-q", "diagnose", campaign],
        &["montecarlo", campaign, "--trials", "100", "-q"],
    ] {
        let outcome = run(folder.path(), args);
        outcome.assert_good();
        assert_eq!([outcome.stdout, outcome.stderr], ["", ""], "{args:?}");
    }
    run(folder.path(), &["check", "none.json", "-q"]).assert_failed("no file", 3, "none.json");
}

#[test]
fn completions_name_verbs_and_options() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let outcome = run(folder.path(), &["completions", shell]);
        outcome.assert_good();
        for word in ["calibrate", "no-report"] {
            assert!(outcome.stdout.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn wrong_command_lines() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.to_str().unwrap();
    for (args, says) in [
        (vec![], "Usage: trueaxis"),
        (vec!["--colour"], "unexpected argument '--colour'"),
        (vec!["calibrat"], "'calibrate'"),
        (vec!["calibrate"], "<CAMPAIGN.json>"),
        (vec!["check", campaign, campaign], "unexpected argument"),
        (
            vec!["check", campaign, "--covariance"],
            "unexpected argument",
        ),
        (
            vec!["calibrate", campaign, "--method", "seven"],
            "possible values: joint, nine, six",
        ),
        (
            vec!["calibrate", campaign, "--reference-point", "middle"],
            "expected `origin`, `centroid` or three numbers in mm",
        ),
        (
            vec!["calibrate", campaign, "--reference-point", "1,2"],
            "expected `origin`, `centroid` or three numbers in mm",
        ),
        (
            vec!["calibrate", campaign, "--reference-point", "1,2,NaN"],
            "expected `origin`, `centroid` or three numbers in mm",
        ),
        (
            vec!["simulate", "scenario.json", "--seed", "one"],
            "invalid value 'one'",
        ),
        // Of numbers below zero, too, the range is said.
        (
            vec!["simulate", "scenario.json", "--seed", "-1"],
            "expected a whole number from 0",
        ),
        (
            vec!["volume", "calibration.json", "--draws", "-1"],
            "expected 0, or 100 to 65535",
        ),
        (
            vec!["volume", "calibration.json", "--draws", "99"],
            "expected 0, or 100 to 65535",
        ),
        (
            vec!["volume", "calibration.json", "--points", "-3"],
            "expected a whole number from 2 to 128",
        ),
        (
            vec!["montecarlo", "campaign.json", "--threads", "0"],
            "expected a whole number from 1",
        ),
        (
            vec!["montecarlo", "campaign.json", "--trials", "1e6"],
            "expected a whole number from 100, such as 200000",
        ),
        (
            vec!["export", "grid", "calibration.json", "--step", "-5"],
            "expected a number above zero",
        ),
    ] {
        let outcome = run(folder.path(), &args);
        outcome.assert_usage(&args.join(" "), says);
        assert!(file_names(folder.path()).is_empty());
    }
}

/// With `--json` programs are told, too.
#[test]
fn wrong_command_lines_with_json() {
    let folder = tempfile::tempdir().unwrap();
    for (args, message) in [
        (
            vec!["check", "campaign.json", "--colour", "--json"],
            "unexpected argument '--colour' found",
        ),
        (
            vec!["calibrate", "--json"],
            "the following required arguments were not provided:\n  <CAMPAIGN.json>",
        ),
    ] {
        let outcome = run(folder.path(), &args);
        assert_eq!(outcome.code, Some(USAGE), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(message), "{}", outcome.stderr);
        let error: Value = serde_json::from_str(&outcome.stdout).unwrap();
        assert_eq!(error["format"], "trueaxis-error");
        assert_eq!(
            (&error["exit_code"], &error["code"]),
            (&2.into(), &Value::Null)
        );
        assert_eq!(error["message"], message);
    }
    let help = run(folder.path(), &["check", "--help", "--json"]);
    help.assert_good();
    assert!(help.stdout.contains("Usage"), "{}", help.stdout);
}

impl crate::program::Outcome {
    fn assert_usage(&self, name: &str, says: &str) {
        assert_eq!(self.code, Some(USAGE), "{name}: {}", self.stderr);
        assert_eq!(self.stdout, "", "{name}");
        assert!(self.stderr.contains(says), "{name}: {}", self.stderr);
    }
}
