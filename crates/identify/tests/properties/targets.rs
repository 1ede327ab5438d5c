//! Targets and rigid displacements shared by the tests.

use nalgebra::{Matrix6, RowVector6, Vector3};
use rand::{Rng, RngExt};
use trueaxis_identify::SixRows;
use trueaxis_kinematics::MotionError;

/// Paper section 5.1, home position, mm.
pub(crate) const THREE_AXIS: [Vector3<f64>; 3] = [
    Vector3::new(16.338, 452.716, 122.416),
    Vector3::new(157.086, 332.593, 324.879),
    Vector3::new(248.925, 603.0552, 412.4483),
];

/// Paper section 5.2, stage frame at home, mm.
pub(crate) const ROTARY: [Vector3<f64>; 3] = [
    Vector3::new(-105.8046, 135.3414, 0.0),
    Vector3::new(128.8513, 87.8158, 39.9797),
    Vector3::new(24.9026, -110.8575, 15.2662),
];

/// Three targets anywhere in a cube of 400 mm, up to 1 m away from the reference point.
pub(crate) fn random_targets(rng: &mut impl Rng) -> [Vector3<f64>; 3] {
    let corner = random_vector(rng, 1000.0);
    [(); 3].map(|()| corner + random_vector(rng, 200.0))
}

/// Uniform in `[-limit, limit]` along every axis.
pub(crate) fn random_vector(rng: &mut impl Rng, limit: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-limit..limit))
}

/// Some 10 µm and 10 arcsec.
pub(crate) fn random_error(rng: &mut impl Rng) -> MotionError {
    MotionError::new(random_vector(rng, 1e-2), random_vector(rng, 5e-5))
}

/// Eq. 2, written out.
pub(crate) fn displacement(error: &MotionError, r: &Vector3<f64>) -> Vector3<f64> {
    let (d, e) = (error.translation_mm, error.rotation_rad);
    Vector3::new(
        d.x + e.y * r.z - e.z * r.y,
        d.y + e.z * r.x - e.x * r.z,
        d.z + e.x * r.y - e.y * r.x,
    )
}

/// Largest distance of a target from the reference point, mm.
pub(crate) fn reach(r: &[Vector3<f64>; 3]) -> f64 {
    r.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Six rows of Eq. 21 as printed; the last three columns are divided by `angle_scale_mm`.
pub(crate) fn six_equations(
    rows: SixRows,
    r: &[Vector3<f64>; 3],
    angle_scale_mm: f64,
) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    for (i, row) in rows.rows().enumerate() {
        let [x, y, z] = (r[row / 3] / angle_scale_mm).into();
        let printed = match row % 3 {
            0 => RowVector6::new(1.0, 0.0, 0.0, 0.0, z, -y),
            1 => RowVector6::new(0.0, 1.0, 0.0, -z, 0.0, x),
            _ => RowVector6::new(0.0, 0.0, 1.0, y, -x, 0.0),
        };
        matrix.set_row(i, &printed);
    }
    matrix
}

/// Condition number of the printed equations with angles in units of `1 / reach`.
pub(crate) fn condition_number(rows: SixRows, r: &[Vector3<f64>; 3]) -> f64 {
    let singular_values = six_equations(rows, r, reach(r)).singular_values();
    singular_values.max() / singular_values.min()
}

/// Whether a choice of rows leaves out a target or a coordinate, which the paper's section 4.1.1 excludes.
pub(crate) fn is_blind(rows: SixRows) -> bool {
    let left_out = |of: fn(usize) -> usize, k: usize| rows.rows().all(|row| of(row) != k);
    (0..3).any(|k| left_out(|row| row / 3, k) || left_out(|row| row % 3, k))
}

/// `|δ| + reach |ε|` of the difference over that of `expected`.
pub(crate) fn relative_difference(found: &MotionError, expected: &MotionError, reach: f64) -> f64 {
    let size = |e: MotionError| e.translation_mm.norm() + reach * e.rotation_rad.norm();
    let difference = MotionError::from_vector(&(found.to_vector() - expected.to_vector()));
    size(difference) / size(*expected)
}
