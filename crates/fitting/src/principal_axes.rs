//! Principal directions of centred points: the singular value decomposition of an n × 3 matrix.
//!
//! One-sided Jacobi rotations act on the coordinates themselves. The eigenvectors of the 3 × 3 Gram
//! matrix would lose a spread of 1e-8 of the length (nalgebra forms that matrix for the SVD of a
//! 3 × 3), and the usual bidiagonal SVD leaves one rounding of the largest component in all of
//! them: of a normal of (1e-4, 7e-6, 1) the second then has eleven digits. Jacobi keeps them
//! (J. Demmel, K. Veselić, SIAM J. Matrix Anal. Appl. 13 (1992) 1204).

use nalgebra::{Matrix3, Unit, Vector3};

use crate::Error;
use crate::cloud::Cloud;

/// Singular directions and values of points, the longest first.
#[derive(Debug, Clone)]
pub(crate) struct PrincipalAxes {
    /// Unit directions in the columns, right-handed.
    pub(crate) directions: Matrix3<f64>,
    /// Root of the sum of squares along each direction, the singular values.
    pub(crate) extents: Vector3<f64>,
}

impl PrincipalAxes {
    /// The direction of the `k`-th largest spread.
    pub(crate) fn direction(&self, k: usize) -> Unit<Vector3<f64>> {
        Unit::new_normalize(self.directions.column(k).into_owned())
    }

    /// Refuses the points of `cloud` that lie on a line.
    ///
    /// # Errors
    /// [`Error::Collinear`].
    pub(crate) fn check_planar(&self, cloud: &Cloud) -> Result<(), Error> {
        let [length, width] = [0, 1].map(|k| self.extents[k] / (cloud.len() as f64).sqrt());
        if width > cloud.rounding {
            return Ok(());
        }
        Err(Error::Collinear {
            length_mm: length * cloud.unit_mm,
            width_mm: width * cloud.unit_mm,
            rounding_mm: cloud.rounding * cloud.unit_mm,
        })
    }
}

/// Jacobi converges quadratically; three columns need about six sweeps, never thirty.
const MAX_SWEEPS: usize = 30;

/// Principal axes of points that are relative to their centroid.
pub(crate) fn principal_axes(centred: &[Vector3<f64>]) -> PrincipalAxes {
    let mut rotated = centred.to_vec();
    let mut directions = Matrix3::identity();
    for _ in 0..MAX_SWEEPS {
        let mut at_rest = true;
        for (j, k) in [(0, 1), (0, 2), (1, 2)] {
            if let Some((c, s)) = rotation(&rotated, j, k) {
                at_rest = false;
                let turn = |x: f64, y: f64| (c * x - s * y, s * x + c * y);
                for p in &mut rotated {
                    (p[j], p[k]) = turn(p[j], p[k]);
                }
                for i in 0..3 {
                    (directions[(i, j)], directions[(i, k)]) =
                        turn(directions[(i, j)], directions[(i, k)]);
                }
            }
        }
        if at_rest {
            break;
        }
    }
    sorted(centred, directions)
}

/// Cosine and sine that make columns `j` and `k` orthogonal; `None` if they are.
fn rotation(points: &[Vector3<f64>], j: usize, k: usize) -> Option<(f64, f64)> {
    let (mut jj, mut kk, mut jk) = (0.0, 0.0, 0.0);
    for p in points {
        jj += p[j] * p[j];
        kk += p[k] * p[k];
        jk += p[j] * p[k];
    }
    if jk.abs() <= f64::EPSILON * (jj * kk).sqrt() {
        return None;
    }
    let zeta = (kk - jj) / (2.0 * jk);
    let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    Some((cosine, cosine * tangent))
}

/// Longest direction first; the third is the cross product of the other two.
fn sorted(centred: &[Vector3<f64>], directions: Matrix3<f64>) -> PrincipalAxes {
    let extent = |direction: &Vector3<f64>| {
        let squares: f64 = centred.iter().map(|p| p.dot(direction).powi(2)).sum();
        squares.sqrt()
    };
    let mut columns: Vec<(f64, Vector3<f64>)> = directions
        .column_iter()
        .map(|column| column.normalize())
        .map(|direction| (extent(&direction), direction))
        .collect();
    columns.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [u, v, mut w] = [columns[0].1, columns[1].1, columns[2].1];
    if u.cross(&v).dot(&w) < 0.0 {
        w = -w;
    }
    PrincipalAxes {
        directions: Matrix3::from_columns(&[u, v, w]),
        extents: Vector3::from_iterator(columns.iter().map(|c| c.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slab of 1 × 1e-2 × 1e-12: its Gram matrix would have the third spread 1e-24 beside 1.
    #[test]
    fn finds_a_spread_far_below_the_root_of_the_rounding() {
        let [u, v] = [Vector3::new(2.0, 3.0, 6.0), Vector3::new(3.0, -6.0, 2.0)].map(|d| d / 7.0);
        let w = u.cross(&v);
        let signs = [
            [1.0, 1.0, 1.0],
            [-1.0, 1.0, -1.0],
            [1.0, -1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ];
        let points = signs.map(|[a, b, c]| u * a + v * (1e-2 * b) + w * (1e-12 * c));
        let axes = principal_axes(&points);
        // The coordinates, of size one, are rounded to 1e-16; so is the slab's thickness.
        assert!((axes.extents - Vector3::new(2.0, 2e-2, 2e-12)).amax() < 1e-15);
        assert!((axes.extents[2] / 2e-12 - 1.0).abs() < 1e-3);
        assert!(axes.direction(0).cross(&u).norm() < 1e-15);
        assert!((axes.directions.determinant() - 1.0).abs() < 1e-14);
    }
}
