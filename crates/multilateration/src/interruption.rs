//! Whether a station's zero jumped, and nothing else.
//!
//! A beam interruption changes all later lengths of a station's occupation by one constant. Other things
//! raise the test of such a step, too: a drift (the zero or the tripod creeps), or a displacement of
//! the station or the machine (the change depends on the direction of the beam). The occupation is split
//! only if the step explains the lengths better than these do.
//!
//! A zero or a tripod that wanders in a course that nobody knows, as a swing, raises it as well. Its course is a process
//! with Matérn's covariance in half waves ([`trueaxis_leastsquares::matern_roots`]), its size by restricted maximum
//! likelihood; the step must be needed beside it.

use nalgebra::{DMatrix, DVector, Vector3};
use trueaxis_leastsquares::{dot, half_waves, matern_roots};

use crate::step_tests::StepTest;
use crate::whitened::Whitened;
use crate::{Network, Solution};

/// What a step must be ahead of other explanations, as a difference of squares of standardised
/// sizes: a likelihood ratio of e⁵.
const AHEAD: f64 = 10.0;

/// A displacement has three parameters for the step's one; by chance alone its square is larger by
/// this at most (chi-squared with two degrees of freedom, one in e⁵).
const DISPLACEMENT_CHANCE: f64 = 10.0;

/// Parts of an occupation after which a zero or a tripod that settles has come to rest by 63 %.
const SETTLED_AFTER: [f64; 4] = [0.03, 0.08, 0.2, 0.5];

/// By how much the sum of squares falls, in variances of w, for what else may explain a step.
pub(crate) struct Rivals {
    /// The step itself.
    step: f64,
    /// A zero that drifts or settles, whichever is best.
    drift: f64,
    /// A station that settles.
    settling: f64,
    /// A station that is displaced at the instant of the step.
    displacement: f64,
    /// What the step explains beside a zero or a station that wanders.
    beside_wander: f64,
    /// Rms of the zero if it wanders, mm.
    pub(crate) wander_mm: f64,
    /// Visits of the occupation: instants at which the step was sought.
    instants: usize,
}

/// Correlation lengths of what wanders, as parts of the occupation, and its half waves.
const WANDER_LENGTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
const WAVES: u32 = 12;

/// Sizes that are tried, quarters of powers of ten of the variance that the lengths can just see.
const SIZES: std::ops::Range<i32> = -8..41;

impl Rivals {
    /// The rivals of a step; `scale` is the standard deviation of w.
    pub(crate) fn of(
        step: &StepTest,
        (network, solution): (&Network, &Solution),
        rows: &Whitened,
        scale: f64,
    ) -> Self {
        let zeros = network.zero_of_readings();
        let zero = zeros[step.first_reading];
        let occupation: Vec<usize> = (0..zeros.len()).filter(|&i| zeros[i] == zero).collect();
        let mut beams = vec![Vector3::zeros(); zeros.len()];
        for visit in network.visits.iter().filter(|v| v.station == step.station) {
            let station_mm = solution.stations[visit.station].position_mm;
            for i in visit.readings.clone() {
                let point = network.point(visit.group, network.readings[i].point);
                beams[i] = (solution.points_mm[point] - station_mm).normalize();
            }
        }
        // The zero, or the station, follows this course, from 0 to 1 in the occupation.
        let following = |is_station: bool, course: &dyn Fn(usize, f64) -> f64| {
            let mut columns = vec![vec![0.0; zeros.len()]; if is_station { 3 } else { 1 }];
            let length = occupation.len().max(2) as f64 - 1.0;
            for (k, &i) in occupation.iter().enumerate() {
                let size = course(i, k as f64 / length);
                for (c, column) in columns.iter_mut().enumerate() {
                    column[i] = if is_station { beams[i][c] * size } else { size };
                }
            }
            columns.iter_mut().for_each(|column| rows.whiten(column));
            columns
        };
        let squares = |is_station: bool, course: &dyn Fn(usize, f64) -> f64| {
            explained(rows, &following(is_station, course)) / (scale * scale)
        };
        let settles = |is_station: bool| {
            let after = SETTLED_AFTER.iter();
            after
                .map(|after| squares(is_station, &|_, s| 1.0 - (-s / after).exp()))
                .fold(0.0, f64::max)
        };
        let jumps = |i, _| f64::from(u8::from(i >= step.first_reading));
        let wanders = [false, true].map(|is_station| {
            let of_wave = |k: usize| {
                let wave = |_, s| half_waves(s, WAVES).nth(k).unwrap_or_default();
                following(is_station, &wave)
            };
            let mut columns: Vec<Vec<f64>> = (0..WAVES as usize).flat_map(of_wave).collect();
            let n = columns.len();
            columns.extend(following(false, &jumps));
            let (left, right) = normal_equations(rows, &columns);
            let (of_waves, along) = (left.view((0, 0), (n, n)), right.rows(0, n));
            let alone = wander(&of_waves.into_owned(), &along.into_owned(), scale);
            // What the step explains of the waves is free.
            let (own, of_step) = (left.column(n).rows(0, n) / left[(n, n)], right[n]);
            let of_waves = of_waves - &own * left.view((n, 0), (1, n));
            let beside = wander(&of_waves, &(along - own * of_step), scale);
            (beside.ratio - alone.ratio, alone.rms_mm)
        });
        let [of_zero, of_station] = wanders;
        let visits = network.visits.iter();
        Self {
            instants: visits
                .filter(|v| zeros.get(v.readings.start) == Some(&zero))
                .count(),
            beside_wander: of_zero.0.min(of_station.0) + (step.w / scale).powi(2),
            wander_mm: of_zero.1,
            step: (step.w / scale).powi(2),
            drift: squares(false, &|_, s| s).max(settles(false)),
            settling: settles(true),
            displacement: squares(true, &jumps),
        }
    }

    /// Whether the step is that of an interrupted beam, or of what cannot be told from it.
    /// `cuts_what_wanders`: whether what wanders counts as one, too.
    pub(crate) fn is_interruption(&self, cuts_what_wanders: bool) -> bool {
        self.step > self.drift + AHEAD
            && self.step > self.displacement.max(self.settling) - DISPLACEMENT_CHANCE
            && (cuts_what_wanders || !self.is_wander())
    }

    /// Whether the step is not needed beside a zero or a station that wanders.
    pub(crate) fn is_wander(&self) -> bool {
        self.beside_wander <= AHEAD
    }

    /// Whether the step is needed beside what wanders, even after it was sought at all instants: the largest of n squares
    /// exceeds a single one by 2 ln n.
    pub(crate) fn exclude_wander(&self) -> bool {
        self.beside_wander > AHEAD + 2.0 * (self.instants.max(1) as f64).ln()
    }

    /// Whether a displacement at that instant explains clearly less.
    pub(crate) fn exclude_displacement(&self) -> bool {
        self.step > self.displacement + AHEAD
    }
}

/// A direction that the adjustment absorbs explains nothing, below this part of the largest one.
const ABSORBED: f64 = 1e-9;

/// By how much the sum of squares falls if errors of the form of these columns, one element for each
/// reading, are allowed for: `bᵀ A⁺ b` with `A = XᵀMX` and `b = Xᵀv` of the whitened columns.
fn explained(rows: &Whitened, columns: &[Vec<f64>]) -> f64 {
    let (left, right) = normal_equations(rows, columns);
    let limit = ABSORBED * left.amax();
    let found = left.svd(true, true).solve(&right, limit);
    found.map_or(0.0, |estimates| right.dot(&estimates))
}

/// `A = XᵀMX` and `b = Xᵀv` of whitened columns.
fn normal_equations(rows: &Whitened, columns: &[Vec<f64>]) -> (DMatrix<f64>, DVector<f64>) {
    let mut kept = columns.to_vec();
    kept.iter_mut().for_each(|column| rows.project(column));
    let n = columns.len();
    let left = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &kept[j]));
    let right = DVector::from_fn(n, |k, _| dot(&columns[k], &rows.residuals));
    (left, right)
}

/// What wanders.
#[derive(Clone, Copy, Default)]
struct Wander {
    /// Twice the logarithm of the likelihood ratio against nothing that wanders.
    ratio: f64,
    /// Rms of its course, mm.
    rms_mm: f64,
}

/// The most likely process in half waves, of the normal equations of its columns: wave after wave, each with one for each
/// coordinate.
fn wander(left: &DMatrix<f64>, right: &DVector<f64>, scale: f64) -> Wander {
    let n = right.len();
    let coordinates = n / WAVES as usize;
    let mut best = Wander::default();
    for length in WANDER_LENGTHS {
        let roots = &matern_roots(length, WAVES)[1..];
        let root = DVector::from_fn(n, |k, _| roots[k / coordinates] / scale);
        let scaled = DMatrix::from_fn(n, n, |i, j| root[i] * left[(i, j)] * root[j]);
        let along = right.component_mul(&root) / scale;
        for exponent in SIZES {
            let variance = n as f64 / scaled.trace() * 10_f64.powf(f64::from(exponent) / 4.0);
            let Some(factor) = (DMatrix::identity(n, n) + variance * &scaled).cholesky() else {
                continue;
            };
            let mean = variance * factor.solve(&along);
            let ratio = along.dot(&mean) - factor.ln_determinant();
            if ratio > best.ratio {
                let squares = mean.component_mul(&root).norm_squared() * scale * scale;
                let rms_mm = (0.5 * squares).sqrt();
                best = Wander { ratio, rms_mm };
            }
        }
    }
    best
}
