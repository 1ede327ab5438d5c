//! The least spread of lengths that any station can see of a motion.
//!
//! Let the nominal points of a target be `p`, and let `std` be the standard deviation over the
//! readings. For every place `S` of the station
//!
//! ```text
//! std(|p - S|) >= std(|p - S|²) / (2 max |p - S|)
//! ```
//!
//! because `|a² - b²| <= 2 max(a, b) |a - b|`. `|p - S|²` is quadratic in `S`; with the covariance
//! `C` of the points, `σ²` its least eigenvalue, and the centre `S*` of the best (algebraic) sphere,
//!
//! ```text
//! var(|p - S|²) = e² + 4 (S - S*)ᵀ C (S - S*) >= e² + 4 σ² |S - S*|²
//! ```
//!
//! The points are at most `R` from `S*`, so at most `R + |S - S*|` from `S`. The least quotient over
//! `|S - S*|` has a closed form with `a = e / (2 R)`:
//!
//! ```text
//! std(|p - S|) >= a σ / √(a² + σ²)
//! ```
//!
//! The bound is zero, as it must be, for points in one plane (a far station above it sees nothing)
//! and on one sphere (a station at its centre sees nothing), so for one linear axis, one rotary
//! axis, and two rotary axes that intersect. Three linear axes leave tens of mm.

use nalgebra::{Matrix3, Point3, Vector3};

/// In a cloud of points thinner than this (σ, mm) the sphere is undetermined and the bound of no use.
const THINNEST_CLOUD_MM: f64 = 1.0;

/// Sums over the readings of one target from one station, relative to the first of them: `x` is
/// the point, `q = |x|²`, `l` the length.
#[derive(Default)]
pub(crate) struct Moments {
    first_point: Point3<f64>,
    first_length_mm: f64,
    /// Line of the first reading.
    pub(crate) line: usize,
    count: f64,
    x: Vector3<f64>,
    xx: Matrix3<f64>,
    q: f64,
    qq: f64,
    qx: Vector3<f64>,
    l: f64,
    ll: f64,
    sphere: Option<Sphere>,
}

/// The best algebraic sphere through the points.
struct Sphere {
    /// `S*`.
    center: Point3<f64>,
    /// `e²`, mm⁴.
    e_squared: f64,
    /// `R²`, mm².
    farthest_squared: f64,
}

impl Moments {
    pub(crate) fn starting_at(first_point: Point3<f64>, first_length_mm: f64, line: usize) -> Self {
        Self {
            first_point,
            first_length_mm,
            line,
            ..Self::default()
        }
    }

    pub(crate) fn add(&mut self, point: Point3<f64>, length_mm: f64) {
        let x = point - self.first_point;
        let q = x.norm_squared();
        let l = length_mm - self.first_length_mm;
        self.count += 1.0;
        self.x += x;
        self.xx += x * x.transpose();
        self.q += q;
        self.qq += q * q;
        self.qx += x * q;
        self.l += l;
        self.ll += l * l;
    }

    pub(crate) fn length_std_mm(&self) -> f64 {
        let mean = self.l / self.count;
        (self.ll / self.count - mean * mean).max(0.0).sqrt()
    }

    pub(crate) fn motion_std_mm(&self) -> f64 {
        self.covariance().trace().max(0.0).sqrt()
    }

    fn covariance(&self) -> Matrix3<f64> {
        let mean = self.x / self.count;
        self.xx / self.count - mean * mean.transpose()
    }

    /// `σ²`, mm².
    fn least_variance(&self) -> f64 {
        self.covariance().symmetric_eigenvalues().min()
    }

    pub(crate) fn find_sphere(&mut self) {
        if self.least_variance() < THINNEST_CLOUD_MM * THINNEST_CLOUD_MM {
            return;
        }
        let mean_q = self.q / self.count;
        let q_with_x = self.qx / self.count - self.x / self.count * mean_q;
        let q_variance = self.qq / self.count - mean_q * mean_q;
        self.sphere = self.covariance().try_inverse().map(|inverse| {
            let center = inverse * q_with_x / 2.0;
            Sphere {
                center: self.first_point + center,
                e_squared: (q_variance - 2.0 * center.dot(&q_with_x)).max(0.0),
                farthest_squared: 0.0,
            }
        });
    }

    pub(crate) fn enclose(&mut self, point: Point3<f64>) {
        if let Some(sphere) = &mut self.sphere {
            let squared = nalgebra::distance_squared(&sphere.center, &point);
            sphere.farthest_squared = sphere.farthest_squared.max(squared);
        }
    }

    /// The bound of the module documentation, mm; zero where there is none.
    pub(crate) fn least_std_mm(&self) -> f64 {
        self.sphere.as_ref().map_or(0.0, |sphere| {
            let a_squared = sphere.e_squared / (4.0 * sphere.farthest_squared);
            let sigma_squared = self.least_variance();
            (a_squared * sigma_squared / (a_squared + sigma_squared)).sqrt()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cross_of_three_axes() -> Vec<Point3<f64>> {
        let positions = (0..=20).map(|i| f64::from(i) * 20.0);
        positions
            .flat_map(|q| [Vector3::x() * q, Vector3::y() * q, Vector3::z() * q])
            .map(|v| Point3::from(v + Vector3::new(16.0, 452.0, 122.0)))
            .collect()
    }

    fn moments(points: &[Point3<f64>], station: Point3<f64>) -> Moments {
        let length_mm = |p: &Point3<f64>| (p - station).norm() - 1234.5;
        let mut moments = Moments::starting_at(points[0], length_mm(&points[0]), 2);
        for p in points {
            moments.add(*p, length_mm(p));
        }
        moments.find_sphere();
        points.iter().for_each(|p| moments.enclose(*p));
        moments
    }

    /// Stations on a grid through and far around the points: none sees less than the bound, and
    /// the bound is not so low that it is useless.
    #[test]
    fn no_station_sees_less_than_the_bound() {
        let points = cross_of_three_axes();
        let bound_mm = moments(&points, Point3::origin()).least_std_mm();
        assert!(bound_mm > 15.0, "{bound_mm}");
        let mut least_mm = f64::INFINITY;
        for spacing in [150.0, 700.0, 5000.0, 80_000.0] {
            for i in 0..12_u32.pow(3) {
                let grid = [i % 12, i / 12 % 12, i / 144].map(|g| (f64::from(g) - 5.5) * spacing);
                let seen_mm = moments(&points, Point3::from(grid)).length_std_mm();
                least_mm = least_mm.min(seen_mm);
            }
        }
        assert!(least_mm >= bound_mm, "{least_mm} < {bound_mm}");
        assert!(least_mm < 3.0 * bound_mm, "{least_mm} > 3 * {bound_mm}");
    }

    #[test]
    fn a_plane_and_a_sphere_have_no_bound() {
        let circle = |i: i32| {
            let angle = f64::from(i) * 0.3;
            Vector3::new(angle.cos(), angle.sin(), 0.0) * 200.0
        };
        let plane: Vec<_> = (0..20).map(|i| Point3::from(circle(i))).collect();
        assert!(moments(&plane, Point3::origin()).least_std_mm() < 1e-3);
        let sphere: Vec<_> = (0..60)
            .map(|i| {
                let height = (f64::from(i) * 0.77).sin();
                let ring = circle(i) * (1.0 - height * height).sqrt();
                Point3::from(ring + Vector3::z() * 200.0 * height)
            })
            .collect();
        assert!(moments(&sphere, Point3::origin()).least_std_mm() < 1e-3);
    }
}
