//! A rigid motion of the points moves the fit and nothing else.

use nalgebra::{Isometry3, Matrix3, Matrix6, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use trueaxis_fitting::{Line, fit_circle, fit_circle_two_step, fit_common_axis, fit_line};

use crate::coaxial_scene::{arcs, slices};

/// Coordinates of up to 3000 mm are rounded by 5e-13 mm; the arcs of 150 degrees raise that by
/// less than ten in position, and divide it by 100 mm in direction.
const POSITION_TOL_MM: f64 = 1e-11;
const DIRECTION_TOL: f64 = 1e-13;

/// Cofactors depend on the points by less than ten times their relative change of 1e-14.
const COFACTOR_TOL: f64 = 1e-12;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 64,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(20_240_601),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn motion() -> impl Strategy<Value = Isometry3<f64>> {
    let rotation = prop::array::uniform3(-2.0..2.0_f64);
    let shift = prop::array::uniform3(-2000.0..2000.0_f64);
    (rotation, shift).prop_map(|(rotation, shift)| {
        Isometry3::from_parts(
            Translation3::from(Vector3::from(shift)),
            UnitQuaternion::from_scaled_axis(Vector3::from(rotation)),
        )
    })
}

/// Disturbances of up to 0.1 mm: large against rounding, so that nothing is exact by accident.
fn disturbed_arcs() -> impl Strategy<Value = [Vec<Point3<f64>>; 3]> {
    let arcs = arcs(150_f64.to_radians());
    let count = arcs[0].len();
    let disturbance = prop::collection::vec(prop::array::uniform3(-0.1..0.1_f64), 3 * count);
    disturbance.prop_map(move |disturbance| {
        let mut disturbed = arcs.clone();
        for (p, d) in disturbed.iter_mut().flatten().zip(disturbance) {
            *p += Vector3::from(d);
        }
        disturbed
    })
}

fn moved(points: &[Point3<f64>], motion: &Isometry3<f64>) -> Vec<Point3<f64>> {
    points.iter().map(|p| motion * p).collect()
}

/// `motion`'s rotation on each of the two vectors of a line.
fn rotation6(motion: &Isometry3<f64>) -> Matrix6<f64> {
    let rotation: Matrix3<f64> = motion.rotation.to_rotation_matrix().into_inner();
    let mut both = Matrix6::zeros();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    both
}

fn assert_moved_line(line: &Line, moved: &Line, motion: &Isometry3<f64>) {
    assert!((motion * line.point_mm - moved.point_mm).norm() < POSITION_TOL_MM);
    let turned = motion * line.direction.into_inner();
    assert!((turned - moved.direction.into_inner()).norm() < DIRECTION_TOL);
    let rotation = rotation6(motion);
    let expected = rotation * line.cofactor * rotation.transpose();
    assert!((expected - moved.cofactor).norm() < COFACTOR_TOL * expected.norm());
    assert!((line.scatter.rms_mm - moved.scatter.rms_mm).abs() < POSITION_TOL_MM);
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn line_moves_with_its_points(arcs in disturbed_arcs(), motion in motion()) {
        let points = arcs[0].as_slice();
        let [before, after] = [points, &moved(points, &motion)].map(|p| fit_line(p).unwrap());
        assert_moved_line(&before, &after, &motion);
    }

    #[test]
    fn circles_move_with_their_points(arcs in disturbed_arcs(), motion in motion()) {
        let points = arcs[0].as_slice();
        for fit in [fit_circle, fit_circle_two_step] {
            let [before, after] = [points, &moved(points, &motion)].map(|p| fit(p).unwrap());
            assert!((motion * before.center_mm - after.center_mm).norm() < POSITION_TOL_MM);
            let turned = motion * before.normal.into_inner();
            assert!((turned - after.normal.into_inner()).norm() < DIRECTION_TOL);
            assert!((before.radius_mm - after.radius_mm).abs() < POSITION_TOL_MM);
        }
    }

    #[test]
    fn common_axis_moves_with_its_points(arcs in disturbed_arcs(), motion in motion()) {
        let moved_arcs = arcs.each_ref().map(|arc| moved(arc, &motion));
        let [before, after] = [&arcs, &moved_arcs].map(|arcs| fit_common_axis(&slices(arcs)).unwrap());
        assert_moved_line(&before.axis, &after.axis, &motion);
        for (before, after) in before.circles.iter().zip(&after.circles) {
            assert!((motion * before.center_mm - after.center_mm).norm() < POSITION_TOL_MM);
            assert!((before.radius_mm - after.radius_mm).abs() < POSITION_TOL_MM);
        }
    }

    /// Turned round, a line has the opposite direction and the covariance that goes with it.
    #[test]
    fn reversed_line_is_the_line_of_the_points_in_reverse(arcs in disturbed_arcs()) {
        let mut reversed_arcs = arcs.clone();
        for arc in &mut reversed_arcs {
            arc.reverse();
        }
        let forwards = fit_common_axis(&slices(&arcs)).unwrap();
        let backwards = fit_common_axis(&slices(&reversed_arcs)).unwrap();
        assert_moved_line(&forwards.axis.reversed(), &backwards.axis, &Isometry3::identity());
    }
}
