//! The solution of one solver: `MODEL.SOLVER.solution`, points (x y z) and behind them stations (x y z L).

use std::fs;
use std::path::Path;

use anyhow::Result;
use nalgebra::{Matrix3, Point3, Vector3};
use trueaxis_multilateration::Station;

use crate::files::read_rows;

/// Points and stations in a frame of the solver's own.
pub(crate) struct Solution {
    /// Points, and stations behind them.
    places: Vec<Point3<f64>>,
    dead_paths_mm: Vec<f64>,
}

impl Solution {
    pub(crate) fn of(points: &[Point3<f64>], stations: &[Station]) -> Self {
        let behind = stations.iter().map(|station| station.position_mm);
        Self {
            places: points.iter().copied().chain(behind).collect(),
            dead_paths_mm: stations.iter().map(|s| s.dead_path_mm).collect(),
        }
    }

    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        let (points, stations) = self
            .places
            .split_at(self.places.len() - self.dead_paths_mm.len());
        let mut text = String::new();
        for p in points {
            text += &format!("{},{},{}\n", p.x, p.y, p.z);
        }
        for (s, dead_path_mm) in stations.iter().zip(&self.dead_paths_mm) {
            text += &format!("{},{},{},{dead_path_mm}\n", s.x, s.y, s.z);
        }
        Ok(fs::write(path, text)?)
    }

    pub(crate) fn read(path: &Path) -> Result<Self> {
        let rows = read_rows(path, ',')?;
        let place = |row: &Vec<f64>| Point3::new(row[0], row[1], row[2]);
        Ok(Self {
            places: rows.iter().map(place).collect(),
            dead_paths_mm: rows.iter().filter_map(|row| row.get(3)).copied().collect(),
        })
    }

    /// Largest distance of a point, a station or a dead path from that of the other solution, after
    /// the rigid motion that fits best, mm.
    pub(crate) fn difference_mm(&self, other: &Self) -> f64 {
        let motion = best_fit(&other.places, &self.places);
        let places = self.places.iter().zip(&other.places);
        let places = places.map(|(a, b)| (a - motion(b)).norm());
        let dead_paths = self.dead_paths_mm.iter().zip(&other.dead_paths_mm);
        let dead_paths = dead_paths.map(|(a, b)| (a - b).abs());
        places.chain(dead_paths).fold(0.0, f64::max)
    }
}

/// The motion that takes `from` to `to` with the least squares (Kabsch).
#[expect(
    clippy::disallowed_methods,
    reason = "matrices of three by three are decomposed by another algorithm, which is right"
)]
fn best_fit(from: &[Point3<f64>], to: &[Point3<f64>]) -> impl Fn(&Point3<f64>) -> Point3<f64> {
    let centre = |points: &[Point3<f64>]| {
        let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
        Point3::from(sum / points.len() as f64)
    };
    let (from_centre, to_centre) = (centre(from), centre(to));
    let products = from.iter().zip(to);
    let correlation: Matrix3<f64> = products
        .map(|(a, b)| (b - to_centre) * (a - from_centre).transpose())
        .sum();
    // The singular values are far apart and positive: no reflection, no choice of axes.
    let decomposition = correlation.svd(true, true);
    let (u, v_t) = (decomposition.u, decomposition.v_t);
    let rotation = u
        .zip(v_t)
        .map_or_else(Matrix3::identity, |(u, v_t)| u * v_t);
    move |p| to_centre + rotation * (p - from_centre)
}
