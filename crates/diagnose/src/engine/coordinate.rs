//! What a coordinate of a disturbance moves: a parameter of an effect in the catalogue, or the geometry of an axis.

use nalgebra::{Rotation3, Vector3};
use trueaxis_effects::{Circumstances, Displaced, Effect, Subject, effect};
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Ideal, MICROMETRE};

use crate::engine::form::Form;

/// One of the quantities that vary, each with a course of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Coordinate {
    /// A unit of a parameter of an effect.
    Effect(&'static Effect, usize),
    /// What an axis carries is displaced along the axis or along a direction of the axis' carrier, or rotated about
    /// such a direction and the centroid of its targets, by an arc second or a comparable displacement, as a function
    /// of the position of the axis, whether it runs or is parked.
    Geometry(Motion, Law),
    /// Nothing: what an effect in the catalogue moves.
    Held,
}

impl Coordinate {
    /// The same at all positions of the axis.
    pub(crate) fn without_law(self) -> Self {
        match self {
            Self::Geometry(motion, _) => Self::Geometry(motion, Law::Constant),
            other => other,
        }
    }

    /// Its prior width as a multiple of that of the other coordinates.
    pub(crate) fn prior(self, form: Form) -> f64 {
        let Self::Geometry(motion, law) = self else {
            return 1.0;
        };
        let of_motion = match motion {
            Motion::Displaced(_) => form.displaced,
            Motion::Turned(_) | Motion::Along => 1.0,
        };
        of_motion
            * match (motion, law) {
                (Motion::Turned(_), Law::Constant) => form.turned_at_home,
                (_, Law::CosineTwice | Law::SineTwice) => form.twice_a_turn,
                _ => 1.0,
            }
    }
}

/// The motion of what an axis carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Motion {
    /// The linear axis travels further.
    Along,
    /// Along a direction of the axis' carrier.
    Displaced(usize),
    /// About a direction of the axis' carrier.
    Turned(usize),
}

/// The dependence on the position of the axis.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Law {
    Constant,
    /// Position relative to the middle, as a share of the travel, from -½ to ½.
    FromMiddle,
    /// Position relative to home as a share of the travel, `u`; for a rotary axis `cos φ - 1`.
    First,
    /// `u²`; for a rotary axis `sin φ`.
    Second,
    /// Of a rotary axis: `cos 2φ - 1`.
    CosineTwice,
    /// Of a rotary axis: `sin 2φ`.
    SineTwice,
}

/// The first parameters of an effect in the catalogue.
pub(crate) fn parameters(id: &str, count: usize) -> impl Iterator<Item = Coordinate> {
    let known = effect(id).into_iter();
    known.flat_map(move |effect| (0..count).map(move |k| Coordinate::Effect(effect, k)))
}

/// A linear axis grows and shrinks about an unknown point.
pub(crate) fn scale() -> Vec<Coordinate> {
    let laws = [Law::Constant, Law::FromMiddle];
    laws.map(|law| Coordinate::Geometry(Motion::Along, law))
        .into()
}

/// What an axis carries stands otherwise: displaced, then turned, about each direction. Along a linear axis or about a rotary
/// one this is lost motion.
pub(crate) fn stage(axis: &Axis) -> Vec<Coordinate> {
    let is_lost = |motion: &Motion| match (motion, axis.kind()) {
        (Motion::Displaced(k), AxisKind::Linear) | (Motion::Turned(k), AxisKind::Rotary) => {
            *k == axis.principal()
        }
        _ => false,
    };
    let displaced = (0..3).map(Motion::Displaced);
    let all = displaced.chain((0..3).map(Motion::Turned));
    let coordinate = |motion| match is_lost(&motion) {
        true => Coordinate::Held,
        false => Coordinate::Geometry(motion, Law::Constant),
    };
    all.map(coordinate).collect()
}

/// The geometry of an axis changes: squareness, straightness, bow and tilts. A displacement at home belongs to the
/// machine, a rotation at home to what the axis carries.
pub(crate) fn geometry(kind: AxisKind) -> Vec<Coordinate> {
    use Law::{Constant, CosineTwice, First, Second, SineTwice};
    let [displaced, turned]: [&[Law]; 2] = match kind {
        AxisKind::Linear => [&[First, Second], &[Constant, First]],
        AxisKind::Rotary => [
            &[First, Second, CosineTwice, SineTwice],
            &[Constant, First, Second, CosineTwice, SineTwice],
        ],
    };
    let displaced = (0..3).map(|k| (Motion::Displaced(k), displaced));
    let turned = (0..3).map(|k| (Motion::Turned(k), turned));
    let by_law = |(motion, laws): (Motion, &'static [Law])| {
        laws.iter()
            .map(move |&law| Coordinate::Geometry(motion, law))
    };
    displaced.chain(turned).flat_map(by_law).collect()
}

/// A curve to be shown: the factors on some of the coordinates.
pub(crate) type Shown = Vec<(usize, f64)>;

/// The curves to be shown, given the displacement by a unit of each coordinate without its law, µm: each coordinate
/// by itself; for a geometry the motions of the stage with the axis at a position, rotations by their displacements.
pub(crate) fn shown(
    coordinates: &[Coordinate],
    units_um: &[f64],
    geometry_at: Option<(&Axis, f64)>,
) -> Vec<Shown> {
    let mut shown: Vec<(Option<Motion>, Shown)> = Vec::new();
    for (c, coordinate) in coordinates.iter().enumerate() {
        match (*coordinate, geometry_at) {
            (Coordinate::Geometry(motion, law), Some((axis, position))) => {
                let own = (c, units_um[c] * law.at(axis, position));
                match shown.last_mut() {
                    Some((Some(last), all)) if *last == motion => all.push(own),
                    _ => shown.push((Some(motion), vec![own])),
                }
            }
            _ => shown.push((None, vec![(c, units_um[c])])),
        }
    }
    shown.into_iter().map(|(_, own)| own).collect()
}

/// The displacement of a reading by a unit of each coordinate.
pub(crate) fn moved(
    coordinates: &[Coordinate],
    subject: &Subject,
    at: &Circumstances<'_>,
) -> Vec<Displaced> {
    let carried = subject.axis.filter(|&axis| at.is_carried_by(axis));
    let stage = carried.map(|axis| Stage::new(axis, at));
    let moved = coordinates.iter().map(|coordinate| match coordinate {
        Coordinate::Held => Displaced::default(),
        Coordinate::Effect(effect, k) => effect.form(subject, *k, f64::NEG_INFINITY, at),
        Coordinate::Geometry(motion, law) => {
            let moved = stage.as_ref().map(|stage| stage.moved(*motion, *law));
            Displaced::point(moved.unwrap_or_default())
        }
    });
    moved.collect()
}

impl Law {
    /// The value of the law at a position of the axis, mm or rad.
    fn at(self, axis: &Axis, position: f64) -> f64 {
        let [low, high] = axis.travel();
        let u = position / (high - low);
        match (self, axis.kind()) {
            (Self::Constant, _) => 1.0,
            (Self::FromMiddle, _) => u - 0.5 * (low + high) / (high - low),
            (Self::First, AxisKind::Linear) => u,
            (Self::Second, AxisKind::Linear) => u * u,
            (Self::First, AxisKind::Rotary) => position.cos() - 1.0,
            (Self::Second, AxisKind::Rotary) => position.sin(),
            (Self::CosineTwice, _) => (2.0 * position).cos() - 1.0,
            (Self::SineTwice, _) => (2.0 * position).sin(),
        }
    }
}

/// The stage of an axis at a reading.
struct Stage<'a> {
    axis: &'a Axis,
    ref_from_base: Rotation3<f64>,
    /// From the pivot, which the stage of the axis carries: it is where the centroid of the targets would be if all
    /// axes on the stage were at home.
    arm_mm: Vector3<f64>,
    /// Position of the axis, mm or rad.
    position: f64,
}

impl<'a> Stage<'a> {
    fn new(axis: usize, at: &Circumstances<'a>) -> Self {
        let motion = |carrier| at.machine.motion(&Ideal, carrier, at.positions);
        let pivot_mm = match at.carrier == Some(axis) {
            true => at.centroid_mm,
            false => {
                motion(Some(axis)) * motion(at.carrier).inverse_transform_point(&at.centroid_mm)
            }
        };
        Self {
            axis: &at.machine.axes()[axis],
            ref_from_base: at.ref_from_base(axis).rotation.to_rotation_matrix(),
            arm_mm: at.point_mm - pivot_mm,
            position: at.position(axis),
        }
    }

    /// The displacement by a unit of a motion, mm.
    fn moved(&self, motion: Motion, law: Law) -> Vector3<f64> {
        let direction = |k: usize| self.ref_from_base.matrix().column(k).into_owned();
        let moved = match motion {
            Motion::Along => self.ref_from_base * self.axis.direction().into_inner() * MICROMETRE,
            Motion::Displaced(k) => direction(k) * self.unit_of_displacement_mm(),
            Motion::Turned(k) => direction(k).cross(&self.arm_mm) * ARCSEC,
        };
        moved * law.at(self.axis, self.position)
    }

    /// Displacement by an arc second over the travel of a linear axis; a micrometre for a rotary axis.
    fn unit_of_displacement_mm(&self) -> f64 {
        let [low, high] = self.axis.travel();
        match self.axis.kind() {
            AxisKind::Linear => ARCSEC * (high - low),
            AxisKind::Rotary => MICROMETRE,
        }
    }
}
