//! A diagnosis in a dozen lines.

use trueaxis_diagnose::{Cause, Diagnosis, LevelReport, Place, Verdict};
use trueaxis_effects::Level;

use crate::diagnose::causes;
use crate::diagnose::layout::labelled;

/// A group whose misfit is so much larger than that of all is worth its name.
const STANDS_OUT: f64 = 1.15;

/// Groups that are named.
const MOST_PLACES: usize = 2;

/// All lines, without notices.
pub(crate) fn lines(diagnosis: &Diagnosis) -> Vec<String> {
    let mut lines = vec![format!("{}: {}", diagnosis.campaign, verdict(diagnosis))];
    for level in &diagnosis.levels {
        lines.extend(off(level, diagnosis));
    }
    let of_level = |level: Level| {
        let causes = diagnosis.causes.iter();
        causes.filter(move |cause| cause.level == level)
    };
    let misfits: Vec<&Cause> = diagnosis
        .causes
        .iter()
        .filter(|cause| cause.level != Level::Components)
        .collect();
    for (k, cause) in misfits.iter().enumerate() {
        lines.push(String::new());
        let rank = (misfits.len() > 1).then_some(k + 1);
        // The calibration was done again without all causes together: told once.
        let first = k == 0 || misfits[k - 1].data != cause.data;
        lines.extend(causes::of_misfit(cause, rank, first, &diagnosis.scene));
        let last_of_level = misfits[k + 1..].iter().all(|c| c.data != cause.data);
        let level = diagnosis.levels.iter().find(|l| l.data == cause.data);
        lines.extend(
            level
                .filter(|_| last_of_level)
                .into_iter()
                .flat_map(causes::gained),
        );
    }
    if let Some(unexplained) = &diagnosis.unexplained {
        lines.push(String::new());
        lines.push(format!(
            "unexplained in {}: {:.2} µm rms",
            unexplained.data, unexplained.rms_um
        ));
        lines.extend(labelled("what", &unexplained.note));
        let to_do = "no known effect explains it: look for what changes like this (air conditioning, \
                     neighbours, the tripod's floor) before the calibration is used";
        lines.extend(labelled("to do", to_do));
    }
    if of_level(Level::Components).next().is_some() {
        lines.push(String::new());
        lines.push("what the error curves consist of (no fault of the model):".to_owned());
        let curves = of_level(Level::Components);
        lines.extend(curves.map(|cause| causes::of_curve(cause, &diagnosis.scene)));
    }
    lines.extend(not_observable(diagnosis));
    lines
}

fn verdict(diagnosis: &Diagnosis) -> String {
    let count = diagnosis
        .causes
        .iter()
        .filter(|cause| cause.level != Level::Components)
        .count();
    match diagnosis.verdict {
        Verdict::Clean if diagnosis.levels.is_empty() => "nothing was judged".to_owned(),
        Verdict::Unknown if count > 0 => {
            format!("the data contradict the model, for {count} cause(s) and something unknown")
        }
        Verdict::Clean => "clean, nothing contradicts the model".to_owned(),
        Verdict::Named | Verdict::Ambiguous if diagnosis.unexplained.is_some() => {
            format!("the data contradict the model, for {count} cause(s) and something more")
        }
        Verdict::Named if count > 1 => format!("the data contradict the model, for {count} causes"),
        Verdict::Named => "the data contradict the model, and the cause is clear".to_owned(),
        Verdict::Ambiguous => {
            "the data contradict the model, and several causes are possible".to_owned()
        }
        Verdict::Unknown => {
            "the data contradict the model, and no known cause explains it".to_owned()
        }
    }
}

/// How far the prediction is off, and where.
fn off(level: &LevelReport, diagnosis: &Diagnosis) -> Vec<String> {
    // What is not explained may be in the scatter of the repeats, too.
    let floor = match diagnosis.unexplained {
        None => "noise alone is",
        Some(_) => "repeats scatter by",
    };
    let mut text = format!(
        "predicted to {:.2} µm rms, {floor} {:.2} µm",
        level.before.rms_um, level.noise_floor_um
    );
    if diagnosis.verdict != Verdict::Clean {
        if level.after.rms_um < level.before.rms_um {
            text += &format!("; with the causes {:.2} µm", level.after.rms_um);
        }
        let places = standing_out(level);
        if !places.is_empty() {
            text += &format!("; worst for {}", places.join(" and "));
        }
    }
    labelled("misfit", &format!("{}: {text}", level.data))
}

/// Where the misfit is largest: the worst group of each kind, if it is far worse than all.
fn standing_out(level: &LevelReport) -> Vec<String> {
    let mut worst: Vec<&Place> = Vec::new();
    for place in &level.places {
        match worst.iter_mut().find(|other| other.by == place.by) {
            Some(other) if place.before_um > other.before_um => *other = place,
            Some(_) => {}
            None => worst.push(place),
        }
    }
    worst.retain(|place| place.before_um > STANDS_OUT * level.before.rms_um);
    worst.sort_by(|a, b| b.before_um.total_cmp(&a.before_um));
    let described = worst.iter().take(MOST_PLACES).map(|place| {
        let what = match place.by {
            "position" => "axis ".to_owned(),
            by => format!("{by} "),
        };
        format!("{what}{} ({:.2} µm)", place.name, place.before_um)
    });
    described.collect()
}

/// One line of names.
fn not_observable(diagnosis: &Diagnosis) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for unseen in &diagnosis.not_observable {
        let name = unseen.effect.replace('_', " ");
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() {
        return Vec::new();
    }
    vec![
        String::new(),
        format!(
            "  not visible in these data, so not ruled out (diagnosis.json says why): {}",
            names.join(", ")
        ),
    ]
}
