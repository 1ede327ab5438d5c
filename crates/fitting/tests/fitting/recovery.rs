//! Exact data are recovered, and data that hold no answer are refused with numbers.

use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_fitting::{Error, fit_common_axis};

use crate::coaxial_scene::{TARGETS, arcs, axis_direction, axis_point, slices};

/// Coordinates of up to 1000 mm are rounded by 6e-14 mm each; twice that for the sines that made them. Six times what
/// linear propagation makes of it for three arcs of 60 degrees.
const POSITION_TOL_MM: f64 = 1e-12;
const DIRECTION_TOL: f64 = 5e-15;

#[test]
fn common_axis_of_three_arcs_of_60_degrees() {
    for (sweep_deg, sense) in [(60.0_f64, 1.0), (60.0, -1.0), (360.0, 1.0)] {
        let arcs = arcs(sense * sweep_deg.to_radians());
        let found = fit_common_axis(&slices(&arcs)).unwrap();
        assert!(found.termination.is_converged(), "{:?}", found.termination);

        let direction = axis_direction().into_inner() * sense;
        let shift = (found.axis.point_mm - axis_point())
            .cross(&direction)
            .norm();
        let tilt = (found.axis.direction.into_inner() - direction).norm();
        assert!(
            shift < POSITION_TOL_MM,
            "{sweep_deg}: axis is off by {shift:e}"
        );
        assert!(tilt < DIRECTION_TOL, "{sweep_deg}: tilt {tilt:e}");
        for (circle, (radius, height, _)) in found.circles.iter().zip(TARGETS) {
            assert!((circle.radius_mm - radius).abs() < POSITION_TOL_MM);
            let center = axis_point() + axis_direction().into_inner() * height;
            assert!((circle.center_mm - center).norm() < 1e-11);
        }
    }
}

#[test]
fn direction_follows_the_order_of_the_points() {
    let [mut arc, ..] = arcs(1.0);
    let forwards = fit_common_axis(&[&arc]).unwrap().axis.direction;
    assert!(forwards.dot(&axis_direction()) > 0.999_999);
    arc.reverse();
    let backwards = fit_common_axis(&[&arc]).unwrap().axis.direction;
    assert!((forwards.into_inner() + backwards.into_inner()).norm() < 1e-12);
}

/// Short arcs with noise from 1 nm to 1 µm: steps along the flat direction change the cost by less
/// than its rounding, which must not pass for a failure to descend.
#[test]
fn short_arcs_converge() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for (sweep_rad, noise_mm) in [(0.05, 1e-6), (0.2, 1e-6), (0.2, 1e-3), (1.0, 1e-3)] {
        for _ in 0..20 {
            let mut arcs = arcs(sweep_rad);
            for x in arcs.iter_mut().flatten().flat_map(|p| p.iter_mut()) {
                let unit: f64 = StandardNormal.sample(&mut rng);
                *x += noise_mm * unit;
            }
            let [first, second, third] = slices(&arcs);
            for circles in [&[first, second, third][..], &[first], &[second], &[third]] {
                let axis = fit_common_axis(circles).unwrap();
                assert!(axis.termination.is_converged(), "{:?}", axis.termination);
            }
        }
    }
}

#[test]
fn too_few_points() {
    let [first, second, _] = arcs(1.0);
    let few = |circles: &[&[Point3<f64>]]| fit_common_axis(circles).unwrap_err().to_string();
    assert_eq!(few(&[]), "common axis: need at least 3 points, found 0");
    assert_eq!(
        few(&[&first[..2]]),
        "common axis: need at least 3 points, found 2"
    );
    assert_eq!(
        few(&[&first, &second[..1]]),
        "circle number 1: need at least 2 points on each circle, found 1"
    );
    // Two chords that are not parallel are just enough: eight residuals, eight unknowns.
    let chords = [&first[..2], &second[..2]];
    let exact = fit_common_axis(&chords).unwrap();
    assert!((exact.axis.direction.cross(&axis_direction())).norm() < 1e-11);
}

#[test]
fn coincident_points() {
    let p = Point3::new(700.0, -20.0, 3.0);
    let refused = fit_common_axis(&[&[p; 2], &[p; 3]]).unwrap_err();
    assert!(
        matches!(refused, Error::Coincident { points: 5, .. }),
        "{refused}"
    );
}

#[test]
fn collinear_points() {
    let line = [0.0, 1.0, 2.0, 4.0]
        .map(|t| Point3::new(700.1, -20.3, 3.7) + Vector3::new(0.3, 0.7, -0.1) * t);
    let beside = line.map(|p| p + Vector3::new(0.0, 0.0, 50.0));
    for refused in [
        fit_common_axis(&[&line]).unwrap_err(),
        fit_common_axis(&[&line, &beside]).unwrap_err(),
    ] {
        let Error::Collinear {
            length_mm,
            width_mm,
            rounding_mm,
        } = refused
        else {
            panic!("expected collinear, found {refused}");
        };
        assert!(length_mm > 1.0 && width_mm <= rounding_mm && rounding_mm < 1e-11);
    }
}

/// Noise like an S: the best circle is the straight line, of infinite radius.
#[test]
fn an_arc_without_a_bend_is_not_determined() {
    let bends = [0.0, 1e-3, 0.0, -1e-3, 0.0];
    let points: Vec<_> = bends
        .iter()
        .enumerate()
        .map(|(i, &y)| Point3::new(i as f64 * 10.0, y, 0.0))
        .collect();
    let refused = fit_common_axis(&[&points]).unwrap_err();
    assert!(matches!(refused, Error::Undetermined { .. }), "{refused}");
}
