//! Causes and disturbances against each other, as with lengths.
//!
//! One model finds causes first, then disturbances beside them, then causes again with these in the covariance;
//! another begins with disturbances; a third has nothing else. The one with the largest 2 ln B is taken: each further
//! name costs [`DECISIVE`], and what can take any course twice that.

use trueaxis_selection::{DECISIVE, Score};

use crate::engine::linear::{Among, Chosen};
use crate::engine::{FURTHER_LEVEL, JudgedDisturbance};
use crate::verification::believed::{with_gain, without_imitations};
use crate::verification::described::described;
use crate::verification::held_out::{gain, held_out};
use crate::verification::instead::simple_instead;
use crate::verification::lost_motion::is_of_line;
use crate::verification::model::{
    Model, has, have_same, is_coupling, is_left, of_causes, only, two_ln_b,
};
use crate::verification::problem::Problem;
use crate::verification::wandering::wandering;

/// Most searches until one holds.
const MOST_TRIES: usize = 3;

/// The model with the largest 2 ln B, if its disturbances help on unused readings; otherwise that of causes alone.
pub(crate) fn compete<'a>(plain: &Problem<'a>) -> Model<'a> {
    let of_causes = of_causes(plain, causes(plain));
    let is_complete = !is_left(&of_causes);
    let alone = match of_causes.causes.is_empty() && is_complete {
        true => Vec::new(),
        false => wandering(plain, &[]),
    };
    let mut models = Vec::new();
    let found = &of_causes.causes;
    if is_complete
        && found
            .iter()
            .any(|cause| is_coupling(plain, cause.candidate))
    {
        // A coupling may imitate squareness and scale together.
        let all = 0..plain.listed.candidates.len();
        let couplings: Vec<usize> = all.filter(|&number| is_coupling(plain, number)).collect();
        models.extend(whole(plain, &couplings));
    } else if is_complete && found.len() > 1 {
        // So may a jump and changing lost motion imitate a drift and constant lost motion: in two cycles exactly.
        models.extend(whole(plain, &[]));
    }
    if !is_complete {
        models.extend(whole(plain, &[]));
        let sets = suspected(plain, &of_causes.causes);
        models.extend(sets.into_iter().filter_map(|causes| beside(plain, causes)));
    }
    // Where causes explain everything, disturbances must do it alone to be better.
    let explains = |m: &Model<'_>| !m.causes.is_empty() && !is_left(m);
    let is_explained = is_complete && !of_causes.causes.is_empty() || models.iter().any(explains);
    if !alone.is_empty() {
        models.push(only(plain, alone.clone()));
        if !is_explained {
            // The second disturbance may have taken what belongs to a cause.
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
    let scored = scored.map(|model| (two_ln_b(plain, &model), model));
    let mut scored: Vec<(f64, Model<'a>)> = scored.collect();
    // Stable: the first of those that are as good.
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut scored = scored.into_iter();
    let Some((most, mut best)) = scored.next() else {
        return only(plain, Vec::new());
    };
    if grows_too_much(plain, most) {
        return only(plain, Vec::new());
    }
    if best.wandering.is_empty() {
        let are_as_good = |model: &Model<'_>| {
            let are_others = !have_same(&model.causes, &best.causes);
            model.wandering.is_empty() && are_others && !model.causes.is_empty() && !is_left(model)
        };
        let near = scored.take_while(|(two_ln_b, _)| most - two_ln_b < DECISIVE);
        let as_good = near.filter(|(_, model)| are_as_good(model));
        let as_good = as_good.map(|(_, model)| model.causes);
        best.as_good = as_good.chain(simple_instead(plain, &best, most)).collect();
    }
    best
}

/// Whether an axis that grows by more than axes do explains more than all that is possible, of this 2 ln B: then nothing
/// possible is named.
fn grows_too_much(plain: &Problem<'_>, most: f64) -> bool {
    let beside = plain.listed.beside(&[]);
    let best = beside.impossible.first();
    best.is_some_and(|best| {
        let effect = plain.listed.candidate(&beside, best).hypothesis.effect;
        effect.grows_axis() && best.two_ln_b > most + DECISIVE
    })
}

/// Sets of causes beside which something may wander.
fn suspected(plain: &Problem<'_>, of_causes: &[Chosen]) -> Vec<Vec<Chosen>> {
    let found = Among::all(&plain.listed, plain.level).after(Vec::new());
    let mut holding = found.clone();
    without_imitations(plain, &mut holding);
    // A form of one parameter that leaves much to disturbances may be right; others imitate it.
    let may_be_right = |cause: &&Chosen| {
        plain.listed.candidates[cause.candidate].is_simple() || holding.contains(cause)
    };
    let together: Vec<Chosen> = found.iter().filter(may_be_right).copied().collect();
    // Each by itself: beside a cause that is a part of what wanders, lost motion was missed. It is always tried.
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
    let forms =
        candidates.filter(|(_, own)| is_of_line(plain.comparison, &own.hypothesis) && !own.is_free);
    let chosen = forms.filter_map(|(candidate, own)| {
        Some(Chosen {
            candidate,
            shape: own.columns.shapes().next()?,
            u_shape: 0.0,
        })
    });
    chosen.collect()
}

/// Most first causes beside which others are sought, and most causes that explain everything: play of both axes,
/// their squareness, scales and servos are all present on an ordinary circle.
const FIRST: usize = 4;
const MOST_OF_ALL: usize = 5;

/// Several causes, none of them `excluded`, that leave nothing: of a pair that one cause imitates neither comes
/// first, and what is small against the others was taken for their shape.
fn whole<'a>(plain: &Problem<'a>, excluded: &[usize]) -> Vec<Model<'a>> {
    let listed = &plain.listed;
    let beside = listed.beside(&[]);
    let is_first = |score: &&Score| {
        let candidate = listed.candidate(&beside, score);
        candidate.plausible.len() == 1 && beside.is_significant(score, plain.level)
    };
    let firsts = beside.scores.iter().filter(is_first).take(FIRST);
    let mut models: Vec<Model<'a>> = Vec::new();
    for first in firsts.map(|score| listed.chosen(&beside, score)) {
        let search = Among {
            excluded,
            most: MOST_OF_ALL,
            is_whole: true,
            ..Among::all(listed, plain.level)
        };
        let causes = search.after(vec![first]);
        let is_known = models.iter().any(|m| have_same(&m.causes, &causes));
        if causes.len() < 2 || is_known {
            continue;
        }
        let model = of_causes(plain, causes);
        if !is_left(&model) {
            models.push(model);
        }
    }
    models
}

/// Whether the disturbances gain on readings that were not used, with a probability of nine in ten; without
/// disturbances, whether each cause does.
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

/// Causes with the disturbances beside them, without those that are not significant there or imitate what is left;
/// `None` if nothing wanders.
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
        // When a cause began and how long it took changes beside disturbances, and the true course never quite follows
        // the process.
        let level = plain.level.min(FURTHER_LEVEL);
        causes = Among::by_name(&model.problem.listed, level).revised(causes);
        without_imitations(&model.problem, &mut causes);
        if causes.len() == found {
            model.causes = causes;
            return Some(model);
        }
    }
}

/// The causes found where something wanders, with the disturbances beside them.
fn with_causes<'a>(plain: &Problem<'a>, first: Vec<JudgedDisturbance>) -> Option<Model<'a>> {
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

/// Causes that hold on unused readings and do not merely imitate structure beside them. What does not hold is
/// excluded and the search repeated.
fn causes(problem: &Problem<'_>) -> Vec<Chosen> {
    let level = problem.level;
    let listed = &problem.listed;
    let mut excluded: Vec<usize> = Vec::new();
    for _ in 0..MOST_TRIES {
        let search = Among {
            excluded: &excluded,
            ..Among::all(listed, level)
        };
        let mut chosen = search.after(Vec::new());
        let first: Vec<usize> = chosen.iter().map(|c| c.candidate).collect();
        // Beside disturbances the neighbours of a reading predict it with a cause and without.
        if !problem.wanders {
            with_gain(problem, &mut chosen);
        }
        let found = chosen.len();
        without_imitations(problem, &mut chosen);
        if chosen.len() < found {
            let search = Among {
                further: level,
                ..Among::by_name(listed, level)
            };
            chosen = search.revised(chosen);
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
