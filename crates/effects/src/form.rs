//! From the formula of an effect to displacements.
//!
//! An effect acts in one of a few ways, and its formula says by how much for one unit of one parameter:
//! the k-th of three parameters moves a station or a target along the k-th reference direction, an axis
//! goes further than its position says, or the component errors of an axis change. In that case the stage
//! moves by δ and turns by ε about the reference point of δ,
//!
//! ```text
//! D_p = R (δ + ε × r)        r = p - o - q d  (linear)        r = p - o  (rotary)
//! ```
//!
//! with p the point where it stands, o the reference point and d the direction of the axis, all in the
//! frame of what carries the axis, and R the orientation of that frame, from the commanded positions.

use nalgebra::Vector3;
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Component, MICROMETRE, MotionError};

use crate::waves::{waves_about_axis, waves_across_axis};
use crate::{Circumstances, Displaced, Effect, Layer, PPM, Shape, Subject};

/// The way an effect acts, with its formula for one unit of one parameter.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    /// The instrument shows more than the distance, mm.
    Length(fn(&AtReading<'_>) -> f64),
    /// The instrument shows the distance longer by this many parts per million.
    Scale(fn(&AtReading<'_>) -> f64),
    /// The station moves along the reference direction of the parameter, mm; the fourth to sixth parameter of the
    /// frame of an instrument turn it about the origin, one arcsec where the others are one µm.
    Station(fn(&AtReading<'_>) -> f64),
    /// The target moves along the reference direction of the parameter, mm.
    Target(fn(&AtReading<'_>) -> f64),
    /// The same along a direction that turns with its stage.
    TargetOnStage(fn(&AtReading<'_>) -> f64),
    /// The target moves, mm in the reference frame.
    Displacement(fn(&AtReading<'_>) -> Vector3<f64>),
    /// The axis moves farther than commanded by this share of its position, and takes the target with it.
    Growth(fn(&AtReading<'_>) -> f64),
    /// Readings are late by this many seconds, in which the moving axis travels on.
    Delay(f64),
    /// The moving axis stops short of its position by half of this many µm or arcsec, on the side from which it came.
    LostMotion(fn(&AtReading<'_>) -> f64),
    /// The positioning error of the axis changes, mm.
    Positioning(fn(&OnCurve<'_>) -> f64),
    /// The component error of the subject changes.
    Component(fn(&OnCurve<'_>) -> MotionError),
    /// The angle about a rotary axis changes in this number of waves per turn, or in the number that is the shape.
    WavesAbout(Option<f64>),
    /// The two of these components across a rotary axis change in waves; the shape is their number per turn.
    WavesAcross([Component; 3]),
    /// Several component errors of the axis change together.
    Curves(fn(&OnCurve<'_>) -> MotionError),
}

/// One unit of one parameter of an effect on a subject, somewhere.
pub(crate) struct Term<'a, At> {
    pub(crate) subject: &'a Subject,
    pub(crate) parameter: usize,
    pub(crate) shape: f64,
    pub(crate) at: &'a At,
}

/// At a reading.
pub(crate) type AtReading<'a> = Term<'a, Circumstances<'a>>;

/// At a position of the axis on its error curve.
pub(crate) type OnCurve<'a> = Term<'a, AxisPosition<'a>>;

/// A position of an axis on an error curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPosition<'a> {
    /// The axis.
    pub axis: &'a Axis,
    /// Commanded position, mm or rad.
    pub position: f64,
    /// Side of approach, +1 or -1.
    pub direction: f64,
}

impl AtReading<'_> {
    /// The axis of the subject.
    pub(crate) fn axis(&self) -> Option<&Axis> {
        self.at.machine.axes().get(self.subject.axis?)
    }

    /// Commanded position of the axis of the subject, mm or rad; 0 without any.
    pub(crate) fn position(&self) -> f64 {
        self.subject.axis.map_or(0.0, |axis| self.at.position(axis))
    }

    /// By how much what follows the temperature of the subject is warmer than at the first reading, K; 0 without
    /// any. The shape is the lag, s.
    pub(crate) fn warmer_k(&self) -> f64 {
        let column = self.subject.column;
        let history = column.and_then(|column| self.at.temperatures.get(column));
        history.map_or(0.0, |h| h.warmer_k(self.at.time_s, self.shape))
    }

    /// The displacement at the target for `mm` of the parameter of a station, or of the frame of an instrument.
    fn frame_motion(&self, mm: f64) -> Vector3<f64> {
        match self.parameter.checked_sub(3) {
            None => Vector3::ith(self.parameter, mm),
            Some(about) => {
                let turn_rad = Vector3::ith(about, mm / MICROMETRE * ARCSEC);
                turn_rad.cross(&self.at.point_mm.coords)
            }
        }
    }

    /// Whether the axis of the subject is the one that moves between the readings.
    fn is_of_moving_axis(&self) -> bool {
        self.subject.axis == Some(self.at.axis)
    }

    /// The displacement of the target if the axis of the subject goes further, by mm or rad.
    fn further(&self, by: f64) -> Displaced {
        let axis = self.subject.axis;
        axis.map_or_else(Displaced::default, |axis| {
            Displaced::point(self.at.unit_motion(axis) * by)
        })
    }

    /// One µm, of a rotary axis one arcsec, in mm or rad.
    fn unit(&self) -> f64 {
        match self.axis().map(Axis::kind) {
            Some(AxisKind::Rotary) => ARCSEC,
            _ => MICROMETRE,
        }
    }
}

impl Effect {
    /// What one unit of parameter `parameter` does to a reading: nothing to another station or target
    /// than that of the subject, or to one that its carrier does not move, nothing up to the instant of an effect that
    /// has one, and nothing of the machine to a target on the bed.
    pub fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        // What the machine does, it does not do to its bed.
        let is_reached = self.layer != Layer::Machine || at.carrier.is_some();
        let is_there = is_reached && (self.shape != Shape::Instant || at.time_s > shape);
        let is_carried = subject.carrier.is_none_or(|axis| at.is_carried_by(axis));
        let is_concerned = subject.has_station(at.station) && subject.has_target(at.target);
        if !(is_there && is_concerned && is_carried) {
            return Displaced::default();
        }
        let of = Term {
            subject,
            parameter,
            shape,
            at,
        };
        let along = |mm: f64| Vector3::ith(parameter, mm);
        match self.form {
            Form::Length(value) => Displaced::length(value(&of)),
            Form::Scale(value) => Displaced::length(PPM * at.distance_mm * value(&of)),
            Form::Station(value) => Displaced::station(of.frame_motion(value(&of))),
            Form::Target(value) => Displaced::point(along(value(&of))),
            Form::TargetOnStage(value) => Displaced::point(at.ref_from_stage() * along(value(&of))),
            Form::Displacement(value) => Displaced::point(value(&of)),
            Form::Growth(value) => of.further(value(&of) * of.position()),
            Form::Delay(late_s) if of.is_of_moving_axis() => of.further(at.speed_per_s * late_s),
            Form::LostMotion(value) if of.is_of_moving_axis() => {
                of.further(-0.5 * at.direction * of.unit() * value(&of))
            }
            Form::Delay(_) | Form::LostMotion(_) => Displaced::default(),
            // Error curves.
            _ => subject.axis.map_or_else(Displaced::default, |axis| {
                let place = AxisPosition {
                    axis: &at.machine.axes()[axis],
                    position: at.position(axis),
                    direction: at.direction,
                };
                let motion = self.motion(subject, parameter, shape, &place);
                Displaced::point(at.moved(axis, &motion))
            }),
        }
    }

    /// What it does to a reading with the values `parameters`, in the units of [`Effect::parameters`].
    pub fn displacement(
        &self,
        subject: &Subject,
        parameters: &[f64],
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        let mut sum = Displaced::default();
        for (k, value) in parameters.iter().enumerate() {
            sum.add(*value, &self.form(subject, k, shape, at));
        }
        sum
    }

    /// What one unit of parameter `parameter` adds to the component errors of its axis, mm and rad,
    /// before the least-squares gauge; nothing for an effect that is not part of an error curve.
    pub fn motion(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &AxisPosition<'_>,
    ) -> MotionError {
        let of = Term {
            subject,
            parameter,
            shape,
            at,
        };
        match self.form {
            Form::Positioning(value) => {
                let along = at.axis.direction().into_inner();
                MotionError::new(along * value(&of), Vector3::zeros())
            }
            Form::Component(value) | Form::Curves(value) => value(&of),
            Form::WavesAbout(waves) => waves_about_axis(waves.unwrap_or(shape), &of),
            Form::WavesAcross(components) => waves_across_axis(components, &of),
            _ => MotionError::default(),
        }
    }
}

impl Circumstances<'_> {
    /// `R (δ + ε × r)`: displacement of the target if the component errors of an axis change, mm. Zero if the
    /// axis does not move the target.
    pub(crate) fn moved(&self, axis: usize, by: &MotionError) -> Vector3<f64> {
        if !self.is_carried_by(axis) {
            return Vector3::zeros();
        }
        let ref_from_base = self.ref_from_base(axis);
        let position = self.position(axis);
        let axis = &self.machine.axes()[axis];
        let reference = match axis.kind() {
            AxisKind::Linear => axis.reference_mm() + axis.direction().into_inner() * position,
            AxisKind::Rotary => axis.reference_mm(),
        };
        let r = ref_from_base.inverse() * self.point_mm - reference;
        ref_from_base.rotation * by.displacement_mm(r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, effect};
    use trueaxis_kinematics::Machine;

    /// Without stations a frame has six parameters; one arcsec about z moves what is a metre along x by 4.848 µm.
    #[test]
    fn the_frame_of_an_instrument_turns() {
        let x = Axis::linear("X", Vector3::x(), [0.0, 400.0]).unwrap();
        let machine = Machine::new(vec![x], vec![0], vec![]).unwrap();
        let scene = Scene {
            machine: machine.clone(),
            stations: Vec::new(),
            targets: Vec::new(),
            moving: vec![0],
            temperatures: Vec::new(),
        };
        let jump = effect("station_jump").unwrap();
        let subjects = jump.subjects(&scene);
        assert_eq!(subjects, [Subject::default()]);
        assert_eq!(jump.parameters(&scene, &subjects[0]).len(), 6);
        let at = Circumstances {
            time_s: 2.0,
            positions: &[0.0],
            point_mm: nalgebra::Point3::new(1000.0, 0.0, 0.0),
            ..Circumstances::new(&machine)
        };
        let turned = jump.form(&subjects[0], 5, 1.0, &at).station_mm;
        assert!((turned - Vector3::new(0.0, 4.848_136_811e-3, 0.0)).norm() < 1e-12);
        let along = jump.form(&subjects[0], 1, 1.0, &at).station_mm;
        assert_eq!(along, Vector3::new(0.0, MICROMETRE, 0.0));
    }
}
