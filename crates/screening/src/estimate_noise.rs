//! The noise that the residuals show, in place of the declared one.

use nalgebra::Matrix2;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::{Error, Network, Noise, Solution, solve_with_noise};

/// Estimated noise with what is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseEstimate {
    /// The noise with which the network was finally solved.
    pub noise: Noise,
    /// The source of the estimate.
    pub basis: NoiseBasis,
    /// Covariance of the relative errors of the variances of a length and of the repeatability. Zero where the given
    /// noise was kept.
    pub relative_covariance: Matrix2<f64>,
    /// The constant part of a length's standard deviation.
    pub length: PartEstimate,
    /// The standard deviation of the machine's repeatability.
    pub repeatability: PartEstimate,
}

/// The source of an estimate of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseBasis {
    /// Too little redundancy: the given noise was kept.
    Given,
    /// The lengths do not separate the two parts: the given noise times a common factor.
    CommonFactor,
    /// Both parts were estimated.
    Components,
}

/// One part of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartEstimate {
    /// Standard deviation, mm.
    pub sigma_mm: f64,
    /// Its standard uncertainty, mm; zero where the given one was kept.
    pub u_mm: f64,
    /// Degrees of freedom of its square; infinite where the given one was kept.
    pub degrees_of_freedom: f64,
    /// Two-sided probability of an estimate as far from the given value if that is right; `None` where nothing can be
    /// compared.
    pub p_value: Option<f64>,
}

/// With fewer degrees of freedom than this a declared variance is kept: the relative uncertainty of an estimate would
/// be above one half.
pub const LEAST_DEGREES_OF_FREEDOM: f64 = 8.0;

/// Significance at which the declared noise is given up even with few degrees of freedom.
const REJECTED: f64 = 1e-3;

/// Least ratio of the noise of a length to the machine's repeatability at which both are estimated.
const LEAST_LENGTH: f64 = 1e-3;

/// No length is known better than this, mm: a nanometre.
const ROUNDING_MM: f64 = 1e-6;

/// Residuals smaller than this share of the declared noise come from a calculation, not from an instrument.
pub const TOO_GOOD: f64 = 0.01;

/// Residuals (rms) that no measurement of a machine leaves, mm.
const CALCULATED_MM: f64 = 1e-4;

/// Parts that the data separate less than this (`1 - ρ²` of their estimates) get a common factor.
pub const LEAST_SEPARATION: f64 = 0.01;

/// Converged when no factor differs from one by more than this share of its own uncertainty.
const CONVERGED: f64 = 0.02;

const MAX_ITERATIONS: usize = 12;

/// No step changes a variance by a larger factor, so that a bad start does not end at zero.
const LARGEST_STEP: f64 = 100.0;

/// A variance smaller than this share of its start is zero.
const VANISHED: f64 = 1e-6;

/// Estimates the noise of a solved network and solves it again with the estimate. `declared` says whether the
/// network's noise is more than a guess: then it is kept where the data show less.
pub fn estimate_noise(
    network: &mut Network,
    solution: &mut Solution,
    declared: bool,
) -> Result<NoiseEstimate, Error> {
    let mut adjusted = Weighted { network, solution };
    let given = adjusted.network.noise;
    let dof = adjusted.degrees_of_freedom();
    let above = chi_squared_upper_tail(adjusted.squares(), dof);
    // A noise that is declared in another unit is a hundred times too large, too.
    let is_calculated = adjusted.solution.rms_residual_mm() < CALCULATED_MM;
    let too_good = is_calculated && adjusted.sigma0() < TOO_GOOD;
    if dof == 0.0 || (declared && above > REJECTED && (too_good || dof < LEAST_DEGREES_OF_FREEDOM))
    {
        return Ok(kept(given));
    }
    if too_good {
        return common_factor(&mut adjusted, given);
    }
    // A start far from the residuals may end where the components cannot be separated.
    let plausible = declared && above > REJECTED && above < 1.0 - REJECTED;
    let starts = [
        Some(given).filter(|n| plausible && n.repeatability_mm > 0.0),
        Some(level(given)),
    ];
    for start in starts.into_iter().flatten() {
        if adjusted.network.noise != start {
            adjusted.solve_with(start)?;
        }
        if !plausible {
            let sigma0 = adjusted.sigma0();
            adjusted.solve_with(scaled(start, sigma0, sigma0))?;
        }
        if let Some(found) = both_parts(&mut adjusted, given)? {
            return Ok(found);
        }
    }
    adjusted.solve_with(given)?;
    common_factor(&mut adjusted, given)
}

/// A solved network that can be solved again with another noise.
struct Weighted<'a> {
    network: &'a mut Network,
    solution: &'a mut Solution,
}

impl Weighted<'_> {
    /// Solves the network with another noise.
    fn solve_with(&mut self, noise: Noise) -> Result<(), Error> {
        self.network.noise = noise;
        *self.solution = solve_with_noise(self.network, self.solution)?;
        Ok(())
    }

    /// Redundancy of the lengths.
    fn degrees_of_freedom(&self) -> f64 {
        self.solution.of_lengths(self.network).1
    }

    /// Sum of squares of the whitened residuals of the lengths.
    fn squares(&self) -> f64 {
        self.solution.of_lengths(self.network).0
    }

    /// Standard deviation of unit weight of the lengths.
    fn sigma0(&self) -> f64 {
        (self.squares() / self.degrees_of_freedom()).sqrt()
    }
}

/// A noise with two equal parts.
pub(crate) fn level(given: Noise) -> Noise {
    Noise {
        repeatability_mm: given.length_sigma_mm,
        ..given
    }
}

/// The estimate of both parts, improved until they converge; `None` if they do not converge, if the lengths do not separate them
/// there, or if the adjustment does not converge.
fn both_parts(adjusted: &mut Weighted<'_>, given: Noise) -> Result<Option<NoiseEstimate>, Error> {
    let start = adjusted.network.noise;
    for _ in 0..MAX_ITERATIONS {
        let is_solved = adjusted.solution.termination.is_converged();
        let components = || adjusted.solution.variance_components(adjusted.network);
        let Some(found) = is_solved.then(components).flatten() else {
            return Ok(None);
        };
        let told_apart = found.separation >= LEAST_SEPARATION;
        let converged = (0..2)
            .all(|k| (found.factors[k] - 1.0).abs() <= CONVERGED * found.covariance[(k, k)].sqrt());
        if converged {
            // Only the lengths must be known well: a repeatability that is small beside them needs no more.
            let worth = 2.0 / found.covariance[(0, 0)] >= LEAST_DEGREES_OF_FREEDOM;
            let noise = adjusted.network.noise;
            let is_known = worth && told_apart;
            return Ok(is_known.then(|| estimated(noise, given, found.covariance)));
        }
        let step = |k: usize| {
            let factor = found.factors[k];
            factor.clamp(1.0 / LARGEST_STEP, LARGEST_STEP).sqrt()
        };
        let mut noise = scaled(adjusted.network.noise, step(0), step(1));
        // Every interferometer has some noise of its own, but the lengths are too few to show it.
        let least_mm = LEAST_LENGTH * noise.repeatability_mm;
        if noise.length_sigma_mm < least_mm {
            return Ok(None);
        }
        let vanished = (noise.repeatability_mm / start.repeatability_mm).powi(2) < VANISHED;
        if vanished {
            noise.repeatability_mm = 0.0;
        }
        adjusted.solve_with(noise)?;
        if vanished {
            return match told_apart {
                true => lengths_only(adjusted, given).map(Some),
                false => Ok(None),
            };
        }
    }
    Ok(None)
}

/// The estimate where the machine returns exactly, as far as the lengths show.
fn lengths_only(adjusted: &mut Weighted<'_>, given: Noise) -> Result<NoiseEstimate, Error> {
    let dof = adjusted.degrees_of_freedom();
    adjusted.solve_with(scaled(adjusted.network.noise, adjusted.sigma0(), 1.0))?;
    let relative_covariance = Matrix2::new(2.0 / dof, 0.0, 0.0, 0.0);
    Ok(estimated(
        adjusted.network.noise,
        given,
        relative_covariance,
    ))
}

/// The estimate of both parts with the given ratio.
fn common_factor(adjusted: &mut Weighted<'_>, given: Noise) -> Result<NoiseEstimate, Error> {
    let dof = adjusted.degrees_of_freedom();
    let sigma0 = adjusted.sigma0().max(ROUNDING_MM / given.length_sigma_mm);
    adjusted.solve_with(scaled(given, sigma0, sigma0))?;
    let relative_covariance = Matrix2::from_element(2.0 / dof);
    Ok(NoiseEstimate {
        basis: NoiseBasis::CommonFactor,
        ..estimated(adjusted.network.noise, given, relative_covariance)
    })
}

/// The noise with both standard deviations times factors.
pub fn scaled(noise: Noise, length: f64, repeatability: f64) -> Noise {
    Noise {
        length_sigma_mm: noise.length_sigma_mm * length,
        length_sigma_relative: noise.length_sigma_relative * length,
        repeatability_mm: noise.repeatability_mm * repeatability,
    }
}

fn kept(given: Noise) -> NoiseEstimate {
    NoiseEstimate {
        basis: NoiseBasis::Given,
        ..estimated(given, given, Matrix2::zeros())
    }
}

fn estimated(noise: Noise, given: Noise, relative_covariance: Matrix2<f64>) -> NoiseEstimate {
    let part = |k: usize, sigma_mm: f64, given_mm: f64| {
        let variance = relative_covariance[(k, k)];
        let degrees_of_freedom = 2.0 / variance;
        let comparable = given_mm > 0.0 && degrees_of_freedom.is_finite();
        let p_value = comparable.then(|| {
            let statistic = degrees_of_freedom * (sigma_mm / given_mm).powi(2);
            let above = chi_squared_upper_tail(statistic, degrees_of_freedom);
            (2.0 * above.min(1.0 - above)).min(1.0)
        });
        PartEstimate {
            sigma_mm,
            u_mm: 0.5 * sigma_mm * variance.sqrt(),
            degrees_of_freedom,
            p_value,
        }
    };
    NoiseEstimate {
        noise,
        basis: NoiseBasis::Components,
        relative_covariance,
        length: part(0, noise.length_sigma_mm, given.length_sigma_mm),
        repeatability: part(1, noise.repeatability_mm, given.repeatability_mm),
    }
}
