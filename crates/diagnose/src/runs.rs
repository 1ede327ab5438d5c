//! Comparison of the runs of one axis that were measured with other axes parked elsewhere.
//!
//! Each step of each run has a pose of its own in the adjustment of the lengths, so no coupling of axes contradicts
//! the lengths. It contradicts other runs: what a rigid machine leaves of the poses at positions shared by runs is
//! white noise ([`RunComparison`]). The effect of a unit of a cause on it goes through the lengths and the whole
//! calibration ([`trueaxis_calibrate::Responses::of_runs_to`]): the runs of other axes, which determine the base, see
//! the effect as well.

mod contradicting;
mod fitted;
mod hypotheses;

use trueaxis_calibrate::{Calibration, Replay, RunComparison, calibrate_for_replay};
use trueaxis_campaign::Campaign;
use trueaxis_effects::{Level, ResolvedEffect, Scene};
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_poses::EffectsOnLengths;
use trueaxis_selection::{Projection, f_test};

use crate::engine::linear::{Among, Judged, Listed};
use crate::engine::rms;
use crate::numbers::{distinct, root_mean_square, whole};
pub(crate) use crate::runs::contradicting::contradicting_runs;
use crate::runs::fitted::fitted;
use crate::runs::hypotheses::{candidates, not_observable};
use crate::said::{Entry, Said};
use crate::{Cause, Error, LevelReport, Misfit, OmnibusTest, Settings, Shares, Unexplained};

/// Family-wise level of the causes, and level of the misfit of the runs: together they raise an alarm in 0.7 % of
/// campaigns whose runs agree.
const CAUSE_LEVEL: f64 = 0.005;
const MISFIT_LEVEL: f64 = 0.002;

/// Share of the misfit from which causes are named even if a remainder is significant: no machine sags by a product.
const NEARLY_ALL: f64 = 0.9;

/// Compares the runs of each axis that has several; `None` if none has, or if they share no positions. Causes are named
/// only if `may_be_named`: the lengths have no other cause left in them. Also returns the campaign with its lengths
/// less the effects of the causes, if there are any.
pub(crate) fn diagnose_runs(
    campaign: &Campaign,
    scene: &Scene,
    settings: &Settings,
    may_be_named: bool,
) -> Result<Option<(Said, Option<Campaign>)>, Error> {
    let axes = distinct(campaign.runs.iter().map(|run| run.axis));
    if campaign.lengths.is_none() || axes.len() == campaign.runs.len() {
        return Ok(None);
    }
    let mut whole = settings.calibration;
    whole.poses.robust = false;
    let replay = calibrate_for_replay(campaign, &settings.calibration)
        .or_else(|_| calibrate_for_replay(campaign, &whole));
    let (calibration, replay) = replay.map_err(Error::Calibrate)?;
    let comparisons = replay.run_comparisons();
    if comparisons.is_empty() {
        return Ok(None);
    }
    let on_lengths = EffectsOnLengths::new(campaign)
        .map_err(|error| Error::Calibrate(trueaxis_calibrate::Error::Poses(error)))?;
    let noise_dof = noise_dof(&calibration);
    Ok(Some(compared(
        scene,
        (noise_dof, may_be_named),
        &replay,
        &comparisons,
        &on_lengths,
    )))
}

/// Degrees of freedom of the larger part of the noise that the lengths show.
fn noise_dof(calibration: &Calibration) -> f64 {
    let noise = calibration.adjustment.noise;
    let Some((length, repeatability)) = noise.map(|n| (n.length.used, n.repeatability.used)) else {
        return f64::INFINITY;
    };
    match length.sigma_mm > repeatability.sigma_mm {
        true => length.degrees_of_freedom,
        false => repeatability.degrees_of_freedom,
    }
}

/// Tests what a model leaves of the runs, with the probability that runs which agree differ as much; the noise of the
/// poses has `noise_dof` degrees of freedom.
fn test(model: &Projection, noise_dof: f64) -> OmnibusTest {
    let columns = whole(model.degrees_of_freedom.round()).max(1);
    let (squares, all) = (model.squares(), noise_dof + columns as f64);
    OmnibusTest {
        varies_with: "run",
        detail: None,
        columns,
        p_value: match noise_dof > MANY {
            true => chi_squared_upper_tail(squares, columns as f64),
            false => f_test(squares, squares + noise_dof, columns, all),
        },
    }
}

/// Practically infinite: F is chi-squared to a part in a thousand.
const MANY: f64 = 1e5;

fn compared(
    scene: &Scene,
    (noise_dof, may_be_named): (f64, bool),
    replay: &Replay<'_>,
    comparisons: &[RunComparison],
    on_lengths: &EffectsOnLengths<'_>,
) -> (Said, Option<Campaign>) {
    let candidates = candidates(scene, replay, comparisons, on_lengths);
    let listed = Listed::new(projection(comparisons), candidates.into());
    let base = &listed.base;
    let test = |model: &Projection| test(model, noise_dof);
    let is_left = |model: &Projection| test(model).p_value < MISFIT_LEVEL;
    let found = match may_be_named {
        true => Among::all(&listed, CAUSE_LEVEL).after(Vec::new()),
        false => Vec::new(),
    };
    let mut after = listed.with(&found);
    let is_left = is_left(&after);
    let structure = base.squares() - base.degrees_of_freedom;
    let share = (base.squares() - after.squares()) / structure;
    let mut judged: Vec<Judged> = Vec::new();
    if !is_left || share >= NEARLY_ALL {
        judged.extend((0..found.len()).filter_map(|k| listed.judge(&found, k)));
    } else {
        after = base.clone();
    }
    let sigma_um =
        1e3 * comparisons.iter().map(|c| c.sigma_mm).sum::<f64>() / comparisons.len() as f64;
    let rms_um = |model: &Projection| sigma_um * rms(model);
    let sought = may_be_named.then_some(share);
    let unexplained =
        is_left.then(|| unexplained(test(&after).p_value, rms_um(&after), sigma_um, sought));
    let columns = judged.iter().map(|j| listed.columns_of(&j.cause));
    let misfit = |model: &Projection| Misfit {
        rms_um: rms_um(model),
        heldout_rms_um: None,
    };
    let causes = judged.iter().map(|judged| Cause {
        fitted: fitted(scene, comparisons, judged),
        ..cause(scene, on_lengths, &listed, judged)
    });
    let causes: Vec<Cause> = causes.collect();
    let effects: Vec<ResolvedEffect> = causes.iter().map(|c| c.effect.clone()).collect();
    let is_whole = causes.iter().all(Cause::is_seen_whole);
    let corrected = (!effects.is_empty() && is_whole).then(|| {
        let effects_mm = on_lengths.of(&effects);
        on_lengths.taken_out(&effects_mm)
    });
    let entry = Entry {
        causes,
        disturbances: Vec::new(),
        report: LevelReport {
            level: Level::Lengths,
            data: in_words(scene, comparisons),
            noise_floor_um: sigma_um,
            prediction_u_um: None,
            before: misfit(base),
            after: misfit(&after),
            gain: None,
            shares: Shares::of_parts(base, columns, std::iter::empty(), is_left),
            unexplained,
            tests: vec![test(base)],
            tests_after: vec![test(&after)],
            places: Vec::new(),
        },
    };
    let said = Said {
        entries: vec![entry],
        not_observable: Vec::from_iter(not_observable(scene, &listed)),
        ..Said::default()
    };
    (said, corrected)
}

/// All comparisons in one projection, one below the other.
fn projection(comparisons: &[RunComparison]) -> Projection {
    let rows: usize = comparisons.iter().map(|c| c.observations.len()).sum();
    let observations = comparisons.iter().flat_map(|c| &c.observations);
    let observations: Vec<f64> = observations.copied().collect();
    let (mut base, mut first) = (Vec::new(), 0);
    for comparison in comparisons {
        base.extend(comparison.base.iter().map(|own| {
            let mut column = vec![0.0; rows];
            column[first..first + own.len()].copy_from_slice(own);
            column
        }));
        first += comparison.observations.len();
    }
    Projection::dense(observations, &base)
}

/// What is left of the runs, of which the best explanation takes a share, if any was sought.
fn unexplained(p_value: f64, rms_um: f64, sigma_um: f64, share: Option<f64>) -> Unexplained {
    let note = match share {
        None => "varies with run; a cause of the lengths that is seen in part only is still in them, and may be why"
            .to_owned(),
        Some(share) if share < NEARLY_ALL => format!(
            "varies with run; the best explanation takes {:.0} % of it, which is not enough to name it",
            100.0 * share.max(0.0)
        ),
        Some(_) => format!("varies with run: a small remainder, probability {p_value:.0e}"),
    };
    let rms_um = (rms_um.powi(2) - sigma_um.powi(2)).max(0.0).sqrt();
    Unexplained {
        is_of_tests: true,
        ..Unexplained::new(Level::Lengths, rms_um, vec!["run"], note)
    }
}

/// Description such as `runs y and y2 of axis Y`.
fn in_words(scene: &Scene, comparisons: &[RunComparison]) -> String {
    let of_axis = |comparison: &RunComparison| {
        let runs = comparison.runs.join(", ");
        format!("runs {runs} of axis {}", scene.axis_name(comparison.axis))
    };
    let all: Vec<String> = comparisons.iter().map(of_axis).collect();
    all.join("; ")
}

fn cause(
    scene: &Scene,
    on_lengths: &EffectsOnLengths<'_>,
    listed: &Listed,
    judged: &Judged,
) -> Cause {
    let cause = listed.cause(judged, (scene, Level::Lengths), (&judged.fit, 0.0), 1.0);
    let effects_mm = on_lengths.of(std::slice::from_ref(&cause.effect));
    Cause {
        explained_rms_um: 1e3 * root_mean_square(&effects_mm),
        rivals: listed.rivals(judged),
        ..cause
    }
}
