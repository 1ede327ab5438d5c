//! Damage to `campaign.json`, and to files as a whole.

use crate::fixture::{Files, assert_refused, rotary_table, table_points, three_axes};

#[test]
fn whole_files() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| drop(f.0.remove("campaign.json")),
                "campaign.json: there is no such file … give the path",
            ),
            (
                |f| drop(f.0.remove("lengths.csv")),
                "lengths.csv: there is no such file … campaign.json, field lengths, names it",
            ),
            (
                |f| drop(f.0.remove("li_x.csv")),
                "li_x.csv: there is no such file … field verification[0].readings",
            ),
            (
                |f| f.json("\"lengths.csv\"", "\".\""),
                "this is a folder, expected a file … field lengths",
            ),
            (
                |f| empty(f, "campaign.json"),
                "campaign.json: the file is empty",
            ),
            (
                |f| empty(f, "lengths.csv"),
                "lengths.csv: the file is empty … saved completely?",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines.truncate(1)),
                "lengths.csv: there are no rows",
            ),
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

/// What a disk lost: a line of any length that is not worth quoting.
#[test]
fn lines_without_a_column_are_quoted_in_part() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| drop(f.0.insert("lengths.csv".to_owned(), "\0".repeat(100_000))),
                "lengths.csv: the file holds NUL bytes, so it is no text; is it the right file?",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines[0] = "1234567µ".repeat(10_000)),
                "`1234567µ1234567µ1234567µ1234567µ1234567µ1234567µ1234567µ1234567µ1234567µ1234567µ…`; expected",
            ),
        ],
    );
}

#[test]
fn format_and_version() {
    assert_refused(
        &three_axes(),
        &[
            // A calibration, whose fields are all unknown.
            (
                |f| {
                    let calibration = r#"{ "format": "trueaxis-calibration", "version": 1, "method": "nine-equation" }"#;
                    f.0.insert("campaign.json".to_owned(), calibration.to_owned());
                },
                "campaign.json line 1, field format … trueaxis calibration, not a campaign",
            ),
            (
                |f| f.json("trueaxis-campaign", "survey"),
                "field format: found \"survey\" … expected \"trueaxis-campaign\"",
            ),
            (
                |f| f.json("trueaxis-campaign", "trueaxis-scenario"),
                "trueaxis scenario, not a campaign",
            ),
            (
                |f| f.json("\"format\": \"trueaxis-campaign\",", ""),
                "field format: found nothing … expected \"trueaxis-campaign\"",
            ),
            (
                |f| f.json("\"version\": 1,", "\"version\": 2, \"novelty\": true,"),
                "field version: found 2; expected 1 … newer release",
            ),
            (
                |f| f.json("\"name\": \"test\",", "\"name\": \"test\",,"),
                "campaign.json line 4, character … not valid JSON",
            ),
            (
                |f| f.lines("campaign.json", |lines| lines.truncate(12)),
                "campaign.json line 13 … not valid JSON: it ends too early",
            ),
            (
                |f| f.json("\"name\": \"test\",", "\"name\": \"test\""),
                "campaign.json line 5 … not valid JSON … RFC 8259",
            ),
            (
                |f| drop(f.0.insert("campaign.json".to_owned(), "3".to_owned())),
                "campaign.json line 1: invalid type … expected an object",
            ),
        ],
    );
}

#[test]
fn fields() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.json("length_sigma_um", "lenght_sigma_um"),
                "campaign.json line 14, field instrument.lenght_sigma_um … did you mean \
                 `length_sigma_um`? … known: name, serial, length_sigma_um, \
                 length_sigma_ppm, repeatability_um",
            ),
            (
                |f| f.json("\"name\": \"x\", ", ""),
                "field runs[0]: field `name` is missing",
            ),
            (
                |f| f.json("[16.338, ", "[\"16.338\", "),
                "field targets[0].position_mm[0] … expected a number",
            ),
            (
                |f| f.json("[16.338, ", "["),
                "field targets[0].position_mm … expected three numbers",
            ),
            // Unknown kind of axis.
            (
                |f| {
                    f.json(
                        "\"name\": \"Y\", \"kind\": \"linear\"",
                        "\"name\": \"Y\", \"kind\": \"linaer\"",
                    );
                },
                "field machine.axes[1].kind … did you mean `linear`? known: linear, rotary",
            ),
            (
                |f| f.json("\"positioning\"", "\"interferometer\""),
                "field verification[0].kind … known: positioning, ballbar",
            ),
            (
                |f| f.json("\"target_mm\"", "\"ball_mm\""),
                "field verification[0].ball_mm … belongs to the kind `ballbar`",
            ),
            // Verification without its axis.
            (
                |f| {
                    f.json(
                        "\"kind\": \"positioning\", \"axis\": \"X\",",
                        "\"kind\": \"positioning\",",
                    );
                },
                "field verification[0]: field `axis` is missing",
            ),
            (
                |f| f.json("\"lengths\":", "\"points\": \"points.csv\", \"lengths\":"),
                "field points … choose one … keep `lengths` for multilateration",
            ),
            // No data at all.
            (
                |f| {
                    f.lines("campaign.json", |lines| {
                        let data = lines
                            .iter()
                            .position(|l| l.contains("\"lengths\""))
                            .unwrap();
                        lines.truncate(data - 1);
                        lines.extend(["  \"runs\": []".to_owned(), "}".to_owned()]);
                    });
                },
                "campaign.json: the campaign has no data … `lengths` or `points`",
            ),
            // Lengths without stations.
            (
                |f| {
                    f.lines("campaign.json", |lines| {
                        let start = lines
                            .iter()
                            .position(|l| l.contains("\"stations\""))
                            .unwrap();
                        lines.drain(start..start + 6);
                    });
                },
                "field stations: the list is empty, but `lengths` refers to it",
            ),
        ],
    );
}

#[test]
fn names() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.json("{ \"name\": \"Y\",", "{ \"name\": \"X\","),
                "field machine.axes[1].name … axis `X` … machine.axes[0].name",
            ),
            (
                |f| f.json("\"name\": \"K\"", "\"name\": \"P\""),
                "field targets[2].name … target `P` … targets[0].name",
            ),
            (
                |f| f.json("\"name\": \"S3\"", "\"name\": \"S2\""),
                "field stations[2].name … station `S2` … stations[1].name",
            ),
            (
                |f| f.json("\"name\": \"z\"", "\"name\": \"y\""),
                "field runs[2].name … run `y` … runs[1].name",
            ),
            (
                |f| f.json("{ \"name\": \"Y\",", "{ \"name\": \"target\","),
                "field machine.axes[1].name … name of another column",
            ),
            (
                |f| f.json("\"name\": \"K\"", "\"name\": \"K \""),
                "field targets[2].name … without blanks",
            ),
            (
                |f| f.json("\"axis\": \"Y\"", "\"axis\": \"V\""),
                "field runs[1].axis: unknown axis `V` … known: X, Y, Z",
            ),
            // Target on an unknown axis.
            (
                |f| {
                    f.json(
                        "452.716, 122.416], \"carried_by\": \"Z\"",
                        "452.716, 122.416], \"carried_by\": \"z\"",
                    );
                },
                "field targets[0].carried_by: unknown axis `z` … did you mean `Z`?",
            ),
            // Station missing from the list.
            (
                |f| {
                    f.lines("campaign.json", |lines| {
                        let last = lines.iter().position(|l| l.contains("\"S4\"")).unwrap();
                        lines.remove(last);
                        let before = lines[last - 1].trim_end_matches(',').to_owned();
                        lines[last - 1] = before;
                    });
                },
                "lengths.csv line 272, column station … `S4`",
            ),
            (
                |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"X\", \"Y\", \"ZZ\"]"),
                "field machine.kinematics.tool[2] … did you mean `Z`?",
            ),
        ],
    );
}

#[test]
fn values() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.json("\"direction\": [0, 1, 0]", "\"direction\": [0, 2, 0]"),
                "field machine.axes[1].direction: axis Y … length 2, expected a unit vector",
            ),
            (
                |f| f.json("\"direction\": [0, 1, 0]", "\"direction\": [0, 0, 0]"),
                "field machine.axes[1].direction … expected a unit vector",
            ),
            (
                |f| f.json("0.269", "-0.3"),
                "field instrument.length_sigma_um … more than zero",
            ),
            (
                |f| f.json("[0, 440]", "[440, 0]"),
                "field machine.axes[0].travel … low end first, in mm",
            ),
            (
                |f| f.json("[0, 440]", "[0, 440], \"position_mm\": [0, 0, 0]"),
                "field machine.axes[0].position_mm … remove it",
            ),
            (
                |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"X\", \"Y\"]"),
                "field machine.kinematics: axis Z appears in no kinematic branch",
            ),
            (
                |f| f.json("0.269", "0"),
                "field instrument.length_sigma_um … expected more than zero; leave it out",
            ),
            (
                |f| f.json("\"repeatability_um\": 1.0", "\"repeatability_um\": -1.0"),
                "field instrument.repeatability_um … -1 … expected zero or more",
            ),
        ],
    );
    assert_refused(
        &rotary_table(),
        &[(
            |f| f.json(", \"position_mm\": [0, 0, 0] }", " }"),
            "field machine.axes[0]: field `position_mm` is missing",
        )],
    );
    assert_refused(
        &table_points(),
        &[(
            |f| f.json("\"runs\": [ { \"name\": \"c\", \"axis\": \"C\" } ],", ""),
            "field runs: the list is empty, but `points` refers to it",
        )],
    );
}
