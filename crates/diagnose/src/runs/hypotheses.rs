//! What may make runs differ, and what a unit of it does to their comparison.

use trueaxis_calibrate::{Replay, RunComparison};
use trueaxis_effects::{Effect, ResolvedEffect, Scene, Subject, effect};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_poses::EffectsOnLengths;

use crate::NotObservable;
use crate::engine::{Candidate, Listed, in_words, plausible, unseen};
use crate::selection::{Hypothesis, gram_of};

/// Effects that give one axis another curve in another run. What else changes with time contradicts the lengths
/// themselves.
const EFFECTS: [&str; 2] = ["axis_expansion", "cross_coupling"];

/// Lengths are changed by as much to find what it does to the runs, mm: far above rounding, far below what would
/// leave the linear range.
const STEP_MM: f64 = 10.0 * MICROMETRE;

/// All hypotheses.
pub(super) fn candidates(
    scene: &Scene,
    replay: &Replay<'_>,
    comparisons: &[RunComparison],
    on_lengths: &EffectsOnLengths<'_>,
) -> Vec<Candidate<'static>> {
    let mut responses = replay.responses();
    let rows = comparisons.iter().map(|c| c.observations.len()).sum();
    let mut column = |effect: &'static Effect, subject: Subject, k: usize, count: usize| {
        let mut unit = ResolvedEffect {
            effect,
            subject,
            parameters: vec![0.0; count],
            shape: 0.0,
        };
        unit.parameters[k] = 1.0;
        let of_unit_mm = on_lengths.of(&[unit]);
        let largest_mm = of_unit_mm.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        if largest_mm <= 0.0 {
            return vec![0.0; rows];
        }
        let scale = STEP_MM / largest_mm;
        let used = replay.used_lengths().iter();
        let errors_mm: Vec<f64> = used.map(|&i| scale * of_unit_mm[i]).collect();
        let changes = responses.of_runs_to(comparisons, &errors_mm);
        changes.map_or_else(
            || vec![0.0; rows],
            |changes| changes.concat().iter().map(|x| x / scale).collect(),
        )
    };
    let mut all = Vec::new();
    for effect in EFFECTS.iter().filter_map(|id| effect(id)) {
        let subjects = effect.subjects(scene);
        for &subject in &subjects {
            let count = effect.parameters(scene, &subject).len();
            let columns = (0..count)
                .map(|k| column(effect, subject, k, count))
                .collect();
            let hypothesis = Hypothesis {
                effect,
                subject,
                subjects: subjects.len(),
            };
            all.push(Candidate {
                is_free: false,
                finer: None,
                sizes: Vec::new(),
                columns: vec![columns],
                shapes: vec![0.0],
                plausible: plausible(&hypothesis, scene),
                hypothesis,
            });
        }
    }
    all
}

/// The pairs of axes whose coupling the runs do not show.
pub(super) fn not_observable(scene: &Scene, listed: &Listed) -> Option<NotObservable> {
    let coupling = effect("cross_coupling")?;
    let hidden = listed.candidates.iter().filter(|candidate| {
        let Hypothesis {
            effect, subject, ..
        } = candidate.hypothesis;
        let is_pair = effect.id == coupling.id && subject.component.is_none();
        is_pair && gram_of(&listed.base, &candidate.columns[0]).rank() < candidate.columns[0].len()
    });
    let subjects: Vec<String> = hidden
        .map(|candidate| in_words(&candidate.hypothesis.subject, scene))
        .collect();
    let why = "no axis was measured twice with another one parked elsewhere, so that the curves take all of it, or a part";
    let bias = ("calibration", coupling.explanation.consequence);
    (!subjects.is_empty()).then(|| unseen(coupling, subjects.join("; "), why, bias))
}
