//! The scale of all lengths together, which lengths alone do not determine.
//!
//! An instrument whose scale is off by `s` shows
//!
//! ```text
//! l = (1 + s) |p - S| - L
//! ```
//!
//! the lengths of a world that is larger by `1 + s`: they leave the scale of the whole as free as its position. So
//! they are adjusted as they are, and what they give is then made smaller. The scale is declared, or follows from a
//! known distance `D` between two targets, which the adjustment has as `d`:
//!
//! ```text
//! s = 0 + e     σ: `scale_sigma_ppm`          s = d / D - 1 + e     σ² = (u²(d) + σ_D²) / D²
//! ```
//!
//! With their weighted mean, `s = cᵀ t + ε` with the shared sources `t` of the adjustment and a part `ε` of its own,
//! points `p`, poses and stations owe `-p s` to its error.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, RowDVector, Translation3};
use trueaxis_campaign::KnownLength;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_multilateration::{Corrections, Distances, Pair};

use crate::lengths::LengthsAdjustment;
use crate::lengths::common_value::common_value;
use crate::report::KnownMisfit;

/// The scale of all lengths together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaleResult {
    /// By how much lengths are shown too long, relative.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// What determines it.
    pub basis: ScaleBasis,
}

/// What determines the scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScaleBasis {
    /// `scale_sigma_ppm` alone: the lengths are taken as they are.
    Declared,
    /// `known_lengths` alone.
    KnownLengths,
    /// Both.
    Both,
}

/// The scale as a function of the errors of an adjustment.
#[derive(Debug, Clone)]
pub(crate) struct Scale {
    pub(crate) result: ScaleResult,
    /// `c`.
    of_shared: RowDVector<f64>,
    /// Variance of `ε` in two parts: of the lengths' noise, and of what is declared.
    pub(crate) of_noise: f64,
    pub(crate) declared: f64,
    /// The distances and their weights in `s`, 1/mm; none where `s` is that of another adjustment.
    distances: Option<(Distances, Vec<f64>)>,
}

/// Where nothing is declared: air that is not compensated at all is within three times this.
const UNDECLARED: f64 = 1e-4;

impl LengthsAdjustment<'_> {
    /// The scale, if anything determines it, and the known lengths that contradict the others or what is declared;
    /// `limit` is that of Baarda's `w`.
    pub(crate) fn estimate_scale(&self, limit: f64) -> (Option<Scale>, Vec<KnownMisfit>) {
        let prior = self.campaign.instrument.scale_sigma_ppm;
        // Those of which both targets were measured, where they keep their distance.
        let known = self.campaign.known_lengths.iter();
        let measured = known.filter_map(|known| Some((known, self.pair(known.targets)?)));
        let (known, pairs): (Vec<&KnownLength>, Vec<Pair>) = measured.unzip();
        let solution = &self.screened.solution;
        let found = solution.distances(&self.screened.network, &pairs);
        if prior.is_none() && known.is_empty() {
            return (None, Vec::new());
        }
        let shared = solution.covariance.reduced_inverse();
        let through = &found.of_shared * shared * found.of_shared.transpose();
        let count = known.len();
        let mut observed = vec![0.0; count + 1];
        let prior_sigma = prior.map_or(UNDECLARED, |ppm| ppm * 1e-6);
        let mut covariance = DMatrix::from_element(count + 1, count + 1, 0.0);
        covariance[(count, count)] = prior_sigma * prior_sigma;
        for (i, a) in known.iter().enumerate() {
            observed[i] = found.values_mm[i] / a.length_mm - 1.0;
            for (j, b) in known.iter().enumerate() {
                covariance[(i, j)] =
                    (through[(i, j)] + found.own[(i, j)]) / (a.length_mm * b.length_mm);
            }
            covariance[(i, i)] += (a.sigma_um * MICROMETRE / a.length_mm).powi(2);
        }
        let Some(mean) = common_value(&observed, &covariance, count, limit) else {
            return (None, Vec::new());
        };
        let misfits = mean.misfits.iter().map(|misfit| {
            let known = known[misfit.observation];
            let [a, b] = known.targets.map(|t| &self.campaign.targets[t].name);
            let what = format!("known length {a}-{b}");
            misfit.of(what, -misfit.difference * known.length_mm)
        });
        let misfits = misfits.collect();
        let takes_part = mean.weights[..count].iter().any(|w| *w > 0.0);
        let basis = match (takes_part, prior.is_some()) {
            (true, true) => ScaleBasis::Both,
            (true, false) => ScaleBasis::KnownLengths,
            (false, true) => ScaleBasis::Declared,
            (false, false) => return (None, misfits),
        };
        let weights = known.iter().zip(&mean.weights);
        let weights: Vec<f64> = weights.map(|(known, w)| w / known.length_mm).collect();
        let in_mm = DVector::from_column_slice(&weights);
        let of_lengths = known.iter().zip(&weights);
        let of_lengths = of_lengths.map(|(known, w)| (w * known.sigma_um * MICROMETRE).powi(2));
        let declared = of_lengths.sum::<f64>() + (mean.weights[count] * prior_sigma).powi(2);
        let all = DVector::from_column_slice(&mean.weights);
        let scale = Scale {
            result: ScaleResult {
                value: mean.value,
                u: all.dot(&(&covariance * &all)).sqrt(),
                basis,
            },
            of_shared: in_mm.transpose() * &found.of_shared,
            of_noise: in_mm.dot(&(&found.own * &in_mm)),
            declared,
            distances: Some((found, weights)),
        };
        (Some(scale), misfits)
    }

    fn pair(&self, targets: [usize; 2]) -> Option<Pair> {
        let place = |g: usize| {
            let place = |t: usize| self.groups[g].targets.iter().position(|seen| *seen == t);
            Some([place(targets[0])?, place(targets[1])?])
        };
        let bodies = self.screened.network.bodies.as_deref();
        let of_body = (0..self.groups.len()).find_map(|g| {
            let (placed, [a, b]) = (&bodies?.of_groups[g], place(g)?);
            let body = placed.body?;
            let places = [placed.places[a], placed.places[b]];
            Some(Pair::OfBody { body, places })
        });
        let of_bed = || {
            let group = self.screened.network.bed?;
            let points = place(group)?;
            Some(Pair::OfGroup { group, points })
        };
        of_body.or_else(of_bed)
    }
}

impl Scale {
    /// The same as a quantity of its own, for an adjustment with other sources.
    pub(crate) fn of_another(&self) -> Self {
        Self {
            of_shared: RowDVector::zeros(0),
            of_noise: self.result.u.powi(2) - self.declared,
            distances: None,
            ..self.clone()
        }
    }

    /// `c`, filled up to `width` sources, and behind it the coefficient of `ε`.
    pub(crate) fn coefficients(&self, width: usize) -> RowDVector<f64> {
        let mut row = RowDVector::zeros(width + 1);
        row.columns_mut(0, self.of_shared.ncols())
            .copy_from(&self.of_shared);
        row[width] = 1.0;
        row
    }

    /// The error of `s` in a trial, with the errors of what does not follow from its lengths, `N(0, 1)`.
    pub(crate) fn change(&self, corrections: &Corrections, [noise, declared]: [f64; 2]) -> f64 {
        let of_lengths = match &self.distances {
            Some((distances, weights)) => {
                let changes_mm = distances.changes_mm(corrections);
                changes_mm.iter().zip(weights).map(|(d, w)| d * w).sum()
            }
            None => self.of_noise.max(0.0).sqrt() * noise,
        };
        of_lengths + self.declared.sqrt() * declared
    }
}

/// A pose in a world that is larger by `1 + scale`, as it is: the targets are made smaller about the centre
/// of their home positions, which moves.
pub(crate) fn at_scale(
    pose: &Isometry3<f64>,
    home_centre: &Point3<f64>,
    scale: f64,
) -> Isometry3<f64> {
    let centre = (pose * home_centre).coords;
    Translation3::from(centre / (1.0 + scale) - centre) * pose
}
