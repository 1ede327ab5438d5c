//! Report of the diagnosis of lengths, with units.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::Level;
use trueaxis_poses::{LengthsAdjustment, uneven_in_words};

use crate::Error;
use crate::engine::{
    Competed, Findings, Measured, Suspect, Wanders, add_rival_disturbances, left_out_in_words, rms,
    wandered_mm,
};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::fitted::fitted;
use crate::lengths::held_out::{held_out_stations, held_out_sweeps};
use crate::lengths::instead::add_what_moves_instead;
use crate::lengths::named::left_alone;
use crate::lengths::noise_floor::{mean_noise_um, noise_floor_um};
use crate::lengths::places::places;
use crate::lengths::search::looked_at;
use crate::numbers::root_mean_square;
use crate::said::Said;

/// Finds where the lengths contradict the rigid, quasi-static model, and why, starting from the adjustment of their
/// calibration; returns also the effects of causes and disturbances on all readings of the campaign, mm.
pub(crate) fn diagnose_lengths(
    campaign: &Campaign,
    lengths: &Lengths,
    adjustment: Option<&LengthsAdjustment<'_>>,
) -> Result<(Said, Vec<f64>), Error> {
    let (base, looked) = looked_at(Base::new(campaign, lengths, adjustment)?, lengths)?;
    let mut named = looked.named;
    let held_out_by = |model: &Competed<Base<'_>>| match model.is_plain() {
        true => None,
        false => held_out_sweeps(&model.base, &model.search.adjusted),
    };
    let mut heldout = held_out_by(&named.competed);
    // Causes that predict unused data worse than nothing are not named.
    if heldout.is_some_and(|h| h.is_loss()) && !named.competed.search.found.is_empty() {
        named = left_alone(&base, looked.plain.network.noise, &looked.before)?;
        heldout = held_out_by(&named.competed);
    }
    let mut competed = named.competed;
    add_rival_disturbances(&mut competed)?;
    let search = &mut competed.search;
    add_what_moves_instead(&competed.base, &search.adjusted, &mut search.found)?;
    let (base, current) = (&competed.base, &competed.search.adjusted);
    let wandered_mm = wandered_mm(base, current, None);
    let rest = base.less(current, &wandered_mm)?;
    // Both models in the final noise.
    let noise = current.network.noise;
    let sharp = base.beside(Vec::new()).adjust(Vec::new(), Some(noise))?;
    let noise_um = mean_noise_um(base, current);
    let findings = Findings {
        level: Level::Lengths,
        data: format!("{} lengths", base.readings.len()),
        competed: &competed,
        sharp: &sharp,
        noise_um,
        // Changes between repeats that are not among the causes are also in the scatter of the repeats.
        floor_um: noise_floor_um(base, &rest).min(noise_um * rms(&current.projection)),
        heldout,
        stations_out: match competed.is_plain() {
            true => None,
            false => held_out_stations(base, current),
        },
        tests: [looked.before, named.after],
        unexplained: named.unexplained,
        left: &rest.projection,
        places: &|misfits| places(base, misfits),
    };
    let entry = findings.entry(|suspect| {
        let rms_um = rms_of_effect_um(base, current, suspect);
        Ok((rms_um, fitted(base, &rest, current, suspect)))
    })?;
    let said = Said {
        entries: vec![entry],
        not_observable: looked.not_observable,
        notices: notices(base),
        ..Said::default()
    };
    Ok((said, effects_mm(base, lengths, current, &wandered_mm)))
}

/// The effects of causes and disturbances on all readings of the campaign, mm. Readings that were left out keep their
/// error.
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
        let lines = base.left_out.iter().map(|left_out| left_out.line);
        notices.push(left_out_in_words("length", lines));
    }
    let words = |own| uneven_in_words(own, base.campaign, (&base.network, &base.groups));
    notices.extend(base.uneven.iter().map(words));
    let times = || base.readings.iter().map(|r| r.time_s);
    if times().all(|t| Some(t) == times().next()) {
        notices.push(
            "all lengths have the same time_s: nothing that changes with time can be found; give times"
                .to_owned(),
        );
    }
    notices
}

/// Rms of the effect of a cause on the lengths, µm.
fn rms_of_effect_um(base: &Base<'_>, current: &Adjusted, suspect: &Suspect) -> f64 {
    let alone = std::slice::from_ref(suspect);
    let effects_mm = base.readings.iter();
    let effects_mm = effects_mm.map(|r| base.effect_mm(r, &current.solution, alone));
    root_mean_square(&effects_mm.collect::<Vec<f64>>()) * 1e3
}
