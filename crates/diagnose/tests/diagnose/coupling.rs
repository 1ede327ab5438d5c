//! Coupling of two axes against a calibration that was measured with the other axis away from home.
//!
//! The stage is displaced by `c x y`. A calibration whose X run had Y at b, and whose Y run had X at a, has `c (b x + a y)` of
//! it in its curves, so that readings show `c (x y - b x - a y)`.

use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Settings as Calibrating, calibrate};
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};
use trueaxis_diagnose::{Cause, Diagnosis, Rival, Settings, Verdict, diagnose_against};
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_predict::CalibratedMachine;

use crate::counts::summary;
use crate::iso_run::TARGET_MM;
use crate::three_runs::three_runs;
use crate::{campaign, generator, report};

/// µm/m².
const C: [f64; 3] = [480.0, -280.0, 160.0];
/// Where Y stood while X was calibrated, and X while Y was, mm.
const PARKED_MM: [f64; 2] = [250.0, 150.0];
const POINT_SIGMA_UM: f64 = 0.3;
const SIGMA_UM: f64 = 0.3;

/// What the coupling does, µm.
fn coupling_um(x_mm: f64, y_mm: f64) -> [f64; 3] {
    C.map(|c| c * 1e-6 * x_mm * y_mm)
}

/// Three targets at 21 positions of each axis of a machine that has no other errors.
fn calibrated(random: &mut ChaCha8Rng) -> CalibratedMachine {
    let parked_mm = [PARKED_MM[1], PARKED_MM[0], 0.0];
    calibrated_with(POINT_SIGMA_UM, parked_mm, coupling_um, random)
}

/// The same in noise of another size, with each axis parked elsewhere, and off by a function of X and Y.
fn calibrated_with(
    sigma_um: f64,
    parked_mm: [f64; 3],
    off_um: impl Fn(f64, f64) -> [f64; 3],
    random: &mut ChaCha8Rng,
) -> CalibratedMachine {
    let all = three_runs(parked_mm, sigma_um, |positions, home| {
        let off_um = off_um(positions[0], positions[1]);
        let at = std::array::from_fn(|c| {
            let noise: f64 = StandardNormal.sample(random);
            home[c] + positions[c] + (off_um[c] + sigma_um * noise) * MICROMETRE
        });
        Point3::from(at)
    });
    let calibration = calibrate(&all, &Calibrating::default()).unwrap();
    calibration.calibrated_machine()
}

/// Readings of a verification at x and y, five cycles there and back.
fn read(
    name: &str,
    kind: VerificationKind,
    places: &[[f64; 2]],
    reading_um: impl Fn([f64; 2]) -> f64,
    random: &mut ChaCha8Rng,
) -> Verification {
    let mut readings = Vec::new();
    for cycle in 1..=5 {
        for direction in [Direction::Forward, Direction::Backward] {
            for k in 0..places.len() {
                let k = if direction == Direction::Forward {
                    k
                } else {
                    places.len() - 1 - k
                };
                let noise: f64 = StandardNormal.sample(random);
                readings.push(VerificationReading {
                    time_s: None,
                    cycle,
                    direction,
                    positions: vec![places[k][0], places[k][1], 0.0],
                    value_um: 11.0 + reading_um(places[k]) + SIGMA_UM * noise,
                    line: readings.len() + 2,
                });
            }
        }
    }
    Verification {
        name: name.into(),
        kind,
        u_um: None,
        u_ppm: None,
        readings,
    }
}

/// A line along X with Y at a position.
fn line(y_mm: f64, random: &mut ChaCha8Rng) -> Verification {
    let places: Vec<[f64; 2]> = (0..21).map(|i| [20.0 * f64::from(i), y_mm]).collect();
    let kind = VerificationKind::Positioning {
        axis: 0,
        target_mm: TARGET_MM.into(),
    };
    let of_x = |[x, y]: [f64; 2]| coupling_um(x, y)[0];
    read(&format!("X at Y {y_mm}"), kind, &places, of_x, random)
}

fn diagnosed(calibration: &CalibratedMachine, all: Vec<Verification>) -> Diagnosis {
    diagnose_against(&campaign(all), calibration, &Settings::default()).unwrap()
}

/// Value and u of a coefficient of the coupling of X and Y that is found.
fn found(diagnosis: &Diagnosis, name: &str) -> [f64; 2] {
    let is_coupling = |id: &str| id == "cross_coupling";
    let cause = diagnosis
        .causes
        .iter()
        .find(|c| is_coupling(c.effect.effect.id));
    let cause = cause.unwrap_or_else(|| panic!("{}", summary(diagnosis)));
    let parameter = cause.parameters.iter().find(|p| p.name == name).unwrap();
    [parameter.value, parameter.u]
}

/// Two lines beside the calibrated position have one coupling, of the size that the machine has; at the calibrated position there is
/// nothing to be seen. A line that is read at home alone is explained by a scale error as well. Beyond 4 u: 6e-5.
#[test]
fn lines_show_a_coupling_from_where_the_axis_was_calibrated() {
    let mut random = generator(3, 62);
    let calibration = calibrated(&mut random);
    let beside = vec![line(0.0, &mut random), line(400.0, &mut random)];
    let [value, u] = found(&diagnosed(&calibration, beside), "coupling_x");
    assert!(
        (value - C[0]).abs() < 4.0 * u && u < 0.05 * C[0],
        "{value} ± {u}"
    );
    let there = diagnosed(&calibration, vec![line(PARKED_MM[0], &mut random)]);
    assert_eq!(there.verdict, Verdict::Clean, "{}", summary(&there));
    let home = diagnosed(&calibration, vec![line(0.0, &mut random)]);
    let names = alike(&home);
    assert!(
        names.contains(&"cross_coupling") && names.contains(&"scale_error"),
        "{names:?}"
    );
}

/// A coupling of X and Z that was taken out of what was measured says nothing of that of X and Y, which is in the curves of both from
/// where they were calibrated; if it is the one that was taken out, it counts from home, where it is not seen at Y 0.
#[test]
fn a_coupling_that_was_taken_out_counts_from_home_and_no_other_does() {
    let mut random = generator(3, 63);
    let mut calibration = calibrated(&mut random);
    let taken_out = |other: &str| {
        let subject = serde_json::json!({ "axis": "X", "other_axis": other });
        let effect =
            serde_json::json!({ "effect": "cross_coupling", "subject": subject, "parameters": [] });
        vec![serde_json::from_value::<GivenEffect>(effect).unwrap()]
    };
    let home = vec![line(0.0, &mut random)];
    let is_seen = |calibration: &CalibratedMachine| {
        let diagnosis = diagnosed(calibration, home.clone());
        alike(&diagnosis).contains(&"cross_coupling")
    };
    assert!(is_seen(&calibration));
    calibration.effects_taken_out = taken_out("Z");
    assert!(is_seen(&calibration));
    calibration.effects_taken_out = taken_out("Y");
    assert!(!is_seen(&calibration));
}

/// What explains the first cause as well, with it.
fn alike(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let cause = &diagnosis.causes[0];
    let rivals = cause.rivals.iter().filter_map(|rival| match rival {
        Rival::Effect { effect, .. } => Some(effect.effect.id),
        Rival::Disturbance { .. } => None,
    });
    rivals.chain([cause.effect.effect.id]).collect()
}

const CENTRE_MM: [f64; 2] = [200.0, 200.0];
const RADIUS_MM: f64 = 150.0;

/// A circle in XY of a machine that is off by a function of X and Y.
fn circle(off_um: impl Fn(f64, f64) -> [f64; 3], random: &mut ChaCha8Rng) -> Verification {
    let at = |k: i32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 72.0;
        let [x, y] = CENTRE_MM;
        [x + RADIUS_MM * angle.cos(), y + RADIUS_MM * angle.sin()]
    };
    let places: Vec<[f64; 2]> = (0..72).map(at).collect();
    let kind = VerificationKind::Ballbar {
        ball_mm: Point3::new(0.0, 0.0, 50.0),
        ball_carrier: 2,
        length_is_calibrated: false,
        center_mm: Point3::new(CENTRE_MM[0], CENTRE_MM[1], 50.0),
    };
    let along_bar = |[x, y]: [f64; 2]| {
        let off_um = off_um(x, y);
        (off_um[0] * (x - CENTRE_MM[0]) + off_um[1] * (y - CENTRE_MM[1])) / RADIUS_MM
    };
    read("DBB in XY", kind, &places, along_bar, random)
}

/// On a circle the coupling shows with the same sizes.
#[test]
fn a_ball_bar_shows_a_coupling_from_where_the_axes_were_calibrated() {
    let mut random = generator(4, 62);
    let calibration = calibrated(&mut random);
    let diagnosis = diagnosed(&calibration, vec![circle(coupling_um, &mut random)]);
    for (name, c) in [("coupling_x", C[0]), ("coupling_y", C[1])] {
        let [value, u] = found(&diagnosis, name);
        assert!(
            (value - c).abs() < 4.0 * u && u < 0.1 * c.abs(),
            "{name} {value} ± {u}"
        );
    }
}

/// How many of some machines whose squareness and scale have changed since their calibration have a clear coupling. What changed is
/// among what is said of each.
fn clear_couplings(seeds: std::ops::Range<u64>) -> usize {
    let changed_um = |x_mm: f64, y_mm: f64| [0.02 * x_mm - 0.039 * y_mm, 0.0, 0.0];
    let is_clear = |seed: &u64| {
        let mut random = generator(*seed, 63);
        let calibration = calibrated_with(0.8, [0.0; 3], |_, _| [0.0; 3], &mut random);
        let diagnosis = diagnosed(&calibration, vec![circle(changed_um, &mut random)]);
        let said = alike(&diagnosis);
        let is_changed = |id: &&str| ["squareness_error", "scale_error"].contains(id);
        assert!(said.iter().any(is_changed), "{seed}: {said:?}");
        let is_clear_coupling =
            |c: &Cause| c.effect.effect.id == "cross_coupling" && c.rivals.is_empty();
        diagnosis.causes.iter().any(is_clear_coupling)
    };
    seeds.filter(is_clear).count()
}

/// Squareness and scale that changed since are nearly a coupling from home: what differs is within the uncertainty of the
/// calibration. It was said to be clear in three of ten. Which has the larger 2 ln B is decided by noise, at odds of 20 to 1 at most once in 20:
/// one of two is clear with a probability of 0.1; the seeds are fixed.
#[test]
fn squareness_and_scale_that_changed_are_no_clear_coupling() {
    let clear = clear_couplings(0..2);
    assert!(clear == 0, "{clear} of 2");
}

#[test]
#[ignore = "study: 40 diagnoses"]
fn squareness_and_scale_are_seldom_a_clear_coupling() {
    let clear = clear_couplings(4..44);
    report(&format!("clear couplings: {clear} of 40"));
    assert!(clear <= 4, "{clear} of 40");
}
