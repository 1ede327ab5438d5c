//! The search for causes in the lengths.

use trueaxis_campaign::Lengths;
use trueaxis_effects::{Level, Subject};
use trueaxis_poses::network_from_campaign;
use trueaxis_screening::Removed;
use trueaxis_selection::{Hypothesis, Null};

use crate::engine::{
    Candidates, Measured, Omnibus, Search, compete, find_causes, is_tested, of_catalogue, scans,
    untested,
};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::left_out::{alone, still_left_out};
use crate::lengths::named::{Named, named};
use crate::lengths::not_observable::not_observable;
use crate::lengths::omnibus::omnibus;
use crate::{Error, NotObservable};

/// The lengths, and the findings of the search in them. Readings that were left out as gross errors come back if they
/// are consecutive, or if a cause explains them.
pub(crate) fn looked_at<'a>(
    mut base: Base<'a>,
    lengths: &'a Lengths,
) -> Result<(Base<'a>, Looked<'a>), Error> {
    let campaign = base.campaign;
    let leaving_out = |base: &Base<'a>, gross: &[Removed]| {
        let all = network_from_campaign(campaign, lengths, false);
        Base::leaving_out(campaign, lengths, all, gross, Some(&base.start))
    };
    let all = std::mem::take(&mut base.left_out);
    let alone = alone(&all, lengths);
    if alone.len() < all.len() {
        base = leaving_out(&base, &alone)?;
    } else {
        base.left_out = all.clone();
    }
    let mut searched = Searched::of(&base)?;
    // Before the search for disturbances, which takes longest.
    let are_other = |base: &Base<'a>, gross: &[Removed]| {
        !gross.iter().eq(base.left_out.iter().map(|l| &l.removed))
    };
    let gross = still_left_out(&all, &base, lengths, &searched.search.adjusted);
    if are_other(&base, &gross) {
        base = leaving_out(&base, &gross)?;
        searched = Searched::of(&base)?;
    }
    let before: Vec<Hypothesis> = hypotheses(&searched.search.adjusted);
    let mut looked = searched.look(&base)?;
    let after = hypotheses(&looked.named.competed.search.adjusted);
    let are_same = before.len() == after.len() && before.iter().zip(&after).all(|(a, b)| a.is(b));
    if !are_same {
        let gross = still_left_out(&all, &base, lengths, &looked.named.competed.search.adjusted);
        if are_other(&base, &gross) {
            base = leaving_out(&base, &gross)?;
            looked = Searched::of(&base)?.look(&base)?;
        }
    }
    Ok((base, looked))
}

fn hypotheses(adjusted: &Adjusted) -> Vec<Hypothesis> {
    adjusted.suspects.iter().map(|s| s.hypothesis).collect()
}

/// The findings of the search in the lengths of a base.
pub(crate) struct Looked<'a> {
    /// The model without causes.
    pub(crate) plain: Adjusted,
    /// The tests of this model.
    pub(crate) before: Vec<Omnibus>,
    pub(crate) named: Named<'a>,
    pub(crate) not_observable: Vec<NotObservable>,
}

/// Best resolution of an interferometer, µm: what is left of simulated lengths without noise is the rounding of the
/// adjustment, in which no cause is sought.
const RESOLUTION_UM: f64 = 1e-3;

/// Without causes, and with all p-values of the omnibus tests above this, no disturbance would be significant.
const WORTH_A_LOOK: f64 = 0.05;

/// Causes of the lengths of a base, found without disturbances.
struct Searched {
    /// The model without causes.
    plain: Adjusted,
    /// The tests of this model.
    before: Vec<Omnibus>,
    candidates: Candidates,
    search: Search<Adjusted>,
    not_observable: Vec<NotObservable>,
}

impl Searched {
    /// Tests the lengths and searches for causes.
    fn of(base: &Base<'_>) -> Result<Self, Error> {
        let plain = base.adjust(Vec::new(), None)?;
        let residuals_um = plain.solution.residuals_mm.iter().map(|r| 1e3 * r);
        let squares: f64 = residuals_um.map(|r| r * r).sum();
        let is_exact = squares < RESOLUTION_UM.powi(2) * plain.projection.degrees_of_freedom;
        let before = match is_exact {
            true => Vec::new(),
            false => omnibus(base, &plain),
        };
        // Poses absorb any coupling of axes; where runs differ, `crate::runs` compares them.
        let is_pose = |s: &Subject| s.other_axis.is_some() && s.component.is_some();
        let is_wanted = |s: &Subject| !is_pose(s) && is_tested(base.campaign, s);
        let all = of_catalogue(Level::Lengths, &base.scene, is_wanted);
        let first = scans(base, &plain, &plain.projection, &all);
        let scans = match is_exact {
            true => &[],
            false => first.scans.as_slice(),
        };
        let null = Null::simulated(&plain.projection, scans);
        let bare = base.adjust(Vec::new(), Some(plain.network.noise))?;
        let candidates = Candidates { all, null };
        let search = find_causes(base, bare, &candidates, scans)?;
        Ok(Self {
            not_observable: [
                not_observable(&base.scene, &first.without_trace),
                untested(Level::Lengths, base.campaign, &base.scene),
            ]
            .concat(),
            plain,
            before,
            candidates,
            search,
        })
    }

    /// Finds disturbances beside the causes or instead of them, and names the causes.
    fn look<'a>(self, base: &Base<'a>) -> Result<Looked<'a>, Error> {
        let Self { plain, before, .. } = self;
        let is_quiet = before.iter().all(|t| t.test.p_value >= WORTH_A_LOOK);
        let model = compete(base, is_quiet, self.search, &self.candidates)?;
        Ok(Looked {
            named: named(base, model, plain.network.noise, &before)?,
            plain,
            before,
            not_observable: self.not_observable,
        })
    }
}
