//! What a coordinate of something that wanders moves: a parameter of an effect of the catalogue, or the geometry of an axis.

use nalgebra::{Rotation3, Vector3};
use trueaxis_effects::{Circumstances, Displaced, Effect, Subject, effect};
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, MICROMETRE};

/// One of the things that move in a course of their own.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Coordinate {
    /// A unit of a parameter of an effect.
    Effect(&'static Effect, usize),
    /// What an axis carries is displaced along the axis, or along a direction of what carries the axis, or turned about one and the
    /// centroid of its targets: a micrometre or an arc second, by a function of where the axis stands, whether it runs or is parked.
    Geometry(Motion, Law),
}

/// How something is moved that an axis carries.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Motion {
    /// The axis goes further.
    Along,
    /// Along a direction of what carries it.
    Displaced(usize),
    /// About a direction of what carries it.
    Turned(usize),
}

/// How it depends on where the axis stands: Legendre's polynomials of the position of a linear axis over its travel, and
/// `1, cos φ, sin φ` of a rotary one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Law(usize);

/// Forms of a displacement over the position: what is turned, straight and bent.
const OF_DISPLACEMENT: usize = 3;

/// Forms of a turn of the stage of a linear axis, and of a rotary one.
const OF_TURN: [usize; 2] = [2, 3];

/// The first parameters of an effect of the catalogue.
pub(crate) fn parameters(id: &str, count: usize) -> impl Iterator<Item = Coordinate> {
    let known = effect(id).into_iter();
    known.flat_map(move |effect| (0..count).map(move |k| Coordinate::Effect(effect, k)))
}

/// A linear axis grows and shrinks, and nobody knows the point from which: the middle of its travel, and one end against it.
pub(crate) fn scale() -> impl Iterator<Item = Coordinate> {
    (0..2).map(|degree| Coordinate::Geometry(Motion::Along, Law(degree)))
}

/// An axis guides otherwise: straight, bent, turned, from its parts displaced.
pub(crate) fn geometry(kind: AxisKind) -> Vec<Coordinate> {
    let of_turn = OF_TURN[usize::from(kind == AxisKind::Rotary)];
    let displaced = (0..3).map(|along| (Motion::Displaced(along), OF_DISPLACEMENT));
    let turned = (0..3).map(|about| (Motion::Turned(about), of_turn));
    let laws = |(motion, count)| (0..count).map(move |k| Coordinate::Geometry(motion, Law(k)));
    displaced.chain(turned).flat_map(laws).collect()
}

/// A curve in which coordinates are shown: a factor of each of some of them.
pub(crate) type Shown = Vec<(usize, f64)>;

/// What is shown of coordinates with the displacement of each by a unit, µm: each by itself; of a scale the middle, and how much
/// further one end is from the other; of a geometry the motions of the stage at a place where the laws of the axis have these values.
pub(crate) fn shown(coordinates: &[Coordinate], units_um: &[f64], laws: &[f64; 3]) -> Vec<Shown> {
    let mut shown: Vec<Shown> = Vec::new();
    for (c, (coordinate, &unit_um)) in coordinates.iter().zip(units_um).enumerate() {
        match *coordinate {
            Coordinate::Effect(..) | Coordinate::Geometry(_, Law(0)) => {
                shown.push(vec![(c, unit_um)]);
            }
            // From one end to the other the law goes from -1 to 1.
            Coordinate::Geometry(Motion::Along, _) => shown.push(vec![(c, 2.0)]),
            Coordinate::Geometry(_, Law(degree)) => {
                // They follow the first law of their motion.
                if let Some(own) = shown.last_mut() {
                    let of_first_um = own[0].1;
                    own.push((c, of_first_um * laws[degree]));
                }
            }
        }
    }
    shown
}

/// What a unit of each coordinate does to a reading.
pub(crate) fn moved(
    coordinates: &[Coordinate],
    subject: &Subject,
    at: &Circumstances<'_>,
) -> Vec<Displaced> {
    let carried = subject.axis.filter(|&axis| at.is_carried_by(axis));
    let stage = carried.map(|axis| Stage::new(axis, at));
    let moved = coordinates.iter().map(|coordinate| match coordinate {
        Coordinate::Effect(effect, k) => effect.form(subject, *k, f64::NEG_INFINITY, at),
        Coordinate::Geometry(motion, law) => {
            let moved = stage.as_ref().map(|stage| stage.moved(*motion, *law));
            Displaced::point(moved.unwrap_or_default())
        }
    });
    moved.collect()
}

/// The laws at a position of an axis, mm or rad.
pub(crate) fn laws(axis: &Axis, position: f64) -> [f64; 3] {
    match axis.kind() {
        AxisKind::Linear => {
            let [low, high] = axis.travel();
            let x = (2.0 * position - low - high) / (high - low);
            [1.0, x, 1.5 * x * x - 0.5]
        }
        AxisKind::Rotary => [1.0, position.cos(), position.sin()],
    }
}

/// What an axis carries, at a reading.
struct Stage {
    /// What the axis moves the target by, 1 mm or 1 rad.
    along: Vector3<f64>,
    ref_from_base: Rotation3<f64>,
    arm_mm: Vector3<f64>,
    laws: [f64; 3],
}

impl Stage {
    fn new(axis: usize, at: &Circumstances<'_>) -> Self {
        Self {
            along: at.unit_motion(axis),
            ref_from_base: at.ref_from_base(axis).rotation.to_rotation_matrix(),
            arm_mm: at.point_mm - at.centroid_mm,
            laws: laws(&at.machine.axes()[axis], at.position(axis)),
        }
    }

    /// By a micrometre, or by an arc second, mm.
    fn moved(&self, motion: Motion, law: Law) -> Vector3<f64> {
        let direction = |k: usize| self.ref_from_base.matrix().column(k).into_owned();
        let moved = match motion {
            Motion::Along => self.along * MICROMETRE,
            Motion::Displaced(k) => direction(k) * MICROMETRE,
            Motion::Turned(k) => direction(k).cross(&self.arm_mm) * ARCSEC,
        };
        moved * self.laws[law.0]
    }
}
