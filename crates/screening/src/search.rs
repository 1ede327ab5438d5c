//! The search of [`crate::screen`]: weights, tests and removals.

mod clean_adjustment;
mod far_readings;
mod snooping;
mod splits;

use std::sync::Arc;

use trueaxis_leastsquares::student_two_sided;
use trueaxis_multilateration::{
    self as multilateration, Interruption, Network, Noise, ReadingTest, Solution, Start, Tests,
    Whitened, solve, solve_from,
};

use self::far_readings::far_at;
use crate::estimate_noise::NoiseEstimate;
use crate::interruption::Excluded;
use crate::jump_tests::JumpTest;
use crate::robust_weights::{REMOVED, spread};
use crate::screened::Screened;
use crate::uneven::weigh_uneven;
use crate::{Error, guard};

/// Probability that a network without gross errors loses any reading.
const READINGS_LEVEL: f64 = 0.01;

/// Asymptotic efficiency of the median as an estimate of the spread, against the standard deviation.
const MEDIAN_EFFICIENCY: f64 = 0.37;

/// Least spread: calculated lengths have residuals of rounding, whose tails have no meaning.
const LEAST_SPREAD: f64 = 0.05;

/// Share of readings that may be far off at the start before the nominal positions are to blame.
const MOST_FAR: f64 = 0.05;

/// Solutions at the final width of the weights.
const WELSCH_ITERATIONS: usize = 3;

/// Rounds of weights, or of snooping, after which a search counts as not settling.
const MAX_ROUNDS: usize = 60;

/// Consecutive solutions that do not converge before the search ends: their tests have no meaning.
const MOST_LOST: usize = 3;

/// The search is given up when more than this many times the allowed share are removed: some may still come back.
const HOPELESS: f64 = 1.5;

/// A reading whose variance is inflated by more than this has no influence.
const WEIGHTLESS: f64 = 100.0;

/// The limit of a reading's |w| if the noise is known.
pub(crate) fn reading_limit(readings: usize) -> f64 {
    critical(READINGS_LEVEL, readings, f64::INFINITY)
}

/// The limit of |w| of a jump of a zero.
pub(crate) fn jump_limit(readings: usize) -> f64 {
    critical(splits::STEPS_LEVEL, readings, f64::INFINITY)
}

/// The limit of |w| at which all tests together have the level `level`; `degrees_of_freedom` are those of the spread.
fn critical(level: f64, tests: usize, degrees_of_freedom: f64) -> f64 {
    student_two_sided(level / tests.max(1) as f64, degrees_of_freedom)
}

/// The search in progress: removed readings stay in the network without weight.
pub(crate) struct Search {
    network: Network,
    /// Factors on the variances of the readings with which the search lets them go, beside those that they have.
    inflation: Vec<f64>,
    /// The factors that they have; empty where all are one.
    given: Vec<f64>,
    solution: Option<Arc<Solution>>,
    /// The start of the first solution.
    start: Option<Start>,
    /// The tests at the solution, once they were needed.
    tests: Option<Arc<Tests>>,
    /// The largest jump of each zero at the solution, once it was sought.
    largest_jumps: Option<Vec<JumpTest>>,
    /// Whether the network's noise is more than a guess.
    declared: bool,
    /// Share of the readings that may be removed.
    most_removed: f64,
    /// Readings that were far off at the start, and by how much (mm).
    far: Vec<(usize, f64)>,
    /// Readings that were removed because nothing checks them without a wrong one: they do not come back.
    unchecked: Vec<bool>,
    /// How often each reading came back in the last snooping.
    returns: Vec<u8>,
    /// So many jumps were found that something else changes with time: no occupation is split.
    never_split: bool,
    /// Whether occupations are also split where a zero or a tripod wanders.
    pub(crate) splits_what_wanders: bool,
    /// Explanations of the interruptions that are certainly wrong.
    excluded: Vec<(Interruption, Excluded)>,
    /// Whether the snooping came to an end.
    converged: bool,
    /// Consecutive solutions that did not converge.
    lost: usize,
    /// Degrees of freedom of the network's noise once it is estimated; w then has unit variance.
    noise_known: Option<f64>,
}

impl Search {
    /// A search in a copy of `network` with this noise; readings that are far off at the start are removed already.
    pub(crate) fn new(
        network: &Network,
        noise: Noise,
        declared: bool,
        most_removed: f64,
    ) -> Result<Self, Error> {
        let start = Start::new(network)?;
        let mut far = far_at(&start, network);
        if far.len() as f64 > MOST_FAR * network.readings.len() as f64 {
            far.clear();
        }
        let readings = network.readings.len();
        let mut inflation = vec![1.0; readings];
        for &(reading, _) in &far {
            inflation[reading] = REMOVED;
        }
        Ok(Self {
            network: Network {
                noise,
                ..network.clone()
            },
            inflation,
            given: network.variance_factors.clone(),
            solution: None,
            start: Some(start),
            tests: None,
            largest_jumps: None,
            declared,
            most_removed,
            far,
            unchecked: vec![false; readings],
            returns: vec![0; readings],
            never_split: false,
            splits_what_wanders: false,
            excluded: Vec::new(),
            converged: true,
            lost: 0,
            noise_known: None,
        })
    }

    /// From now on the tests use this noise, with the larger degrees of freedom: a part with few is small beside the
    /// other.
    fn noise_is_known(&mut self, noise: &NoiseEstimate) {
        self.network.noise = noise.noise;
        let (length, repeatability) = (noise.length, noise.repeatability);
        let degrees = length
            .degrees_of_freedom
            .max(repeatability.degrees_of_freedom);
        self.noise_known = Some(degrees);
    }

    /// Gives the network the factors that its readings have now.
    fn inflate(&mut self) {
        let factors = &mut self.network.variance_factors;
        factors.clone_from(&self.inflation);
        for (factor, given) in factors.iter_mut().zip(&self.given) {
            *factor *= given;
        }
    }

    fn solve(&mut self) -> Result<(), Error> {
        if let Some(near) = self.solution.take() {
            return self.solve_near(&near);
        }
        self.inflate();
        let network = &self.network;
        let solution = match self.start.take() {
            Some(start) => start.solve(network),
            None => solve(network),
        };
        self.take(Arc::new(solution.map_err(|error| self.driven_away(error))?));
        Ok(())
    }

    /// Solves again from the solution of a similar network.
    fn solve_near(&mut self, near: &Solution) -> Result<(), Error> {
        self.inflate();
        let solution = solve_from(&self.network, near);
        // The network with all lengths at full weight could be solved: too little is left.
        self.take(Arc::new(
            solution.map_err(|error| self.nothing_left(error))?,
        ));
        Ok(())
    }

    /// Continues from the final adjustment with the noise estimated in it.
    pub(crate) fn go_on_from(&mut self, screened: &Screened) -> Result<(), Error> {
        self.noise_is_known(&screened.noise);
        if self.is_whole(&screened.network) && screened.solution.termination.is_converged() {
            self.take(Arc::clone(&screened.solution));
            return Ok(());
        }
        self.solve_near(&screened.solution)
    }

    /// Whether the search has all lengths at full weight, and so the adjustment of `clean`.
    fn is_whole(&self, clean: &Network) -> bool {
        self.network.noise == clean.noise
            && self.network.interruptions == clean.interruptions
            && self.network.readings.len() == clean.readings.len()
            && self.inflation.iter().all(|f| f.total_cmp(&1.0).is_eq())
    }

    fn take(&mut self, solution: Arc<Solution>) {
        self.lost = match solution.termination.is_converged() {
            true => 0,
            false => self.lost + 1,
        };
        self.solution = Some(solution);
        self.tests = None;
        self.largest_jumps = None;
    }

    fn is_lost(&self) -> bool {
        self.lost >= MOST_LOST
    }

    /// The error, or that one reading is so wrong that even without weight it drove the adjustment away.
    fn driven_away(&self, error: multilateration::Error) -> multilateration::Error {
        match error {
            multilateration::Error::StationsNotDetermined { .. } => {
                self.ran_away().unwrap_or(error)
            }
            error => error,
        }
    }

    /// That the reading farthest off at the start drove the adjustment away, if any was far.
    fn ran_away(&self) -> Option<multilateration::Error> {
        let farthest = self.far.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        farthest.map(|&(reading, residual_mm)| multilateration::Error::RanAway {
            reading,
            residual_mm,
        })
    }

    /// The error where too many readings have lost their weight for the others to determine the network; where none has,
    /// that the reading farthest off drove the adjustment away.
    fn nothing_left(&self, error: multilateration::Error) -> Error {
        match self.too_many(0.0) {
            Err(too_many) => too_many,
            Ok(()) => self.ran_away().unwrap_or(error).into(),
        }
    }

    /// Refuses that more than this share of the readings has lost its weight.
    fn too_many(&self, share: f64) -> Result<(), Error> {
        let readings = self.network.readings.len();
        let factors = self.inflation.iter().enumerate();
        let without_weight = factors.filter(|&(_, &factor)| factor > WEIGHTLESS);
        let removed: Vec<usize> = without_weight.map(|(reading, _)| reading).collect();
        match removed.len() as f64 > share * readings as f64 {
            true => Err(Error::TooManyGrossErrors {
                removed,
                readings,
                limit: self.most_removed,
            }),
            false => Ok(()),
        }
    }

    /// The tests at the present solution, and their spread.
    fn tests(&mut self) -> Result<(Arc<Tests>, f64), Error> {
        if self.solution.is_none() {
            self.solve()?;
        }
        let all =
            |solution: &Arc<Solution>| solution.tests_of_inflated(&self.network, &self.inflation);
        let new = || Arc::new(self.solution.as_ref().map(all).unwrap_or_default());
        let tests = Arc::clone(self.tests.get_or_insert_with(new));
        let spread = match (self.noise_known, self.declared) {
            (Some(_), _) => 1.0,
            // With few lengths the median may be small by chance: the declared noise is the least.
            (None, true) => self.spread(&tests.readings).max(1.0),
            (None, false) => self.spread(&tests.readings),
        };
        Ok((tests, spread))
    }

    /// The tests at a solution, if it is the present one and has been tested.
    pub(crate) fn tests_at(&self, solution: &Arc<Solution>) -> Option<Arc<Tests>> {
        let present = self.solution.as_ref()?;
        self.tests
            .clone()
            .filter(|_| Arc::ptr_eq(present, solution))
    }

    fn spread(&self, tests: &[ReadingTest]) -> f64 {
        spread(tests, &self.inflation).max(LEAST_SPREAD)
    }

    /// The limit of |w| in spreads. The spread has the degrees of freedom of the estimated noise; before there is
    /// one, it is a median, worth a third of the redundancy, unless the noise is declared.
    fn limit(&self, level: f64) -> f64 {
        let redundancy = self
            .solution
            .as_ref()
            .map_or(0, |solution| solution.degrees_of_freedom());
        let degrees_of_freedom = match (self.noise_known, self.declared) {
            (Some(degrees_of_freedom), _) => degrees_of_freedom,
            (None, true) => f64::INFINITY,
            (None, false) => MEDIAN_EFFICIENCY * redundancy as f64,
        };
        critical(level, self.network.readings.len(), degrees_of_freedom)
    }

    /// The rows of the hat matrix at the present solution, in measuring order.
    fn hat_rows(&self) -> Option<Whitened> {
        let solution = self.solution.as_deref()?;
        Some(Whitened::new(&self.network, solution))
    }

    /// Whether the tests ask for a change.
    pub(crate) fn suspicious(&mut self) -> Result<bool, Error> {
        if self.is_lost() {
            return Ok(false);
        }
        let (tests, spread) = self.tests()?;
        let changes = self.changes(&tests, spread);
        Ok(!changes.is_empty()
            || self.weakest_split(spread).is_some()
            || self.jump(&tests.readings, spread).is_some())
    }

    /// `original` with less weight for lengths that scatter more than the others, if any do.
    pub(crate) fn weighed(&mut self, original: &Network) -> Result<Option<Network>, Error> {
        let (tests, _) = self.tests()?;
        let Some(solution) = self.solution.as_deref() else {
            return Ok(None);
        };
        let weighed = weigh_uneven(&self.network, (solution, &tests), self.declared)?;
        Ok(weighed.map(|weighed| {
            let mut variance_factors = weighed.network.variance_factors;
            for (factor, inflation) in variance_factors.iter_mut().zip(&self.inflation) {
                *factor /= inflation;
            }
            Network {
                variance_factors,
                ..original.clone()
            }
        }))
    }

    /// Finds gross errors and interruptions until nothing changes.
    pub(crate) fn clean(&mut self) -> Result<(), Error> {
        if !self.suspicious()? {
            return Ok(());
        }
        self.unchecked.fill(false);
        if !self.network.interruptions.is_empty() {
            self.network.interruptions.clear();
            self.solve()?;
        }
        self.find_interruptions()?;
        self.redescend()?;
        self.snoop()?;
        if !self.network.interruptions.is_empty() {
            self.place_interruptions()?;
            self.snoop()?;
        }
        // Splits that are not significant in the end are undone and not sought again.
        let never_split = std::mem::replace(&mut self.never_split, true);
        loop {
            let (_, spread) = self.tests()?;
            let Some(split) = self.weakest_split(spread) else {
                break;
            };
            self.network.interruptions.remove(split);
            self.solve()?;
            self.snoop()?;
        }
        self.never_split = never_split;
        self.drop_unchecked()
    }

    /// Removes readings that nothing checks since a wrong one was removed.
    fn drop_unchecked(&mut self) -> Result<(), Error> {
        let removed = self.removed()?;
        guard::check(&self.network, &removed, self.most_removed)?;
        loop {
            let (tests, _) = self.tests()?;
            let unchecked = guard::unchecked(&self.network, &tests.readings)?;
            if unchecked.is_empty() {
                return Ok(());
            }
            for reading in unchecked {
                self.unchecked[reading] = true;
                self.inflation[reading] = REMOVED;
            }
            self.solve()?;
        }
    }
}
