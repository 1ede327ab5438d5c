//! Lengths of axes that expand while they are measured, as at one temperature.
//!
//! An axis whose expansion α is declared goes `α q (T - T0)` further than at the first reading. With T of each reading all
//! lengths lose what that did to them, of axes that stand, too; what is left then holds at `T0` for every step, and the
//! report refers it to 20 °C. Left in, a temperature that changes from station to station would be an error of none.

use std::borrow::Cow;

use trueaxis_campaign::Campaign;
use trueaxis_effects::{ResolvedEffect, Subject, TemperatureHistory, effect};

use crate::lengths::circumstances::temperature_history;
use crate::lengths::effects::EffectsOnLengths;

/// The campaign with lengths as if its axes had kept the temperatures of the first reading
/// ([`trueaxis_campaign::AxisExpansion::lengths_hold_at_c`]), if it declares an expansion and its temperatures change; else as
/// it is, also where its lengths cannot be adjusted, which their calibration will say.
pub fn at_one_temperature(campaign: &Campaign) -> Cow<'_, Campaign> {
    let (Some(lengths), Some(growth)) = (&campaign.lengths, effect("thermal_growth")) else {
        return Cow::Borrowed(campaign);
    };
    let mut expansions = campaign.expansions.clone();
    let (mut effects, mut histories) = (Vec::new(), Vec::new());
    for expansion in &mut expansions {
        let column = lengths.logged_column(&expansion.temperature_column);
        let history = column.map(|column| temperature_history(lengths, column));
        let Some(history) = history.filter(|_| expansion.lengths_hold_at_c.is_none()) else {
            continue;
        };
        let first_c = history.nodes().next().map(|(_, value_c)| value_c);
        expansion.lengths_hold_at_c = first_c;
        effects.extend(first_c.map(|_| ResolvedEffect {
            effect: growth,
            subject: Subject::axis(expansion.axis).with_column(histories.len()),
            parameters: vec![expansion.ppm_per_k],
            shape: 0.0,
        }));
        histories.push(history);
    }
    let changes = |history: &TemperatureHistory| {
        let mut kelvins = history
            .nodes()
            .map(|(time_s, _)| history.warmer_k(time_s, 0.0));
        kelvins.any(|warmer_k| warmer_k.abs() > 0.0)
    };
    if !histories.iter().any(changes) {
        return Cow::Borrowed(campaign);
    }
    let Ok(mut on_lengths) = EffectsOnLengths::new(campaign) else {
        return Cow::Borrowed(campaign);
    };
    on_lengths.temperatures = histories;
    Cow::Owned(Campaign {
        expansions,
        ..on_lengths.taken_out(&on_lengths.of(&effects))
    })
}
