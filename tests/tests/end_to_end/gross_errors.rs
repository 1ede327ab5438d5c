//! Gross errors and interrupted beams through the whole calibration.

use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::{Calibration, Error, Settings, calibrate};
use trueaxis_campaign::Campaign;
use trueaxis_poses::Error as Poses;
use trueaxis_simulate::{Scenario, Simulated, simulate};
use trueaxis_tests::{Deviation, Scatter, components, locations};

use crate::round_trip::SHIPPED;

/// Some per cent of the lengths wrong by 0.02 to 5 mm, evenly in the logarithm; which lines.
fn spoil(campaign: &mut Campaign, per_cent: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
    let readings = &mut campaign.lengths.as_mut().unwrap().readings;
    let count = per_cent * readings.len() / 100;
    let wrong = sample(rng, readings.len(), count).into_vec();
    for &i in &wrong {
        let size_mm = 0.02 * 250_f64.powf(rng.random());
        readings[i].length_mm += if rng.random::<bool>() {
            size_mm
        } else {
            -size_mm
        };
    }
    wrong.iter().map(|&i| readings[i].line).collect()
}

/// Component and location errors within five of their standard uncertainties: with some 400 numbers
/// of a campaign one is outside by chance with a probability of 2e-4.
fn assert_harmless(name: &str, calibration: &Calibration, simulated: &Simulated) {
    let mut all = components(calibration, &simulated.truth);
    all.extend(locations(calibration, &simulated.truth));
    for d in all.iter().filter(|d| d.is_inside().is_some()) {
        let Deviation {
            name: what,
            error,
            u,
            ..
        } = d;
        assert!(error.abs() < 5.0 * u, "{name}: {what}: {error:e}, u {u:e}");
    }
}

/// 540 wrong lengths in twelve campaigns: all are found. The smallest is wrong by 7 times what is found with
/// 80 % power, so none is missed by chance; good lengths leave at a family-wise 1 %, in three of a
/// scenario's six campaigns with a probability of 2e-5.
#[test]
fn three_per_cent_of_gross_errors_do_no_harm() {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    for (name, text) in [SHIPPED[0], SHIPPED[2]] {
        let scenario = Scenario::from_json(text).unwrap();
        let (mut all, mut missed, mut false_alarms) = (0, 0, 0);
        let mut scatter = Scatter::default();
        for seed in 0..6 {
            let mut simulated = simulate(&scenario, seed).unwrap();
            let wrong = spoil(&mut simulated.campaign, 3, &mut rng);
            let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
            assert_harmless(name, &calibration, &simulated);
            scatter.add(&calibration, &simulated.truth);
            let found: Vec<usize> = calibration
                .adjustment
                .rejected
                .iter()
                .map(|r| r.line)
                .collect();
            all += wrong.len();
            missed += wrong.iter().filter(|line| !found.contains(line)).count();
            false_alarms += found.iter().filter(|line| !wrong.contains(line)).count();
            assert!(calibration.adjustment.interruptions.is_empty(), "{name}");
        }
        println!(
            "{name}: {all} gross errors, {missed} missed, {false_alarms} good lengths removed; {}",
            scatter.pooled(|d| d.kind.is_of_machine())
        );
        assert_eq!(missed, 0, "{name}: of {all}");
        assert!(false_alarms <= 2, "{name}");
    }
}

#[test]
fn ten_per_cent_are_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    for (name, text) in [SHIPPED[0], SHIPPED[2]] {
        let scenario = Scenario::from_json(text).unwrap();
        let mut simulated = simulate(&scenario, 1).unwrap();
        spoil(&mut simulated.campaign, 10, &mut rng);
        let error = calibrate(&simulated.campaign, &Settings::default()).unwrap_err();
        println!("{name}: {error}");
        assert!(
            matches!(error, Error::Poses(Poses::NotTrustworthy { .. })),
            "{name}: {error}"
        );
    }
}

/// One interruption in the occupation of every station, from 5 µm to 5 mm.
#[test]
fn an_interruption_of_every_station_does_no_harm() {
    let mut rng = ChaCha8Rng::seed_from_u64(33);
    for (name, text) in [SHIPPED[0], SHIPPED[2]] {
        let scenario = Scenario::from_json(text).unwrap();
        for (seed, change_mm) in [(1, 0.005), (2, 0.05), (3, 0.5), (4, 5.0)] {
            let mut simulated = simulate(&scenario, seed).unwrap();
            let stations = simulated.campaign.stations.len();
            let lengths = simulated.campaign.lengths.as_mut().unwrap();
            for station in 0..stations {
                let occupation: Vec<usize> = lengths
                    .stops
                    .iter()
                    .filter(|stop| stop.station == station)
                    .flat_map(|stop| stop.readings.clone())
                    .collect();
                let after = rng.random_range(occupation.len() / 5..4 * occupation.len() / 5);
                for &i in &occupation[after..] {
                    lengths.readings[i].length_mm += change_mm;
                }
            }
            let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
            let found = &calibration.adjustment.interruptions;
            let sizes: Vec<f64> = found
                .iter()
                .map(|occupation| occupation.change_mm)
                .collect();
            println!(
                "{name}: {change_mm} mm: {sizes:.4?}, {} removed",
                calibration.adjustment.rejected.len()
            );
            assert_eq!(found.len(), stations, "{name}: {change_mm} mm");
            for occupation in found {
                // A displacement changes the lengths by more or less in other directions.
                assert!(
                    !(occupation.tripod_may_have_moved && change_mm > 0.1),
                    "{name}: {occupation:?}"
                );
                assert!(
                    (occupation.change_mm - change_mm).abs() < 5.0 * occupation.u_mm,
                    "{name}: {occupation:?}"
                );
            }
            assert_harmless(name, &calibration, &simulated);
        }
    }
}
