//! Report of the diagnosis of lengths, with units.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::Level;
use trueaxis_poses::{LengthsAdjustment, uneven_in_words};

use crate::engine::{
    HeldOut, Suspect, Wanders, add_rival_disturbances, cause, wandered, wandered_mm,
    whitened_columns,
};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::fitted::fitted;
use crate::lengths::held_out::{held_out_stations, held_out_sweeps};
use crate::lengths::instead::add_what_moves_instead;
use crate::lengths::named::{Named, left_alone};
use crate::lengths::noise_floor::{mean_noise_um, noise_floor_um};
use crate::lengths::places::places;
use crate::lengths::search::{Looked, looked_at};
use crate::said::{Entry, Said};
use crate::shares::Part;
use crate::{Error, Gain, LevelReport, Misfit, Shares};

/// Finds what the lengths contradict in the rigid, quasi-static model, and why, starting from the adjustment of their
/// calibration; returns also the effects of causes and disturbances on all readings of the campaign, mm.
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
    // If a fold cannot be adjusted, nothing is held out.
    let held_out_by = |named: &Named<'_>| match named.is_plain() {
        true => None,
        false => held_out_sweeps(&named.base, &named.adjusted).unwrap_or(None),
    };
    let mut heldout = held_out_by(&named);
    // Causes that predict unused data worse than nothing are not named.
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
    add_what_moves_instead(&named.base, &named.adjusted, &mut named.found)?;
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
    // Both models in the final noise.
    let noise = current.network.noise;
    let sharp = base.beside(Vec::new()).adjust(Vec::new(), Some(noise))?;
    let length_um = mean_noise_um(&base, &current);
    let rms_um = |adjusted: &Adjusted| {
        (adjusted.projection.squares() / adjusted.projection.degrees_of_freedom).sqrt() * length_um
    };
    let (before_um, after_um) = (rms_um(&sharp), rms_um(&current));
    // Changes between repeats that are not among the causes are also in the scatter of the repeats.
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
        &wandering,
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
        let lines: Vec<String> = base.left_out.iter().map(|l| l.line.to_string()).collect();
        notices.push(format!(
            "{} length(s) contradict all others and were left out: line(s) {}",
            lines.len(),
            lines.join(", ")
        ));
    }
    let words = |own| uneven_in_words(own, base.campaign, (&base.network, &base.groups));
    notices.extend(base.uneven.iter().map(words));
    let times = || base.readings.iter().map(|r| r.time_s);
    if times().all(|t| Some(t) == times().next()) {
        notices.push(
            "all lengths have the same time_s: nothing that changes with time can be told; give times"
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
    let squares: f64 = effects_mm.map(|e| e * e).sum();
    (squares / base.readings.len() as f64).sqrt() * 1e3
}
