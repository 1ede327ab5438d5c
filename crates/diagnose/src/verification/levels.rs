//! Readings that jump between two levels: a loose mount, a sensor that locks onto another fringe, a bistable joint.
//!
//! Jumps this frequent are no shift with an instant, and neighbours are alike as in correlated noise, which absorbs them. So readings that are otherwise clean are compared under two models, beside the base model: autoregressive noise,
//! and two levels `±a` with white noise, between which the readings jump with one probability (a hidden Markov model,
//! Rabiner 1989, fitted by expectation and maximisation). How much likelier two levels look by chance depends on the
//! table, so tables of autoregressive noise alone are made for comparison.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_effects::Level;
use trueaxis_leastsquares::dot;
use trueaxis_selection::Projection;

use crate::Unexplained;
use crate::verification::base::base_columns;
use crate::verification::problem::Problem;

/// Twice the logarithm of the ratio of likelihoods below which no comparison is made: few tables of noise alone reach it.
const WORTH_A_LOOK: f64 = 8.0;

/// Tables of noise alone, of which none, or one, may look as much like two levels: a level of 0.5 %.
const TABLES: usize = 399;
const MOST_ALIKE: usize = 1;

/// Fewest jumps: a single one has an instant.
const LEAST_JUMPS: f64 = 3.0;

/// Distance of levels that are clearly apart, in standard deviations of the noise beside them.
const APART: f64 = 3.0;

/// Distance of levels in last digits of the readings: noise that is coarsely rounded has two levels next to each other.
const DIGITS: f64 = 5.0;

/// Most steps of expectation and maximisation.
const STEPS: usize = 60;

/// Change of the deviance that ends them.
const TOLERANCE: f64 = 1e-3;

/// Probability of a jump with which they begin.
const FIRST_JUMPS: f64 = 0.15;

/// Most readings times values of the base model, so that the comparison takes seconds at most.
const MOST_WORK: usize = 100_000;

/// What has two levels stands in one of two places.
const TO_DO: &str = "look for what stands in one of two places: a loose mount, joint or clamp, a reflector in its nest, a sensor \
     that locks onto the next fringe or line";

/// What is left of a problem that nothing else explains, if it jumps between two levels.
pub(crate) fn levels(problem: &Problem<'_>) -> Option<Unexplained> {
    let comparison = problem.comparison;
    // Errors of a prediction are alike at neighbouring positions, and not noise.
    if problem.calibrated {
        return None;
    }
    let columns = base_columns(comparison, false);
    if columns.len() * comparison.arrivals.len() > MOST_WORK {
        return None;
    }
    let base = Projection::dense(comparison.difference_um.clone(), &columns);
    let seen = TwoLevels::new(&base, &base.residuals)?;
    let digit_um = 12.0_f64.sqrt() * comparison.resolution_um().unwrap_or_default();
    let is_clear = 2.0 * seen.half_um > DIGITS * digit_um
        && seen.two_ln_ratio > WORTH_A_LOOK
        && seen.jumps >= LEAST_JUMPS
        && 2.0 * seen.half_um > APART * seen.noise_um;
    if !is_clear || looks_as_much(&base, problem.whitening.correlation, seen.two_ln_ratio) {
        return None;
    }
    let note = format!(
        "the readings jump between two levels {:.1} µm apart, {:.0} times; beside that they scatter by {:.1} µm",
        2.0 * seen.half_um,
        seen.jumps,
        seen.noise_um
    );
    let noise = base.rows() as f64 * seen.noise_um.powi(2) / base.squares();
    Some(Unexplained {
        share: (1.0 - noise).max(0.0),
        action: Some(TO_DO),
        ..Unexplained::new(Level::Verification, seen.half_um, vec!["time"], note)
    })
}

/// Whether more than a few tables of noise alone look as much like two levels.
fn looks_as_much(base: &Projection, correlation: f64, two_ln_ratio: f64) -> bool {
    // The same tables whenever the program runs.
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let innovation = (1.0 - correlation * correlation).sqrt();
    let mut alike = 0;
    for _ in 0..TABLES {
        let mut last: f64 = StandardNormal.sample(&mut random);
        let noise = (0..base.rows()).map(|_| {
            let own = last;
            let next: f64 = StandardNormal.sample(&mut random);
            last = correlation * last + innovation * next;
            own
        });
        let left = base.left_of(&noise.collect::<Vec<f64>>());
        let own = TwoLevels::new(base, &left);
        alike += usize::from(own.is_some_and(|own| own.two_ln_ratio >= two_ln_ratio));
        if alike > MOST_ALIKE {
            return true;
        }
    }
    false
}

/// Readings as two levels.
struct TwoLevels {
    /// Twice the logarithm of their likelihood over that of autoregressive noise.
    two_ln_ratio: f64,
    /// Half of the distance of the levels, µm.
    half_um: f64,
    /// Standard deviation beside them, µm.
    noise_um: f64,
    /// Expected number of jumps.
    jumps: f64,
}

impl TwoLevels {
    /// Of what a base model leaves; `None` if it leaves nothing.
    fn new(base: &Projection, left: &[f64]) -> Option<Self> {
        let n = left.len() as f64;
        let squares = dot(left, left);
        if squares <= 0.0 {
            return None;
        }
        let correlation = dot(&left[1..], &left[..left.len() - 1]) / squares;
        let of_noise = n * (squares / n).ln() + (n - 1.0) * (1.0 - correlation.powi(2)).ln();
        let mut level: Vec<f64> = left.iter().map(|x| 0.9 * x.signum()).collect();
        let mut of_jump = FIRST_JUMPS;
        let mut best: Option<Self> = None;
        for _ in 0..STEPS {
            // Expected levels are -1 to 1; what is uncertain of them is noise.
            let seen = base.left_of(&level);
            let uncertain: f64 = level.iter().map(|m| 1.0 - m * m).sum();
            let half = dot(left, &seen) / (dot(&seen, &seen) + uncertain);
            let rest: Vec<f64> = left.iter().zip(&seen).map(|(x, m)| x - half * m).collect();
            let variance = (dot(&rest, &rest) + half * half * uncertain) / n;
            if variance.is_nan() || variance <= f64::EPSILON * squares {
                return best;
            }
            let beside = rest.iter().zip(&level).map(|(x, m)| x + half * m);
            let (ln_likelihood, levels, jumps) = smoothed(beside, half, variance, of_jump);
            let of_levels = n * variance.ln() - 2.0 * ln_likelihood;
            let two_ln_ratio = of_noise + n - of_levels;
            let gained = best.as_ref().map(|best| two_ln_ratio - best.two_ln_ratio);
            best = Some(Self {
                two_ln_ratio,
                half_um: half.abs(),
                noise_um: variance.sqrt(),
                jumps,
            });
            if gained.is_some_and(|gained| gained.abs() < TOLERANCE) {
                break;
            }
            level = levels;
            of_jump = (jumps / (n - 1.0)).clamp(0.5 / n, 0.5);
        }
        best
    }
}

/// The logarithm of the likelihood of readings beside `±half` (in units of `variance`, up to a constant), their
/// expected levels, and the expected number of jumps: the forward and the backward recursion.
fn smoothed(
    beside: impl Iterator<Item = f64>,
    half: f64,
    variance: f64,
    of_jump: f64,
) -> (f64, Vec<f64>, f64) {
    let likelihoods = |x: f64| {
        [-half, half].map(|level| {
            let likelihood = (-0.5 * (x - level).powi(2) / variance).exp();
            likelihood.max(f64::MIN_POSITIVE)
        })
    };
    let given: Vec<[f64; 2]> = beside.map(likelihoods).collect();
    let moved = |[low, high]: [f64; 2]| {
        let stay = 1.0 - of_jump;
        [stay * low + of_jump * high, of_jump * low + stay * high]
    };
    let mut forward: Vec<([f64; 2], f64)> = Vec::with_capacity(given.len());
    for own in &given {
        let before = forward.last().map_or([0.5; 2], |(last, _)| moved(*last));
        let joint = [before[0] * own[0], before[1] * own[1]];
        let sum = joint[0] + joint[1];
        forward.push((joint.map(|p| p / sum), sum));
    }
    let ln_likelihood = forward.iter().map(|(_, sum)| sum.ln()).sum();
    let mut backward = [1.0; 2];
    let mut levels = vec![0.0; given.len()];
    let mut jumps = 0.0;
    for i in (0..given.len()).rev() {
        let ([low, high], sum) = forward[i];
        levels[i] = high * backward[1] - low * backward[0];
        let from_here = [
            given[i][0] * backward[0] / sum,
            given[i][1] * backward[1] / sum,
        ];
        if let Some(([low, high], _)) = i.checked_sub(1).map(|last| forward[last]) {
            jumps += of_jump * (low * from_here[1] + high * from_here[0]);
        }
        backward = moved(from_here);
    }
    (ln_likelihood, levels, jumps)
}
