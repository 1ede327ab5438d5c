//! The gain on sweeps not used for the fit.
//!
//! Whole sweeps are assigned to five folds. Those of a fold get practically no weight, so that they change nothing;
//! their misfits are errors of prediction, whitened like the others. Shapes of the causes are sought again in the
//! rest. A point counts only if its target was measured at this step in a sweep of the rest, too.

use std::collections::HashSet;

use crate::engine::{FOLDS, HeldOut, Suspect, Wanders, in_blocks, sought_again};
use crate::points::base::Base;
use crate::points::model::{Model, NO_WEIGHT};

/// Fewest sweeps; with fewer the rest says too little.
const LEAST_SWEEPS: usize = 4;

/// Predicts each fold without causes, and with the causes and disturbances; `None` if nothing can be predicted.
pub(crate) fn held_out(base: &Base<'_>, model: &Model, causes: &[Suspect]) -> Option<HeldOut> {
    let all = &base.readings.all;
    let sweeps = all.iter().map(|r| r.sweep).max()? + 1;
    if sweeps < LEAST_SWEEPS {
        return None;
    }
    let folds = FOLDS.min(sweeps);
    let nothing = base.beside(Vec::new());
    let mut rows = Vec::new();
    for fold in 0..folds {
        let is_held = |i: usize| all[i].sweep % folds == fold;
        let stops = base.readings.stops.iter();
        let held: Vec<bool> = stops.map(|stop| is_held(stop.start)).collect();
        let without = |base: &Base<'_>| Model::with(base, &[], model.noise, Some(&held));
        let plain = without(&nothing);
        let (_, with) = match base.disturbances.is_empty() {
            true => sought_again(base, &plain, causes),
            false => sought_again(base, &without(base), causes),
        };
        let kept = (0..all.len()).filter(|&i| !is_held(i));
        let known: HashSet<_> = kept.map(|i| (all[i].pose, all[i].shape)).collect();
        let is_known = |i: &usize| is_held(*i) && known.contains(&(all[*i].pose, all[*i].shape));
        for i in (0..all.len()).filter(is_known) {
            rows.extend((3 * i..3 * i + 3).map(|row| {
                let left = [plain.bare.residuals[row], with.residuals[row]];
                let [before, after] = left.map(|e| (e / NO_WEIGHT).powi(2));
                (all[i].sweep, [before, after, 1.0])
            }));
        }
    }
    let mut blocks = in_blocks(rows.into_iter());
    blocks.retain(|[.., rows]| *rows > 0.0);
    HeldOut::of(&blocks).filter(|_| blocks.len() >= LEAST_SWEEPS)
}
