//! What is known beside the lengths: dead paths, and the scale with known lengths.
//!
//! Nothing that is known may spoil the lengths unseen: it is compared with what these say, and what contradicts
//! them takes no part. Known dead paths are compared without the constant that all reflectors have in common.

use std::sync::Arc;

use nalgebra::DMatrix;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::student_two_sided;
use trueaxis_multilateration::{Bodies, KnownDeadPath, Network, solve_from};
use trueaxis_screening::Screened;

use crate::Error;
use crate::lengths::LengthsAdjustment;
use crate::lengths::common_value::common_value;
use crate::lengths::refused::adjustment_error;
use crate::report::KnownMisfit;

/// Probability that anything known is said to contradict lengths if nothing does.
const LEVEL: f64 = 0.01;

/// Elements of a station: x y z and dead path.
const PER_STATION: usize = 4;

impl LengthsAdjustment<'_> {
    /// Takes what is known into the adjustment; `bodies` are those of the campaign.
    pub(crate) fn take_known(&mut self, bodies: Option<Arc<Bodies>>) -> Result<(), Error> {
        let stations = self.campaign.stations.iter();
        let dead_paths = stations
            .filter(|station| station.dead_path.is_some())
            .count();
        let known = dead_paths + self.campaign.known_lengths.len();
        let limit = student_two_sided(LEVEL / known.max(1) as f64, f64::INFINITY);
        if dead_paths > 0 {
            self.take_dead_paths(limit)?;
        }
        let (scale, misfits) = match &self.screened.network.bodies {
            None if known > dead_paths => {
                let rigid = Network {
                    bodies,
                    ..self.screened.network.clone()
                };
                let rigid = Self {
                    screened: self.solved_again(rigid)?,
                    ..self.clone()
                };
                let (scale, misfits) = rigid.estimate_scale(limit);
                (scale.map(|scale| scale.of_another()), misfits)
            }
            _ => self.estimate_scale(limit),
        };
        self.scale = scale;
        self.known_misfits.extend(misfits);
        Ok(())
    }

    /// The dead paths that do not contradict the lengths.
    fn take_dead_paths(&mut self, limit: f64) -> Result<(), Error> {
        let solution = &self.screened.solution;
        let stations = self.campaign.stations.iter().enumerate();
        let known = stations.filter_map(|(station, s)| {
            s.dead_path.map(|known| KnownDeadPath {
                station,
                length_mm: known.length_mm,
                sigma_mm: known.sigma_mm,
            })
        });
        let known: Vec<KnownDeadPath> = known.collect();
        let found_mm = |k: &KnownDeadPath| solution.stations[k.station].dead_path_mm;
        let observed: Vec<f64> = known.iter().map(|k| k.length_mm - found_mm(k)).collect();
        let column = |k: usize| PER_STATION * known[k].station + PER_STATION - 1;
        let mut covariance = DMatrix::from_fn(known.len(), known.len(), |i, j| {
            solution.covariance.shared()[(column(i), column(j))]
        });
        for (i, known) in known.iter().enumerate() {
            covariance[(i, i)] += known.sigma_mm * known.sigma_mm;
        }
        let Some(mean) = common_value(&observed, &covariance, known.len(), limit) else {
            return Ok(());
        };
        self.known_misfits.extend(mean.misfits.iter().map(|misfit| {
            let station = &self.campaign.stations[known[misfit.observation].station];
            misfit.of(format!("dead path of {}", station.name), misfit.difference)
        }));
        let kept = known.into_iter().zip(&mean.weights);
        let kept = kept.filter(|(_, weight)| **weight != 0.0);
        let network = Network {
            dead_paths: kept.map(|(known, _)| known).collect(),
            ..self.screened.network.clone()
        };
        self.screened = self.solved_again(network)?;
        Ok(())
    }

    /// The same with a network of the same lengths.
    pub(crate) fn solved_again(&self, network: Network) -> Result<Screened, Error> {
        let solution = solve_from(&network, &self.screened.solution);
        let words = |error| adjustment_error(self.campaign, self.lengths, &self.groups, error);
        Ok(Screened {
            solution: Arc::new(solution.map_err(words)?),
            network,
            tests: None,
            ..self.screened.clone()
        })
    }

    /// What a user must know of it.
    pub(crate) fn known_notices(&self) -> Vec<String> {
        let misfits = self.known_misfits.iter();
        let mut notices: Vec<String> = misfits.map(KnownMisfit::notice).collect();
        let missing = self.campaign.known_lengths.iter().filter(|known| {
            let is_seen = |t: usize| self.groups.iter().any(|group| group.targets.contains(&t));
            !known.targets.into_iter().all(is_seen)
        });
        notices.extend(missing.map(|known| {
            let [a, b] = known.targets.map(|t| &self.campaign.targets[t].name);
            format!("known length {a}-{b} is not used: no lengths to both of its targets")
        }));
        notices
    }
}

impl KnownMisfit {
    fn notice(&self) -> String {
        format!(
            "{} is {:+.1} µm from what the lengths and all else that is known say ({}): it is not used \
             unless nothing tells which of two is wrong; check its number in campaign.json",
            self.what,
            self.difference_mm / MICROMETRE,
            trueaxis_files::p_value(self.p_value)
        )
    }
}
