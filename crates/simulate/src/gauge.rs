//! The least-squares gauge: what of an error curve belongs to the location errors.
//!
//! With the commanded positions `q_i` of all runs of an axis of direction `d`, each different one
//! counted once, the gauge takes from δ(q) and ε(q)
//!
//! ```text
//! linear  δ across d   its least-squares line             a + b q
//!         δ along d    its value at home                  a
//!         ε            its value at home                  a
//! rotary  δ across d   its least-squares mean in the
//!                      fixed and the turning frame        a + R(d, q) b
//!         ε across d   the same
//!         δ, ε along d their value at home                a
//! ```
//!
//! What a linear axis loses across d is its squareness; what a rotary axis loses is the location
//! of its axis (a) and a shift of what it carries (b). The value at home is that at `q = 0`, on
//! the straight line between the neighbouring steps if no step is there, and that of the nearest
//! step if 0 lies outside the steps.
//!
//! A calibration states the same conditions on what it observed. Here they are met in closed form, by
//! code that shares nothing with the estimator, so that each is a check of the other.

use nalgebra::{Rotation3, Unit, Vector3};
use trueaxis_kinematics::{Axis, AxisKind, MotionError};

/// What the gauge takes away from the curves of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GaugePart {
    direction: Unit<Vector3<f64>>,
    translation: Taken,
    rotation: Taken,
}

/// `constant + slope q + R(d, q) turning`, in mm or rad.
#[derive(Debug, Clone, PartialEq, Default)]
struct Taken {
    constant: Vector3<f64>,
    slope: Vector3<f64>,
    turning: Vector3<f64>,
}

/// Mean squared distance of the steps from their mean below which they are one step: mm² for a
/// linear axis, on the unit circle for a rotary one. Full turns differ by rounding alone (1e-32);
/// two steps 1 µm or 1 arcsec apart give 2e-7 and 6e-12.
const MIN_SPREAD: f64 = 1e-14;

impl GaugePart {
    /// Nothing is taken.
    pub(crate) fn none(axis: &Axis) -> Self {
        Self {
            direction: axis.direction(),
            translation: Taken::default(),
            rotation: Taken::default(),
        }
    }

    /// What the gauge takes from `errors` at the increasing positions `q` (mm or rad); `None` if
    /// the positions are too few to define it.
    pub(crate) fn fit(axis: &Axis, q: &[f64], errors: &[MotionError]) -> Option<Self> {
        let d = axis.direction();
        let translations: Vec<_> = errors.iter().map(|e| e.translation_mm).collect();
        let rotations: Vec<_> = errors.iter().map(|e| e.rotation_rad).collect();
        let (translation, rotation) = match axis.kind() {
            AxisKind::Linear => {
                let straightness = line(q, &across(&d, &translations))?;
                let positioning = at_home(q, &along(&d, &translations))?;
                let angles = Taken::constant(at_home(q, &rotations)?);
                (straightness.plus_constant(positioning), angles)
            }
            AxisKind::Rotary => {
                let radial = circle(&d, q, &across(&d, &translations))?;
                let axial = at_home(q, &along(&d, &translations))?;
                let tilt = circle(&d, q, &across(&d, &rotations))?;
                let angle = at_home(q, &along(&d, &rotations))?;
                (radial.plus_constant(axial), tilt.plus_constant(angle))
            }
        };
        Some(Self {
            direction: d,
            translation,
            rotation,
        })
    }

    /// What is taken at position `q`, mm or rad.
    pub(crate) fn at(&self, q: f64) -> MotionError {
        MotionError::new(
            self.translation.at(&self.direction, q),
            self.rotation.at(&self.direction, q),
        )
    }
}

impl Taken {
    fn constant(constant: Vector3<f64>) -> Self {
        Self {
            constant,
            ..Self::default()
        }
    }

    fn plus_constant(mut self, constant: Vector3<f64>) -> Self {
        self.constant += constant;
        self
    }

    fn at(&self, d: &Unit<Vector3<f64>>, q: f64) -> Vector3<f64> {
        self.constant + self.slope * q + turn(d, q) * self.turning
    }
}

/// Least-squares line `a + b q`.
fn line(q: &[f64], values: &[Vector3<f64>]) -> Option<Taken> {
    let count = count(q)?;
    let mean_q = q.iter().sum::<f64>() / count;
    let mean = values.iter().sum::<Vector3<f64>>() / count;
    let spread: f64 = q.iter().map(|q| (q - mean_q).powi(2)).sum();
    if spread < MIN_SPREAD * count {
        return None;
    }
    let slope = q.iter().zip(values);
    let slope = slope.map(|(q, v)| (v - mean) * (q - mean_q));
    let slope = slope.sum::<Vector3<f64>>() / spread;
    Some(Taken {
        constant: mean - slope * mean_q,
        slope,
        turning: Vector3::zeros(),
    })
}

/// Least-squares `a + R(d, q) b` of vectors across d.
///
/// With the plane across d as the complex plane this is the straight line `a + b e` in
/// `e = exp(iq)`: `b = Σ (v - v̄) ē_i / Σ |e_i - ē|²`, where multiplying by the conjugate of e
/// turns back by q.
fn circle(d: &Unit<Vector3<f64>>, q: &[f64], values: &[Vector3<f64>]) -> Option<Taken> {
    let count = count(q)?;
    let mean = values.iter().sum::<Vector3<f64>>() / count;
    let (sines, cosines): (Vec<f64>, Vec<f64>) = q.iter().map(|q| q.sin_cos()).unzip();
    let spread = squares_about_mean(&sines) + squares_about_mean(&cosines);
    if spread < MIN_SPREAD * count {
        return None;
    }
    let turned_back = q.iter().zip(values).map(|(&q, v)| turn(d, -q) * (v - mean));
    let turning = turned_back.sum::<Vector3<f64>>() / spread;
    let mean_turned = q.iter().map(|&q| turn(d, q) * turning);
    Some(Taken {
        constant: mean - mean_turned.sum::<Vector3<f64>>() / count,
        slope: Vector3::zeros(),
        turning,
    })
}

/// Value at `q = 0` on the straight line between neighbouring steps; outside, the nearest value.
fn at_home(q: &[f64], values: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let above = q.partition_point(|&q| q < 0.0);
    match (above.checked_sub(1), values.get(above)) {
        (None, first) => first.copied(),
        (Some(below), None) => Some(values[below]),
        (Some(below), Some(value_above)) => {
            let (q0, q1) = (q[below], q[above]);
            Some(values[below].lerp(value_above, -q0 / (q1 - q0)))
        }
    }
}

fn across(d: &Unit<Vector3<f64>>, values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let d = d.as_ref();
    values.iter().map(|v| v - d * d.dot(v)).collect()
}

fn along(d: &Unit<Vector3<f64>>, values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let d = d.as_ref();
    values.iter().map(|v| d * d.dot(v)).collect()
}

fn turn(d: &Unit<Vector3<f64>>, angle_rad: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(d, angle_rad)
}

/// Number of values; `None` for none.
fn count(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then_some(values.len() as f64)
}

fn squares_about_mean(values: &[f64]) -> f64 {
    let mean = count(values).map_or(0.0, |count| values.iter().sum::<f64>() / count);
    values.iter().map(|v| (v - mean).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn rotary() -> Axis {
        Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::origin()).unwrap()
    }

    fn linear() -> Axis {
        Axis::linear("Y", Vector3::y(), [-100.0, 400.0]).unwrap()
    }

    #[test]
    fn a_straight_line_across_is_all_squareness() {
        let q = [-30.0, -10.0, 50.0, 90.0];
        let errors = q.map(|q| {
            MotionError::new(
                Vector3::new(0.003 + 2e-5 * q, -0.004 + 1e-5 * q, 0.0),
                Vector3::new(1e-5, 2e-5, 3e-5 + 1e-7 * q),
            )
        });
        let gauge = GaugePart::fit(&linear(), &q, &errors).unwrap();
        for (&q, error) in q.iter().zip(&errors) {
            let left = error.to_vector() - gauge.at(q).to_vector();
            // EXY vanishes; EYY keeps its slope and ECY its change, both zero at home.
            let expected = [0.0, 1e-5 * q, 0.0, 0.0, 0.0, 1e-7 * q];
            assert!((left - nalgebra::Vector6::from(expected)).norm() < 1e-16);
        }
    }

    #[test]
    fn a_shifted_axis_and_a_shifted_target_are_all_location() {
        // An uneven part of a turn: the two parts are far from orthogonal there.
        let q = [-1.0, -0.4, 0.3, 0.5, 1.2_f64];
        let errors = q.map(|q| {
            let (s, c) = q.sin_cos();
            let fixed = Vector3::new(0.003, -0.002, 0.0);
            let turning = Vector3::new(0.005 * c - 0.001 * s, 0.001 * c + 0.005 * s, 0.0);
            MotionError::new(fixed + turning, (fixed - turning) * 1e-3)
        });
        let gauge = GaugePart::fit(&rotary(), &q, &errors).unwrap();
        for (&q, error) in q.iter().zip(&errors) {
            let left = error.to_vector() - gauge.at(q).to_vector();
            assert!(left.norm() < 1e-16);
        }
    }

    #[test]
    fn home_between_steps_is_interpolated_and_outside_is_the_nearest() {
        let value = |x: f64| Vector3::new(x, 0.0, 0.0);
        let values = [value(1.0), value(4.0), value(6.0)];
        let home = |q| at_home(q, &values).unwrap().x;
        assert!((home(&[-1.0, 2.0, 3.0]) - 2.0).abs() < 1e-15);
        assert!((home(&[-1.0, 0.0, 3.0]) - 4.0).abs() < 1e-15);
        assert!((home(&[0.0, 2.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!((home(&[1.0, 2.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!((home(&[-3.0, -2.0, -1.0]) - 6.0).abs() < 1e-15);
    }

    #[test]
    fn one_position_defines_no_gauge() {
        let errors = [MotionError::default(); 2];
        let full_turn = [0.0, std::f64::consts::TAU];
        assert_eq!(GaugePart::fit(&linear(), &[5.0], &errors[..1]), None);
        assert_eq!(GaugePart::fit(&rotary(), &full_turn, &errors), None);
        assert_eq!(GaugePart::fit(&rotary(), &[], &[]), None);
    }
}
