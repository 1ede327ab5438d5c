//! The readings of other instruments against the prediction: positioning lines and ball bars.
//!
//! ```text
//! measured - predicted = base model + causes + noise
//! ```
//!
//! Repeated readings are removed ([`mod@given_once`]) and sorted ([`order`]; where two orders are as likely, both are
//! judged, [`other_order`]). Each verification of the campaign is first judged by itself ([`mod@series`]): the
//! prediction ([`comparison`]) with its errors ([`prediction_error`]), what the measurement leaves open ([`base`]), the
//! noise by the repeats ([`noise_floor`]) and whether that of neighbours is alike ([`mod@autocorrelation`]) or jumps
//! between two levels ([`mod@levels`]), causes one at a time ([`crate::engine::linear`]), their gain on unused readings
//! ([`held_out`]), disturbances beside or instead of them ([`wandering`], [`competition`], [`mod@described`]), rivals
//! ([`instead`]), and what is left ([`omnibus`]). Then all together ([`together`]): a cause in the machine has one
//! size in all lines. The paper's Figs. 10, 12 and 16 are this comparison.
//!
//! Without a calibration the prediction is an ideal machine; a line then shows differences between directions, cycles
//! and lines, but not what its mean curve consists of.

mod another_curve;
mod arrivals;
mod autocorrelation;
pub(crate) mod base;
mod believed;
mod between_passes;
pub(crate) mod comparison;
mod competition;
mod described;
mod doubted;
mod given_once;
mod gross_error;
mod gross_errors;
mod held_out;
mod hypotheses;
mod instead;
mod joined;
mod laser_scale;
mod levels;
mod lost_motion;
mod model;
mod noise_floor;
mod not_at_rest;
mod not_observable;
mod omnibus;
mod one_side;
mod one_size;
mod order;
mod other_order;
mod other_side;
mod paused;
mod pauses;
mod prediction_error;
mod problem;
mod report;
mod resolution;
mod series;
mod short_periods;
mod side;
mod stack;
mod stopped;
mod stops;
mod take_away;
mod tested;
mod together;
mod turned;
mod units;
mod wandered;
mod wanderer;
mod wandering;
mod which_order;
mod whitening;

use trueaxis_campaign::{Campaign, Verification};
use trueaxis_effects::{Effect, Level, Scene, Shape, effect};
use trueaxis_kinematics::{AxisKind, Machine};
use trueaxis_predict::{CalibratedMachine, GIVE_COMMANDED, are_read_out};

use crate::components::diagnose_line_curve;
use crate::said::Said;
use crate::verification::autocorrelation::{Noise, alike_neighbours};
use crate::verification::base::{count, places};
use crate::verification::comparison::Comparison;
use crate::verification::given_once::{copied, given_once, keep_rows_given_once, read_again};
use crate::verification::gross_errors::gross_errors;
use crate::verification::hypotheses::comes_from_both_sides;
use crate::verification::joined::join;
use crate::verification::laser_scale::alike_scales;
use crate::verification::levels::levels;
use crate::verification::lost_motion::beyond_drives;
use crate::verification::noise_floor::{noise_floor_um, repeats};
use crate::verification::not_observable::not_observable;
use crate::verification::omnibus::differs_by_cycle;
use crate::verification::order::{put_in_order, takes_turns};
use crate::verification::other_order::doubt;
use crate::verification::problem::Problem;
use crate::verification::series::Series;
use crate::verification::stops::gross_errors_within_stops;
use crate::verification::together::together;
use crate::verification::turned::{put_right, turned};

/// Probability of a false alarm for all verifications of a campaign together: once for the causes, once for the
/// omnibus tests.
const LEVEL: f64 = 0.01;

/// Fewest degrees of freedom for a judgement.
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
    let given = given_once(&campaign.verification, &mut outcome.notices);
    let mut kept = Vec::new();
    let mut in_other_order = Vec::new();
    for verification in given {
        let mut verification = verification.clone();
        let notices = &mut outcome.notices;
        notices.extend(keep_rows_given_once(&mut verification));
        let copied = copied(&verification.readings);
        notices.extend(copied.map(|copied| format!("{}: {copied}", verification.name)));
        let in_order = put_in_order(&mut verification);
        notices.extend(in_order.notice);
        if let Some(readings) = in_order.other {
            let mut other = verification.clone();
            other.readings = readings;
            // The stated order lists them.
            leave_gross_errors_out(machine, &mut other, calibration, &mut Said::default());
            in_other_order.push(other);
        }
        leave_gross_errors_out(machine, &mut verification, calibration, &mut outcome);
        let found = turned(&Comparison::new(machine, &verification, calibration));
        if let Some((ends, said)) = found {
            put_right(&mut verification, &ends);
            outcome
                .notices
                .push(format!("{}: {said}", verification.name));
        }
        if calibration.is_none() {
            outcome.notices.extend(read_again(&verification, &kept));
        }
        kept.push(verification);
    }
    let comparisons = kept
        .iter()
        .map(|own| Comparison::new(machine, own, calibration));
    let comparisons: Vec<Comparison<'_>> = comparisons.collect();
    // Each is judged by itself, and all together if there are several.
    let looks = comparisons.len() + usize::from(comparisons.len() > 1);
    let level = LEVEL / looks.max(1) as f64;
    let judged = comparisons.iter().filter_map(|comparison| {
        let asked = (level, explain_curves);
        judged_alone(comparison, calibration, scene, asked, &mut outcome)
    });
    let mut all: Vec<Series<'_>> = judged.collect();
    let shared = together(&mut all, calibration);
    let entry = |(number, series): (usize, &Series<'_>)| {
        let first: Vec<usize> = shared.iter().filter_map(|s| s.candidates[number]).collect();
        series.entry(&first)
    };
    outcome.entries = all.iter().enumerate().map(entry).collect();
    outcome.notices.extend(alike_scales(&outcome.entries, &all));
    join(&mut outcome.entries, &shared, &all);
    let are_open: Vec<&str> = in_other_order.iter().map(|own| own.name.as_str()).collect();
    for verification in &in_other_order {
        let mut entries = outcome.entries.iter_mut();
        let Some(entry) = entries.find(|entry| entry.report.data == verification.name) else {
            continue;
        };
        let comparison = Comparison::new(machine, verification, calibration);
        let (asked, mut aside) = ((level, false), Said::default());
        let series = judged_alone(&comparison, calibration, scene, asked, &mut aside);
        let other = series.map(|series| series.entry(&[]));
        doubt(entry, other.as_ref(), &comparison, &are_open);
    }
    outcome
}

/// Leaves out readings that contradict all others, and reports them.
fn leave_gross_errors_out(
    machine: &Machine,
    verification: &mut Verification,
    calibration: Option<&CalibratedMachine>,
    outcome: &mut Said,
) {
    for screen in [gross_errors_within_stops, gross_errors] {
        let comparison = Comparison::new(machine, verification, calibration);
        let gross = screen(verification, &comparison);
        drop(comparison);
        for own in gross.iter().rev() {
            verification.readings.remove(own.reading);
        }
        for own in gross {
            let (wrong, against) = (own.rejected, own.contradicts.against());
            outcome.notices.push(format!(
                "{}: the reading in line {} is off by {:.1} µm (u = {:.1} µm) against {against}",
                wrong.file, wrong.row, wrong.error_um, wrong.u_um
            ));
            outcome.rejected.push(wrong);
        }
    }
}

/// One verification judged by itself; `None`, with a notice, for too few data. `level` is its share of the level.
fn judged_alone<'a>(
    comparison: &'a Comparison<'a>,
    calibration: Option<&CalibratedMachine>,
    scene: &'a Scene,
    (level, explain_curves): (f64, bool),
    outcome: &mut Said,
) -> Option<Series<'a>> {
    let name = comparison.name;
    if let Some(mistake) = units::mistake(comparison) {
        outcome.notices.push(format!(
            "{name}: {mistake}; it is not judged: correct the table first"
        ));
        return None;
    }
    let doubts = [units::doubt, one_side::doubt, not_at_rest::doubt];
    let doubts = doubts.into_iter().filter_map(|doubt| doubt(comparison));
    let notices = doubts.map(|doubt| format!("{name}: {doubt}"));
    outcome.notices.extend(notices);
    let Some(digit) = comparison.digit else {
        let why = match comparison.arrivals.as_slice() {
            [stop] if stop.readings > 1 => {
                "all readings are of one stop, and count as one; number them in `cycle`, one after the other, to have them judged for \
                 drift, jumps and gross errors"
            }
            [] | [_] => "there are fewer than two stops",
            _ => "all readings are equal",
        };
        outcome
            .notices
            .push(format!("{name}: nothing can be said: {why}"));
        return None;
    };
    let scatter_um = noise_floor_um(comparison);
    let resolution_um = digit.of_stop_um();
    let hidden_um = scatter_um.map_or(0.0, |scatter_um| {
        digit.hidden_um(scatter_um, repeats(comparison))
    });
    let floor_um = scatter_um.map(|scatter_um| scatter_um.max(resolution_um).hypot(hidden_um));
    let posed = |noise: Noise| {
        let digit = (resolution_um, hidden_um);
        Problem::new(comparison, scene, calibration, level, noise, digit)
    };
    let curve = match calibration {
        None if explain_curves => diagnose_line_curve(comparison, floor_um, &mut outcome.notices),
        _ => None,
    };
    let is_explained = curve.is_some();
    outcome.curves.extend(curve.into_iter().flatten());
    // Without repeats the misfit of the base model replaces the noise at first.
    let plain = posed(Noise::white(floor_um.unwrap_or(1.0)));
    if plain.listed.base.degrees_of_freedom < LEAST_DEGREES_OF_FREEDOM {
        let are_read_out =
            comparison.line().is_some() && are_read_out(&comparison.positions(comparison.axis()));
        let what_to_do = if are_read_out {
            GIVE_COMMANDED
        } else if is_read_elsewhere(comparison) {
            "hardly any position was read twice: stop at the same positions on the way back and in each cycle, or give those commanded"
        } else {
            "repeat the cycle"
        };
        outcome.notices.push(format!(
            "{name}: {} readings, those of a stop counted once, leave {:.0} degrees of freedom beside the mean curve or the set-up; nothing can be said (at least {LEAST_DEGREES_OF_FREEDOM:.0} are needed: {what_to_do})",
            plain.readings(),
            plain.listed.base.degrees_of_freedom,
        ));
        return None;
    }
    let mut found = Series::new(plain);
    if floor_um.is_none() {
        // Then what is left with the causes in the model replaces it.
        for _ in 0..2 {
            let left_um = found.left_um().max(resolution_um);
            found = Series::new(posed(Noise::white(left_um)));
        }
        found.noise_floor_um = found.left_um().max(resolution_um);
    }
    // Noise below the last digit is alike for other reasons.
    let correlated = match hidden_um > 0.0 {
        true => None,
        false => alike_neighbours(&found, |noise| {
            let sigma_um = noise.sigma_um.max(resolution_um);
            Series::new(posed(Noise { sigma_um, ..noise }))
        }),
    };
    if let Some(correlated) = correlated {
        found = correlated;
    }
    if found.is_clean() {
        found.levels = levels(&found.plain);
    }
    // Jumps between two levels look like correlated noise, but are none.
    let correlation = found.plain.whitening.correlation;
    if correlation > 0.0 && found.levels.is_none() {
        outcome.notices.push(format!(
            "{name}: errors of neighbouring stops are alike (correlation {correlation:.2}), as in air that stirs; what is stated, and what counts as significant, \
             takes it into account"
        ));
    }
    let periods = found.model.causes.iter().filter(|cause| {
        let effect = found.plain.listed.hypothesis(cause).effect;
        effect.shape == Shape::Period
    });
    let doubts = periods.filter_map(|cause| short_periods::doubt(comparison, cause.shape));
    let notices = doubts.map(|doubt| format!("{name}: {doubt}"));
    outcome.notices.extend(notices);
    // Late time stamps look similar.
    let mut others = found.model.causes.clone();
    others.retain(|cause| !found.plain.listed.hypothesis(cause).effect.is_delay());
    if let Some([size, most]) = beyond_drives(&found.plain, &others) {
        let unit = match comparison.machine.axes()[comparison.axis()].kind() {
            AxisKind::Linear => "µm",
            AxisKind::Rotary => "arcsec",
        };
        outcome.notices.push(format!(
            "{name}: the sides of approach differ by {size:.0} {unit}, and no drive in use loses more than {most:.0} {unit}: see whether \
             deviation_um is in µm, whether direction is the side of approach, and whether the axis stood at its positions"
        ));
    }
    if calibration.is_none() && comparison.line().is_none() && !found.model.wandering.is_empty() {
        outcome.notices.push(format!(
            "{name}: without a calibration what wanders may be what the error curves of the axes do, which is no fault of the model; \
             compare with one (--calibration)"
        ));
    }
    // At one position after the other a cycle is not a period of time.
    if takes_turns(comparison) && differs_by_cycle(&found.plain) {
        outcome.notices.push(format!(
            "{name}: without time_s its rows were taken as a step cycle, position after position from either side in turn, but cycles differ, as those of an axis that went there and back do; then give time_s, or the rows in the order of measuring"
        ));
    }
    let unseen = not_observable(&found.plain);
    // What the mean curve absorbs was sought in the curve itself.
    let is_of_curve =
        |own: &Effect| own.levels.contains(&Level::Components) && !own.is_lost_motion();
    let in_curve = |id: &str| is_explained && effect(id).is_some_and(is_of_curve);
    let unseen = unseen.into_iter().filter(|u| !in_curve(u.effect));
    outcome.not_observable.extend(unseen);
    Some(found)
}

/// Whether the axis of a line came from both sides, but hardly any position was read twice.
fn is_read_elsewhere(comparison: &Comparison<'_>) -> bool {
    let axis = comparison.line();
    axis.is_some_and(|axis| comes_from_both_sides(comparison, axis))
        && 10 * count(&places(comparison)) > 9 * comparison.arrivals.len()
}
