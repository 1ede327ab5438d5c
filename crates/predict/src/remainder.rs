//! What the interpolation between steps may be off by.
//!
//! Leaving out the step at `q_j` and interpolating from its four neighbours leaves
//! `r_j = f[q_{j-2}, …, q_{j+2}] ω_j`, Newton's remainder there ([`crate::curve`]), and between the true
//! steps, which are nearer, the remainder is `f[…] ω(q)`. So what leaving steps out shows is taken to the true
//! spacing by the divided differences, whose mean square beyond the noise is
//!
//! ```text
//! s² = mean_j ((Σ w_jk f_k)² - w_jᵀ cov(f) w_j)     u(q) = s |ω(q)|
//! ```
//!
//! over all windows of five steps of a curve (0 if that is negative). In the middle between steps of equal distance
//! `r_j` is 64/9 times as large, so that an interpolation error that is hidden in the noise is small beside it.
//!
//! Newton's remainder takes the divided difference at q for that of the steps, which a short wave is not: of a wave with the
//! phase `θ` from step to step, half way between steps of equal distance, the polynomial leaves `(1 - c)²(2 + c)/2` and the divided
//! differences say `3/8 (1 - c²)²`, `c = cos θ/2`. How fast they change tells `θ` of the shortest wave that there is: neighbours of
//! them correlate by `ρ = cos θ`. So, where the polynomial is of third degree,
//!
//! ```text
//! ρ = mean_j (r_j r_{j+1} - w_jᵀ cov(f) w_{j+1}) / s²     c² = (1 + ρ)/2     u(q) = s |ω(q)| 4 (2 + c) / (3 (1 + c)²)
//! ```
//!
//! which is 1.03 `s |ω|` for a wave of ten steps, 1.15 for one of five, 1.8 for one of two and a half, and 8/3 for what goes up and
//! down with every step. What fits between the steps unseen is unseen.
//!
//! Outside the steps the errors of the nearest, `q_0`, are held, whose remainder is that of a slope. With the step before it,
//! `q_1`, and `d = |q - q_0|`, `h = |q_0 - q_1|`,
//!
//! ```text
//! f(q) - f(q_0) = ±d (f[q_1, q_0] ± (d + h) f[q_1, q_0, q])      u(q)² = d² (max(s_1², f[q_1, q_0]²) + (d + h)² s_2²)
//! ```
//!
//! `s_1`, `s_2` are the same rms of slopes and second differences over the curve. What the gauge leaves of a straightness is
//! steepest at its ends, as is a bow: by the mean slope alone u would be too small by a factor of up to 1.8 (3 for
//! polynomials of the fifth degree). Where the slope at the end is small, the mean counts. Noise may hide the slopes over
//! single steps (u would be 0 beyond home, where an angle is 0 by definition): `s_1` is the largest rms of those over 1, 2,
//! 4, … steps. A mean slope over more steps has less noise, and is no larger than those that it is the mean of.

use nalgebra::Vector6;
use trueaxis_kinematics::MotionError;

use crate::curve::{Curve, Sample};
use crate::factored_covariance::FactoredCovariance;
use crate::knots::DividedDifference;

/// What the six components may be off by, mm and rad.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Remainder {
    /// `s`, times what it is too small by for short waves.
    between: Vector6<f64>,
    /// `s_2`.
    bend: Vector6<f64>,
    /// At the last step and at the first.
    ends: [End; 2],
}

/// What goes on outside an end.
#[derive(Debug, Clone, PartialEq)]
struct End {
    /// The larger of `s_1` and the slope there, on the side of approach where that is largest.
    slope: Vector6<f64>,
    /// `h`.
    gap: f64,
}

impl Remainder {
    /// Of the errors of an axis; its component errors begin at `first` among the results.
    pub(crate) fn new(
        curve: &Curve,
        errors: &[MotionError],
        factors: &FactoredCovariance,
        first: usize,
    ) -> Self {
        let value = |difference: &DividedDifference| -> Vector6<f64> {
            let nodes = difference.iter();
            nodes.map(|&(node, w)| errors[node].to_vector() * w).sum()
        };
        let places = |difference: &DividedDifference| -> Vec<(usize, Vector6<f64>)> {
            let nodes = difference.iter();
            let of_node =
                |&(node, w)| (0..6).map(move |c| (first + 6 * node + c, Vector6::ith(c, w)));
            nodes.flat_map(of_node).collect()
        };
        // Less what the noise makes of it.
        let product = |a: &DividedDifference, b: &DividedDifference| {
            let noise = factors.of_functions(&places(a), &places(b)).diagonal();
            value(a).component_mul(&value(b)) - noise
        };
        let rms = |differences: &[DividedDifference]| {
            let sum: Vector6<f64> = differences.iter().map(|d| product(d, d)).sum();
            sum.map(|sum| (sum.max(0.0) / differences.len().max(1) as f64).sqrt())
        };
        let slopes = (0..).map(|k| curve.slopes(1 << k));
        let slopes = slopes.take_while(|slopes| !slopes.is_empty());
        let mean_slope = slopes.fold(Vector6::zeros(), |most, over| most.sup(&rms(&over)));
        let end = |is_below: bool| {
            let mut end = End {
                slope: mean_slope,
                gap: 0.0,
            };
            for (slope, gap) in curve.slopes_at_end(is_below) {
                end.slope = end.slope.sup(&rms(&[slope]));
                end.gap = end.gap.max(gap);
            }
            end
        };
        let between = rms(&curve.divided_differences(None));
        let neighbours = curve.neighbouring_differences();
        let together: Vector6<f64> = neighbours.iter().map(|[a, b]| product(a, b)).sum();
        let together = together / neighbours.len().max(1) as f64;
        let of_short_waves = between.zip_map(&together, |s, together| {
            let correlation = if neighbours.is_empty() || s <= 0.0 {
                1.0
            } else {
                together / (s * s)
            };
            of_short_waves(correlation)
        });
        Self {
            between: between.component_mul(&of_short_waves),
            bend: rms(&curve.divided_differences(Some(2))),
            ends: [false, true].map(end),
        }
    }

    /// Standard uncertainty of a sample of the curve beside that of the data, mm and rad.
    pub(crate) fn u(&self, sample: &Sample) -> Vector6<f64> {
        let end = &self.ends[usize::from(sample.is_below)];
        let bend = self.bend * (sample.beyond + end.gap);
        let outside = end.slope.zip_map(&bend, f64::hypot) * sample.beyond;
        self.between * sample.remainder + outside
    }
}

/// How much more the polynomial of third degree leaves half way between steps than Newton's remainder says, for a wave whose
/// neighbouring divided differences correlate like this.
fn of_short_waves(correlation: f64) -> f64 {
    let c = (0.5 * (1.0 + correlation.clamp(-1.0, 1.0))).sqrt();
    4.0 * (2.0 + c) / (3.0 * (1.0 + c).powi(2))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand::{RngExt, SeedableRng};
    use trueaxis_kinematics::AxisKind;
    use trueaxis_montecarlo::ChaCha8Rng;

    use super::*;
    use crate::interpolation::tests::at;

    const STEPS: usize = 21;

    /// Mean square of the error of a curve outside its steps, and of u: waves of this length in steps and of random phase, less
    /// their average line over the steps, which the gauge takes.
    fn mean_squares(wave_steps: f64, beyond: f64) -> [f64; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let places: Vec<f64> = (0..STEPS).map(|k| k as f64).collect();
        let nodes: Vec<_> = places.iter().map(|&q| at(q, None)).collect();
        let curve = Curve::new(AxisKind::Linear, &nodes);
        let certain = FactoredCovariance::zero(STEPS, 6 * STEPS);
        let centre = 0.5 * (STEPS - 1) as f64;
        let square: f64 = places.iter().map(|q| (q - centre).powi(2)).sum();
        let mut sums = [0.0; 2];
        for _ in 0..400 {
            let phase = Vector6::from_fn(|_, _| TAU * random.random::<f64>());
            let wave = |q: f64| phase.map(|phase| (TAU * q / wave_steps + phase).sin());
            let waves = || places.iter().map(|&q| (q, wave(q)));
            let mean = waves().map(|(_, f)| f).sum::<Vector6<f64>>() / STEPS as f64;
            let slope = waves().map(|(q, f)| f * (q - centre)).sum::<Vector6<f64>>() / square;
            let straight = |q: f64| wave(q) - mean - slope * (q - centre);
            let errors = places
                .iter()
                .map(|&q| MotionError::from_vector(&straight(q)));
            let errors: Vec<MotionError> = errors.collect();
            let remainder = Remainder::new(&curve, &errors, &certain, 0);
            for (q, held) in [(-beyond, 0), (2.0 * centre + beyond, STEPS - 1)] {
                let off = errors[held].to_vector() - straight(q);
                sums[0] += off.norm_squared();
                sums[1] += remainder.u(&curve.at(q)).norm_squared();
            }
        }
        sums
    }

    /// A wave of random phase: u is the rms of what the curve is off by half way between steps. That of 360 phases is known to 4 %, and
    /// the mean over 21 steps of waves that do not fit in is off by some per cent.
    #[test]
    fn u_between_the_steps_is_that_of_short_waves_too() {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let nodes: Vec<_> = (0..STEPS).map(|k| at(k as f64, None)).collect();
        let curve = Curve::new(AxisKind::Linear, &nodes);
        let certain = FactoredCovariance::zero(STEPS, 6 * STEPS);
        for wave_steps in [2.2, 3.0, 5.0, 20.0] {
            let mut sums = [0.0; 2];
            for _ in 0..60 {
                let phase = Vector6::from_fn(|_, _| TAU * random.random::<f64>());
                let wave = |q: f64| phase.map(|phase| (TAU * q / wave_steps + phase).sin());
                let errors = (0..STEPS).map(|k| MotionError::from_vector(&wave(k as f64)));
                let errors: Vec<MotionError> = errors.collect();
                let remainder = Remainder::new(&curve, &errors, &certain, 0);
                for k in 1..STEPS - 2 {
                    let q = k as f64 + 0.5;
                    let sample = curve.at(q);
                    let found: Vector6<f64> = sample
                        .weights
                        .iter()
                        .map(|&(node, weight)| errors[node].to_vector() * weight)
                        .sum();
                    sums[0] += (found - wave(q)).norm_squared();
                    sums[1] += remainder.u(&sample).norm_squared();
                }
            }
            let ratio = (sums[0] / sums[1]).sqrt();
            assert!((0.9..1.1).contains(&ratio), "{wave_steps}: {ratio}");
        }
    }

    /// By the mean slope alone u was 1.2 (a wave over the travel) and 1.7 times (half a wave) too small. 4,800 errors each: their
    /// rms is known to a few per cent.
    #[test]
    fn u_outside_the_steps_is_that_of_the_ends() {
        for wave_steps in [10.0, 20.0, 40.0] {
            for beyond in [0.25, 1.0, 2.0] {
                let [squares, variances] = mean_squares(wave_steps, beyond);
                let ratio = (squares / variances).sqrt();
                assert!(
                    (0.6..1.1).contains(&ratio),
                    "{wave_steps} {beyond}: {ratio}"
                );
            }
        }
    }
}
