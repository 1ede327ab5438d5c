//! Axes that do not return equally well: where the visits of one plainly scatter more ([`uneven_axes`]), each gets the
//! repeatability at which they all scatter alike.

use super::{Axes, AxisReturn, PLAIN, Returned, STEPS};
use crate::uneven::uneven_axes;
use crate::{Error, Screened};

/// A repeatability is converged if its variance is right to this.
const RIGHT: f64 = 0.02;

/// No axis misses its steps by more, mm (standard deviation): lengths are wrong.
const MOST_MM: f64 = 0.1;

impl Axes<'_> {
    /// How the axes return where one plainly does so worse than the others.
    pub(super) fn uneven(
        &self,
        mut ratios: Vec<AxisReturn>,
        together: Result<&Screened, &Error>,
    ) -> Option<Returned> {
        let (mut found, limit) = self.start(together)?;
        let mut is_known = false;
        self.iterate(&mut found, &mut ratios, |found, ratios| {
            let mut adjusted = match is_known {
                true => self.again(ratios, found)?,
                false => found.clone(),
            };
            for _ in 0..STEPS {
                let (network, solution) = (&adjusted.network, &adjusted.solution);
                if network.noise.repeatability_mm > MOST_MM {
                    return None;
                }
                let sweeps = (self.count, &self.sweeps[..]);
                let scatters = uneven_axes(network, solution, sweeps, is_known)?;
                is_known = true;
                let converged = scatters.iter().all(|ratio| (ratio - 1.0).abs() < RIGHT);
                // The repeatability of the network is their root mean square.
                let of_axis = |axis: usize| ratios[axis].variance * scatters[axis];
                let measured =
                    (0..ratios.len()).filter(|axis| self.of_groups.contains(&Some(*axis)));
                let measured: Vec<f64> = measured.map(of_axis).collect();
                let mean = measured.iter().sum::<f64>() / measured.len() as f64;
                for (own, ratio) in ratios.iter_mut().zip(&scatters) {
                    own.variance *= ratio / mean;
                }
                adjusted = self.again(ratios, found)?;
                if self.improve(&adjusted, ratios, PLAIN) {
                    adjusted = self.again(ratios, found)?;
                } else if converged {
                    break;
                }
            }
            Some(adjusted)
        })?;
        (found.changes() <= limit).then(|| (ratios, found.into_owned()))
    }
}
