//! Whether the targets of each step are where the shape of their body, which all steps share, has them.
//!
//! The adjustment with rigid stages says by how much its sum of squares `S` drops if the body has another shape at one
//! step ([`trueaxis_multilateration::OwnShapes`]). Where the noise is estimated, that is compared with what is left:
//!
//! ```text
//! F = (drop / d) / ((S - drop) / (ν - d))
//! ```
//!
//! with the degrees of freedom `d` of the step, and `ν` of the adjustment that determine the variance of a length. Steps
//! that fail are freed, the worst first, and no longer bend the shape, the stations and the noise for the others.

use rayon::prelude::*;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::{chi_squared_upper_tail, f_upper_tail};
use trueaxis_multilateration::{Network, OwnShapeTest, Solution};
use trueaxis_screening::solve_as_a_set;

use crate::lengths::LengthsAdjustment;
use crate::lengths::network::network_from_campaign;
use crate::report::StepMisfit;
use crate::words::step_in_words;

/// Family-wise significance of the test of all steps together.
const LEVEL: f64 = 0.01;

/// A step moves the others less than half as much as itself if the body was measured at three steps or more: steps with
/// this part of the largest drop fail by themselves.
const BY_ITSELF: f64 = 0.5;

/// Lengths without noise leave rounding.
const LEAST_VARIANCE: f64 = 1e-6;

/// Steps that one thread takes at a time.
const CHUNK: usize = 32;

impl LengthsAdjustment<'_> {
    /// The steps whose targets contradict a rigid body, in measuring order; none where there is no adjustment with rigid stages.
    pub(crate) fn steps_not_rigid(&self) -> Vec<StepMisfit> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        if network.bodies.is_some() {
            return self.not_rigid_in(network, solution);
        }
        let nominal =
            network_from_campaign(self.campaign, self.lengths, self.settings.by_direction);
        let mut rigid = Network {
            bodies: nominal.network.bodies,
            ..network.clone()
        };
        let solved = solve_as_a_set(&mut rigid, Some(solution));
        let solved = solved.ok().filter(|s| s.termination.is_converged());
        solved.map_or_else(Vec::new, |solution| self.not_rigid_in(&rigid, &solution))
    }

    fn not_rigid_in(&self, network: &Network, solution: &Solution) -> Vec<StepMisfit> {
        let mut shapes = solution.own_shapes(network);
        let mut bound = self.moved();
        let level = LEVEL / bound.len().max(1) as f64;
        let degrees_of_freedom = self.screened.noise.length.degrees_of_freedom;
        let mut noise = LeftNoise::new(solution, degrees_of_freedom);
        let mut freed: Vec<usize> = Vec::new();
        loop {
            let drop = |&g: &usize| {
                let test = shapes.test(g)?;
                (noise.without(&test).p_value(&test) < level).then_some((g, test))
            };
            let failing = bound.par_iter().with_min_len(CHUNK).filter_map(drop);
            let mut failing: Vec<(usize, OwnShapeTest)> = failing.collect();
            let drops = failing.iter().map(|(_, test)| test.drop);
            let least = BY_ITSELF * drops.fold(0.0, f64::max);
            failing.retain(|(_, test)| test.drop >= least);
            let before = freed.len();
            for (g, test) in failing {
                if let Some(drop) = shapes.free(g) {
                    noise = noise.without(&OwnShapeTest { drop, ..test });
                    freed.push(g);
                }
            }
            if freed.len() == before {
                break;
            }
            freed.sort_unstable();
            bound.retain(|g| freed.binary_search(g).is_err());
        }
        let misfit = |g: usize| {
            let test = shapes.test(g)?;
            let p_value = noise.p_value(&test);
            (p_value < level).then(|| StepMisfit {
                step: step_in_words(self.campaign, self.groups[g].step),
                rms_um: test.rms_mm / MICROMETRE,
                chi_squared: test.drop / noise.variance(),
                degrees_of_freedom: test.degrees_of_freedom,
                p_value,
            })
        };
        freed.into_iter().filter_map(misfit).collect()
    }
}

/// The noise that steps do not explain.
#[derive(Clone, Copy)]
struct LeftNoise {
    /// Sum of squares of the adjustment in units of its noise, and its degrees of freedom.
    squares: f64,
    degrees_of_freedom: f64,
    /// Those that determine the variance of a length; infinite where the noise was not estimated.
    part: f64,
}

impl LeftNoise {
    /// The variance of a length was estimated with `of_length` degrees of freedom.
    fn new(solution: &Solution, of_length: f64) -> Self {
        let degrees_of_freedom = solution.degrees_of_freedom() as f64;
        Self {
            squares: solution.squares,
            degrees_of_freedom,
            part: of_length / degrees_of_freedom,
        }
    }

    /// What is left without a step that is tested.
    fn without(self, test: &OwnShapeTest) -> Self {
        Self {
            squares: self.squares - test.drop,
            degrees_of_freedom: self.degrees_of_freedom - test.degrees_of_freedom as f64,
            ..self
        }
    }

    fn variance(self) -> f64 {
        match self.part.is_finite() {
            true => (self.squares / self.degrees_of_freedom).max(LEAST_VARIANCE),
            false => 1.0,
        }
    }

    fn p_value(self, test: &OwnShapeTest) -> f64 {
        let (left, degrees) = (self.degrees_of_freedom, test.degrees_of_freedom as f64);
        let chi_squared = test.drop / self.variance();
        match self.part.is_finite() {
            true if left > 0.0 => {
                f_upper_tail(chi_squared / degrees, degrees, left * self.part.min(1.0))
            }
            true => 1.0,
            false => chi_squared_upper_tail(chi_squared, degrees),
        }
    }
}
