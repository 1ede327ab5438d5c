//! One axis: its nominal geometry and its exact motion.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::{Error, LocationComponent, LocationError, MotionError};

/// Linear or rotary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisKind {
    /// Moves along its direction; positions in mm.
    Linear,
    /// Turns about its direction (right-hand rule); positions in rad.
    Rotary,
}

impl AxisKind {
    /// `linear` or `rotary`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Rotary => "rotary",
        }
    }

    /// A position in mm or rad from one in mm or degrees, as in files. Zero loses its sign: -0 and 0 are one place.
    pub fn position_from_file(self, position: f64) -> f64 {
        match self {
            Self::Linear => position + 0.0,
            Self::Rotary => position.to_radians() + 0.0,
        }
    }

    /// A position in mm or degrees from one in mm or rad.
    pub fn position_in_file(self, position: f64) -> f64 {
        match self {
            Self::Linear => position,
            Self::Rotary => position.to_degrees(),
        }
    }

    /// The unit of positions in files: `mm` or `deg`.
    pub fn position_unit(self) -> &'static str {
        match self {
            Self::Linear => "mm",
            Self::Rotary => "deg",
        }
    }
}

/// The nominal geometry of an axis in the reference frame at home.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    name: String,
    kind: AxisKind,
    direction: Unit<Vector3<f64>>,
    /// What [`Axis::rotary`] was given; the origin for a linear axis.
    point_mm: Point3<f64>,
    /// The reference point of δ: `point_mm` until [`Axis::with_reference`].
    reference_mm: Point3<f64>,
    travel: [f64; 2],
}

/// How far a direction's length may be from one before it is refused: a rounded unit vector of
/// four digits passes, a wrong one does not.
const UNIT_LENGTH_TOL: f64 = 1e-3;

/// A direction of this length is normalised already: doing it again would change the last bit of a third of them, and a
/// machine would change when it is written and read.
const NORMALISED_TOL: f64 = 4.0 * f64::EPSILON;

impl Axis {
    /// A linear axis along `direction`; `travel` in mm. The reference point of its δ is the origin.
    ///
    /// # Errors
    /// [`Error::Direction`] if `direction` is not a unit vector, [`Error::Travel`] if `travel` is
    /// not an interval.
    pub fn linear(name: &str, direction: Vector3<f64>, travel: [f64; 2]) -> Result<Self, Error> {
        Self::new(name, AxisKind::Linear, direction, Point3::origin(), travel)
    }

    /// A rotary axis about the line through `point_mm` along `direction`; `travel` in rad.
    /// `point_mm` is the reference point of its δ.
    ///
    /// # Errors
    /// As [`Axis::linear`], and [`Error::Position`] if `point_mm` is not finite.
    pub fn rotary(
        name: &str,
        direction: Vector3<f64>,
        travel: [f64; 2],
        point_mm: Point3<f64>,
    ) -> Result<Self, Error> {
        Self::new(name, AxisKind::Rotary, direction, point_mm, travel)
    }

    fn new(
        name: &str,
        kind: AxisKind,
        direction: Vector3<f64>,
        point_mm: Point3<f64>,
        travel: [f64; 2],
    ) -> Result<Self, Error> {
        let length = direction.norm();
        if !length.is_finite() || (length - 1.0).abs() > UNIT_LENGTH_TOL {
            let direction = [direction.x, direction.y, direction.z];
            return Err(Error::Direction {
                axis: name.to_owned(),
                direction,
                length,
            });
        }
        if !point_mm.iter().all(|c| c.is_finite()) {
            return Err(Error::Position {
                axis: name.to_owned(),
            });
        }
        let [low, high] = travel;
        if !(low <= high && low.is_finite() && high.is_finite()) {
            return Err(Error::Travel {
                axis: name.to_owned(),
                low,
                high,
            });
        }
        let direction = match (length - 1.0).abs() <= NORMALISED_TOL {
            true => Unit::new_unchecked(direction),
            false => Unit::new_normalize(direction),
        };
        Ok(Self {
            name: name.to_owned(),
            kind,
            direction,
            point_mm,
            reference_mm: point_mm,
            travel,
        })
    }

    /// The same axis with another reference point of δ (stage coordinates at home, mm).
    ///
    /// For a rotary axis only the height along the axis counts: the reference point stays on it.
    #[must_use]
    pub fn with_reference(mut self, point_mm: Point3<f64>) -> Self {
        self.reference_mm = match self.kind {
            AxisKind::Linear => point_mm,
            AxisKind::Rotary => {
                let height_mm = (point_mm - self.reference_mm).dot(&self.direction);
                self.reference_mm + self.direction.into_inner() * height_mm
            }
        };
        self
    }

    /// Name, such as `X` or `C`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Linear or rotary.
    pub fn kind(&self) -> AxisKind {
        self.kind
    }

    /// Nominal direction, positive motion or right-hand rotation.
    pub fn direction(&self) -> Unit<Vector3<f64>> {
        self.direction
    }

    /// Reference point of δ at home, mm; for a rotary axis a point on its nominal axis.
    pub fn reference_mm(&self) -> Point3<f64> {
        self.reference_mm
    }

    /// The point that a rotary axis is given by, whatever the reference point of its δ is, mm; the origin for a linear one.
    pub fn point_mm(&self) -> Point3<f64> {
        self.point_mm
    }

    /// Lowest and highest position, mm or rad.
    pub fn travel(&self) -> [f64; 2] {
        self.travel
    }

    /// The reference direction (0, 1, 2 for x, y, z) that the axis follows most closely.
    pub fn principal(&self) -> usize {
        self.direction.iamax()
    }

    /// Makes the tilt of a location error of this axis one across it: its part along [`Axis::principal`], which has no
    /// name of its own, follows from the others.
    pub fn complete_tilt(&self, location: &mut LocationError) {
        let along = self.direction.dot(&location.tilt_rad);
        location.tilt_rad[self.principal()] -= along / self.direction[self.principal()];
    }

    /// The location errors that this axis can have, in the order X0 Y0 Z0 A0 B0 C0: two tilts for
    /// a linear axis (of which the reference frame may take some), three shifts and two tilts for
    /// a rotary one.
    pub fn location_components(&self) -> Vec<LocationComponent> {
        let tilts = (0..3)
            .filter(|&i| i != self.principal())
            .map(LocationComponent::Tilt);
        match self.kind {
            AxisKind::Linear => tilts.collect(),
            AxisKind::Rotary => (0..3).map(LocationComponent::Offset).chain(tilts).collect(),
        }
    }

    /// Average direction `d' = exp(tilt) d`.
    pub fn average_direction(&self, location: &LocationError) -> Unit<Vector3<f64>> {
        UnitQuaternion::from_scaled_axis(location.tilt_rad) * self.direction
    }

    /// The commanded motion alone: translation by `position` mm along the average direction, or
    /// rotation by `position` rad about the average axis, as it acts on home coordinates. Its rotation
    /// turns stage coordinates into the generalised ones of the paper's Eq. 19.
    pub fn commanded_motion(&self, position: f64, location: &LocationError) -> Isometry3<f64> {
        self.motion(position, location, &MotionError::default())
    }

    /// The stage point at home whose displacement is δ: `o` for a linear axis, `c' - l` for a
    /// rotary one (see [`Axis::motion`]), mm.
    pub fn reference_at_home_mm(&self, location: &LocationError) -> Point3<f64> {
        match self.kind {
            AxisKind::Linear => self.reference_mm,
            AxisKind::Rotary => self.reference_mm + location.offset_mm - self.axial_mm(location),
        }
    }

    /// The part of a shift along the nominal axis, mm.
    fn axial_mm(&self, location: &LocationError) -> Vector3<f64> {
        self.direction.into_inner() * self.direction.dot(&location.offset_mm)
    }

    /// The exact motion of everything that the axis carries, as it acts on home coordinates.
    ///
    /// With the reference point `o` (linear) or `c' = c + offset` (rotary), the average direction
    /// `d'`, and `l` the part of the offset along the nominal axis:
    ///
    /// ```text
    /// linear  h -> o  + δ + q d' + exp(ε) (h - o)
    /// rotary  h -> c' + δ + exp(ε) R(d', q) (h - c' + l)
    /// ```
    pub fn motion(
        &self,
        position: f64,
        location: &LocationError,
        error: &MotionError,
    ) -> Isometry3<f64> {
        let average_direction = self.average_direction(location);
        let error_motion = error.isometry();
        match self.kind {
            AxisKind::Linear => {
                let o = self.reference_mm.coords;
                Translation3::from(o + average_direction.into_inner() * position)
                    * error_motion
                    * Translation3::from(-o)
            }
            AxisKind::Rotary => {
                let centre = self.reference_mm.coords + location.offset_mm;
                Translation3::from(centre)
                    * error_motion
                    * UnitQuaternion::from_axis_angle(&average_direction, position)
                    * Translation3::from(self.axial_mm(location) - centre)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ARCSEC;

    #[test]
    fn directions_are_normalised_once() {
        for i in 1..2000_u32 {
            let angle = f64::from(i) * 0.011;
            let vector = Vector3::new(angle.cos(), angle.sin(), (3.0 * angle).sin());
            let rounded = vector.normalize() * 1.0004;
            let axis = Axis::linear("X", rounded, [0.0, 1.0]).unwrap();
            let again = Axis::linear("X", axis.direction().into_inner(), [0.0, 1.0]).unwrap();
            assert_eq!(again, axis);
        }
    }

    #[test]
    fn squareness_turns_y_about_positive_z() {
        let y = Axis::linear("Y", Vector3::y(), [0.0, 400.0]).unwrap();
        let c0y = 20.0 * ARCSEC;
        let location = LocationError {
            tilt_rad: Vector3::new(0.0, 0.0, c0y),
            ..Default::default()
        };
        let direction = y.average_direction(&location);
        assert!((direction.into_inner() - Vector3::new(-c0y, 1.0, 0.0)).norm() < 1e-8);
    }

    #[test]
    fn tilted_rotary_axis_leaves_its_own_points_in_place() {
        let c = Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::new(50.0, 60.0, 70.0)).unwrap();
        let location = LocationError {
            offset_mm: Vector3::new(0.1, -0.2, 0.0),
            tilt_rad: Vector3::new(1e-3, 2e-3, 0.0),
        };
        let on_axis = Point3::from(
            c.reference_mm().coords
                + location.offset_mm
                + c.average_direction(&location).into_inner() * 123.0,
        );
        let moved = c.commanded_motion(1.234, &location) * on_axis;
        assert!((moved - on_axis).norm() < 1e-12);
    }

    #[test]
    fn axial_location_error_lifts_the_stage() {
        let c = Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::new(50.0, 60.0, 70.0)).unwrap();
        let location = LocationError {
            offset_mm: Vector3::new(0.0, 0.0, 0.5),
            tilt_rad: Vector3::zeros(),
        };
        let h = Point3::new(10.0, 20.0, 30.0);
        let lifted = c.commanded_motion(0.0, &location) * h;
        assert!((lifted - h - Vector3::new(0.0, 0.0, 0.5)).norm() < 1e-13);
    }

    /// The paper's Eqs. 19a, 19b, 19c as printed.
    #[test]
    fn commanded_rotation_gives_the_generalised_coordinates() {
        let (x, y, z, angle) = (3.0, -5.0, 7.0, 0.7_f64);
        let (s, c) = angle.sin_cos();
        let printed = [
            (Vector3::x(), Vector3::new(x, y * c - z * s, z * c + y * s)),
            (Vector3::y(), Vector3::new(x * c + z * s, y, z * c - x * s)),
            (Vector3::z(), Vector3::new(x * c - y * s, y * c + x * s, z)),
        ];
        for (direction, expected) in printed {
            let axis = Axis::rotary("R", direction, [0.0, 6.0], Point3::origin()).unwrap();
            let motion = axis.commanded_motion(angle, &LocationError::default());
            assert!((motion * Vector3::new(x, y, z) - expected).norm() < 1e-14);
        }
    }

    #[test]
    fn names_follow_iso_230_1() {
        let names = |axis: &Axis| {
            let components = axis.location_components();
            components
                .iter()
                .map(|c| c.name(axis.name()))
                .collect::<Vec<_>>()
                .join(" ")
        };
        let c = Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::origin()).unwrap();
        let a = Axis::rotary("A", Vector3::x(), [0.0, 6.3], Point3::origin()).unwrap();
        let z = Axis::linear("Z", Vector3::z(), [0.0, 400.0]).unwrap();
        assert_eq!(names(&c), "X0C Y0C Z0C A0C B0C");
        assert_eq!(names(&a), "X0A Y0A Z0A B0A C0A");
        assert_eq!(names(&z), "A0Z B0Z");
    }

    #[test]
    fn refuses_what_is_not_a_direction() {
        let refused = Axis::linear("X", Vector3::new(1.0, 1.0, 0.0), [0.0, 1.0]);
        assert!(matches!(refused, Err(Error::Direction { .. })));
        let refused = Axis::linear("X", Vector3::new(f64::NAN, 0.0, 0.0), [0.0, 1.0]);
        assert!(matches!(refused, Err(Error::Direction { .. })));
    }
}
