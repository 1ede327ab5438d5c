//! What the uncertainties contain, and what they lack.
//!
//! [`parts`] has one entry for each possible part of U; new parts belong there.

use trueaxis_campaign::{Campaign, Stop};
use trueaxis_poses::{LengthsAdjustment, MeasuredPoses, ScaleBasis, step_in_words};

use crate::result::calibration::UncertaintyStatement;

/// A part of U: its name where U contains it, or why it does not.
type Part = Result<String, String>;

/// What the uncertainties of a calibration contain.
pub(crate) fn statement(campaign: &Campaign, measured: &MeasuredPoses<'_>) -> UncertaintyStatement {
    let mut statement = UncertaintyStatement::default();
    for part in parts(campaign, measured) {
        match part {
            Ok(contained) => statement.contains.push(contained),
            Err(lacking) => statement.lacks.push(lacking),
        }
    }
    statement
}

/// All parts that concern the campaign, in the order in which they are stated.
fn parts(campaign: &Campaign, measured: &MeasuredPoses<'_>) -> Vec<Part> {
    let mut parts: Vec<Part> = vec![Ok("noise and geometry".to_owned())];
    // A single reflector has no differences.
    let several = measured.of_lengths(LengthsAdjustment::reflectors).len() > 1;
    parts.extend(several.then(|| Ok("reflectors".to_owned())));
    let dead_paths = campaign.stations.iter().any(|s| s.dead_path.is_some());
    let take_part = measured.lengths.is_some() && dead_paths;
    parts.extend(take_part.then(|| Ok("known dead paths".to_owned())));
    parts.push(scale(campaign, measured));
    parts.push(nests(campaign));
    parts.extend(temperatures(campaign));
    parts.extend(repeatability(campaign, measured));
    parts.extend(off_steps(campaign, measured));
    parts
}

/// A parked axis has the errors of its curve, between its steps and beyond them. No length shows how its errors
/// continue there, nor their effect on the location of the axis that moves.
fn off_steps(campaign: &Campaign, measured: &MeasuredPoses<'_>) -> Vec<Part> {
    let poses = &measured.poses;
    let mut steps: Vec<Vec<f64>> = vec![Vec::new(); campaign.machine.axes().len()];
    for pose in &poses.observations {
        let step = &campaign.steps[pose.step];
        if let Some(axis) = step.run.map(|run| campaign.runs[run].axis) {
            steps[axis].push(step.positions[axis]);
        }
    }
    let all = steps.iter_mut();
    all.for_each(|own| own.sort_unstable_by(f64::total_cmp));
    let first = |what: &str, said: &str, is_off: fn(&[f64], f64) -> bool| -> Option<Part> {
        let (step, axis) = poses.observations.iter().find_map(|pose| {
            let carriers = poses.bodies[pose.body].targets.iter();
            let mut axes =
                carriers.flat_map(|&t| campaign.machine.chain(campaign.targets[t].carrier));
            let position = |axis: usize| campaign.steps[pose.step].positions[axis];
            let off = axes.find(|&&axis| is_off(&steps[axis], position(axis)))?;
            Some((pose.step, *off))
        })?;
        let name = campaign.machine.axes()[axis].name();
        let place = step_in_words(campaign, step);
        Some(Err(format!("{what}: {place}, {name} stood {said}")))
    };
    let found = [
        first(
            "errors of axes beyond their steps",
            "where it was not measured",
            is_beyond,
        ),
        first(
            "errors of parked axes between their steps",
            "between two of its steps, whose errors are interpolated",
            is_between,
        ),
    ];
    let mut found: Vec<Part> = found.into_iter().flatten().collect();
    let measured = campaign.machine.axes().iter().zip(&steps);
    let homeless: Vec<&str> = measured
        .filter(|(_, own)| is_beyond(own, 0.0))
        .map(|(axis, _)| axis.name())
        .collect();
    if !homeless.is_empty() {
        found.push(Err(format!(
            "way from home to the steps of {}: all their errors are relative to the step next to home",
            homeless.join(", ")
        )));
    }
    found
}

/// Whether a position lies outside some steps (ascending).
fn is_beyond(steps: &[f64], position: f64) -> bool {
    let ends = steps.first().zip(steps.last());
    ends.is_some_and(|(low, high)| position < *low || position > *high)
}

/// Share of the distance between two steps within which a position counts as at a step.
const AT_STEP: f64 = 0.02;

/// Whether a position lies between two steps (ascending), not at one of them.
fn is_between(steps: &[f64], position: f64) -> bool {
    let above = steps.partition_point(|step| *step < position);
    let gap = above.checked_sub(1).map(|k| steps[k]).zip(steps.get(above));
    gap.is_some_and(|(low, high)| (position - low).min(high - position) > AT_STEP * (high - low))
}

/// For points: residuals of one visit show the instrument, but not how the machine returns. Lengths show it, from
/// several stations or repeats.
fn repeatability(campaign: &Campaign, measured: &MeasuredPoses<'_>) -> Option<Part> {
    let points = campaign.points.as_ref()?;
    let poses = &measured.poses.observations;
    let by_direction = poses.iter().any(|pose| pose.direction.is_some());
    let visits = points.stops.iter();
    let place = |s: &Stop| (s.step, by_direction.then(|| s.direction.sign()));
    let mut visits: Vec<_> = visits.map(place).collect();
    visits.sort_unstable();
    let is_repeated = visits.windows(2).any(|pair| pair[0] == pair[1]);
    let is_open = campaign.instrument.repeatability_um.is_none() && !is_repeated;
    is_open.then(|| {
        Err("repeatability of the machine: `repeatability_um` is not declared, and no position was visited twice".to_owned())
    })
}

/// The nests of the targets, to which location errors are relative.
fn nests(campaign: &Campaign) -> Part {
    // Targets on the bed do not enter the frame.
    let mut carried = campaign.targets.iter().filter(|t| t.carrier.is_some());
    let open = carried.any(|t| t.position_sigma_mm.is_none());
    match open {
        true => Err("nests of the targets: `position_sigma_mm` is not declared".to_owned()),
        false => Ok("nests of the targets".to_owned()),
    }
}

/// The temperatures of the axes that are referred to 20 °C.
fn temperatures(campaign: &Campaign) -> Option<Part> {
    let expansions = &campaign.expansions;
    let open = expansions.iter().any(|e| e.temperature_sigma_k.is_none());
    (!expansions.is_empty()).then(|| match open {
        true => Err("temperature of the axes: `temperature_sigma_k` is not declared".to_owned()),
        false => Ok("temperature of the axes".to_owned()),
    })
}

fn scale(campaign: &Campaign, measured: &MeasuredPoses<'_>) -> Part {
    let declared = campaign.instrument.scale_sigma_ppm.is_some();
    let scale = measured.of_lengths(LengthsAdjustment::scale);
    let part = match (scale.map(|scale| scale.basis), &measured.lengths) {
        (Some(ScaleBasis::Declared), _) => Ok("scale of the instrument"),
        (Some(ScaleBasis::KnownLengths | ScaleBasis::Both), _) => Ok("scale by known lengths"),
        (None, None) if declared => Ok("scale of the instrument"),
        (None, Some(_)) => Err("neither `scale_sigma_ppm` nor `known_lengths` is declared"),
        (None, None) => Err("`scale_sigma_ppm` is not declared"),
    };
    let lacking = |why| format!("scale of the instrument: {why}");
    part.map(str::to_owned).map_err(lacking)
}
