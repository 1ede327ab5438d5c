//! What the points say, in words and units.

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, Points};
use trueaxis_effects::{Level, ResolvedEffect, Scene};

use crate::engine::{
    Found, HeldOut, Measured, OMNIBUS_LEVEL, Omnibus, Search, Suspect, cause, find_causes,
    is_imitation, of_catalogue, scans, still_left, unexplained,
};
use crate::points::base::Base;
use crate::points::fitted::fitted;
use crate::points::gross_errors::{Gross, are_accidents, stand_out};
use crate::points::held_out::held_out;
use crate::points::model::Model;
use crate::points::not_observable::not_observable;
use crate::points::omnibus::{families, omnibus};
use crate::points::places::places;
use crate::said::{Entry, Said};
use crate::selection::{Fit, Hypothesis, Null};
use crate::{Error, LevelReport, Misfit, Shares};

/// Degrees of freedom below which nothing can be said.
const LEAST_DEGREES_OF_FREEDOM: f64 = 8.0;

/// No instrument resolves less, µm: what is left of points that were made without noise is rounding.
const RESOLUTION_UM: f64 = 1e-3;

/// Finds what the points contradict in the rigid, quasi-static model, and why; with the campaign without gross errors
/// and without what the causes do, if there is either.
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
        return said(&screened, points, Believed::nothing(plain));
    }
    let all = of_catalogue(Level::Points, scene, |_| true);
    let mut search = searched(&screened.base, plain, &all)?;
    if !search.found.is_empty() {
        // What stood out of everything may have been a part of a cause, or have hidden beneath it.
        let again = Screened::beside(campaign, points, scene, &suspects(&search.found));
        if again.numbers() != screened.numbers() {
            let plain = Model::estimated(&again.base, &[]);
            search = searched(&again.base, plain, &all)?;
        }
        screened = again;
    }
    let believed = Believed::of(&screened.base, search)?;
    said(&screened, points, believed)
}

/// The causes of what `plain`, the model without any, leaves.
fn searched(base: &Base<'_>, plain: Model, all: &[Hypothesis]) -> Result<Search<Model>, Error> {
    let first = scans(base, &plain, &plain.projection, all).scans;
    let null = Null::simulated(&plain.projection, &first);
    find_causes(base, plain, all, &first, &null)
}

fn suspects(found: &[Found]) -> Vec<Suspect> {
    found.iter().map(|f| f.suspect.clone()).collect()
}

/// The points without gross errors.
struct Screened<'a> {
    base: Base<'a>,
    gross: Vec<Gross>,
    /// Whether there are too many, or several in a row: then none is left out.
    are_many: bool,
}

impl<'a> Screened<'a> {
    /// Beside causes.
    fn beside(
        campaign: &'a Campaign,
        points: &Points,
        scene: &'a Scene,
        causes: &[Suspect],
    ) -> Self {
        let mut gross: Vec<Gross> = Vec::new();
        loop {
            let mut removed: Vec<usize> = gross.iter().map(|g| g.number).collect();
            removed.sort_unstable();
            let base = Base::new(campaign, scene, points, &removed);
            let model = Model::estimated(&base, &base.columns_of(causes));
            let next = stand_out(&base, &model);
            let are_many = !are_accidents(&[&gross[..], &next[..]].concat(), &base, points);
            if are_many {
                gross.clear();
            }
            if next.is_empty() || are_many {
                gross.sort_by_key(|g| g.number);
                return Self {
                    base: match are_many {
                        true => Base::new(campaign, scene, points, &[]),
                        false => base,
                    },
                    gross,
                    are_many,
                };
            }
            gross.extend(next);
        }
    }

    fn numbers(&self) -> Vec<usize> {
        self.gross.iter().map(|g| g.number).collect()
    }
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

/// The causes that are believed, and what the model with them leaves and gains.
struct Believed {
    found: Vec<Found>,
    model: Model,
    after: Vec<Omnibus>,
    heldout: Option<HeldOut>,
}

impl Believed {
    /// No causes, and nothing tested.
    fn nothing(model: Model) -> Self {
        Self {
            found: Vec::new(),
            model,
            after: Vec::new(),
            heldout: None,
        }
    }

    /// The causes of a search but those that predict unused points worse than nothing, or merely imitate what is left.
    fn of(base: &Base<'_>, search: Search<Model>) -> Result<Self, Error> {
        let Search {
            mut found,
            adjusted: mut model,
            ..
        } = search;
        loop {
            let count = found.len();
            let families = families(base, &model);
            let after = omnibus(&model, &families);
            let left = still_left(&families, &after, OMNIBUS_LEVEL, |t| t.excess);
            let is_one = |cause: &Found| {
                let Suspect {
                    hypothesis, shape, ..
                } = &cause.suspect;
                let columns = base.columns(&model)(hypothesis, *shape);
                let fit = Fit::new(&model.bare, &columns);
                is_imitation(&model.bare, &fit, hypothesis.is_of_time(), &left)
            };
            // What was found beside an imitation goes with it.
            let first = found.iter().position(is_one);
            found.truncate(first.unwrap_or(count));
            if found.len() == count {
                let heldout = match found.is_empty() {
                    true => None,
                    false => held_out(base, &model, &suspects(&found)),
                };
                if heldout.is_none_or(|h| !h.is_loss()) {
                    return Ok(Self {
                        found,
                        model,
                        after,
                        heldout,
                    });
                }
                found.clear();
            }
            model = base.refit(suspects(&found))?;
            for (found, suspect) in found.iter_mut().zip(&model.suspects) {
                found.suspect = suspect.clone();
            }
        }
    }
}

/// All of it, of a model with the causes.
fn said(
    screened: &Screened<'_>,
    points: &Points,
    believed: Believed,
) -> Result<(Said, Option<Campaign>), Error> {
    let (base, gross) = (&screened.base, &screened.gross);
    let Believed {
        found,
        model,
        after,
        heldout,
    } = believed;
    // Both in the noise that is left at the end.
    let sharp = Model::with(base, &[], model.noise, None);
    let noise_um = model.noise.mean_um(&base.readings);
    let (before_um, after_um) = (
        noise_um * Model::rms(&sharp.projection),
        noise_um * Model::rms(&model.projection),
    );
    // What is only rounding is not tested.
    let before = match after.is_empty() {
        true => Vec::new(),
        false => omnibus(&sharp, &families(base, &sharp)),
    };
    let is_left = after.iter().any(Omnibus::is_clear);
    let left = || unexplained(Level::Points, &model.projection, &after, after_um);
    let unexplained = is_left.then(left);
    let gain = heldout.map(|h| h.gain(before_um, after_um, noise_um));
    let of_cause = base.columns(&sharp);
    let columns = model
        .suspects
        .iter()
        .map(|s| of_cause(&s.hypothesis, s.shape));
    let columns: Vec<Vec<Vec<f64>>> = columns.collect();
    let misfit = |rms_um: f64, of: fn(&HeldOut) -> f64| Misfit {
        rms_um,
        heldout_rms_um: heldout.as_ref().map(|h| of(h) * noise_um),
    };
    let tests = |all: Vec<Omnibus>| all.into_iter().map(|t| t.test).collect();
    let report = LevelReport {
        level: Level::Points,
        data: format!("{} points", base.readings.all.len()),
        noise_floor_um: noise_um,
        before: misfit(before_um, |h| h.before),
        after: misfit(after_um, |h| h.after),
        gain,
        shares: Shares::new(&sharp.projection, &columns, is_left),
        unexplained,
        tests: tests(before),
        tests_after: tests(after),
        places: places(base, &sharp, &model, noise_um),
    };
    let gain = gain.filter(|_| found.len() == 1);
    let effects: Vec<ResolvedEffect> = found.iter().map(|f| f.suspect.resolved()).collect();
    let causes = found.into_iter().map(|found| {
        let effect_um = rms_of_effect_um(base, &found.suspect);
        let shown = (effect_um, fitted(base, &model, &found.suspect)?);
        Ok(cause(base, Level::Points, &model, found, gain, shown))
    });
    let causes = causes.collect::<Result<_, Error>>()?;
    let corrected = (!effects.is_empty() || !gross.is_empty())
        .then(|| corrected(base, points, gross, &effects));
    let entry = Entry {
        report,
        causes,
        disturbances: Vec::new(),
    };
    let said = Said {
        entries: vec![entry],
        not_observable: not_observable(base, &sharp),
        notices: notices(screened),
        rejected: gross.iter().map(Gross::rejected).collect(),
        ..Said::default()
    };
    Ok((said, corrected))
}

/// Rms of what a cause does to the coordinates, µm.
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
        let lines: Vec<String> = gross.iter().map(|g| g.line.to_string()).collect();
        notices.push(format!(
            "points.csv: {} point(s) contradict all others and were left out: line(s) {}",
            lines.len(),
            lines.join(", ")
        ));
    }
    if screened.are_many {
        notices.push(
            "points that look like gross errors are too many, or too close together, to be left out as accidents: they \
             are in the misfit"
                .to_owned(),
        );
    }
    let elapsed = base.readings.all.iter().map(|r| r.elapsed_s);
    if elapsed.fold(0.0, f64::max) <= 0.0 {
        notices.push(
            "all points have the same time_s: nothing that changes with time can be told; give times"
                .to_owned(),
        );
    }
    notices
}

/// The campaign without gross errors and without what the causes do to the coordinates.
fn corrected(
    base: &Base<'_>,
    points: &Points,
    gross: &[Gross],
    effects: &[ResolvedEffect],
) -> Campaign {
    let mut moved_mm = vec![Vector3::zeros(); points.readings.len()];
    for (i, reading) in base.readings.all.iter().enumerate() {
        moved_mm[reading.number] = base.effect_mm(i, effects);
    }
    let is_kept = |number: &usize| gross.iter().all(|g| g.number != *number);
    let mut kept = Points::default();
    for stop in &points.stops {
        let first = kept.readings.len();
        for number in stop.readings.clone().filter(is_kept) {
            let mut reading = points.readings[number].clone();
            reading.position_mm -= moved_mm[number];
            kept.readings.push(reading);
        }
        if kept.readings.len() > first {
            let mut stop = stop.clone();
            stop.readings = first..kept.readings.len();
            kept.stops.push(stop);
        }
    }
    Campaign {
        points: Some(kept),
        ..base.campaign.clone()
    }
}
