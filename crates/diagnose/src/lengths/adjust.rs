//! The joint adjustment with rigid stages, with and without causes.

use std::sync::Arc;

use trueaxis_multilateration::{Network, Noise, Solution, Whitened, solve_from};
use trueaxis_screening::estimate_noise;
use trueaxis_selection::Fit;

use crate::Error;
use crate::engine::{Measured, Suspect, wandered_mm};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

const MAX_ITERATIONS: usize = 8;

/// Rounds of noise and disturbances: in the first each is mistaken for the other.
const ROUNDS: usize = 3;

impl Base<'_> {
    /// Adjusts everything with `suspects` in the model, from their present parameters. What the rigid model and the
    /// disturbances of a model `near` absorb is used again. Without `noise` the noise is estimated.
    ///
    /// Parameters of causes that the lengths hardly tell apart may run away, so that nothing can be adjusted: then the first
    /// linear step is the best.
    pub(crate) fn adjust_from(
        &self,
        near: Option<&Adjusted>,
        suspects: Vec<Suspect>,
        noise: Option<Noise>,
    ) -> Result<Adjusted, Error> {
        match self.iterated(near, suspects.clone(), noise) {
            Err(Error::Adjustment(_)) if !suspects.is_empty() => self.first_step(suspects, noise),
            found => found,
        }
    }

    fn first_step(
        &self,
        mut suspects: Vec<Suspect>,
        noise: Option<Noise>,
    ) -> Result<Adjusted, Error> {
        let without = self.iterated(None, Vec::new(), noise)?;
        let noise = without.network.noise;
        for suspect in &mut suspects {
            suspect.parameters.fill(0.0);
        }
        let mut zero = self.adjust_given(suspects, noise)?;
        let columns = self.columns_of_suspects(&zero);
        let fit = Fit::new(&zero.projection, &columns);
        zero.update(&fit);
        // Where even this step leads too far, the lengths stay as they are.
        let stepped = self.adjust_given(zero.suspects.clone(), noise);
        Ok(self.beside_suspects(stepped.unwrap_or(zero)))
    }

    fn iterated(
        &self,
        near: Option<&Adjusted>,
        mut suspects: Vec<Suspect>,
        noise: Option<Noise>,
    ) -> Result<Adjusted, Error> {
        let mut solution = near.map_or(&self.start, |near| &near.solution).clone();
        let mut network = self.network.clone();
        let mut by_wandering_mm = vec![0.0; self.readings.len()];
        for round in 1..=MAX_ITERATIONS {
            self.correct(&mut network, &solution, &suspects);
            if let Some(noise) = noise {
                network.noise = noise;
                solution = solve_from(&network, &solution)?;
            } else {
                network.noise = self.network.noise;
                // Disturbances are no noise.
                let add = |network: &mut Network, sign: f64| {
                    for (reading, mm) in network.readings.iter_mut().zip(&by_wandering_mm) {
                        reading.length_mm += sign * mm;
                    }
                };
                add(&mut network, -1.0);
                solution = solve_from(&network, &solution)?;
                estimate_noise(&mut network, &mut solution, self.declared)?;
                add(&mut network, 1.0);
                if !self.disturbances.is_empty() {
                    solution = solve_from(&network, &solution)?;
                }
            }
            let mut adjusted = self.adjusted(near, network, solution, suspects);
            let is_known = noise.is_some() || self.disturbances.is_empty() || round >= ROUNDS;
            if adjusted.suspects.is_empty() && is_known {
                return Ok(adjusted);
            }
            let columns = self.columns_of_suspects(&adjusted);
            let fit = Fit::new(&adjusted.projection, &columns);
            let rests = adjusted.update(&fit);
            if !is_known || rests {
                adjusted.projection = adjusted.projection.extended(&columns);
            }
            if is_known && rests {
                return Ok(adjusted);
            }
            if !is_known {
                by_wandering_mm = wandered_mm(self, &adjusted, None);
            }
            Adjusted {
                network,
                solution,
                suspects,
                ..
            } = adjusted;
        }
        // The parameters still move: the last linear step is the best available.
        let adjusted = self.adjust_given(suspects, network.noise)?;
        Ok(self.beside_suspects(adjusted))
    }

    /// With what the causes absorb, too.
    fn beside_suspects(&self, mut adjusted: Adjusted) -> Adjusted {
        let columns = self.columns_of_suspects(&adjusted);
        adjusted.projection = adjusted.projection.extended(&columns);
        adjusted
    }

    fn columns_of_suspects(&self, adjusted: &Adjusted) -> Vec<Vec<f64>> {
        let columns = self.columns(adjusted);
        let suspects = adjusted.suspects.iter();
        let of_each = suspects.flat_map(|s| columns(&s.hypothesis, s.shape));
        of_each.collect()
    }

    /// Adjusts everything with fixed causes.
    pub(crate) fn adjust_given(
        &self,
        suspects: Vec<Suspect>,
        noise: Noise,
    ) -> Result<Adjusted, Error> {
        let mut network = self.network.clone();
        network.noise = noise;
        self.correct(&mut network, &self.start, &suspects);
        let solution = solve_from(&network, &self.start)?;
        Ok(self.adjusted(None, network, solution, suspects))
    }

    /// A solved network with what its rigid model absorbs, that of a model near it if there is one.
    fn adjusted(
        &self,
        near: Option<&Adjusted>,
        network: Network,
        solution: Solution,
        suspects: Vec<Suspect>,
    ) -> Adjusted {
        let (whitened, before_causes) = match near {
            Some(near) => {
                let mut residuals = solution.residuals_mm.clone();
                near.whitened.whiten(&mut residuals);
                let of_these = near.before_causes.with_residuals(&residuals);
                (Arc::clone(&near.whitened), of_these)
            }
            None => {
                let whitened = Arc::new(Whitened::new(&network, &solution));
                let before_causes = self.before_causes(&whitened, &solution);
                (whitened, before_causes)
            }
        };
        Adjusted {
            projection: before_causes.clone(),
            before_causes: Arc::new(before_causes),
            network,
            solution,
            whitened,
            suspects,
        }
    }

    /// The lengths less the effects of the causes: exact distances between displaced points.
    fn correct(&self, network: &mut Network, solution: &Solution, suspects: &[Suspect]) {
        for (i, reading) in self.readings.iter().enumerate() {
            let measured_mm = self.network.readings[i].length_mm;
            network.readings[i].length_mm =
                measured_mm - self.effect_mm(reading, solution, suspects);
        }
    }
}
