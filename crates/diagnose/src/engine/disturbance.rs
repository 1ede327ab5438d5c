//! A disturbance: a smooth process of unknown form.
//!
//! Something (the machine, the tripods, the air, a station, a target, the lost motion of an axis) moves with time, or
//! with the position of an axis, in an unknown course. Over the argument `x`, 0 to 1, each coordinate is
//!
//! ```text
//! f(x) = Σ_k b_k cos(kπx)      b_k ~ N(0, w² S_k)      S_k ~ (3/ℓ² + k²π²)⁻²      S_0 + ½ Σ S_k = 1
//! ```
//!
//! a process with Matérn's covariance (ν = 3/2) of correlation length `ℓ` and standard deviation `w` in the basis of
//! half waves (Solin and Särkkä 2020), which needs only a dozen columns for each coordinate. `ℓ` is one of a few,
//! equally likely a priori, none shorter than three stops: faster changes are repeatability.
//!
//! Who wanders, what moves, and with what, is in tables of `docs/diagnosis.md` (What wanders). Where lost motion, scale
//! and geometry of an axis change with time, the waves go beyond both ends of the campaign ([`mod@super::basis`]).
//!
//! There is no axis with position alone: the free poses of the base model absorb it, and so they absorb the mean of
//! its geometry. Without targets on the bed the machine with time and all tripods (the frame without its rotations)
//! with time are the same thing under two names, and both are always given.

use trueaxis_effects::{BACKLASH, Layer, Scene, Subject};
use trueaxis_kinematics::AxisKind;
use trueaxis_selection::Hypothesis;

use crate::engine::basis::Basis;
use crate::engine::coordinate::{Coordinate, geometry, parameters, scale, stage};
use crate::engine::form::Form;
use crate::engine::smooth::correlation_lengths;
use crate::numbers::distinct;

/// Something that may wander, and with what it varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Wanderer {
    pub(crate) who: Who,
    pub(crate) with: With,
}

/// What may wander.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Who {
    /// The zero of the instrument that reads.
    Instrument,
    Machine,
    Tripods,
    /// The frame in which coordinates are measured.
    Frame,
    Air,
    Station(usize),
    Target(usize),
    Axis(usize),
}

/// What it varies with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum With {
    /// Time in the occupation of a station, with a course for each occupation.
    Occupation,
    /// Time from the first to the last reading.
    Campaign,
    /// Position of the axis that runs, with a course for each axis.
    Position,
    /// Position of an axis, with opposite signs for the two sides of approach.
    Sides,
    /// The same of the other motions of what the axis carries.
    StageBySides,
    /// Time, with opposite signs for the two sides of approach of an axis.
    SidesInTime,
    /// Time, by functions of the position of an axis.
    TimeAndPosition,
}

/// A disturbance with its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Disturbance {
    pub(crate) wanderer: Wanderer,
    pub(crate) form: Form,
    /// w, in the unit of what moves (µm, ppm, arcsec).
    pub(crate) width: f64,
}

/// All three for an axis that mostly tilts, one that is also out of square, and one that hardly tilts. It may tilt at home or not:
/// rotations that it does not make, which all readings would show, cost much of 2 ln B.
const OF_GEOMETRY: [[f64; 3]; 6] = [
    [0.5, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [8.0, 0.0, 0.0],
    [0.5, 1.0, 0.0],
    [2.0, 1.0, 0.0],
    [8.0, 1.0, 0.0],
];

/// The same of a rotary axis that leans twice a turn, too.
const TWICE_A_TURN: [[f64; 3]; 2] = [[2.0, 0.0, 0.5], [2.0, 1.0, 0.5]];

/// Time and place of a reading.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Here {
    pub(crate) station: usize,
    pub(crate) target: usize,
    /// The axis that runs.
    pub(crate) axis: Option<usize>,
    pub(crate) time_s: f64,
    /// Progress of time in the occupation, and in the campaign, 0 to 1.
    pub(crate) occupation: f64,
    pub(crate) campaign: f64,
    /// Position of the axis in its range, 0 to 1.
    pub(crate) travelled: f64,
    /// Side of approach, +1 or -1.
    pub(crate) side: f64,
}

impl Wanderer {
    pub(crate) const fn new(who: Who, with: With) -> Self {
        Self { who, with }
    }

    /// The layer to which it belongs.
    pub(crate) fn layer(self) -> Layer {
        match self.who {
            Who::Machine | Who::Axis(_) => Layer::Machine,
            Who::Tripods | Who::Frame | Who::Target(_) => Layer::Setup,
            Who::Station(_) if self.with == With::Occupation => Layer::Setup,
            Who::Instrument | Who::Air | Who::Station(_) => Layer::Instrument,
        }
    }

    /// Station, target or axis; empty for what concerns everything.
    pub(crate) fn subject(self) -> Subject {
        match self.who {
            Who::Instrument | Who::Machine | Who::Tripods | Who::Frame | Who::Air => {
                Subject::default()
            }
            Who::Station(station) => Subject::station(station),
            Who::Target(target) => Subject::target(target),
            Who::Axis(axis) => Subject::axis(axis),
        }
    }

    /// Number of wanderers of the same kind, which share the prior probability.
    pub(crate) fn of_kind(self, scene: &Scene) -> usize {
        match self.who {
            Who::Instrument | Who::Machine | Who::Tripods | Who::Frame | Who::Air => 1,
            Who::Station(_) => scene.stations.len(),
            Who::Target(_) => scene.targets.len(),
            Who::Axis(_) => scene.machine.axes().len(),
        }
    }

    /// Whether the geometry or the drive of an axis changes with time.
    pub(crate) fn is_of_changing_axis(self) -> bool {
        let is_of_axis = matches!(self.who, Who::Axis(_));
        is_of_axis && !matches!(self.with, With::Sides | With::StageBySides)
    }

    /// Whether a cause is the mean that its course does not have: the lost motion that changes.
    pub(crate) fn changes(self, cause: &Hypothesis) -> bool {
        matches!(self.with, With::Sides | With::SidesInTime) && self.has_lost_motion(cause)
    }

    /// Whether a cause is lost motion of an axis that also stands otherwise by side: turned about another line than is
    /// assumed, it loses some motion.
    pub(crate) fn turns_beside(self, cause: &Hypothesis) -> bool {
        self.with == With::StageBySides && self.has_lost_motion(cause)
    }

    fn has_lost_motion(self, cause: &Hypothesis) -> bool {
        cause.effect == BACKLASH && cause.subject == self.subject()
    }

    /// The coordinates that move.
    pub(crate) fn coordinates(self, scene: &Scene) -> Vec<Coordinate> {
        let moved: &[(&str, usize)] = match (self.who, self.with) {
            (Who::Machine, _) => &[("machine_shift", 3)],
            (Who::Tripods, _) => &[("station_jump", 3)],
            // Without a station the frame has rotations, too.
            (Who::Frame, _) => &[("station_jump", 6)],
            (Who::Air, _) => &[("station_scale", 1)],
            // Lengths and points have no such zero.
            (Who::Instrument, _) => &[],
            (Who::Station(_), With::Position) => &[("dead_path_jump", 1)],
            (Who::Station(_), _) => &[("station_jump", 3), ("dead_path_jump", 1)],
            (Who::Target(_), _) => &[("target_slip", 3)],
            (Who::Axis(axis), With::TimeAndPosition) => {
                return geometry(scene.machine.axes()[axis].kind());
            }
            (Who::Axis(_), With::Campaign) => return scale(),
            (Who::Axis(axis), With::StageBySides) => return stage(&scene.machine.axes()[axis]),
            (Who::Axis(_), _) => &[("backlash", 1)],
        };
        let all = moved.iter().flat_map(|&(id, count)| parameters(id, count));
        all.collect()
    }

    /// The functions that make up the course of each coordinate. The mean of lost motion is an effect in the
    /// catalogue, and the mean of an axis' motion is its error curve.
    pub(crate) fn basis(self) -> Basis {
        match (self.who, self.with) {
            (Who::Axis(_), With::Campaign) => Basis::beyond(20),
            (_, With::SidesInTime | With::TimeAndPosition) => Basis::beyond(10),
            (_, With::Sides) => Basis::within(8, false),
            (_, With::StageBySides) => Basis::within(2, true),
            (Who::Target(_), With::Position) => Basis::within(6, true),
            (_, With::Occupation | With::Position) => Basis::within(12, true),
            (_, With::Campaign) => Basis::within(16, true),
        }
    }

    /// The course (occupation, axis) to which a reading belongs, and its argument, 0 to 1; `None` if it does not concern the reading.
    fn place(self, here: &Here) -> Option<(usize, f64)> {
        let is_concerned = match self.who {
            Who::Instrument | Who::Machine | Who::Tripods | Who::Frame | Who::Air => true,
            Who::Station(station) => here.station == station,
            Who::Target(target) => here.target == target,
            // A parked axis has a position, too.
            Who::Axis(_) if matches!(self.with, With::Campaign | With::TimeAndPosition) => true,
            Who::Axis(axis) => here.axis == Some(axis),
        };
        let place = match self.with {
            With::Occupation => (here.station, here.occupation),
            With::Campaign | With::SidesInTime | With::TimeAndPosition => (0, here.campaign),
            With::Position => (here.axis?, here.travelled),
            With::Sides | With::StageBySides => (0, here.travelled),
        };
        is_concerned.then_some(place)
    }

    /// Its courses: occupations or axes.
    pub(crate) fn courses(self, all: &[Here]) -> Vec<usize> {
        let places = all.iter().filter_map(|here| self.place(here));
        distinct(places.map(|place| place.0))
    }

    /// All its priors, equally likely, for courses with this number of stops.
    pub(crate) fn forms(self, scene: &Scene, stops: usize) -> Vec<Form> {
        let [ratios, twice]: [&[[f64; 3]]; 2] = match (self.with, self.who) {
            (With::TimeAndPosition, Who::Axis(axis)) => match scene.machine.axes()[axis].kind() {
                AxisKind::Linear => [&OF_GEOMETRY, &[]],
                AxisKind::Rotary => [&OF_GEOMETRY, &TWICE_A_TURN],
            },
            _ => [&[[1.0; 3]], &[]],
        };
        let lengths = correlation_lengths(stops).into_iter();
        let forms = lengths.flat_map(|length| {
            let of_one = ratios.iter().chain(twice);
            of_one.map(move |&[displaced, turned_at_home, twice_a_turn]| Form {
                displaced,
                turned_at_home,
                twice_a_turn,
                ..Form::smooth(length)
            })
        });
        forms.collect()
    }

    /// `S_k^½` for each column.
    pub(crate) fn roots_of_spectrum(self, scene: &Scene, all: &[Here], form: Form) -> Vec<f64> {
        let roots = self.basis().roots_of_spectrum(form.length);
        let coordinates = self.coordinates(scene).into_iter();
        let of_course = coordinates.flat_map(|coordinate| {
            let roots = roots.iter();
            roots.map(move |root| coordinate.prior(form) * root)
        });
        let of_course: Vec<f64> = of_course.collect();
        of_course.repeat(self.courses(all).len())
    }

    /// Displacements by a unit of each coefficient, course after course, coordinate after coordinate, for readings of
    /// `ROWS` rows each: `unit` gives those of a reading by a unit of each coordinate.
    pub(crate) fn columns<const ROWS: usize>(
        self,
        scene: &Scene,
        all: &[Here],
        unit: impl Fn(usize, &[Coordinate]) -> Vec<[f64; ROWS]>,
    ) -> Vec<Vec<f64>> {
        let courses = self.courses(all);
        let coordinates = self.coordinates(scene);
        let basis = self.basis();
        let width = basis.width();
        let count = courses.len() * coordinates.len() * width;
        let mut columns = vec![vec![0.0; ROWS * all.len()]; count];
        let mut waves = Vec::with_capacity(width);
        for (i, here) in all.iter().enumerate() {
            let Some((course, x)) = self.place(here) else {
                continue;
            };
            let Ok(course) = courses.binary_search(&course) else {
                continue;
            };
            // Lost motion, an effect in the catalogue, knows its sign.
            let sign = match self.with {
                With::StageBySides => here.side,
                _ => 1.0,
            };
            waves.clear();
            waves.extend(basis.at(x).map(|wave| sign * wave));
            for (c, moved) in unit(i, &coordinates).into_iter().enumerate() {
                let first = (course * coordinates.len() + c) * width;
                for (column, wave) in columns[first..].iter_mut().zip(&waves) {
                    for (row, along) in moved.into_iter().enumerate() {
                        column[ROWS * i + row] = wave * along;
                    }
                }
            }
        }
        columns
    }
}

/// The targets and axes that may wander; `comes_from` says whether an axis, while it ran, came from a side.
pub(crate) fn targets_and_axes(
    scene: &Scene,
    comes_from: impl Fn(usize, f64) -> bool,
) -> Vec<Wanderer> {
    let targets = (0..scene.targets.len()).map(Who::Target);
    let of_target = |own| [With::Campaign, With::Position].map(|with| Wanderer::new(own, with));
    let mut all: Vec<Wanderer> = targets.flat_map(of_target).collect();
    for (axis, own) in scene.machine.axes().iter().enumerate() {
        let sides = [1.0, -1.0].map(|side| comes_from(axis, side));
        let mut add = |with, is_there: bool| {
            all.extend(is_there.then_some(Wanderer::new(Who::Axis(axis), with)));
        };
        let (moves, is_linear) = (sides.contains(&true), own.kind() == AxisKind::Linear);
        add(With::Sides, sides == [true; 2]);
        add(With::SidesInTime, sides == [true; 2]);
        add(With::StageBySides, sides == [true; 2]);
        add(With::Campaign, moves && is_linear);
        add(With::TimeAndPosition, moves);
    }
    all
}

/// A size has converged if it changes by less than this share of itself: the rest of the data hardly depends on it.
const RESTS: f64 = 0.1;

impl Disturbance {
    /// Whether it is another one than before.
    pub(crate) fn has_moved(&self, before: &Self) -> bool {
        (self.width - before.width).abs() > RESTS * before.width || self.form != before.form
    }

    /// Columns of coefficients scaled to unit prior variance.
    pub(crate) fn scaled(
        &self,
        scene: &Scene,
        all: &[Here],
        mut columns: Vec<Vec<f64>>,
    ) -> Vec<Vec<f64>> {
        let roots = self.wanderer.roots_of_spectrum(scene, all, self.form);
        for (column, root) in columns.iter_mut().zip(roots) {
            column.iter_mut().for_each(|x| *x *= self.width * root);
        }
        columns
    }
}
