//! Files for a machine whose errors are round numbers, against what the descriptions of the controls want: worked out by hand.
//!
//! X stands 10 µm too far at 100 mm and 20 at 200, Y leans by 10″ towards +X, and the table C, at (50, 60), is turned by 5″ too
//! far at 90°.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use trueaxis_compensate::{Format, Request};
use trueaxis_kinematics::{Axis, Machine};

use crate::import::{imported, read};
use crate::{export, request_of};

/// 10″ are 4.84814e-5 rad, 5″ 2.42407e-5 rad or 0.00138889°; Y has the direction (-C0Y, 1, 0).
const ERRORS: &str = "C0Y\n-0.0000484814\n#\nPXC PYC PZC\n50 60 0\n#\nX EXX\n0 0\n100 0.010\n200 0.020\n#\n\
                      Y EYY\n0 0\n200 0\n#\nZ EZZ\n0 0\n200 0\n#\n\
                      C ECC\n0 0\n90 0.0000242407\n180 0\n270 0\n360 0\n";

/// All files of a format, for the tool point (100, 110, 50), and the notes.
fn made(format: Format) -> (String, String) {
    let linear = |name, direction| Axis::linear(name, direction, [0.0, 200.0]).unwrap();
    let centre = Point3::new(50.0, 60.0, 0.0);
    let axes = vec![
        linear("X", Vector3::x()),
        linear("Y", Vector3::y()),
        linear("Z", Vector3::z()),
        Axis::rotary("C", Vector3::z(), [0.0, TAU], centre).unwrap(),
    ];
    let machine = Machine::new(axes, vec![0, 1, 2], vec![3]).unwrap();
    let machine = read(&imported(ERRORS, &machine, None).unwrap());
    let request = Request {
        at: Point3::new(100.0, 110.0, 50.0),
        ..request_of(format, &machine)
    };
    let export = export(format, &request).unwrap();
    let files = export
        .files
        .iter()
        .map(|file| format!("{}\n{}", file.name, file.text));
    (files.collect(), export.notes.join("\n"))
}

fn assert_has(format: Format, lines: &[&str]) {
    let (files, _) = made(format);
    for expected in lines {
        assert!(
            format!("\n{files}").contains(&format!("\n{expected}\n")),
            "{}: {expected} is not in\n{files}",
            format.name()
        );
    }
}

/// The control adds nominal minus actual, and calculates `X_joint = C_xx X + C_xy Y + C_xz Z`.
#[test]
fn linuxcnc() {
    let lines = [
        "X.comp\n0 0 0\n100 100.01 100.01\n200 200.02 200.02",
        "90 90.0013889 90.0013889\n180 180 180",
        "setp matrixkins.C_xx 1\nsetp matrixkins.C_xy -0.0000484814\nsetp matrixkins.C_xz 0",
        "setp matrixkins.C_yx 0",
    ];
    assert_has(Format::LinuxCnc, &lines);
}

/// A positive value of `$AA_ENC_COMP` moves the axis in the negative direction; 10″ on 200 mm are 9.6963 µm.
#[test]
fn sinumerik() {
    let lines = [
        "$AA_ENC_COMP[0,0,AX1]=0\n$AA_ENC_COMP[0,1,AX1]=0.01\n$AA_ENC_COMP[0,2,AX1]=0.02\n$AA_ENC_COMP_STEP[0,AX1]=100",
        "$AA_ENC_COMP_MIN[0,AX1]=0\n$AA_ENC_COMP_MAX[0,AX1]=200",
        "$AA_ENC_COMP[0,1,AX4]=0.0013889",
        "$AN_CEC[2,0]=0\n$AN_CEC[2,1]=0.0096963\n$AN_CEC_INPUT_AXIS[2]=(AX2)\n$AN_CEC_OUTPUT_AXIS[2]=(AX1)\n$AN_CEC_STEP[2]=200",
    ];
    assert_has(Format::Sinumerik, &lines);
}

/// With `--sign error` the columns hold the error curves: positive where the axis goes too far.
#[test]
fn heidenhain() {
    let lines = [
        "X.com.csv\nAXISPOS,X,Y,Z\n0,0,0,0\n100,0.01,0,0\n200,0.02,0,0",
        "ACTIVE,X,Y,Z\n*,X.com,Y.com,Z.com",
    ];
    assert_has(Format::Heidenhain, &lines);
    assert!(made(Format::Heidenhain).0.contains("\n200,0.0096963,"));
}

/// mm, rad and degrees; the tool point is the zero position of the tool; the chain begins at the workpiece.
#[test]
fn isg_and_etalon() {
    let lines = [
        "P0X P0Y P0Z\n100 110 50\n#\nC0Y\n-0.0000484814\n#",
        "X EXX EYX EZX EAX EBX ECX\n0 0 0 0 0 0 0\n100 0.01 0 0 0 0 0\n200 0.02 0 0 0 0 0\n#",
        "PXC PYC PZC\n50 60 0\n#",
        "90 0 0 0 0 0 0.0000242407",
    ];
    assert_has(Format::Isg, &lines);
    let lines = [
        "[C0Y]\nVALUE = -0.000048481400",
        "[EXX]\nGridpoints = {\n0 0.000000000000\n100 0.010000000000\n200 0.020000000000\n}  // end of EXX",
    ];
    // The digits of the calibration in between, 1e-6″.
    let (etalon, _) = made(Format::Etalon);
    assert!(
        etalon.contains(lines[1]) && etalon.contains(&lines[0][..21]),
        "{etalon}"
    );
    // Records: the lines below the headers.
    for (format, says) in [
        (Format::Isg, "max_records 15 or more"),
        (Format::Etalon, "P0X P0Y P0Z = 100 110 50 beside it"),
    ] {
        let (_, notes) = made(format);
        for says in [says, "chain CXYZ, workpiece_axes 1", "alternative_model 1"] {
            assert!(notes.contains(says), "{says}: {notes}");
        }
    }
}

/// Both correct with `x - y f`, so f is positive where Y leans towards +X and the corner at the origin is acute: AC is the longer
/// diagonal, 141.4213562 mm √(1 ± 4.84814e-5).
#[test]
fn marlin_and_klipper() {
    assert_has(
        Format::Marlin,
        &["M852 I0.000048481 J0.000000000 K0.000000000"],
    );
    let (klipper, notes) = made(Format::Klipper);
    assert!(klipper.contains("\nSET_SKEW XY=141.4247843"), "{klipper}");
    assert!(klipper.contains(",141.4179280"), "{klipper}");
    // A comment of that firmware, and what a start takes away.
    assert!(klipper.contains("skew.gcode\n; "), "{klipper}");
    assert!(notes.contains("SKEW_PROFILE LOAD=trueaxis"), "{notes}");
}
