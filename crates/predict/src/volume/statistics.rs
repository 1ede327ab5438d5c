//! The figures of many errors.

use nalgebra::{DMatrix, Matrix3x6, Matrix6, Point3, Vector3, Vector6};
use trueaxis_kinematics::centroid;
use trueaxis_leastsquares::dense::Svd;

/// Share of the places whose error a percentile is not less than.
const PERCENTILE: f64 = 0.95;

/// Relative singular value below which a rigid motion of the places is not determined.
const FREE: f64 = 1e-10;

/// How large displacements are, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes<T> {
    /// Root of the mean square.
    pub rms: T,
    /// Not exceeded at 95 % of the places.
    pub p95: T,
    /// The largest.
    pub max: T,
}

/// The figures of the errors at all places; `T` is a number, or one with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures<T> {
    /// `|e - e(home)|`, mm.
    pub zeroed_at_home: Sizes<T>,
    /// What the best rigid motion of the workpiece leaves (least squares over the places), mm.
    pub best_fit: Sizes<T>,
    /// Largest minus smallest displacement along x, y, z (mm), and rotation about them (rad): the volumetric accuracy
    /// of ISO 230-1 over these places.
    pub ranges: [T; 6],
}

impl<T: Copy> Figures<T> {
    /// All in one list.
    pub(crate) fn to_array(self) -> [T; 12] {
        let (a, b, r) = (self.zeroed_at_home, self.best_fit, self.ranges);
        [
            a.rms, a.p95, a.max, b.rms, b.p95, b.max, r[0], r[1], r[2], r[3], r[4], r[5],
        ]
    }

    /// From that list.
    pub(crate) fn from_array(v: [T; 12]) -> Self {
        Self {
            zeroed_at_home: Sizes {
                rms: v[0],
                p95: v[1],
                max: v[2],
            },
            best_fit: Sizes {
                rms: v[3],
                p95: v[4],
                max: v[5],
            },
            ranges: std::array::from_fn(|i| v[6 + i]),
        }
    }
}

/// The best rigid motion over given places: `e ≈ t + ρ × p`.
pub(crate) struct RigidFit {
    centre: Point3<f64>,
    inverse: Matrix6<f64>,
}

impl RigidFit {
    /// Over nominal points on the workpiece, mm. What they do not determine is left out.
    pub(crate) fn new(points: &[Point3<f64>]) -> Self {
        let centre = centroid(points);
        let squares: f64 = points.iter().map(|p| (p - centre).norm_squared()).sum();
        // Rotations are scaled by the size of the volume, so that singular values compare.
        let size = (squares / points.len().max(1) as f64)
            .sqrt()
            .max(f64::MIN_POSITIVE);
        let mut normal = Matrix6::zeros();
        for p in points {
            let rows = rows((p - centre) / size);
            normal += rows.transpose() * rows;
        }
        let normal = DMatrix::from_column_slice(6, 6, normal.as_slice());
        // Points that are not finite are refused before; nothing fits them.
        let inverse = Svd::new(&normal).map(|svd| svd.pseudo_inverse(FREE * svd.largest()));
        let inverse = inverse.map(|inverse| Matrix6::from_column_slice(inverse.as_slice()));
        let mut inverse = inverse.unwrap_or_default();
        for i in 3..6 {
            inverse.row_mut(i).scale_mut(1.0 / size);
            inverse.column_mut(i).scale_mut(1.0 / size);
        }
        Self { centre, inverse }
    }

    /// Translation of the centre and rotation.
    fn motion(&self, points: &[Point3<f64>], errors: &[Vector6<f64>]) -> Vector6<f64> {
        let mut right = Vector6::zeros();
        for (p, e) in points.iter().zip(errors) {
            right += rows(p - self.centre).transpose() * e.fixed_rows::<3>(0);
        }
        self.inverse * right
    }
}

/// `e = t - [p]ₓ ρ`.
fn rows(p: Vector3<f64>) -> Matrix3x6<f64> {
    let mut rows = Matrix3x6::identity();
    rows.fixed_columns_mut::<3>(3).copy_from(&-p.cross_matrix());
    rows
}

/// The figures of errors (δ and ε) at places with these nominal points; `home` is the error at home.
pub(crate) fn figures(
    points: &[Point3<f64>],
    fit: &RigidFit,
    errors: &[Vector6<f64>],
    home: &Vector6<f64>,
) -> Figures<f64> {
    let displacement = |e: &Vector6<f64>| e.fixed_rows::<3>(0).into_owned();
    let zeroed = errors.iter().map(|e| displacement(&(e - home)).norm());
    let motion = fit.motion(points, errors);
    let left = points
        .iter()
        .zip(errors)
        .map(|(p, e)| (displacement(e) - rows(p - fit.centre) * motion).norm());
    let mut low = Vector6::repeat(f64::INFINITY);
    let mut high = Vector6::repeat(f64::NEG_INFINITY);
    for e in errors {
        low = low.inf(e);
        high = high.sup(e);
    }
    Figures {
        zeroed_at_home: sizes(zeroed.collect()),
        best_fit: sizes(left.collect()),
        ranges: (high - low).into(),
    }
}

fn sizes(mut all: Vec<f64>) -> Sizes<f64> {
    let count = all.len();
    let squares: f64 = all.iter().map(|size| size * size).sum();
    let max = all.iter().copied().fold(0.0, f64::max);
    let place = percentile_place(PERCENTILE, count);
    let (_, p95, _) = all.select_nth_unstable_by(place, f64::total_cmp);
    Sizes {
        rms: (squares / count as f64).sqrt(),
        p95: *p95,
        max,
    }
}

/// The place of a percentile in an ascending list.
pub(crate) fn percentile_place(share: f64, count: usize) -> usize {
    // A share of a count of places is in range.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the count"
    )]
    let rank = (share * count as f64).ceil() as usize;
    rank.clamp(1, count.max(1)) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_motion_leaves_nothing() {
        let points: Vec<Point3<f64>> = (0..60)
            .map(|i| {
                let i = f64::from(i);
                Point3::new(400.0 * (0.7 * i).sin(), 300.0 * (1.3 * i).cos(), 7.0 * i)
            })
            .collect();
        let (t, rho) = (
            Vector3::new(0.01, -0.02, 0.03),
            Vector3::new(1e-5, 3e-5, -2e-5),
        );
        let error = |p: &Point3<f64>| {
            let e = t + rho.cross(&p.coords);
            Vector6::new(e.x, e.y, e.z, rho.x, rho.y, rho.z)
        };
        let mut errors: Vec<Vector6<f64>> = points.iter().map(error).collect();
        let fit = RigidFit::new(&points);
        let home = Vector6::new(t.x, t.y, t.z, 0.0, 0.0, 0.0);
        let found = figures(&points, &fit, &errors, &home);
        assert!(found.best_fit.max < 1e-15, "{found:?}");
        let largest = points.iter().map(|p| rho.cross(&p.coords).norm());
        let largest = largest.fold(0.0, f64::max);
        assert!((found.zeroed_at_home.max - largest).abs() < 1e-15);
        assert!(found.ranges[3..].iter().all(|range| *range < 1e-18));
        // One place that is off stands out; the 95 % do not see it.
        errors[7].x += 0.1;
        let found = figures(&points, &fit, &errors, &home);
        assert!(found.best_fit.max > 0.08 && found.best_fit.p95 < 0.02);
        // Points on a line leave a rotation open.
        let line: Vec<Point3<f64>> = points.iter().map(|p| Point3::new(p.z, 0.0, 0.0)).collect();
        let errors: Vec<Vector6<f64>> = line.iter().map(error).collect();
        let found = figures(&line, &RigidFit::new(&line), &errors, &home);
        assert!(found.best_fit.max < 1e-15, "{found:?}");
    }

    #[test]
    fn percentiles_are_ranks() {
        for (count, place) in [(1, 0), (19, 18), (20, 18), (21, 19), (1000, 949)] {
            assert_eq!(percentile_place(0.95, count), place, "{count}");
        }
    }
}
