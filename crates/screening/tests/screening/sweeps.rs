//! What changes along a sweep: lost motion is no scatter, and what slips or drifts is no noise.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::{Network, Whitened, solve};
use trueaxis_screening::{Screened, Sweep, slow, uneven_axes};

use crate::gross_errors::NOISE;
use crate::world::*;

const REPEATS: usize = 4;

/// Four sweeps over all steps, there and back; what stands still at a step is displaced by this in a sweep, mm.
fn displaced(seed: u64, by_mm: impl Fn(usize, usize, usize) -> Vector3<f64>) -> Network {
    let truth = truth(50.0);
    let mut network = network(&truth, truth.points.clone(), REPEATS, NOISE);
    let groups = network.groups.len();
    for (number, visit) in network.visits.iter_mut().enumerate() {
        if number / groups % 2 == 1 {
            visit.group = groups - 1 - visit.group;
        }
    }
    add_noise(&mut network, &truth, &mut ChaCha8Rng::seed_from_u64(seed));
    for (number, visit) in network.visits.iter().enumerate() {
        let sweep = number / groups;
        for reading in &mut network.readings[visit.readings.clone()] {
            let place = truth.points[3 * visit.group + reading.point];
            let beam = (place - truth.stations[visit.station].0).normalize();
            reading.length_mm += beam.dot(&by_mm(visit.group, sweep, reading.point));
        }
    }
    tied(&network)
}

/// Nine steps along each axis.
const STEPS: usize = 9;

/// Lost motion of 0 at one end of an axis and of 16 µm at the other, from both sides in turn.
fn worn(group: usize, sweep: usize, _point: usize) -> Vector3<f64> {
    let side = if sweep % 2 == 1 { -1e-3 } else { 1e-3 };
    let along = if group < STEPS { group as f64 } else { 0.0 };
    Vector3::new(side * along, 0.0, 0.0)
}

/// How much more such an axis moves from step to step was taken for a repeatability that is worse than that of the others.
#[test]
fn lost_motion_that_changes_along_an_axis_is_no_scatter() {
    let told = |network: &Network| {
        let solution = solve(network).unwrap();
        let starts = (0..network.visits.len()).step_by(STEPS);
        let sweep = |first: usize| Sweep {
            axis: network.visits[first].group / STEPS,
            visits: (first..first + STEPS).collect(),
        };
        let sweeps: Vec<Sweep> = starts.map(sweep).collect();
        uneven_axes(network, &solution, (3, &sweeps), false)
    };
    for seed in 1..4 {
        assert_eq!(told(&displaced(seed, worn)), None, "seed {seed}");
        let scatters = |group: usize, sweep: usize, _: usize| {
            let wave = |k: f64| 4e-3 * (k * (group * 97 + sweep * 31) as f64).sin();
            match group < STEPS {
                true => Vector3::new(wave(1.3), wave(2.1), wave(2.9)),
                false => Vector3::zeros(),
            }
        };
        let ratios = told(&displaced(seed, scatters)).unwrap();
        assert!(ratios[0] > 2.0 * ratios[1], "seed {seed}: {ratios:?}");
    }
}

/// 8 µm of the second target from the third station on.
fn slipped(_group: usize, sweep: usize, point: usize) -> Vector3<f64> {
    match point == 1 && sweep >= 2 * REPEATS {
        true => Vector3::new(5e-3, -4e-3, 5e-3),
        false => Vector3::zeros(),
    }
}

/// A slip is found, and of how far; lost motion is none. A clean network is said to have one in a thousand times.
#[test]
fn a_target_that_slipped_is_found() {
    let slips = |network: &Network| Screened::plain(network, true).unwrap().slips();
    for seed in 1..4 {
        let found = slips(&displaced(seed, slipped)).unwrap();
        let slip = found.targets[0];
        assert_eq!(
            (found.targets.len(), slip.place),
            (1, (0, 1)),
            "seed {seed}"
        );
        let error_mm = slip.moved_mm.norm() - 66e-6_f64.sqrt();
        assert!(error_mm.abs() < 4.0 * slip.u_mm, "seed {seed}: {slip:?}");
        assert!(slips(&displaced(seed, worn)).is_none(), "seed {seed}");
        let clean = displaced(seed, |_, _, _| Vector3::zeros());
        assert!(slips(&clean).is_none(), "seed {seed}");
    }
}

/// A target that slipped by 8 µm between two stations leaves misfits that are alike from step to step: a sum over the steps of a run
/// scatters more than one of noise, and than one of lost motion, which repeats.
#[test]
fn what_slipped_is_alike_from_step_to_step() {
    let runs: Vec<Vec<usize>> = (0..3)
        .map(|axis| (STEPS * axis..STEPS * (axis + 1)).collect())
        .collect();
    let told = |network: &Network| {
        let rows = Whitened::of_visits(network, &solve(network).unwrap());
        slow(network, &rows, &runs)
    };
    for seed in 1..4 {
        let slow = told(&displaced(seed, slipped)).unwrap();
        assert!(slow.correlation > 0.3, "seed {seed}: {slow:?}");
        assert!(slow.ratio > 2.0, "seed {seed}: {slow:?}");
        assert_eq!(told(&displaced(seed, |_, _, _| Vector3::zeros())), None);
        assert_eq!(told(&displaced(seed, worn)), None, "seed {seed}");
    }
}
