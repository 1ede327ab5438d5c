//! The gain on lengths that the model was not fitted to.
//!
//! Whole sweeps (one axis, one repeat, one direction, from one station) are dealt to five folds in their
//! order, each station beginning with another fold so that no step loses several stations at once,
//! before anything is looked at. For each fold the model without and with the causes is adjusted
//! to the others (instants and time constants are sought again there) and predicts it. Misfits are
//! weighted with the noise, its correlation within a stop included: a slip of a target shows in the
//! differences of three lengths, which are known four times better than one length. The ratio of the rms
//! has an interval from a bootstrap of sweeps.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::LengthCircumstances as Reading;

use crate::Error;
use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::hypotheses::{scan, visit_times};
use crate::selection::Hypothesis;

/// Held-out rms without and with the causes in standard deviations of the noise, and the interval of
/// their ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeldOut {
    pub(crate) before: f64,
    pub(crate) after: f64,
    pub(crate) interval: [f64; 2],
}

const FOLDS: usize = 5;

/// Resamples of the bootstrap: its 95 % interval is then good to a tenth of its width.
const RESAMPLES: usize = 1000;

const SEED: u64 = 0x6865_6c64_2d6f_7574;

/// Predicts each fold from the others with the noise of the final model; `None` if there are too few
/// sweeps, or a fold is needed to determine the rest.
pub(crate) fn held_out(base: &Base<'_>, adjusted: &Adjusted) -> Result<Option<HeldOut>, Error> {
    let sweeps = base.readings.iter().map(|r| r.sweep).max().unwrap_or(0) + 1;
    if sweeps < 2 * FOLDS {
        return Ok(None);
    }
    let noise = adjusted.network.noise;
    // For each sweep: readings, squares before, squares after.
    let mut sums = vec![(0_usize, 0.0, 0.0); sweeps];
    for fold in 0..FOLDS {
        let is_out = |r: &Reading| (r.sweep_of_turn + r.station) % FOLDS == fold;
        let removed: Vec<usize> = (0..base.readings.len())
            .filter(|&i| is_out(&base.readings[i]))
            .collect();
        let Ok(rest) = base.without(&removed) else {
            return Ok(None);
        };
        let plain = rest.adjust(Vec::new(), Some(noise))?;
        let suspects = fitted_again(&rest, &plain, &adjusted.suspects);
        let extended = rest.adjust_given(suspects, noise)?;
        let mut before = rest.predicted_misfit_mm(base, &plain);
        let mut after = rest.predicted_misfit_mm(base, &extended);
        // A sweep holds whole visits, so that these are whitened among themselves.
        adjusted.whitened.whiten(&mut before);
        adjusted.whitened.whiten(&mut after);
        for &i in &removed {
            let sum = &mut sums[base.readings[i].sweep];
            sum.0 += 1;
            sum.1 += before[i].powi(2);
            sum.2 += after[i].powi(2);
        }
    }
    let ratio = |sums: &mut dyn Iterator<Item = &(usize, f64, f64)>| {
        let (before, after) = sums.fold((0.0, 0.0), |(b, a), s| (b + s.1, a + s.2));
        (after / before).sqrt()
    };
    let mut generator = ChaCha8Rng::seed_from_u64(SEED);
    let mut ratios: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn: Vec<usize> = (0..sweeps)
                .map(|_| generator.random_range(0..sweeps))
                .collect();
            ratio(&mut drawn.iter().map(|&k| &sums[k]))
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let count: usize = sums.iter().map(|s| s.0).sum();
    let rms = |squares: f64| (squares / count as f64).sqrt();
    Ok(Some(HeldOut {
        before: rms(sums.iter().map(|s| s.1).sum()),
        after: rms(sums.iter().map(|s| s.2).sum()),
        interval: [
            ratios[RESAMPLES / 40],
            ratios[RESAMPLES - RESAMPLES / 40 - 1],
        ],
    }))
}

/// The same causes with shapes and parameters from other lengths; directions of the parameters that
/// these hardly show are shrunk ([`crate::selection::Gram::shrunk`]). A cause that they do not show stays out.
fn fitted_again(base: &Base<'_>, plain: &Adjusted, suspects: &[Suspect]) -> Vec<Suspect> {
    let visits = visit_times(base);
    let mut projected = Adjusted {
        network: plain.network.clone(),
        solution: plain.solution.clone(),
        whitened: plain.whitened.clone(),
        projection: plain.projection.clone(),
        suspects: Vec::new(),
    };
    let mut again: Vec<Suspect> = Vec::new();
    for suspect in suspects {
        let hypothesis: Hypothesis = suspect.hypothesis;
        let Some(scan) = scan(base, &projected, &visits, hypothesis) else {
            continue;
        };
        let mut best: Option<(f64, f64, Vec<f64>)> = None;
        scan.for_each(&projected.projection.residuals, &mut |shape, gram, s| {
            let statistic = gram.statistic(s);
            if best
                .as_ref()
                .is_none_or(|(_, largest, _)| statistic > *largest)
            {
                best = Some((shape, statistic, gram.shrunk(s)));
            }
        });
        let Some((shape, _, parameters)) = best else {
            continue;
        };
        again.push(Suspect {
            shape,
            parameters,
            ..suspect.clone()
        });
        let columns = scan.columns(shape);
        projected.projection = projected.projection.extended(&columns);
    }
    again
}
