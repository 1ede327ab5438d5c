//! Tables onto those that were active while the machine was measured: the models of the controls add what the new ones add, and
//! what the targets saw of the old ones.
//!
//! They saw it along the lines that were measured, one axis moving and the others at home, if the axis that the old tables moved
//! stands on the same branch as the one that was measured: `old_o(q) = old_o(0) + Σ old_o(q_i) - old_o(0)` over the axes i of the
//! branch of o. All the rest is whole in the new calibration.

use serde_json::{Value, json};
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_compensate::{Error, Export, ExportedFile, Format, Request};
use trueaxis_kinematics::{Branch, MICROMETRE, Machine};
use trueaxis_simulate::simulate;

use crate::controllers::control;
use crate::{
    FIVE_AXES, THREE_AXES, calibrated, export, poses, request, request_of, scenario, tool,
};

const FORMATS: [Format; 4] = [
    Format::Grid,
    Format::LinuxCnc,
    Format::Sinumerik,
    Format::Heidenhain,
];

type Control<'a> = dyn Fn(&[f64]) -> Vec<f64> + 'a;

/// What the targets saw of it.
fn seen(old: &Control<'_>, machine: &Machine, commanded: &[f64]) -> Vec<f64> {
    let home = vec![0.0; commanded.len()];
    let at_home = old(&home);
    let mut seen = at_home.clone();
    for branch in [Branch::Tool, Branch::Workpiece].map(|branch| machine.branch(branch)) {
        for &input in branch {
            let mut along = home.clone();
            along[input] = commanded[input];
            let along = old(&along);
            for &output in branch {
                seen[output] += along[output] - at_home[output];
            }
        }
    }
    seen
}

/// The three-axis machine with its X under the workpiece, where it has targets of its own.
fn two_branches() -> String {
    let mut scenario: Value = serde_json::from_str(THREE_AXES).unwrap();
    scenario["machine"]["kinematics"] = json!({ "tool": ["Y", "Z"], "workpiece": ["X"] });
    let mut targets = scenario["targets"].as_array().unwrap().clone();
    for mut target in targets.clone() {
        target["name"] = format!("{} of X", target["name"].as_str().unwrap()).into();
        target["carried_by"] = "X".into();
        targets.push(target);
    }
    scenario["targets"] = targets.into();
    scenario.to_string()
}

/// What an old calibration of the same machine, with other noise, made, at its own spacing.
fn old(format: Format, text: &str) -> Export {
    let campaign = simulate(&scenario(text), 7).unwrap().campaign;
    let machine = calibrate(&campaign, &Settings::default()).unwrap();
    let machine = machine.calibrated_machine();
    let step = (text != FIVE_AXES).then_some(40.0);
    export(
        format,
        &Request {
            step,
            ..request_of(format, &machine)
        },
    )
    .unwrap()
}

/// Linear in the tables (`grid`, `sinumerik`, `heidenhain`: to the digits of the files), or one behind the other (`linuxcnc`: files behind
/// matrices): to the second order, some nm.
#[test]
fn the_control_adds_what_was_seen_of_the_old_ones() {
    for text in [THREE_AXES, FIVE_AXES, &two_branches()] {
        let machine = calibrated(&scenario(text), false);
        for format in FORMATS {
            let old = old(format, text);
            let new = export(format, &request_of(format, &machine)).unwrap();
            let onto = Request {
                onto: &old.files,
                ..request_of(format, &machine)
            };
            let sum = export(format, &onto).unwrap();
            // It is announced for the machine as measured, with the old ones on.
            assert_eq!(sum.announcement, new.announcement, "{}", format.name());
            let [old, new, sum] =
                [&old, &new, &sum].map(|export| control(format, export, machine.machine(), tool()));
            let mut largest: f64 = 0.0;
            let mut added: f64 = 0.0;
            for commanded in poses(&machine, 200) {
                let old = seen(&old, machine.machine(), &commanded);
                let [new, sum] = [&new, &sum].map(|control| control(&commanded));
                for ((old, new), sum) in old.iter().zip(&new).zip(&sum) {
                    largest = largest.max((old + new - sum).abs());
                    added = added.max(sum.abs());
                }
            }
            println!(
                "{} {}: {:.6} of {:.1} µm",
                machine.name,
                format.name(),
                largest / MICROMETRE,
                added / MICROMETRE
            );
            // The matrices of linuxcnc move the corrections of each other's files along slopes below 3e-4.
            let limit = match format {
                Format::LinuxCnc => added * 3e-4,
                _ => 4e-4 * MICROMETRE,
            };
            assert!(largest < limit && added > 10.0 * MICROMETRE);
        }
    }
}

/// Tables for one axis leave those of the others as they are.
#[test]
fn what_only_the_old_ones_have_stays() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    for format in [Format::LinuxCnc, Format::Sinumerik, Format::Heidenhain] {
        let old = old(format, THREE_AXES);
        let one = Request {
            axis: Some(0),
            ..request_of(format, &machine)
        };
        let new = export(format, &one).unwrap();
        let sum = Request {
            onto: &old.files,
            ..one
        };
        let sum = export(format, &sum).unwrap();
        let [old, new, sum] =
            [&old, &new, &sum].map(|export| control(format, export, machine.machine(), tool()));
        for commanded in [[100.0, 0.0, 0.0], [0.0, 210.0, 0.0], [50.0, 130.0, 370.0]] {
            let [old, new, sum] = [&old, &new, &sum].map(|control| control(&commanded));
            for ((old, new), sum) in old.iter().zip(&new).zip(&sum) {
                assert!(
                    (old + new - sum).abs() < 0.02 * MICROMETRE,
                    "{}",
                    format.name()
                );
            }
        }
    }
}

#[test]
fn old_tables_that_are_none_are_refused_with_their_place() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let refused = |format, name: &str, text: &str| {
        let old = [ExportedFile {
            name: name.to_owned(),
            text: text.to_owned(),
        }];
        let request = Request {
            onto: &old,
            ..request_of(format, &machine)
        };
        export(format, &request).unwrap_err().to_string()
    };
    let enc = "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.01\n$AA_ENC_COMP_STEP[0,AX1]=440\n\
               $AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=440\n";
    let grid = "X,Y,Z,add_X_um,add_Y_um,add_Z_um\n0,0,0,1,1,1\n440,0,0,1,1,1\n";
    for (format, name, text, says) in [
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc[..40],
            "AX_EEC.INI line 2",
        ),
        (
            Format::Sinumerik,
            "X.comp",
            "0 0 0\n440 440 440\n",
            "X.comp line 1: \"0 0 0\"; expected an assignment",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            "%_N_AX_EEC_INI\nCHANDATA(1)\nM17\n",
            "\"no assignment\"; expected tables",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &format!("N10 {enc}$AA_ENC_COMP_WEIGHT[0,AX1]=1\n"),
            "AX_EEC.INI line 6",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &format!("{enc}$AA_ENC_COMP_MIN[0,AX1]=0\n"),
            "each variable of a table once",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc.replace("=0.01\n", "=10\n"),
            "the file is in mm and degrees",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc[..80],
            "_MIN of the table; the file may be cut off",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc.replace("AX1", "AX9"),
            "expected AX1 to AX3",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc.replace("=440\n$AA_ENC_COMP_MIN", "=220\n$AA_ENC_COMP_MIN"),
            "2 points from 0 to 440, 220 apart",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &enc.replace("=440\n$AA_ENC_COMP_MIN", "=439.99\n$AA_ENC_COMP_MIN")
                .replace("=440\n", "=439.99\n"),
            "axis X, the old and the new table in one",
        ),
        (
            Format::Sinumerik,
            "AX_EEC.INI",
            &format!("{enc}$AA_ENC_COMP_IS_MODULO[0,AX1]=1\n"),
            "_IS_MODULO 0",
        ),
        (
            Format::Grid,
            "grid.csv",
            "X,Y,Z\n0,0,0\n",
            "a column add_X_um",
        ),
        (Format::Grid, "grid.csv", &grid[..50], "grid.csv line 3"),
        (
            Format::Grid,
            "grid.csv",
            &grid.replace("add_Z_um", "add_Z_um,add_C_um"),
            "\"add_C_um\"; expected each column once",
        ),
        (
            Format::Grid,
            "grid.csv",
            &grid.replace("add_Z_um", "add_Z_um,X"),
            "\"X\"; expected each column once",
        ),
        (
            Format::LinuxCnc,
            "x.comp",
            "0 0 0\n",
            "x.comp is no old table of linuxcnc for this machine; expected X.comp, Y.comp, Z.comp, matrixkins.hal",
        ),
        (
            Format::LinuxCnc,
            "X.comp",
            "",
            "\"no lines\"; expected position, forward, reverse",
        ),
        (
            Format::LinuxCnc,
            "X.comp",
            "0 0 0\n440 0.01 0.01\n",
            "X.comp line 2: \"440 0.01 0.01\"; expected actual positions",
        ),
        (
            Format::LinuxCnc,
            "matrixkins.hal",
            "# none\n",
            "\"no cell\"; expected `setp",
        ),
        (
            Format::LinuxCnc,
            "matrixkins.hal",
            "setp matrixkins.C_xx 1\nloadrt matrixkins\n",
            "matrixkins.hal line 2",
        ),
        (
            Format::LinuxCnc,
            "matrixkins.hal",
            "setp matrixkins.C_xy 0\nsetp matrixkins.C_xy 0\n",
            "each cell once",
        ),
        (
            Format::LinuxCnc,
            "matrixkins.hal",
            "setp matrixkins.C_xx 0\nsetp matrixkins.C_xy 1\n",
            "a matrix near that of a machine without errors",
        ),
        (
            Format::Grid,
            "grid.csv",
            &grid.replace("440,0,0", "440,0,40"),
            "every node of the grid once",
        ),
        (
            Format::Heidenhain,
            "U.com.csv",
            "AXISPOS,U\n0,0\n",
            "U.com.csv is no old table of heidenhain for this machine; expected X.com.csv, Y.com.csv, Z.com.csv",
        ),
        (
            Format::Heidenhain,
            "README.txt",
            "",
            "README.txt is no old table of heidenhain",
        ),
        (
            Format::Heidenhain,
            "X.com.csv",
            "AXISPOS,U\n0,0\n",
            "AXISPOS, then once BACKLASH or X, Y, Z",
        ),
        (
            Format::Heidenhain,
            "X.com.csv",
            "AXISPOS,X\n20,0\n10,0\n",
            "X.com.csv line 3",
        ),
        (
            Format::Heidenhain,
            "X.com.csv",
            "AXISPOS,X\n0,0\n7,0\n",
            "heidenhain wants equal distances",
        ),
        (
            Format::Marlin,
            "skew.gcode",
            "M852 I0\n",
            "marlin takes no old tables",
        ),
        (
            Format::Isg,
            "volcomp.csv",
            "X EXX\n0 0\n440 0.01\n",
            "isg takes no old tables",
        ),
    ] {
        let said = refused(format, name, text);
        assert!(
            said.contains(says),
            "{}: {said}\n  expected {says}",
            format.name()
        );
    }
    let two = old(Format::Sinumerik, THREE_AXES).files;
    let request = Request {
        onto: &two,
        ..request(&machine)
    };
    assert!(matches!(
        export(Format::Grid, &request),
        Err(Error::Unsuitable { .. })
    ));
    // Among others, too, and for heidenhain with the files beside the tables.
    for format in [Format::LinuxCnc, Format::Heidenhain] {
        let mut files = old(format, THREE_AXES).files;
        files.push(ExportedFile {
            name: "U.comp".to_owned(),
            text: String::new(),
        });
        let request = Request {
            onto: &files,
            ..request_of(format, &machine)
        };
        let refused = export(format, &request).unwrap_err();
        assert!(
            matches!(&refused, Error::NoOldTable { file, .. } if file == "U.comp"),
            "{refused}"
        );
    }
}
