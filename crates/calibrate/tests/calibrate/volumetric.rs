//! The volumetric error in the measured volume; its covariance is tested with all others.

use nalgebra::{DVector, Point3};
use trueaxis_calibrate::{Calibration, ReferencePoint, Settings, calibrate};

use crate::{simulated, two_branches};

#[test]
fn corners_and_centre_of_the_measured_volume() {
    let campaign = simulated(&two_branches());
    let settings = Settings {
        by_direction: true,
        ..Settings::default()
    };
    let calibration = calibrate(&campaign, &settings).unwrap();
    let tool = Point3::new(100.0, 50.0, 300.0);
    let found = calibration.volumetric_errors(&campaign.machine, tool);
    let full = 310_f64.to_radians();
    let corner = |i: usize| {
        [
            400.0 * (i >> 2) as f64,
            300.0 * (i >> 1 & 1) as f64,
            full * (i & 1) as f64,
        ]
    };
    assert_eq!(found.len(), 9);
    for (i, place) in found[..8].iter().enumerate() {
        let distance =
            DVector::from_column_slice(&place.positions) - DVector::from_column_slice(&corner(i));
        assert!(distance.norm() < 1e-9, "{:?}", place.positions);
    }
    let centre = &found[8];
    let expected = [200.0, 150.0, 0.5 * full];
    let distance =
        DVector::from_column_slice(&centre.positions) - DVector::from_column_slice(&expected);
    assert!(distance.norm() < 1e-9, "{:?}", centre.positions);
    assert!(centre.covariance_mm2.is_none());
    assert!(centre.error_mm.norm() > 1e-3);
}

/// The shift of C is stated at the height of the reference point, which its tilt moves by 15 µm; the
/// volumetric error is the same. (X and Y have no angular errors, so the frame is the same as well.)
#[test]
fn the_reference_point_does_not_matter() {
    let campaign = simulated(&two_branches());
    let tool = Point3::new(100.0, 50.0, 300.0);
    let [origin, centroid] =
        [ReferencePoint::Origin, ReferencePoint::Centroid].map(|reference_point| {
            let settings = Settings {
                by_direction: true,
                reference_point,
                ..Settings::default()
            };
            calibrate(&campaign, &settings).unwrap()
        });
    let shift = |calibration: &Calibration| {
        let c = calibration.axis("C").unwrap();
        c.location_error("Y0C").unwrap().value
    };
    assert!((shift(&origin) - shift(&centroid)).abs() > 0.01);
    let [origin, centroid] =
        [origin, centroid].map(|c| c.volumetric_errors(&campaign.machine, tool));
    for (a, b) in origin.iter().zip(&centroid) {
        let difference_mm = (a.error_mm - b.error_mm).norm();
        assert!(difference_mm < 1e-8, "{difference_mm:e}");
    }
}
