//! Principal directions of centred points: the singular value decomposition of an n × 3 matrix.
//!
//! The eigenvectors of the 3 × 3 Gram matrix carry one rounding of its largest element: a spread below
//! 1e-8 of the length is lost, and of a normal of (1e-4, 7e-6, 1) the second component has eleven
//! digits. In the frame of these eigenvectors the Gram matrix is made anew, from coordinates that are
//! small where the points spread little; its elements off the diagonal then give what is left to turn,
//! to first order, with all digits.

use nalgebra::{Matrix3, SymmetricEigen, Unit, Vector3};

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

/// Each correction leaves the square of what it corrects: a spread of 1e-4 of the length has its
/// direction to 1e-8 by the eigenvectors, to 1e-16 by one.
const CORRECTIONS: usize = 2;

/// Two spreads whose squares differ by less than this fraction have no directions of their own.
const EQUAL_SPREADS: f64 = 1e-8;

/// Principal axes of points that are relative to their centroid.
pub(crate) fn principal_axes(centred: &[Vector3<f64>]) -> PrincipalAxes {
    let eigen = SymmetricEigen::new(gram(centred, &Matrix3::identity()));
    let mut order = [0, 1, 2];
    order.sort_by(|&j, &k| eigen.eigenvalues[k].total_cmp(&eigen.eigenvalues[j]));
    let mut directions = Matrix3::from_columns(&order.map(|k| eigen.eigenvectors.column(k)));
    for _ in 0..CORRECTIONS {
        directions = corrected(centred, &directions);
    }
    let squares = gram(centred, &directions).diagonal();
    PrincipalAxes {
        directions,
        extents: squares.map(f64::sqrt),
    }
}

/// `Fᵀ P Pᵀ F` of points in the columns of P.
fn gram(points: &[Vector3<f64>], frame: &Matrix3<f64>) -> Matrix3<f64> {
    let mut gram = Matrix3::zeros();
    for p in points {
        let p = frame.tr_mul(p);
        gram += p * p.transpose();
    }
    gram
}

/// The first and the last direction turned by `g_jk / (g_kk - g_jj)` towards the others.
fn corrected(centred: &[Vector3<f64>], frame: &Matrix3<f64>) -> Matrix3<f64> {
    let gram = gram(centred, frame);
    let turned = |k: usize| {
        let towards = |j: usize| {
            let gap = gram[(k, k)] - gram[(j, j)];
            let apart = gap.abs() > EQUAL_SPREADS * gram[(k, k)].max(gram[(j, j)]);
            let angle = if j != k && apart {
                gram[(j, k)] / gap
            } else {
                0.0
            };
            frame.column(j) * angle
        };
        frame.column(k) + towards(0) + towards(1) + towards(2)
    };
    let last = turned(2).normalize();
    let first = turned(0);
    let first = (first - last * last.dot(&first)).normalize();
    Matrix3::from_columns(&[first, last.cross(&first), last])
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
