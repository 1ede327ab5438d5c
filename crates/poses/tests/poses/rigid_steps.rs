//! Steps whose targets do not move as a rigid triangle, and those where a station does not see one of them.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Lengths;
use trueaxis_poses::{Method, Settings, measure};
use trueaxis_simulate::{Scenario, Simulated, simulate};

/// Campaigns with two repeats of a three-axis machine, whose first target the first station does not see. The others
/// and the target are in one plane in the midst of a run, so that lengths hardly tell where it is there.
fn hidden(seed: u64) -> Simulated {
    let text = include_str!("../../../../campaigns/fxyz/scenario.json");
    let mut scenario = Scenario::from_json(text).unwrap();
    scenario.repeats = 2;
    scenario.stations[3].position_mm[2] = 41.0;
    let mut simulated = simulate(&scenario, seed).unwrap();
    let lengths = simulated.campaign.lengths.as_mut().unwrap();
    let old = std::mem::take(lengths);
    *lengths = Lengths {
        logged: old.logged,
        ..Lengths::default()
    };
    for mut stop in old.stops {
        let first = lengths.readings.len();
        let readings = old.readings[stop.readings.clone()].iter();
        let seen = readings.filter(|reading| stop.station != 0 || reading.target != 0);
        lengths.readings.extend(seen.cloned());
        stop.readings = first..lengths.readings.len();
        lengths.stops.push(stop);
    }
    simulated
}

/// The second target was elsewhere at this step, mm.
const STEP: usize = 30;
const ELSEWHERE_MM: Vector3<f64> = Vector3::new(0.004, -0.002, 0.004);

fn move_target(simulated: &mut Simulated, by_mm: Vector3<f64>) {
    let campaign = &mut simulated.campaign;
    let positions = &campaign.steps[STEP].positions;
    let place = campaign.targets[1].home_mm + Vector3::from_column_slice(positions);
    let lengths = campaign.lengths.as_mut().unwrap();
    for stop in lengths.stops.iter().filter(|stop| stop.step == STEP) {
        let station: Point3<f64> = simulated.truth.stations[stop.station].position_mm;
        let beam = (place - station).normalize();
        for reading in &mut lengths.readings[stop.readings.clone()] {
            if reading.target == 1 {
                reading.length_mm += beam.dot(&by_mm);
            }
        }
    }
}

/// One clean campaign in a hundred has a step that is not rigid by chance: more than three of forty have a probability
/// of 8e-4. A target that was off by 6 µm, most of which is a motion of the whole, is found in nearly all; the seeds are fixed.
/// Compared with the shape of its run, but with the noise of one of all runs, 24 of the forty clean ones failed.
#[test]
fn a_target_that_a_station_does_not_see_is_no_misfit() {
    const CAMPAIGNS: u64 = 40;
    let misfits = |simulated: &Simulated, method: Method| {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        measure(&simulated.campaign, &settings).unwrap().misfits
    };
    let (mut alarms, mut found, mut others) = (0, 0, 0);
    for seed in 1..=CAMPAIGNS {
        let mut simulated = hidden(seed);
        alarms += usize::from(!misfits(&simulated, Method::Joint).is_empty());
        if seed > CAMPAIGNS / 2 {
            continue;
        }
        move_target(&mut simulated, ELSEWHERE_MM);
        let failing = misfits(&simulated, Method::Joint);
        let moved = failing
            .iter()
            .filter(|m| m.step.starts_with("run y at X = 0 mm, Y = 140 mm"));
        let moved = moved.count();
        found += usize::from(moved == 1);
        others += usize::from(failing.len() > moved);
    }
    println!("{alarms} alarms of {CAMPAIGNS}, {found} moved targets found, {others} others");
    assert!(alarms <= 3, "{alarms}");
    assert!(found >= 18, "{found}");
    assert!(others <= 3, "{others}");
}

/// It is one test, whatever makes the poses, and however far the target was off.
#[test]
fn a_target_that_was_far_off_makes_no_other_step_fail() {
    let text = include_str!("../../../../campaigns/fxyz/scenario.json");
    let mut simulated = simulate(&Scenario::from_json(text).unwrap(), 3).unwrap();
    move_target(&mut simulated, Vector3::new(0.0, 0.02, 0.0));
    for (method, robust) in [
        (Method::Joint, true),
        (Method::Joint, false),
        (Method::Nine, true),
    ] {
        let settings = Settings {
            method,
            robust,
            ..Settings::default()
        };
        let found = measure(&simulated.campaign, &settings).unwrap().misfits;
        assert_eq!(found.len(), 1, "{method:?} {robust}: {found:?}");
        assert!(found[0].step.contains("Y = 140 mm"), "{found:?}");
    }
}
