//! What may move in an unknown course while readings are taken.
//!
//! Over its argument `x`, 0 to 1, each coordinate is a process with Matérn's covariance in half waves
//! ([`Basis`]), as with lengths, but without its mean: the base model or an effect takes that. Rows without a
//! clock do not show pauses between passes, in which drifts go on: each pass, or each cycle, may then also have an
//! offset. A course in time may also swing with one period, as an air conditioning does.
//!
//! What moves, and with what, is in a table of `docs/diagnosis-readings.md` (What wanders).

use std::f64::consts::TAU;

use trueaxis_leastsquares::median;
use trueaxis_selection::Hypothesis;

use crate::engine::basis::Basis;
use crate::engine::correlation_lengths;
use crate::engine::disturbance::With::{Campaign, Position, Sides, SidesInTime};
use crate::engine::disturbance::{Wanderer, Who};
use crate::engine::form::{Form, Pauses};
use crate::numbers::extremes;
use crate::verification::arrivals::Arrival;
use crate::verification::base::{count, cycles, places, runs_of_cycles};
use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::comes_from_both_sides;
use crate::verification::lost_motion::reached_from_both_sides;

/// Most half waves of each coordinate: five times those of the shortest correlation length. What is cut off would be
/// taken for the course of something else.
const MOST_WAVES: usize = 40;

/// Mean stops of a pass below which an offset for each would be noise.
const LEAST_STOPS: usize = 3;

/// Passes above which their offsets are a course by themselves.
const MOST_PASSES: usize = 60;

/// Points of a smooth curve.
const POINTS: u32 = 33;

/// Steps of the number of waves of a swing over the readings: one sixteenth of a wave more or less leaves 98 % of it.
const WAVE_STEP: f64 = 0.125;

/// Most waves of a swing over the readings.
const MOST_SWINGS: f64 = 16.0;

/// Least difference of the waves of a swing over the readings from the number of cycles, or a multiple of it, for it
/// to differ from all that repeats with the cycle: with a difference of one it is orthogonal to that.
const FROM_CYCLE: f64 = 0.75;

/// Fewest stops of a period: three of each half, as for the shortest correlation length.
const STOPS_OF_PERIOD: f64 = 6.0;

/// What wanders in the readings of a comparison.
#[derive(Clone, Copy)]
pub(crate) struct Course<'c, 'a> {
    pub(crate) comparison: &'c Comparison<'a>,
    pub(crate) wanderer: Wanderer,
}

/// The zero of the instrument, and the machine.
pub(crate) const INSTRUMENT: Wanderer = Wanderer::new(Who::Instrument, Campaign);
pub(crate) const MACHINE: Wanderer = Wanderer::new(Who::Machine, Campaign);

/// All that a comparison may show beside its base model.
pub(crate) fn wanderers(comparison: &Comparison<'_>, calibrated: bool) -> Vec<Wanderer> {
    let Some(axis) = comparison.line() else {
        // A ball bar shows more than one axis.
        let position = Wanderer::new(Who::Machine, Position);
        return vec![position, INSTRUMENT, MACHINE];
    };
    let is_rotary = comparison.is_of_rotary_axis();
    let moves = comparison.moving.contains(&axis);
    let own = |with| Wanderer::new(Who::Axis(axis), with);
    let mut all = vec![INSTRUMENT];
    // A turn has 360 degrees at any temperature.
    all.extend((moves && !is_rotary).then_some(own(Campaign)));
    all.extend((moves && calibrated).then_some(own(Position)));
    // Without a calibration the sides are compared where both were read.
    let compares = calibrated || !reached_from_both_sides(comparison).is_empty();
    if moves && compares && comes_from_both_sides(comparison, axis) {
        all.extend(is_rotary.then_some(own(Sides)));
        all.push(own(SidesInTime));
    }
    all
}

/// What has the same columns under another name.
pub(crate) fn confounded(comparison: &Comparison<'_>, wanderer: Wanderer) -> Option<Wanderer> {
    let with = match wanderer.with {
        Sides => SidesInTime,
        SidesInTime => Sides,
        _ => return (wanderer == INSTRUMENT && comparison.line().is_some()).then_some(MACHINE),
    };
    let confounded = Wanderer { with, ..wanderer };
    comparison
        .is_position_after_position()
        .then_some(confounded)
}

/// What wanders with time in the readings, under all its names.
pub(crate) fn with_time(comparison: &Comparison<'_>) -> impl Iterator<Item = Wanderer> + use<> {
    std::iter::once(INSTRUMENT).chain(confounded(comparison, INSTRUMENT))
}

/// Whether a cause names the course of a wanderer.
pub(crate) fn is_course_of(wanderer: Wanderer, cause: &Hypothesis) -> bool {
    match (wanderer.who, wanderer.with) {
        (Who::Axis(_), Campaign) => cause.effect.grows_axis(),
        (_, Campaign) => cause.is_of_time(),
        _ => false,
    }
}

impl Course<'_, '_> {
    /// Whether it is a course in time and nothing else.
    fn is_of_time(self) -> bool {
        self.wanderer.with == Campaign
    }

    /// Whether its argument is time.
    fn goes_with_time(self) -> bool {
        self.is_of_time() || self.wanderer.with == SidesInTime
    }

    /// Its argument at an arrival, 0 to 1.
    fn argument(self, row: usize) -> f64 {
        let arrival = &self.comparison.arrivals[row];
        match self.goes_with_time() {
            true => arrival.progress,
            false if self.comparison.line().is_some() => self.comparison.travelled(arrival),
            false => 0.5 + self.comparison.around[row] / TAU,
        }
    }

    /// Number of different arguments: over a line the number of its positions; for lost motion with time the number
    /// of passes, since two are needed to show it.
    fn stops(self) -> usize {
        if self.wanderer.with == SidesInTime {
            return count(&self.comparison.passes);
        }
        match self.is_of_time() || self.comparison.line().is_none() {
            true => self.comparison.arrivals.len(),
            false => count(&places(self.comparison)),
        }
    }

    /// Effect of a unit of each coordinate on a reading.
    fn seen(self, row: usize) -> Vec<f64> {
        let arrival = &self.comparison.arrivals[row];
        match (self.wanderer.who, self.wanderer.with) {
            // Half of the lost motion is missing on either side.
            (_, Sides | SidesInTime) => vec![-0.5 * arrival.sides[self.comparison.axis()]],
            (Who::Machine, Campaign) => self.comparison.points[row].along.as_slice().to_vec(),
            // The point from which it grows is unknown.
            (Who::Axis(_), Campaign) => vec![1.0, self.comparison.travelled(arrival) - 0.5],
            _ => vec![1.0],
        }
    }

    /// Passes, and cycles of more than one pass, between which it may change by more than within them: where no clock
    /// shows how long the pauses are.
    fn parts(self) -> [usize; 2] {
        let passes = count(&self.comparison.passes);
        let has_stops = LEAST_STOPS * passes <= self.comparison.arrivals.len();
        if !self.is_of_time() || self.comparison.timed || !has_stops || passes > MOST_PASSES {
            return [0, 0];
        }
        let cycles = count(&runs_of_cycles(self.comparison));
        [passes, if cycles < passes { cycles } else { 0 }]
    }

    /// Effect of a unit of each coefficient on the readings, coordinate by coordinate; the same for all smooth forms:
    /// the offsets of the passes have a root of zero in those without pauses.
    pub(crate) fn columns(self, form: Form) -> Vec<Vec<f64>> {
        let functions = self.functions(form);
        let rows = parts(self.comparison)
            .into_iter()
            .enumerate()
            .map(|(row, part)| {
                let basis = functions.at(self.argument(row), part);
                let seen = self.seen(row);
                let products = seen.iter().flat_map(|x| basis.iter().map(move |b| x * b));
                products.collect::<Vec<f64>>()
            });
        let rows: Vec<Vec<f64>> = rows.collect();
        let count = rows.first().map_or(0, Vec::len);
        (0..count)
            .map(|k| rows.iter().map(|row| row[k]).collect())
            .collect()
    }

    fn functions(self, form: Form) -> Functions {
        Functions {
            form,
            smooth: Basis::within(MOST_WAVES.min(self.stops() / 2), false),
            parts: self.parts(),
        }
    }

    /// Standard deviations of the coefficients, coordinate by coordinate.
    pub(crate) fn roots(self, form: Form) -> Vec<f64> {
        let roots = self.functions(form).roots();
        roots.repeat(self.seen(0).len())
    }

    /// Smooth courses that are tried.
    pub(crate) fn smooth(self) -> Vec<Form> {
        let lengths = correlation_lengths(self.stops());
        let pauses: &[Pauses] = match self.parts() {
            [0, _] => &[Pauses::Nowhere],
            [_, 0] => &[Pauses::Nowhere, Pauses::BetweenPasses],
            _ => &[
                Pauses::Nowhere,
                Pauses::BetweenCycles,
                Pauses::BetweenPasses,
            ],
        };
        let of_lengths = |&pauses: &Pauses| {
            let lengths = lengths.iter();
            lengths.map(move |&length| Form {
                pauses,
                ..Form::smooth(length)
            })
        };
        pauses.iter().flat_map(of_lengths).collect()
    }

    /// Periods that are tried, of what goes with time; without a clock as if the machine had not paused. What is
    /// quicker than a pass from end to end varies with the position and the side as well.
    pub(crate) fn periods(self) -> Vec<f64> {
        if !self.is_of_time() {
            return Vec::new();
        }
        let stops = self.comparison.arrivals.len() as f64;
        let passes = count(&self.comparison.passes) as f64;
        let most = MOST_SWINGS.min(passes).min(stops / STOPS_OF_PERIOD);
        let waves = std::iter::successors(Some(1.0), |waves| Some(waves + WAVE_STEP));
        let waves = waves.take_while(|waves| *waves <= most);
        waves.map(|waves| 1.0 / waves).collect()
    }

    /// Whether a swing with this period is nearly a function of position and side of approach.
    pub(crate) fn is_of_cycle(self, period: f64) -> bool {
        let cycles = 1.0 / between_cycles(self.comparison);
        let waves = 1.0 / period;
        let nearest = (waves / cycles).round().max(1.0) * cycles;
        (waves - nearest).abs() < FROM_CYCLE
    }

    /// Positions at which its curve is shown, in the unit of its argument, with the basis there.
    pub(crate) fn shown(self, form: Form) -> Vec<(f64, Vec<f64>)> {
        let ([first, last], _) = self.range();
        let functions = self.functions(form);
        if functions.parts[0] > 0 {
            let arrivals = self.comparison.arrivals.iter().zip(parts(self.comparison));
            let at = |(arrival, part): (&Arrival, [usize; 2])| {
                (arrival.time_s, functions.at(arrival.progress, part))
            };
            return arrivals.map(at).collect();
        }
        let at = |k: u32| {
            let x = f64::from(k) / f64::from(POINTS - 1);
            (first + x * (last - first), functions.at(x, [0, 0]))
        };
        (0..POINTS).map(at).collect()
    }

    /// Range of its argument, and the unit: s, readings, mm or deg.
    pub(crate) fn range(self) -> ([f64; 2], &'static str) {
        if self.goes_with_time() {
            let times = self.comparison.arrivals.iter().map(|a| a.time_s);
            return (extremes(times), self.comparison.unit_of("s"));
        }
        if self.comparison.line().is_none() {
            return ([-180.0, 180.0], "deg");
        }
        let kind = self.comparison.machine.axes()[self.comparison.axis()].kind();
        let ends = self.comparison.range.map(|end| kind.position_in_file(end));
        (ends, kind.position_unit())
    }
}

/// Standard deviation of the change between two passes without a clock, in standard deviations of the smooth course.
const BETWEEN_PASSES: f64 = 0.5;

/// The functions that make up the course of each coordinate.
struct Functions {
    form: Form,
    /// Those of a course that does not swing.
    smooth: Basis,
    /// Number of passes, and of cycles of more than one pass, that may have offsets.
    parts: [usize; 2],
}

impl Functions {
    /// Factors of the coefficients at an argument: `cos(πx), cos(2πx), ...`, or sine and cosine of a swing less their
    /// means, and where pauses are unknown one for the pass and one for the cycle.
    fn at(&self, x: f64, part: [usize; 2]) -> Vec<f64> {
        let mut all: Vec<f64> = match self.form.period {
            None => self.smooth.at(x).collect(),
            Some(period) => {
                let turn = TAU / period;
                let (sine, cosine) = (turn * x).sin_cos();
                vec![sine - (1.0 - turn.cos()) / turn, cosine - turn.sin() / turn]
            }
        };
        for (count, own) in self.parts.into_iter().zip(part) {
            all.extend((0..count).map(|k| f64::from(u8::from(k == own))));
        }
        all
    }

    /// Standard deviations of the coefficients; `S_k^½` for the waves.
    fn roots(&self) -> Vec<f64> {
        let mut roots = match self.form.period {
            None => self.smooth.roots_of_spectrum(self.form.length),
            Some(_) => vec![1.0; 2],
        };
        let of_parts = [Pauses::BetweenPasses, Pauses::BetweenCycles];
        for (count, own) in self.parts.into_iter().zip(of_parts) {
            let root = if own == self.form.pauses {
                BETWEEN_PASSES
            } else {
                0.0
            };
            roots.extend(std::iter::repeat_n(root, count));
        }
        roots
    }
}

/// For each arrival the index of its pass, and of its cycle among consecutive ones.
fn parts(comparison: &Comparison<'_>) -> Vec<[usize; 2]> {
    let cycles = runs_of_cycles(comparison);
    let parts = comparison.passes.iter().zip(cycles);
    parts.map(|(&pass, cycle)| [pass, cycle]).collect()
}

/// From the start of a cycle to the next, including the pause between, as a share of the time of all (median).
fn between_cycles(comparison: &Comparison<'_>) -> f64 {
    let numbers = cycles(comparison);
    let mut starts = vec![f64::INFINITY; count(&numbers)];
    for (arrival, &number) in comparison.arrivals.iter().zip(&numbers) {
        starts[number] = starts[number].min(arrival.progress);
    }
    starts.sort_by(f64::total_cmp);
    let between = starts.windows(2).map(|two| two[1] - two[0]);
    let mut between: Vec<f64> = between.filter(|part| *part > 0.0).collect();
    median(&mut between).unwrap_or(1.0)
}
