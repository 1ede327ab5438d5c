//! The geometric circle in a plane: minimise `Σ (|p_i - c| - R)²`.

use faer::Mat;
use nalgebra::Vector2;

use crate::Error;
use crate::gauss_newton::{Minimum, Model, minimise};

/// Circle through planar points, in units of their size.
#[derive(Debug, Clone)]
pub(crate) struct PlanarCircle<'a> {
    points: &'a [Vector2<f64>],
    pub(crate) centre: Vector2<f64>,
    pub(crate) radius: f64,
}

impl<'a> PlanarCircle<'a> {
    /// The circle with the least sum of squared radial distances.
    ///
    /// # Errors
    /// [`Error::Undetermined`] if the points lie on a line.
    pub(crate) fn fit(points: &'a [Vector2<f64>]) -> Result<Minimum<Self>, Error> {
        let centre = algebraic_centre(&[points]);
        minimise(Self {
            points,
            centre,
            radius: mean_distance(points, centre),
        })
    }
}

impl Model for PlanarCircle<'_> {
    fn linearise(&self) -> (Vec<f64>, Mat<f64>) {
        let arms: Vec<Vector2<f64>> = self.points.iter().map(|p| p - self.centre).collect();
        let residuals = arms.iter().map(|arm| arm.norm() - self.radius).collect();
        let jacobian = Mat::from_fn(arms.len(), 3, |i, k| match k {
            2 => -1.0,
            _ => -unit(arms[i])[k],
        });
        (residuals, jacobian)
    }

    fn moved(&self, step: &[f64]) -> Self {
        Self {
            points: self.points,
            centre: self.centre + Vector2::new(step[0], step[1]),
            radius: self.radius + step[2],
        }
    }

    fn rounding(&self) -> f64 {
        let size = self.centre.norm() + self.radius;
        f64::EPSILON * size * (self.points.len() as f64).sqrt()
    }
}

/// A common centre of several planar groups of points, each with its own radius, from the linear
/// equations `2 c·(p - p̄) = |p|² - mean |p|²` (I. Kåsa, 1976; the squared radii eliminated).
///
/// It is exact for exact points and otherwise a start: noise on a short arc pulls it inwards.
/// For collinear points it is the origin.
pub(crate) fn algebraic_centre(groups: &[&[Vector2<f64>]]) -> Vector2<f64> {
    let (mut a, mut b) = (nalgebra::Matrix2::zeros(), Vector2::zeros());
    for group in groups {
        let count = group.len().max(1) as f64;
        let mean = group.iter().sum::<Vector2<f64>>() / count;
        let mean_square = group.iter().map(Vector2::norm_squared).sum::<f64>() / count;
        for p in *group {
            let d = p - mean;
            a += d * d.transpose();
            b += d * (p.norm_squared() - mean_square);
        }
    }
    a.cholesky()
        .map_or_else(Vector2::zeros, |cholesky| cholesky.solve(&b) * 0.5)
}

/// Least-squares radius about a given centre.
pub(crate) fn mean_distance(points: &[Vector2<f64>], centre: Vector2<f64>) -> f64 {
    let sum: f64 = points.iter().map(|p| (p - centre).norm()).sum();
    sum / points.len().max(1) as f64
}

/// Direction of an arm; zero for a point at the centre, where the distance has none.
fn unit(arm: Vector2<f64>) -> Vector2<f64> {
    arm.try_normalize(0.0).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss_newton::jacobian_error;

    fn arc(centre: Vector2<f64>, radius: f64, angles: &[f64]) -> Vec<Vector2<f64>> {
        let point = |&angle: &f64| centre + Vector2::new(angle.cos(), angle.sin()) * radius;
        angles.iter().map(point).collect()
    }

    #[test]
    fn jacobian_agrees_with_differences() {
        let points = arc(Vector2::new(0.3, -0.2), 1.1, &[0.1, 0.9, 2.0, 4.0]);
        let circle = PlanarCircle {
            points: &points,
            centre: Vector2::new(0.2, 0.1),
            radius: 0.9,
        };
        assert!(jacobian_error(&circle) < 1e-8);
    }

    #[test]
    fn concentric_arcs_share_their_centre() {
        let centre = Vector2::new(0.7, -0.4);
        let inner = arc(centre, 0.5, &[0.0, 0.3, 0.6]);
        let outer = arc(centre, 1.5, &[2.0, 2.3]);
        let found = algebraic_centre(&[&inner, &outer]);
        assert!((found - centre).norm() < 1e-13);
    }
}
