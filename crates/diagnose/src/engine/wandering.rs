//! Disturbances beside causes.
//!
//! A [`Disturbance`] is judged like a cause, by twice the logarithm of the marginal likelihood ratio ([`Smooth`]),
//! flat over subjects; its p-value is family-wise for all disturbances (Bonferroni).

use rayon::prelude::*;
use trueaxis_effects::Displaced;
use trueaxis_leastsquares::dot;
use trueaxis_selection::{DECISIVE, Projection, by_evidence};

use crate::Error;
use crate::engine::coordinate::Coordinate;
use crate::engine::disturbance::{Disturbance, Wanderer, With};
use crate::engine::smooth::{SMOOTH_LEVEL, Smooth, beside_one_of};
use crate::engine::{Suspect, Wanders};

/// Displacement by a unit of each coordinate, rms over the readings concerned, µm; the motions of a stage count as
/// the same at all positions of the axis. Lost motion is twice its displacement.
pub(crate) fn units_um<D: Wanders>(data: &D, model: &D::Model, wanderer: Wanderer) -> Vec<f64> {
    let coordinates = wanderer.coordinates(data.scene()).into_iter();
    let coordinates: Vec<Coordinate> = coordinates.map(Coordinate::without_law).collect();
    let moved = data.moved(model, &coordinates, &wanderer.subject());
    let times = match wanderer.with {
        With::Sides | With::SidesInTime => 2.0,
        _ => 1.0,
    };
    let unit_um = |c: usize| {
        let squares = moved.iter().map(|moved: &Vec<Displaced>| {
            let Displaced {
                point_mm,
                station_mm,
                length_mm,
            } = moved[c];
            (point_mm - station_mm).norm_squared() + length_mm.powi(2)
        });
        let seen = squares.filter(|square| *square > 0.0);
        let (sum, count) = seen.fold((0.0, 0_usize), |(sum, n), square| (sum + square, n + 1));
        times * 1e3 * (sum / count.max(1) as f64).sqrt()
    };
    (0..coordinates.len()).map(unit_um).collect()
}

/// Whitens columns.
fn whitened<D: Wanders>(data: &D, model: &D::Model, mut columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let each = columns.par_iter_mut();
    each.for_each(|column| data.whiten(model, column));
    columns
}

/// Whitened columns of a disturbance, scaled to coefficients of unit prior variance.
pub(crate) fn whitened_columns<D: Wanders>(
    data: &D,
    model: &D::Model,
    own: &Disturbance,
) -> Vec<Vec<f64>> {
    let columns = data.columns_mm(model, own.wanderer);
    let columns = own.scaled(data.scene(), &data.here(), columns);
    whitened(data, model, columns)
}

/// The effect of disturbances on each row, or on those of `elsewhere`, as far as the data show it, mm.
pub(crate) fn wandered_mm<D: Wanders>(
    data: &D,
    model: &D::Model,
    elsewhere: Option<&D>,
) -> Vec<f64> {
    let at = elsewhere.unwrap_or(data);
    let all = at.here();
    let mut sum_mm = vec![0.0; D::ROWS * all.len()];
    for own in data.disturbances() {
        let there = own.scaled(at.scene(), &all, at.columns_mm(model, own.wanderer));
        let whitened = match elsewhere {
            None => whitened(data, model, there.clone()),
            Some(_) => whitened_columns(data, model, own),
        };
        for (own, there) in whitened.iter().zip(&there) {
            let coefficient = dot(own, &D::projection(model).residuals);
            for (sum, x) in sum_mm.iter_mut().zip(there) {
                *sum += coefficient * x;
            }
        }
    }
    sum_mm
}

/// Most disturbances at once; more cannot be separated.
const MOST: usize = 3;

/// Nothing wanders farther, µm (standard deviation): names were exchanged, or coordinates mistyped.
const FARTHEST_UM: f64 = 5e3;

/// A size is settled if it changes by less than this share of itself: the rest of the data hardly depends on it.
const RESTS: f64 = 0.1;

/// A lost motion that is a cause may change with time or position: only these are tested, since it is known to be there.
const WAYS_TO_CHANGE: f64 = 2.0;

/// A disturbance with its judgement beside the others.
#[derive(Debug, Clone)]
pub(crate) struct JudgedDisturbance {
    pub(crate) disturbance: Disturbance,
    pub(crate) evidence: f64,
    pub(crate) p_value: f64,
    /// Other wanderers that explain as much.
    pub(crate) rivals: Vec<Wanderer>,
}

/// The disturbances beside causes.
pub(crate) fn wandering<D: Wanders>(
    base: &D,
    suspects: &[Suspect],
) -> Result<Vec<JudgedDisturbance>, Error> {
    wandering_of(base, suspects, &one_by_one(base, suspects)?)
}

/// Each disturbance beside causes as if it were the only one, the one with the most evidence first.
pub(crate) fn one_by_one<D: Wanders>(
    base: &D,
    suspects: &[Suspect],
) -> Result<Vec<JudgedDisturbance>, Error> {
    let all = base.wanderers();
    let adjusted = base.adjust(suspects.to_vec(), None)?;
    Ok(judge_all(base, &adjusted, &all, all.len()))
}

/// The disturbances beside causes, from those judged [`one_by_one`]. Instead of several separate ones there may be
/// one that all data share: then this is also tried first, and the better explanation is taken.
pub(crate) fn wandering_of<D: Wanders>(
    base: &D,
    suspects: &[Suspect],
    judged: &[JudgedDisturbance],
) -> Result<Vec<JudgedDisturbance>, Error> {
    let Some(leader) = leader(base, judged) else {
        return Ok(Vec::new());
    };
    let (first, noise) = joined_by_others(base, suspects, leader)?;
    let is_common = |judged: &JudgedDisturbance| is_common(base, judged);
    let who = |judged: &JudgedDisturbance| judged.disturbance.wanderer.who;
    let are_several = first.iter().any(|one| who(one) != who(&first[0]));
    if !are_several || first.iter().any(is_common) {
        return Ok(first);
    }
    let mut ways = vec![(first, noise)];
    for common in judged.iter().filter(|judged| is_tried(base, judged)) {
        let common = with_rivals(base, common, &[]);
        let way = joined_by_others(base, suspects, common)?;
        // If the others made it superfluous, the result is that of the first attempt.
        if way.0.iter().any(is_common) {
            ways.push(way);
        }
    }
    let noises = ways.iter().map(|(_, noise)| *noise);
    let plain = base.adjust(suspects.to_vec(), least::<D>(noises))?;
    let scored = ways.into_iter().map(|(judged, _)| {
        let price = 2.0 * DECISIVE * judged.len() as f64;
        (of_wandering(base, &plain, &judged).0 - price, judged)
    });
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(best.map(|best| best.1).unwrap_or_default())
}

/// Whether it concerns all data.
fn is_common<D: Wanders>(base: &D, judged: &JudgedDisturbance) -> bool {
    judged.disturbance.wanderer.of_kind(base.scene()) == 1
}

/// Whether it may come first although another one has more evidence.
pub(crate) fn is_tried<D: Wanders>(base: &D, judged: &JudgedDisturbance) -> bool {
    is_common(base, judged) && judged.p_value < SMOOTH_LEVEL
}

/// The first of judged disturbances, with those that explain as much; `None` if the data do not show it.
fn leader<D: Wanders>(base: &D, judged: &[JudgedDisturbance]) -> Option<JudgedDisturbance> {
    let (first, others) = judged.split_first()?;
    if first.p_value >= SMOOTH_LEVEL {
        return None;
    }
    Some(with_rivals(base, first, others))
}

/// A disturbance with its twin and the others that explain as much as rivals.
fn with_rivals<D: Wanders>(
    base: &D,
    own: &JudgedDisturbance,
    others: &[JudgedDisturbance],
) -> JudgedDisturbance {
    let is_rival = |other: &&JudgedDisturbance| own.evidence - other.evidence < DECISIVE;
    let rivals = others.iter().filter(is_rival);
    let rivals = rivals.map(|other| other.disturbance.wanderer);
    let twin = base.twin(own.disturbance.wanderer);
    JudgedDisturbance {
        rivals: twin.into_iter().chain(rivals).collect(),
        ..own.clone()
    }
}

/// A disturbance and further ones beside it and the causes, one after the other, each with its size beside the
/// others; and the noise with all of them.
fn joined_by_others<D: Wanders>(
    base: &D,
    suspects: &[Suspect],
    first: JudgedDisturbance,
) -> Result<(Vec<JudgedDisturbance>, D::Noise), Error> {
    let all = base.wanderers();
    let mut own = vec![first];
    // Otherwise one that is not significant beside the others would come back for ever.
    let mut dropped: Vec<Wanderer> = Vec::new();
    loop {
        let here = base.beside(disturbances(&own));
        let mut adjusted = here.adjust(suspects.to_vec(), None)?;
        let mut moved = false;
        for k in 0..own.len() {
            let mut others = disturbances(&own);
            let before = others.remove(k);
            let without = base
                .beside(others)
                .adjust(suspects.to_vec(), Some(D::noise(&adjusted)))?;
            if let Some(again) = judge(base, &without, before.wanderer, all.len()) {
                let now = &again.disturbance;
                moved |= (now.width - before.width).abs() > RESTS * before.width
                    || now.spectrum != before.spectrum;
                let rivals = std::mem::take(&mut own[k].rivals);
                own[k] = JudgedDisturbance { rivals, ..again };
            }
        }
        let is_left = |judged: &JudgedDisturbance| judged.p_value < SMOOTH_LEVEL;
        let (kept, gone): (Vec<_>, Vec<_>) = own.into_iter().partition(is_left);
        own = kept;
        if own.len() == MOST {
            return Ok((own, D::noise(&adjusted)));
        }
        moved |= !gone.is_empty();
        dropped.extend(gone.iter().map(|judged| judged.disturbance.wanderer));
        if moved {
            let here = base.beside(disturbances(&own));
            adjusted = here.adjust(suspects.to_vec(), None)?;
        }
        let is_new =
            |w: &Wanderer| !dropped.contains(w) && own.iter().all(|o| o.disturbance.wanderer != *w);
        let others: Vec<Wanderer> = all.iter().copied().filter(is_new).collect();
        let judged = judge_all(base, &adjusted, &others, all.len());
        match leader(base, &judged) {
            Some(next) => own.push(next),
            None => return Ok((own, D::noise(&adjusted))),
        }
    }
}

/// Disturbances in what an adjusted model leaves, the one with the most evidence first.
pub(crate) fn judge_all<D: Wanders>(
    base: &D,
    adjusted: &D::Model,
    wanderers: &[Wanderer],
    family: usize,
) -> Vec<JudgedDisturbance> {
    let judged = wanderers.par_iter();
    let judged = judged.filter_map(|&wanderer| judge(base, adjusted, wanderer, family));
    by_evidence(judged.collect(), |one: &JudgedDisturbance| one.evidence)
}

/// A disturbance in what an adjusted model leaves; `None` if the data do not show it, or it would be larger than anything that wanders.
fn judge<D: Wanders>(
    base: &D,
    adjusted: &D::Model,
    wanderer: Wanderer,
    family: usize,
) -> Option<JudgedDisturbance> {
    let columns = whitened(base, adjusted, base.columns_mm(adjusted, wanderer));
    let all = base.here();
    let spectra = wanderer.spectra(base.scene(), base.stops(wanderer.with));
    let roots = spectra
        .iter()
        .map(|&spectrum| wanderer.roots_of_spectrum(base.scene(), &all, spectrum));
    let roots: Vec<Vec<f64>> = roots.collect();
    let smooth = Smooth::new(D::projection(adjusted), &columns, &roots)?;
    let is_too_large = |unit_um: &f64| smooth.width * unit_um > FARTHEST_UM;
    if smooth.p_value < SMOOTH_LEVEL && units_um(base, adjusted, wanderer).iter().any(is_too_large)
    {
        return None;
    }
    let mut causes = D::suspects(adjusted).iter();
    let tests = match causes.any(|cause| wanderer.changes(&cause.hypothesis)) {
        true => WAYS_TO_CHANGE,
        false => family as f64,
    };
    Some(JudgedDisturbance {
        disturbance: Disturbance {
            wanderer,
            spectrum: spectra[smooth.spectrum],
            width: smooth.width,
        },
        evidence: smooth.evidence - 2.0 * (wanderer.of_kind(base.scene()) as f64).ln(),
        p_value: (tests * smooth.p_value).min(1.0),
        rivals: Vec::new(),
    })
}

/// Twice the logarithm of the marginal likelihood ratio of disturbances against a model without them, and the projection with them.
pub(crate) fn of_wandering<D: Wanders>(
    base: &D,
    plain: &D::Model,
    wandering: &[JudgedDisturbance],
) -> (f64, Projection) {
    let mut projection = D::projection(plain).clone();
    let mut sum = 0.0;
    for judged in wandering {
        let own = &judged.disturbance;
        let columns = whitened_columns(base, plain, own);
        let spectra = own
            .wanderer
            .spectra(base.scene(), base.stops(own.wanderer.with))
            .len();
        let tried = spectra * own.wanderer.of_kind(base.scene());
        let (evidence, next) = beside_one_of(&projection, &columns, tried);
        sum += evidence;
        projection = next;
    }
    (sum, projection)
}

/// The noise with the least variance.
pub(crate) fn least<D: Wanders>(noises: impl Iterator<Item = D::Noise>) -> Option<D::Noise> {
    noises.min_by(|a, b| D::variance(a).total_cmp(&D::variance(b)))
}

pub(crate) fn disturbances(wandering: &[JudgedDisturbance]) -> Vec<Disturbance> {
    wandering.iter().map(|judged| judged.disturbance).collect()
}
