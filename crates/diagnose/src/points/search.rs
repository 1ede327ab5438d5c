//! One cause after the other, each judged beside the others with the noise that is left.

use trueaxis_effects::{ResolvedEffect, Shape};

use crate::points::base::Base;
use crate::points::hypotheses::scans;
use crate::points::model::Model;
use crate::selection::{
    Fit, Hypothesis, Null, Projection, Score, cosine, golden_section, is_rival, rank, weakest,
};

/// Family-wise level of the causes. With that of the omnibus tests, and since [`Null`] takes scans over instants for
/// rarer than they are by a factor of about two, one of 150 clean campaigns alarms.
const CAUSE_LEVEL: f64 = 0.002;

/// More causes at once are a pile of names, not a diagnosis.
const MOST_CAUSES: usize = 4;

/// Exchanges of causes for better ones before it is enough.
const MOST_EXCHANGES: usize = 6;

/// Explanations of a machine and of a frame that are more alike than this are twins.
const ALIKE: f64 = 0.95;

/// Rivals that are worth a line.
const MOST_RIVALS: usize = 8;

/// An effect on a subject at a shape.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Suspect {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) shape: f64,
    /// Standard deviation of the shape over its marginal likelihood.
    pub(crate) u_shape: f64,
}

/// A cause with its judgement beside the others.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) suspect: Suspect,
    pub(crate) p_value: f64,
    /// Drop of the BIC by this cause.
    pub(crate) bic: f64,
    /// Drop of the sum of squares by this cause.
    pub(crate) statistic: f64,
    /// What explains as much, with its parameters there and its BIC.
    pub(crate) rivals: Vec<(ResolvedEffect, f64)>,
}

/// The causes and the model with them.
pub(crate) struct Search {
    pub(crate) found: Vec<Found>,
    pub(crate) model: Model,
}

/// The columns of suspects one after the other, mm.
pub(crate) fn columns_mm(base: &Base<'_>, suspects: &[Suspect]) -> Vec<Vec<f64>> {
    let of = |suspect: &Suspect| base.columns_mm(&suspect.hypothesis, suspect.shape);
    suspects.iter().flat_map(of).collect()
}

/// Finds the causes of what `plain`, the model without any, leaves.
pub(crate) fn find_causes(base: &Base<'_>, plain: Model, all: &[Hypothesis]) -> Search {
    let first = scans(base, &plain, &plain.projection, all);
    let null = Null::simulated(&plain.projection, &first);
    drop(first);
    let mut search = Search {
        found: Vec::new(),
        model: plain,
    };
    while search.found.len() < MOST_CAUSES {
        let mut suspects: Vec<Suspect> = search.found.iter().map(|f| f.suspect).collect();
        let free = without(all, &suspects);
        let Some(next) = judged(base, &search.model, None, &free, &null) else {
            break;
        };
        suspects.push(next.suspect);
        let (found, model) = settle(base, suspects, all, &null);
        if found.len() <= search.found.len() || !are_their_own(&found) {
            break;
        }
        search = Search { found, model };
    }
    search
}

/// Whether the weakest of several causes is one of its own, and no two the same trouble under two names.
fn are_their_own(found: &[Found]) -> bool {
    if found.len() < 2 {
        return true;
    }
    let pairs = || (1..found.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let is_stacked = pairs().any(|(i, j)| overlap(&found[i], &found[j]));
    let (_, is_doubtful) = weakest(found.iter().map(|f| (f.statistic, f.p_value)));
    !is_stacked && !is_doubtful
}

/// What a cause makes responsible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Culprit {
    /// The machine as a whole, or the frame: one course in time.
    Whole,
    Target(usize),
    Axis(usize, &'static str),
    Everything(&'static str),
}

/// Whether two causes have an explanation in common: several jumps of one frame are a frame that sways.
fn overlap(a: &Found, b: &Found) -> bool {
    let culprits = |found: &Found| -> Vec<Culprit> {
        let hypothesis = &found.suspect.hypothesis;
        let rivals = found.rivals.iter();
        let rivals = rivals.map(|(rival, _)| culprit(rival.effect.id, rival.subject));
        rivals
            .chain([culprit(hypothesis.effect.id, hypothesis.subject)])
            .collect()
    };
    let others = culprits(b);
    culprits(a).iter().any(|culprit| others.contains(culprit))
}

fn culprit(id: &'static str, subject: trueaxis_effects::Subject) -> Culprit {
    match (subject.axis, subject.target) {
        (Some(axis), _) => Culprit::Axis(axis, id),
        (None, Some(target)) => Culprit::Target(target),
        _ if is_of_machine(id) || is_of_frame(id) => Culprit::Whole,
        _ => Culprit::Everything(id),
    }
}

/// Whether an effect moves all that the machine carries alike.
fn is_of_machine(id: &str) -> bool {
    ["machine_drift", "warm_up", "machine_shift"].contains(&id)
}

fn is_of_frame(id: &str) -> bool {
    ["station_drift", "station_settling", "station_jump"].contains(&id)
}

impl Suspect {
    /// Whether it is one course in time of all points, or of all of one target, alike: what wanders looks like one.
    pub(crate) fn is_of_time(&self) -> bool {
        let id = self.hypothesis.effect.id;
        let of_target = ["target_slip", "target_creep", "fixture_expansion"];
        is_of_machine(id) || is_of_frame(id) || of_target.contains(&id)
    }
}

/// All hypotheses but those of the suspects: no effect happens twice to one subject.
fn without(all: &[Hypothesis], suspects: &[Suspect]) -> Vec<Hypothesis> {
    let is_free = |h: &&Hypothesis| suspects.iter().all(|s| !s.hypothesis.is(h));
    all.iter().filter(is_free).copied().collect()
}

/// Judges each cause with the others in the model until none changes any more.
fn settle(
    base: &Base<'_>,
    mut suspects: Vec<Suspect>,
    all: &[Hypothesis],
    null: &Null,
) -> (Vec<Found>, Model) {
    let mut exchanges = 0;
    loop {
        let model = Model::estimated(base, &columns_mm(base, &suspects));
        let mut found = Vec::new();
        let mut has_changed = false;
        for k in 0..suspects.len() {
            let mut others = suspects.clone();
            let own = others.remove(k);
            // With the noise that is left: a large disturbance blurs its own rivals.
            let beside = Model::with(base, &columns_mm(base, &others), model.noise, None);
            let free = without(all, &others);
            let Some(judged) = judged(base, &beside, Some(&own), &free, null) else {
                suspects.remove(k);
                has_changed = true;
                break;
            };
            let new = judged.suspect;
            let is_same = new.hypothesis.is(&own.hypothesis);
            let moved = (new.shape - own.shape).abs();
            if !is_same || moved > new.u_shape.max(REFINED * own.shape.abs()) {
                has_changed |= exchanges < MOST_EXCHANGES;
                exchanges += 1;
            }
            suspects[k] = new;
            found.push(judged);
        }
        if !has_changed {
            let model = Model::estimated(base, &columns_mm(base, &suspects));
            return (found, model);
        }
    }
}

/// Evidence that differs by less is rounding.
const EQUAL: f64 = 1e-3;

/// The best explanation of what a model leaves, `own` if it is as good, and its rivals; `None` if noise explains it.
fn judged(
    base: &Base<'_>,
    model: &Model,
    own: Option<&Suspect>,
    free: &[Hypothesis],
    null: &Null,
) -> Option<Found> {
    let projection = &model.projection;
    let scans = scans(base, model, projection, free);
    let mut scores = rank(projection, &scans);
    let hypothesis = |score: &Score| scans[score.scan].hypothesis();
    let fit = |h: &Hypothesis, shape: f64| {
        Fit::new(
            projection,
            &model.whitened(base, &base.columns_mm(h, shape)),
        )
    };
    scores.retain(|s| is_possible(base, hypothesis(s), || fit(hypothesis(s), s.shape)));
    let is_significant = |s: &&Score| null.family_wise(s.ln_p) <= CAUSE_LEVEL;
    let leader = scores.iter().find(is_significant)?;
    let is_own = |s: &&Score| own.is_some_and(|own| hypothesis(s).is(&own.hypothesis));
    let as_good = |s: &&Score| leader.evidence - s.evidence < EQUAL;
    let mut kept = scores.iter().filter(is_significant).filter(is_own);
    let best = kept.find(as_good).unwrap_or(leader);
    let shape = match hypothesis(best).effect.shape {
        Shape::TimeConstant | Shape::SettlingTime => {
            let explained = |shape: f64| {
                let explained = fit(hypothesis(best), shape).explained;
                explained.iter().map(|x| x * x).sum::<f64>()
            };
            refined(best.shape, explained)
        }
        _ => best.shape,
    };
    let own_fit = fit(hypothesis(best), shape);
    let mut rivals = Vec::new();
    for score in &scores {
        // Who explains less than half cannot be alike.
        if score.scan == best.scan || score.statistic < 0.5 * best.statistic {
            continue;
        }
        let other = fit(hypothesis(score), score.shape);
        let alike = cosine(&own_fit, &other);
        let [a, b] = [best, score].map(|s| hypothesis(s).effect.id);
        // A frame that only goes along is a machine that goes the other way, whatever else a frame can do.
        let are_twins = is_of_machine(a) && is_of_frame(b) && alike > ALIKE;
        if (are_twins || is_rival(best, score, alike)) && rivals.len() < MOST_RIVALS {
            let Hypothesis {
                effect, subject, ..
            } = *hypothesis(score);
            let rival = ResolvedEffect {
                effect,
                subject,
                parameters: other.estimates,
                shape: score.shape,
            };
            rivals.push((rival, score.bic));
        }
    }
    Some(Found {
        suspect: Suspect {
            hypothesis: *hypothesis(best),
            shape,
            u_shape: best.u_shape,
        },
        p_value: null.family_wise(best.ln_p),
        bic: best.bic,
        statistic: best.statistic,
        rivals,
    })
}

/// Whether the data allow values in their plausible ranges, three standard uncertainties considered.
fn is_possible(base: &Base<'_>, hypothesis: &Hypothesis, fit: impl Fn() -> Fit) -> bool {
    let parameters = hypothesis
        .effect
        .parameters(base.scene, &hypothesis.subject);
    if parameters.iter().all(|p| p.plausible.is_none()) {
        return true;
    }
    // Whitened with the noise: of unit variance.
    fit().is_possible(&parameters, 1.0)
}

/// Ratio of neighbours in the list of time constants, at most, and the part to which one is refined.
const RATIO: f64 = 1.5;
const REFINED: f64 = 1e-3;

/// A time constant between its neighbours in the list.
fn refined(found: f64, explained: impl Fn(f64) -> f64) -> f64 {
    let is_close = |low: f64, high: f64| high - low <= REFINED * high;
    golden_section([found / RATIO, found * RATIO], is_close, explained)
}

/// What a suspect explains of what the base model leaves.
pub(crate) fn trace(base: &Base<'_>, model: &Model, suspect: &Suspect) -> Vec<f64> {
    let columns = columns_mm(base, std::slice::from_ref(suspect));
    let fit = Fit::new(&model.bare, &model.whitened(base, &columns));
    fit.explained
}

/// Part of the squares of a trace that lies in columns, both after the projection.
pub(crate) fn part_within(model: &Projection, columns: &[Vec<f64>], trace: &[f64]) -> f64 {
    let squares: f64 = trace.iter().map(|x| x * x).sum();
    let mut rest = trace.to_vec();
    model.extended(columns).project(&mut rest);
    let left: f64 = rest.iter().map(|x| x * x).sum();
    1.0 - left / squares.max(f64::MIN_POSITIVE)
}
