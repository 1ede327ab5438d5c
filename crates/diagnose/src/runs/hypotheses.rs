//! Possible causes of a difference between runs, and their effects on the comparison.

use trueaxis_calibrate::{Replay, RunComparison};
use trueaxis_effects::{CROSS_COUPLING, Effect, Level, Scene};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_poses::EffectsOnLengths;
use trueaxis_selection::{Hypothesis, ShapeColumns, gram_of};

use crate::NotObservable;
use crate::engine::linear::{Candidate, Listed};
use crate::engine::{in_words, of_catalogue, plausible, unseen};

/// Change of lengths from which the response of the runs is found, mm: far above rounding, and well within the linear
/// range.
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
    let mut column = |hypothesis: &Hypothesis, k: usize, count: usize| {
        let mut unit = vec![0.0; count];
        unit[k] = 1.0;
        let of_unit_mm = on_lengths.of(&[hypothesis.resolved(unit, 0.0)]);
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
    let all = of_catalogue(Level::Lengths, scene, |_| true).into_iter();
    // Effects that change the curve of an axis between runs: other changes with time contradict the lengths.
    let differs = |by: &Effect| by.grows_axis() || by == CROSS_COUPLING;
    let all = all.filter(|hypothesis| differs(hypothesis.effect));
    let candidate = |hypothesis: Hypothesis| {
        let plausible = plausible(&hypothesis, scene);
        let count = plausible.len();
        let columns = (0..count).map(|k| column(&hypothesis, k, count));
        Candidate {
            is_free: false,
            finer: None,
            sizes: Vec::new(),
            columns: ShapeColumns::new([(0.0, columns.collect())]).into(),
            plausible,
            hypothesis,
        }
    };
    all.map(candidate).collect()
}

/// The pairs of axes whose coupling the runs do not show.
pub(super) fn not_observable(scene: &Scene, listed: &Listed) -> Option<NotObservable> {
    let hidden = listed.candidates.iter().filter(|candidate| {
        let own = &candidate.hypothesis;
        let is_pair = own.effect == CROSS_COUPLING && own.subject.component.is_none();
        let columns = candidate.columns.whole(0);
        is_pair && gram_of(&listed.base, &columns).rank() < columns.len()
    });
    let subjects: Vec<String> = hidden
        .map(|candidate| in_words(&candidate.hypothesis.subject, scene))
        .collect();
    let why = "no axis was measured twice with another one parked elsewhere, so that the curves take all of it, or a part";
    let bias = [("calibration", CROSS_COUPLING.explanation.consequence)];
    (!subjects.is_empty()).then(|| unseen(CROSS_COUPLING, subjects.join("; "), why, bias))
}
