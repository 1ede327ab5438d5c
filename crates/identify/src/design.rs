//! The design matrix of the nine equations, as printed and well scaled.

use nalgebra::{Dyn, Matrix3, MatrixXx6, OMatrix, U6, Vector3};

use crate::Error;

/// Largest distance from a degenerate geometry, relative to the size of the targets, that counts as degenerate.
///
/// The coordinates of targets are known to about 1e-6 of the distances between them (0.3 µm in 300 mm).
pub(crate) const GEOMETRY_TOL: f64 = 1e-6;

/// The nine (or 3T) equations: the matrix `[I, M_j]` of the paper's Eq. 21.
///
/// Its rows are those of Eq. 8 for each target, together Eq. 9 for a linear axis, or of Eq. 15, together Eq. 16 for a
/// rotary axis; with the coordinates of Eq. 19 both are the same. (Eqs. 5-7 and 12-14 are the right-hand side `Δ`:
/// measured minus ideal position.)
///
/// `r` holds the generalised coordinates of the targets relative to the reference point of δ, mm
/// (Eq. 19: turned by the commanded angle, or in [`crate::pose_from_points`] by the pose itself). Rows are Px Py Pz Qx Qy Qz Kx Ky Kz and so
/// on (①②③④⑤⑥⑦⑧⑨); columns are δx δy δz (per mm) and εx εy εz (per rad). Row j holds
/// `Δ_j = δ + ε × r_j`.
pub fn equations(r: &[Vector3<f64>]) -> MatrixXx6<f64> {
    let mut matrix = MatrixXx6::zeros(3 * r.len());
    for (j, r) in r.iter().enumerate() {
        matrix
            .fixed_view_mut::<3, 3>(3 * j, 0)
            .copy_from(&Matrix3::identity());
        // M_j is the matrix of ε -> ε × r_j = -r_j × ε.
        matrix
            .fixed_view_mut::<3, 3>(3 * j, 3)
            .copy_from(&-r.cross_matrix());
    }
    matrix
}

/// Targets that span a plane, relative to their centroid and in units of their radius of gyration.
///
/// With δ at the centroid and angles times the radius of gyration, the columns of the equations
/// are of one size and translations do not mix with rotations, wherever the reference point is.
pub(crate) struct CentredTargets {
    centroid_mm: Vector3<f64>,
    /// Root of the mean squared distance of the targets from their centroid, mm.
    pub(crate) gyration_mm: f64,
    scaled: Vec<Vector3<f64>>,
}

impl CentredTargets {
    /// # Errors
    /// [`Error::TooFewTargets`], [`Error::NotFinite`], [`Error::Collinear`].
    pub(crate) fn new(r: &[Vector3<f64>]) -> Result<Self, Error> {
        if r.len() < 3 {
            return Err(Error::TooFewTargets { found: r.len() });
        }
        require_finite("position", r)?;
        let extent = Extent::of(r);
        if extent.off_line_mm <= GEOMETRY_TOL * extent.length_mm {
            return Err(extent.collinear());
        }
        let count = r.len() as f64;
        let centroid_mm = r.iter().sum::<Vector3<f64>>() / count;
        let offsets = r.iter().map(|r| r - centroid_mm);
        let gyration_mm = (offsets.clone().map(|s| s.norm_squared()).sum::<f64>() / count).sqrt();
        let scaled = offsets.map(|s| s / gyration_mm).collect();
        Ok(Self {
            centroid_mm,
            gyration_mm,
            scaled,
        })
    }

    /// The equations for δ at the centroid (mm) and ε times the radius of gyration (mm).
    pub(crate) fn equations(&self) -> MatrixXx6<f64> {
        equations(&self.scaled)
    }

    /// From solutions of [`CentredTargets::equations`] to δ at the reference point and ε in rad: `δ = δ_c - ε × c`.
    pub(crate) fn unscale(&self, mut solutions: OMatrix<f64, U6, Dyn>) -> OMatrix<f64, U6, Dyn> {
        for mut solution in solutions.column_iter_mut() {
            let rotation = solution.fixed_rows::<3>(3) / self.gyration_mm;
            let translation = solution.fixed_rows::<3>(0) - rotation.cross(&self.centroid_mm);
            solution.fixed_rows_mut::<3>(0).copy_from(&translation);
            solution.fixed_rows_mut::<3>(3).copy_from(&rotation);
        }
        solutions
    }
}

/// How far points reach along and across the line through the two that are farthest apart.
pub(crate) struct Extent {
    pub(crate) length_mm: f64,
    pub(crate) off_line_mm: f64,
}

impl Extent {
    pub(crate) fn of(points: &[Vector3<f64>]) -> Self {
        let mut origin = Vector3::zeros();
        let mut longest = Vector3::zeros();
        for (i, first) in points.iter().enumerate() {
            for second in &points[i + 1..] {
                let side = second - first;
                if side.norm() > longest.norm() {
                    (origin, longest) = (*first, side);
                }
            }
        }
        let off_line_mm = longest.try_normalize(0.0).map_or(0.0, |along| {
            points
                .iter()
                .map(|p| (p - origin).cross(&along).norm())
                .fold(0.0, f64::max)
        });
        Self {
            length_mm: longest.norm(),
            off_line_mm,
        }
    }

    pub(crate) fn collinear(&self) -> Error {
        Error::Collinear {
            length_mm: self.length_mm,
            off_line_mm: self.off_line_mm,
        }
    }
}

/// # Errors
/// [`Error::NotFinite`] with the first target whose vector is not finite.
pub(crate) fn require_finite(
    quantity: &'static str,
    vectors: &[Vector3<f64>],
) -> Result<(), Error> {
    let is_wrong = |v: &Vector3<f64>| !v.iter().all(|c| c.is_finite());
    match vectors.iter().position(is_wrong) {
        Some(target) => Err(Error::NotFinite { quantity, target }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::RowVector6;

    #[test]
    fn rows_are_those_of_equation_9() {
        let (x, y, z) = (2.0, 3.0, 5.0);
        let matrix = equations(&[Vector3::zeros(), Vector3::new(x, y, z)]);
        assert_eq!(matrix.row(3), RowVector6::new(1.0, 0.0, 0.0, 0.0, z, -y));
        assert_eq!(matrix.row(4), RowVector6::new(0.0, 1.0, 0.0, -z, 0.0, x));
        assert_eq!(matrix.row(5), RowVector6::new(0.0, 0.0, 1.0, y, -x, 0.0));
    }

    #[test]
    fn collinear_targets_are_refused_with_numbers() {
        let along = Vector3::new(2.0, -1.0, 2.0) / 3.0;
        let across = Vector3::new(1.0, 2.0, 0.0).normalize();
        let start = Vector3::new(500.0, 300.0, -200.0);
        let targets = |off_line_mm: f64| {
            [
                start,
                start + along * 120.0 + across * off_line_mm,
                start + along * 300.0,
            ]
        };
        let refused = CentredTargets::new(&targets(1e-4)).err().unwrap();
        let Error::Collinear {
            length_mm,
            off_line_mm,
        } = refused
        else {
            panic!("{refused}");
        };
        assert!((length_mm - 300.0).abs() < 1e-9);
        assert!((off_line_mm - 1e-4).abs() < 1e-9);
        assert!(CentredTargets::new(&targets(1e-3)).is_ok());
    }

    #[test]
    fn coincident_few_and_infinite_targets_are_refused() {
        let p = Vector3::new(1.0, 2.0, 3.0);
        let refusal = |r: &[Vector3<f64>]| CentredTargets::new(r).err();
        assert_eq!(
            refusal(&[p, p, p]),
            Some(Error::Collinear {
                length_mm: 0.0,
                off_line_mm: 0.0
            })
        );
        assert_eq!(refusal(&[p, p]), Some(Error::TooFewTargets { found: 2 }));
        let infinite = Vector3::new(0.0, f64::INFINITY, 0.0);
        assert_eq!(
            refusal(&[p, infinite, -p]),
            Some(Error::NotFinite {
                quantity: "position",
                target: 1
            })
        );
    }
}
