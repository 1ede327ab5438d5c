//! What must not matter: the names of the targets, the frame, the reference point, the number of
//! targets.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use trueaxis_identify::{SixRows, equations, nine};
use trueaxis_kinematics::MotionError;

use crate::targets::{condition_number, displacement, is_blind, reach, relative_difference};

fn vector(limit: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-limit..limit).prop_map(Vector3::from)
}

/// As on a machine: no angle of the triangle is small, some 100 mm to 1 m from the origin.
fn targets() -> impl Strategy<Value = [Vector3<f64>; 3]> {
    let corner = vector(500.0);
    let jitter = prop::array::uniform3(vector(40.0));
    (corner, jitter).prop_map(|(corner, [p, q, k])| {
        [
            corner + p,
            corner + q + Vector3::new(200.0, 10.0, 90.0),
            corner + k + Vector3::new(30.0, 220.0, -100.0),
        ]
    })
}

fn volumetric_errors() -> impl Strategy<Value = [Vector3<f64>; 3]> {
    prop::array::uniform3(vector(1e-2))
}

fn rotation() -> impl Strategy<Value = UnitQuaternion<f64>> {
    vector(3.0).prop_map(UnitQuaternion::from_scaled_axis)
}

/// The errors agree within the rounding of a least squares solution, `EPSILON * condition²`.
fn same(found: &MotionError, expected: &MotionError, r: &[Vector3<f64>; 3]) -> bool {
    let reach = reach(r);
    let mut scaled = equations(r);
    scaled.fixed_columns_mut::<3>(3).unscale_mut(reach);
    let singular_values = scaled.singular_values();
    let condition = singular_values.max() / singular_values.min();
    let translation = (found.translation_mm - expected.translation_mm).norm();
    let rotation = (found.rotation_rad - expected.rotation_rad).norm();
    let largest_delta_mm = 1e-2;
    translation + reach * rotation < f64::EPSILON * condition * condition * largest_delta_mm
}

fn turned(by: &UnitQuaternion<f64>, error: &MotionError) -> MotionError {
    MotionError::new(by * error.translation_mm, by * error.rotation_rad)
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: RngSeed::Fixed(21),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn names_of_the_targets_do_not_matter(
        r in targets(),
        delta in volumetric_errors(),
        order in Just([0, 1, 2]).prop_shuffle(),
    ) {
        let expected = nine(&r).unwrap().apply(&delta);
        let renamed = order.map(|j| r[j]);
        let found = nine(&renamed).unwrap().apply(&order.map(|j| delta[j]));
        prop_assert!(same(&found, &expected, &r));

        // Row 3j + i of the renamed targets is row 3 order[j] + i of the old ones.
        for rows in SixRows::all().filter(|rows| !is_blind(*rows)) {
            let mut old = rows.rows().map(|row| 3 * order[row / 3] + row % 3);
            let old = SixRows::new([(); 6].map(|()| old.next().unwrap())).unwrap();
            let expected = old.operator(&r).unwrap().apply(&delta);
            let found = rows.operator(&renamed).unwrap().apply(&order.map(|j| delta[j]));
            let difference = relative_difference(&found, &expected, reach(&r));
            prop_assert!(difference < 2.0 * f64::EPSILON * condition_number(old, &r));
        }
    }

    #[test]
    fn frame_does_not_matter(r in targets(), delta in volumetric_errors(), by in rotation()) {
        let expected = turned(&by, &nine(&r).unwrap().apply(&delta));
        let found = nine(&r.map(|r| by * r)).unwrap().apply(&delta.map(|d| by * d));
        prop_assert!(same(&found, &expected, &r));
    }

    /// `δ` at `s` is `δ + ε × s`.
    #[test]
    fn reference_point_moves_only_the_translation(
        r in targets(),
        delta in volumetric_errors(),
        s in vector(500.0),
    ) {
        let error = nine(&r).unwrap().apply(&delta);
        let expected = MotionError::new(displacement(&error, &s), error.rotation_rad);
        let found = nine(&r.map(|r| r - s)).unwrap().apply(&delta);
        prop_assert!(same(&found, &expected, &r));
    }

    /// A fourth target where the fit of three puts it does not change the fit.
    #[test]
    fn agreeing_fourth_target_changes_nothing(
        r in targets(),
        delta in volumetric_errors(),
        fourth in vector(500.0),
    ) {
        let expected = nine(&r).unwrap().apply(&delta);
        let four = [r[0], r[1], r[2], fourth];
        let delta = [delta[0], delta[1], delta[2], displacement(&expected, &fourth)];
        let operator = nine(&four).unwrap();
        prop_assert!(same(&operator.apply(&delta), &expected, &r));
        prop_assert!(operator.residual_mm(&delta)[3].norm() < 1e-14);
    }
}
