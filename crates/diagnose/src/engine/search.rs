//! The search for causes, one after the other.
//!
//! 1. The hypothesis with the most evidence, among those that noise alone would not match at the level of the causes,
//!    joins the causes.
//! 2. All causes settle ([`settle`]): each is compared with every other hypothesis with the other causes in the
//!    model, in the noise that is left; a better one replaces it, and one that is not needed leaves. The first cause
//!    is often a compromise between two.
//! 3. The search ends when nothing joins, or when the next cause would be the same problem under another name
//!    ([`Culprits`]) or only the shape of an earlier one.

use trueaxis_effects::Shape;
use trueaxis_selection::{DECISIVE, EQUAL, Fit, Hypothesis, Null, Scan, combined};

use crate::Error;
use crate::engine::between::{golden_section, neighbours};
use crate::engine::opposed::are_opposed;
use crate::engine::{Culprits, Found, Measured, Ranking, Suspect};

/// The causes, the model with them, and what a further cause that is not a separate one would explain.
pub(crate) struct Search<M> {
    pub(crate) found: Vec<Found>,
    pub(crate) adjusted: M,
    pub(crate) left: f64,
}

impl<M> Search<M> {
    /// A model without causes.
    pub(crate) fn without_causes(adjusted: M) -> Self {
        Self {
            found: Vec::new(),
            adjusted,
            left: 0.0,
        }
    }
}

/// A hypothesis that explains less than this share of what the leader explains is no rival in the same model,
/// whatever the noise: rivals explain at least half.
const WORTH_COMPARING: f64 = 0.25;

/// Finds the causes of what `start`, a model without causes, leaves. `first` are the scans of `all` hypotheses for that model.
pub(crate) fn find_causes<D: Measured>(
    data: &D,
    start: D::Model,
    all: &[Hypothesis],
    first: &[Box<dyn Scan>],
    null: &Null,
) -> Result<Search<D::Model>, Error> {
    let mut search = Search::without_causes(start);
    while search.found.len() < D::MOST_CAUSES {
        let mut suspects = D::suspects(&search.adjusted).to_vec();
        let next = if suspects.is_empty() {
            let ranking = Ranking::of(data, D::projection(&search.adjusted), first);
            next(&ranking, null, D::CAUSE_LEVEL)
        } else {
            next(
                &Ranking::new(data, &search.adjusted, all),
                null,
                D::CAUSE_LEVEL,
            )
        };
        let Some((leader, comparable)) = next else {
            break;
        };
        // Beside earlier causes all hypotheses are compared again: those causes may have hidden some.
        let candidates = if suspects.is_empty() {
            &comparable
        } else {
            all
        };
        suspects.push(leader);
        let (found, adjusted) = settle(data, suspects, candidates, null)?;
        if found.len() <= search.found.len() {
            break;
        }
        if let Some(left) = not_its_own(data, &adjusted, &found) {
            search.left = left;
            break;
        }
        (search.found, search.adjusted) = (found, adjusted);
    }
    Ok(search)
}

/// The hypothesis with the most evidence among those that noise does not explain, and those to compare with it.
fn next<S: AsRef<[Box<dyn Scan>]>>(
    ranking: &Ranking<'_, S>,
    null: &Null,
    level: f64,
) -> Option<(Suspect, Vec<Hypothesis>)> {
    let leader = ranking.leader(null, level, None)?;
    let comparable = ranking.comparable(leader, WORTH_COMPARING);
    Some((ranking.suspect(leader).0, comparable))
}

/// A further cause that explains less than this share of what the others explain may be only their shape, which is
/// never quite that of the catalogue; for the same reason it must be more certain.
pub(crate) const SHAPE_ERROR: f64 = 0.05;
pub(crate) const FURTHER_LEVEL: f64 = 0.001;

/// What the weakest of several causes explains, if the last addition is not a separate cause.
fn not_its_own<D: Measured>(data: &D, model: &D::Model, found: &[Found]) -> Option<f64> {
    if found.len() < 2 {
        return None;
    }
    let culprits: Vec<Culprits> = found.iter().map(|f| Culprits::of(data, f)).collect();
    let is_stacked = (1..found.len()).any(|i| {
        (0..i).any(|j| {
            !found[i].suspect.is_second_time_constant(&found[j].suspect)
                && culprits[i].overlap(&culprits[j])
        })
    });
    let all: f64 = found.iter().map(|f| f.statistic).sum();
    let weakest = found.iter().map(|f| f.statistic).fold(all, f64::min);
    let is_shape = weakest < SHAPE_ERROR * (all - weakest);
    let is_uncertain = found
        .iter()
        .any(|f| f.p_value > FURTHER_LEVEL || f.evidence < 0.0);
    let is_none = is_stacked || is_shape || is_uncertain || opposed(data, model);
    is_none.then_some(weakest)
}

/// Whether the causes of a model cancel each other.
fn opposed<D: Measured>(data: &D, model: &D::Model) -> bool {
    let columns = data.columns(model);
    let effects = D::suspects(model).iter().map(|suspect| {
        let own = columns(&suspect.hypothesis, suspect.shape);
        combined(D::bare(model).rows(), &own, &suspect.parameters)
    });
    are_opposed(D::bare(model), &effects.collect::<Vec<_>>())
}

/// Most exchanges of causes for better ones.
const MOST_EXCHANGES: usize = 6;

/// Judges each cause against the candidates with the others in the model until nothing changes.
pub(crate) fn settle<D: Measured>(
    data: &D,
    mut suspects: Vec<Suspect>,
    candidates: &[Hypothesis],
    null: &Null,
) -> Result<(Vec<Found>, D::Model), Error> {
    let mut adjusted = data.refit(suspects.clone())?;
    let mut exchanges = 0;
    loop {
        let mut found = Vec::new();
        let mut changed = false;
        for k in 0..suspects.len() {
            let mut others = suspects.clone();
            let own = others.remove(k);
            // In the noise left without it: a large disturbance hides its own rivals.
            let without = data.refit_near(&adjusted, others)?;
            let Some(judged) = judged(data, &without, &own, candidates, null) else {
                suspects.remove(k);
                changed = true;
                break;
            };
            let same = judged.suspect.hypothesis.is(&own.hypothesis);
            let step = (judged.suspect.shape - own.shape).abs();
            let moved = step > judged.suspect.u_shape.max(REFINED * own.shape.abs());
            if (!same || moved) && exchanges < MOST_EXCHANGES {
                exchanges += 1;
                changed = true;
            }
            suspects[k] = judged.suspect.clone();
            found.push(judged);
        }
        adjusted = data.refit(suspects.clone())?;
        let others = data.exchanged(D::suspects(&adjusted));
        if let Some(others) = others.filter(|_| !changed) {
            // The number of parameters is the same, so the squares decide.
            let other = data.refit_near(&adjusted, others)?;
            let more = D::projection(&other).squares() - D::projection(&adjusted).squares();
            if more < -EQUAL && exchanges < MOST_EXCHANGES {
                exchanges += 1;
                suspects = D::suspects(&other).to_vec();
                adjusted = other;
                continue;
            }
            if more < DECISIVE {
                add_exchanged(&mut found, D::suspects(&other), more);
            }
        }
        if !changed {
            for (found, suspect) in found.iter_mut().zip(D::suspects(&adjusted)) {
                found.suspect = suspect.clone();
            }
            return Ok((found, adjusted));
        }
        suspects = D::suspects(&adjusted).to_vec();
    }
}

/// Lists exchanged causes as rivals of those that they replace; together they leave `more` squares.
fn add_exchanged(found: &mut [Found], others: &[Suspect], more: f64) {
    for (found, other) in found.iter_mut().zip(others) {
        let is_other = |suspect: &Suspect| suspect.hypothesis.is(&other.hypothesis);
        if !is_other(&found.suspect) && !found.rivals.iter().any(|rival| is_other(&rival.0)) {
            found.rivals.push((other.clone(), found.bic + more));
        }
    }
}

/// The best explanation of what a model without one of its causes leaves, with its rivals; `None` if noise explains it.
fn judged<D: Measured>(
    data: &D,
    without: &D::Model,
    own: &Suspect,
    candidates: &[Hypothesis],
    null: &Null,
) -> Option<Found> {
    let ranking = Ranking::new(data, without, candidates);
    // Equal evidence is no reason for an exchange.
    let best = ranking.leader(null, D::CAUSE_LEVEL, Some(&own.hypothesis))?;
    let (mut suspect, mut fit) = ranking.suspect(best);
    if let Some(ends) = ends(data, &suspect) {
        (suspect, fit) = refined(data, without, &suspect, ends);
    }
    Some(Found {
        p_value: null.family_wise(best.ln_p),
        bic: best.bic,
        evidence: best.evidence,
        statistic: best.statistic,
        rivals: ranking.rivals::<D>(best, &fit),
        wandering: Vec::new(),
        suspect,
    })
}

/// Limits between which a listed shape is refined; `None` if the list has all shapes.
fn ends<D: Measured>(data: &D, suspect: &Suspect) -> Option<[f64; 2]> {
    let shape = suspect.hypothesis.effect.shape;
    if !matches!(
        shape,
        Shape::TimeConstant | Shape::SettlingTime | Shape::Lag
    ) {
        return None;
    }
    let found = suspect.shape;
    match neighbours(&data.shapes(shape), found) {
        [Some(before), Some(after)] => Some([before, after]),
        [Some(before), None] => Some([before, found * found / before]),
        [None, Some(after)] => Some([found * found / after, after]),
        [None, None] => None,
    }
}

/// Relative accuracy to which a time constant is refined.
const REFINED: f64 = 1e-3;

/// A time constant or a lag between its neighbours in the list: golden section on what it explains.
fn refined<D: Measured>(
    data: &D,
    without: &D::Model,
    suspect: &Suspect,
    ends: [f64; 2],
) -> (Suspect, Fit) {
    let columns = data.columns(without);
    let at = |shape: f64| Fit::new(D::projection(without), &columns(&suspect.hypothesis, shape));
    let is_close = |low: f64, high: f64| high - low <= REFINED * ends[1];
    let shape = golden_section(ends, is_close, |shape| at(shape).gained());
    let fit = at(shape);
    let refined = Suspect::new(suspect.hypothesis, (shape, suspect.u_shape), &fit);
    (refined, fit)
}
