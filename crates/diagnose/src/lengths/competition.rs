//! Causes and disturbances against each other.
//!
//! A [`Disturbance`] is judged as a cause is, by twice the logarithm of the marginal likelihood ratio: its standard
//! deviation by restricted maximum likelihood, flat over correlation lengths and subjects. Its p-value is that of the
//! restricted likelihood ratio at the border `w = 0`, `½ P(χ²₁ > LR)`, which is on the safe side (Crainiceanu and
//! Ruppert 2004), all disturbances together (Bonferroni).
//!
//! Two models are built. One finds causes first, then what wanders beside them, then causes again with that in the
//! covariance; the other begins with what wanders. They, and what wanders alone, are compared in the same noise by
//! their whole evidence. A form that can be anything is believed less than one of the catalogue, and every further
//! name costs: a cause is charged [`DECISIVE`], odds of 20 to 1, and a disturbance twice that. So a drift is a drift
//! though something that wanders might have done it, and three stacked causes do not beat one disturbance.
//!
//! A cause in time that leaves a tenth of what it explains to a disturbance of the same thing does not describe how
//! that thing moves, and loses its name ([`is_of`]).

use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::Noise;

use crate::Error;
use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::causes::{Found, Search, find_causes, settle};
use crate::lengths::culprit::is_of;
use crate::lengths::disturbance::{Disturbance, Wanderer, wanderers};
use crate::lengths::hypotheses::{hypotheses, scan, visit_times};
use crate::lengths::omnibus::Omnibus;
use crate::selection::{
    DECISIVE, Gram, Hypothesis, Null, Projection, dot, gram_matrix, marginal_of, rank,
};

/// Family-wise level of the disturbances.
const LEVEL: f64 = 0.002;

/// Without causes and with omnibus tests above this nothing wanders that would be significant.
const WORTH_A_LOOK: f64 = 0.05;

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

/// Causes, and what wanders beside them.
pub(crate) struct Model<'a> {
    /// The lengths, what wanders in their covariance.
    pub(crate) base: Base<'a>,
    pub(crate) search: Search,
    pub(crate) wandering: Vec<Judged>,
}

/// What is needed to look for causes.
pub(crate) struct Candidates<'a> {
    pub(crate) all: &'a [Hypothesis],
    pub(crate) null: &'a Null,
}

/// The model with the most evidence. `search` are the causes that were found without disturbances, `before` the tests
/// of what a model without any leaves.
pub(crate) fn compete<'a>(
    base: &Base<'a>,
    before: &[Omnibus],
    search: Search,
    candidates: &Candidates<'_>,
) -> Result<Model<'a>, Error> {
    let is_quiet = before.iter().all(|t| t.test.p_value >= WORTH_A_LOOK);
    let of_causes = |search| Model {
        base: base.clone(),
        search,
        wandering: Vec::new(),
    };
    if search.found.is_empty() && is_quiet {
        return Ok(of_causes(search));
    }
    let suspects = search.adjusted.suspects.clone();
    let beside = wandering(base, &suspects)?;
    let causes_first = match beside.is_empty() {
        true => of_causes(search),
        false => alternated(base, beside, candidates)?,
    };
    let alone = wandering(base, &[])?;
    if alone.is_empty() {
        return Ok(causes_first);
    }
    // Where causes explain all, what wanders must do it alone to be better.
    let is_complete = causes_first.wandering.is_empty() && causes_first.search.left <= 0.0;
    let only = without_causes(base, alone.clone())?;
    let mut model = best(base, vec![causes_first, only])?;
    if !is_complete || model.search.found.is_empty() {
        model = best(base, vec![model, alternated(base, alone, candidates)?])?;
    }
    described(base, model, candidates)
}

/// A cause is no more than a part of what wanders if this part of what it explains is left to a disturbance of the
/// same thing.
const PART: f64 = 0.1;

/// The model without causes that do not describe how the thing moves that they make responsible.
fn described<'a>(
    base: &Base<'a>,
    mut model: Model<'a>,
    candidates: &Candidates<'_>,
) -> Result<Model<'a>, Error> {
    loop {
        let wanders_on = |found: &Found| {
            model.wandering.iter().any(|judged| {
                judged.evidence > PART * found.statistic
                    && is_of(base, found, judged.disturbance.wanderer)
            })
        };
        let Some(undescribed) = model.search.found.iter().position(wanders_on) else {
            return Ok(model);
        };
        let mut suspects = model.search.adjusted.suspects;
        suspects.remove(undescribed);
        model = settled(base, suspects, candidates)?;
    }
}

/// Causes as they settle beside what wanders beside them.
fn settled<'a>(
    base: &Base<'a>,
    suspects: Vec<Suspect>,
    candidates: &Candidates<'_>,
) -> Result<Model<'a>, Error> {
    let wandering = wandering(base, &suspects)?;
    if suspects.is_empty() {
        return without_causes(base, wandering);
    }
    let here = base.beside(disturbances(&wandering));
    let (found, adjusted) = settle(&here, suspects, candidates.all, candidates.null)?;
    if found.is_empty() {
        return only_wandering(base);
    }
    Ok(Model {
        base: here,
        search: Search {
            found,
            adjusted,
            left: 0.0,
        },
        wandering,
    })
}

/// The model with the most evidence in the noise of the one with the least.
fn best<'a>(base: &Base<'a>, models: Vec<Model<'a>>) -> Result<Model<'a>, Error> {
    let noises = models.iter().map(|m| m.search.adjusted.network.noise);
    let plain = base.adjust(Vec::new(), least(noises))?;
    let evidences: Vec<f64> = models
        .iter()
        .map(|model| evidence(base, &plain, model))
        .collect();
    let first = evidences
        .iter()
        .fold(f64::NEG_INFINITY, |best, &e| best.max(e));
    let mut models = models.into_iter().zip(evidences);
    let found = models.find(|(_, evidence)| *evidence >= first);
    Ok(found.expect("one has the most").0)
}

/// The noise with the least variance.
fn least(noises: impl Iterator<Item = Noise>) -> Option<Noise> {
    let variance = |noise: &Noise| noise.length_sigma_mm.powi(2) + noise.return_sigma_mm.powi(2);
    noises.min_by(|a, b| variance(a).total_cmp(&variance(b)))
}

/// Twice the logarithm of the marginal likelihood ratio of what wanders against a model without it, and the
/// projection with it.
fn of_wandering(base: &Base<'_>, plain: &Adjusted, wandering: &[Judged]) -> (f64, Projection) {
    let mut projection = plain.projection.clone();
    let mut sum = 0.0;
    for judged in wandering {
        let own = &judged.disturbance;
        let columns = base.whitened_columns(own, &plain.whitened, &plain.solution);
        let (next, ln_price) = projection.beside(&columns);
        let ratio = (next.squares() / projection.squares()).max(f64::MIN_POSITIVE);
        let tried = own.wanderer.lengths(base).len() * own.wanderer.of_kind(base);
        sum -= projection.degrees_of_freedom * ratio.ln() + ln_price + 2.0 * (tried as f64).ln();
        projection = next;
    }
    (sum, projection)
}

/// Twice the logarithm of the marginal likelihood ratio against the model without anything, less what names cost.
fn evidence(base: &Base<'_>, plain: &Adjusted, model: &Model<'_>) -> f64 {
    let (mut sum, projection) = of_wandering(base, plain, &model.wandering);
    let visits = visit_times(base);
    let mut adjusted = plain.with(projection);
    for found in &model.search.found {
        let hypothesis = found.suspect.hypothesis;
        if let Some(scan) = scan(base, &adjusted, &visits, hypothesis) {
            let score = rank(&adjusted.projection, std::slice::from_ref(&scan));
            sum += score.first().map_or(0.0, |score| score.evidence);
            let columns = base.columns(&adjusted, &hypothesis, found.suspect.shape);
            adjusted = adjusted.with(adjusted.projection.extended(&columns));
        }
    }
    let names = model.search.found.len() + 2 * model.wandering.len();
    sum - DECISIVE * names.saturating_sub(1) as f64
}

/// Only what wanders.
fn without_causes<'a>(base: &Base<'a>, wandering: Vec<Judged>) -> Result<Model<'a>, Error> {
    let base = base.beside(disturbances(&wandering));
    let adjusted = base.adjust(Vec::new(), None)?;
    Ok(Model {
        base,
        search: Search {
            found: Vec::new(),
            adjusted,
            left: 0.0,
        },
        wandering,
    })
}

/// Only what wanders, found without any cause.
pub(crate) fn only_wandering<'a>(base: &Base<'a>) -> Result<Model<'a>, Error> {
    without_causes(base, wandering(base, &[])?)
}

/// Causes beside what wanders, what wanders beside those, and both as they settle.
fn alternated<'a>(
    base: &Base<'a>,
    first: Vec<Judged>,
    candidates: &Candidates<'_>,
) -> Result<Model<'a>, Error> {
    let here = base.beside(disturbances(&first));
    let start = here.adjust(Vec::new(), None)?;
    let scans = hypotheses(&here, &start, candidates.all).scans;
    let search = find_causes(&here, start, candidates.all, &scans, candidates.null)?;
    if search.found.is_empty() {
        return Ok(Model {
            base: here,
            search,
            wandering: first,
        });
    }
    let (count, left) = (search.found.len(), search.left);
    let mut model = settled(base, search.adjusted.suspects, candidates)?;
    if model.search.found.len() == count {
        model.search.left = left;
    }
    Ok(model)
}

fn disturbances(judged: &[Judged]) -> Vec<Disturbance> {
    judged.iter().map(|judged| judged.disturbance).collect()
}

/// What wanders beside causes. Where it would be several single things, it may be one that they have in common: then
/// that is tried first, too, and the better explanation taken.
fn wandering(base: &Base<'_>, suspects: &[Suspect]) -> Result<Vec<Judged>, Error> {
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
        own.retain(|judged| judged.p_value < LEVEL);
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
        let Some(next) = judged.first().filter(|next| next.p_value < LEVEL) else {
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
    use rayon::prelude::*;
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
    let n = columns.len();
    let matrix = gram_matrix(projection, &columns);
    let s: Vec<f64> = columns
        .iter()
        .map(|c| dot(c, &projection.residuals))
        .collect();
    let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    let (squares, dof) = (projection.squares(), projection.degrees_of_freedom);
    let lengths = wanderer.lengths(base);
    let fits = lengths.iter().map(|&length| {
        let roots = wanderer.roots_of_spectrum(base, length);
        let scaled: Vec<f64> = (0..n * n)
            .map(|ij| matrix[ij] * roots[ij / n] * roots[ij % n])
            .collect();
        let before: Vec<f64> = before.iter().zip(&roots).map(|(b, r)| b * r * r).collect();
        let s: Vec<f64> = s.iter().zip(&roots).map(|(s, r)| s * r).collect();
        let gram = Gram::new(&scaled, &before);
        let (variance, ratio) = gram.restricted_likelihood(&s, squares, dof);
        (length, variance, ratio)
    });
    let fits: Vec<(f64, f64, f64)> = fits.collect();
    let &(length, variance, ratio) = fits.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
    if variance <= 0.0 {
        return None;
    }
    let evidences: Vec<(f64, f64)> = fits.iter().map(|fit| (fit.0, fit.2)).collect();
    let of_lengths = marginal_of(&evidences, fits.len()).2;
    let tail = 0.5 * chi_squared_upper_tail(ratio, 1.0).max(f64::MIN_POSITIVE);
    Some(Judged {
        disturbance: Disturbance {
            wanderer,
            length,
            width: variance.sqrt(),
        },
        evidence: of_lengths - 2.0 * (wanderer.of_kind(base) as f64).ln(),
        p_value: (family as f64 * tail).min(1.0),
        rivals: Vec::new(),
    })
}
