//! A machine that shifts while one station is occupied: the lengths show an opposite jump of that tripod.
//!
//! Later stations are determined against the shifted machine. If one name is found, both are given, unless targets on
//! the bed, which do not move, distinguish them.

use trueaxis_effects::{Shape, Subject, effect};
use trueaxis_selection::{DECISIVE, Fit, Hypothesis};

use crate::Error;
use crate::engine::{Found, Suspect};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// Adds to a shift of the machine the jump of a tripod at the same instant if it explains nearly as much.
pub(crate) fn add_jumps(
    base: &Base<'_>,
    adjusted: &Adjusted,
    found: &mut [Found],
) -> Result<(), Error> {
    let Some(jump) = effect("station_jump").filter(|_| !base.scene.has_bed_targets()) else {
        return Ok(());
    };
    for (k, found) in found.iter_mut().enumerate() {
        let is_jump = |(rival, _): &(Suspect, f64)| rival.hypothesis.effect == jump;
        let shape = found.suspect.shape;
        let effect = found.suspect.hypothesis.effect;
        let is_shift = effect.moves_machine() && effect.shape == Shape::Instant;
        if !is_shift || found.rivals.iter().any(is_jump) {
            continue;
        }
        let mut others = adjusted.suspects.clone();
        others.remove(k);
        let without = base.adjust_near(adjusted, others)?;
        let own = base.columns(&without, &found.suspect.hypothesis, shape);
        let own = Fit::new(&without.projection, &own).gained();
        let stations = base.scene.stations.len();
        let of_station = |station: usize| {
            let hypothesis = Hypothesis {
                effect: jump,
                subject: Subject {
                    station: Some(station),
                    ..Subject::default()
                },
                subjects: stations,
            };
            let fit = Fit::new(
                &without.projection,
                &base.columns(&without, &hypothesis, shape),
            );
            (hypothesis, fit)
        };
        let all = (0..stations).map(of_station);
        let best = all.max_by(|(_, a), (_, b)| a.gained().total_cmp(&b.gained()));
        let Some((hypothesis, fit)) = best.filter(|(_, fit)| own - fit.gained() < DECISIVE) else {
            continue;
        };
        let bic = found.bic + own - fit.gained();
        let rival = Suspect::new(hypothesis, (shape, found.suspect.u_shape), &fit);
        found.rivals.push((rival, bic));
    }
    Ok(())
}
