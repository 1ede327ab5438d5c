//! A rotary run: three targets at different heights on one axis, nowhere parallel to a coordinate.

use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// Steps of the run.
pub(crate) const STEPS: usize = 13;

/// Radius, height and phase (mm, mm, rad) of the targets.
pub(crate) const TARGETS: [(f64, f64, f64); 3] = [
    (170.0, -40.0, 0.3),
    (155.0, 25.0, 2.4),
    (113.0, 130.0, -1.5),
];

pub(crate) fn axis_point() -> Point3<f64> {
    Point3::new(410.0, -275.0, 820.0)
}

pub(crate) fn axis_direction() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(0.2, -0.3, 0.9))
}

/// The points of the three targets over `sweep_rad` about the axis, right-hand sense.
pub(crate) fn arcs(sweep_rad: f64) -> [Vec<Point3<f64>>; 3] {
    let upright =
        UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &axis_direction()).unwrap();
    TARGETS.map(|(radius, height, phase)| {
        let point = |step: usize| {
            let angle = phase + sweep_rad * step as f64 / (STEPS - 1) as f64;
            let (sine, cosine) = angle.sin_cos();
            axis_point() + upright * Vector3::new(radius * cosine, radius * sine, height)
        };
        (0..STEPS).map(point).collect()
    })
}

pub(crate) fn slices(arcs: &[Vec<Point3<f64>>; 3]) -> [&[Point3<f64>]; 3] {
    arcs.each_ref().map(Vec::as_slice)
}
