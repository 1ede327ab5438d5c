//! Report of what wanders: how much, how fast, and its curve, with units.

use trueaxis_effects::{Level, Subject};
use trueaxis_kinematics::AxisKind;

use crate::engine::Posterior;
use crate::engine::disturbance::{Here, Wanderer, With};
use crate::engine::wandering::{JudgedDisturbance, Wanders, units_um, whitened_columns};
use crate::selection::{combined, dot};
use crate::{CorrelationLength, CurvePoint, Disturbance, Gain, Wandering};

/// Points of a curve, all occupations together.
const POINTS: usize = 33;

/// The disturbances of a model; `gain` if there is nothing else that gains.
pub(crate) fn wandered<D: Wanders>(
    base: &D,
    level: Level,
    adjusted: &D::Model,
    judged: Vec<JudgedDisturbance>,
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let all = base.here();
    let report = |judged: JudgedDisturbance| {
        let wanderer = judged.disturbance.wanderer;
        let coefficients = Coefficients::new(base, &all, adjusted, &judged);
        let course = coefficients.course();
        let (range, unit) = range(base, &all, wanderer, course);
        Disturbance {
            level,
            data: String::new(),
            whose: whose(level, wanderer, course),
            p_value: judged.p_value,
            rms_um: coefficients.rms_um,
            share: 0.0,
            correlation_length: CorrelationLength {
                value: judged.disturbance.length * (range[1] - range[0]),
                unit,
            },
            period: None,
            heldout_gain: gain.map(|gain| 1.0 - gain.heldout_rms_ratio),
            curve: coefficients.curve(base, course),
            rivals: judged
                .rivals
                .iter()
                .map(|&w| whose(level, w, None))
                .collect(),
        }
    };
    judged.into_iter().map(report).collect()
}

/// What wanders, by its public name; with the position of the axis of one course.
pub(crate) fn whose(level: Level, wanderer: Wanderer, course: Option<usize>) -> Wandering {
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
        },
    }
}

/// The range of its argument, time or the positions of an axis, and the unit: s, mm or deg. Of occupations the longest.
fn range<D: Wanders>(
    base: &D,
    all: &[Here],
    wanderer: Wanderer,
    course: Option<usize>,
) -> ([f64; 2], &'static str) {
    if let Some(axis) = course.or(wanderer.subject().axis) {
        let ends = base.ends(axis);
        return match base.scene().machine.axes()[axis].kind() {
            AxisKind::Linear => (ends, "mm"),
            AxisKind::Rotary => (ends.map(f64::to_degrees), "deg"),
        };
    }
    if wanderer.with == With::Campaign {
        return (span_s(all.iter()), "s");
    }
    let courses = wanderer.courses(all).into_iter();
    let occupations =
        courses.map(|station| span_s(all.iter().filter(|here| here.station == station)));
    let longest = occupations.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    (longest.unwrap_or_default(), "s")
}

/// First and last of some readings, s.
fn span_s<'h>(some: impl Iterator<Item = &'h Here> + Clone) -> [f64; 2] {
    let times = some.map(|here| here.time_s);
    let first = times.clone().fold(f64::INFINITY, f64::min);
    [first, times.fold(first, f64::max)]
}

/// The coefficients of a disturbance given the data, in units of what they have beforehand.
struct Coefficients<'h> {
    all: &'h [Here],
    wanderer: Wanderer,
    posterior: Posterior,
    /// Standard deviation beforehand of the coefficients, µm of displacement.
    roots_um: Vec<f64>,
    rms_um: f64,
}

impl<'h> Coefficients<'h> {
    fn new<D: Wanders>(
        base: &D,
        all: &'h [Here],
        adjusted: &D::Model,
        judged: &JudgedDisturbance,
    ) -> Self {
        let own = &judged.disturbance;
        let in_mm = own.scaled(all, base.columns_mm(adjusted, own.wanderer));
        let columns = whitened_columns(base, adjusted, own);
        let posterior = Posterior::new(D::projection(adjusted), &columns);
        let rows = in_mm.first().map_or(0, Vec::len);
        let sums_mm = combined(rows, &in_mm, &posterior.mean);
        let units_um = units_um(base, adjusted, own.wanderer);
        let width = own.wanderer.basis(0.0).count();
        let roots = own.wanderer.roots_of_spectrum(all, own.length);
        let roots_um = roots.iter().enumerate().map(|(k, root)| {
            let unit_um = units_um[k / width % units_um.len()];
            root * own.width * unit_um
        });
        Self {
            all,
            wanderer: own.wanderer,
            posterior,
            roots_um: roots_um.collect(),
            rms_um: 1e3 * (dot(&sums_mm, &sums_mm) / sums_mm.len() as f64).sqrt(),
        }
    }

    /// Of what varies with the positions of several axes the one with which it varies most.
    fn course(&self) -> Option<usize> {
        let courses = self.wanderer.courses(self.all);
        let of_one = self.posterior.mean.len() / courses.len().max(1);
        let size = |k: usize| {
            let own = k * of_one..(k + 1) * of_one;
            let varies = own.filter(|i| i % self.wanderer.basis(0.0).count() > 0);
            varies
                .map(|i| (self.posterior.mean[i] * self.roots_um[i]).powi(2))
                .sum::<f64>()
        };
        let is_of_axes = self.wanderer.with == With::Position;
        let largest = (0..courses.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
        largest.filter(|_| is_of_axes).map(|k| courses[k])
    }

    /// Each coordinate with its standard uncertainty over time, occupation after occupation, or over the positions of `axis`.
    fn curve<D: Wanders>(&self, base: &D, axis: Option<usize>) -> Vec<CurvePoint> {
        let courses = self.wanderer.courses(self.all);
        let shown: Vec<usize> = match axis {
            Some(axis) => courses
                .iter()
                .position(|&c| c == axis)
                .into_iter()
                .collect(),
            None => (0..courses.len()).collect(),
        };
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
            for point in 0..points {
                let x = point as f64 / (points - 1) as f64;
                let (value_um, u_um) = self.at(course, x);
                curve.push(CurvePoint {
                    at: ends[0] + x * (ends[1] - ends[0]),
                    value_um,
                    u_um,
                });
            }
        }
        curve
    }

    /// All coordinates at a place of a course, 0 to 1, and their standard uncertainties, µm: from their mean over the
    /// course, since the base model takes that for the place of a station or a target.
    fn at(&self, course: usize, x: f64) -> (Vec<f64>, Vec<f64>) {
        let mut basis: Vec<f64> = self.wanderer.basis(x).collect();
        if self.wanderer.has_mean() {
            basis[0] = 0.0;
        }
        let width = basis.len();
        let coordinates = self.wanderer.coordinates().len();
        let of_coordinate = |c: usize| {
            let first = (course * coordinates + c) * width;
            let row: Vec<f64> = (0..width)
                .map(|k| basis[k] * self.roots_um[first + k])
                .collect();
            let (value, variance) = self.posterior.of(first, &row);
            (value, variance.sqrt())
        };
        (0..coordinates).map(of_coordinate).unzip()
    }
}
