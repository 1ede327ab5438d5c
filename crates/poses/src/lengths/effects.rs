//! What effects do to the lengths of a campaign.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::{ResolvedEffect, TemperatureHistory};
use trueaxis_multilateration::{Network, Solution};
use trueaxis_screening::solve_as_a_set;

use crate::Error;
use crate::lengths::circumstances::{
    LengthCircumstances, length_circumstances, temperature_histories,
};
use crate::lengths::network::{CampaignNetwork, network_from_campaign};
use crate::lengths::refused::adjustment_error;

/// What effects do to each length of a campaign: exact distances ([`Observation`](crate::Observation)) at the
/// geometry that the lengths have as they are, which is right to a millionth.
pub struct EffectsOnLengths<'a> {
    campaign: &'a Campaign,
    lengths: &'a Lengths,
    network: Network,
    solution: Solution,
    circumstances: Vec<LengthCircumstances>,
    /// What effects with a column go with.
    pub(super) temperatures: Vec<TemperatureHistory>,
}

impl<'a> EffectsOnLengths<'a> {
    /// Adjusts the lengths as they are.
    ///
    /// # Errors
    /// [`Error::EffectsWithoutLengths`], and those of an adjustment.
    pub fn new(campaign: &'a Campaign) -> Result<Self, Error> {
        let lengths = campaign.lengths.as_ref();
        let lengths = lengths.ok_or(Error::EffectsWithoutLengths)?;
        let CampaignNetwork {
            mut network,
            groups,
            ..
        } = network_from_campaign(campaign, lengths, false);
        let solution = solve_as_a_set(&mut network, None)
            .map_err(|error| adjustment_error(campaign, lengths, &groups, error))?;
        let all: Vec<usize> = (0..lengths.readings.len()).collect();
        let circumstances = length_circumstances(campaign, lengths, &network, &groups, &all);
        Ok(Self {
            campaign,
            lengths,
            network,
            solution,
            circumstances,
            temperatures: temperature_histories(campaign),
        })
    }

    /// What effects together do to each length, mm; they must have been resolved in the scene of the campaign
    /// ([`scene_of`](crate::scene_of)).
    pub fn of(&self, effects: &[ResolvedEffect]) -> Vec<f64> {
        let of_length = |circumstances: &LengthCircumstances| {
            let (network, solution) = (&self.network, &self.solution);
            let observation =
                circumstances.observation(self.campaign, network, solution, &self.temperatures);
            let displaced = effects
                .iter()
                .map(|effect| effect.displaced(&observation.at));
            observation.lengthening_mm(&displaced.sum())
        };
        self.circumstances.iter().map(of_length).collect()
    }

    /// The campaign with lengths less these.
    pub fn taken_out(&self, effects_mm: &[f64]) -> Campaign {
        let mut lengths = self.lengths.clone();
        for (reading, effect_mm) in lengths.readings.iter_mut().zip(effects_mm) {
            reading.length_mm -= effect_mm;
        }
        Campaign {
            lengths: Some(lengths),
            ..self.campaign.clone()
        }
    }
}
