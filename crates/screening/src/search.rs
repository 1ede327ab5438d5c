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
use crate::robust_weights::{REMOVED, spread};
use crate::screened::Screened;
use crate::step_tests::StepTest;
use crate::{Error, guard};

/// Probability that a network without gross errors loses any reading.
const READINGS_LEVEL: f64 = 0.01;

/// Asymptotic efficiency of the median as a spread, beside the standard deviation.
const MEDIAN_EFFICIENCY: f64 = 0.37;

/// Calculated lengths have residuals of rounding, whose tails have no meaning.
const LEAST_SPREAD: f64 = 0.05;

/// Readings that may be far off at the start before the nominal positions are to blame.
const MOST_FAR: f64 = 0.05;

/// Solutions at the final width.
const WELSCH_ITERATIONS: usize = 3;

/// Rounds of weights, or of snooping, after which a search that has not ended does not.
const MAX_ROUNDS: usize = 60;

/// Solutions in a row that do not reach the minimum before the search ends: their tests have no meaning.
const MOST_LOST: usize = 3;

/// The search is given up when more than this many times the allowed share of the readings have left: some would come back.
const HOPELESS: f64 = 1.5;

/// A reading whose variance has grown by more plays no part.
const WEIGHTLESS: f64 = 100.0;

/// The limit of a reading's |w| if the noise is known.
pub(crate) fn reading_limit(readings: usize) -> f64 {
    critical(READINGS_LEVEL, readings, f64::INFINITY)
}

/// The limit of |w| at which the level of all tests together is `level`; `degrees_of_freedom` are
/// those of the spread.
fn critical(level: f64, tests: usize, degrees_of_freedom: f64) -> f64 {
    student_two_sided(level / tests.max(1) as f64, degrees_of_freedom)
}

/// The search in progress: removed readings stay in the network without weight.
pub(crate) struct Search {
    network: Network,
    solution: Option<Arc<Solution>>,
    /// Where the first solution starts.
    start: Option<Start>,
    /// The tests at the solution, once they were asked for.
    tests: Option<Arc<Tests>>,
    /// The largest step of each zero there, once they were sought.
    largest_steps: Option<Vec<StepTest>>,
    /// Whether the network's noise is more than a guess.
    declared: bool,
    /// Share of the readings that may leave.
    most_removed: f64,
    /// Readings that were far off at the start, and by how much (mm).
    far: Vec<(usize, f64)>,
    /// Readings that left because nothing checks them beside a wrong one: they do not come back.
    unchecked: Vec<bool>,
    /// So many steps were found that they are none: something else changes with time.
    never_split: bool,
    /// Whether occupations are split where a zero or a tripod wanders, too.
    pub(crate) cuts_what_wanders: bool,
    /// What the interruptions certainly are not.
    excluded: Vec<(Interruption, Excluded)>,
    /// Whether the snooping came to an end.
    settled: bool,
    /// Solutions in a row that did not reach the minimum.
    lost: usize,
    /// Once the network's noise is estimated, so that w has unit variance, its degrees of freedom.
    noise_known: Option<f64>,
}

impl Search {
    /// Work on a copy of `network` with this noise at first; readings that are far off at the start have left already.
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
        let mut variance_factors = vec![1.0; readings];
        for &(reading, _) in &far {
            variance_factors[reading] = REMOVED;
        }
        Ok(Self {
            network: Network {
                variance_factors,
                noise,
                ..network.clone()
            },
            solution: None,
            start: Some(start),
            tests: None,
            largest_steps: None,
            declared,
            most_removed,
            far,
            unchecked: vec![false; readings],
            never_split: false,
            cuts_what_wanders: false,
            excluded: Vec::new(),
            settled: true,
            lost: 0,
            noise_known: None,
        })
    }

    /// From now on the tests use this noise. A part with few degrees of freedom is small beside the
    /// other one, which then counts.
    fn noise_is_known(&mut self, noise: &NoiseEstimate) {
        self.network.noise = noise.noise;
        let (length, repeatability) = (noise.length, noise.repeatability);
        let degrees = length
            .degrees_of_freedom
            .max(repeatability.degrees_of_freedom);
        self.noise_known = Some(degrees);
    }

    fn solve(&mut self) -> Result<(), Error> {
        if let Some(near) = self.solution.take() {
            return self.solve_near(&near);
        }
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
        let solution = solve_from(&self.network, near);
        // With all lengths at full weight it could be solved: what is left is too little.
        self.take(Arc::new(
            solution.map_err(|error| self.nothing_left(error))?,
        ));
        Ok(())
    }

    /// Goes on from the clean adjustment with the noise that was estimated in it.
    pub(crate) fn go_on_from(&mut self, screened: &Screened) -> Result<(), Error> {
        self.noise_is_known(&screened.noise);
        if self.is_whole(&screened.network) && screened.solution.termination.is_converged() {
            self.take(Arc::clone(&screened.solution));
            return Ok(());
        }
        self.solve_near(&screened.solution)
    }

    /// Whether the work has all lengths with full weight, so that it is the adjustment of `clean`.
    fn is_whole(&self, clean: &Network) -> bool {
        self.network.noise == clean.noise
            && self.network.interruptions == clean.interruptions
            && self.network.readings.len() == clean.readings.len()
            && self
                .network
                .variance_factors
                .iter()
                .all(|f| f.total_cmp(&1.0).is_eq())
    }

    fn take(&mut self, solution: Arc<Solution>) {
        self.lost = match solution.termination.is_converged() {
            true => 0,
            false => self.lost + 1,
        };
        self.solution = Some(solution);
        self.tests = None;
        self.largest_steps = None;
    }

    fn is_lost(&self) -> bool {
        self.lost >= MOST_LOST
    }

    /// A reading may be so wrong that even without weight it drives the adjustment away.
    fn driven_away(&self, error: multilateration::Error) -> multilateration::Error {
        match error {
            multilateration::Error::StationsNotDetermined { .. } => {
                self.ran_away().unwrap_or(error)
            }
            error => error,
        }
    }

    /// That the reading that was farthest off at the start drove the adjustment away, if one was far.
    fn ran_away(&self) -> Option<multilateration::Error> {
        let farthest = self.far.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        farthest.map(|&(reading, residual_mm)| multilateration::Error::RanAway {
            reading,
            residual_mm,
        })
    }

    /// So many readings have lost their weight that the others do not determine the network; if none
    /// has, one that was far off did it.
    fn nothing_left(&self, error: multilateration::Error) -> Error {
        match self.too_many(0.0) {
            Err(too_many) => too_many,
            Ok(()) => self.ran_away().unwrap_or(error).into(),
        }
    }

    /// That more than this share of the readings has lost its weight.
    fn too_many(&self, share: f64) -> Result<(), Error> {
        let readings = self.network.readings.len();
        let factors = self.network.variance_factors.iter().enumerate();
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
        let all = |solution: &Arc<Solution>| solution.tests(&self.network);
        let new = || Arc::new(self.solution.as_ref().map(all).unwrap_or_default());
        let tests = Arc::clone(self.tests.get_or_insert_with(new));
        let spread = match (self.noise_known, self.declared) {
            (Some(_), _) => 1.0,
            // With few lengths the median may be small by chance; what is declared is not.
            (None, true) => self.spread(&tests.readings).max(1.0),
            (None, false) => self.spread(&tests.readings),
        };
        Ok((tests, spread))
    }

    /// The tests at a solution, if it is the present one and was tested.
    pub(crate) fn tests_at(&self, solution: &Arc<Solution>) -> Option<Arc<Tests>> {
        let present = self.solution.as_ref()?;
        self.tests
            .clone()
            .filter(|_| Arc::ptr_eq(present, solution))
    }

    fn spread(&self, tests: &[ReadingTest]) -> f64 {
        spread(tests, &self.network.variance_factors).max(LEAST_SPREAD)
    }

    /// The limit of |w| in spreads. The spread has the degrees of freedom of the noise; the median, which
    /// gives it before that is estimated, is worth a third of them.
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
            || self.step(&tests.readings, spread).is_some())
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
        // What is not significant in the end was none, and is not sought again.
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

    /// Lets go of readings that nothing checks beside a wrong one.
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
                self.network.variance_factors[reading] = REMOVED;
            }
            self.solve()?;
        }
    }
}
