//! `trueaxis montecarlo`, and the matrices that `calibrate` writes on request.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{run, shipped};

fn rotary_stage() -> String {
    let path = shipped("rotary-stage").join("campaign.json");
    path.to_str().unwrap().to_owned()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Header and elements of a `NumPy` file of format 1.0.
fn npy(path: &Path) -> (String, Vec<f64>) {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8(bytes[10..10 + length].to_vec()).unwrap();
    let data = bytes[10 + length..].chunks_exact(8);
    let number = |chunk: &[u8]| f64::from_le_bytes(chunk.try_into().unwrap());
    (header, data.map(number).collect())
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let file = rotary_stage();
    let mut texts = Vec::new();
    for threads in ["1", "2", "3"] {
        let out = folder.path().join(threads);
        let outcome = run(
            folder.path(),
            &[
                "montecarlo",
                &file,
                "--trials",
                "300",
                "--seed",
                "7",
                "--threads",
                threads,
                "--out",
                threads,
            ],
        );
        outcome.assert_good();
        assert!(
            outcome
                .stderr
                .contains("300 trials of this noise, 132 results"),
            "{}",
            outcome.stderr
        );
        let judged = "no more than chance makes the largest of 132 results by 300 trials";
        assert!(outcome.stderr.contains(judged), "{}", outcome.stderr);
        // No progress where nobody watches.
        assert!(!outcome.stderr.contains('\r') && !outcome.stderr.contains('\u{1b}'));
        texts.push(fs::read(out.join("montecarlo.json")).unwrap());
    }
    assert!(texts.windows(2).all(|pair| pair[0] == pair[1]));
    let found: Value = serde_json::from_slice(&texts[0]).unwrap();
    assert_eq!(found["format"], "trueaxis-montecarlo");
    assert_eq!(found["results"].as_array().unwrap().len(), 132);
}

#[test]
fn too_few_trials_are_a_wrong_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = rotary_stage();
    for (options, says) in [
        (["--trials", "99"], "expected a whole number from 100"),
        (["--trials", "-5"], "expected a whole number from 100"),
        (["--digits", "9"], "--digits"),
        (["--trials", "1000000000"], "bytes"),
    ] {
        let mut arguments = vec!["montecarlo", file.as_str()];
        arguments.extend(options);
        let outcome = run(folder.path(), &arguments);
        assert_eq!(outcome.code, Some(2), "{options:?}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains(says),
            "{options:?}: {}",
            outcome.stderr
        );
        assert!(!folder.path().join("rotary-stage").exists());
    }
}

#[test]
fn matrices_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let file = rotary_stage();
    let outcome = run(
        folder.path(),
        &[
            "calibrate",
            &file,
            "--out",
            "out",
            "--covariance",
            "--reliability",
        ],
    );
    outcome.assert_good();
    assert!(
        outcome.stderr.contains("an error of a length is noticed"),
        "{}",
        outcome.stderr
    );
    let out = folder.path().join("out");

    let index = json(&out.join("covariance.json"));
    let outputs = index["outputs"].as_array().unwrap();
    let (header, matrix) = npy(&out.join("covariance.npy"));
    assert!(
        header.contains(&format!("({0}, {0})", outputs.len())),
        "{header}"
    );
    let calibration = json(&out.join("calibration.json"));
    let u = calibration["axes"][0]["components"]["EAC"]["u_arcsec"]
        .as_array()
        .unwrap();
    let places = outputs
        .iter()
        .enumerate()
        .filter(|(_, output)| output["name"] == "EAC");
    for ((place, _), u) in places.zip(u) {
        let variance = matrix[place * (outputs.len() + 1)];
        assert!((variance.sqrt() - u.as_f64().unwrap()).abs() < 1e-6);
    }

    let index = json(&out.join("reliability.json"));
    let (header, effects) = npy(&out.join("reliability.npy"));
    let (rows, columns) = (684, index["results"].as_array().unwrap().len());
    assert!(header.contains(&format!("({rows}, {columns})")), "{header}");
    assert_eq!(index["row"].as_array().unwrap().len(), rows);
    // The largest effect that the index names is that of the matrix.
    let column = index["worst_result"][0].as_u64().unwrap();
    let effect = effects[usize::try_from(column).unwrap()];
    assert!(effect.abs() > 0.0);
}
