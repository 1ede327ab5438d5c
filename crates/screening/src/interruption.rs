//! Whether the zero of a station jumped, or something else happened.
//!
//! A beam interruption changes all later lengths of a station's occupation by one constant. Other things
//! raise the test of such a jump, too: a drift (of the zero or the tripod), or a displacement of the station or the
//! machine (the change depends on the direction of the beam). The occupation is split only if the jump explains the
//! lengths better than all of these.
//!
//! So does a zero or a tripod that wanders in an unknown smooth course, such as a swing. The course is a process with
//! Matérn's covariance in half waves ([`trueaxis_leastsquares::matern_roots`]), its size by restricted maximum
//! likelihood; the jump must be needed beside it.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView, Vector3};
use rayon::prelude::*;
use trueaxis_leastsquares::dense::Svd;
use trueaxis_leastsquares::{half_waves, matern_roots};
use trueaxis_multilateration::{Network, Solution, Visit, Whitened};

use crate::jump_tests::JumpTest;

/// Lead of a jump over other explanations that is needed, as a difference of squares of standardised sizes: a
/// likelihood ratio of e⁵.
const AHEAD: f64 = 10.0;

/// A displacement has three parameters, the jump one; by chance alone its square is larger by at most this
/// (chi-squared with two degrees of freedom, one in e⁵).
const DISPLACEMENT_CHANCE: f64 = 10.0;

/// Time constants of a zero or a tripod that settles, as parts of the occupation.
const SETTLED_AFTER: [f64; 4] = [0.03, 0.08, 0.2, 0.5];

/// Correlation lengths of a wandering course, as parts of the occupation, and its number of half waves.
const WANDER_LENGTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
const WAVES: u32 = 12;

/// Exponents of the sizes tried: quarter powers of ten, times the variance that the lengths can just see.
const SIZES: Range<i32> = -8..41;

/// A jump and its rival explanations: how far each lowers the sum of squares, in variances of w.
pub(crate) struct Rivals<'a> {
    jump: &'a JumpTest,
    rows: &'a Whitened,
    /// Standard deviation of w.
    spread: f64,
    /// The readings of the jump's zero.
    occupation: Vec<usize>,
    /// The directions of the beams of these readings.
    beams: Vec<Vector3<f64>>,
    /// Visits of the occupation: the instants at which the jump was sought.
    instants: usize,
    /// All visits from the first of the occupation to its last, and their readings.
    visits: Range<usize>,
    readings: Range<usize>,
}

/// Explanations of a jump that are certainly wrong.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Excluded {
    /// A displacement of the station.
    pub(crate) tripod: bool,
    /// A zero or a tripod that wanders.
    pub(crate) wander: bool,
}

/// What moves.
#[derive(Clone, Copy)]
enum Mover {
    Zero,
    Station,
}

impl<'a> Rivals<'a> {
    /// The rivals of a jump; `spread` is the standard deviation of w.
    pub(crate) fn of(
        jump: &'a JumpTest,
        (network, solution): (&Network, &Solution),
        rows: &'a Whitened,
        spread: f64,
    ) -> Self {
        let zeros = network.zero_of_readings();
        let zero = zeros[jump.first_reading];
        let station_mm = solution.stations[jump.station].position_mm;
        let (mut occupation, mut beams, mut instants) = (Vec::new(), Vec::new(), 0);
        let is_own = |reading: usize| zeros[reading] == zero;
        let has_own = |visit: &Visit| visit.readings.clone().any(is_own);
        let first = network.visits.iter().position(has_own).unwrap_or(0);
        let end = network
            .visits
            .iter()
            .rposition(has_own)
            .map_or(first, |last| last + 1);
        let visits = first..end;
        let of_visits = &network.visits[visits.clone()];
        let start = of_visits.first().map_or(0, |visit| visit.readings.start);
        let readings = start..of_visits.last().map_or(start, |visit| visit.readings.end);
        for visit in of_visits {
            instants += usize::from(visit.readings.clone().next().is_some_and(is_own));
            for i in visit.readings.clone().filter(|&i| is_own(i)) {
                let point = network.point(visit.group, network.readings[i].point);
                beams.push((solution.points_mm[point] - station_mm).normalize());
                occupation.push(i);
            }
        }
        Self {
            jump,
            rows,
            spread,
            occupation,
            beams,
            instants,
            visits,
            readings,
        }
    }

    /// Whether the jump is that of an interrupted beam, or of something that cannot be distinguished. With
    /// `splits_what_wanders` a wandering course counts as one, too.
    pub(crate) fn is_interruption(&self, splits_what_wanders: bool) -> bool {
        let jump = self.jump();
        // The most costly test comes last.
        jump > self.drift() + AHEAD
            && jump > self.displacement().max(self.settles(Mover::Station)) - DISPLACEMENT_CHANCE
            && (splits_what_wanders || self.wandering_mm().is_none())
    }

    /// Rms of the zero if it wanders, mm; `None` if the jump is needed beside a zero or a station that wanders.
    pub(crate) fn wandering_mm(&self) -> Option<f64> {
        let (explained, rms_mm) = self.beside_wander();
        (explained <= AHEAD).then_some(rms_mm)
    }

    /// Excludes what explains clearly less than the jump: a displacement at its instant; a wandering course, even
    /// though the jump was sought at all instants (the largest of n squares exceeds a single one by 2 ln n).
    pub(crate) fn excluded(&self) -> Excluded {
        let sought = 2.0 * (self.instants.max(1) as f64).ln();
        Excluded {
            tripod: self.jump() > self.displacement() + AHEAD,
            wander: self.beside_wander().0 > AHEAD + sought,
        }
    }

    /// Drop of the sum of squares by the jump, in variances of w; so for the following functions.
    fn jump(&self) -> f64 {
        (self.jump.w / self.spread).powi(2)
    }

    /// The better of a zero that drifts and one that settles.
    fn drift(&self) -> f64 {
        let linear = self.squares(Mover::Zero, |k| self.progress(k));
        linear.max(self.settles(Mover::Zero))
    }

    /// A mover that settles, with the best time constant.
    fn settles(&self, mover: Mover) -> f64 {
        let after = SETTLED_AFTER.iter();
        let squares =
            |after: &f64| self.squares(mover, |k| 1.0 - (-self.progress(k) / after).exp());
        after.map(squares).fold(0.0, f64::max)
    }

    /// A displacement of the station at the instant of the jump.
    fn displacement(&self) -> f64 {
        self.squares(Mover::Station, |k| self.jumps(k))
    }

    /// What the jump explains beside a zero or a station that wanders, and the rms of a zero that wanders alone, mm.
    fn beside_wander(&self) -> (f64, f64) {
        let places = 0..self.occupation.len();
        let waves: Vec<Vec<f64>> = places
            .map(|k| half_waves(self.progress(k), WAVES).collect())
            .collect();
        let of = |mover| {
            let of_wave = |wave: usize| self.following(mover, |k| waves[k][wave]);
            let mut columns: Vec<Vec<f64>> = (0..WAVES as usize).flat_map(of_wave).collect();
            let n = columns.len();
            columns.extend(self.following(Mover::Zero, |k| self.jumps(k)));
            let (left, right) = self.normal_equations(&columns);
            let (of_waves, along) = (left.view((0, 0), (n, n)), right.rows(0, n));
            let alone = wander(&of_waves.into_owned(), &along.into_owned(), self.spread);
            // The jump is free: take what it explains out of the waves.
            let (own, of_jump) = (left.column(n).rows(0, n) / left[(n, n)], right[n]);
            let of_waves = of_waves - &own * left.view((n, 0), (1, n));
            let beside = wander(&of_waves, &(along - own * of_jump), self.spread);
            (beside.ratio - alone.ratio, alone.rms_mm)
        };
        let (of_zero, of_station) = rayon::join(|| of(Mover::Zero), || of(Mover::Station));
        (of_zero.0.min(of_station.0) + self.jump(), of_zero.1)
    }

    /// The part of the occupation that has passed at its reading `k`, 0 to 1.
    fn progress(&self, k: usize) -> f64 {
        k as f64 / (self.occupation.len().max(2) as f64 - 1.0)
    }

    /// The course of the jump: 0 before its instant, 1 after it.
    fn jumps(&self, k: usize) -> f64 {
        f64::from(u8::from(self.occupation[k] >= self.jump.first_reading))
    }

    fn squares(&self, mover: Mover, course: impl Fn(usize) -> f64) -> f64 {
        self.explained(&self.following(mover, course)) / (self.spread * self.spread)
    }

    /// Whitened columns of a zero, or of each coordinate of a station, that follows a course over the readings of the
    /// occupation; an element for each row of its visits.
    fn following(&self, mover: Mover, course: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        let count = match mover {
            Mover::Zero => 1,
            Mover::Station => 3,
        };
        let mut columns = vec![vec![0.0; self.readings.len()]; count];
        for (k, &i) in self.occupation.iter().enumerate() {
            let size = course(k);
            for (c, column) in columns.iter_mut().enumerate() {
                column[i - self.readings.start] = match mover {
                    Mover::Zero => size,
                    Mover::Station => self.beams[k][c] * size,
                };
            }
        }
        columns
            .par_iter_mut()
            .for_each(|column| self.rows.whiten_from(self.visits.start, column));
        columns
    }

    /// Drop of the sum of squares by errors of the form of these columns: `bᵀ A⁺ b` with `A = XᵀMX` and `b = Xᵀv` of
    /// the whitened columns.
    fn explained(&self, columns: &[Vec<f64>]) -> f64 {
        let (left, right) = self.normal_equations(columns);
        let limit = ABSORBED * left.amax();
        let inverse = Svd::new(&left).map(|svd| svd.pseudo_inverse(limit));
        inverse.map_or(0.0, |inverse| right.dot(&(inverse * &right)))
    }

    /// `A = XᵀX - OᵀX (OᵀX)ᵀ - (TᵀX)ᵀ Σ TᵀX` and `b = Xᵀv` of whitened columns.
    fn normal_equations(&self, columns: &[Vec<f64>]) -> (DMatrix<f64>, DVector<f64>) {
        let (rows, own, width) = (self.rows, self.readings.clone(), self.rows.shared_width);
        let transposed = DMatrix::from_fn(columns.len(), own.len(), |k, i| columns[k][i]);
        let x = transposed.transpose();
        let shared = &rows.shared[own.start * width..own.end * width];
        let of_shared = DMatrixView::from_slice(shared, width, own.len()) * &x;
        let sigma = DMatrixView::from_slice(&rows.reduced_inverse, width, width);
        let mut of_groups = DMatrix::zeros(columns.len(), rows.groups * rows.own_width);
        for (row, x) in own.clone().zip(transposed.column_iter()) {
            for (column, o) in rows.columns_of_group(row).zip(rows.own_row(row)) {
                of_groups.column_mut(column).axpy(*o, &x, 1.0);
            }
        }
        let left = &transposed * &x
            - &of_groups * of_groups.transpose()
            - of_shared.transpose() * (sigma * &of_shared);
        let residuals = DVectorView::from_slice(&rows.residuals[own.clone()], own.len());
        (left, transposed * residuals)
    }
}

/// Directions with less than this share of the largest eigenvalue are absorbed by the adjustment and explain nothing.
const ABSORBED: f64 = 1e-9;

/// A wandering course.
#[derive(Clone, Copy, Default)]
struct Wander {
    /// Twice the logarithm of the likelihood ratio against no wandering.
    ratio: f64,
    /// Rms of its course, mm.
    rms_mm: f64,
}

/// The most likely wandering course from the normal equations of its columns, wave after wave, with one column for
/// each coordinate.
///
/// The noise is given, that of all lengths; `trueaxis_selection::restricted_likelihood` estimates it from the data that wander.
fn wander(left: &DMatrix<f64>, right: &DVector<f64>, spread: f64) -> Wander {
    let n = right.len();
    let coordinates = n / WAVES as usize;
    let mut best = Wander::default();
    for length in WANDER_LENGTHS {
        let roots = &matern_roots(length, WAVES)[1..];
        let root = DVector::from_fn(n, |k, _| roots[k / coordinates] / spread);
        let scaled = DMatrix::from_fn(n, n, |i, j| root[i] * left[(i, j)] * root[j]);
        let along = right.component_mul(&root) / spread;
        for exponent in SIZES {
            let variance = n as f64 / scaled.trace() * 10_f64.powf(f64::from(exponent) / 4.0);
            let Some(factor) = (DMatrix::identity(n, n) + variance * &scaled).cholesky() else {
                continue;
            };
            let mean = variance * factor.solve(&along);
            let ratio = along.dot(&mean) - factor.ln_determinant();
            if ratio > best.ratio {
                let squares = mean.component_mul(&root).norm_squared() * spread * spread;
                let rms_mm = (0.5 * squares).sqrt();
                best = Wander { ratio, rms_mm };
            }
        }
    }
    best
}
