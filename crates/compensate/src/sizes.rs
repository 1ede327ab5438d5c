//! How large errors of the tool are over the working volume.

use nalgebra::Vector6;

/// Of the errors at some places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Displacement of the tool point, less that at home: root of the mean square, mm.
    pub rms_mm: f64,
    /// Its largest, mm.
    pub max_mm: f64,
    /// Rotation of the tool, rad.
    pub rotation_rms_rad: f64,
    /// Its largest, rad.
    pub rotation_max_rad: f64,
}

impl Sizes {
    /// Of displacements (mm) and rotations (rad).
    pub(crate) fn of(errors: &[Vector6<f64>]) -> Self {
        let sizes = |first: usize| {
            let sizes = errors.iter().map(move |e| e.fixed_rows::<3>(first).norm());
            let squares: f64 = sizes.clone().map(|size| size * size).sum();
            let rms = (squares / errors.len().max(1) as f64).sqrt();
            (rms, sizes.fold(0.0, f64::max))
        };
        let ((rms_mm, max_mm), (rotation_rms_rad, rotation_max_rad)) = (sizes(0), sizes(3));
        Self {
            rms_mm,
            max_mm,
            rotation_rms_rad,
            rotation_max_rad,
        }
    }
}
