//! Lengths of axes that expand while they are measured, as at one temperature.
//!
//! An axis whose expansion α is declared goes `α q (T - T0)` further than at the first reading. With T of each reading all
//! lengths lose what that did to them, of axes that stand, too; what is left then holds at `T0` for every step, and the
//! report refers it to 20 °C. Left in, a temperature that changes from station to station would be no error of an axis.

use std::borrow::Cow;

use trueaxis_campaign::Campaign;
use trueaxis_effects::{ResolvedEffect, Subject, TemperatureHistory, effect};

use crate::lengths::effects::EffectsOnLengths;

/// The campaign with lengths as if its axes had kept the temperatures of the first reading
/// ([`trueaxis_campaign::AxisExpansion::lengths_hold_at_c`]), if it declares an expansion; else as it is, also where its lengths cannot be
/// adjusted, which their calibration will say.
pub fn at_one_temperature(campaign: &Campaign) -> Cow<'_, Campaign> {
    let as_it_is = Cow::Borrowed(campaign);
    let (Some(lengths), Some(growth)) = (&campaign.lengths, effect("thermal_growth")) else {
        return as_it_is;
    };
    let mut expansions = campaign.expansions.clone();
    let mut open = Vec::new();
    for expansion in &mut expansions {
        let column = lengths.logged_column(&expansion.temperature_column);
        let of_rows = column.and_then(|column| without_gaps(&column.values));
        let Some(of_rows) = of_rows.filter(|_| expansion.lengths_hold_at_c.is_none()) else {
            continue;
        };
        expansion.lengths_hold_at_c = of_rows.first().copied();
        open.push((expansion.axis, expansion.ppm_per_k, of_rows));
    }
    if open.is_empty() {
        return as_it_is;
    }
    open.retain(|(.., of_rows)| of_rows.windows(2).any(|t| t[0].total_cmp(&t[1]).is_ne()));
    if open.is_empty() {
        return Cow::Owned(Campaign {
            expansions,
            ..campaign.clone()
        });
    }
    let Ok(mut on_lengths) = EffectsOnLengths::new(campaign) else {
        return as_it_is;
    };
    // At all readings 1 K warmer than before them: what a kelvin does to each length.
    let times = lengths.readings.iter().map(|reading| reading.time_s);
    let start_s = times.fold(f64::INFINITY, f64::min);
    on_lengths.temperatures = vec![TemperatureHistory::new(start_s - 1.0, 0.5, vec![0.0, 1.0])];
    let mut effects_mm = vec![0.0; lengths.readings.len()];
    for (axis, ppm_per_k, of_rows) in open {
        let of_one_k = on_lengths.of(&[ResolvedEffect {
            effect: growth,
            subject: Subject::axis(axis).with_column(0),
            parameters: vec![ppm_per_k],
            shape: 0.0,
        }]);
        for ((sum, mm_per_k), at_c) in effects_mm.iter_mut().zip(of_one_k).zip(&of_rows) {
            *sum += mm_per_k * (at_c - of_rows[0]);
        }
    }
    Cow::Owned(Campaign {
        expansions,
        ..on_lengths.taken_out(&effects_mm)
    })
}

/// A value for each row: where none was logged straight from the one before to the one after, by rows; none without any.
fn without_gaps(values: &[Option<f64>]) -> Option<Vec<f64>> {
    let logged = values.iter().enumerate();
    let logged: Vec<(usize, f64)> = logged.filter_map(|(i, v)| Some((i, (*v)?))).collect();
    let (first, last) = (logged.first()?, logged.last()?);
    let mut whole = vec![first.1; first.0];
    for pair in logged.windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        let part = |row: usize| (row - from) as f64 / (to - from) as f64;
        whole.extend((from..to).map(|row| a + (b - a) * part(row)));
    }
    whole.resize(values.len(), last.1);
    Some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_bridged_and_ends_go_on() {
        let values = [None, Some(20.0), None, Some(21.0), Some(23.0), None];
        let whole = without_gaps(&values).unwrap();
        let expected = [20.0, 20.0, 20.5, 21.0, 23.0, 23.0];
        assert_eq!(whole.len(), expected.len());
        assert!(
            whole
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
        assert!(without_gaps(&[None, None]).is_none());
    }
}
