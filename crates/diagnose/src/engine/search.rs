//! The search for causes in data that are adjusted anew with each: lengths and points.

use trueaxis_selection::{
    DECISIVE, EQUAL, Fit, Hypothesis, Null, Projection, Scan, Score, combined,
};

use crate::Error;
use crate::engine::between::{golden_section, neighbours};
use crate::engine::forward::{FURTHER_LEVEL, Forward, RESTS, Search, is_another, select};
use crate::engine::{Candidates, Culprit, Found, Measured, Ranking, Suspect, forward, scans};

/// A hypothesis that explains less than this share of what the leader explains is no rival in the same model,
/// whatever the noise: rivals explain at least half.
const WORTH_COMPARING: f64 = 0.25;

/// Finds the causes of what `start`, a model without causes, leaves. `first` are the scans of all candidates for that model.
pub(crate) fn find_causes<D: Measured>(
    data: &D,
    start: D::Model,
    candidates: &Candidates,
    first: &[Box<dyn Scan>],
) -> Result<Search<D::Model>, Error> {
    let projection = D::projection(&start).clone();
    let ranking = Ranking::new(data, &projection, first);
    let leader = ranking.leader(&candidates.null, D::CAUSE_LEVEL, None);
    let comparable = leader.map(|leader| ranking.comparable(leader, WORTH_COMPARING));
    let Some((leader, comparable)) = leader.zip(comparable) else {
        return Ok(Search::without_causes(start));
    };
    let search = Refitted {
        data,
        candidates,
        // Beside earlier causes all hypotheses are compared again: those causes may have hidden some.
        first: Some((found(&ranking, leader, &candidates.null).0, comparable)),
    };
    let mut causes = select(&search, start)?;
    with_parameters::<D>(&mut causes.found, &causes.adjusted);
    Ok(causes)
}

/// Judges each cause against the candidates with the others in the model until nothing changes.
pub(crate) fn revise<D: Measured>(
    data: &D,
    suspects: Vec<Suspect>,
    candidates: &Candidates,
) -> Result<(Vec<Found>, D::Model), Error> {
    let search = Refitted {
        data,
        candidates,
        first: None,
    };
    let (mut found, model) = forward::revise(&search, suspects)?;
    with_parameters::<D>(&mut found, &model);
    Ok((found, model))
}

/// Causes with their parameters beside each other.
pub(crate) fn with_parameters<D: Measured>(found: &mut [Found], model: &D::Model) {
    for (found, suspect) in found.iter_mut().zip(D::suspects(model)) {
        found.suspect = suspect.clone();
    }
}

/// The search in data that are adjusted anew with each cause.
struct Refitted<'s, D> {
    data: &'s D,
    candidates: &'s Candidates,
    /// The first cause, and what is compared with it alone.
    first: Option<(Found, Vec<Hypothesis>)>,
}

impl<D: Measured> Forward for Refitted<'_, D> {
    type Cause = Suspect;
    type Found = Found;
    type Model = D::Model;

    fn most(&self) -> usize {
        D::MOST_CAUSES
    }

    fn fit(&self, causes: Vec<Suspect>) -> Result<D::Model, Error> {
        self.data.adjust(causes, None)
    }

    fn fit_near(&self, near: &D::Model, causes: Vec<Suspect>) -> Result<D::Model, Error> {
        self.data.adjust_near(near, causes)
    }

    fn causes(model: &D::Model) -> &[Suspect] {
        D::suspects(model)
    }

    fn best(&self, model: &D::Model, own: Option<&Suspect>) -> Option<Found> {
        let is_alone = D::suspects(model).is_empty();
        let all = match (&self.first, own) {
            (Some((first, _)), None) if is_alone => return Some(first.clone()),
            (Some((_, comparable)), Some(_)) if is_alone => comparable,
            _ => &self.candidates.all,
        };
        let null = &self.candidates.null;
        let projection = D::projection(model);
        let scans = scans(self.data, model, projection, all).scans;
        let ranking = Ranking::new(self.data, projection, &scans);
        // An equal 2 ln B is no reason for an exchange.
        let name = own.map(|own| &own.hypothesis);
        let leader = ranking.leader(null, D::CAUSE_LEVEL, name)?;
        let (mut found, mut fit) = found(&ranking, leader, null);
        if own.is_some() {
            if let Some(ends) = ends(self.data, &found.suspect) {
                (found.suspect, fit) = refined(self.data, model, &found.suspect, ends);
            }
            found.rivals = ranking.rivals::<D>(leader, &fit);
        }
        Some(found)
    }

    fn cause(found: &Found) -> &Suspect {
        &found.suspect
    }

    fn statistic(found: &Found) -> f64 {
        found.statistic
    }

    fn has_moved(before: &Suspect, now: &Suspect) -> bool {
        let is_same = now.hypothesis.is(&before.hypothesis);
        !is_same || is_another(before.shape, (now.shape, now.u_shape))
    }

    /// The number of parameters is the same, so the squares decide.
    fn exchanged(&self, model: &D::Model, found: &mut [Found]) -> Result<Option<D::Model>, Error> {
        let Some(others) = self.data.exchanged(D::suspects(model)) else {
            return Ok(None);
        };
        let other = self.data.adjust_near(model, others)?;
        let more = D::projection(&other).squares() - D::projection(model).squares();
        if more < -EQUAL {
            return Ok(Some(other));
        }
        if more < DECISIVE {
            add_exchanged(found, D::suspects(&other), more);
        }
        Ok(None)
    }

    fn is_doubtful(&self, found: &[Found]) -> bool {
        let culprits = found.iter().map(|own| Culprit::all_of(self.data, own));
        let culprits: Vec<Vec<Culprit>> = culprits.collect();
        let share = |i: usize, j: usize| culprits[i].iter().any(|own| culprits[j].contains(own));
        let is_stacked = (1..found.len()).any(|i| {
            (0..i).any(|j| {
                !found[i].suspect.is_second_time_constant(&found[j].suspect) && share(i, j)
            })
        });
        let is_uncertain = |f: &Found| f.p_value > FURTHER_LEVEL || f.two_ln_b < 0.0;
        is_stacked || found.iter().any(is_uncertain)
    }

    fn effects<'m>(&'m self, model: &'m D::Model) -> Option<(&'m Projection, Vec<Vec<f64>>)> {
        let columns = self.data.columns(model);
        let effects = D::suspects(model).iter().map(|suspect| {
            let own = columns(&suspect.hypothesis, suspect.shape);
            combined(D::bare(model).rows(), &own, &suspect.parameters)
        });
        Some((D::bare(model), effects.collect()))
    }
}

/// A scored hypothesis as a cause without rivals.
fn found(ranking: &Ranking<'_>, score: &Score, null: &Null) -> (Found, Fit) {
    let (suspect, fit) = ranking.suspect(score);
    let found = Found {
        suspect,
        p_value: null.family_wise(score.ln_p),
        bic: score.bic,
        two_ln_b: score.two_ln_b,
        statistic: score.statistic,
        rivals: Vec::new(),
        wandering: Vec::new(),
    };
    (found, fit)
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

/// Limits between which a listed shape is refined; `None` if the list has all shapes.
fn ends<D: Measured>(data: &D, suspect: &Suspect) -> Option<[f64; 2]> {
    let shape = suspect.hypothesis.effect.shape;
    if !shape.is_duration() {
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

/// A time constant or a lag between its neighbours in the list: golden section on what it explains.
fn refined<D: Measured>(
    data: &D,
    without: &D::Model,
    suspect: &Suspect,
    ends: [f64; 2],
) -> (Suspect, Fit) {
    let columns = data.columns(without);
    let at = |shape: f64| Fit::new(D::projection(without), &columns(&suspect.hypothesis, shape));
    let is_close = |low: f64, high: f64| high - low <= RESTS * ends[1];
    let shape = golden_section(ends, is_close, |shape| at(shape).gained());
    let fit = at(shape);
    let refined = Suspect::new(suspect.hypothesis, (shape, suspect.u_shape), &fit);
    (refined, fit)
}
