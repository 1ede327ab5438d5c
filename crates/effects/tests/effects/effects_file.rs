//! `trueaxis-effects`.

use serde_json::{Value, json};
use trueaxis_effects::EffectsFile;

use crate::scene::scene;

/// Two effects; the parameters of the second stand in another order than in the catalogue.
fn file() -> Value {
    json!({
        "format": "trueaxis-effects", "version": 1, "campaign": "five axes",
        "effects": [
            { "effect": "dead_path_jump", "subject": { "station": "S2" }, "parameters": [
                { "name": "jump", "value": 0.1, "u": 1.0, "unit": "um" },
                { "name": "time", "value": 1.0 / 3.0, "unit": "s" } ] },
            { "effect": "machine_shift", "parameters": [
                { "name": "shift_z", "value": 4.0, "u": 2.0, "unit": "um" },
                { "name": "time", "value": 900.0, "unit": "s" },
                { "name": "shift_x", "value": 5.0, "u": 3.0, "unit": "um" },
                { "name": "shift_y", "value": 6.0, "u": 4.0, "unit": "um" } ] }
        ],
        "covariance": [ [1.0, 0.12, 0.13, 0.14], [0.12, 4.0, 0.23, 0.24],
                        [0.13, 0.23, 9.0, 0.34], [0.14, 0.24, 0.34, 16.0] ]
    })
}

fn read(json: &Value) -> Result<EffectsFile, trueaxis_effects::Error> {
    EffectsFile::from_json(&serde_json::to_string_pretty(json).unwrap())
}

#[test]
fn what_is_written_is_read() {
    let effects = read(&file()).unwrap();
    assert_eq!(effects.campaign, "five axes");
    let text = effects.to_json().unwrap();
    assert!(text.starts_with("{\n  \"format\": \"trueaxis-effects\",\n  \"version\": 1,"));
    assert_eq!(EffectsFile::from_json(&text).unwrap(), effects);

    let mut without = file();
    without.as_object_mut().unwrap().remove("covariance");
    let without = read(&without).unwrap();
    assert_eq!(without.covariance, None);
    assert!(!without.to_json().unwrap().contains("covariance"));
}

/// The covariance follows its parameters into the order of the catalogue.
#[test]
fn the_covariance_stays_with_its_parameters() {
    let resolved = read(&file()).unwrap().resolve(&scene()).unwrap();
    assert_eq!(resolved.effects[0].parameters, [0.1]);
    assert_eq!(resolved.effects[1].parameters, [5.0, 6.0, 4.0]);
    let expected = vec![
        vec![1.0, 0.13, 0.14, 0.12],
        vec![0.13, 9.0, 0.34, 0.23],
        vec![0.14, 0.34, 16.0, 0.24],
        vec![0.12, 0.23, 0.24, 4.0],
    ];
    assert_eq!(resolved.covariance, Some(expected));
}

#[test]
fn wrong_files_are_refused_with_the_reason() {
    let cases = [
        (
            "/format",
            json!("trueaxis-diagnosis"),
            "format: this is a trueaxis diagnosis, not an effects file",
        ),
        ("/version", json!(2), "version: found 2; expected 1"),
        (
            "/effects/1/effect",
            json!("machine_drfit"),
            "effects[1].effect: unknown effect `machine_drfit`",
        ),
        (
            "/covariance/3",
            json!([0.14, 0.24, 0.34]),
            "covariance[3]: expected 4, one for each linear parameter, found 3",
        ),
        (
            "/covariance",
            json!([[1.0]]),
            "covariance: expected 4, one for each linear parameter, found 1",
        ),
        (
            "/covariance/2/2",
            json!(-9.0),
            "covariance[2][2]: expected a variance, zero or more, found -9",
        ),
        (
            "/covariance/2/1",
            json!(0.24),
            "covariance[2][1]: a covariance must be symmetric, but 0.24 is mirrored by 0.23 in row 1",
        ),
    ];
    for (pointer, value, expected) in cases {
        let mut json = file();
        *json.pointer_mut(pointer).unwrap() = value;
        let message = read(&json).unwrap_err().to_string();
        // What is wrong with the document as such has a line, too.
        let (_, reason) = message.split_once("field ").unwrap();
        assert!(reason.starts_with(expected), "{message}");
    }
}

#[test]
fn the_parser_names_line_and_field() {
    let message = EffectsFile::from_json("{\n  \"effects\": [,]\n}").unwrap_err();
    assert!(
        message
            .to_string()
            .starts_with("line 2, character 15: not valid JSON: expected value"),
        "{message}"
    );
    let text = "{ \"format\": \"trueaxis-effects\", \"version\": 1, \"campaign\": \"x\",\n\
                \"effects\": [ { \"effect\": \"warm_up\", \"parametres\": [] } ] }";
    let message = EffectsFile::from_json(text).unwrap_err().to_string();
    let expected = "line 2, field effects[0].parametres: unknown field `parametres`";
    assert!(message.starts_with(expected), "{message}");
    assert!(message.contains("did you mean `parameters`?"), "{message}");
}

/// What is found only with the machine at hand, too, is named from the top of the file.
#[test]
fn resolving_names_the_effect() {
    let mut json = file();
    json["effects"][0]["subject"]["station"] = json!("S3");
    let message = read(&json)
        .unwrap()
        .resolve(&scene())
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("field effects[0].subject.station: unknown station `S3`"));
    let nothing = EffectsFile {
        covariance: Some(vec![]),
        ..EffectsFile::default()
    };
    assert!(nothing.resolve(&scene()).unwrap().effects.is_empty());
}

#[test]
fn numbers_that_json_cannot_hold_are_not_written() {
    let mut effects = read(&file()).unwrap();
    effects.effects[0].parameters[0].value = f64::NAN;
    let message = effects.to_json().unwrap_err().to_string();
    assert_eq!(
        message,
        "field effects[0].parameters[0].value: expected a finite number, found NaN"
    );
}
