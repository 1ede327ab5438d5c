//! Report of disturbances: size, speed, and course, with units.

use std::f64::consts::{FRAC_PI_2, PI};

use trueaxis_effects::{Level, Subject};
use trueaxis_kinematics::{Axis, AxisKind};
use trueaxis_leastsquares::dot;
use trueaxis_selection::{Projection, combined};

use crate::engine::coordinate::{self, Coordinate, Shown};
use crate::engine::disturbance::{Here, Wanderer, Who, With};
use crate::engine::wandering::JudgedDisturbance;
use crate::engine::wanders::units_um;
use crate::engine::{Posterior, Wanders, whitened};
use crate::numbers::extremes;
use crate::{CorrelationLength, CurvePoint, Disturbance, Gain, Rival, Wandering};

impl JudgedDisturbance {
    /// As reported: `axis` is the one whose positions count, where there are several, and `range` that of the argument
    /// with its unit; `gain` if nothing else contributes to the gain.
    pub(crate) fn reported(
        &self,
        (level, axis): (Level, Option<usize>),
        ([first, last], unit): ([f64; 2], &'static str),
        (rms_um, curve): (f64, Vec<CurvePoint>),
        gain: Option<Gain>,
    ) -> Disturbance {
        let form = self.disturbance.form;
        let rivals = self.rivals.iter();
        Disturbance {
            level,
            data: String::new(),
            whose: whose(level, self.wanderer(), axis),
            p_value: self.p_value,
            rms_um,
            share: 0.0,
            correlation_length: CorrelationLength {
                value: form.length * (last - first),
                unit,
            },
            period: form.period.map(|period| period * (last - first)),
            heldout_gain: gain.map(|gain| 1.0 - gain.heldout_rms_ratio),
            curve,
            rivals: rivals.map(|&w| whose(level, w, None)).collect(),
        }
    }
}

/// The coefficients of a disturbance given the data, in units of their prior standard deviations.
pub(crate) struct Coefficients {
    posterior: Posterior,
    /// Prior standard deviations.
    roots: Vec<f64>,
    /// Number of coefficients of a course.
    of_course: usize,
    /// Effect of all on the rows from which they follow.
    pub(crate) effect: Vec<f64>,
}

impl Coefficients {
    /// From whitened columns in the covariance of a model, scaled to unit prior variance; for a number of courses.
    pub(crate) fn new(
        model: &Projection,
        columns: &[Vec<f64>],
        roots: Vec<f64>,
        courses: usize,
    ) -> Self {
        let posterior = Posterior::new(model, columns);
        Self {
            of_course: roots.len() / courses.max(1),
            effect: combined(model.rows(), columns, &posterior.mean),
            posterior,
            roots,
        }
    }

    /// Each coordinate of a course.
    pub(crate) fn coordinates(&self, functions: &[f64]) -> Vec<Shown> {
        let all = 0..self.of_course / functions.len();
        all.map(|coordinate| vec![(coordinate, 1.0)]).collect()
    }

    /// Combinations of the coordinates of a course where their functions have these values, and their standard
    /// uncertainties in standard deviations of the noise.
    pub(crate) fn at(
        &self,
        course: usize,
        functions: &[f64],
        shown: &[Shown],
    ) -> (Vec<f64>, Vec<f64>) {
        let first = course * self.of_course;
        let value = |own: &Shown| {
            let mut row = vec![0.0; self.of_course];
            for &(c, um) in own {
                for (k, function) in functions.iter().enumerate() {
                    let own = c * functions.len() + k;
                    row[own] = function * um * self.roots[first + own];
                }
            }
            let (value, variance) = self.posterior.of(first, &row);
            (value, variance.sqrt())
        };
        shown.iter().map(value).unzip()
    }
}

/// Number of points of a curve, all occupations together.
const POINTS: usize = 33;

/// The disturbances of lengths or points in a model.
pub(crate) fn wandered<D: Wanders>(
    base: &D,
    level: Level,
    adjusted: &D::Model,
    judged: &[JudgedDisturbance],
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let all = base.here();
    let report = |judged: &JudgedDisturbance| {
        let course = Course::new(base, &all, adjusted, judged);
        let axis = course.axis();
        let range = range(base, &all, judged.wanderer(), axis);
        let shown = (course.rms_um, course.curve(base, axis));
        judged.reported((level, axis), range, shown, gain)
    };
    judged.iter().map(report).collect()
}

impl Rival {
    /// A disturbance.
    pub(crate) fn of(level: Level, wanderer: Wanderer, two_ln_b: f64) -> Self {
        Self::Disturbance {
            whose: whose(level, wanderer, None),
            two_ln_b,
        }
    }
}

/// A wanderer by its public name; `course` selects the axis whose positions count.
fn whose(level: Level, wanderer: Wanderer, course: Option<usize>) -> Wandering {
    Wandering {
        level,
        layer: wanderer.layer(),
        subject: Subject {
            axis: course.or(wanderer.subject().axis),
            ..wanderer.subject()
        },
        varies_with: match wanderer.with {
            With::Occupation | With::Campaign => &["time"],
            With::Position => &["position"],
            With::Sides => &["position", "direction"],
            With::StageBySides => &["direction"],
            With::SidesInTime => &["time", "direction"],
            With::TimeAndPosition => &["time", "position"],
        },
    }
}

/// The range of the argument, time or positions of an axis, with its unit, s, mm or deg; for occupations the longest.
fn range<D: Wanders>(
    base: &D,
    all: &[Here],
    wanderer: Wanderer,
    course: Option<usize>,
) -> ([f64; 2], &'static str) {
    if matches!(
        wanderer.with,
        With::Position | With::Sides | With::StageBySides
    ) && let Some(axis) = course.or(wanderer.subject().axis)
    {
        let kind = base.scene().machine.axes()[axis].kind();
        let ends = base.ends(axis).map(|end| kind.position_in_file(end));
        return (ends, kind.position_unit());
    }
    if wanderer.with != With::Occupation {
        return (span_s(all.iter()), "s");
    }
    let courses = wanderer.courses(all).into_iter();
    let occupations =
        courses.map(|station| span_s(all.iter().filter(|here| here.station == station)));
    let longest = occupations.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    (longest.unwrap_or_default(), "s")
}

/// Earliest and latest time of some readings, s.
fn span_s<'h>(some: impl Iterator<Item = &'h Here>) -> [f64; 2] {
    extremes(some.map(|here| here.time_s))
}

/// The course of a disturbance in lengths or points.
struct Course<'h> {
    all: &'h [Here],
    wanderer: Wanderer,
    coefficients: Coefficients,
    coordinates: Vec<Coordinate>,
    /// Displacement by a unit of each coordinate, µm.
    units_um: Vec<f64>,
    rms_um: f64,
}

impl<'h> Course<'h> {
    fn new<D: Wanders>(
        base: &D,
        all: &'h [Here],
        adjusted: &D::Model,
        judged: &JudgedDisturbance,
    ) -> Self {
        let own = &judged.disturbance;
        let scene = base.scene();
        let in_mm = own.scaled(scene, all, base.courses_mm(adjusted, own.wanderer));
        let columns = whitened(base, adjusted, in_mm.clone());
        let roots = own.wanderer.roots_of_spectrum(scene, all, own.form);
        let roots = roots.iter().map(|root| root * own.width).collect();
        let courses = own.wanderer.courses(all).len();
        let coefficients = Coefficients::new(D::projection(adjusted), &columns, roots, courses);
        let rows = in_mm.first().map_or(0, Vec::len);
        let sums_mm = combined(rows, &in_mm, &coefficients.posterior.mean);
        Self {
            all,
            wanderer: own.wanderer,
            coefficients,
            coordinates: own.wanderer.coordinates(scene),
            units_um: units_um(base, adjusted, own.wanderer),
            rms_um: 1e3 * (dot(&sums_mm, &sums_mm) / sums_mm.len() as f64).sqrt(),
        }
    }

    /// For variation with the positions of several axes, the axis with the largest variation.
    fn axis(&self) -> Option<usize> {
        let courses = self.wanderer.courses(self.all);
        let own = &self.coefficients;
        let size = |k: usize| {
            let width = self.wanderer.basis().width();
            let of_course = k * own.of_course..(k + 1) * own.of_course;
            let varies = of_course.filter(|i| i % width > 0);
            let displaced = varies.map(|i| {
                let unit_um = self.units_um[i / width % self.units_um.len()];
                own.posterior.mean[i] * own.roots[i] * unit_um
            });
            displaced.map(|um| um * um).sum::<f64>()
        };
        let is_of_axes = self.wanderer.with == With::Position;
        let largest = (0..courses.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
        largest.filter(|_| is_of_axes).map(|k| courses[k])
    }

    /// Each coordinate with its standard uncertainty over time, by occupations, or over the positions of `axis`.
    fn curve<D: Wanders>(&self, base: &D, axis: Option<usize>) -> Vec<CurvePoint> {
        let courses = self.wanderer.courses(self.all);
        let is_shown = |k: &usize| axis.is_none_or(|axis| courses[*k] == axis);
        let shown: Vec<usize> = (0..courses.len()).filter(is_shown).collect();
        let points = POINTS.div_ceil(shown.len().max(1)).max(2);
        let mut curve = Vec::new();
        for course in shown {
            let ends = match self.wanderer.with {
                With::Occupation => {
                    let own = self.all.iter();
                    span_s(own.filter(|here| here.station == courses[course]))
                }
                _ => range(base, self.all, self.wanderer, axis).0,
            };
            for geometry_at in self.places(base) {
                let position = geometry_at.map(|(axis, at)| axis.kind().position_in_file(at));
                let shown = coordinate::shown(&self.coordinates, &self.units_um, geometry_at);
                for point in 0..points {
                    let x = point as f64 / (points - 1) as f64;
                    let (value_um, u_um) = self.at(course, x, &shown);
                    curve.push(CurvePoint {
                        at: ends[0] + x * (ends[1] - ends[0]),
                        position,
                        value_um,
                        u_um,
                    });
                }
            }
        }
        curve
    }

    /// The axis whose geometry is shown, at the ends of the measured range that are not home, for a rotary axis a
    /// quarter of a turn apart, mm or rad; `None` for anything else, which has no position.
    fn places<'b, D: Wanders>(&self, base: &'b D) -> Vec<Option<(&'b Axis, f64)>> {
        let (Who::Axis(axis), With::TimeAndPosition) = (self.wanderer.who, self.wanderer.with)
        else {
            return vec![None];
        };
        let own = &base.scene().machine.axes()[axis];
        let [low, high] = base.ends(axis);
        let places = match own.kind() {
            AxisKind::Linear => [low, high],
            AxisKind::Rotary => [high.min(low + FRAC_PI_2), high.min(low + PI)],
        };
        let away = places
            .into_iter()
            .filter(|place| place.abs() > 0.05 * (high - low));
        away.map(|place| Some((own, place))).collect()
    }

    /// All shown values at a place of a course, 0 to 1, with their standard uncertainties, µm, relative to the mean
    /// over the course, which the base model assigns to the position of a station or a target. No model has what differs by side.
    fn at(&self, course: usize, x: f64, shown: &[Shown]) -> (Vec<f64>, Vec<f64>) {
        let basis = self.wanderer.basis();
        let mut functions: Vec<f64> = basis.at(x).collect();
        if basis.has_mean() && self.wanderer.with != With::StageBySides {
            functions[0] = 0.0;
        }
        self.coefficients.at(course, &functions, shown)
    }
}
