//! The shipped verification readings: compensation does what it says.

use std::path::Path;

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::{Campaign, read};
use trueaxis_compensate::{Verified, verify};
use trueaxis_diagnose::{diagnose, diagnose_against};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::verification::{bars_on_the_stage, five_axis_readings, verification_campaign};

fn shipped(name: &str) -> Campaign {
    let campaigns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../campaigns");
    read(&campaigns.join(name).join("campaign.json")).unwrap()
}

fn calibrated() -> CalibratedMachine {
    let calibration = calibrate(&shipped("fxyz"), &Settings::default()).unwrap();
    calibration.calibrated_machine()
}

/// Largest minus smallest mean reading, µm.
fn range_um(verified: &Verified) -> f64 {
    let all = verified.points.iter().map(|point| point.reading_um);
    all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min)
}

/// Readings agree with the predictions, and what was there is gone by more than the paper's factor (16.69 → 5.11,
/// -17.52 → -4.47, -18.38 → -4.67 µm along X, Y, Z).
#[test]
fn compensation_takes_away_what_was_predicted() {
    let machine = calibrated();
    let before = verify(&machine, &shipped("fxyz-lines"), false).unwrap();
    let after = verify(&machine, &shipped("fxyz-compensated"), true).unwrap();
    assert_eq!((before.len(), after.len()), (4, 4));
    let paper = [16.69 / 5.11, 17.52 / 4.47, 18.38 / 4.67, 1.0];
    for ((before, after), factor) in before.iter().zip(&after).zip(paper) {
        for verified in [before, after] {
            let counts = verified.above_one();
            println!(
                "{}: {} of {} |E_n| above 1",
                verified.name, counts.0, counts.1
            );
            assert!(!verified.is_misfit(), "{}", verified.name);
        }
        let [b, a] = [before, after].map(range_um);
        println!("{}: {b:.2} -> {a:.2} µm", before.name);
        assert!(b / a > factor, "{}: {b} {a}", before.name);
    }
}

/// Ball bars at the paper's points A and B of the rotary stage (Fig. 16) agree with the prediction of its calibration, by Eq. 24 as
/// exactly.
#[test]
fn bars_on_the_stage_agree_with_the_prediction() {
    let calibration = calibrate(&shipped("rotary-stage"), &Settings::default()).unwrap();
    let bars = verify(
        &calibration.calibrated_machine(),
        &shipped("rotary-bars"),
        false,
    )
    .unwrap();
    assert_eq!(bars.len(), 2);
    for verified in &bars {
        let counts = verified.above_one();
        let off = |f: fn(&trueaxis_compensate::Point) -> f64| {
            let all = verified.points.iter().map(f);
            all.fold(0.0, |largest: f64, x| largest.max(x.abs()))
        };
        println!(
            "{}: {counts:?} |E_n| above 1, {:.2} µm at most, Eq. 24 off by {:.4} µm",
            verified.name,
            off(|p| p.reading_um - p.predicted_um),
            off(|p| p.first_order_um - p.predicted_um)
        );
        assert_eq!(counts.1, 38);
        assert!(!verified.is_misfit(), "{}", verified.name);
        assert!(off(|p| p.first_order_um - p.predicted_um) < 0.05);
    }
    let scenario = include_str!("../../../campaigns/rotary-stage/scenario.json");
    let scenario = Scenario::from_json(scenario).unwrap();
    let truth = scenario.true_machine().unwrap();
    let made = bars_on_the_stage(&shipped("rotary-stage"), &truth, "bars").unwrap();
    let shipped = shipped("rotary-bars");
    for (a, b) in made.verification.iter().zip(&shipped.verification) {
        let values = |v: &trueaxis_campaign::Verification| -> Vec<f64> {
            v.readings.iter().map(|r| r.value_um).collect()
        };
        assert_eq!(values(a), values(b));
    }
}

/// Lines, arcs, ball bars and places of the five-axis machine agree with the prediction of its calibration, and the files are what the
/// exact model makes.
#[test]
fn five_axes_are_where_the_calibration_says() {
    let readings = shipped("five-axis-lines");
    let calibration = calibrate(&shipped("five-axis"), &Settings::default()).unwrap();
    let verified = verify(&calibration.calibrated_machine(), &readings, false).unwrap();
    // 3 lines of 42, 2 arcs of 26, a bar of 144 and one of 26, 36 places of which 12 in one coordinate.
    let all: usize = verified.iter().map(|entry| entry.above_one().1).sum();
    assert_eq!((verified.len(), all), (8, 3 * 42 + 2 * 26 + 144 + 26 + 84));
    for verified in &verified {
        println!(
            "{}: {:?} {:?}",
            verified.name,
            verified.above_one(),
            verified.p_value
        );
        assert!(!verified.is_misfit(), "{}", verified.name);
    }
    // What the interpolation of its curves leaves is no fault of the machine; a wave of 90 mm that steps of 40 mm hardly show is.
    let settings = trueaxis_diagnose::Settings::default();
    let against = calibration.calibrated_machine();
    let diagnosis = diagnose_against(&readings, &against, &settings).unwrap();
    for cause in &diagnosis.causes {
        assert_eq!(cause.effect.effect.id, "cyclic_error");
        let period = cause.parameters.last().unwrap();
        let is_true = (period.value - 90.0).abs() < 4.0 * period.u && period.u < 5.0;
        assert!(is_true, "{period:?}");
    }
    let truth = five_axis_scenario().true_machine().unwrap();
    let made = five_axis_readings(&shipped("five-axis"), &truth, &readings.name).unwrap();
    assert_eq!(made, readings);
}

fn five_axis_scenario() -> Scenario {
    let scenario = include_str!("../../../campaigns/five-axis/scenario.json");
    Scenario::from_json(scenario).unwrap()
}

/// Share of the readings beyond U, with its standard error, when the five-axis machine is calibrated anew in each of so many
/// campaigns: one calibration moves many readings at once, so the campaigns are the sample.
fn share_beyond_u(campaigns: u32) -> (f64, f64) {
    let (readings, scenario) = (shipped("five-axis-lines"), five_axis_scenario());
    let shares = (1..=campaigns).map(|seed| {
        let campaign = simulate(&scenario, u64::from(seed)).unwrap().campaign;
        let calibration = calibrate(&campaign, &Settings::default()).unwrap();
        let verified = verify(&calibration.calibrated_machine(), &readings, false).unwrap();
        let counts = verified.iter().map(|entry| entry.above_one());
        let (above, all) = counts.fold((0, 0), |(a, b), (c, d)| (a + c, b + d));
        above as f64 / all as f64
    });
    let shares: Vec<f64> = shares.collect();
    let count = f64::from(campaigns);
    let mean = shares.iter().sum::<f64>() / count;
    let squares: f64 = shares.iter().map(|share| (share - mean).powi(2)).sum();
    let standard_error = (squares / (count - 1.0) / count).sqrt();
    println!("{mean:.4} ± {standard_error:.4} beyond U in {campaigns} campaigns");
    (mean, standard_error)
}

/// The share scatters by 1.3 % between campaigns: that of four is above 7 % with a probability of 1e-3 if 5 % is right.
#[test]
fn readings_of_five_axes_are_inside_u() {
    let (mean, _) = share_beyond_u(4);
    assert!(mean < 0.07, "{mean}");
}

/// 95 % within three standard errors: missed by a right U with a probability of 0.1 %.
#[test]
#[ignore = "study: 100 calibrations of five axes"]
fn readings_of_five_axes_are_inside_u_in_100_campaigns() {
    let (mean, standard_error) = share_beyond_u(100);
    assert!(mean < 0.05 + 3.0 * standard_error, "{mean}");
}

/// A bar towards the axis does not see how far the stage turns: an error of ECC is no cause of what it reads, and cannot be. Without a
/// calibration the error curves of the stage are in the readings, over its angle, in a form that no effect has.
#[test]
fn a_bar_towards_the_axis_shows_no_rotation() {
    let settings = trueaxis_diagnose::Settings::default();
    let diagnosis = diagnose(&shipped("rotary-bars"), &settings).unwrap();
    for cause in &diagnosis.causes {
        let component = cause.effect.subject.component.unwrap();
        assert!(!component.is_angular(), "{component:?}");
    }
    let hidden = diagnosis.not_observable.iter();
    let hidden = hidden.filter(|n| n.effect == "cyclic_error" && n.subject.ends_with("ECC"));
    assert_eq!(hidden.count(), 2);
    let whose = diagnosis.disturbances.iter().map(|d| d.whose.varies_with);
    assert_eq!(whose.collect::<Vec<_>>(), [["position"]; 2]);
}

/// The files are what the program in `examples/verification.rs` makes.
#[test]
fn the_files_are_those_of_the_example() {
    let campaign = shipped("fxyz");
    let scenario = include_str!("../../../campaigns/fxyz/scenario.json");
    let truth = Scenario::from_json(scenario)
        .unwrap()
        .true_machine()
        .unwrap();
    let machine = calibrated();
    for (name, compensated_by) in [("fxyz-lines", None), ("fxyz-compensated", Some(&machine))] {
        let shipped = shipped(name);
        let made = verification_campaign(&campaign, &truth, compensated_by, &shipped.name).unwrap();
        for (a, b) in made.verification.iter().zip(&shipped.verification) {
            assert_eq!(a.readings.len(), b.readings.len());
            for (a, b) in a.readings.iter().zip(&b.readings) {
                // The estimates behind the compensation may differ in their last digits.
                assert!(
                    (a.value_um - b.value_um).abs() < 0.01,
                    "{name}: {a:?} {b:?}"
                );
                assert_eq!(a.positions, b.positions);
            }
        }
    }
}
