//! Errors of simulated campaigns against their stated uncertainties.
//!
//! The results of one campaign share its stations and its noise, so a campaign is one draw: with sums `S_c`
//! over the `n_c` numbers of campaign `c`, a mean and its standard error are
//!
//! ```text
//! m = Σ S_c / Σ n_c        s² = N / (N - 1) Σ (S_c - m n_c)² / (Σ n_c)²
//! ```
//!
//! (Cochran, Sampling Techniques, ratio estimates), and never less than if all numbers were independent: a
//! few intervals that all hold the truth have no scatter.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use trueaxis_calibrate::Calibration;
use trueaxis_simulate::Truth;

use crate::{Deviation, Kind, components, locations, stations};

/// What campaigns of one scenario give.
#[derive(Debug, Clone, Default)]
pub struct Scatter {
    /// The deviations of each campaign.
    pub campaigns: Vec<Vec<Deviation>>,
}

/// A mean with the standard error that follows from the scatter between campaigns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Results of some kinds, pooled over campaigns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Numbers with an uncertainty.
    pub numbers: usize,
    /// Rms of the errors, mm or rad.
    pub rms: f64,
    /// Rms of error / u, where one is expected for Student's distribution as well.
    pub ratio: Estimate,
    /// Share of the 95 % intervals that hold the truth.
    pub coverage: Estimate,
}

impl Scatter {
    /// Compares a campaign with the truth. What gauge or frame define is left out.
    ///
    /// # Panics
    /// If that is not exact.
    pub fn add(&mut self, calibration: &Calibration, truth: &Truth) {
        let mut all = components(calibration, truth);
        all.extend(locations(calibration, truth));
        all.extend(stations(calibration, truth));
        all.retain(|deviation| deviation.is_inside().is_some());
        self.campaigns.push(all);
    }

    /// The kinds of results that there are.
    pub fn kinds(&self) -> BTreeSet<Kind> {
        self.campaigns.iter().flatten().map(|d| d.kind).collect()
    }

    /// The same errors beside other uncertainties: what the checks say of those.
    #[must_use]
    pub fn with_u(&self, u: impl Fn(&Deviation) -> f64) -> Self {
        let mut other = self.clone();
        let all = other.campaigns.iter_mut().flatten();
        all.for_each(|deviation| deviation.u = u(deviation));
        other
    }

    /// Results for which `which` holds, pooled.
    pub fn pooled(&self, which: impl Fn(&Deviation) -> bool) -> Pooled {
        let of_kind: Vec<Vec<&Deviation>> = self
            .campaigns
            .iter()
            .map(|campaign| campaign.iter().filter(|d| which(d)).collect())
            .collect();
        let numbers = of_kind.iter().map(Vec::len).sum();
        let mean = |of: &dyn Fn(&Deviation) -> f64, independent: f64| {
            let sums = of_kind.iter().map(|campaign| {
                let sum: f64 = campaign.iter().map(|d| of(d)).sum();
                (sum, campaign.len() as f64)
            });
            mean_of_clusters(&sums.collect::<Vec<_>>(), independent)
        };
        let squares = mean(&Deviation::square, 2.0);
        let ratio = squares.value.sqrt();
        let inside = |d: &Deviation| f64::from(u8::from(d.is_inside() == Some(true)));
        Pooled {
            numbers,
            rms: mean(&|d| d.error * d.error, 0.0).value.sqrt(),
            ratio: Estimate {
                value: ratio,
                standard_error: squares.standard_error / (2.0 * ratio),
            },
            coverage: mean(&inside, 0.95 * 0.05),
        }
    }

    /// For every single result, by name, the rms over the campaigns of error / u.
    pub fn single_ratios(&self) -> BTreeMap<&str, f64> {
        let mut sums: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
        for deviation in self.campaigns.iter().flatten() {
            let sum = sums.entry(&deviation.name).or_default();
            *sum = (sum.0 + deviation.square(), sum.1 + 1.0);
        }
        let rms = |(sum, count): (f64, f64)| (sum / count).sqrt();
        sums.into_iter()
            .map(|(name, sum)| (name, rms(sum)))
            .collect()
    }
}

/// The mean of clusters with their sums and sizes; `independent` is the variance of one number.
fn mean_of_clusters(sums: &[(f64, f64)], independent: f64) -> Estimate {
    let (sum, numbers) = sums
        .iter()
        .fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1));
    let value = sum / numbers;
    let squares: f64 = sums.iter().map(|(s, n)| (s - value * n).powi(2)).sum();
    let clusters = sums.len() as f64;
    let variance = clusters / (clusters - 1.0) * squares / (numbers * numbers);
    Estimate {
        value,
        standard_error: variance.max(independent / numbers).sqrt(),
    }
}

impl Estimate {
    /// How many standard errors it is off.
    pub fn off(&self, expected: f64) -> f64 {
        (self.value - expected) / self.standard_error
    }
}

impl Pooled {
    /// Whether scatter and coverage are as stated within so many standard errors.
    pub fn is_as_stated(&self, standard_errors: f64) -> bool {
        self.ratio.off(1.0).abs() < standard_errors
            && self.coverage.off(0.95).abs() < standard_errors
    }
}

impl fmt::Display for Pooled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            numbers,
            ratio,
            coverage,
            ..
        } = self;
        write!(
            f,
            "{numbers:7} numbers, error / u {:.3} ± {:.3}, {:.1} ± {:.1} % inside 95 %",
            ratio.value,
            ratio.standard_error,
            100.0 * coverage.value,
            100.0 * coverage.standard_error
        )
    }
}
