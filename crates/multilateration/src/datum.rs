//! The datum: the best fit of the points to the nominal ones.
//!
//! `Σ (p - n) = 0` and `Σ n × (p - n) = 0`: six constraints that fix the six free motions.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::centroid;

use crate::network::Network;
use crate::state::{DATUM, State};

/// The centre about which rotations of the datum turn, and their unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Datum {
    pub(crate) centroid: Point3<f64>,
    /// Rms distance of the nominal points from their centroid, mm: makes rotations of the datum
    /// comparable with translations.
    pub(crate) radius_mm: f64,
}

impl Datum {
    pub(crate) fn new(network: &Network) -> Self {
        let count = network.nominal_mm.len().max(1) as f64;
        let centroid = centroid(&network.nominal_mm);
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

    /// What the free motions (translations along x, y, z, then rotations about them, scaled to the size of the
    /// network) do to `shared` shared unknowns, of which the first are the stations.
    pub(crate) fn free_motions(&self, state: &State, shared: usize) -> Vec<Vec<f64>> {
        let mut free_motions: Vec<_> = (0..DATUM).map(|_| Vec::with_capacity(shared)).collect();
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
