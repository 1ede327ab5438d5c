//! A rotary axis that stops at a different angle each time.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_kinematics::{ARCSEC, AxisKind, Ideal};
use trueaxis_simulate::{Scenario, Simulated, simulate};
use trueaxis_tests::components;

const SCENARIO: &str = include_str!("../../../campaigns/five-axis/scenario.json");

/// Turns what axis C carries by another angle at each stop of its run.
fn turn(simulated: &mut Simulated, sigma_arcsec: f64, seed: u64) {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let campaign = &mut simulated.campaign;
    let machine = &campaign.machine;
    let lengths = campaign.lengths.as_mut().unwrap();
    for stop in &lengths.stops {
        let step = &campaign.steps[stop.step];
        let axis = &machine.axes()[campaign.runs[step.run.unwrap()].axis];
        if axis.kind() != AxisKind::Rotary || axis.name() != "C" {
            continue;
        }
        let normal: f64 = StandardNormal.sample(&mut generator);
        let turn = axis.direction().into_inner() * normal * sigma_arcsec * ARCSEC;
        let station_mm = simulated.truth.stations[stop.station].position_mm;
        for reading in &mut lengths.readings[stop.readings.clone()] {
            let target = &campaign.targets[reading.target];
            let point_mm = machine.motion(&Ideal, target.carrier, &step.positions) * target.home_mm;
            let moved = turn.cross(&(point_mm - axis.point_mm()));
            reading.length_mm += (point_mm - station_mm).normalize().dot(&moved);
        }
    }
}

/// Makes one length of a hundred wrong by 0.05 to 5 mm, and says how many.
fn spoil(simulated: &mut Simulated) -> usize {
    let readings = &mut simulated.campaign.lengths.as_mut().unwrap().readings;
    let wrong = readings.iter_mut().skip(13).step_by(97).enumerate();
    let sizes = wrong.map(|(k, reading)| {
        reading.length_mm += [0.05, -0.4, 5.0, 0.1, -2.0][k % 5];
    });
    sizes.count()
}

/// Whole stops left as gross errors until the rest agreed, and of those that stayed U lacked the angle: with 5″ ECC was wrong by 8″,
/// twenty stated uncertainties; so it was in three of 15 such campaigns with 4″ beside gross errors, which hid the angle. With 15″ all were
/// refused: beside so much angle the residuals show no displacement. One of some 3,000 values is beyond 5.5 u with a probability below 0.001.
#[test]
fn no_stop_of_a_table_that_returns_badly_is_a_gross_error() {
    let scenario = SCENARIO.replace("\"lost_motion_arcsec\": 4.2", "\"lost_motion_arcsec\": 0.0");
    let scenario = Scenario::from_json(&scenario).unwrap();
    for (seed, sigma_arcsec, gross) in [
        (1, 2.0, false),
        (2, 5.0, false),
        (3, 5.0, false),
        (4, 4.0, true),
        (5, 4.0, true),
        (6, 15.0, false),
    ] {
        let mut simulated = simulate(&scenario, seed).unwrap();
        turn(&mut simulated, sigma_arcsec, seed);
        let wrong = if gross { spoil(&mut simulated) } else { 0 };
        let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
        let removed = calibration.adjustment.rejected.len();
        assert!(
            removed < wrong + 5,
            "seed {seed}: {removed} lengths left, {wrong} wrong"
        );
        let mut notices = calibration.notices.iter();
        assert!(notices.any(|notice| notice.starts_with("axis C: it stops at a different angle")));
        for deviation in components(&calibration, &simulated.truth) {
            let is_defined = deviation.is_inside().is_none();
            let is_near = is_defined || deviation.error.abs() < 5.5 * deviation.u;
            assert!(is_near, "seed {seed}: {deviation:?}");
        }
    }
}
