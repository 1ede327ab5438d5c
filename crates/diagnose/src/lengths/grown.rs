//! A machine that is larger instead of lengths that are shown too long.
//!
//! From one station a whole machine that grew by s is a scale s of its lengths: `u (p - c) s = l s - u (c - station)
//! s`, where the station's position absorbs the rest. Over time it does not, but the difference is small. Targets on
//! the bed, which do not move, distinguish the two.

use trueaxis_selection::{DECISIVE, Fit, Hypothesis};

use crate::Error;
use crate::engine::Found;
use crate::engine::disturbance::{Wanderer, Who, With};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// Adds a wandering machine to scales of lengths, where one that grows in the same course explains nearly as much.
pub(crate) fn add_growth(
    base: &Base<'_>,
    adjusted: &Adjusted,
    found: &mut [Found],
) -> Result<(), Error> {
    if base.scene.has_bed_targets() {
        return Ok(());
    }
    for (k, found) in found.iter_mut().enumerate() {
        let hypothesis = found.suspect.hypothesis;
        // The temperature of the air is not that of the machine.
        if !hypothesis.effect.scales_lengths() || hypothesis.subject.column.is_some() {
            continue;
        }
        let mut others = adjusted.suspects.clone();
        others.remove(k);
        let without = base.adjust_near(adjusted, others)?;
        let own = base.columns(&without, &hypothesis, found.suspect.shape);
        let own = Fit::new(&without.projection, &own).gained();
        let grown = grown(base, &without, &hypothesis, found.suspect.shape);
        // The point where the machine is held is no finding, so it costs nothing.
        let gained = Fit::new(&without.projection, &grown).gained();
        if own - gained < DECISIVE {
            let machine = Wanderer {
                who: Who::Machine,
                with: With::Campaign,
            };
            found.wandering.push((machine, gained));
        }
    }
    Ok(())
}

/// Whitened columns of a machine that grows in the course of a scale of lengths, about the origin and any point.
fn grown(base: &Base<'_>, adjusted: &Adjusted, scale: &Hypothesis, shape: f64) -> Vec<Vec<f64>> {
    let observations = base.observations(&adjusted.solution);
    let of_lengths = base.columns_mm(&observations, scale, shape).swap_remove(0);
    let with_course = |of: &dyn Fn(usize) -> f64| {
        let course = |i: usize| of_lengths[i] / observations[i].at.distance_mm;
        let mut column: Vec<f64> = (0..observations.len()).map(|i| course(i) * of(i)).collect();
        adjusted.whitened.whiten(&mut column);
        column
    };
    // A metre, so that all columns have similar length.
    let held = (0..3).map(|c| with_course(&|i| 1e3 * observations[i].beam[c]));
    let grows = with_course(&|i| {
        observations[i]
            .beam
            .dot(&observations[i].at.point_mm.coords)
    });
    [grows].into_iter().chain(held).collect()
}
