//! How the noise of measured coordinates depends on place and direction.
//!
//! A tracker measures a distance and two angles: at 2 m, 3 µm/m of the angles is 6 µm across the beam, while the distance
//! is known to less than 1 µm. Coordinates that are taken for equally good in all directions then have wrong weights and
//! wrong uncertainties. What the coordinates themselves say is found by restricted maximum likelihood
//! ([`CoordinateNoise::estimated`]) among
//!
//! | form | variance along a direction |
//! | --- | --- |
//! | equal | the same everywhere |
//! | directions | its own for each of three directions, the same everywhere |
//! | polar | its own along the beam of an instrument; across it its own times the square of the distance |
//!
//! An instrument stands in the origin of its coordinates, or, if these were transformed, where the likelihood is
//! greatest. Standard deviations that are declared for each reading multiply all of these: where they grow with the
//! distance already, the polar form is not the likeliest. Another form than the first must be significant; of several that are, the one with the best information
//! criterion (G. Schwarz, *Annals of Statistics* 6, 461, 1978) stands.

mod block;
mod choice;
mod likelihood;

use nalgebra::{Matrix3, Point3, Vector3};

/// Readings of one step that were approached from one side.
#[derive(Debug, Clone)]
pub struct StepReadings {
    /// Rotation from the bodies' home to the frame of the coordinates.
    pub rotation: Matrix3<f64>,
    /// The readings, visit by visit.
    pub readings: Vec<CoordinateReading>,
}

/// One reading of a point.
#[derive(Debug, Clone)]
pub struct CoordinateReading {
    /// The visit that took it.
    pub visit: usize,
    /// The number of its target among those of all bodies.
    pub target: usize,
    /// Its standard deviation relative to the others, where it is declared.
    pub sigma: f64,
    /// Its position, mm.
    pub point_mm: Point3<f64>,
    /// Measured less modelled position, mm.
    pub misfit_mm: Vector3<f64>,
}

/// The noise of coordinates. Its variances have the mean one over points and directions.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateNoise {
    form: Form,
    /// Along each row of the form; across a beam at the usual distance.
    variances: [f64; 3],
    /// Of the variance that is known least; infinite where noise is equal.
    degrees_of_freedom: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    Equal,
    /// Orthonormal directions, as rows.
    Directions(Matrix3<f64>),
    Polar {
        station_mm: Point3<f64>,
        /// A direction away from the mean beam; the directions across a beam are level and upright to it.
        upright: Vector3<f64>,
        /// Rms distance of the points.
        distance_mm: f64,
    },
}

impl CoordinateNoise {
    /// Equal in all directions.
    pub const EQUAL: Self = Self {
        form: Form::Equal,
        variances: [1.0; 3],
        degrees_of_freedom: f64::INFINITY,
    };

    fn directions(rows: Matrix3<f64>) -> Self {
        Self {
            form: Form::Directions(rows),
            variances: [1.0; 3],
            degrees_of_freedom: f64::INFINITY,
        }
    }

    /// `None` if a point is so near that no instrument stands there.
    fn polar(station_mm: Point3<f64>, points_mm: &[Point3<f64>]) -> Option<Self> {
        let beams = points_mm.iter().map(|point| point - station_mm);
        let squares: f64 = beams.clone().map(|beam| beam.norm_squared()).sum();
        let distance_mm = (squares / points_mm.len() as f64).sqrt();
        let nearest_mm = beams.clone().map(|beam| beam.norm());
        let nearest_mm = nearest_mm.fold(f64::INFINITY, f64::min);
        let sum: Vector3<f64> = beams.sum();
        (nearest_mm > NEAREST * distance_mm).then(|| Self {
            form: Form::Polar {
                station_mm,
                upright: Vector3::ith(sum.iamin(), 1.0),
                distance_mm,
            },
            variances: [1.0; 3],
            degrees_of_freedom: f64::INFINITY,
        })
    }

    /// The directions of a point in which its noise is independent, as orthonormal rows, and the relative variances along
    /// them. Those of a polar instrument are the beam and two across it.
    pub fn at(&self, point_mm: &Point3<f64>) -> (Matrix3<f64>, [f64; 3]) {
        match &self.form {
            Form::Equal => (Matrix3::identity(), self.variances),
            Form::Directions(rows) => (*rows, self.variances),
            Form::Polar {
                station_mm,
                upright,
                distance_mm,
            } => {
                let beam = point_mm - station_mm;
                let farther = beam.norm_squared() / distance_mm.powi(2);
                // A point that was not asked for may be anywhere.
                let farther = farther.max(NEAREST * NEAREST);
                let [along, level, upward] = self.variances;
                let variances = [along, level * farther, upward * farther];
                (rows_along(&beam, upright), variances)
            }
        }
    }

    /// Degrees of freedom of the variance that is known least; infinite where noise is equal.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.degrees_of_freedom
    }

    /// The relative covariance of a point, in the frame of the coordinates.
    pub fn covariance(&self, point_mm: &Point3<f64>) -> Matrix3<f64> {
        let (rows, variances) = self.at(point_mm);
        rows.transpose() * Matrix3::from_diagonal(&variances.into()) * rows
    }

    /// In words for a user; `unit_um` is the standard deviation of a coordinate of variance one, µm. `None` where noise
    /// is equal.
    pub fn in_words(&self, unit_um: f64) -> Option<String> {
        let [first, second, third] = self.variances.map(|variance| unit_um * variance.sqrt());
        match &self.form {
            Form::Equal => None,
            Form::Directions(rows) => {
                let along = |k: usize| {
                    let [x, y, z] = [rows[(k, 0)], rows[(k, 1)], rows[(k, 2)]];
                    format!("({x:.2}, {y:.2}, {z:.2})")
                };
                Some(format!(
                    "{first:.2} µm along {}, {second:.2} µm along {}, {third:.2} µm along {} of their frame",
                    along(0),
                    along(1),
                    along(2),
                ))
            }
            Form::Polar {
                station_mm,
                distance_mm,
                ..
            } => {
                let [x, y, z] = station_mm.coords.into();
                let place = match *station_mm == Point3::origin() {
                    true => "in the origin of their frame".to_owned(),
                    false => format!("at ({x:.0}, {y:.0}, {z:.0}) mm in their frame"),
                };
                let across = 1e3 * second / distance_mm;
                Some(format!(
                    "{first:.2} µm along the beam of an instrument {place}, {across:.2} µm/m across it"
                ))
            }
        }
    }

    /// Which variances are the same.
    fn classes(&self) -> [usize; 3] {
        match self.form {
            Form::Equal => [0; 3],
            Form::Directions(_) => [0, 1, 2],
            Form::Polar { .. } => [0, 1, 1],
        }
    }

    /// The same with variances of unit mean over these points.
    fn of_unit_mean(mut self, points_mm: &[Point3<f64>]) -> Self {
        let of_point = |point: &Point3<f64>| self.at(point).1.iter().sum::<f64>() / 3.0;
        let sum: f64 = points_mm.iter().map(of_point).sum();
        let mean = sum / points_mm.len() as f64;
        self.variances = self.variances.map(|variance| variance / mean);
        self
    }
}

/// Least distance of a point from the instrument, as a part of the usual one: a beam needs some room.
const NEAREST: f64 = 0.05;

/// Sine of an angle below which two directions are one.
const LEAST_SINE: f64 = 1e-6;

/// Three orthonormal rows: along a beam, across it and `upright`, and across both.
fn rows_along(beam: &Vector3<f64>, upright: &Vector3<f64>) -> Matrix3<f64> {
    let along = beam.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let level = upright.cross(&along).try_normalize(LEAST_SINE);
    let level = level.unwrap_or_else(|| {
        let other = Vector3::ith(along.iamin(), 1.0);
        other.cross(&along).normalize()
    });
    let last = along.cross(&level);
    Matrix3::from_rows(&[along.transpose(), level.transpose(), last.transpose()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A target that passes the origin had a variance of nearly zero there, and its weight made covariances of NaN.
    #[test]
    fn no_instrument_stands_among_the_points() {
        let points = |x_mm: f64| [x_mm, 100.0].map(|x| Point3::new(x, 0.0, 0.0));
        let polar = |x_mm| CoordinateNoise::polar(Point3::origin(), &points(x_mm));
        assert!(polar(1e-3).is_none());
        let noise = polar(50.0).unwrap();
        let covariance = noise.covariance(&Point3::new(1e-3, 0.0, 0.0));
        assert!(covariance.try_inverse().is_some());
    }
}
