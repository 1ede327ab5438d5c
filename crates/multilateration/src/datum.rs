//! The datum: the best fit of the points to the nominal ones.
//!
//! `Σ (p - n) = 0` and `Σ n × (p - n) = 0`, six constraints that stand for the six free motions.

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_kinematics::{best_fit, centroid};

use crate::network::Network;
use crate::state::{DATUM, State};

/// Where rotations of the datum turn, and their scale.
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

    /// The motion that takes points to where they fit the nominal ones best.
    pub(crate) fn motion(&self, network: &Network, points: &[Point3<f64>]) -> Isometry3<f64> {
        best_fit(points, &network.nominal_mm)
    }

    /// What the free motions, translations along x, y, z, then rotations about them (scaled to the
    /// size of the network), do to `shared` shared unknowns, of which the first are the stations.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A thin network, turned and shifted, comes back: what is left of the constraints is rounding.
    #[test]
    fn thin_and_plane_networks_return() {
        for thin in [1.0, 1e-2, 1e-3] {
            for thick in [thin, 0.0] {
                let place = |i: usize| {
                    let wave = |k: f64| (k * (i as f64 + 0.3)).sin();
                    Point3::new(
                        500.0 * wave(1.7),
                        500.0 * thin * wave(2.9),
                        500.0 * thick * wave(4.3),
                    )
                };
                let network = Network {
                    nominal_mm: (0..40).map(place).collect(),
                    ..Network::default()
                };
                let away = Isometry3::new(
                    Vector3::new(3.0, -7.0, 2.0),
                    Vector3::new(0.02, -0.01, 0.03),
                );
                let moved: Vec<_> = network.nominal_mm.iter().map(|p| away * p).collect();
                let datum = Datum::new(&network);
                let back = datum.motion(&network, &moved);
                for (moved, nominal) in moved.iter().zip(&network.nominal_mm) {
                    let left = (back * moved - nominal).norm();
                    assert!(left < 1e-10, "{left} of {thin} and {thick}");
                }
            }
        }
    }
}
