//! The headline verb: from a campaign to a diagnosis.

use trueaxis_calibrate::{Calibration, calibrate_with_adjustment};
use trueaxis_campaign::{Campaign, Lengths, Points};
use trueaxis_effects::{CROSS_COUPLING, Scene};
use trueaxis_poses::{LengthsAdjustment, at_one_temperature};
use trueaxis_predict::{CalibratedMachine, check_same_machine};

use crate::changes::changes;
use crate::components::diagnose_components;
use crate::lengths::{diagnose_lengths, scene};
use crate::numbers::distinct;
use crate::points::diagnose_points;
use crate::runs::{contradicting_runs, diagnose_runs};
use crate::said::Said;
use crate::verification::diagnose_verification;
use crate::{Cause, Diagnosis, Error, Settings, Verdict};

/// Says what the rigid, quasi-static model gets wrong in a campaign's data, why, how a better model looks and what it
/// gains on data that it did not use.
///
/// The levels follow each other: the lengths against the joint adjustment with rigid stages; the verification
/// readings against the prediction of the calibration without the causes found in the lengths; and the parts of the
/// calibrated error curves, which explain the curves but contradict nothing, so the verdict does not depend on them.
///
/// # Errors
/// [`Error`] if the campaign cannot be calibrated or has no data that could contradict.
pub fn diagnose(campaign: &Campaign, settings: &Settings) -> Result<Diagnosis, Error> {
    let measured = campaign.lengths.is_some() || campaign.points.is_some();
    let is_read = !campaign.verification.is_empty() || !campaign.point_checks.is_empty();
    if !is_read && !measured {
        return Err(Error::NothingMeasured);
    }
    let campaign = &*at_one_temperature(campaign);
    let mut diagnosis = Diagnosis::new(campaign);
    let mut adjustment = None;
    if measured {
        match calibrated(campaign, settings, &mut diagnosis.notices) {
            Ok((calibration, of_lengths)) => {
                diagnosis.calibration = Some(calibration);
                adjustment = of_lengths;
            }
            // Points that do not determine a pose may still contradict each other.
            Err(error) if campaign.lengths.is_none() && is_not_identifiable(&error) => {
                diagnosis.notices.push(format!("not calibrated: {error}"));
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(lengths) = &campaign.lengths {
        let said = diagnose_lengths(campaign, lengths, adjustment.as_ref())?;
        let corrected = with_lengths(&mut diagnosis, campaign, lengths, said, settings);
        with_runs(&mut diagnosis, campaign, corrected.as_ref(), settings)?;
    } else if let Some(points) = &campaign.points {
        with_points(&mut diagnosis, campaign, points, settings)?;
    }
    let calibration = diagnosis.calibration.as_ref();
    let predicts = calibration.map(Calibration::calibrated_machine);
    with_verification(&mut diagnosis, campaign, predicts.as_ref(), settings);
    let curves = diagnosis.calibration.as_ref();
    if let Some(calibration) = curves.filter(|_| settings.explain_curves) {
        diagnosis.take(diagnose_components(calibration, &campaign.machine));
    }
    if diagnosis.levels.is_empty() && diagnosis.notices.is_empty() {
        let why = "nothing was judged: there is nothing that could contradict the model";
        diagnosis.notices.push(why.to_owned());
    }
    Ok(diagnosis)
}

/// Says what the verification readings of a campaign contradict in an existing calibration, perhaps of another
/// system. Other data of the campaign are ignored.
///
/// # Errors
/// [`Error::OtherMachine`] if the calibration is of another machine, [`Error::NothingRead`] without readings.
pub fn diagnose_against(
    campaign: &Campaign,
    calibration: &CalibratedMachine,
    settings: &Settings,
) -> Result<Diagnosis, Error> {
    check_same_machine(calibration.machine(), &campaign.machine)?;
    if campaign.verification.is_empty() && campaign.point_checks.is_empty() {
        return Err(Error::NothingRead);
    }
    let mut diagnosis = Diagnosis::new(campaign);
    diagnosis.notices.push(format!(
        "the readings are judged against the calibration `{}` that was given",
        calibration.campaign
    ));
    if campaign.lengths.is_some() || campaign.points.is_some() {
        diagnosis.notices.push(
            "what the campaign measured itself (lengths, points) was not looked at: diagnose it without --calibration"
                .to_owned(),
        );
    }
    with_verification(&mut diagnosis, campaign, Some(calibration), settings);
    Ok(diagnosis)
}

/// Adds the findings of the verification readings.
fn with_verification(
    diagnosis: &mut Diagnosis,
    campaign: &Campaign,
    calibration: Option<&CalibratedMachine>,
    settings: &Settings,
) {
    for check in &campaign.point_checks {
        diagnosis.notices.push(format!(
            "{}: point checks are not judged here; `trueaxis verify` compares them with the prediction",
            check.name
        ));
    }
    let said = diagnose_verification(
        campaign,
        calibration,
        &diagnosis.scene,
        settings.explain_curves,
    );
    diagnosis.take(said);
}

impl Diagnosis {
    /// A diagnosis before any judgement.
    fn new(campaign: &Campaign) -> Self {
        Self {
            campaign: campaign.name.clone(),
            scene: scene_of_all(campaign),
            verdict: Verdict::NotJudged,
            levels: Vec::new(),
            causes: Vec::new(),
            disturbances: Vec::new(),
            unexplained: None,
            rejected: Vec::new(),
            not_observable: Vec::new(),
            calibration: None,
            notices: Vec::new(),
        }
    }
}

/// Adds the findings of the lengths, and the calibration without the causes found; returns the campaign without them,
/// if there are any.
fn with_lengths(
    diagnosis: &mut Diagnosis,
    campaign: &Campaign,
    lengths: &Lengths,
    (mut said, effects_mm): (Said, Vec<f64>),
    settings: &Settings,
) -> Option<Campaign> {
    let mut without = None;
    for entry in &mut said.entries {
        let causes = &mut entry.causes;
        if !causes.iter().all(Cause::is_seen_whole) {
            diagnosis.notices.push(
                "a cause is seen in part only: the data do not say what it changes in the calibration, and it \
                 is not in effects.json"
                    .to_owned(),
            );
        } else if !causes.is_empty() || !entry.disturbances.is_empty() {
            let corrected = without_effects(campaign, lengths, &effects_mm);
            if with_better(diagnosis, &corrected, causes, settings) {
                without = Some(corrected);
            }
            if !entry.disturbances.is_empty() {
                diagnosis.notices.push(not_in_effects(causes).to_owned());
            }
        }
        if entry.report.unexplained.is_some() && !causes.is_empty() {
            diagnosis.notices.push(
                "something is left beside the cause: its size may be off by more than its uncertainty, and what \
                 it changes in the calibration is not all"
                    .to_owned(),
            );
        }
    }
    diagnosis.take(said);
    without
}

/// Adds the findings of the points, and the calibration without the causes and gross errors found.
fn with_points(
    diagnosis: &mut Diagnosis,
    campaign: &Campaign,
    points: &Points,
    settings: &Settings,
) -> Result<(), Error> {
    let (mut said, corrected) = diagnose_points(campaign, points, &diagnosis.scene)?;
    if let (Some(corrected), Some(_)) = (&corrected, &diagnosis.calibration) {
        for entry in &mut said.entries {
            with_better(diagnosis, corrected, &mut entry.causes, settings);
        }
    }
    said.entries
        .extend(diagnosis.calibration.as_ref().and_then(contradicting_runs));
    diagnosis.take(said);
    Ok(())
}

/// The notice about disturbances of the lengths that `calibrate --with-effects` does not remove.
fn not_in_effects(causes: &[Cause]) -> &'static str {
    match causes.is_empty() {
        true => {
            "what wanders has no formula, so that there is no effects.json: `calibrate --with-effects` cannot take it out"
        }
        false => {
            "what wanders has no formula and is not in effects.json: `calibrate --with-effects` takes out the causes \
             only, while the changes of the calibration said here are those without both"
        }
    }
}

/// Whether an error says that the data do not determine the poses.
fn is_not_identifiable(error: &Error) -> bool {
    use trueaxis_calibrate::Error as Calibrate;
    matches!(
        error,
        Error::Calibrate(Calibrate::Poses(
            trueaxis_poses::Error::NotIdentifiable { .. }
        ))
    )
}

/// Replaces the calibration by that without the causes, which it lists, and adds the changes to the causes; a notice
/// says so if there is none, and the calibration stays.
fn with_better(
    diagnosis: &mut Diagnosis,
    corrected: &Campaign,
    causes: &mut [Cause],
    settings: &Settings,
) -> bool {
    let mut better = match calibrated(corrected, settings, &mut diagnosis.notices) {
        Ok((better, _)) => better,
        Err(error) => {
            let text = format!(
                "the calibration is that of the data as they are: without the causes, {error}"
            );
            diagnosis.notices.push(text);
            return false;
        }
    };
    for cause in causes {
        if let Some(calibration) = &diagnosis.calibration {
            cause.changes = changes(calibration, &better);
        }
        let taken_out = cause.effect.to_given(&diagnosis.scene);
        better.effects.push(taken_out);
    }
    if let Some(calibration) = diagnosis.calibration.take() {
        better.effects.extend(calibration.effects);
    }
    diagnosis.calibration = Some(better);
    true
}

/// Adds the contradictions between runs of one axis, and the calibration without their causes. `corrected` is the
/// campaign without the causes of the lengths, where they could be taken out.
fn with_runs(
    diagnosis: &mut Diagnosis,
    campaign: &Campaign,
    corrected: Option<&Campaign>,
    settings: &Settings,
) -> Result<(), Error> {
    // A cause that is still in the lengths makes runs differ, too.
    let may_be_named = diagnosis.causes.is_empty() || corrected.is_some();
    let campaign = corrected.unwrap_or(campaign);
    let said = diagnose_runs(campaign, &diagnosis.scene, settings, may_be_named)?;
    let Some((mut said, corrected)) = said else {
        return Ok(());
    };
    if let Some(corrected) = &corrected {
        for entry in &mut said.entries {
            with_better(diagnosis, corrected, &mut entry.causes, settings);
        }
    }
    diagnosis
        .not_observable
        .retain(|unseen| unseen.effect != CROSS_COUPLING.id);
    diagnosis.take(said);
    Ok(())
}

/// Stations, targets, and the axes that move in any of the data.
fn scene_of_all(campaign: &Campaign) -> Scene {
    let mut scene = scene(campaign);
    let moves = |&axis: &usize| {
        campaign.verification.iter().any(|verification| {
            let mut positions = verification.readings.iter().map(|r| r.positions[axis]);
            let first = positions.next();
            positions.any(|position| Some(position) != first)
        })
    };
    let read = (0..campaign.machine.axes().len()).filter(moves);
    scene.moving = distinct(read.chain(scene.moving));
    scene
}

/// A calibration even of data that screening refuses, since a diagnosis asks what is wrong with them. A notice says
/// what had to be given up.
fn calibrated<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
    notices: &mut Vec<String>,
) -> Result<(Calibration, Option<LengthsAdjustment<'a>>), Error> {
    let wanted = settings.calibration;
    let refused = match calibrate_with_adjustment(campaign, &wanted) {
        Err(error) if wanted.poses.robust => error,
        calibrated => return calibrated.map_err(Error::Calibrate),
    };
    let [mut concentrated, mut with_all] = [wanted; 2];
    concentrated.poses.asks_why = true;
    with_all.poses.robust = false;
    let without_some = "calibrated without lengths that contradict the others, although";
    let with_each = "calibrated with all lengths at full weight, since otherwise";
    let mut ways = [(concentrated, without_some), (with_all, with_each)].into_iter();
    let found =
        ways.find_map(|(way, how)| Some((calibrate_with_adjustment(campaign, &way).ok()?, how)));
    let Some((calibrated, how)) = found else {
        return Err(Error::Calibrate(refused.of_a_diagnosis()));
    };
    let notice = format!("{how}: {}", refused.what());
    if !notices.contains(&notice) {
        notices.push(notice);
    }
    Ok(calibrated)
}

/// The campaign with its lengths less the effects of the causes.
fn without_effects(campaign: &Campaign, lengths: &Lengths, effects_mm: &[f64]) -> Campaign {
    let mut corrected = lengths.clone();
    for (reading, effect_mm) in corrected.readings.iter_mut().zip(effects_mm) {
        reading.length_mm -= effect_mm;
    }
    Campaign {
        lengths: Some(corrected),
        ..campaign.clone()
    }
}
