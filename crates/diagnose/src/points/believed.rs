//! The causes of the points that are named.

use trueaxis_selection::{Fit, Hypothesis, Null};

use crate::Error;
use crate::engine::{
    Candidates, Competed, Found, HeldOut, Measured, OMNIBUS_LEVEL, Omnibus, Search, Suspect,
    compete, find_causes, is_imitation, revised, scans, still_left, with_parameters,
};
use crate::points::base::Base;
use crate::points::doubted::robust_sigma;
use crate::points::held_out::held_out;
use crate::points::model::Model;
use crate::points::omnibus::{families, omnibus};
use crate::points::screened::Screened;

/// The named causes, the disturbances beside them, and what the model with both leaves and gains.
pub(super) struct Believed<'a> {
    pub(super) competed: Competed<Base<'a>>,
    pub(super) after: Vec<Omnibus>,
    pub(super) heldout: Option<HeldOut>,
}

impl<'a> Believed<'a> {
    /// No causes, and no tests.
    pub(super) fn nothing(base: Base<'a>, model: Model) -> Self {
        Self {
            competed: Competed {
                base,
                search: Search::without_causes(model),
                wandering: Vec::new(),
            },
            after: Vec::new(),
            heldout: None,
        }
    }

    /// The causes and disturbances in what `plain`, the model with neither, leaves.
    pub(super) fn search(
        screened: &Screened<'a>,
        plain: Model,
        all: &[Hypothesis],
    ) -> Result<Self, Error> {
        let base = &screened.base;
        let first = scans(base, &plain, &plain.projection, all).scans;
        let (all, null) = (all.to_vec(), Null::simulated(&plain.projection, &first));
        let candidates = Candidates { all, null };
        let search = find_causes(base, plain, &candidates, &first)?;
        // No test looks at what an axis does with time.
        let mut model = compete(base, false, search, &candidates)?;
        loop {
            let count = model.search.found.len();
            let believed = Self::of(model, screened.are_many)?;
            if believed.found().len() == count {
                return Ok(believed);
            }
            // A disturbance may have been taken for a cause; the others are judged again without that cause.
            model = revised(base, suspects(believed.found()), &candidates)?;
        }
    }

    /// The causes of a model except those that predict unused points worse than nothing, or only imitate what is
    /// left. Among many gross errors, which imitate anything, causes must predict better and be most of the misfit.
    fn of(mut competed: Competed<Base<'a>>, are_many: bool) -> Result<Self, Error> {
        loop {
            let (base, search) = (&competed.base, &mut competed.search);
            let (found, model) = (&mut search.found, &search.adjusted);
            let count = found.len();
            let families = families(base, model);
            let after = omnibus(model, &families);
            let left = still_left(&families, &after, OMNIBUS_LEVEL, |t| t.excess);
            let is_one = |cause: &Found| {
                let own = &cause.suspect;
                let columns = base.columns(model)(&own.hypothesis, own.shape);
                let fit = Fit::new(&model.bare, &columns);
                is_imitation(&model.bare, &fit, own.hypothesis.is_of_time(), &left)
            };
            // Causes found after an imitation are removed with it.
            let first = found.iter().position(is_one);
            found.truncate(first.unwrap_or(count));
            if found.len() == count {
                let is_plain = found.is_empty() && competed.wandering.is_empty();
                let heldout = match is_plain {
                    true => None,
                    false => held_out(base, model, &suspects(found)),
                };
                let holds = match are_many {
                    true => heldout.is_some_and(|h| h.is_gain()) && does_most(base, model),
                    false => heldout.is_none_or(|h| !h.is_loss()),
                };
                if found.is_empty() || holds {
                    return Ok(Self {
                        competed,
                        after,
                        heldout,
                    });
                }
                found.clear();
            }
            search.adjusted = base.adjust(suspects(found), None)?;
            with_parameters::<Base<'_>>(found, &search.adjusted);
        }
    }

    pub(super) fn found(&self) -> &[Found] {
        &self.competed.search.found
    }
}

/// Whether causes take more than half of the squares beyond the noise, which the variances of the model do not tell: gross errors
/// are in them.
fn does_most(base: &Base<'_>, model: &Model) -> bool {
    let (bare, left) = (model.bare.squares(), &model.projection);
    let noise = robust_sigma(base, model).powi(2) * left.degrees_of_freedom;
    bare - left.squares() > 0.5 * (bare - noise)
}

pub(super) fn suspects(found: &[Found]) -> Vec<Suspect> {
    found.iter().map(|f| f.suspect.clone()).collect()
}
