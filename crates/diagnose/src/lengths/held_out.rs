//! The gain on lengths not used for the fit.
//!
//! Whole sweeps (one axis, one repeat, one direction, from one station) are assigned to five folds in their order and
//! in advance; each station begins with another fold, so that no step loses several stations at once. For each fold
//! the model without and with the causes is adjusted to the others (instants and time constants are sought again) and
//! predicts it. Misfits are weighted with the noise including its correlation within a stop: a slip of a target shows
//! in the differences of three lengths, which are known four times better than one length. The ratio of the rms has
//! an interval from a bootstrap of sweeps.
//!
//! With five or more stations each station is a fold, too. Its position and dead path, which no other length shows,
//! come from its own lengths, but the poses and the causes do not: its lengths take part with a weight that changes
//! nothing else.

use rayon::prelude::*;
use trueaxis_poses::LengthCircumstances as Reading;
use trueaxis_selection::add;

use crate::Error;
use crate::engine::{
    FOLDS, HeldOut, Measured, Squares, Wanders, in_blocks, sought_again, wandered_mm,
};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// Least number of stations: with fewer, the others alone do not determine the points well enough for a prediction,
/// as self-calibration needs four.
const MIN_STATIONS: usize = 5;

/// Predicts each fold of sweeps from the others with the noise of the final model; `None` if there are too few
/// sweeps, or if a fold is needed to determine the rest.
pub(crate) fn held_out_sweeps(base: &Base<'_>, adjusted: &Adjusted) -> Option<HeldOut> {
    let sweeps = base.readings.iter().map(|r| r.sweep).max().unwrap_or(0) + 1;
    if sweeps < 2 * FOLDS {
        return None;
    }
    let fold = |r: &Reading| (r.sweep_of_occupation + r.station) % FOLDS;
    held_out(base, adjusted, FOLDS, fold, |out| base.without(out))
}

/// Predicts each station's lengths from the others; `None` if there are fewer than five stations.
pub(crate) fn held_out_stations(base: &Base<'_>, adjusted: &Adjusted) -> Option<HeldOut> {
    let stations = base.scene.stations.len();
    if stations < MIN_STATIONS {
        return None;
    }
    let fold = |r: &Reading| r.station;
    held_out(base, adjusted, stations, fold, |out| {
        base.without_weight(out)
    })
}

/// Predicts each fold from the base without the fold's readings (ascending); `None` if one cannot be adjusted.
fn held_out<'a>(
    base: &Base<'a>,
    adjusted: &Adjusted,
    folds: usize,
    fold_of: impl Fn(&Reading) -> usize + Sync,
    rest: impl Fn(&[usize]) -> Result<Base<'a>, Error> + Sync,
) -> Option<HeldOut> {
    let noise = adjusted.network.noise;
    let squares = |fold: usize| -> Result<Vec<(usize, Squares)>, Error> {
        let is_out = |i: &usize| fold_of(&base.readings[*i]) == fold;
        let out: Vec<usize> = (0..base.readings.len()).filter(is_out).collect();
        let rest = rest(&out)?;
        let plain = rest.beside(Vec::new()).adjust(Vec::new(), Some(noise))?;
        let (suspects, _) = match rest.disturbances.is_empty() {
            true => sought_again(&rest, &plain, &adjusted.suspects),
            false => {
                let beside = rest.adjust(Vec::new(), Some(noise))?;
                sought_again(&rest, &beside, &adjusted.suspects)
            }
        };
        let mut extended = rest.adjust_given(suspects, noise)?;
        let mut before = rest.predicted_misfit_mm(base, &plain);
        let wanders_mm = wandered_mm(&rest, &extended, Some(base));
        if !rest.disturbances.is_empty() {
            extended = rest.less(&extended, &wandered_mm(&rest, &extended, None))?;
        }
        let mut after = rest.predicted_misfit_mm(base, &extended);
        add(&mut after, &wanders_mm, -1.0);
        // A fold holds whole visits, so it can be whitened separately.
        adjusted.whitened.whiten(&mut before);
        adjusted.whitened.whiten(&mut after);
        let squares = |i: usize| {
            let [before, after] = [before[i], after[i]].map(|misfit| misfit * misfit);
            (base.readings[i].sweep, [before, after, 1.0])
        };
        Ok(out.into_iter().map(squares).collect())
    };
    let folds = (0..folds).into_par_iter().map(|fold| squares(fold).ok());
    let folds: Vec<Vec<(usize, Squares)>> = folds.collect::<Option<_>>()?;
    HeldOut::of(&in_blocks(folds.into_iter().flatten()))
}
