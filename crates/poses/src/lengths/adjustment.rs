//! The adjustment of a campaign's lengths, with errors in the words of the campaign.

use std::cell::Cell;
use std::collections::BTreeMap;

use trueaxis_campaign::{Campaign, Direction, Lengths};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_multilateration::{Network, Noise, Whitened};
use trueaxis_screening::{
    Alike, Screened, Slow, adjust_as_a_set, alike, scaled, screen_unless, slow,
};

use crate::Error;
use crate::lengths::network::{CampaignNetwork, Group, network_from_campaign};
use crate::lengths::refused::{contradictory, screening_error};
use crate::lengths::returns::axes_of;
use crate::lengths::scale::Scale;
use crate::lengths::side_by_side::{side_by_side, sides_alone};
use crate::lengths::uneven::{growing_in_words, uneven_in_words};
use crate::report::KnownMisfit;
use crate::settings::{Method, Settings};

/// The adjustment of a campaign's lengths: the only one that there is.
#[derive(Debug, Clone)]
pub struct LengthsAdjustment<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) lengths: &'a Lengths,
    /// With rigid stages for [`Method::Joint`], with free points otherwise.
    pub settings: Settings,
    pub(crate) groups: Vec<Group>,
    /// The number in the campaign ([`Campaign::reflectors`]) of each reflector that was measured.
    pub(crate) reflectors: Vec<usize>,
    /// The screened network with its solution and noise.
    pub screened: Screened,
    /// The scale of all lengths, where it is an unknown. Points, poses and stations of the solution are larger
    /// than they are by it.
    pub(crate) scale: Option<Scale>,
    /// What is known and contradicts the lengths.
    pub known_misfits: Vec<KnownMisfit>,
    /// What the repeats of stops have in common beyond the model: its factor makes the noise of `screened` larger than
    /// its estimates.
    pub(crate) alike: Option<Alike>,
    /// How far the misfits of neighbouring steps are alike.
    pub slow: Option<Slow>,
}

/// A residual this many times its noise in the mean is no noise: something in the data is wrong.
const CONTRADICTORY_SIGMA0: f64 = 100.0;

impl<'a> LengthsAdjustment<'a> {
    /// Adjusts the lengths, and says what a user must know of the stations.
    pub(crate) fn new(
        campaign: &'a Campaign,
        lengths: &'a Lengths,
        settings: &Settings,
    ) -> Result<(Self, Vec<String>), Error> {
        let CampaignNetwork {
            mut network,
            groups,
            reflectors,
        } = network_from_campaign(campaign, lengths, settings.by_direction);
        let bodies = network.bodies.clone();
        if settings.method != Method::Joint {
            network.bodies = None;
        }
        let declared = campaign.instrument.declares_noise();
        let reflectors_known = network.reflectors.clone();
        let sides = Cell::new(false);
        let of_sides = |network: &Network| {
            let axes = axes_of((campaign, lengths), (network, &groups), settings);
            let found = sides_alone((campaign, lengths), &axes, settings);
            sides.set(found.is_some());
            found
        };
        let adjust = |network: &mut Network, declared: bool| {
            adjust_as_a_set(
                network,
                |screened: &Screened| &screened.solution,
                |network| match settings.robust {
                    true => screen_unless(network, declared, settings.most_removed, || {
                        of_sides(network)
                    }),
                    false => Screened::plain(network, declared),
                },
            )
        };
        let mut adjusted = adjust(&mut network, declared);
        let is_asked = settings.robust && !settings.asks_why;
        let axes = axes_of((campaign, lengths), (&network, &groups), settings);
        let grows = is_asked.then(|| axes.noise_that_grows(adjusted.as_ref()));
        let mut grows_with_length = false;
        if let Some(noise) = grows.flatten() {
            let mut growing = Network {
                noise,
                ..network.clone()
            };
            if let Ok(found) = adjust(&mut growing, true) {
                (network, adjusted, grows_with_length) = (growing, Ok(found), true);
            }
        }
        if adjusted.is_err() {
            // Whether the constants are known was not found out.
            network.reflectors = reflectors_known;
        }
        let axes = axes_of((campaign, lengths), (&network, &groups), settings);
        let found = (is_asked && !sides.get()).then(|| axes.returned(adjusted.as_ref()));
        let (ratios, adjusted) = match found.flatten() {
            Some((ratios, found)) => (ratios, Ok(found)),
            None => (Vec::new(), adjusted),
        };
        let apart = side_by_side(
            (campaign, lengths),
            &axes,
            settings,
            (&ratios, adjusted.as_ref()),
        );
        let screened = apart.map_or(adjusted, Ok);
        let screened =
            screened.map_err(|error| screening_error(campaign, lengths, &groups, error))?;
        let mut adjustment = Self {
            campaign,
            lengths,
            settings: *settings,
            groups,
            reflectors,
            screened,
            scale: None,
            known_misfits: Vec::new(),
            alike: None,
            slow: None,
        };
        let mut notices = adjustment.check(!ratios.is_empty())?;
        notices.extend(adjustment.returns(&ratios));
        notices.extend(adjustment.weigh(network.noise)?);
        notices
            .extend(grows_with_length.then(|| growing_in_words(&adjustment.screened.noise.noise)));
        adjustment.widen()?;
        adjustment.take_known(bodies)?;
        Ok((adjustment, notices))
    }

    /// Refuses an adjustment that cannot be trusted. Contradictions come first: they make the stations look
    /// weak; how axes return is none.
    fn check(&self, is_return: bool) -> Result<Vec<String>, Error> {
        let (campaign, lengths, solution) = (self.campaign, self.lengths, &self.screened.solution);
        let residuals_mm = self.screened.residuals_mm();
        let sigma0 = self.given_sigma0();
        if sigma0 > CONTRADICTORY_SIGMA0 {
            return Err(contradictory(campaign, lengths, sigma0, &residuals_mm));
        }
        let noise_mm = campaign.instrument.length_sigma_um.unwrap_or(1.0) * MICROMETRE;
        let noise = match campaign.instrument.declares_noise() {
            true if is_return => (noise_mm * sigma0.max(1.0), 1.0),
            true => (noise_mm, sigma0),
            false => (noise_mm, 1.0),
        };
        let weak = self.weak_stations(&residuals_mm, noise)?;
        if !solution.termination.is_converged() {
            return Err(Error::NotConverged {
                iterations: solution.iterations,
                termination: solution.termination.to_string(),
            });
        }
        if !self.settings.asks_why {
            self.check_targets()?;
        }
        Ok(weak)
    }

    /// Gives lengths that scatter more than the others less weight, and says whose they are. A diagnosis, which does not
    /// split occupations, weighs its own.
    fn weigh(&mut self, given: Noise) -> Result<Vec<String>, Error> {
        if self.settings.asks_why || !self.settings.robust {
            return Ok(Vec::new());
        }
        let declared = self.campaign.instrument.declares_noise();
        let words = |error| screening_error(self.campaign, self.lengths, &self.groups, error);
        let weighed = self.screened.weighed(given, declared).map_err(words)?;
        let Some((screened, uneven)) = weighed else {
            return Ok(Vec::new());
        };
        let of = (&screened.network, &*self.groups);
        let in_words = |own| uneven_in_words(own, self.campaign, of);
        let notices = uneven.iter().map(in_words).collect();
        self.screened = screened;
        Ok(notices)
    }

    /// Where repeats agree better with each other than with the model, U contains what they have in common. Nothing is
    /// widened for a diagnosis, which asks what it is.
    fn widen(&mut self) -> Result<(), Error> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        if self.settings.asks_why {
            return Ok(());
        }
        let rows = Whitened::of_visits(network, solution);
        self.alike = alike(network, solution, &rows);
        self.slow = slow(network, &rows, &self.runs());
        if let Some(alike) = &self.alike {
            let noise = scaled(network.noise, alike.factor, alike.factor);
            self.screened = self.solved_again(Network {
                noise,
                ..network.clone()
            })?;
        }
        Ok(())
    }

    /// Standard deviation of unit weight with the declared noise.
    pub(crate) fn given_sigma0(&self) -> f64 {
        match self.screened.solution.degrees_of_freedom() {
            0 => 1.0,
            degrees_of_freedom => (self.screened.given_squares / degrees_of_freedom as f64).sqrt(),
        }
    }

    /// The groups of each body in a run and on a side of approach, in the order in which they were first read.
    pub(crate) fn runs(&self) -> Vec<Vec<usize>> {
        let mut runs: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for g in self.moved() {
            let group = &self.groups[g];
            let step = &self.campaign.steps[group.step];
            let side = group.direction.map(Direction::sign);
            runs.entry((step.run, side, group.body))
                .or_default()
                .push(g);
        }
        runs.into_values().collect()
    }
}
