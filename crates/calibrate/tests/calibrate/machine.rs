//! The calibrated machine: from a calibration, and from its files.

use std::io::Cursor;
use std::path::Path;

use nalgebra::{Matrix6, Point3};
use tempfile::TempDir;
use trueaxis_calibrate::{Calibration, ReferencePoint, Settings, calibrate};
use trueaxis_predict::{CalibratedMachine, FactoredCovariance};
use trueaxis_simulate::{Scenario, simulate};

use crate::{simulated, two_branches};

/// Places of X, Y, C: at steps, between and outside.
const PLACES: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [170.0, 130.0, 1.3],
    [420.0, 290.0, 5.6],
    [20.0, 300.0, 3.0],
];

fn tool() -> Point3<f64> {
    Point3::new(100.0, 50.0, 300.0)
}

fn calibrated(reference_point: ReferencePoint) -> Calibration {
    let mut settings = Settings {
        reference_point,
        ..Settings::default()
    };
    settings.poses.by_direction = true;
    calibrate(&simulated(&two_branches()), &settings).unwrap()
}

/// The bytes of `covariance.npz`.
fn npz(calibration: &Calibration) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    calibration.write_covariance_npz(&mut bytes).unwrap();
    bytes.into_inner()
}

/// The files of a calibration in a folder.
fn written(calibration: &Calibration) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = calibration.to_json();
    std::fs::write(folder.path().join("calibration.json"), text).unwrap();
    let covariance = folder.path().join(FactoredCovariance::FILE);
    std::fs::write(covariance, npz(calibration)).unwrap();
    folder
}

fn read(folder: &Path) -> Result<CalibratedMachine, String> {
    CalibratedMachine::read(&folder.join("calibration.json")).map_err(|error| error.to_string())
}

/// Files round to 1e-6 µm and 1e-6 ″.
fn assert_same_predictions(a: &CalibratedMachine, b: &CalibratedMachine, relative: f64) {
    for positions in PLACES {
        let [a, b] = [a, b].map(|machine| machine.predict(&positions, tool()));
        let off = a.error.to_vector() - b.error.to_vector();
        assert!(off.norm() < 1e-8, "{positions:?}: {:e}", off.norm());
        // What is certain at home comes back with rounding.
        let scale = a.u().map(|u| u.max(1e-8));
        let off: Matrix6<f64> = a.covariance - b.covariance;
        for (i, j) in (0..36).map(|k| (k / 6, k % 6)) {
            let off = off[(i, j)] / (scale[i] * scale[j]);
            assert!(off.abs() < relative, "{positions:?} ({i}, {j}): {off:e}");
        }
        assert_eq!(a.extrapolated, b.extrapolated);
    }
}

#[test]
fn files_hold_the_whole_machine() {
    for oblique in [false, true] {
        let mut scenario = two_branches();
        if oblique {
            scenario.machine.axes[1].direction = [0.0, 0.8, 0.6];
            scenario.machine.axes[2].direction = [0.28, 0.0, 0.96];
            scenario.errors.clear();
            scenario.targets[1].position_sigma_mm = Some(0.005);
        }
        let campaign = simulated(&scenario);
        for by_direction in [false, true] {
            let mut settings = Settings {
                reference_point: ReferencePoint::At(Point3::new(50.0, -20.0, 70.0)),
                ..Settings::default()
            };
            settings.poses.by_direction = by_direction;
            let calibration = calibrate(&campaign, &settings).unwrap();
            let folder = written(&calibration);
            let machine = read(folder.path()).unwrap();
            assert_same_predictions(&calibration.calibrated_machine(), &machine, 1e-5);
            assert_eq!(machine.campaign, campaign.name);
            // X with Y at 110; Y with X at 250, and at 60, so that no single place holds; C with both at home.
            let parked = &machine.parked;
            let home = Some(0.0);
            assert_eq!(parked[&0], [home, Some(110.0), home]);
            assert_eq!(parked[&1], [None, home, home]);
            assert_eq!(parked[&2], [home; 3]);
            assert_eq!(npz(&calibration), npz(&calibration));
        }
    }
}

/// The factors are the covariance of all results: their diagonal is the stated uncertainties, what gauge and frame
/// define is zero. That the matrix is right is tested with all others, against responses of the calibration.
#[test]
fn the_factors_state_the_uncertainties() {
    assert_states_the_uncertainties(&calibrated(ReferencePoint::Origin));
    // Nests that are not certain enter through the frame.
    let mut scenario = two_branches();
    for (i, target) in scenario.targets.iter_mut().enumerate() {
        target.position_sigma_mm = Some(0.01 * (1 + i) as f64);
    }
    let nests = calibrate(&simulated(&scenario), &Settings::default()).unwrap();
    assert_states_the_uncertainties(&nests);
    let share = nests.axes[2].location_errors[0].budget;
    assert!(share.systematic > 0.05 * share.variance(), "{share:?}");
}

fn assert_states_the_uncertainties(calibration: &Calibration) {
    let dense = calibration.factors.dense();
    let in_u = |i: usize| match dense[(i, i)] > 0.0 {
        true => dense[(i, i)].sqrt().recip(),
        false => 1.0,
    };
    for (i, result) in calibration.results().iter().enumerate() {
        let off = dense[(i, i)].max(0.0).sqrt() - result.u;
        assert!(off.abs() <= 1e-9 * result.u, "{:?}: {off:e}", result.output);
        for j in [0, i / 2, i] {
            let (a, b) = (in_u(i), in_u(j));
            let u = calibration.factors.u(&[(i, a), (j, b)]);
            let both = a * a * dense[(i, i)] + b * b * dense[(j, j)];
            assert!((u * u - both - 2.0 * a * b * dense[(i, j)]).abs() <= 4e-9);
        }
    }
}

/// The shift of C is stated at the height of the reference point, which its tilt moves by 15 µm; predictions are the
/// same. (X and Y have no angular errors, so the frame is the same as well.)
#[test]
fn the_reference_point_does_not_matter() {
    let [origin, centroid] = [ReferencePoint::Origin, ReferencePoint::Centroid].map(calibrated);
    let shift = |calibration: &Calibration| {
        let c = calibration.axis("C").unwrap();
        c.location_error("Y0C").unwrap().value
    };
    assert!((shift(&origin) - shift(&centroid)).abs() > 0.01);
    let [origin, centroid] = [origin, centroid].map(|c| c.calibrated_machine());
    for positions in PLACES {
        let [a, b] = [&origin, &centroid].map(|machine| machine.predict(&positions, tool()));
        let off = a.error.to_vector() - b.error.to_vector();
        assert!(off.norm() < 1e-8, "{positions:?}: {:e}", off.norm());
    }
}

/// A sine of five steps on an axis with hardly any noise: between the steps the rms of what the interpolation is off by is
/// the rms of its uncertainty, a little more for so short a wave (15 %).
#[test]
fn interpolation_is_as_uncertain_as_it_is_wrong() {
    let scenario = include_str!("../../../../campaigns/fxyz/scenario.json");
    let mut scenario = Scenario::from_json(scenario).unwrap();
    scenario.instrument.length_sigma_um = Some(0.01);
    scenario.instrument.repeatability_um = Some(0.01);
    let simulated = simulate(&scenario, 1).unwrap();
    let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
    let machine = calibration.calibrated_machine();
    let at = |q: f64| machine.predict(&[0.0, q, 0.0], Point3::origin());
    let truth = |q: f64| {
        // EYY: a cubic, which is nothing to an interpolation by cubics, and this wave of 4.75 steps.
        1.3e-3 * (std::f64::consts::TAU * q / 95.0 + 110_f64.to_radians()).sin()
    };
    let (mut squares, mut variances) = (0.0, 0.0);
    for i in 0..20 {
        // The polynomial through the same steps as the curve's gives what a cubic leaves of the wave.
        let q = 10.0 + 20.0 * f64::from(i);
        let left = [-30.0, -10.0, 10.0, 30.0].map(|step| truth(q + step));
        let cubic = (9.0 * (left[1] + left[2]) - left[0] - left[3]) / 16.0;
        if (1..19).contains(&i) {
            squares += (cubic - truth(q)).powi(2);
            variances += at(q).of_interpolation[(1, 1)];
        }
    }
    let ratio = (variances / squares).sqrt();
    assert!((0.8..1.05).contains(&ratio), "{ratio}");
    assert!(at(40.0).of_interpolation.norm() < f64::MIN_POSITIVE);
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let calibration = calibrated(ReferencePoint::Origin);
    let folder = written(&calibration);
    let file = folder.path().join("calibration.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let refused = |text: &str| {
        std::fs::write(&file, text).unwrap();
        read(folder.path()).unwrap_err()
    };
    let without = text.replacen("\"machine\"", "\"machines\"", 1);
    let error = refused(&without);
    assert!(error.contains("field `machine` is missing"), "{error}");
    let error = refused(&text.replacen("\"name\": \"Y\"", "\"name\": \"V\"", 2));
    assert!(error.contains("unknown axis `Y`"), "{error}");
    let error = refused(&text.replacen("\"EXX\"", "\"EXW\"", 1));
    assert!(error.contains("axes[0].components: field `EXX`"), "{error}");
    let error = refused(&text.replacen("\"B0C\"", "\"B0E\"", 1));
    assert!(
        error.contains("unknown location error `B0E`; did you mean"),
        "{error}"
    );
    let error = refused(&text[..text.len() / 2]);
    assert!(error.contains("not valid JSON"), "{error}");
    let error = refused(&text.replacen("trueaxis-calibration", "trueaxis-campaign", 1));
    assert!(error.contains("this is a trueaxis campaign"), "{error}");

    // Another calibration's covariance, one that was cut off, none.
    std::fs::write(&file, &text).unwrap();
    let covariance = folder.path().join(FactoredCovariance::FILE);
    let both = calibrate(&simulated(&two_branches()), &Settings::default()).unwrap();
    for (bytes, says) in [
        (npz(&both), "has the shape"),
        (
            npz(&calibrated(ReferencePoint::Centroid)),
            "standard uncertainty of",
        ),
        (
            npz(&calibration)[..1000].to_vec(),
            "not a complete NumPy archive",
        ),
    ] {
        std::fs::write(&covariance, bytes).unwrap();
        let error = read(folder.path()).unwrap_err();
        assert!(
            error.contains(says) && error.contains("keep the two files"),
            "{error}"
        );
    }
    std::fs::remove_file(&covariance).unwrap();
    let error = read(folder.path()).unwrap_err();
    assert!(error.contains("belongs beside calibration.json"), "{error}");
}
