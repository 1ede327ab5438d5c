//! Causes and what wanders against each other, as in the lengths.
//!
//! One model finds causes first, then what wanders beside them, then causes again with that in the covariance; another
//! begins with what wanders; a third has nothing else. The one with the most evidence is taken: each further name costs
//! [`DECISIVE`], and what can be anything twice that.

use crate::engine::{Chosen, FURTHER_LEVEL, Listed, beside_one_of};
use crate::selection::{DECISIVE, Score};
use crate::verification::believed::{with_gain, without_imitations};
use crate::verification::held_out::{gain, held_out};
use crate::verification::omnibus::omnibus;
use crate::verification::problem::Problem;
use crate::verification::search::{drop_superfluous, search};
use crate::verification::wandering::{FittedProcess, wandering};

/// Causes, and what wanders beside them.
pub(crate) struct Model<'a> {
    /// The readings, what wanders in their covariance.
    pub(crate) problem: Problem<'a>,
    pub(crate) wandering: Vec<FittedProcess>,
    pub(crate) causes: Vec<Chosen>,
}

/// Searches until one holds, at most.
const MOST_TRIES: usize = 3;

/// The model with the most evidence, if what wanders in it helps on readings that were not used; else that of causes alone.
pub(crate) fn compete<'a>(plain: &Problem<'a>) -> Model<'a> {
    let of_causes = Model {
        causes: causes(plain),
        ..only(plain, Vec::new())
    };
    let is_complete = !is_left(&of_causes);
    let alone = match of_causes.causes.is_empty() && is_complete {
        true => Vec::new(),
        false => wandering(plain, &[]),
    };
    let mut models = Vec::new();
    if !is_complete {
        // A form of one parameter that leaves much of what wanders may be right; others imitate it.
        let mut suspects = search(&plain.listed, &[], plain.level);
        let mut holding = suspects.clone();
        without_imitations(plain, &mut holding);
        suspects.retain(|cause| {
            let candidate = &plain.listed.candidates[cause.candidate];
            let is_simple = candidate.plausible.len() == 1 && !candidate.is_of_any_form();
            is_simple || holding.contains(cause)
        });
        models.extend(beside(plain, suspects));
        if models
            .iter()
            .all(|m| !have_same(&m.causes, &of_causes.causes))
        {
            models.extend(beside(plain, of_causes.causes.clone()));
        }
    }
    // Where causes explain all, what wanders must do it alone to be better.
    let explains = |m: &Model<'_>| !m.causes.is_empty() && !is_left(m);
    let is_explained = is_complete && !of_causes.causes.is_empty() || models.iter().any(explains);
    if !alone.is_empty() {
        models.push(only(plain, alone.clone()));
        if !is_explained {
            // A cause may be what the second one has taken.
            if let [first, _, ..] = alone.as_slice() {
                models.extend(with_causes(plain, vec![first.clone()]));
            }
            models.extend(with_causes(plain, alone));
        }
    }
    // The first of those that are as good.
    let mut most = evidence(plain, &of_causes);
    let mut best = None;
    for model in models {
        let model = described(plain, model);
        let evidence = evidence(plain, &model);
        if evidence > most {
            (most, best) = (evidence, Some(model));
        }
    }
    // What wanders and does not predict is left unexplained.
    best.filter(|model| helps(plain, model))
        .unwrap_or(of_causes)
}

/// Whether what wanders gains on readings that were not used, with a probability of nine in ten.
fn helps(plain: &Problem<'_>, model: &Model<'_>) -> bool {
    let without = held_out(plain, &model.causes);
    let with = held_out(&model.problem, &model.causes);
    // What cannot be held out cannot be refuted.
    gain(plain, &without, &with).is_none_or(|gain| gain.upper_bound < 1.0)
}

/// Only what wanders.
pub(crate) fn only<'a>(plain: &Problem<'a>, wandering: Vec<FittedProcess>) -> Model<'a> {
    Model {
        problem: plain.beside(&wandering),
        wandering,
        causes: Vec::new(),
    }
}

/// Causes with what wanders beside them, without those that are not significant there or imitate what is left; none if
/// nothing wanders.
fn beside<'a>(plain: &Problem<'a>, mut causes: Vec<Chosen>) -> Option<Model<'a>> {
    loop {
        let found = causes.len();
        if found == 0 {
            return None;
        }
        let mut model = only(plain, wandering(plain, &causes));
        if model.wandering.is_empty() {
            return None;
        }
        // The true course is never quite the process.
        let level = plain.level.min(FURTHER_LEVEL);
        drop_superfluous(&model.problem.listed, &mut causes, level);
        without_imitations(&model.problem, &mut causes);
        if causes.len() == found {
            model.causes = causes;
            return Some(model);
        }
    }
}

/// The causes that are found where something wanders, with what wanders beside them.
fn with_causes<'a>(plain: &Problem<'a>, first: Vec<FittedProcess>) -> Option<Model<'a>> {
    let found = causes(&plain.beside(&first));
    beside(plain, found)
}

/// Whether two models have the same causes.
fn have_same(first: &[Chosen], second: &[Chosen]) -> bool {
    let numbers = |causes: &[Chosen]| causes.iter().map(|c| c.candidate).collect::<Vec<_>>();
    numbers(first) == numbers(second)
}

/// Whether a test finds anything that the model leaves.
fn is_left(model: &Model<'_>) -> bool {
    let projection = model.problem.listed.with(&model.causes);
    let tests = omnibus(&model.problem, &projection);
    tests.iter().any(|t| t.test.p_value < model.problem.level)
}

/// Causes that hold on unused readings, structure beside them that they do not merely imitate. What does not hold
/// gives its place to the next.
fn causes(problem: &Problem<'_>) -> Vec<Chosen> {
    let level = problem.level;
    let listed = &problem.listed;
    let mut excluded: Vec<usize> = Vec::new();
    for _ in 0..MOST_TRIES {
        let mut chosen = search(listed, &excluded, level);
        let first: Vec<usize> = chosen.iter().map(|c| c.candidate).collect();
        // Beside what wanders the neighbours of a reading predict it with a cause and without.
        if !problem.wanders {
            with_gain(problem, &mut chosen);
        }
        let found = chosen.len();
        without_imitations(problem, &mut chosen);
        if chosen.len() < found {
            drop_superfluous(listed, &mut chosen, level);
        }
        if !chosen.is_empty() || first.is_empty() {
            return chosen;
        }
        let of_time = |&number: &usize| listed.candidates[number].hypothesis.is_of_time();
        if first.iter().any(of_time) {
            excluded.extend((0..listed.candidates.len()).filter(of_time));
        }
        excluded.extend(first);
    }
    Vec::new()
}

/// Twice the logarithm of the marginal likelihood ratio against the model without anything, less what names cost.
fn evidence(plain: &Problem<'_>, model: &Model<'_>) -> f64 {
    let mut sum = 0.0;
    let mut projection = plain.listed.base.clone();
    for own in &model.wandering {
        let (evidence, next) = beside_one_of(&projection, &own.columns(plain), own.tried(plain));
        sum += evidence;
        projection = next;
    }
    let listed = Listed {
        base: projection,
        candidates: plain.listed.candidates.clone(),
    };
    for (k, cause) in model.causes.iter().enumerate() {
        let beside = listed.beside(&model.causes[..k]);
        let own = |score: &&Score| beside.numbers[score.scan] == cause.candidate;
        sum += beside.scores.iter().find(own).map_or(0.0, |s| s.evidence);
    }
    let names = model.causes.len() + 2 * model.wandering.len();
    sum - DECISIVE * names.saturating_sub(1) as f64
}

/// A cause in time is no more than a part of what wanders if this part of what it explains is left to that.
const PART: f64 = 0.1;

/// The model without causes that do not describe the course that they give a name.
fn described<'a>(plain: &Problem<'a>, mut model: Model<'a>) -> Model<'a> {
    loop {
        let listed = &model.problem.listed;
        let wanders_on = |k: usize| {
            let hypothesis = listed.hypothesis(&model.causes[k]);
            let mut wandering = model.wandering.iter();
            let Some(own) = wandering.find(|own| own.wanderer.is_course_of(hypothesis)) else {
                return false;
            };
            let explained = listed.judge(&model.causes, k).map_or(0.0, |judged| {
                let after = listed.with(&model.causes);
                judged.score.statistic * after.degrees_of_freedom / after.squares()
            });
            own.evidence > PART * explained
        };
        let Some(undescribed) = (0..model.causes.len()).find(|&k| wanders_on(k)) else {
            return model;
        };
        let mut others = model.causes.clone();
        others.remove(undescribed);
        model = only(plain, wandering(plain, &others));
        model.causes = others;
        drop_superfluous(&model.problem.listed, &mut model.causes, plain.level);
    }
}
