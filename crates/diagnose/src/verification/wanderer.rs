//! What may move in a course that nobody knows while readings are taken.
//!
//! Over its argument `x`, 0 to 1, each coordinate is a process with Matérn's covariance in half waves
//! ([`matern_roots`]), as in the lengths, but without its mean: the base model takes that, or it is an effect of the catalogue.
//! Rows without a clock do not say how long the machine paused between two passes, in which what drifts goes on: each pass then
//! has an offset of its own beside.
//!
//! | who | what moves | with | coordinates | where |
//! | --- | --- | --- | --- | --- |
//! | instrument | its zero | time | 1 | everywhere |
//! | machine | the point measured | time | 3 | ball bars; on a line it is the zero of the instrument under another name |
//! | axis | its scale, from one end of the positions to the other | time | 1 | lines |
//! | axis | its displacement along itself | position | 1 | lines against a calibration; else the mean curve takes it |
//! | axis | its lost motion | position, by side of approach | 1 | lines of rotary axes; of linear axes it is a cause |

use trueaxis_campaign::VerificationKind;
use trueaxis_effects::{Layer, Level, Subject};
use trueaxis_kinematics::AxisKind;
use trueaxis_leastsquares::{half_waves, matern_roots};

use crate::Wandering;
use crate::engine::correlation_lengths;
use crate::verification::arrivals::Arrival;
use crate::verification::base::places;
use crate::verification::comparison::Comparison;

/// Half waves of each coordinate.
const WAVES: u32 = 12;

/// Standard deviations that are tried of what changes between two passes without a clock, in those of the smooth course:
/// pauses about as long as passes, and much longer ones.
const BETWEEN_PASSES: [f64; 2] = [0.5, 5.0];

/// Stops of a pass, on average, below which an offset for each would be noise.
const LEAST_STOPS: usize = 3;

/// Points of a smooth curve.
const POINTS: u32 = 33;

/// How it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spectrum {
    /// ℓ, as a part of the range of the argument.
    pub(crate) length: f64,
    /// Standard deviation of the offset of a pass, in those of the smooth course.
    between_passes: f64,
}

/// What wanders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanderer {
    Instrument,
    Machine,
    /// The scale of the measured axis with time.
    Scale,
    /// The measured axis over its position.
    Position,
    /// The lost motion of the measured axis over its position.
    Sides,
}

/// All that a comparison may show beside its base model.
pub(crate) fn wanderers(comparison: &Comparison<'_>, calibrated: bool) -> Vec<Wanderer> {
    use Wanderer::{Instrument, Machine, Position, Scale, Sides};
    match comparison.kind {
        VerificationKind::Ballbar { .. } => vec![Instrument, Machine],
        VerificationKind::Positioning { axis, .. } => {
            let is_rotary = comparison.machine.axes()[*axis].kind() == AxisKind::Rotary;
            let mut all = vec![Instrument, Scale];
            all.extend(calibrated.then_some(Position));
            all.extend(is_rotary.then_some(Sides));
            all
        }
    }
}

impl Wanderer {
    /// By its public name.
    pub(crate) fn whose(self, comparison: &Comparison<'_>) -> Wandering {
        let of = |layer, varies_with: &'static [&'static str]| Wandering {
            level: Level::Verification,
            layer,
            subject: Subject::default(),
            varies_with,
        };
        let of_axis = |varies_with| Wandering {
            subject: Subject {
                axis: Some(comparison.axis()),
                ..Subject::default()
            },
            ..of(Layer::Machine, varies_with)
        };
        match self {
            Self::Instrument => of(Layer::Instrument, &["time"]),
            Self::Machine => of(Layer::Machine, &["time"]),
            Self::Scale => of_axis(&["time"]),
            Self::Position => of_axis(&["position"]),
            Self::Sides => of_axis(&["position", "direction"]),
        }
    }

    /// The same columns under another name.
    pub(crate) fn twin(self, comparison: &Comparison<'_>) -> Option<Self> {
        let is_line = matches!(comparison.kind, VerificationKind::Positioning { .. });
        (is_line && self == Self::Instrument).then_some(Self::Machine)
    }

    /// Whether a course in time is all that it is.
    pub(crate) fn is_of_time(self) -> bool {
        matches!(self, Self::Instrument | Self::Machine | Self::Scale)
    }

    /// The course of an arrival, 0 to 1.
    fn argument(self, comparison: &Comparison<'_>, arrival: &Arrival) -> f64 {
        match self.is_of_time() {
            true => arrival.progress,
            false => comparison.travelled(arrival),
        }
    }

    /// What a unit of each coordinate does to a reading.
    fn seen(self, comparison: &Comparison<'_>, row: usize) -> Vec<f64> {
        let arrival = &comparison.arrivals[row];
        match self {
            Self::Instrument | Self::Position => vec![1.0],
            Self::Machine => comparison.points[row].along.as_slice().to_vec(),
            Self::Scale => vec![comparison.travelled(arrival) - 0.5],
            Self::Sides => vec![0.5 * arrival.sides[comparison.axis()]],
        }
    }

    /// Passes between which it may change by more than it does within: where no clock shows how long the pauses are.
    fn passes(self, comparison: &Comparison<'_>) -> usize {
        let count = comparison.passes.last().map_or(0, |last| last + 1);
        let has_stops = LEAST_STOPS * count <= comparison.arrivals.len();
        match self.is_of_time() && !comparison.timed && has_stops {
            true => count,
            false => 0,
        }
    }

    /// What each coefficient of a coordinate is multiplied by at an argument: `cos(πx), cos(2πx), ...`, and where pauses
    /// are unknown one for the pass.
    fn basis(self, comparison: &Comparison<'_>, x: f64, pass: usize) -> Vec<f64> {
        let of_pass = (0..self.passes(comparison)).map(|k| f64::from(u8::from(k == pass)));
        half_waves(x, WAVES).chain(of_pass).collect()
    }

    /// What a unit of each coefficient does to the readings, coordinate after coordinate.
    pub(crate) fn columns(self, comparison: &Comparison<'_>) -> Vec<Vec<f64>> {
        let rows = comparison.arrivals.iter().zip(&comparison.passes);
        let rows = rows.enumerate().map(|(row, (arrival, &pass))| {
            let basis = self.basis(comparison, self.argument(comparison, arrival), pass);
            let seen = self.seen(comparison, row);
            let products = seen.iter().flat_map(|x| basis.iter().map(move |b| x * b));
            products.collect::<Vec<f64>>()
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        let count = rows.first().map_or(0, Vec::len);
        (0..count)
            .map(|k| rows.iter().map(|row| row[k]).collect())
            .collect()
    }

    /// Standard deviations of the coefficients of one coordinate, `S_k^½` of the waves.
    pub(crate) fn roots(self, comparison: &Comparison<'_>, spectrum: &Spectrum) -> Vec<f64> {
        let mut roots = matern_roots(spectrum.length, WAVES)[1..].to_vec();
        let of_passes = std::iter::repeat_n(spectrum.between_passes, self.passes(comparison));
        roots.extend(of_passes);
        roots
    }

    /// Where its curve is shown, in the unit of its argument, with the basis there.
    pub(crate) fn shown(self, comparison: &Comparison<'_>) -> Vec<(f64, Vec<f64>)> {
        let ([first, last], _) = self.range(comparison);
        if self.passes(comparison) > 0 {
            let arrivals = comparison.arrivals.iter().zip(&comparison.passes);
            let at = |(arrival, &pass): (&Arrival, &usize)| {
                let basis = self.basis(comparison, arrival.progress, pass);
                (arrival.time_s, basis)
            };
            return arrivals.map(at).collect();
        }
        let at = |k: u32| {
            let x = f64::from(k) / f64::from(POINTS - 1);
            (first + x * (last - first), self.basis(comparison, x, 0))
        };
        (0..POINTS).map(at).collect()
    }

    /// Spectra that are tried: over a line as many stops as it has positions.
    pub(crate) fn spectra(self, comparison: &Comparison<'_>) -> Vec<Spectrum> {
        let lengths = correlation_lengths(match self.is_of_time() {
            true => comparison.arrivals.len(),
            false => places(comparison).iter().max().map_or(0, |last| last + 1),
        });
        let between = match self.passes(comparison) {
            0 => &BETWEEN_PASSES[..1],
            _ => &BETWEEN_PASSES,
        };
        let of_length = |length| {
            between.iter().map(move |&between_passes| Spectrum {
                length,
                between_passes,
            })
        };
        lengths.into_iter().flat_map(of_length).collect()
    }

    /// Range of its argument, and the unit: s, readings, mm or deg.
    pub(crate) fn range(self, comparison: &Comparison<'_>) -> ([f64; 2], &'static str) {
        if self.is_of_time() {
            let times = comparison.arrivals.iter().map(|a| a.time_s);
            let first = times.clone().fold(f64::INFINITY, f64::min);
            let last = times.fold(f64::NEG_INFINITY, f64::max);
            return ([first, last], comparison.unit_of_time());
        }
        let ends = comparison.range;
        match comparison.machine.axes()[comparison.axis()].kind() {
            AxisKind::Linear => (ends, "mm"),
            AxisKind::Rotary => (ends.map(f64::to_degrees), "deg"),
        }
    }
}
