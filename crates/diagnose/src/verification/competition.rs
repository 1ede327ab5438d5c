//! Causes and what wanders against each other, as in the lengths.
//!
//! One model finds causes first, then what wanders beside them, then causes again with that in the covariance; another
//! begins with what wanders; a third has nothing else. The one with the most evidence is taken: each further name costs
//! [`DECISIVE`], and what can be anything twice that.

use trueaxis_effects::Shape;

use crate::engine::{Chosen, FURTHER_LEVEL, Listed, beside_one_of, without};
use crate::selection::{DECISIVE, Score, combined, dot};
use crate::verification::believed::{with_gain, without_imitations};
use crate::verification::comparison::COUPLING;
use crate::verification::held_out::{gain, held_out};
use crate::verification::lost_motion::FORMS;
use crate::verification::omnibus::omnibus;
use crate::verification::problem::Problem;
use crate::verification::search::{drop_superfluous, opposed, search, search_from};
use crate::verification::wanderer::Wanderer;
use crate::verification::wandering::{FittedProcess, wandering};

/// Causes, and what wanders beside them.
pub(crate) struct Model<'a> {
    /// The readings, what wanders in their covariance.
    pub(crate) problem: Problem<'a>,
    pub(crate) wandering: Vec<FittedProcess>,
    pub(crate) causes: Vec<Chosen>,
    /// Others that explain all with nearly as much evidence.
    pub(crate) as_good: Vec<Vec<Chosen>>,
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
    // A coupling may imitate squareness and scale together.
    if is_complete
        && of_causes
            .causes
            .iter()
            .any(|cause| is_coupling(plain, cause.candidate))
    {
        let all = 0..plain.listed.candidates.len();
        let couplings: Vec<usize> = all.filter(|&number| is_coupling(plain, number)).collect();
        models.extend(whole(plain, &couplings));
    }
    if !is_complete {
        models.extend(whole(plain, &[]));
        let sets = suspected(plain, &of_causes.causes);
        models.extend(sets.into_iter().filter_map(|causes| beside(plain, causes)));
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
    let models = models.into_iter().map(|model| described(plain, model));
    // What wanders and does not predict is left unexplained.
    let helping = models.filter(|model| helps(plain, model));
    let models = without_rests(std::iter::once(of_causes).chain(helping).collect());
    let scored = models.into_iter();
    let mut scored: Vec<(f64, Model<'a>)> = scored
        .map(|model| (evidence(plain, &model), model))
        .collect();
    // The first of those that are as good.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut scored = scored.into_iter();
    let Some((most, mut best)) = scored.next() else {
        return only(plain, Vec::new());
    };
    if best.wandering.is_empty() {
        let are_as_good = |model: &Model<'_>| {
            let are_others = !have_same(&model.causes, &best.causes);
            model.wandering.is_empty() && are_others && !model.causes.is_empty() && !is_left(model)
        };
        let near = scored.take_while(|(evidence, _)| most - evidence < DECISIVE);
        let as_good = near.filter(|(_, model)| are_as_good(model));
        let as_good: Vec<Vec<Chosen>> = as_good.map(|(_, model)| model.causes).collect();
        best.as_good = as_good;
        let simple = simple_instead(plain, &best, most);
        best.as_good.extend(simple);
    }
    best
}

/// Effects of one parameter, or pairs of them, that explain as much as a coupling in their place, significant or not.
fn simple_instead(plain: &Problem<'_>, best: &Model<'_>, most: f64) -> Vec<Vec<Chosen>> {
    let coupling = |cause: &Chosen| is_coupling(plain, cause.candidate);
    let Some(coupling) = best.causes.iter().position(coupling) else {
        return Vec::new();
    };
    let listed = &plain.listed;
    let others = without(&best.causes, coupling);
    let beside = listed.beside(&others);
    let is_simple = |score: &&Score| {
        let candidate = listed.candidate(&beside, score);
        candidate.plausible.len() == 1 && !candidate.is_of_any_form()
    };
    let simple = beside.scores.iter().filter(is_simple).take(FIRST);
    let simple: Vec<Chosen> = simple.map(|score| listed.chosen(&beside, score)).collect();
    let ones = (0..simple.len()).map(|i| vec![simple[i]]);
    let pairs = (0..simple.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
    let pairs = pairs.map(|pair| pair.map(|i| simple[i]).to_vec());
    let mut as_good: Vec<Vec<Chosen>> = Vec::new();
    for own in ones.chain(pairs) {
        let model = Model {
            causes: [&others[..], &own].concat(),
            ..only(plain, Vec::new())
        };
        let has_more = as_good
            .iter()
            .any(|few| few.iter().all(|one| has(&model.causes, one)));
        if !has_more && most - evidence(plain, &model) < DECISIVE && !is_left(&model) {
            as_good.push(model.causes);
        }
    }
    as_good
}

fn is_coupling(plain: &Problem<'_>, candidate: usize) -> bool {
    plain.listed.candidates[candidate].hypothesis.effect.id == COUPLING
}

/// Sets of causes beside which something may wander.
fn suspected(plain: &Problem<'_>, of_causes: &[Chosen]) -> Vec<Vec<Chosen>> {
    let found = search(&plain.listed, &[], plain.level);
    let mut holding = found.clone();
    without_imitations(plain, &mut holding);
    // A form of one parameter that leaves much of what wanders may be right; others imitate it.
    let may_be_right = |cause: &&Chosen| {
        let candidate = &plain.listed.candidates[cause.candidate];
        let is_simple = candidate.plausible.len() == 1 && !candidate.is_of_any_form();
        is_simple || holding.contains(cause)
    };
    let together: Vec<Chosen> = found.iter().filter(may_be_right).copied().collect();
    // Each by itself: beside another one that is a part of what wanders, lost motion was lost. That is tried in any case.
    let each = found.into_iter().chain(lost_motion(plain));
    let all = [together, of_causes.to_vec()].into_iter();
    let mut sets: Vec<Vec<Chosen>> = Vec::new();
    for causes in all.chain(each.map(|cause| vec![cause])) {
        if !causes.is_empty() && !sets.iter().any(|set| have_same(set, &causes)) {
            sets.push(causes);
        }
    }
    sets
}

/// Lost motion of the measured axis in its forms of one and two parameters.
fn lost_motion(plain: &Problem<'_>) -> Vec<Chosen> {
    let candidates = plain.listed.candidates.iter().enumerate();
    let forms = candidates.filter(|(_, own)| {
        let is_of_axis = own.hypothesis.subject.axis == plain.comparison.line();
        is_of_axis && FORMS.contains(&own.hypothesis.effect.id) && !own.is_free
    });
    let chosen = forms.filter_map(|(candidate, own)| {
        Some(Chosen {
            candidate,
            shape: *own.shapes.first()?,
            u_shape: 0.0,
        })
    });
    chosen.collect()
}

/// First causes that others are looked for beside, at most, and causes that explain all, at most: play of both axes, their
/// squareness, scales and servos are all there on an ordinary circle.
const FIRST: usize = 4;
const MOST_OF_ALL: usize = 5;

/// Several causes, none of them `excluded`, that leave nothing: of a pair that one cause imitates neither is the first, and what is little against the others was
/// taken for their shape.
fn whole<'a>(plain: &Problem<'a>, excluded: &[usize]) -> Vec<Model<'a>> {
    let listed = &plain.listed;
    let beside = listed.beside(&[]);
    let null = beside.null();
    let is_first = |score: &&Score| {
        let candidate = listed.candidate(&beside, score);
        candidate.plausible.len() == 1 && null.family_wise(score.ln_p) < plain.level
    };
    let firsts = beside.scores.iter().filter(is_first).take(FIRST);
    let mut models: Vec<Model<'a>> = Vec::new();
    for first in firsts.map(|score| listed.chosen(&beside, score)) {
        let causes = search_from(listed, first, excluded, (plain.level, MOST_OF_ALL));
        let is_known = models.iter().any(|m| have_same(&m.causes, &causes));
        if causes.len() < 2 || is_known || opposed(listed, &causes) {
            continue;
        }
        let model = Model {
            causes,
            ..only(plain, Vec::new())
        };
        if !is_left(&model) {
            models.push(model);
        }
    }
    models
}

/// Whether what wanders gains on readings that were not used, with a probability of nine in ten; where nothing does, whether each cause
/// does.
fn helps(plain: &Problem<'_>, model: &Model<'_>) -> bool {
    if model.wandering.is_empty() {
        let mut gaining = model.causes.clone();
        with_gain(plain, &mut gaining);
        return gaining.len() == model.causes.len();
    }
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
        as_good: Vec::new(),
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

/// Models without those that leave something where another one with the same causes, or more, leaves nothing.
fn without_rests(models: Vec<Model<'_>>) -> Vec<Model<'_>> {
    let leaves: Vec<bool> = models.iter().map(is_left).collect();
    let is_rest = |k: usize| {
        let mut others = models.iter().zip(&leaves);
        let is_whole = |(other, left): (&Model<'_>, &bool)| {
            !left && models[k].causes.iter().all(|own| has(&other.causes, own))
        };
        leaves[k] && !models[k].causes.is_empty() && others.any(is_whole)
    };
    let rests: Vec<bool> = (0..models.len()).map(is_rest).collect();
    let kept = models.into_iter().zip(rests).filter(|(_, rest)| !rest);
    kept.map(|(model, _)| model).collect()
}

/// Whether a cause is among some, whatever its shape.
fn has(causes: &[Chosen], own: &Chosen) -> bool {
    causes.iter().any(|cause| cause.candidate == own.candidate)
}

/// Whether two models have the same causes.
fn have_same(first: &[Chosen], second: &[Chosen]) -> bool {
    first.len() == second.len() && first.iter().all(|own| has(second, own))
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
    let mut names = 2 * model.wandering.len();
    for (k, cause) in model.causes.iter().enumerate() {
        let beside = listed.beside(&model.causes[..k]);
        let own = |score: &&Score| beside.numbers[score.scan] == cause.candidate;
        let own = beside.scores.iter().find(own);
        sum += own.map_or(0.0, |score| score.evidence);
        names += match own {
            // Each direction is an error of its own.
            Some(score) if is_coupling(plain, cause.candidate) => score.rank,
            _ => 1,
        };
    }
    sum - DECISIVE * names.saturating_sub(1) as f64
}

/// A cause in time is no more than a part of what wanders if this part of what it explains is left to that.
const PART: f64 = 0.1;

/// A wave along an axis whose curve wanders over the position is a rest of that, if it explains less than this part of it, or if it
/// is longer than this part of the correlation length: then the curve may go so by itself.
const REST: f64 = 0.25;
const OWN_COURSE: f64 = 0.75;

/// Squares of what a cause of a model does to the readings, in variances of the noise.
fn squares_of(plain: &Problem<'_>, model: &Model<'_>, k: usize) -> f64 {
    let listed = &model.problem.listed;
    let columns = listed.columns(std::slice::from_ref(&model.causes[k]));
    let sizes = listed.sizes(&model.causes);
    let mut effect = combined(plain.listed.base.rows(), &columns, &sizes[k].fit.estimates);
    plain.listed.base.project(&mut effect);
    dot(&effect, &effect)
}

/// The model without causes that do not describe the course that they give a name.
fn described<'a>(plain: &Problem<'a>, mut model: Model<'a>) -> Model<'a> {
    loop {
        let listed = &model.problem.listed;
        let wanders_on = |k: usize| {
            let hypothesis = listed.hypothesis(&model.causes[k]);
            let explained = || {
                listed.judge(&model.causes, k).map_or(0.0, |judged| {
                    let after = listed.with(&model.causes);
                    judged.score.statistic * after.degrees_of_freedom / after.squares()
                })
            };
            let is_wave = hypothesis.effect.shape == Shape::Period;
            let of_curve = |own: &FittedProcess| {
                let others = model
                    .wandering
                    .iter()
                    .filter(|w| w.wanderer != own.wanderer);
                let others: Vec<FittedProcess> = others.cloned().collect();
                let without = plain.beside(&others).listed.with(&model.causes).squares();
                without - listed.with(&model.causes).squares()
            };
            let is_rest = |own: &FittedProcess| {
                let [first, last] = plain.comparison.range;
                let is_long = plain.comparison.line().is_some()
                    && model.causes[k].shape > OWN_COURSE * own.form.length() * (last - first);
                is_long || squares_of(plain, &model, k) < REST * of_curve(own)
            };
            model.wandering.iter().any(|own| match own.wanderer {
                Wanderer::Position if is_wave => is_rest(own),
                wanderer if wanderer.is_course_of(hypothesis) => own.evidence > PART * explained(),
                _ => false,
            })
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
