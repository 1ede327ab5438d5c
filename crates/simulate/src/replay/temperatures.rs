//! Temperatures of a replay: as they were logged, where an effect goes with them.

use trueaxis_campaign::{Campaign, LoggedColumn};
use trueaxis_effects::TemperatureHistory;

use crate::{TemperatureSpec, TemperatureTerm, Truth};

/// The columns that the effects name, as straight lines between averages of what was logged.
pub(super) fn temperatures(campaign: &Campaign, truth: &Truth) -> Vec<TemperatureSpec> {
    let is_named = |column: &&LoggedColumn| {
        let mut effects = truth.effects.iter();
        effects.any(|effect| effect.subject.column.as_ref() == Some(&column.name))
    };
    let Some(lengths) = &campaign.lengths else {
        return Vec::new();
    };
    let spec = |column: &LoggedColumn| {
        let logged = lengths.course(column);
        let (times_s, values_c) = TemperatureHistory::from_logged(&logged).nodes().unzip();
        TemperatureSpec {
            column: column.name.clone(),
            course: vec![TemperatureTerm::Table { times_s, values_c }],
            sigma_k: 0.0,
        }
    };
    lengths.logged.iter().filter(is_named).map(spec).collect()
}
