//! Report of the diagnosis of points, with units.

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, Points};
use trueaxis_effects::{Level, ResolvedEffect, Scene};

use crate::Error;
use crate::engine::{
    Findings, Omnibus, Suspect, Wanders, add_rival_disturbances, is_tested, left_out_in_words,
    of_catalogue, rms, unexplained, wandered_mm,
};
use crate::points::base::Base;
use crate::points::believed::{Believed, suspects};
use crate::points::doubted::doubted;
use crate::points::fitted::fitted;
use crate::points::gross_errors::Gross;
use crate::points::model::Model;
use crate::points::not_observable::not_observable;
use crate::points::omnibus::{families, omnibus};
use crate::points::places::places;
use crate::points::screened::{Screened, without};
use crate::said::Said;

/// Fewest degrees of freedom for a judgement.
const LEAST_DEGREES_OF_FREEDOM: f64 = 8.0;

/// Best resolution of an instrument, µm: what is left of points made without noise is rounding.
const RESOLUTION_UM: f64 = 1e-3;

/// Finds what the points contradict in the rigid, quasi-static model, and why; also returns the campaign without
/// gross errors and effects of causes, if there are any.
pub(crate) fn diagnose_points(
    campaign: &Campaign,
    points: &Points,
    scene: &Scene,
) -> Result<(Said, Option<Campaign>), Error> {
    let mut screened = Screened::beside(campaign, points, scene, &[]);
    let plain = Model::estimated(&screened.base, &[]);
    let freedom = plain.projection.degrees_of_freedom;
    if freedom < LEAST_DEGREES_OF_FREEDOM {
        return Ok((not_judged(&screened.base, freedom), None));
    }
    if plain.noise.mean_um(&screened.base.readings) < RESOLUTION_UM {
        let base = screened.base.clone();
        return said(&screened, points, Believed::nothing(base, plain));
    }
    let all = of_catalogue(Level::Points, scene, |s| is_tested(campaign, s));
    let mut believed = Believed::search(&screened, plain, &all)?;
    if !believed.found().is_empty() {
        // A point that stood out may have been part of a cause, or hidden by one.
        let again = Screened::beside_any(campaign, points, scene, suspects(believed.found()));
        if again.numbers() != screened.numbers() {
            let plain = Model::estimated(&again.base, &[]);
            believed = Believed::search(&again, plain, &all)?;
        }
        screened = again;
    }
    add_rival_disturbances(&mut believed.competed)?;
    said(&screened, points, believed)
}

fn not_judged(base: &Base<'_>, freedom: f64) -> Said {
    let text = format!(
        "{} points leave {freedom:.0} degrees of freedom beside a pose for each step, at least {LEAST_DEGREES_OF_FREEDOM:.0} are needed: measure \
         every step twice or from both sides, or three targets on the stage",
        base.readings.all.len()
    );
    Said {
        notices: vec![text],
        ..Said::default()
    }
}

/// The report of a model with the causes.
fn said(
    screened: &Screened<'_>,
    points: &Points,
    believed: Believed<'_>,
) -> Result<(Said, Option<Campaign>), Error> {
    let (gross, competed, after) = (&screened.gross, believed.competed, believed.after);
    let (base, model) = (&competed.base, &competed.search.adjusted);
    // Both models in the final noise.
    let sharp = Model::with(&base.beside(Vec::new()), &[], model.noise, None);
    let noise_um = model.noise.mean_um(&base.readings);
    // Rounding is neither tested nor doubted.
    let (before, doubted) = match after.is_empty() {
        true => (Vec::new(), None),
        false => (
            omnibus(&sharp, &families(base, &sharp)),
            doubted(base, model, noise_um, screened.are_many),
        ),
    };
    let is_left = after.iter().any(Omnibus::is_clear);
    let after_um = noise_um * rms(&model.projection);
    let left = || unexplained(Level::Points, &model.projection, &after, after_um);
    let unexplained = doubted.or_else(|| is_left.then(left));
    let findings = Findings {
        level: Level::Points,
        data: format!("{} points", base.readings.all.len()),
        competed: &competed,
        sharp: &sharp,
        noise_um,
        floor_um: noise_um,
        heldout: believed.heldout,
        stations_out: None,
        tests: [before, after],
        unexplained,
        left: &model.projection,
        places: &|misfits| places(base, misfits),
    };
    let entry = findings.entry(|suspect| {
        let effect_um = rms_of_effect_um(base, suspect);
        Ok((effect_um, fitted(base, model, suspect)?))
    })?;
    let found = competed.search.found.iter();
    let effects: Vec<ResolvedEffect> = found.map(|f| f.suspect.resolved()).collect();
    let is_changed = !competed.is_plain() || !gross.is_empty();
    let wandered_mm = wandered_mm(base, model, None);
    let corrected = is_changed.then(|| corrected(screened, points, &effects, &wandered_mm));
    let said = Said {
        entries: vec![entry],
        not_observable: not_observable(base, &sharp),
        notices: notices(screened),
        rejected: gross.iter().flat_map(Gross::rejected).collect(),
        ..Said::default()
    };
    Ok((said, corrected))
}

/// Rms of the effect of a cause on the coordinates, µm.
fn rms_of_effect_um(base: &Base<'_>, suspect: &Suspect) -> f64 {
    let effect = [suspect.resolved()];
    let moved_mm = (0..base.readings.all.len()).map(|i| base.effect_mm(i, &effect));
    let squares: f64 = moved_mm.map(|moved_mm| moved_mm.norm_squared()).sum();
    (squares / base.misfit_mm.len() as f64).sqrt() * 1e3
}

fn notices(screened: &Screened<'_>) -> Vec<String> {
    let (base, gross) = (&screened.base, &screened.gross);
    let mut notices = Vec::new();
    if !gross.is_empty() {
        let points = gross.iter().flat_map(Gross::rejected);
        let words = left_out_in_words("point", points.map(|point| point.row));
        notices.push(format!("points.csv: {words}"));
    }
    if screened.are_many {
        notices.push(
            "points that look like gross errors are too many, or too close together, to be left out as accidents: they \
             are in the misfit"
                .to_owned(),
        );
    }
    notices.extend(screened.uneven.iter().map(|&target| {
        format!(
            "target {}: its points scatter more than those of the others and weigh less here: a loose nest, a beam that \
             meets it askew, or, far from a rotary axis, how that axis returns",
            base.scene.targets[target].name
        )
    }));
    let elapsed = base.readings.all.iter().map(|r| r.elapsed_s);
    if elapsed.fold(0.0, f64::max) <= 0.0 {
        notices.push(
            "all points have the same time_s: nothing that changes with time can be found; give times"
                .to_owned(),
        );
    }
    notices
}

/// The campaign without gross errors and without the effects of causes and disturbances (`wandered`: rows, mm).
fn corrected(
    screened: &Screened<'_>,
    points: &Points,
    effects: &[ResolvedEffect],
    wandered_mm: &[f64],
) -> Campaign {
    let base = &screened.base;
    let mut moved_mm = vec![Vector3::zeros(); points.readings.len()];
    for (i, reading) in base.readings.all.iter().enumerate() {
        let wandered_mm = base.of_rows(i, &wandered_mm[3 * i..3 * i + 3]);
        moved_mm[reading.number] = base.effect_mm(i, effects) + wandered_mm;
    }
    let mut moved = points.clone();
    for (reading, moved_mm) in moved.readings.iter_mut().zip(moved_mm) {
        reading.position_mm -= moved_mm;
    }
    Campaign {
        points: Some(without(&moved, &screened.numbers())),
        ..base.campaign.clone()
    }
}
