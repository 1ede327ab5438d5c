//! The search for causes in the lengths.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::{Level, Subject};
use trueaxis_poses::{LengthsAdjustment, network_from_campaign};
use trueaxis_screening::Removed;
use trueaxis_selection::{Hypothesis, Null};

use crate::engine::{
    Candidates, Found, HeldOut, Omnibus, Search, Suspect, Wanders, add_rival_disturbances, cause,
    compete, find_causes, is_tested, of_catalogue, scans, settle, untested, wandered, wandered_mm,
    whitened_columns,
};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::fitted::fitted;
use crate::lengths::grown::add_growth;
use crate::lengths::held_out::{held_out_stations, held_out_sweeps};
use crate::lengths::left_out::{alone, still_left_out};
use crate::lengths::named::{Named, left_alone, named};
use crate::lengths::noise_floor::{mean_noise_um, noise_floor_um};
use crate::lengths::not_observable::not_observable;
use crate::lengths::omnibus::omnibus;
use crate::lengths::places::places;
use crate::lengths::shifted::add_jumps;
use crate::said::{Entry, Said};
use crate::shares::Part;
use crate::{Error, Gain, LevelReport, Misfit, NotObservable, Shares};

/// Finds what the lengths contradict in the rigid, quasi-static model, and why, from the adjustment of their
/// calibration; and what causes and disturbances do to every reading of the campaign, mm.
pub(crate) fn diagnose_lengths(
    campaign: &Campaign,
    lengths: &Lengths,
    adjustment: Option<&LengthsAdjustment<'_>>,
) -> Result<(Said, Vec<f64>), Error> {
    let (base, looked) = looked_at(Base::new(campaign, lengths, adjustment)?, lengths)?;
    let Looked {
        plain,
        before,
        mut named,
        not_observable,
    } = looked;
    // A fold that cannot be adjusted holds nothing out.
    let held_out_by = |named: &Named<'_>| match named.is_plain() {
        true => None,
        false => held_out_sweeps(&named.base, &named.adjusted).unwrap_or(None),
    };
    let mut heldout = held_out_by(&named);
    // What predicts unused data worse than nothing is no cause.
    if heldout.is_some_and(|h| h.is_loss()) && !named.found.is_empty() {
        named = left_alone(&base, plain.network.noise, &before)?;
        heldout = held_out_by(&named);
    }
    add_rival_disturbances(
        &named.base,
        &named.adjusted,
        &named.wandering,
        &mut named.found,
    )?;
    add_growth(&named.base, &named.adjusted, &mut named.found)?;
    add_jumps(&named.base, &named.adjusted, &mut named.found)?;
    let Named {
        base,
        found,
        wandering,
        adjusted: current,
        after,
        unexplained,
    } = named;
    let wandered_mm = wandered_mm(&base, &current, None);
    let rest = base.less(&current, &wandered_mm)?;
    let scatter_um = noise_floor_um(&base, &rest);
    // Both in the noise that is left at the end.
    let noise = current.network.noise;
    let sharp = base.beside(Vec::new()).adjust(Vec::new(), Some(noise))?;
    let length_um = mean_noise_um(&base, &current);
    let rms_um = |adjusted: &Adjusted| {
        (adjusted.projection.squares() / adjusted.projection.degrees_of_freedom).sqrt() * length_um
    };
    let (before_um, after_um) = (rms_um(&sharp), rms_um(&current));
    // What changes between repeats and is not among the causes is in their scatter, too.
    let floor_um = scatter_um.min(after_um);
    let stations_out = match found.is_empty() && wandering.is_empty() {
        true => None,
        false => held_out_stations(&base, &current).unwrap_or(None),
    };
    let gain = heldout.map(|h| Gain {
        leave_one_station_out: stations_out.map(HeldOut::ratio),
        ..h.gain(before_um, after_um, floor_um)
    });
    let of_causes = current.suspects.iter();
    let of_causes = of_causes.map(|s| Part::Free(base.columns(&sharp, &s.hypothesis, s.shape)));
    let smooth = base.disturbances.iter();
    let smooth = smooth.map(|d| Part::Smooth(whitened_columns(&base, &sharp, d)));
    let parts: Vec<Part> = of_causes.chain(smooth).collect();
    let shares = Shares::of_parts(&sharp.projection, &parts, unexplained.is_some());
    let scale_um = |adjusted: &Adjusted| {
        length_um * (base.readings.len() as f64 / adjusted.projection.degrees_of_freedom).sqrt()
    };
    let report = LevelReport {
        level: Level::Lengths,
        data: format!("{} lengths", base.readings.len()),
        noise_floor_um: floor_um,
        prediction_u_um: None,
        before: Misfit {
            rms_um: before_um,
            heldout_rms_um: heldout.map(|h| h.before * length_um),
        },
        after: Misfit {
            rms_um: after_um,
            heldout_rms_um: heldout.map(|h| h.after * length_um),
        },
        gain,
        shares,
        unexplained,
        tests: before.into_iter().map(|t| t.test).collect(),
        tests_after: after.into_iter().map(|t| t.test).collect(),
        places: places(
            &base,
            [&sharp.projection.residuals, &rest.projection.residuals],
            [&sharp, &current].map(scale_um),
        ),
    };
    let effects_mm = effects_mm(&base, lengths, &current, &wandered_mm);
    let notices = notices(&base);
    let only = found.len() + wandering.len() == 1;
    let disturbances = wandered(
        &base,
        Level::Lengths,
        &current,
        wandering,
        gain.filter(|_| only),
    );
    let causes = found.into_iter().map(|found| {
        let suspect = &found.suspect;
        let shown = (
            rms_of_effect_um(&base, &current, suspect),
            fitted(&base, &rest, &current, suspect),
        );
        cause(
            &base,
            Level::Lengths,
            &current,
            found,
            gain.filter(|_| only),
            shown,
        )
    });
    let causes = causes.collect();
    let entry = Entry {
        report,
        causes,
        disturbances,
    };
    let said = Said {
        entries: vec![entry],
        not_observable,
        notices,
        ..Said::default()
    };
    Ok((said, effects_mm))
}

/// The lengths, and what the search finds in them. Readings that were left out as gross errors come back where they are
/// in a row, or where a cause explains them.
fn looked_at<'a>(
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
    // Asked before what wanders is looked for, which takes longest.
    let are_other = |base: &Base<'a>, gross: &[Removed]| {
        !gross.iter().eq(base.left_out.iter().map(|l| &l.removed))
    };
    let gross = still_left_out(&all, &base, lengths, &searched.search.adjusted);
    if are_other(&base, &gross) {
        base = leaving_out(&base, &gross)?;
        searched = searched.again(&base)?;
    }
    let before: Vec<Hypothesis> = hypotheses(&searched.search.adjusted);
    let mut looked = searched.look(&base)?;
    let after = hypotheses(&looked.named.adjusted);
    let are_same = before.len() == after.len() && before.iter().zip(&after).all(|(a, b)| a.is(b));
    if !are_same {
        let gross = still_left_out(&all, &base, lengths, &looked.named.adjusted);
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

/// What the search finds in the lengths of a base.
struct Looked<'a> {
    /// The model without causes.
    plain: Adjusted,
    /// The tests of what it leaves.
    before: Vec<Omnibus>,
    named: Named<'a>,
    not_observable: Vec<NotObservable>,
}

/// No interferometer resolves less, µm: what is left of simulated lengths without noise is the rounding of
/// the adjustment, and no cause is looked for in it.
const RESOLUTION_UM: f64 = 1e-3;

/// Causes of the lengths of a base as if nothing wandered.
struct Searched {
    /// The model without causes.
    plain: Adjusted,
    /// The tests of what it leaves.
    before: Vec<Omnibus>,
    all: Vec<Hypothesis>,
    null: Null,
    search: Search<Adjusted>,
    not_observable: Vec<NotObservable>,
}

impl Searched {
    /// Tests and searches.
    fn of(base: &Base<'_>) -> Result<Self, Error> {
        let plain = base.adjust(Vec::new(), None)?;
        let residuals_um = plain.solution.residuals_mm.iter().map(|r| 1e3 * r);
        let squares: f64 = residuals_um.map(|r| r * r).sum();
        let is_exact = squares < RESOLUTION_UM.powi(2) * plain.projection.degrees_of_freedom;
        let before = match is_exact {
            true => Vec::new(),
            false => omnibus(base, &plain),
        };
        // Poses take every coupling of axes; where runs differ, they are compared (`crate::runs`).
        let is_pose = |s: &Subject| s.other_axis.is_some() && s.component.is_some();
        let is_wanted = |s: &Subject| !is_pose(s) && is_tested(base.campaign, s);
        let all = of_catalogue(Level::Lengths, &base.scene, is_wanted);
        let first = scans(base, &plain, &plain.projection, &all);
        let scans = match is_exact {
            true => &[],
            false => first.scans.as_slice(),
        };
        let null = Null::simulated(&plain.projection, scans);
        let sides = || base.readings.iter().map(|r| r.direction);
        let both_sides = sides().any(|side| Some(side) != sides().next());
        let bare = base.adjust(Vec::new(), Some(plain.network.noise))?;
        let search = find_causes(base, bare, &all, scans, &null)?;
        Ok(Self {
            not_observable: [
                not_observable(&base.scene, &first.without_trace, both_sides),
                untested(Level::Lengths, base.campaign, &base.scene),
            ]
            .concat(),
            plain,
            before,
            all,
            null,
            search,
        })
    }

    /// The same with the few more readings that the causes explain: these settle among their rivals, but nothing else is looked for.
    fn again(self, base: &Base<'_>) -> Result<Self, Error> {
        let plain = base.adjust(Vec::new(), None)?;
        let Search {
            found,
            adjusted,
            left,
        } = self.search;
        let is_comparable = |hypothesis: &&Hypothesis| {
            let of_found = |found: &Found| {
                let rivals = found.rivals.iter().map(|rival| &rival.0);
                let mut comparable = rivals.chain([&found.suspect]);
                comparable.any(|suspect| suspect.hypothesis.is(hypothesis))
            };
            found.iter().any(of_found)
        };
        let comparable: Vec<Hypothesis> = self.all.iter().filter(is_comparable).copied().collect();
        let (found, adjusted) = settle(base, adjusted.suspects, &comparable, &self.null)?;
        Ok(Self {
            before: omnibus(base, &plain),
            plain,
            search: Search {
                found,
                adjusted,
                left,
            },
            ..self
        })
    }

    /// What wanders beside the causes or instead of them, and their names.
    fn look<'a>(self, base: &Base<'a>) -> Result<Looked<'a>, Error> {
        let Self { plain, before, .. } = self;
        let candidates = Candidates {
            all: &self.all,
            null: &self.null,
        };
        let model = compete(base, &before, self.search, &candidates)?;
        Ok(Looked {
            named: named(base, model, plain.network.noise, &before)?,
            plain,
            before,
            not_observable: self.not_observable,
        })
    }
}

/// For every reading of the campaign what the causes and what wanders do to it, mm. Readings that were left out keep
/// their error.
fn effects_mm(
    base: &Base<'_>,
    lengths: &Lengths,
    adjusted: &Adjusted,
    wandered_mm: &[f64],
) -> Vec<f64> {
    let mut effects_mm = vec![0.0; lengths.readings.len()];
    let is_kept = |i: &usize| base.left_out.iter().all(|l| l.removed.reading != *i);
    let kept = (0..lengths.readings.len()).filter(is_kept);
    for ((i, reading), wandered_mm) in kept.zip(&base.readings).zip(wandered_mm) {
        let of_causes_mm = base.effect_mm(reading, &adjusted.solution, &adjusted.suspects);
        effects_mm[i] = of_causes_mm + wandered_mm;
    }
    effects_mm
}

fn notices(base: &Base<'_>) -> Vec<String> {
    let mut notices = Vec::new();
    if !base.left_out.is_empty() {
        let lines: Vec<String> = base.left_out.iter().map(|l| l.line.to_string()).collect();
        notices.push(format!(
            "{} length(s) contradict all others and were left out: line(s) {}",
            lines.len(),
            lines.join(", ")
        ));
    }
    for &station in &base.uneven {
        notices.push(format!(
            "station {}: its lengths scatter more than those of the others and weigh less here: see whether the tripod stood firmly, and \
             what passed through the beam",
            base.scene.stations[station]
        ));
    }
    let times = || base.readings.iter().map(|r| r.time_s);
    if times().all(|t| Some(t) == times().next()) {
        notices.push(
            "all lengths have the same time_s: nothing that changes with time can be told; give times"
                .to_owned(),
        );
    }
    notices
}

/// Rms of what a cause does to the lengths, µm.
fn rms_of_effect_um(base: &Base<'_>, current: &Adjusted, suspect: &Suspect) -> f64 {
    let alone = std::slice::from_ref(suspect);
    let effects_mm = base.readings.iter();
    let effects_mm = effects_mm.map(|r| base.effect_mm(r, &current.solution, alone));
    let squares: f64 = effects_mm.map(|e| e * e).sum();
    (squares / base.readings.len() as f64).sqrt() * 1e3
}
