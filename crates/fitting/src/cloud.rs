//! Points relative to their centroid, in a unit near their size.

use nalgebra::{Point3, Vector3};

use crate::Error;

/// Groups of points, centred as a whole and scaled.
///
/// A part of 1 mm, 1000 mm away from the origin, loses three digits to its distance. So the first
/// point is subtracted first, which is exact to the rounding of the *difference*; only then is
/// anything averaged. The unit is a power of two, so that scaling rounds nothing.
#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    first_mm: Point3<f64>,
    /// From the first point to the centroid of all points, mm.
    centroid_mm: Vector3<f64>,
    /// Length of one unit, mm.
    pub(crate) unit_mm: f64,
    /// What the rounding of the coordinates explains, units.
    pub(crate) rounding: f64,
    /// The points of each group relative to the centroid of all, units.
    pub(crate) groups: Vec<Vec<Vector3<f64>>>,
}

/// A spread of this many units in the last place of the largest coordinate counts as none: one
/// for the rounding of each coordinate, with a margin for what made the coordinates.
const ROUNDING_ULPS: f64 = 8.0;

/// Squares of greater coordinates, and sums of them, could overflow.
const LARGEST_MM: f64 = 1e100;

impl Cloud {
    /// Centres and scales `groups`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Coincident`] if all points are one, or there is none.
    pub(crate) fn new(groups: &[&[Point3<f64>]]) -> Result<Self, Error> {
        let points = || groups.iter().copied().flatten();
        if let Some((index, p)) = points().enumerate().find(|(_, p)| !is_usable(p)) {
            return Err(Error::NotFinite {
                index,
                point_mm: [p.x, p.y, p.z],
            });
        }
        let count = points().count();
        let first_mm = points().next().copied().unwrap_or_default();
        let centroid_mm = points().map(|p| p - first_mm).sum::<Vector3<f64>>() / count as f64;
        let squares: f64 = points()
            .map(|p| (p - first_mm - centroid_mm).norm_squared())
            .sum();
        let spread_mm = (squares / count as f64).sqrt();
        let largest_mm = points().fold(0.0_f64, |largest, p| largest.max(p.coords.amax()));
        let rounding_mm = ROUNDING_ULPS * f64::EPSILON * largest_mm;
        // The centroid of no points is NaN.
        if spread_mm.is_nan() || spread_mm <= rounding_mm {
            return Err(Error::Coincident {
                points: count,
                spread_mm,
                rounding_mm,
            });
        }
        let unit_mm = spread_mm.log2().round().exp2();
        let centred = |p: &Point3<f64>| (p - first_mm - centroid_mm) / unit_mm;
        Ok(Self {
            first_mm,
            centroid_mm,
            unit_mm,
            rounding: rounding_mm / unit_mm,
            groups: groups
                .iter()
                .map(|group| group.iter().map(centred).collect())
                .collect(),
        })
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.groups.iter().map(Vec::len).sum()
    }

    /// Every group relative to its own centroid, all in one list.
    pub(crate) fn pooled(&self) -> Vec<Vector3<f64>> {
        let mut pooled = Vec::with_capacity(self.len());
        for group in &self.groups {
            let mean = mean(group);
            pooled.extend(group.iter().map(|p| p - mean));
        }
        pooled
    }

    /// The point at `p` relative to the centroid, mm.
    pub(crate) fn to_mm(&self, p: Vector3<f64>) -> Point3<f64> {
        self.first_mm + (self.centroid_mm + p * self.unit_mm)
    }
}

/// Arithmetic mean; zero for no points.
pub(crate) fn mean(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64
}

fn is_usable(p: &Point3<f64>) -> bool {
    p.iter().all(|c| c.abs() <= LARGEST_MM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_from_the_origin_costs_no_digit() {
        let near = [[0.0, 0.0, 0.0], [1.0, 2.0, 4.0], [-1.0, 0.5, 0.25]].map(Point3::from);
        let far = near.map(|p| p + Vector3::new(1024.0, -2048.0, 4096.0));
        let [near, far] = [&near, &far].map(|points| Cloud::new(&[&points[..]]).unwrap());
        assert_eq!(near.groups, far.groups);
    }

    #[test]
    fn refuses_points_that_are_one() {
        let p = Point3::new(1e3, 2.0, 3.0);
        let almost = p + Vector3::new(1e-13, 0.0, 0.0);
        let refused = Cloud::new(&[&[p, almost]]);
        assert!(matches!(refused, Err(Error::Coincident { points: 2, .. })));
        assert!(matches!(
            Cloud::new(&[]),
            Err(Error::Coincident { points: 0, .. })
        ));
    }

    #[test]
    fn names_the_point_that_is_not_finite() {
        let p = Point3::new(1.0, 2.0, 3.0);
        let refused = Cloud::new(&[&[p, p], &[p, Point3::new(1.0, f64::NAN, 2.0)]]);
        assert!(matches!(refused, Err(Error::NotFinite { index: 3, .. })));
    }
}
