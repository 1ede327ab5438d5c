//! What a campaign may declare beside its measurement: read, written back, and refused where it cannot
//! be.

use trueaxis_campaign::{
    AxisExpansion, Campaign, KnownDeadPath, KnownLength, LoggedQuantity, read, write,
};

use crate::fixture::{Files, assert_refused, rotary_table, three_axes};

/// P of [`three_axes`], up to its carrier.
const P: &str = "122.416], \"carried_by\": \"Z\"";
const Q: &str = "324.879], \"carried_by\": \"Z\"";
const K: &str = "412.448], \"carried_by\": \"Z\"";

/// Adds fields behind a piece of `campaign.json`.
fn add(files: &mut Files, behind: &str, fields: &str) {
    files.json(behind, &format!("{behind}, {fields}"));
}

/// Adds columns to `lengths.csv`: their names, and their cells in every row.
fn log(files: &mut Files, names: &str, cells: &str) {
    files.lines("lengths.csv", |lines| {
        for (i, line) in lines.iter_mut().enumerate() {
            *line += &format!(",{}", if i == 0 { names } else { cells });
        }
    });
}

/// X with an expansion, and its temperature in a column of its own.
fn expanding() -> Files {
    let mut files = three_axes();
    add(
        &mut files,
        "\"travel\": [0, 440]",
        r#""expansion_ppm_per_k": 11.5, "temperature_column": "machine_temp_x_c", "temperature_sigma_k": 0.2"#,
    );
    log(&mut files, "machine_temp_x_c", "20.5");
    files
}

/// The campaign with these fields, after it has come back from its own files unchanged.
fn declared(declare: impl Fn(&mut Files)) -> Campaign {
    let mut files = three_axes();
    declare(&mut files);
    let campaign = files.read().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = read(&write(&campaign, folder.path()).unwrap()).unwrap();
    assert_eq!(copy, campaign);
    assert_eq!(campaign.notices, [""; 0]);
    campaign
}

#[test]
fn what_is_left_out_is_not_declared() {
    let campaign = declared(|_| ());
    assert!(campaign.instrument.air_compensated);
    assert_eq!(campaign.instrument.scale_sigma_ppm, None);
    assert_eq!(campaign.targets[0].reflector, None);
    assert_eq!(campaign.stations[0].dead_path, None);
    assert_eq!(campaign.expansions, []);
    assert_eq!(campaign.known_lengths, []);
    assert_eq!((campaign.date, campaign.operator), (None, None));
}

#[test]
fn targets_share_reflectors_that_they_name_alike() {
    let names = ["P", "Q", "K"].map(str::to_owned);
    assert_eq!(
        declared(|_| ()).reflectors(),
        (names.to_vec(), vec![0, 1, 2])
    );
    let campaign = declared(|f| {
        add(f, P, "\"reflector\": \"SMR 1\"");
        add(f, K, "\"reflector\": \"SMR 1\"");
    });
    assert_eq!(campaign.targets[2].reflector.as_deref(), Some("SMR 1"));
    let names = ["SMR 1", "Q"].map(str::to_owned);
    assert_eq!(campaign.reflectors(), (names.to_vec(), vec![0, 1, 0]));
}

#[test]
fn one_reflector_written_in_two_ways_is_said() {
    let mut files = three_axes();
    add(&mut files, P, "\"reflector\": \"SMR 1\"");
    add(&mut files, Q, "\"reflector\": \"SMR 2\"");
    add(&mut files, K, "\"reflector\": \"smr-1\"");
    assert_eq!(
        files.read().unwrap().notices,
        [
            "reflectors `SMR 1` and `smr-1` of campaign.json count as two; if they are one, write the \
          name alike"
        ]
    );
}

#[test]
fn targets_declare_how_well_their_nests_were_set() {
    let campaign = declared(|f| add(f, Q, "\"position_sigma_mm\": 0.5"));
    let sigmas = campaign.targets.iter().map(|t| t.position_sigma_mm);
    assert!(sigmas.eq([None, Some(0.5), None]));
}

#[test]
fn targets_that_cannot_be() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| add(f, P, "\"reflecter\": \"R1\""),
                "field targets[0].reflecter … did you mean `reflector`?",
            ),
            (
                |f| add(f, P, "\"reflector\": \"R1 \""),
                "field targets[0].reflector: name \"R1 \" … without blanks",
            ),
            (
                |f| add(f, Q, "\"reflector\": \"P\""),
                "field targets[1].reflector: `P` is a target (targets[0]) … write \
                 `\"reflector\": \"P\"` in both",
            ),
            (
                |f| add(f, P, "\"position_sigma_mm\": 0"),
                "field targets[0].position_sigma_mm … a standard deviation of 0 mm; \
                 expected more than zero",
            ),
            (
                |f| f.json(P, "122.416], \"carried_by\": null"),
                "lengths.csv line 2, column run: \"x\" for target `P`, which stands on the \
                 bed … expected an empty cell: targets on the bed are read beside the runs",
            ),
            (
                |f| f.json(P, "122.416]"),
                "field targets[0]: field `carried_by` is missing",
            ),
        ],
    );
}

#[test]
fn instruments_declare_reflectors_scale_air_and_serial_number() {
    let campaign = declared(|f| {
        add(
            f,
            "\"repeatability_um\": 1.0",
            r#""reflector_sigma_um": 2.5, "scale_sigma_ppm": 0.4, "air_compensated": false, "serial": "LT-07/b""#,
        );
    });
    let instrument = &campaign.instrument;
    assert_eq!(instrument.reflector_sigma_um, Some(2.5));
    assert_eq!(instrument.scale_sigma_ppm, Some(0.4));
    assert!(!instrument.air_compensated);
    assert_eq!(instrument.serial.as_deref(), Some("LT-07/b"));
}

#[test]
fn instruments_that_cannot_be() {
    fn with(files: &mut Files, field: &str) {
        add(files, "\"repeatability_um\": 1.0", field);
    }
    assert_refused(
        &three_axes(),
        &[
            (
                |f| with(f, "\"reflector_sigma_um\": 0"),
                "field instrument.reflector_sigma_um … more than zero",
            ),
            (
                |f| with(f, "\"scale_sigma_ppm\": -2"),
                "field instrument.scale_sigma_ppm: a standard deviation of -2 … more than \
                 zero",
            ),
            (
                |f| with(f, "\"scale_sigma_ppm\": 1e300"),
                "field instrument.scale_sigma_ppm: a standard deviation of 1e300; expected no more than 1e9",
            ),
            (
                |f| with(f, "\"air_compensated\": \"yes\""),
                "field instrument.air_compensated … expected a boolean",
            ),
            (
                |f| with(f, "\"serial\": 4711"),
                "field instrument.serial … expected a string",
            ),
            (
                |f| with(f, "\"serial_no\": \"4711\""),
                "field instrument.serial_no … did you mean `serial`?",
            ),
        ],
    );
}

#[test]
fn dead_paths_are_known_with_their_uncertainty() {
    const S2: &str = "\"approx_mm\": [-900, -600, 200]";
    let campaign = declared(|f| {
        add(
            f,
            S2,
            "\"dead_path_mm\": 987.64, \"dead_path_sigma_mm\": 0.01",
        );
    });
    let known = KnownDeadPath {
        length_mm: 987.64,
        sigma_mm: 0.01,
    };
    assert_eq!(campaign.stations[1].dead_path, Some(known));
    assert_refused(
        &three_axes(),
        &[
            (
                |f| add(f, S2, "\"dead_path_mm\": 987.64"),
                "field stations[1]: field `dead_path_sigma_mm` is missing",
            ),
            (
                |f| add(f, S2, "\"dead_path_sigma_mm\": 0.01"),
                "field stations[1]: field `dead_path_mm` is missing",
            ),
            (
                |f| add(f, S2, "\"dead_path_mm\": 987.64, \"dead_path_sigma_mm\": 0"),
                "field stations[1].dead_path_sigma_mm … more than zero",
            ),
        ],
    );
}

#[test]
fn axes_expand_with_a_logged_temperature() {
    let campaign = expanding().read().unwrap();
    let expected = AxisExpansion {
        axis: 0,
        ppm_per_k: 11.5,
        temperature_column: "machine_temp_x_c".to_owned(),
        temperature_sigma_k: Some(0.2),
        lengths_hold_at_c: None,
    };
    assert_eq!(campaign.expansions, [expected]);
    let folder = tempfile::tempdir().unwrap();
    let copy = read(&write(&campaign, folder.path()).unwrap()).unwrap();
    assert_eq!(copy, campaign);

    let by_default = declared(|f| {
        add(f, "\"travel\": [0, 440]", "\"expansion_ppm_per_k\": 0");
        log(f, "machine_temp_c", "20");
    });
    let expansion = &by_default.expansions[0];
    assert_eq!(expansion.temperature_column, "machine_temp_c");
    assert_eq!(expansion.temperature_sigma_k, None);
}

#[test]
fn expansions_that_cannot_be() {
    assert_refused(
        &expanding(),
        &[
            (
                |f| f.replace("lengths.csv", "machine_temp_x_c", "machine_temp_z_c"),
                "field machine.axes[0].temperature_column: lengths.csv has no column \
                 `machine_temp_x_c` … did you mean `machine_temp_z_c`?",
            ),
            (
                |f| f.json("\"machine_temp_x_c\"", "\"machine_tmp_c\""),
                "field machine.axes[0].temperature_column: unknown temperature column … \
                 did you mean `machine_temp_c`?",
            ),
            (
                |f| f.json("\"machine_temp_x_c\"", "\"air_humidity_pct\""),
                "unknown temperature column `air_humidity_pct`",
            ),
            (
                |f| f.json("11.5,", "11.5e-6,"),
                "field machine.axes[0].expansion_ppm_per_k: an expansion of 0.0000115 \
                 ppm/K … expected a coefficient in um per m and K, such as 11.5 for steel",
            ),
            (
                |f| f.json("\"expansion_ppm_per_k\": 11.5, ", ""),
                "field machine.axes[0]: field `expansion_ppm_per_k` is missing",
            ),
            (
                |f| f.json("\"temperature_sigma_k\": 0.2", "\"temperature_sigma_k\": 0"),
                "field machine.axes[0].temperature_sigma_k … more than zero",
            ),
        ],
    );
    assert_refused(
        &rotary_table(),
        &[
            // Expansion of a table.
            (
                |f| {
                    f.json(
                        "\"travel\": [0, 360]",
                        "\"travel\": [0, 360], \"expansion_ppm_per_k\": 11",
                    );
                },
                "field machine.axes[0].expansion_ppm_per_k … axis C is rotary",
            ),
        ],
    );
}

#[test]
fn known_lengths_stand_between_two_targets() {
    const BEHIND: &str = "\"name\": \"test\"";
    let campaign = declared(|f| {
        add(
            f,
            BEHIND,
            r#""known_lengths": [ { "targets": ["P", "K"], "length_mm": 400.1002, "sigma_um": 0.5 } ]"#,
        );
    });
    let expected = KnownLength {
        targets: [0, 2],
        length_mm: 400.1002,
        sigma_um: 0.5,
    };
    assert_eq!(campaign.known_lengths, [expected]);

    fn with(files: &mut Files, targets: &str, length_mm: &str, sigma_um: &str) {
        let entry = format!(
            r#"{{ "targets": [{targets}], "length_mm": {length_mm}, "sigma_um": {sigma_um} }}"#
        );
        add(files, BEHIND, &format!("\"known_lengths\": [{entry}]"));
    }
    assert_refused(
        &three_axes(),
        &[
            (
                |f| with(f, "\"P\", \"k\"", "400.1", "0.5"),
                "field known_lengths[0].targets[1]: unknown target `k` … did you mean `K`?",
            ),
            (
                |f| with(f, "\"P\", \"P\"", "400.1", "0.5"),
                "field known_lengths[0].targets: target `P` twice",
            ),
            (
                |f| with(f, "\"P\", \"K\"", "0.4001002", "0.5"),
                "field known_lengths[0].length_mm: a length of 0.4001002 mm, but `P` and \
                 `K` are nominally 401.0 mm apart",
            ),
            (
                |f| with(f, "\"P\", \"K\"", "400.1", "0"),
                "field known_lengths[0].sigma_um … more than zero",
            ),
            (
                |f| with(f, "\"P\", \"K\"", "-400.1", "0.5"),
                "field known_lengths[0].length_mm … more than zero",
            ),
        ],
    );
}

#[test]
fn verifications_declare_their_uncertainty() {
    const BEHIND: &str = "\"kind\": \"positioning\"";
    let campaign = declared(|f| add(f, BEHIND, "\"u_um\": 0.3, \"u_ppm\": 0.7"));
    let verification = &campaign.verification[0];
    assert_eq!(
        (verification.u_um, verification.u_ppm),
        (Some(0.3), Some(0.7))
    );
    assert_refused(
        &three_axes(),
        &[
            (
                |f| add(f, BEHIND, "\"u_um\": 0"),
                "field verification[0].u_um … a standard uncertainty of 0",
            ),
            (
                |f| add(f, BEHIND, "\"u_ppm\": -1"),
                "field verification[0].u_ppm … zero or more",
            ),
            (
                |f| add(f, BEHIND, "\"u_mu\": 1"),
                "field verification[0].u_mu … did you mean `u_um`?",
            ),
        ],
    );
}

/// Point checks beside the line of [`three_axes`], as the table `text`.
fn add_points(files: &mut Files, text: &str) {
    let entry = r#"  "verification": [
    { "name": "ball plate", "kind": "points", "u_um": 0.4, "readings": "plate.csv" },"#;
    files.json("  \"verification\": [", entry);
    files.0.insert("plate.csv".to_owned(), text.to_owned());
}

#[test]
fn point_checks_hold_what_was_measured() {
    let campaign = declared(|f| {
        add_points(
            f,
            "time_s,cycle,X,Y,Z,x_mm,y_mm,z_mm,dx_um,dz_um\n\
             0,1,0,0,0,10,20,30,0,0\n\
             60,1,100,0,200,10,20,30,-1.5,\n\
             120,2,100,0,200,10,20,30,,2.25\n",
        );
    });
    let [check] = campaign.point_checks.as_slice() else {
        panic!("{:?}", campaign.point_checks);
    };
    assert_eq!((check.name.as_str(), check.u_um), ("ball plate", Some(0.4)));
    let last = &check.readings[2];
    assert_eq!(
        (last.time_s, last.cycle, last.line),
        (Some(120.0), Some(2), 4)
    );
    assert_eq!(last.positions, [100.0, 0.0, 200.0]);
    assert_eq!(last.tool_home_mm, Some([10.0, 20.0, 30.0].into()));
    assert_eq!(last.deviation_um, [None, None, Some(2.25)]);
    assert_eq!(check.readings[1].deviation_um, [Some(-1.5), None, None]);
    // The line is still there, and a table with nothing but positions and deviations will do.
    assert_eq!(campaign.verification.len(), 1);
    let least = declared(|f| add_points(f, "Z,Y,X,dy_um\n3,2,1,0.5\n"));
    let reading = &least.point_checks[0].readings[0];
    assert_eq!(
        (reading.time_s, reading.cycle, reading.tool_home_mm),
        (None, None, None)
    );
    assert_eq!(reading.positions, [1.0, 2.0, 3.0]);
}

#[test]
fn point_checks_that_are_none() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| add_points(f, "X,Z,dx_um\n0,0,1\n"),
                "plate.csv line 1, column Y … missing",
            ),
            (
                |f| add_points(f, "X,Y,Z,dx_um\n0,0,0,1\n0,900,0,1\n"),
                "plate.csv line 3, column Y … 900 … 400",
            ),
            (
                |f| add_points(f, "X,Y,Z\n0,0,0\n"),
                "plate.csv line 1, column dx_um … missing",
            ),
            (
                |f| add_points(f, "X,Y,Z,dx_um,dz_um\n0,0,0,1,\n9,0,0,,\n"),
                "plate.csv line 3 … no deviation was measured … remove the row",
            ),
            (
                |f| add_points(f, "X,Y,Z,x_mm,y_mm,dx_um\n0,0,0,1,2,3\n"),
                "plate.csv line 1, column z_mm … missing",
            ),
            (
                |f| add_points(f, "X,Y,Z,dx_um\n0,0,0,none\n"),
                "plate.csv line 2, column dx_um … none",
            ),
            (
                |f| add_points(f, "X,Y,Z,dx_um\n"),
                "plate.csv: there are no rows",
            ),
            // An axis as of a line.
            (
                |f| {
                    add_points(f, "X,Y,Z,dx_um\n0,0,0,1\n");
                    f.json(
                        "\"points\", \"u_um\"",
                        "\"points\", \"axis\": \"X\", \"u_um\"",
                    );
                },
                "field verification[0].axis … belongs to the kind `positioning`",
            ),
            // No uncertainty.
            (
                |f| {
                    add_points(f, "X,Y,Z,dx_um\n0,0,0,1\n");
                    f.json("\"u_um\": 0.4", "\"u_um\": 0");
                },
                "field verification[0].u_um … a standard uncertainty of 0",
            ),
        ],
    );
}

#[test]
fn the_day_and_the_operator() {
    const BEHIND: &str = "\"name\": \"test\"";
    let campaign = declared(|f| {
        add(
            f,
            BEHIND,
            "\"date\": \"2026-03-31\", \"operator\": \"J. Doe\"",
        );
    });
    assert_eq!(campaign.date.as_deref(), Some("2026-03-31"));
    assert_eq!(campaign.operator.as_deref(), Some("J. Doe"));
    assert_refused(
        &three_axes(),
        &[
            (
                |f| add(f, BEHIND, "\"date\": \"31.3.2026\""),
                "field date: found \"31.3.2026\"; expected a day as year-month-day",
            ),
            (
                |f| add(f, BEHIND, "\"operator\": [\"J. Doe\"]"),
                "field operator … expected a string",
            ),
        ],
    );
}

#[test]
fn any_number_of_machine_temperatures() {
    let names = "air_pressure_hpa,machine_temp_spindle_c,machine_temp_c,machine_temp_column_2_c";
    let campaign = declared(|f| {
        log(f, names, "1013.2,21.5,20,20.25");
        f.cell("lengths.csv", 3, "machine_temp_spindle_c", "");
        f.cell("lengths.csv", 4, "machine_temp_spindle_c", "22");
    });
    let lengths = campaign.lengths.as_ref().unwrap();
    let logged = lengths.logged.iter().map(|column| column.name.as_str());
    assert!(logged.eq(names.split(',')));
    let spindle = lengths.logged_column("machine_temp_spindle_c").unwrap();
    assert_eq!(spindle.values.len(), lengths.readings.len());
    assert_eq!(spindle.values[..3], [Some(21.5), None, Some(22.0)]);
    assert_eq!(spindle.quantity(), Some(LoggedQuantity::MachineTemperature));
    assert_eq!(lengths.logged_column("air_temp_c"), None);
    assert_refused(
        &three_axes(),
        &[
            (
                |f| log(f, "machine_temp_spindle", "20"),
                "line 1, column machine_temp_spindle: unknown column … did you mean \
                 `machine_temp_<name>_c`?",
            ),
            (
                |f| log(f, "machine_temp__c", "20"),
                "line 1, column machine_temp__c: unknown column",
            ),
            (
                |f| log(f, "machine_temp_x_c,machine_temp_x_c", "20,20"),
                "column machine_temp_x_c: the column stands twice",
            ),
            (
                |f| log(f, "machine_temp_x_c", "20 C"),
                "line 2, column machine_temp_x_c: \"20 C\" is not a number",
            ),
            (
                |f| f.json("{ \"name\": \"Y\",", "{ \"name\": \"machine_temp_y_c\","),
                "field machine.axes[1].name … name of another column",
            ),
        ],
    );
}
