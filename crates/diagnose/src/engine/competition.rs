//! Competition of causes and disturbances.
//!
//! Two models are built. One finds causes first, then disturbances beside them, then causes again with the disturbances in the
//! covariance; the other begins with disturbances. These and disturbances alone are compared in the same noise by their total 2 ln B. A
//! form that can be anything is less credible than one in the catalogue, and every further name costs: a cause [`DECISIVE`], odds of 20
//! to 1, and a disturbance twice that. So a drift is a drift even if a disturbance might explain it, and three stacked causes do not beat
//! one disturbance. Where causes leave nothing to disturbances, only a single disturbance with a larger 2 ln B can replace them.
//!
//! A cause in time that leaves a tenth of what it explains to a disturbance of the same thing does not describe the
//! motion of that thing, and is not named ([`is_of`]). Nor is one whose statistic is less than a twentieth of the
//! 2 ln B for an axis that changes with time: no basis of low degree quite describes warming up.

use trueaxis_effects::Layer;
use trueaxis_selection::{DECISIVE, Hypothesis, Null, Projection, rank};

use crate::Error;
use crate::engine::disturbance::{Wanderer, Who, With};
use crate::engine::wandering::{
    JudgedDisturbance, Wandering, instead_of_cause, one_by_one, sought, sought_from,
};
use crate::engine::wanders::{Beside, disturbances, least, of_wandering};
use crate::engine::{
    Culprit, Found, SHAPE_ERROR, Search, Suspect, Wanders, find_causes, revise, scan, scans,
    without,
};

/// Causes, and disturbances beside them.
pub(crate) struct Competed<D: Wanders> {
    /// The data, with the disturbances in their covariance.
    pub(crate) base: D,
    pub(crate) search: Search<D::Model>,
    pub(crate) wandering: Vec<JudgedDisturbance>,
}

impl<D: Wanders> Competed<D> {
    /// Whether it has neither causes nor disturbances.
    pub(crate) fn is_plain(&self) -> bool {
        self.search.found.is_empty() && self.wandering.is_empty()
    }
}

/// The input of a search for causes.
pub(crate) struct Candidates {
    pub(crate) all: Vec<Hypothesis>,
    pub(crate) null: Null,
}

/// The model with the largest 2 ln B. `search` has the causes found without disturbances; if there are none and all `is_quiet`, none are
/// sought.
pub(crate) fn compete<D: Wanders>(
    base: &D,
    is_quiet: bool,
    search: Search<D::Model>,
    candidates: &Candidates,
) -> Result<Competed<D>, Error> {
    let of_causes = |search| Competed {
        base: base.clone(),
        search,
        wandering: Vec::new(),
    };
    if search.found.is_empty() && is_quiet {
        return Ok(of_causes(search));
    }
    let suspects = D::suspects(&search.adjusted).to_vec();
    let nothing = Beside::new(base, &[]);
    let (one_by_one, beside) = rayon::join(
        || one_by_one(&nothing),
        || match suspects.is_empty() {
            true => Ok(Vec::new()),
            false => sought(&Beside::new(base, &suspects)),
        },
    );
    let (one_by_one, beside) = (one_by_one?, beside?);
    let is_complete = !suspects.is_empty() && beside.is_empty() && search.left <= 0.0;
    if is_complete && beats(base, &search, one_by_one.1.first())? {
        return Ok(of_causes(search));
    }
    let alternated = |first| described(base, alternated(base, first, candidates)?, candidates);
    let (causes_first, alone) = rayon::join(
        || match beside.is_empty() {
            true => Ok(of_causes(search)),
            false => alternated(beside),
        },
        || {
            let alone = sought_from(&nothing, &one_by_one)?;
            let is_first = !is_complete && !alone.is_empty();
            let ahead = is_first.then(|| alternated(alone.clone())).transpose()?;
            Ok::<_, Error>((alone, ahead))
        },
    );
    let (causes_first, (alone, ahead)) = (causes_first?, alone?);
    if alone.is_empty() {
        return Ok(causes_first);
    }
    let only = without_causes(base, alone.clone())?;
    let wandering_first = || ahead.map_or_else(|| alternated(alone), Ok);
    if suspects.is_empty() {
        return better(base, wandering_first()?, only);
    }
    let is_complete = causes_first.wandering.is_empty() && causes_first.search.left <= 0.0;
    let mut model = better(base, causes_first, only)?;
    if !is_complete || model.search.found.is_empty() {
        model = better(base, model, wandering_first()?)?;
    }
    Ok(model)
}

/// Whether causes that explain everything have a larger 2 ln B than the first disturbance. That several together look like
/// a form in the catalogue down to the noise would be a coincidence and is not tried.
fn beats<D: Wanders>(
    base: &D,
    search: &Search<D::Model>,
    first: Option<&JudgedDisturbance>,
) -> Result<bool, Error> {
    let plain = base.adjust(Vec::new(), Some(D::noise(&search.adjusted)))?;
    let of_causes = charged(base, &plain, &search.found, &[]);
    let first = first.map(|first| charged(base, &plain, &[], std::slice::from_ref(first)));
    Ok(first.is_none_or(|of_first| of_first <= of_causes))
}

/// Adds to causes the disturbances that may have been there instead: those with a larger 2 ln B, and those of which the
/// cause may be a part.
pub(crate) fn add_rival_disturbances<D: Wanders>(competed: &mut Competed<D>) -> Result<(), Error> {
    let (base, search) = (&competed.base, &mut competed.search);
    let beside = Beside::new(base, &[]);
    let known = &competed.wandering;
    let is_new = |w: &Wanderer| known.iter().all(|own| own.wanderer() != *w);
    let others: Vec<Wanderer> = beside.wanderers().iter().copied().filter(is_new).collect();
    for (k, found) in search.found.iter_mut().enumerate() {
        let suspects = without(D::suspects(&search.adjusted), k);
        let without = base.adjust_near(&search.adjusted, suspects)?;
        let instead = instead_of_cause(&beside, &without, &others, found.two_ln_b);
        found.wandering.extend(instead);
        let of_stage = known
            .iter()
            .filter(|own| own.wanderer().turns_beside(&found.suspect.hypothesis));
        found
            .wandering
            .extend(of_stage.map(|own| (own.wanderer(), own.two_ln_b)));
    }
    Ok(())
}

/// A cause is only part of a disturbance if this share of what it explains is left to a disturbance of the same thing.
pub(crate) const PART: f64 = 0.1;

/// The model without causes that do not describe the motion of what they blame.
fn described<D: Wanders>(
    base: &D,
    mut model: Competed<D>,
    candidates: &Candidates,
) -> Result<Competed<D>, Error> {
    loop {
        let wanders_on = |found: &Found| {
            model.wandering.iter().any(|judged| {
                let wanderer = judged.wanderer();
                let is_rest = wanderer.is_of_changing_axis()
                    && found.suspect.hypothesis.is_of_time()
                    && found.statistic < SHAPE_ERROR * judged.two_ln_b;
                let goes_on = judged.two_ln_b > PART * found.statistic
                    && is_of(&Culprit::all_of(base, found), wanderer);
                is_rest || goes_on
            })
        };
        let Some(undescribed) = model.search.found.iter().position(wanders_on) else {
            return Ok(model);
        };
        let suspects = without(D::suspects(&model.search.adjusted), undescribed);
        model = revised(base, suspects, candidates)?;
    }
}

/// Causes revised beside disturbances that are found beside them.
pub(crate) fn revised<D: Wanders>(
    base: &D,
    suspects: Vec<Suspect>,
    candidates: &Candidates,
) -> Result<Competed<D>, Error> {
    let wandering = sought(&Beside::new(base, &suspects))?;
    if suspects.is_empty() {
        return without_causes(base, wandering);
    }
    let here = base.beside(disturbances(&wandering));
    let (found, adjusted) = revise(&here, suspects, candidates)?;
    if found.is_empty() {
        return only_wandering(base);
    }
    Ok(Competed {
        base: here,
        search: Search {
            found,
            adjusted,
            left: 0.0,
        },
        wandering,
    })
}

/// The model with a larger 2 ln B, in the smaller of the two noises; the first if both have as much.
fn better<D: Wanders>(
    base: &D,
    first: Competed<D>,
    second: Competed<D>,
) -> Result<Competed<D>, Error> {
    let noises = [&first, &second].map(|m| D::noise(&m.search.adjusted));
    let plain = base.adjust(Vec::new(), least::<D>(noises.into_iter()))?;
    let all_two_ln_b =
        [&first, &second].map(|model| charged(base, &plain, &model.search.found, &model.wandering));
    Ok(match all_two_ln_b[1] > all_two_ln_b[0] {
        true => second,
        false => first,
    })
}

/// Twice the logarithm of the marginal likelihood ratio of causes with disturbances against the model with neither,
/// less the price of every further name.
fn charged<D: Wanders>(
    base: &D,
    plain: &D::Model,
    causes: &[Found],
    wandering: &[JudgedDisturbance],
) -> f64 {
    let (two_ln_b, beside) = of_wandering(base, plain, wandering);
    let columns = base.columns(plain);
    let of_causes = causes.iter().map(|own| &own.suspect);
    let of_causes = of_causes.map(|own| columns(&own.hypothesis, own.shape));
    let of_causes: Vec<Vec<Vec<f64>>> = of_causes.collect();
    let price_of = |k: usize| {
        let others = beside.extended(&without(&of_causes, k).concat());
        let scan = scan(base, plain, &others, causes[k].suspect.hypothesis)?;
        let scores = rank(&others, std::slice::from_ref(&scan));
        scores.first().map(|score| score.price(&others))
    };
    let prices = (0..causes.len()).filter_map(price_of);
    two_ln_b + together([&beside, &beside.extended(&of_causes.concat())], prices)
        - price(causes.len(), wandering)
}

/// 2 ln B of all causes: from what the model leaves without and with them, less the price of the prior of each beside the others.
/// Added one after the other, a cause that may have any shape would first explain what the others do, at another shape, and they
/// would explain it again.
pub(crate) fn together(
    [before, after]: [&Projection; 2],
    prices: impl Iterator<Item = f64>,
) -> f64 {
    before.ln_ratio(after.squares()) - prices.sum::<f64>()
}

/// The price of every further name than one: what can take any course costs twice that of an effect.
pub(crate) fn price(effects: usize, wandering: &[JudgedDisturbance]) -> f64 {
    let names = effects + 2 * wandering.len();
    DECISIVE * names.saturating_sub(1) as f64
}

/// The model with these disturbances alone.
fn without_causes<D: Wanders>(
    base: &D,
    wandering: Vec<JudgedDisturbance>,
) -> Result<Competed<D>, Error> {
    let base = base.beside(disturbances(&wandering));
    let adjusted = base.adjust(Vec::new(), None)?;
    Ok(Competed {
        base,
        search: Search::without_causes(adjusted),
        wandering,
    })
}

/// The model with disturbances alone, found without causes.
pub(crate) fn only_wandering<D: Wanders>(base: &D) -> Result<Competed<D>, Error> {
    without_causes(base, sought(&Beside::new(base, &[]))?)
}

/// Causes found beside disturbances, disturbances beside these causes, and both revised.
fn alternated<D: Wanders>(
    base: &D,
    first: Vec<JudgedDisturbance>,
    candidates: &Candidates,
) -> Result<Competed<D>, Error> {
    let here = base.beside(disturbances(&first));
    let start = here.adjust(Vec::new(), None)?;
    let scans = scans(&here, &start, D::projection(&start), &candidates.all).scans;
    let search = find_causes(&here, start, candidates, &scans)?;
    if search.found.is_empty() {
        return Ok(Competed {
            base: here,
            search,
            wandering: first,
        });
    }
    let (count, left) = (search.found.len(), search.left);
    let mut model = revised(base, D::suspects(&search.adjusted).to_vec(), candidates)?;
    if model.search.found.len() == count {
        model.search.left = left;
    }
    Ok(model)
}

/// Whether a disturbance in time is of the thing that a cause blames: the cause may then be only part of a course
/// that it does not describe.
fn is_of(culprits: &[Culprit], wanderer: Wanderer) -> bool {
    culprits
        .iter()
        .any(|culprit| match (*culprit, wanderer.who, wanderer.with) {
            (Culprit::Station(own, _), Who::Station(other), With::Occupation)
            | (Culprit::Target(own, _), Who::Target(other), With::Campaign) => own == other,
            (Culprit::Axis(own, by), Who::Axis(other), With::Campaign) => {
                own == other && by.grows_axis()
            }
            (Culprit::EveryOccupation, Who::Machine | Who::Tripods | Who::Frame, _) => true,
            (Culprit::Everything(by), Who::Air, _) => by.layer == Layer::Instrument,
            _ => false,
        })
}
