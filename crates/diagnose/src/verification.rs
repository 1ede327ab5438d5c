//! The readings of other instruments against the prediction: positioning lines and ball bars.
//!
//! ```text
//! measured - predicted = base model + causes + noise
//! ```
//!
//! Each verification of the campaign is judged by itself: the prediction ([`comparison`]) with its own
//! errors ([`prediction_error`]), what the measurement leaves open ([`base`]), the noise that the repeats
//! show ([`noise_floor`]), causes one at a time ([`search`]), whether they help on readings that were not
//! used ([`held_out`]), what wanders beside them or instead of them ([`wandering`], [`competition`]), and
//! whether anything is left ([`omnibus`]). The paper's Figs. 10, 12 and 16 are
//! this comparison.
//!
//! Without a calibration the prediction is an ideal machine; a line then tells what differs between
//! directions, cycles and lines, but not what its mean curve is made of. Arrivals are taken as
//! independent. Lines in different files are not joined.

mod arrivals;
pub(crate) mod base;
mod believed;
#[cfg(test)]
mod calibrated_tests;
pub(crate) mod comparison;
mod competition;
mod gross_errors;
mod held_out;
mod hypotheses;
mod lost_motion;
mod noise_floor;
mod not_observable;
mod omnibus;
mod prediction_error;
mod problem;
mod report;
mod resolution;
mod search;
mod wandered;
mod wanderer;
mod wandering;

use trueaxis_calibrate::CalibratedMachine;
use trueaxis_campaign::{Campaign, Verification, VerificationKind};
use trueaxis_effects::{Level, Scene};
use trueaxis_kinematics::{Ideal, Machine};

use crate::components::diagnose_line_curve;
use crate::engine::{Chosen, Omnibus, without};
use crate::said::{Entry, Said};
use crate::selection::{Part, Projection, add};
use crate::verification::arrivals::is_same;
use crate::verification::base::base_columns;
use crate::verification::comparison::Comparison;
use crate::verification::competition::{Look, Model, compete};
use crate::verification::gross_errors::gross_errors;
use crate::verification::noise_floor::noise_floor_um;
use crate::verification::prediction_error::prediction_directions;
use crate::verification::problem::{Given, Problem};
use crate::verification::resolution::resolution_um;
use crate::verification::wandered::{Course, wandered};
use crate::verification::wandering::Wandering;
use crate::{LevelReport, Misfit, Shares, Unexplained};

/// False alarms of all verifications of a campaign together: once for the causes, once for the omnibus
/// tests.
const LEVEL: f64 = 0.01;

/// Degrees of freedom below which nothing can be said.
const LEAST_DEGREES_OF_FREEDOM: f64 = 8.0;

/// Compares every verification of a campaign with the prediction of a calibration, or with an ideal
/// machine.
pub(crate) fn diagnose_verification(
    campaign: &Campaign,
    calibration: Option<&CalibratedMachine>,
    scene: &Scene,
    explain_curves: bool,
) -> Said {
    let machine = match calibration {
        Some(calibration) => calibration.machine(),
        None => &campaign.machine,
    };
    let mut outcome = Said::default();
    if calibration.is_some_and(|c| !c.has_uncertainties) && !campaign.verification.is_empty() {
        outcome.notices.push(
            "the calibration has no uncertainties and is taken as exact: its own errors are found in the readings"
                .to_owned(),
        );
    }
    let level = LEVEL / campaign.verification.len().max(1) as f64;
    for verification in &campaign.verification {
        diagnose_entry(
            campaign,
            machine,
            verification,
            calibration,
            scene,
            Asked {
                level,
                explain_curves,
            },
            &mut outcome,
        );
    }
    outcome
}

/// What is asked of one verification.
#[derive(Clone, Copy)]
struct Asked {
    /// Its part of the false alarms.
    level: f64,
    /// Whether to say what its mean curve consists of.
    explain_curves: bool,
}

fn diagnose_entry(
    campaign: &Campaign,
    machine: &Machine,
    verification: &Verification,
    calibration: Option<&CalibratedMachine>,
    scene: &Scene,
    asked: Asked,
    outcome: &mut Said,
) {
    let Asked {
        level,
        explain_curves,
    } = asked;
    let compared = |verification| match calibration {
        Some(calibration) => Comparison::new(machine, verification, calibration),
        None => Comparison::new(machine, verification, &Ideal),
    };
    let gross = gross_errors(verification, &compared(verification));
    let mut kept = verification.clone();
    for (row, _) in gross.iter().rev() {
        kept.readings.remove(*row);
    }
    for (_, rejected) in gross {
        outcome.notices.push(format!(
            "{}: the reading in line {} is off by {:.1} µm (u = {:.1} µm) against all others and was left out",
            rejected.file, rejected.row, rejected.error_um, rejected.u_um
        ));
        outcome.rejected.push(rejected);
    }
    let mut comparison = compared(&kept);
    if calibration.is_some() {
        comparison.parked_elsewhere = parked_elsewhere(campaign, &kept);
    }
    let base = base_columns(&comparison, calibration.is_some());
    let Some(resolution_um) = resolution_um(&comparison) else {
        let why = match comparison.arrivals.len() {
            0 | 1 => "there are fewer than two stops",
            _ => "all readings are equal",
        };
        let name = &verification.name;
        outcome
            .notices
            .push(format!("{name}: {why}; nothing can be said"));
        return;
    };
    let posed = |sigma_um: f64| {
        let directions = calibration.map(|c| prediction_directions(&comparison, c, sigma_um));
        let given = Given {
            calibrated: calibration.is_some(),
            sigma_um,
            resolution_um,
            base: &base,
            prediction: &directions.unwrap_or_default(),
        };
        Problem::new(&comparison, scene, &given)
    };
    let floor_um = noise_floor_um(&comparison).map(|floor| floor.max(resolution_um));
    let curve = match calibration {
        None if explain_curves => {
            diagnose_line_curve(&comparison, floor_um, machine, &verification.name)
        }
        _ => None,
    };
    let is_explained = curve.is_some();
    outcome.curves.extend(curve.into_iter().flatten());
    // Without repeats the base model's misfit stands for the noise at first.
    let mut problem = posed(floor_um.unwrap_or(1.0));
    let name = &verification.name;
    if problem.listed.base.degrees_of_freedom < LEAST_DEGREES_OF_FREEDOM {
        outcome.notices.push(format!(
            "{name}: {} arrivals leave {:.0} degrees of freedom beside the base model; nothing can be said (at least {LEAST_DEGREES_OF_FREEDOM:.0} are needed: repeat the cycle)",
            problem.readings(),
            problem.listed.base.degrees_of_freedom,
        ));
        return;
    }
    let mut found = judge_entry(&problem, scene, name, level);
    if floor_um.is_none() {
        // Then what is left with the causes in the model.
        for _ in 0..2 {
            problem = posed(found.report.after.rms_um.max(resolution_um));
            found = judge_entry(&problem, scene, name, level);
        }
        found.report.noise_floor_um = found.report.after.rms_um.max(resolution_um);
    }
    let unseen = not_observable::not_observable(&problem, scene, name, calibration.is_some());
    // What the mean curve absorbs was looked for in the curve itself.
    let in_curve = |id: &str| is_explained && ["scale_error", "cyclic_error"].contains(&id);
    let unseen = unseen.into_iter().filter(|u| !in_curve(u.effect));
    outcome.not_observable.extend(unseen);
    outcome.entries.push(found);
}

/// Axes that stand elsewhere at the readings of a line than in all steps that its axis was calibrated at.
fn parked_elsewhere(campaign: &Campaign, verification: &Verification) -> Vec<usize> {
    let VerificationKind::Positioning { axis, .. } = verification.kind else {
        return Vec::new();
    };
    let calibrated: Vec<&[f64]> = campaign
        .steps
        .iter()
        .filter(|step| step.run.is_some_and(|run| campaign.runs[run].axis == axis))
        .map(|step| step.positions.as_slice())
        .collect();
    let elsewhere = |other: &usize| {
        let read = verification.readings.iter().map(|r| r.positions[*other]);
        *other != axis
            && !calibrated.is_empty()
            && read
                .clone()
                .all(|q| calibrated.iter().all(|at| !is_same(at[*other], q)))
    };
    (0..campaign.machine.axes().len())
        .filter(elsewhere)
        .collect()
}

/// Finds and judges the causes of one verification.
fn judge_entry(plain: &Problem<'_>, scene: &Scene, name: &str, level: f64) -> Entry {
    let families = omnibus::families(plain);
    let folds = held_out::folds(plain.comparison);
    let before = &plain.listed.base;
    let tests = omnibus::omnibus(plain, &families, before);
    let look = Look {
        families: &families,
        folds: &folds,
        level,
    };
    let Model {
        problem,
        wandering,
        causes: chosen,
    } = compete(plain, &look);
    let problem = &problem;

    // The one without which most is left comes first.
    let left_without = |k: usize| problem.listed.with(&without(&chosen, k)).squares();
    let mut ranked: Vec<(f64, Chosen)> = (0..chosen.len())
        .map(|k| (left_without(k), chosen[k]))
        .collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let chosen: Vec<Chosen> = ranked.into_iter().map(|(_, cause)| cause).collect();
    let after = problem.listed.with(&chosen);
    let tests_after = omnibus::omnibus(problem, &families, &after);
    let courses = wandering
        .iter()
        .map(|own| (own, Course::new(problem, own, &after)));
    let courses: Vec<(&Wandering, Course)> = courses.collect();
    let mut course = vec![0.0; before.rows()];
    for (_, own) in &courses {
        add(&mut course, &own.whitened, 1.0);
    }
    let causes = report::causes(problem, scene, &chosen, (before, &after), &course, &folds);
    let unexplained = unexplained(problem, &after, &tests_after, level);
    let of_causes = chosen.iter().map(std::slice::from_ref);
    let of_causes = of_causes.map(|cause| Part::Free(problem.listed.columns(cause)));
    let smooth = wandering.iter().map(|w| Part::Smooth(w.columns(plain)));
    let parts: Vec<Part> = of_causes.chain(smooth).collect();
    let held_before = held_out::held_out(plain, &[], &folds);
    let held_after = held_out::held_out(problem, &chosen, &folds);
    let gain = held_out::gain(problem, &held_before, &held_after);
    let is_plain = chosen.is_empty() && wandering.is_empty();
    let is_single = chosen.len() + wandering.len() == 1;
    let gain = gain.map(|bounded| bounded.gain).filter(|_| !is_plain);
    let disturbances = wandered(problem, &courses, &after, gain.filter(|_| is_single));
    let misfit = |model, held: &held_out::HeldOut| Misfit {
        rms_um: problem.rms_um(model),
        heldout_rms_um: held.rms().map(|rms| rms * problem.sigma_um),
    };
    Entry {
        report: LevelReport {
            level: Level::Verification,
            data: name.to_owned(),
            noise_floor_um: problem.sigma_um,
            before: misfit(before, &held_before),
            after: misfit(&after, &held_after),
            gain,
            shares: Shares::of_parts(before, &parts, unexplained.is_some()),
            unexplained,
            tests: tests.into_iter().map(|t| t.test).collect(),
            tests_after: tests_after.into_iter().map(|t| t.test).collect(),
            places: report::places(problem, before, &after),
        },
        causes,
        disturbances,
    }
}

/// Structure that the causes leave.
fn unexplained(
    problem: &Problem<'_>,
    after: &Projection,
    tests: &[Omnibus],
    level: f64,
) -> Option<Unexplained> {
    let clear = || tests.iter().filter(|t| t.test.p_value < level);
    // Squares beyond what noise leaves in the columns of the clearest test.
    let excess = clear().map(|t| {
        let columns = t.test.columns as f64;
        let rest = after.squares() - t.drop;
        t.drop - columns * rest / (after.degrees_of_freedom - columns).max(1.0)
    });
    let excess = excess.reduce(f64::max)?;
    let varies_with: Vec<&'static str> = clear().map(|t| t.test.varies_with).collect();
    let period = clear().find_map(|t| t.test.detail.as_deref());
    let period = period.map_or_else(String::new, |p| format!(", with a period near {p}"));
    Some(Unexplained {
        level: Level::Verification,
        data: String::new(),
        rms_um: problem.sigma_um * (excess.max(0.0) / problem.readings() as f64).sqrt(),
        share: 0.0,
        note: format!("it varies with {}{period}", varies_with.join(" and ")),
        varies_with,
    })
}
