//! What wanders beside causes.
//!
//! A [`Disturbance`] is judged as a cause is, by twice the logarithm of the marginal likelihood ratio ([`Smooth`]), flat
//! over subjects; its p-value is that of all disturbances together (Bonferroni).

use rayon::prelude::*;
use trueaxis_multilateration::Noise;

use crate::Error;
use crate::engine::{SMOOTH_LEVEL, Smooth, Suspect, beside_one_of};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::disturbance::{Disturbance, Wanderer, wanderers};
use crate::selection::{DECISIVE, Projection};

/// More that wander at once are not told apart.
const MOST: usize = 3;

/// A disturbance with its judgement beside the others.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    pub(crate) disturbance: Disturbance,
    pub(crate) evidence: f64,
    pub(crate) p_value: f64,
    /// What explains as much.
    pub(crate) rivals: Vec<Wanderer>,
}

/// What wanders beside causes. Where it would be several single things, it may be one that they have in common: then
/// that is tried first, too, and the better explanation taken.
pub(super) fn wandering(base: &Base<'_>, suspects: &[Suspect]) -> Result<Vec<Judged>, Error> {
    let (first, noise) = one_after_the_other(base, suspects, None)?;
    let is_common = |wanderer: &Wanderer| wanderer.of_kind(base) == 1;
    if first.len() < 2 || first.iter().any(|j| is_common(&j.disturbance.wanderer)) {
        return Ok(first);
    }
    let mut all = vec![(first, noise)];
    for common in wanderers(base).into_iter().filter(is_common) {
        all.push(one_after_the_other(base, suspects, Some(common))?);
    }
    let plain = base.adjust(
        suspects.to_vec(),
        least(all.iter().map(|(_, noise)| *noise)),
    )?;
    let scored = all.into_iter().map(|(judged, _)| {
        let price = 2.0 * DECISIVE * judged.len() as f64;
        (of_wandering(base, &plain, &judged).0 - price, judged)
    });
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|best| best.1).unwrap_or_default())
}

/// What wanders beside causes, one after the other from `first`, each with the size that it has beside the others, and
/// the noise beside all.
fn one_after_the_other(
    base: &Base<'_>,
    suspects: &[Suspect],
    first: Option<Wanderer>,
) -> Result<(Vec<Judged>, Noise), Error> {
    let all = wanderers(base);
    let mut own: Vec<Judged> = Vec::new();
    loop {
        let here = base.beside(disturbances(&own));
        let adjusted = here.adjust(suspects.to_vec(), None)?;
        for k in 0..own.len() {
            let mut others = disturbances(&own);
            let wanderer = others.remove(k).wanderer;
            let without = base
                .beside(others)
                .adjust(suspects.to_vec(), Some(adjusted.network.noise))?;
            if let Some(again) = judge(base, &without, wanderer, all.len()) {
                let rivals = std::mem::take(&mut own[k].rivals);
                own[k] = Judged { rivals, ..again };
            }
        }
        own.retain(|judged| judged.p_value < SMOOTH_LEVEL);
        if own.len() == MOST {
            return Ok((own, adjusted.network.noise));
        }
        let is_next = |w: &Wanderer| match (first, own.is_empty()) {
            (Some(first), true) => *w == first,
            _ => own.iter().all(|o| o.disturbance.wanderer != *w),
        };
        let others: Vec<Wanderer> = all.iter().copied().filter(is_next).collect();
        let here = base.beside(disturbances(&own));
        let adjusted = match own.is_empty() {
            true => adjusted,
            false => here.adjust(suspects.to_vec(), None)?,
        };
        let judged = judge_all(base, &adjusted, &others, all.len());
        let Some(next) = judged.first().filter(|next| next.p_value < SMOOTH_LEVEL) else {
            return Ok((own, adjusted.network.noise));
        };
        let is_rival = |other: &&Judged| next.evidence - other.evidence < DECISIVE;
        let rivals = judged.iter().skip(1).filter(is_rival);
        let rivals: Vec<Wanderer> = rivals.map(|j| j.disturbance.wanderer).collect();
        let twin = next.disturbance.wanderer.twin(base);
        own.push(Judged {
            rivals: twin.into_iter().chain(rivals).collect(),
            ..next.clone()
        });
    }
}

/// Disturbances of what an adjusted model leaves, the one with the most evidence first.
fn judge_all(
    base: &Base<'_>,
    adjusted: &Adjusted,
    wanderers: &[Wanderer],
    family: usize,
) -> Vec<Judged> {
    let judged = wanderers.par_iter();
    let mut judged: Vec<Judged> = judged
        .filter_map(|&wanderer| judge(base, adjusted, wanderer, family))
        .collect();
    judged.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    judged
}

/// A disturbance of what an adjusted model leaves; none if the lengths do not show it.
fn judge(
    base: &Base<'_>,
    adjusted: &Adjusted,
    wanderer: Wanderer,
    family: usize,
) -> Option<Judged> {
    let projection: &Projection = &adjusted.projection;
    let mut columns = wanderer.columns_mm(base, &adjusted.solution);
    columns
        .iter_mut()
        .for_each(|column| adjusted.whitened.whiten(column));
    let lengths = wanderer.lengths(base);
    let spectra = lengths
        .iter()
        .map(|length| wanderer.roots_of_spectrum(base, *length));
    let smooth = Smooth::new(projection, &columns, &spectra.collect::<Vec<_>>())?;
    Some(Judged {
        disturbance: Disturbance {
            wanderer,
            length: lengths[smooth.spectrum],
            width: smooth.width,
        },
        evidence: smooth.evidence - 2.0 * (wanderer.of_kind(base) as f64).ln(),
        p_value: (family as f64 * smooth.p_value).min(1.0),
        rivals: Vec::new(),
    })
}

/// Twice the logarithm of the marginal likelihood ratio of what wanders against a model without it, and the
/// projection with it.
pub(super) fn of_wandering(
    base: &Base<'_>,
    plain: &Adjusted,
    wandering: &[Judged],
) -> (f64, Projection) {
    let mut projection = plain.projection.clone();
    let mut sum = 0.0;
    for judged in wandering {
        let own = &judged.disturbance;
        let columns = base.whitened_columns(own, &plain.whitened, &plain.solution);
        let tried = own.wanderer.lengths(base).len() * own.wanderer.of_kind(base);
        let (evidence, next) = beside_one_of(&projection, &columns, tried);
        sum += evidence;
        projection = next;
    }
    (sum, projection)
}

/// The noise with the least variance.
pub(super) fn least(noises: impl Iterator<Item = Noise>) -> Option<Noise> {
    let variance = |noise: &Noise| noise.length_sigma_mm.powi(2) + noise.repeatability_mm.powi(2);
    noises.min_by(|a, b| variance(a).total_cmp(&variance(b)))
}

pub(super) fn disturbances(judged: &[Judged]) -> Vec<Disturbance> {
    judged.iter().map(|judged| judged.disturbance).collect()
}
