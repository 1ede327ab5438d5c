//! Small rigid motions as linear functions of many error sources.
//!
//! A twist `(ρ, v)` displaces a point by `v + ρ × p`. Rows are coordinates; columns are whatever
//! the errors are linear in.

use nalgebra::{DMatrix, Isometry3, Matrix3xX, Matrix6xX, Point3};

/// ρ (rad) and v (mm, displacement of the origin), three rows each.
#[derive(Debug, Clone)]
pub struct Twist {
    /// ρ.
    pub rotation: Matrix3xX<f64>,
    origin: Matrix3xX<f64>,
}

impl Twist {
    /// No motion: zeros for each of `columns` sources.
    pub fn zero(columns: usize) -> Self {
        Self {
            rotation: Matrix3xX::zeros(columns),
            origin: Matrix3xX::zeros(columns),
        }
    }

    /// The twist that displaces `point` by `displacement` and turns by `rotation`.
    pub fn about(
        point: Point3<f64>,
        displacement: Matrix3xX<f64>,
        rotation: Matrix3xX<f64>,
    ) -> Self {
        // v = d - ρ × p = d + [p]ₓ ρ
        let origin = displacement + point.coords.cross_matrix() * &rotation;
        Self { rotation, origin }
    }

    /// The same motion seen from another frame.
    #[must_use]
    pub fn seen_from(&self, frame_from_here: &Isometry3<f64>) -> Self {
        let turn = frame_from_here.rotation.to_rotation_matrix().into_inner();
        // The old origin is there now and moves by the turned v.
        let old_origin = Point3::from(frame_from_here.translation.vector);
        Self::about(old_origin, turn * &self.origin, turn * &self.rotation)
    }

    /// Adds a motion of the same sources.
    pub fn add(&mut self, other: &Self) {
        self.rotation += &other.rotation;
        self.origin += &other.origin;
    }

    /// The same motion as a function of what the old columns are linear in: one row of `columns`
    /// for each of them.
    #[must_use]
    pub fn through(&self, columns: &DMatrix<f64>) -> Self {
        Self {
            rotation: &self.rotation * columns,
            origin: &self.origin * columns,
        }
    }

    /// v and ρ as six rows.
    pub fn rows(&self) -> Matrix6xX<f64> {
        let mut rows = Matrix6xX::zeros(self.origin.ncols());
        rows.fixed_rows_mut::<3>(0).copy_from(&self.origin);
        rows.fixed_rows_mut::<3>(3).copy_from(&self.rotation);
        rows
    }

    /// Displacement of a point.
    pub fn at(&self, point: Point3<f64>) -> Matrix3xX<f64> {
        &self.origin - point.coords.cross_matrix() * &self.rotation
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_twist_moves_points_the_same_way_from_every_frame() {
        let displacement = Matrix3xX::from_column_slice(&[1.0, -2.0, 0.5]);
        let rotation = Matrix3xX::from_column_slice(&[0.3, 0.1, -0.2]);
        let about = Point3::new(10.0, -20.0, 30.0);
        let twist = Twist::about(about, displacement.clone(), rotation);
        assert!((twist.at(about) - &displacement).norm() < 1e-12);

        let frame = Isometry3::new(Vector3::new(5.0, 6.0, 7.0), Vector3::new(0.4, -0.7, 1.1));
        let p = Point3::new(1.0, 2.0, 3.0);
        let here = twist.at(p);
        let expected = frame.rotation * Vector3::from_column_slice(here.as_slice());
        let there = twist.seen_from(&frame).at(frame * p);
        assert!((Vector3::from_column_slice(there.as_slice()) - expected).norm() < 1e-12);
    }
}
