//! What the base model can take has no strength.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::MICROMETRE;

use super::{kinds, smallest};
use crate::blind::Kind;
use crate::blind::experiment::Experiment;
use crate::blind::projection::Projection;
use crate::blind::setup::Setup;

/// No station is nearer to a target, mm: stations are 900 mm or more from the middle of points that
/// are up to 610 mm from it.
const NEAR_MM: f64 = 290.0;

/// A change that moves stations and targets against each other by `moved_mm` changes lengths by that
/// to first order, which must be absorbed, and to second order by its square over twice the distance,
/// which may be left: each length has at least its own noise for its weight.
fn assert_absorbed(kinds: &[Kind], moved_mm: f64, change: impl Fn(&mut Setup)) {
    for (kind, seed) in kinds.iter().zip(0..) {
        let mut experiment = Experiment::new(kind, seed);
        let projection = Projection::new(&experiment);
        let before = experiment.exact_mm(&[]);
        change(&mut experiment.setup);
        let after = experiment.exact_mm(&[]);
        let changes = after.iter().zip(&before).map(|(a, b)| a - b);
        let changes: Vec<f64> = changes.collect();
        let largest = changes.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
        assert!(
            (0.01 * moved_mm..moved_mm).contains(&largest),
            "{kind:?}: lengths change by {largest} mm"
        );
        let second_order = moved_mm.powi(2) / (2.0 * NEAR_MM) / (kind.noise.length_um * MICROMETRE);
        let bound = second_order * (changes.len() as f64).sqrt();
        let left = projection.residuals(&changes).norm();
        assert!(
            left < bound,
            "{kind:?}: {left:e} is left, at most {bound:e}"
        );
    }
}

fn assert_set_up_is_absorbed(kinds: &[Kind]) {
    assert_absorbed(kinds, 1.01e-3, |setup| setup.dead_paths_mm[2] += 1e-3);
    for station in 0..4 {
        let shift = Vector3::new(0.8e-3, -0.7e-3, 0.5e-3);
        assert_absorbed(kinds, 1.2e-3, |setup| setup.stations_mm[station] += shift);
    }
    for target in 0..3 {
        let shift = Vector3::new(-0.7e-3, 0.8e-3, 0.4e-3);
        assert_absorbed(kinds, 1.2e-3, |setup| setup.homes_mm[target] += shift);
    }
    // All stations turn together.
    assert_absorbed(kinds, 3e-3, |setup| {
        let turn = |p: &mut Point3<f64>| p.coords += Vector3::new(1e-6, 0.0, 1e-6).cross(&p.coords);
        setup.stations_mm.iter_mut().for_each(turn);
    });
}

/// Every axis gets another tilt, and the curves of the next one.
fn assert_axes_are_absorbed(kinds: &[Kind]) {
    assert_absorbed(kinds, 0.05, |setup| {
        for axis in &mut setup.errors.axes {
            axis.location.tilt_rad += Vector3::new(5e-6, 5e-6, 5e-6);
        }
    });
    assert_absorbed(kinds, 0.05, |setup| {
        let axes = &mut setup.errors.axes;
        let locations: Vec<_> = axes.iter().map(|axis| axis.location).collect();
        axes.rotate_left(1);
        for (axis, mut location) in axes.iter_mut().zip(locations) {
            location.tilt_rad.y += 1e-5;
            axis.location = location;
        }
    });
}

/// A pose has six parameters for the twelve lengths and more of a step.
fn assert_a_reading_is_left(kinds: &[Kind]) {
    for kind in kinds {
        let experiment = Experiment::new(kind, 3);
        let projection = Projection::new(&experiment);
        let mut change = vec![0.0; experiment.schedule.readings()];
        change[7] = 0.269e-3;
        let left = projection.residuals(&change).norm();
        assert!((0.15..1.0).contains(&left), "{left}");
    }
}

#[test]
fn the_base_model_absorbs_set_up_and_axes_but_no_single_reading() {
    assert_set_up_is_absorbed(&smallest());
    assert_axes_are_absorbed(&smallest());
    assert_a_reading_is_left(&smallest());
}

#[test]
#[ignore = "study: 84 numerical Jacobians"]
fn the_base_model_absorbs_the_same_of_all_kinds() {
    assert_set_up_is_absorbed(&kinds());
    assert_axes_are_absorbed(&kinds());
    assert_a_reading_is_left(&kinds());
}
