//! Tables of other systems as calibrations: what our writers make comes back, what is damaged is refused with its place.

use nalgebra::Point3;
use serde_json::Value;
use trueaxis_calibrate::{ReferencePoint, Settings};
use trueaxis_campaign::{InputFile, MachineSpec};
use trueaxis_compensate::{
    DeclaredUncertainty, Error, Format, Import, Imported, Request, export, import,
};
use trueaxis_kinematics::{ARCSEC, Ideal, MICROMETRE, Machine};
use trueaxis_predict::CalibratedMachine;

use crate::{
    FIVE_AXES, TABLE, THREE_AXES, calibrated, calibrated_with, controllers, poses, scenario, tool,
};

const DECLARED: DeclaredUncertainty = DeclaredUncertainty {
    um: 2.0,
    arcsec: None,
};

pub(crate) fn imported(
    text: &str,
    machine: &Machine,
    uncertainty: Option<DeclaredUncertainty>,
) -> Result<Imported, Error> {
    import(&Import {
        file: InputFile {
            name: "tables.txt".to_owned(),
            sha256: String::new(),
        },
        text,
        machine,
        machine_name: "machine",
        uncertainty,
    })
}

/// Through the files, as `predict` reads them.
pub(crate) fn read(imported: &Imported) -> CalibratedMachine {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("calibration.json");
    std::fs::write(&path, imported.calibration.to_string()).unwrap();
    if let Some(covariance) = &imported.covariance {
        let mut file = std::fs::File::create(folder.path().join("covariance.npz")).unwrap();
        let as_they_are = vec![1.0; covariance.results()];
        covariance.write_npz(&mut file, &as_they_are).unwrap();
    }
    CalibratedMachine::read(&path).unwrap()
}

fn exported(format: Format, machine: &CalibratedMachine) -> String {
    let request = Request {
        format,
        machine,
        at: tool(),
        axis: None,
        step: None,
        sign: None,
        levers: false,
        onto: &[],
    };
    export(&request).unwrap().files[0].text.clone()
}

/// The nominal machine, without the reference points of a calibration.
fn nominal(text: &str) -> Machine {
    scenario(text).true_machine().unwrap().machine().clone()
}

/// A calibration, exported and imported again, predicts the same displacements beside those at home (what is zero there
/// is not in the tables of machines without rotary axes), to the digits of the files.
#[test]
fn what_was_exported_comes_back() {
    for text in [THREE_AXES, FIVE_AXES, TABLE] {
        let machine = calibrated(&scenario(text), false);
        for format in [Format::Isg, Format::Etalon] {
            let found = imported(&exported(format, &machine), &nominal(text), None).unwrap();
            assert_eq!(found.format, format);
            assert_eq!(found.covariance, None);
            let again = read(&found);
            assert!(!again.has_uncertainties);
            let error = |machine: &CalibratedMachine, at: &[f64]| {
                let of = |at: &[f64]| machine.machine().tool_error(machine, at, tool());
                let home = of(&vec![0.0; at.len()]).translation_mm;
                let error = of(at);
                (error.translation_mm - home, error.rotation_rad)
            };
            let mut largest: [f64; 2] = [0.0; 2];
            for at in poses(&machine, 200) {
                let (a, b) = (error(&machine, &at), error(&again, &at));
                largest[0] = largest[0].max((a.0 - b.0).norm() / MICROMETRE);
                largest[1] = largest[1].max((a.1 - b.1).norm() / ARCSEC);
            }
            println!("{} {}: {largest:?} µm, ″", machine.name, format.name());
            // Ten decimals of mm and rad with levers of 1 m, and the second order of δ at another reference point.
            assert!(largest[0] < 3e-3 && largest[1] < 1e-4, "{largest:?}");
        }
    }
}

/// Whatever the reference point of the calibration was, and though an axis is oblique, the tables are those of the machine as the campaign
/// gives it: δ of rotary axes at `position_mm` (that of `etalon` stood at the reference point and nobody could know), all three parts
/// of a tilt (one of an oblique axis was missing, up to 11 µm).
#[test]
fn tables_are_of_the_machine_as_it_is_given() {
    let oblique = r#""name": "Z", "kind": "linear", "direction": [0, 0.6, 0.8]"#;
    let upright = r#""name": "Z", "kind": "linear", "direction": [0, 0, 1]"#;
    assert!(THREE_AXES.contains(upright));
    let oblique = THREE_AXES.replace(upright, oblique);
    let at = ReferencePoint::At(Point3::new(100.0, 200.0, -70.0));
    for (text, reference_point) in [
        (oblique.as_str(), ReferencePoint::Origin),
        (oblique.as_str(), at),
        (FIVE_AXES, at),
        (TABLE, at),
        (TABLE, ReferencePoint::Centroid),
    ] {
        let settings = Settings {
            reference_point,
            ..Settings::default()
        };
        let machine = calibrated_with(&scenario(text), &settings);
        let nominal = nominal(text);
        let steps: Vec<Vec<f64>> = (0..nominal.axes().len())
            .map(|axis| machine.steps(axis))
            .collect();
        // At the steps of all axes.
        let poses = (0..40).map(|k| {
            steps
                .iter()
                .enumerate()
                .map(move |(i, of)| of[(7 * k + 3 * i * k) % of.len()])
        });
        let poses: Vec<Vec<f64>> = poses.map(Iterator::collect).collect();
        for format in [Format::Isg, Format::Etalon] {
            let file = exported(format, &machine);
            let tables = match format {
                Format::Isg => controllers::isg(&file, &nominal),
                _ => controllers::etalon(&file, &nominal),
            };
            // What is there at home is zero in tables without rotary axes.
            let off = |at: &Vec<f64>| {
                let own = machine.machine().tool_error(&machine, at, tool());
                let of_tables = nominal.tool_error(&tables, at, tool());
                own.translation_mm - of_tables.translation_mm
            };
            let home = off(&vec![0.0; steps.len()]);
            let largest = poses.iter().map(|at| (off(at) - home).norm() / MICROMETRE);
            let largest = largest.fold(0.0, f64::max);
            println!("{} {}: {largest:.4} µm", machine.name, format.name());
            assert!(
                largest < 3e-3,
                "{} {}: {largest} µm",
                machine.name,
                format.name()
            );
        }
    }
}

/// With a declared uncertainty every prediction has one: at a step of X alone, six components of three axes and three
/// squarenesses, put together here.
#[test]
fn a_declared_uncertainty_is_that_of_each_value() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let nominal = nominal(THREE_AXES);
    let text = exported(Format::Isg, &machine);
    let again = read(&imported(&text, &nominal, Some(DECLARED)).unwrap());
    assert!(again.has_uncertainties);
    let at = [200.0, 100.0, 300.0];
    let u = again.predict(&at, tool()).u();
    // Half the diagonal of 440, 400, 400 mm.
    let lever_mm = 0.5 * f64::sqrt(440.0 * 440.0 + 2.0 * 400.0 * 400.0);
    let (u_mm, u_rad) = (2.0 * MICROMETRE, 2.0 * MICROMETRE / lever_mm);
    // Angles of X, Y, Z about z and y move the point along x; C0Y turns Y's, B0Z turns Z's travel.
    let p = machine
        .machine()
        .tool_in_workpiece(&Ideal, &at)
        .transform_point(&tool());
    let mut squares = 3.0 * u_mm * u_mm;
    // The levers of each axis: from the origin of its stage to the point.
    for stage in [[200.0, 0.0, 0.0], [200.0, 100.0, 0.0], at] {
        let lever = p.coords - nalgebra::Vector3::from(stage);
        squares += u_rad * u_rad * (lever.y * lever.y + lever.z * lever.z);
    }
    squares += u_rad * u_rad * (100.0 * 100.0 + 300.0 * 300.0);
    let expected = squares.sqrt();
    assert!((u[0] / expected - 1.0).abs() < 0.02, "{} {expected}", u[0]);
    // Angles of their own.
    let own = DeclaredUncertainty {
        arcsec: Some(0.5),
        ..DECLARED
    };
    let again = read(&imported(&text, &nominal, Some(own)).unwrap());
    let u = again.predict(&at, tool()).u()[3] / ARCSEC;
    assert!((u / (0.5 * 3_f64.sqrt()) - 1.0).abs() < 0.02, "{u}");
    // A machine without a length to make one of.
    let table = calibrated(&scenario(TABLE), false);
    let text = exported(Format::Etalon, &table);
    let refused = imported(&text, &self::nominal(TABLE), Some(DECLARED));
    assert_eq!(refused, Err(Error::NoLever));
}

/// Without one nothing has an uncertainty, and that is said.
#[test]
fn without_an_uncertainty_nothing_has_one() {
    let machine = calibrated(&scenario(THREE_AXES), false);
    let text = exported(Format::Etalon, &machine);
    let found = imported(&text, &nominal(THREE_AXES), None).unwrap();
    assert!(
        found
            .notices
            .iter()
            .any(|n| n.contains("no uncertainty was given"))
    );
    let again = read(&found);
    let u = again.predict(&[20.0, 20.0, 20.0], tool()).u();
    assert!(u.iter().all(|u| u.is_nan()), "{u}");
    assert!(
        again
            .compare(&machine)
            .unwrap()
            .iter()
            .all(|d| d.u.is_nan() && !d.is_beyond_noise())
    );
    let settings = trueaxis_predict::VolumeSettings {
        points: 3,
        tool_home_mm: tool(),
        draws: 10,
        seed: 1,
    };
    assert_eq!(again.volume(&settings).figures.best_fit.rms.drawn, None);
    let left = trueaxis_compensate::remains(&again, &again.places(3, tool())).unwrap();
    assert!(left.u_rms_mm.is_nan() && left.u_max_mm.is_nan());
}

/// Files as the public descriptions show them: tabs, comments behind values, parts of the errors, other positions for each.
#[test]
fn other_peoples_files() {
    let nominal = nominal(THREE_AXES);
    let isg = "// machine 7\r\nB0Z\tC0Y\tX0X\r\n1e-5\t-2e-5\t0\r\n#\r\nP0X P0Y P0Z\r\n0 0 120\r\n#\r\n\
               X EXX ECX // x\r\n0 0 0\r\n100 0.002 1e-6\r\n#\r\nX EAX\r\n50 1e-5\r\n100 2e-5\r\n";
    let found = imported(isg, &nominal, None).unwrap();
    let values = |name: &str| found.calibration["axes"][0]["components"][name].clone();
    assert_eq!(
        found.calibration["axes"][0]["positions"],
        serde_json::json!([0.0, 50.0, 100.0])
    );
    assert_eq!(
        values("EXX")["value_um"],
        serde_json::json!([0.0, 1.0, 2.0])
    );
    assert_eq!(
        values("EYX")["value_um"],
        serde_json::json!([0.0, 0.0, 0.0])
    );
    let angle = |k: usize| values("EAX")["value_arcsec"][k].as_f64().unwrap();
    assert!((angle(0) - 1e-5 / ARCSEC).abs() < 1e-6 && (angle(2) - 2e-5 / ARCSEC).abs() < 1e-6);
    let squareness = &found.calibration["location_errors"]["C0Y"]["value_arcsec"];
    assert!((squareness.as_f64().unwrap() + 2e-5 / ARCSEC).abs() < 1e-6);
    let said = found.notices.join("\n");
    assert!(
        said.contains("axis X: not in the file and taken for zero: EYX, EZX, EBX"),
        "{said}"
    );
    assert!(said.contains("interpolated between them"), "{said}");
    // Y and Z have location errors alone: nothing else is wrong with them.
    assert_eq!(
        found.calibration["axes"][2]["positions"],
        serde_json::json!([0.0, 400.0])
    );
    let again = read(&found);
    let error = again
        .machine()
        .tool_error(&again, &[0.0, 100.0, 0.0], tool());
    assert!((error.translation_mm.x - 2e-3).abs() < 1e-5, "{error:?}");
    assert_eq!(found.calibration["stations"], Value::Array(Vec::new()));
}

#[test]
fn damaged_files_are_refused_with_their_place() {
    let nominal = nominal(THREE_AXES);
    let refused = |text: &str| imported(text, &nominal, None).unwrap_err().to_string();
    for (text, says) in [
        (
            "",
            "line 1: \"nothing\"; expected component or location errors",
        ),
        // ISG.
        (
            "0 0 0\n",
            "line 1: \"0 0 0\"; expected the names of errors above",
        ),
        (
            "X EXX\n0 0\n10\n",
            "line 3: \"10\"; expected 2 numbers, one for each name of line 1",
        ),
        (
            "X EXX\n0 0\n10 0,002\n",
            "line 3: \"0,002\"; expected a number with a decimal point",
        ),
        ("X EXX\n0 0\n10 nan\n", "line 3: \"nan\"; expected a number"),
        (
            "X EXX\n0 0\n10 2.1\n0 0\n",
            "line 4: \"0, after 10\"; expected positions that rise",
        ),
        (
            "X EXX\n0 0\n10 20.5\n",
            "line 3: \"EXX = 20.5\"; expected at most 5 mm",
        ),
        (
            "X EAX\n0 0\n10 0.5\n",
            "line 3: \"EAX = 0.5\"; expected at most 0.05 rad",
        ),
        (
            "X EXX\n0 0\n",
            "line 1: \"EXX\"; expected two points or more",
        ),
        (
            "X EXX EYX\n",
            "line 1: \"X EXX EYX\"; expected values below these names",
        ),
        (
            "Z X EXX\n0 0 0\n",
            "line 1: \"Z X EXX\"; expected one axis that the errors depend on",
        ),
        (
            "X EXY\n0 0\n10 0\n",
            "line 1: \"EXY\"; expected component errors of X",
        ),
        (
            "X EWX\n0 0\n10 0\n",
            "line 1: \"EWX\"; expected an error of an axis of this machine; did you mean",
        ),
        (
            "C ECC\n0 0\n10 0\n",
            "line 1: \"ECC\"; expected an error of an axis of this machine",
        ),
        ("C0Y\n1e-5\n2e-5\n", "line 3: \"2e-5\"; expected one row"),
        (
            "C0Y\n1e-5\n#\nC0Y\n1e-5\n",
            "line 5: \"C0Y\"; expected each error once; line 2 has it already",
        ),
        (
            "C0X C0W\n1e-5 1e-5\n",
            "line 2: \"C0W\"; expected an error of an axis of this machine",
        ),
        (
            "X EXX\n0 0\n500 0\n",
            "line 1: \"X at 500 mm\"; expected positions within its travel, 0 to 440 mm",
        ),
        // Etalon.
        (
            "[EXX]\nGridpoints = {\n0 0\n10 0\n",
            "line 4: \"the end of the file\"; expected the end of [EXX], begun in line 1",
        ),
        (
            "[EXX]\nGridpoints = {\n0 0\n10 0\n[EYX]\n",
            "line 5: \"[EYX]\"; expected argument and value of [EXX]",
        ),
        (
            "[C0Y]\n[EXX]\n",
            "line 2: \"[EXX]\"; expected `VALUE = ` or `Gridpoints = {` of [C0Y]",
        ),
        ("[C0Y]\nVALUE = \n", "line 2: \"\"; expected a number"),
        (
            "[C0Y]\nVALUE = 0.00001\nEXX\n",
            "line 3: \"EXX\"; expected [EXX], the name of an error",
        ),
        (
            "[C0Y]\nUNIT = arcsec\n",
            "line 2: \"UNIT = arcsec\"; expected `VALUE = `",
        ),
    ] {
        let said = refused(text);
        assert!(said.starts_with("tables.txt "), "{said}");
        assert!(said.contains(says), "{said}\n  expected {says}");
    }
    // Cut off anywhere, a file is refused, or what it lacks is said; that rows of the last block lack nobody knows.
    let machine = calibrated(&scenario(THREE_AXES), false);
    for format in [Format::Isg, Format::Etalon] {
        let text = exported(format, &machine);
        let whole = imported(&text, &nominal, None).unwrap();
        for part in 1..40 {
            let end = (0..=text.len() * part / 40)
                .rev()
                .find(|&end| text.is_char_boundary(end));
            let text = &text[..end.unwrap()];
            let said = imported(text, &nominal, None).map(|found| found.notices.len());
            let is_row_of_isg = format == Format::Isg && text.ends_with('\n');
            assert!(said.is_err() || said.unwrap() > whole.notices.len() || is_row_of_isg);
        }
    }
}

/// The centre of a rotary axis in the file is where its errors are given for; one beside the axis is of another frame.
#[test]
fn the_centre_of_a_rotary_axis() {
    let nominal = nominal(TABLE);
    let [x, y, z]: [f64; 3] = nominal.axes()[0].reference_mm().coords.into();
    let with = |x: f64| {
        let text = format!(
            "PXC PYC PZC\n{x} {y} {}\n#\nC ECC\n0 0\n90 1e-5\n",
            z + 30.0
        );
        imported(&text, &nominal, None)
    };
    let found = with(x).unwrap();
    assert_eq!(
        found.calibration["axes"][0]["reference_point_mm"][2],
        z + 30.0
    );
    let said = with(x + 25.0).unwrap_err().to_string();
    assert!(said.contains("it is 25.000 mm beside it"), "{said}");
    let spec = MachineSpec::of("machine", &nominal);
    assert_eq!(
        found.calibration["machine"],
        serde_json::to_value(spec).unwrap()
    );
}
