//! What disturbances do to the geometry and the instrument at one reading.

use nalgebra::Vector3;

/// The sum of all disturbances at one reading. Each part acts exactly where it acts in reality:
///
/// ```text
/// l = (1 + s) |T(q + a) (h + g (h - h_c) + d) + m + r × (T(q) h - T(q) h_c) - (S + v)| + z - L
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Disturbance {
    /// z: the interferometer's zero, mm.
    pub(super) zero_mm: f64,
    /// s: the scale of the length, without unit.
    pub(super) scale: f64,
    /// v: the tripod, reference frame, mm.
    pub(super) station_mm: Vector3<f64>,
    /// m: everything that the machine carries, reference frame, mm.
    pub(super) machine_mm: Vector3<f64>,
    /// r: everything that the machine carries turns, about the centroid of the targets of its stage, reference frame, rad.
    pub(super) turn: Vector3<f64>,
    /// d: the target on its stage, stage frame, mm.
    pub(super) target_mm: Vector3<f64>,
    /// g: growth of the triangle of targets about its centroid, without unit.
    pub(super) growth: f64,
    /// a: by how much single axes stand beyond their commanded position, mm or rad.
    pub(super) axes: Vec<(usize, f64)>,
}
