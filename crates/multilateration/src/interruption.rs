//! Whether a station's zero jumped, and nothing else.
//!
//! A beam interruption changes all later lengths of a station's occupation by one constant. Other things
//! raise the test of such a step, too: a drift (the zero or the tripod creeps), or a displacement of
//! the station or the machine (the change depends on the direction of the beam). The occupation is split
//! only if the step explains the lengths better than these do.

use nalgebra::{DMatrix, DVector, Vector3};
use trueaxis_leastsquares::dot;

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
}

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
        let squares = |is_station: bool, course: &dyn Fn(usize, f64) -> f64| {
            let mut columns = vec![vec![0.0; zeros.len()]; if is_station { 3 } else { 1 }];
            let length = occupation.len().max(2) as f64 - 1.0;
            for (k, &i) in occupation.iter().enumerate() {
                let size = course(i, k as f64 / length);
                for (c, column) in columns.iter_mut().enumerate() {
                    column[i] = if is_station { beams[i][c] * size } else { size };
                }
            }
            explained(rows, columns) / (scale * scale)
        };
        let settles = |is_station: bool| {
            let after = SETTLED_AFTER.iter();
            after
                .map(|after| squares(is_station, &|_, s| 1.0 - (-s / after).exp()))
                .fold(0.0, f64::max)
        };
        let jumps = |i, _| f64::from(u8::from(i >= step.first_reading));
        Self {
            step: (step.w / scale).powi(2),
            drift: squares(false, &|_, s| s).max(settles(false)),
            settling: settles(true),
            displacement: squares(true, &jumps),
        }
    }

    /// Whether the step is that of an interrupted beam, or of what cannot be told from it.
    pub(crate) fn is_interruption(&self) -> bool {
        self.step > self.drift + AHEAD
            && self.step > self.displacement.max(self.settling) - DISPLACEMENT_CHANCE
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
fn explained(rows: &Whitened, mut columns: Vec<Vec<f64>>) -> f64 {
    columns.iter_mut().for_each(|column| rows.whiten(column));
    let mut kept = columns.clone();
    kept.iter_mut().for_each(|column| rows.project(column));
    let n = columns.len();
    let left = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &kept[j]));
    let right = DVector::from_fn(n, |k, _| dot(&columns[k], &rows.residuals));
    let limit = ABSORBED * left.amax();
    let found = left.svd(true, true).solve(&right, limit);
    found.map_or(0.0, |estimates| right.dot(&estimates))
}
