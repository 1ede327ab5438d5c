//! The lengths of a campaign with their base model, and the effects on them.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_effects::{Scene, TemperatureHistory};
use trueaxis_multilateration::{Network, Solution, solve_from};
use trueaxis_poses::{
    CampaignNetwork, Group, LengthCircumstances as Reading, LengthsAdjustment, Method, Observation,
    length_circumstances, network_from_campaign, scene_of, temperature_histories,
};
use trueaxis_screening::{LessWeight, Removed, Weighed, solve_as_a_set, weigh_uneven};
use trueaxis_selection::Hypothesis;

use crate::Error;
use crate::engine::Suspect;
use crate::engine::disturbance::Disturbance;
use crate::lengths::adjusted::Adjusted;
use crate::lengths::left_out::LeftOut;
use crate::numbers::extremes;

/// The lengths of a campaign, ready to be adjusted.
#[derive(Clone)]
pub(crate) struct Base<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) scene: Scene,
    pub(crate) network: Network,
    pub(crate) groups: Vec<Group>,
    pub(crate) readings: Vec<Reading>,
    temperatures: Vec<TemperatureHistory>,
    /// Solution without causes, the start of the others.
    pub(crate) start: Solution,
    /// Whether the noise is declared.
    pub(super) declared: bool,
    /// Readings that were left out as gross errors.
    pub(crate) left_out: Vec<LeftOut>,
    /// What lengths have in common that scatter more than the others, and have less weight.
    pub(crate) uneven: Vec<LessWeight>,
    /// Disturbances in the covariance of the lengths.
    pub(crate) disturbances: Vec<Disturbance>,
    /// First and last time of all lengths, s.
    pub(crate) span_s: [f64; 2],
}

/// Factor on the variance of lengths that are to be predicted: a thousand of them have the weight of a thousandth of
/// one length.
const NO_WEIGHT: f64 = 1e6;

impl<'a> Base<'a> {
    /// The lengths as their calibration adjusted them, without causes. Gross errors are left out; interrupted beams
    /// are not split, because the search is to find them.
    pub(crate) fn new(
        campaign: &'a Campaign,
        lengths: &Lengths,
        adjustment: Option<&LengthsAdjustment<'_>>,
    ) -> Result<Self, Error> {
        let all = network_from_campaign(campaign, lengths, false);
        let removed = adjustment.map_or(&[][..], |adjustment| &adjustment.screened.removed);
        // An adjustment with other groups is no start.
        let same = |adjustment: &&LengthsAdjustment<'_>| {
            adjustment.settings.method == Method::Joint && !adjustment.settings.by_direction
        };
        let near = adjustment
            .filter(same)
            .map(|adjustment| &*adjustment.screened.solution);
        Self::leaving_out(campaign, lengths, all, removed, near)
    }

    /// Adjusts a campaign's lengths without causes and without the readings `removed` (ascending), from a solution of
    /// the same steps if there is one.
    pub(crate) fn leaving_out(
        campaign: &'a Campaign,
        lengths: &Lengths,
        all: CampaignNetwork,
        removed: &[Removed],
        near: Option<&Solution>,
    ) -> Result<Self, Error> {
        let (network, groups) = (all.network, all.groups);
        let left_out = LeftOut::of(campaign, lengths, &network, &groups, removed);
        let numbers: Vec<usize> = removed.iter().map(|removed| removed.reading).collect();
        let (mut network, kept) = network.without(&numbers);
        let mut start = solve_as_a_set(&mut network, near)?;
        let declared = campaign.instrument.declares_noise();
        let mut uneven = Vec::new();
        let tests = start.tests(&network);
        if let Some(weighed) = weigh_uneven(&network, (&start, &tests), declared)? {
            start = solve_from(&weighed.network, &start)?;
            Weighed { network, uneven } = weighed;
        }
        let readings = length_circumstances(campaign, lengths, &network, &groups, &kept);
        Ok(Self {
            span_s: extremes(readings.iter().map(|r| r.time_s)),
            disturbances: Vec::new(),
            campaign,
            scene: scene_of(campaign),
            temperatures: temperature_histories(campaign),
            readings,
            start,
            declared,
            uneven,
            left_out,
            network,
            groups,
        })
    }

    pub(crate) fn observation<'b>(
        &'b self,
        reading: &Reading,
        solution: &Solution,
    ) -> Observation<'b> {
        reading.observation(self.campaign, &self.network, solution, &self.temperatures)
    }

    /// The effect of causes on a reading, mm.
    pub(crate) fn effect_mm(
        &self,
        reading: &Reading,
        solution: &Solution,
        suspects: &[Suspect],
    ) -> f64 {
        if suspects.is_empty() {
            return 0.0;
        }
        let observation = self.observation(reading, solution);
        let of_suspect = |suspect: &Suspect| {
            let (own, shape) = (&suspect.hypothesis, suspect.shape);
            own.effect
                .displacement(&own.subject, &suspect.parameters, shape, &observation.at)
        };
        observation.lengthening_mm(&suspects.iter().map(of_suspect).sum())
    }

    /// All readings at the positions of a solution.
    pub(crate) fn observations<'b>(&'b self, solution: &Solution) -> Vec<Observation<'b>> {
        let readings = self.readings.iter();
        readings.map(|r| self.observation(r, solution)).collect()
    }

    /// Changes of the lengths, for readings at known positions, by a unit of each parameter of a hypothesis, mm.
    pub(crate) fn columns_at(
        &self,
        observations: &[Observation<'_>],
        hypothesis: &Hypothesis,
        shape: f64,
    ) -> Vec<Vec<f64>> {
        let column = |k: usize| {
            let all = observations.iter();
            let lengthened = all.map(|own| hypothesis.form(k, shape, &own.at).along(&own.beam));
            lengthened.collect()
        };
        let count = hypothesis.parameters(&self.scene).len();
        (0..count).map(column).collect()
    }

    /// The same lengths without some readings (ascending).
    pub(crate) fn without(&self, removed: &[usize]) -> Result<Self, Error> {
        let (network, kept) = self.network.without(removed);
        let readings = kept.iter().map(|&i| self.readings[i].clone()).collect();
        self.with_network(network, readings)
    }

    /// The same lengths with practically no weight for some: these determine the dead path of their station, but
    /// change nothing that others determine.
    pub(crate) fn without_weight(&self, held: &[usize]) -> Result<Self, Error> {
        let mut network = self.network.clone();
        network.variance_factors.resize(network.readings.len(), 1.0);
        for &i in held {
            network.variance_factors[i] *= NO_WEIGHT;
        }
        self.with_network(network, self.readings.clone())
    }

    /// The same campaign with another network and its readings.
    fn with_network(&self, network: Network, readings: Vec<Reading>) -> Result<Self, Error> {
        let start = solve_from(&network, &self.start)?;
        Ok(Self {
            network,
            readings,
            start,
            left_out: Vec::new(),
            ..self.clone()
        })
    }

    /// Measured minus predicted lengths for all lengths of `all`, mm, by a model adjusted to these lengths only.
    pub(crate) fn predicted_misfit_mm(&self, all: &Base<'_>, adjusted: &Adjusted) -> Vec<f64> {
        let solution = &adjusted.solution;
        let misfit = |(i, reading): (usize, &Reading)| {
            let (station, point) = (reading.station, reading.point);
            let computed_mm = solution.computed_length_mm(&adjusted.network, station, point);
            let effect_mm = all.effect_mm(reading, solution, &adjusted.suspects);
            all.network.readings[i].length_mm - computed_mm - effect_mm
        };
        all.readings.iter().enumerate().map(misfit).collect()
    }
}
