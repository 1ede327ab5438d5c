//! Data that cannot be as they stand must never be calibrated silently.
//!
//! What a row says alone: logged states that no workshop has ([`logged`]). What the rows say together: rows
//! that are not in measuring order ([`order`]), repeats that were copied ([`copies`]), lengths that no
//! known dead path leaves positive ([`dead_paths`]). All else here is about units.
//!
//! Measured data are compared with the nominal motion of the machine. Nominal means: within some mm (targets are mounted by hand)
//! and some degrees (of axis directions), so every test is far from what a correct campaign can do. In order:
//!
//! 1. **Lengths that change too much** ([`pairs`]). A target that moves from `p` to `p'` changes its
//!    distance to any fixed station by no more than the triangle inequality allows, wherever the
//!    station is:
//!
//!    ```text
//!    | |p' - S| - |p - S| | <= |p' - p|
//!    ```
//!
//!    Each sweep of a run is judged by the two rows of a target whose lengths differ most. One such
//!    pair may be a typing error or a broken beam, which is the calibration's business and only a
//!    notice here; a unit is wrong for most pairs of a run, or most pairs of a station.
//! 2. **Lengths that change too little** ([`least_spread`]). One station may see next to nothing of a
//!    motion: a rotary table that turns about the line of sight, an axis across the beam. What it cannot
//!    do is see nothing of motions in three directions; the bound proved in [`moments`] holds for
//!    every place of the station. A campaign without three directions is refused only if all its
//!    stations, three or more, see less than a two-hundredth of the motion: they would all stand on
//!    the axis of rotation, or far off across a linear axis, from where nothing can be solved.
//! 3. **Lengths against `approx_mm`** ([`approx`]), where all stations have it: another unit, or
//!    another station's place, must fit twenty times better before anything is said.
//!
//! Points have no free station: the distances of measured points must be the nominal ones, neither more nor less; and
//! those within a stop reveal exchanged names ([`exchanged`]).
//!
//! For data that fail, the usual mistakes ([`hypothesis`]) are tried; the one with which the data
//! pass is named in the error. Positions in another unit explain data only if they are then still
//! within the travel, which tells `X` in metres from `length_mm` in micrometres.

mod approx;
mod copies;
mod dead_paths;
mod exchanged;
mod hypothesis;
mod least_spread;
mod logged;
mod moments;
mod nominal;
mod order;
mod pairs;

pub use hypothesis::UnitMistake;

pub(crate) use copies::check as check_copies;
pub(crate) use order::check as check_order;

use std::path::Path;

use crate::{Campaign, Error, Lengths, Place, Points, Problem};
use hypothesis::Hypothesis;
use nominal::NominalPoints;
use pairs::{Pair, Pairs};

/// Refuses lengths that the nominal machine cannot have caused; returns notices about single rows.
pub(crate) fn check_lengths(
    file: &Path,
    name: &str,
    campaign: &Campaign,
    lengths: &Lengths,
) -> Result<Vec<String>, Error> {
    let given = Hypothesis::as_given(campaign);
    let (nominal, pairs) = rayon::join(
        || NominalPoints::new(campaign, &given),
        || Pairs::of_lengths(lengths, campaign),
    );
    let explains = |hypothesis: &Hypothesis| {
        let nominal = NominalPoints::new(campaign, hypothesis);
        let too_large = pairs.judge(&nominal, hypothesis).is_pervasive();
        !too_large
            && pairs.show_motion(&nominal, hypothesis)
            && least_spread::too_small(lengths, &nominal, hypothesis).is_none()
    };

    let judgement = pairs.judge(&nominal, &given);
    let mut notices = Vec::new();
    if let Some(worst) = judgement.worst {
        let suspects = if judgement.is_pervasive() {
            hypothesis::for_lengths(campaign, &judgement.touched_runs, &judgement.stations)
        } else {
            Vec::new()
        };
        let mistake = suspects.into_iter().find(explains).and_then(|h| h.mistake);
        // A station alone that no unit explains had its interferometer set to zero in a sweep.
        if judgement.runs.is_empty() && mistake.is_none() {
            notices.push(isolated(name, campaign, worst, nominal.distance_mm(worst)));
        } else {
            return Err(Problem::LengthsTooLarge {
                first_line: worst.ends[0].line,
                station: campaign.stations[worst.station].name.clone(),
                target: campaign.targets[worst.ends[1].target].name.clone(),
                change_mm: worst.observed_mm,
                moved_mm: nominal.distance_mm(worst),
                mistake,
            }
            .at(Place::column(file, worst.ends[1].line, "length_mm")));
        }
    }
    // What is too small is said first: its distances mean nothing.
    let (too_small, against_approx) = rayon::join(
        || least_spread::too_small(lengths, &nominal, &given),
        || approx::check(file, campaign, lengths, &nominal),
    );
    if let Some(small) = too_small {
        let runs: Vec<usize> = (0..campaign.runs.len()).collect();
        let suspects = hypothesis::for_lengths(campaign, &runs, &[small.station]);
        return Err(Problem::LengthsTooSmall {
            station: campaign.stations[small.station].name.clone(),
            target: campaign.targets[small.target].name.clone(),
            spread_mm: small.spread_mm,
            least_mm: small.least_mm,
            mistake: suspects.into_iter().find(explains).and_then(|h| h.mistake),
        }
        .at(Place::column(file, small.line, "length_mm")));
    }
    against_approx?;
    notices.extend(dead_paths::check(file, name, campaign, lengths)?);
    notices.extend(logged::notices(name, &lengths.logged));
    Ok(notices)
}

/// Refuses points whose distances are not those of the nominal machine.
pub(crate) fn check_points(
    file: &Path,
    name: &str,
    campaign: &Campaign,
    points: &Points,
) -> Result<Vec<String>, Error> {
    let given = Hypothesis::as_given(campaign);
    let nominal = NominalPoints::new(campaign, &given);
    let pairs = Pairs::of_points(points, campaign, &nominal);
    let judgement = pairs.judge(&nominal, &given);
    let mut notices = exchanged::notices(name, campaign, points, &nominal);
    let Some(worst) = judgement.worst else {
        return Ok(notices);
    };
    let nominal_mm = nominal.distance_mm(worst);
    if judgement.runs.is_empty() {
        // Names that are exchanged say it better.
        if notices.is_empty() {
            notices.push(isolated(name, campaign, worst, nominal_mm));
        }
        return Ok(notices);
    }
    let explains = |hypothesis: &Hypothesis| {
        let nominal = NominalPoints::new(campaign, hypothesis);
        !pairs.judge(&nominal, hypothesis).is_pervasive() && pairs.show_motion(&nominal, hypothesis)
    };
    let suspects = hypothesis::for_points(campaign, &judgement.runs);
    Err(Problem::PointsImpossible {
        first_line: worst.ends[0].line,
        measured_mm: worst.observed_mm,
        nominal_mm,
        mistake: suspects.into_iter().find(explains).and_then(|h| h.mistake),
    }
    .at(Place::line(file, worst.ends[1].line)))
}

/// A notice on rows that contradict the motion while most others do not.
fn isolated(name: &str, campaign: &Campaign, worst: &Pair, nominal_mm: f64) -> String {
    let [first, second] = &worst.ends;
    format!(
        "{name} lines {} and {}: target `{}` is seen to move by {:.3} mm, nominally it moves by \
         {nominal_mm:.3} mm; one of the rows is wrong, or the beam was broken in between",
        first.line, second.line, campaign.targets[second.target].name, worst.observed_mm
    )
}
