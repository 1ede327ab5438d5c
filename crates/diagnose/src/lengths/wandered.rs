//! What wanders, in words and units: how much, how fast, and its curve.

use trueaxis_effects::{Level, Subject};
use trueaxis_kinematics::AxisKind;

use crate::engine::Posterior;
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::disturbance::{Wanderer, With};
use crate::lengths::wandering::Judged;
use crate::selection::{combined, dot};
use crate::{CorrelationLength, CurvePoint, Disturbance, Gain, Wandering};

/// Points of a curve, all occupations together.
const POINTS: usize = 33;

/// The disturbances of a model; `gain` if there is nothing else that gains.
pub(crate) fn wandered(
    base: &Base<'_>,
    adjusted: &Adjusted,
    judged: Vec<Judged>,
    gain: Option<Gain>,
) -> Vec<Disturbance> {
    let report = |judged: Judged| {
        let wanderer = judged.disturbance.wanderer;
        let coefficients = Coefficients::new(base, adjusted, &judged);
        let course = coefficients.course(base);
        let range = range(base, wanderer, course);
        Disturbance {
            level: Level::Lengths,
            data: String::new(),
            whose: whose(wanderer, course),
            p_value: judged.p_value,
            rms_um: coefficients.rms_um,
            share: 0.0,
            correlation_length: CorrelationLength {
                value: judged.disturbance.length * (range[1] - range[0]),
                unit: unit(base, wanderer, course),
            },
            heldout_gain: gain.map(|gain| 1.0 - gain.heldout_rms_ratio),
            curve: coefficients.curve(base, course),
            rivals: judged.rivals.iter().map(|&w| whose(w, None)).collect(),
        }
    };
    judged.into_iter().map(report).collect()
}

/// What wanders, by its public name; with the position of the axis of one course.
fn whose(wanderer: Wanderer, course: Option<usize>) -> Wandering {
    Wandering {
        level: Level::Lengths,
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

/// The axis over whose positions it varies.
fn axis_of(wanderer: Wanderer, course: Option<usize>) -> Option<usize> {
    course.or(wanderer.subject().axis)
}

/// Its range: s, mm or degrees. Of occupations the longest.
fn range(base: &Base<'_>, wanderer: Wanderer, course: Option<usize>) -> [f64; 2] {
    match axis_of(wanderer, course) {
        Some(axis) => {
            let axis = &base.scene.machine.axes()[axis];
            axis.travel().map(|end| match axis.kind() {
                AxisKind::Linear => end,
                AxisKind::Rotary => end.to_degrees(),
            })
        }
        None if wanderer.with == With::Campaign => base.span_s,
        None => {
            let occupations = wanderer
                .courses(base)
                .into_iter()
                .map(|s| occupation_s(base, s));
            let longest = occupations.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
            longest.unwrap_or_default()
        }
    }
}

fn unit(base: &Base<'_>, wanderer: Wanderer, course: Option<usize>) -> &'static str {
    let kind = axis_of(wanderer, course).map(|axis| base.scene.machine.axes()[axis].kind());
    match kind {
        Some(AxisKind::Linear) => "mm",
        Some(AxisKind::Rotary) => "deg",
        None => "s",
    }
}

/// First and last reading of a station, s.
fn occupation_s(base: &Base<'_>, station: usize) -> [f64; 2] {
    let own = || base.readings.iter().filter(|r| r.station == station);
    let first = own().map(|r| r.time_s).fold(f64::INFINITY, f64::min);
    [first, own().map(|r| r.time_s).fold(first, f64::max)]
}

/// The coefficients of a disturbance given the lengths, in units of what they have beforehand.
struct Coefficients {
    wanderer: Wanderer,
    posterior: Posterior,
    /// Standard deviation beforehand of the coefficients, µm of displacement.
    roots_um: Vec<f64>,
    rms_um: f64,
}

impl Coefficients {
    fn new(base: &Base<'_>, adjusted: &Adjusted, judged: &Judged) -> Self {
        let own = &judged.disturbance;
        let in_mm = own.columns_mm(base, &adjusted.solution);
        let columns = base.whitened_columns(own, &adjusted.whitened, &adjusted.solution);
        let posterior = Posterior::new(&adjusted.projection, &columns);
        let sums_mm = combined(base.readings.len(), &in_mm, &posterior.mean);
        let unit_um = unit_um(base, adjusted, own.wanderer);
        let roots = own.wanderer.roots_of_spectrum(base, own.length);
        Self {
            wanderer: own.wanderer,
            posterior,
            roots_um: roots.iter().map(|r| r * own.width * unit_um).collect(),
            rms_um: 1e3 * (dot(&sums_mm, &sums_mm) / sums_mm.len() as f64).sqrt(),
        }
    }

    /// Of what varies with the positions of several axes the one with which it varies most.
    fn course(&self, base: &Base<'_>) -> Option<usize> {
        let courses = self.wanderer.courses(base);
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
    fn curve(&self, base: &Base<'_>, axis: Option<usize>) -> Vec<CurvePoint> {
        let courses = self.wanderer.courses(base);
        let shown: Vec<usize> = match axis {
            Some(axis) => courses
                .iter()
                .position(|&c| c == axis)
                .into_iter()
                .collect(),
            None => (0..courses.len()).collect(),
        };
        let points = POINTS.div_ceil(shown.len().max(1));
        let mut curve = Vec::new();
        for course in shown {
            let ends = match self.wanderer.with {
                With::Occupation => occupation_s(base, courses[course]),
                _ => range(base, self.wanderer, axis),
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
    /// course, since the base model takes that for the place of a station or a target. Lost motion has a mean.
    fn at(&self, course: usize, x: f64) -> (Vec<f64>, Vec<f64>) {
        let mut basis: Vec<f64> = self.wanderer.basis(x).collect();
        if self.wanderer.with != With::Sides {
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

/// How far a unit moves things, µm: rms over the readings that it concerns. Lost motion is twice what it moves.
fn unit_um(base: &Base<'_>, adjusted: &Adjusted, wanderer: Wanderer) -> f64 {
    let Some((effect, k)) = wanderer.coordinates().into_iter().next() else {
        return 0.0;
    };
    let subject = wanderer.subject();
    let squares = base.readings.iter().map(|reading| {
        let at = base.observation(reading, &adjusted.solution).at;
        let moved = effect.form(&subject, k, f64::NEG_INFINITY, &at);
        (moved.point_mm - moved.station_mm).norm_squared() + moved.length_mm.powi(2)
    });
    let (count, sum) = squares
        .filter(|square| *square > 0.0)
        .fold((0, 0.0), |(count, sum), square| (count + 1, sum + square));
    let times = if wanderer.with == With::Sides {
        2.0
    } else {
        1.0
    };
    times * 1e3 * (sum / f64::from(count.max(1))).sqrt()
}
