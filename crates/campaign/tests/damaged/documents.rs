//! Damage to `campaign.json`, and to files as a whole.

use crate::fixture::{Case, Files, assert_refused, rotary_table, table_points, three_axes};

#[test]
fn whole_files() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "no campaign.json",
                damage: |f| drop(f.0.remove("campaign.json")),
                says: &["campaign.json: there is no such file", "give the path"],
            },
            Case {
                name: "no lengths.csv",
                damage: |f| drop(f.0.remove("lengths.csv")),
                says: &[
                    "lengths.csv: there is no such file",
                    "campaign.json, field lengths, names it",
                ],
            },
            Case {
                name: "no readings",
                damage: |f| drop(f.0.remove("li_x.csv")),
                says: &[
                    "li_x.csv: there is no such file",
                    "field verification[0].readings",
                ],
            },
            Case {
                name: "lengths is a folder",
                damage: |f| f.json("\"lengths.csv\"", "\".\""),
                says: &["this is a folder, expected a file", "field lengths"],
            },
            Case {
                name: "empty campaign.json",
                damage: |f| empty(f, "campaign.json"),
                says: &["campaign.json: the file is empty"],
            },
            Case {
                name: "empty lengths.csv",
                damage: |f| empty(f, "lengths.csv"),
                says: &["lengths.csv: the file is empty", "saved completely?"],
            },
            Case {
                name: "header only",
                damage: |f| f.lines("lengths.csv", |lines| lines.truncate(1)),
                says: &["lengths.csv: there are no rows"],
            },
        ],
    );
}

fn empty(files: &mut Files, name: &str) {
    files.0.insert(name.to_owned(), " \n".to_owned());
}

#[test]
fn a_folder_in_place_of_the_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let message = trueaxis_campaign::read(folder.path())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("this is a folder, expected a file; give the path of a campaign.json")
    );
}

#[test]
fn text_that_is_not_utf_8() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in &three_axes().0 {
        let mut bytes = text.clone().into_bytes();
        if name == "lengths.csv" {
            let third_line = text.match_indices('\n').nth(1).unwrap().0 + 1;
            bytes[third_line] = 0xB5; // µ in Latin-1
        }
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let message = trueaxis_campaign::read(&folder.path().join("campaign.json"))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("lengths.csv line 3: this line is not UTF-8"),
        "{message}"
    );
}

#[test]
fn format_and_version() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "a calibration, whose fields are all unknown",
                damage: |f| {
                    let calibration = r#"{ "format": "trueaxis-calibration", "version": 1, "method": "nine-equation" }"#;
                    f.0.insert("campaign.json".to_owned(), calibration.to_owned());
                },
                says: &[
                    "campaign.json line 1, field format",
                    "trueaxis calibration, not a campaign",
                ],
            },
            Case {
                name: "another program's document",
                damage: |f| f.json("trueaxis-campaign", "survey"),
                says: &[
                    "field format: found \"survey\"",
                    "expected \"trueaxis-campaign\"",
                ],
            },
            Case {
                name: "a scenario",
                damage: |f| f.json("trueaxis-campaign", "trueaxis-scenario"),
                says: &["trueaxis scenario, not a campaign"],
            },
            Case {
                name: "another JSON",
                damage: |f| f.json("\"format\": \"trueaxis-campaign\",", ""),
                says: &[
                    "field format: found nothing",
                    "expected \"trueaxis-campaign\"",
                ],
            },
            Case {
                name: "a later version with a new field",
                damage: |f| f.json("\"version\": 1,", "\"version\": 2, \"novelty\": true,"),
                says: &["field version: found 2; expected 1", "newer release"],
            },
            Case {
                name: "a trailing comma",
                damage: |f| f.json("\"name\": \"test\",", "\"name\": \"test\",,"),
                says: &["campaign.json line 4, character", "not valid JSON"],
            },
            Case {
                name: "cut off",
                damage: |f| f.lines("campaign.json", |lines| lines.truncate(12)),
                says: &["campaign.json line 13", "not valid JSON: EOF"],
            },
            Case {
                name: "a missing comma",
                damage: |f| f.json("\"name\": \"test\",", "\"name\": \"test\""),
                says: &["campaign.json line 5", "not valid JSON", "RFC 8259"],
            },
            Case {
                name: "a list",
                damage: |f| drop(f.0.insert("campaign.json".to_owned(), "3".to_owned())),
                says: &["campaign.json line 1: invalid type", "expected an object"],
            },
        ],
    );
}

#[test]
fn fields() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "unknown field near a known one",
                damage: |f| f.json("length_sigma_um", "lenght_sigma_um"),
                says: &[
                    "campaign.json line 14, field instrument.lenght_sigma_um",
                    "did you mean `length_sigma_um`?",
                    "known: name, serial, length_sigma_um, length_sigma_ppm, repeatability_um",
                ],
            },
            Case {
                name: "missing field",
                damage: |f| f.json("\"name\": \"x\", ", ""),
                says: &["field runs[0]: field `name` is missing"],
            },
            Case {
                name: "text for a number",
                damage: |f| f.json("[16.338, ", "[\"16.338\", "),
                says: &["field targets[0].position_mm[0]", "expected a number"],
            },
            Case {
                name: "two coordinates",
                damage: |f| f.json("[16.338, ", "["),
                says: &["field targets[0].position_mm", "expected three numbers"],
            },
            Case {
                name: "unknown kind of axis",
                damage: |f| {
                    f.json(
                        "\"name\": \"Y\", \"kind\": \"linear\"",
                        "\"name\": \"Y\", \"kind\": \"linaer\"",
                    );
                },
                says: &[
                    "field machine.axes[1].kind",
                    "did you mean `linear`? known: linear, rotary",
                ],
            },
            Case {
                name: "unknown kind of verification",
                damage: |f| f.json("\"positioning\"", "\"interferometer\""),
                says: &["field verification[0].kind", "known: positioning, ballbar"],
            },
            Case {
                name: "field of the other kind of verification",
                damage: |f| f.json("\"target_mm\"", "\"ball_mm\""),
                says: &[
                    "field verification[0].ball_mm",
                    "belongs to the kind `ballbar`",
                ],
            },
            Case {
                name: "verification without its axis",
                damage: |f| {
                    f.json(
                        "\"kind\": \"positioning\", \"axis\": \"X\",",
                        "\"kind\": \"positioning\",",
                    );
                },
                says: &["field verification[0]: field `axis` is missing"],
            },
            Case {
                name: "both lengths and points",
                damage: |f| f.json("\"lengths\":", "\"points\": \"points.csv\", \"lengths\":"),
                says: &[
                    "field points",
                    "choose one",
                    "keep `lengths` for multilateration",
                ],
            },
            Case {
                name: "no data at all",
                damage: |f| {
                    f.lines("campaign.json", |lines| {
                        let data = lines
                            .iter()
                            .position(|l| l.contains("\"lengths\""))
                            .unwrap();
                        lines.truncate(data - 1);
                        lines.extend(["  \"runs\": []".to_owned(), "}".to_owned()]);
                    });
                },
                says: &[
                    "campaign.json: the campaign has no data",
                    "`lengths` or `points`",
                ],
            },
            Case {
                name: "lengths without stations",
                damage: |f| {
                    f.lines("campaign.json", |lines| {
                        let start = lines
                            .iter()
                            .position(|l| l.contains("\"stations\""))
                            .unwrap();
                        lines.drain(start..start + 6);
                    });
                },
                says: &["field stations: the list is empty, but `lengths` refers to it"],
            },
        ],
    );
}

#[test]
fn names() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "two axes of one name",
                damage: |f| f.json("{ \"name\": \"Y\",", "{ \"name\": \"X\","),
                says: &[
                    "field machine.axes[1].name",
                    "axis `X`",
                    "machine.axes[0].name",
                ],
            },
            Case {
                name: "two targets of one name",
                damage: |f| f.json("\"name\": \"K\"", "\"name\": \"P\""),
                says: &["field targets[2].name", "target `P`", "targets[0].name"],
            },
            Case {
                name: "two stations of one name",
                damage: |f| f.json("\"name\": \"S3\"", "\"name\": \"S2\""),
                says: &["field stations[2].name", "station `S2`", "stations[1].name"],
            },
            Case {
                name: "two runs of one name",
                damage: |f| f.json("\"name\": \"z\"", "\"name\": \"y\""),
                says: &["field runs[2].name", "run `y`", "runs[1].name"],
            },
            Case {
                name: "an axis named like a column",
                damage: |f| f.json("{ \"name\": \"Y\",", "{ \"name\": \"target\","),
                says: &["field machine.axes[1].name", "name of another column"],
            },
            Case {
                name: "a name that ends in a blank",
                damage: |f| f.json("\"name\": \"K\"", "\"name\": \"K \""),
                says: &["field targets[2].name", "without blanks"],
            },
            Case {
                name: "run of an unknown axis",
                damage: |f| f.json("\"axis\": \"Y\"", "\"axis\": \"V\""),
                says: &["field runs[1].axis: unknown axis `V`", "known: X, Y, Z"],
            },
            Case {
                name: "target on an unknown axis",
                damage: |f| {
                    f.json(
                        "452.716, 122.416], \"carried_by\": \"Z\"",
                        "452.716, 122.416], \"carried_by\": \"z\"",
                    );
                },
                says: &[
                    "field targets[0].carried_by: unknown axis `z`",
                    "did you mean `Z`?",
                ],
            },
            Case {
                name: "station missing from the list",
                damage: |f| {
                    f.lines("campaign.json", |lines| {
                        let last = lines.iter().position(|l| l.contains("\"S4\"")).unwrap();
                        lines.remove(last);
                        let before = lines[last - 1].trim_end_matches(',').to_owned();
                        lines[last - 1] = before;
                    });
                },
                says: &["lengths.csv line 272, column station", "`S4`"],
            },
            Case {
                name: "unknown axis in a branch",
                damage: |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"X\", \"Y\", \"ZZ\"]"),
                says: &["field machine.kinematics.tool[2]", "did you mean `Z`?"],
            },
        ],
    );
}

#[test]
fn values() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "direction not a unit vector",
                damage: |f| f.json("\"direction\": [0, 1, 0]", "\"direction\": [0, 2, 0]"),
                says: &[
                    "field machine.axes[1].direction: axis Y",
                    "length 2, expected a unit vector",
                ],
            },
            Case {
                name: "direction of no length",
                damage: |f| f.json("\"direction\": [0, 1, 0]", "\"direction\": [0, 0, 0]"),
                says: &["field machine.axes[1].direction", "expected a unit vector"],
            },
            Case {
                name: "negative length_sigma_um",
                damage: |f| f.json("0.269", "-0.3"),
                says: &["field instrument.length_sigma_um", "more than zero"],
            },
            Case {
                name: "travel turned round",
                damage: |f| f.json("[0, 440]", "[440, 0]"),
                says: &["field machine.axes[0].travel", "low end first, in mm"],
            },
            Case {
                name: "position of a linear axis",
                damage: |f| f.json("[0, 440]", "[0, 440], \"position_mm\": [0, 0, 0]"),
                says: &["field machine.axes[0].position_mm", "remove it"],
            },
            Case {
                name: "axis in no branch",
                damage: |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"X\", \"Y\"]"),
                says: &["field machine.kinematics: axis Z appears in no kinematic branch"],
            },
            Case {
                name: "zero length_sigma_um",
                damage: |f| f.json("0.269", "0"),
                says: &[
                    "field instrument.length_sigma_um",
                    "expected more than zero; leave it out",
                ],
            },
            Case {
                name: "negative repeatability_um",
                damage: |f| f.json("\"repeatability_um\": 1.0", "\"repeatability_um\": -1.0"),
                says: &[
                    "field instrument.repeatability_um",
                    "-1",
                    "expected zero or more",
                ],
            },
        ],
    );
    assert_refused(
        &rotary_table(),
        &[Case {
            name: "rotary axis without a position",
            damage: |f| f.json(", \"position_mm\": [0, 0, 0] }", " }"),
            says: &["field machine.axes[0]: field `position_mm` is missing"],
        }],
    );
    assert_refused(
        &table_points(),
        &[Case {
            name: "points without runs",
            damage: |f| f.json("\"runs\": [ { \"name\": \"c\", \"axis\": \"C\" } ],", ""),
            says: &["field runs: the list is empty, but `points` refers to it"],
        }],
    );
}
