//! A rigid motion of the points moves the fit and nothing else.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use trueaxis_fitting::{Line, fit_common_axis, fit_line};

use crate::coaxial_scene::{arcs, slices};

/// Coordinates of up to 3000 mm are rounded by 5e-13 mm; the arcs of 150 degrees raise that by
/// less than ten in position, and divide it by 100 mm in direction.
const POSITION_TOL_MM: f64 = 1e-11;
const DIRECTION_TOL: f64 = 1e-13;

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

fn assert_moved_line(line: &Line, moved: &Line, motion: &Isometry3<f64>) {
    assert!((motion * line.point_mm - moved.point_mm).norm() < POSITION_TOL_MM);
    let turned = motion * line.direction.into_inner();
    assert!((turned - moved.direction.into_inner()).norm() < DIRECTION_TOL);
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
    fn common_axis_moves_with_its_points(arcs in disturbed_arcs(), motion in motion()) {
        let moved_arcs = arcs.each_ref().map(|arc| moved(arc, &motion));
        let [before, after] = [&arcs, &moved_arcs].map(|arcs| fit_common_axis(&slices(arcs)).unwrap());
        assert_moved_line(&before.axis, &after.axis, &motion);
        for (before, after) in before.circles.iter().zip(&after.circles) {
            assert!((motion * before.center_mm - after.center_mm).norm() < POSITION_TOL_MM);
            assert!((before.radius_mm - after.radius_mm).abs() < POSITION_TOL_MM);
        }
    }
}
