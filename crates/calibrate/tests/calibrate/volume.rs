//! The volumetric error over the volume; that its intervals hold the truth is tested across the crates.

use nalgebra::Point3;
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_kinematics::{MICROMETRE, MotionError};
use trueaxis_predict::{CalibratedMachine, Volume, VolumeSettings};

use crate::{simulated, two_branches};

fn machine() -> CalibratedMachine {
    let campaign = simulated(&two_branches());
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    calibration.calibrated_machine()
}

fn settings(points: usize) -> VolumeSettings {
    VolumeSettings {
        points,
        tool_home_mm: Point3::new(100.0, 50.0, 300.0),
        draws: 50,
        seed: 1,
    }
}

/// Displacement less that at home, in µm.
fn zeroed_um(machine: &CalibratedMachine, volume: &Volume, at: &[f64]) -> f64 {
    let of = |at: &[f64]| {
        let error = machine.predict(at, volume.places.tool_home_mm).error;
        error.translation_mm
    };
    (of(at) - of(&[0.0; 3])).norm() / MICROMETRE
}

#[test]
fn figures_are_those_of_the_places() {
    let machine = machine();
    let volume = machine.volume(&settings(7));
    // X and Y make the grid, C is spread over its steps, as often as a third axis would make nodes.
    assert_eq!(volume.places.nodes(), [7, 7, 1]);
    assert_eq!(volume.places.count(), 343);
    let all = (0..343).map(|i| zeroed_um(&machine, &volume, &volume.places.at(i)));
    let mut all: Vec<f64> = all.collect();
    let sizes = volume.figures.zeroed_at_home;
    let rms = (all.iter().map(|e| e * e).sum::<f64>() / 343.0).sqrt();
    all.sort_by(f64::total_cmp);
    for (found, expected) in [
        (sizes.rms, rms),
        (sizes.p95, all[325]),
        (sizes.max, all[342]),
    ] {
        assert!((found.value / MICROMETRE - expected).abs() < 1e-9);
        let [low, high] = found.drawn.unwrap().interval;
        assert!(low < high, "{found:?}");
    }
    let worst = zeroed_um(&machine, &volume, &volume.worst);
    assert!((worst - all[342]).abs() < 1e-9);
    let shares: f64 = volume.shares.iter().map(|(_, share)| share).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    // Six components of three axes, C0Y, and five of C.
    assert_eq!(volume.shares.len(), 18 + 1 + 5, "{:?}", volume.shares);
    // A best fit leaves less than a zero at home.
    assert!(volume.figures.best_fit.rms.value < sizes.rms.value);
}

#[test]
fn the_map_has_the_other_axes_at_home() {
    let machine = machine();
    let volume = machine.volume(&settings(4));
    let map = volume.map(&machine);
    assert_eq!(map.len(), 16);
    for (number, error) in map.iter().enumerate() {
        let at = volume.places.at_node(number);
        assert!(at[2].abs() < f64::MIN_POSITIVE);
        let size = error.translation_mm.norm() / MICROMETRE;
        assert!((size - zeroed_um(&machine, &volume, &at)).abs() < 1e-9);
    }
    let csv = volume.map_csv(&machine, &map);
    assert!(csv.starts_with("X,Y,C,ex_um,ey_um,ez_um,ea_arcsec,eb_arcsec,ec_arcsec\n"));
    assert_eq!(csv.lines().count(), 17);
    let vti = volume.map_vti(&map);
    assert!(vti.contains("WholeExtent=\"0 3 0 3 0 0\""), "{vti}");
    let numbers = vti.lines().filter(|line| line.split(' ').count() == 3);
    let numbers: Vec<&str> = numbers.filter(|line| !line.contains('<')).collect();
    assert_eq!(numbers.len(), 32);
    // x runs fastest: the second vector is that of the second node along X.
    let MotionError {
        translation_mm: e, ..
    } = map[1];
    let first: f64 = numbers[1].split(' ').next().unwrap().parse().unwrap();
    assert!((first - e.x / MICROMETRE).abs() < 1e-3);
    assert!(volume.places.at_node(1)[0] > 0.0 && volume.places.at_node(4)[1] > 0.0);
}

#[test]
fn a_seed_gives_the_same_figures() {
    let machine = machine();
    let [a, b] = [1, 1].map(|_| machine.volume(&settings(5)).to_json(&machine));
    assert_eq!(a, b);
    let other = VolumeSettings {
        seed: 2,
        ..settings(5)
    };
    assert_ne!(a, machine.volume(&other).to_json(&machine));
}
