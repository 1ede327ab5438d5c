//! The search for disturbances beside causes, the same for all kinds of data.
//!
//! 1. The disturbance with the largest 2 ln B joins, if noise alone would not look as much like any.
//! 2. Each is judged beside the others; one that is not significant there leaves, and does not come back.
//! 3. The search ends when nothing joins, or when there are as many as can be separated.
//!
//! A disturbance is judged like a cause, by twice the logarithm of the marginal likelihood ratio
//! ([`Smooth`](crate::engine::Smooth)); its p-value is family-wise for all disturbances (Bonferroni).

use rayon::prelude::*;
use trueaxis_selection::{DECISIVE, by_two_ln_b};

use crate::Error;
use crate::engine::disturbance::{Disturbance, Wanderer};
use crate::engine::{SMOOTH_LEVEL, without};

/// A disturbance with its judgement beside the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JudgedDisturbance {
    pub(crate) disturbance: Disturbance,
    pub(crate) two_ln_b: f64,
    pub(crate) p_value: f64,
    /// Other wanderers that explain as much.
    pub(crate) rivals: Vec<Wanderer>,
}

impl JudgedDisturbance {
    pub(crate) fn wanderer(&self) -> Wanderer {
        self.disturbance.wanderer
    }
}

/// What differs between kinds of data, beside given causes. The table in [`crate::engine`] has the reasons.
pub(crate) trait Wandering: Sync {
    /// The data with the causes, and disturbances in their covariance.
    type Model: Sync;

    /// Most disturbances at once; more cannot be separated.
    const MOST: usize;

    /// All wanderers that the data may show beside the causes.
    fn wanderers(&self) -> &[Wanderer];

    /// The model with disturbances, in the noise of another one or its own.
    fn fit(
        &self,
        own: &[JudgedDisturbance],
        near: Option<&Self::Model>,
    ) -> Result<Self::Model, Error>;

    /// A disturbance in what a model leaves; `None` if the data do not show it.
    fn judge(&self, model: &Self::Model, wanderer: Wanderer) -> Option<JudgedDisturbance>;

    /// What has the same columns under another name.
    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer>;

    /// What a disturbance would hide in a model.
    fn hidden(&self, _model: &Self::Model, _own: &JudgedDisturbance) -> Option<Wanderer> {
        None
    }
}

/// The disturbances that are found one after the other.
pub(crate) fn sought<W: Wandering>(data: &W) -> Result<Vec<JudgedDisturbance>, Error> {
    sought_from(data, &one_by_one(data)?)
}

/// The same from those that were judged [`one_by_one`].
pub(crate) fn sought_from<W: Wandering>(
    data: &W,
    (model, judged): &(W::Model, Vec<JudgedDisturbance>),
) -> Result<Vec<JudgedDisturbance>, Error> {
    let mut own: Vec<JudgedDisturbance> = Vec::new();
    // Otherwise one that is not significant beside the others would come back for ever.
    let mut dropped: Vec<Wanderer> = Vec::new();
    let mut next = leader(data, model, judged);
    while let Some(joining) = next {
        own.push(joining);
        let (model, gone) = revise(data, &mut own)?;
        dropped.extend(gone);
        if own.len() == W::MOST {
            break;
        }
        let is_new = |w: &Wanderer| !dropped.contains(w) && own.iter().all(|o| o.wanderer() != *w);
        let others = data.wanderers().iter().copied().filter(is_new);
        let judged = judge_all(data, &model, &others.collect::<Vec<_>>());
        next = leader(data, &model, &judged);
    }
    Ok(own)
}

/// Judges each disturbance beside the others; those that are not significant there leave. Returns the model with those
/// that stay, and those that left.
fn revise<W: Wandering>(
    data: &W,
    own: &mut Vec<JudgedDisturbance>,
) -> Result<(W::Model, Vec<Wanderer>), Error> {
    let model = data.fit(own, None)?;
    let mut moved = false;
    for k in 0..own.len() {
        let without = data.fit(&without(own, k), Some(&model))?;
        match data.judge(&without, own[k].wanderer()) {
            Some(again) => {
                moved |= again.disturbance.has_moved(&own[k].disturbance);
                let rivals = std::mem::take(&mut own[k].rivals);
                own[k] = JudgedDisturbance { rivals, ..again };
            }
            None => own[k].p_value = 1.0,
        }
    }
    let is_gone = |judged: &mut JudgedDisturbance| judged.p_value >= SMOOTH_LEVEL;
    let gone: Vec<_> = own.extract_if(.., is_gone).map(|o| o.wanderer()).collect();
    let model = match moved || !gone.is_empty() {
        true => data.fit(own, None)?,
        false => model,
    };
    Ok((model, gone))
}

/// Each disturbance as if it were the only one, the one with the largest 2 ln B first.
pub(crate) fn one_by_one<W: Wandering>(
    data: &W,
) -> Result<(W::Model, Vec<JudgedDisturbance>), Error> {
    let model = data.fit(&[], None)?;
    let judged = judge_all(data, &model, data.wanderers());
    Ok((model, judged))
}

/// Disturbances in what a model leaves, the one with the largest 2 ln B first.
pub(crate) fn judge_all<W: Wandering>(
    data: &W,
    model: &W::Model,
    wanderers: &[Wanderer],
) -> Vec<JudgedDisturbance> {
    let judged = wanderers.par_iter();
    let judged = judged.filter_map(|&wanderer| data.judge(model, wanderer));
    by_two_ln_b(judged.collect(), |one: &JudgedDisturbance| one.two_ln_b)
}

/// The first of those judged in what a model leaves, with what is confounded with it, the others that explain as much, and what it hides
/// as rivals; `None` if noise explains it.
fn leader<W: Wandering>(
    data: &W,
    model: &W::Model,
    judged: &[JudgedDisturbance],
) -> Option<JudgedDisturbance> {
    let (first, others) = judged.split_first()?;
    if first.p_value >= SMOOTH_LEVEL {
        return None;
    }
    let is_rival = |other: &&JudgedDisturbance| first.two_ln_b - other.two_ln_b < DECISIVE;
    let rivals = others.iter().filter(is_rival);
    let rivals = rivals.flat_map(|other| names(data, other.wanderer()));
    let own = names(data, first.wanderer());
    let mut named: Vec<Wanderer> = Vec::new();
    for name in own.chain(rivals).chain(data.hidden(model, first)) {
        if !named.contains(&name) {
            named.push(name);
        }
    }
    Some(JudgedDisturbance {
        rivals: named.split_off(1),
        ..first.clone()
    })
}

/// What explains more than a cause, of this 2 ln B, in a model without it, with the 2 ln B. A rival may have
/// [`DECISIVE`] less than a cause, but a disturbance costs as much more.
pub(crate) fn instead_of_cause<W: Wandering>(
    data: &W,
    without: &W::Model,
    wanderers: &[Wanderer],
    two_ln_b: f64,
) -> Vec<(Wanderer, f64)> {
    let judged = judge_all(data, without, wanderers).into_iter();
    let more = judged.filter(|own| own.two_ln_b > two_ln_b);
    let names = more.flat_map(|own| names(data, own.wanderer()).map(move |w| (w, own.two_ln_b)));
    names.collect()
}

/// A wanderer, and what has the same columns under another name.
fn names<W: Wandering>(data: &W, wanderer: Wanderer) -> impl Iterator<Item = Wanderer> {
    std::iter::once(wanderer).chain(data.confounded(wanderer))
}
