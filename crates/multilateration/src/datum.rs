//! The datum: the best fit of the points to the nominal ones.
//!
//! `Σ (p - n) = 0` and `Σ n × (p - n) = 0`, six constraints that stand for the six free motions.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::free_points::{DATUM, State};
use crate::network::Network;

/// Where rotations of the datum turn, and their scale.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Datum {
    pub(crate) centroid: Point3<f64>,
    /// Rms distance of the nominal points from their centroid, mm: makes rotations of the datum
    /// comparable with translations.
    pub(crate) radius_mm: f64,
}

/// A decomposition of nine numbers needs a few.
const MOST_SWEEPS: usize = 100;

impl Datum {
    pub(crate) fn new(network: &Network) -> Self {
        let count = network.nominal_mm.len().max(1) as f64;
        let sum: Vector3<f64> = network.nominal_mm.iter().map(|p| p.coords).sum();
        let centroid = Point3::from(sum / count);
        let squares: f64 = network
            .nominal_mm
            .iter()
            .map(|p| (p - centroid).norm_squared())
            .sum();
        Self {
            centroid,
            radius_mm: (squares / count).sqrt().max(f64::MIN_POSITIVE),
        }
    }

    /// Lever arm of the rotations at `p`, in units of the radius.
    pub(crate) fn lever(&self, p: Point3<f64>) -> Vector3<f64> {
        (p - self.centroid) / self.radius_mm
    }

    /// The motion that takes points to where they fit the nominal ones best: about the centroids the
    /// rotation `R = V diag(1, 1, det VUᵀ) Uᵀ` from `Σ (p - p̄)(n - n̄)ᵀ = U S Vᵀ` (W. Kabsch, *Acta
    /// Crystallographica* A 32, 922, 1976).
    pub(crate) fn motion(&self, network: &Network, points: &[Point3<f64>]) -> Isometry3<f64> {
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        let centroid = Point3::from(sum / points.len().max(1) as f64);
        let mut products = Matrix3::zeros();
        for (p, n) in points.iter().zip(&network.nominal_mm) {
            products += (p - centroid) * self.lever(*n).transpose();
        }
        let svd = products.try_svd(true, true, f64::EPSILON, MOST_SWEEPS);
        let turn = match svd.map(|svd| (svd.u, svd.v_t)) {
            Some((Some(u), Some(v_t))) => {
                let sides = Vector3::new(1.0, 1.0, (u * v_t).determinant());
                let turn = v_t.transpose() * Matrix3::from_diagonal(&sides) * u.transpose();
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn))
            }
            // Points that are not finite.
            _ => UnitQuaternion::identity(),
        };
        let shift = self.centroid.coords - turn * centroid.coords;
        Isometry3::from_parts(Translation3::from(shift), turn)
    }

    /// What the free motions, translations along x, y, z, then rotations about them (scaled to the
    /// size of the network), do to `shared` shared unknowns, of which the first are the stations.
    pub(crate) fn free_motions(&self, state: &State, shared: usize) -> Vec<Vec<f64>> {
        let mut free_motions = vec![Vec::new(); DATUM];
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        for station in &state.stations {
            let r = self.lever(*station);
            let motions = [x, y, z, x.cross(&r), y.cross(&r), z.cross(&r)];
            for (all, motion) in free_motions.iter_mut().zip(motions) {
                all.extend([motion.x, motion.y, motion.z, 0.0]);
            }
        }
        for motion in &mut free_motions {
            motion.resize(shared, 0.0);
        }
        free_motions
    }
}
