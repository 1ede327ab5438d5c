//! The propagation of distributions.

use crate::coverage;
use crate::error::Error;
use crate::model::Model;
use crate::settings::{Settings, Trials};
use crate::stability::{Blocks, Stability};
use crate::summary::Summary;
use crate::values::{Part, Values};

/// The distributions of all outputs.
#[derive(Debug, Clone)]
pub struct Propagation {
    /// Coverage probability of the intervals.
    pub coverage: f64,
    /// Trials made.
    pub trials: usize,
    /// Summary of each output.
    pub outputs: Vec<Summary>,
    /// Whether an adaptive number of trials was enough; none for a fixed number.
    pub stability: Option<Stability>,
    values: Values,
}

impl Propagation {
    /// The values of an output in the order of the trials.
    ///
    /// # Panics
    /// When there is no such output.
    pub fn values(&self, output: usize) -> impl Iterator<Item = f64> + '_ {
        assert!(output < self.outputs.len(), "no output {output}");
        self.values.of(Part::All, output)
    }

    /// Correlation coefficient of two outputs; 0 where one of them does not vary.
    ///
    /// # Panics
    /// When there is no such output.
    pub fn correlation(&self, output: usize, other: usize) -> f64 {
        let (a, b) = (&self.outputs[output], &self.outputs[other]);
        let product = a.u * b.u * (self.trials - 1) as f64;
        if product < f64::MIN_POSITIVE {
            return 0.0;
        }
        let pairs = self.values(output).zip(self.values(other));
        pairs.map(|(x, y)| (x - a.mean) * (y - b.mean)).sum::<f64>() / product
    }
}

/// Propagates the distributions of the inputs of `model` to its outputs.
///
/// `progress` is told the number of trials made so far; calls come from any thread, and of two
/// that come at once the larger number may arrive first.
///
/// # Errors
/// - [`Error::NotFinite`] when a trial fails; [`Error::Overflow`] when the values are too large for
///   statistics;
/// - [`Error::Coverage`], [`Error::NoOutputs`], [`Error::TooFewTrials`],
///   [`Error::TooFewForBlocks`], [`Error::SignificantDigits`] for settings that have no meaning;
/// - [`Error::Memory`], [`Error::Allocation`], [`Error::Threads`] for too few resources.
///
/// Not stabilising is no error; see [`Propagation::stability`].
pub fn propagate<M: Model>(
    model: &M,
    settings: &Settings,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Propagation, Error> {
    settings.check(model.outputs())?;
    let Some(threads) = settings.threads else {
        return on_this_pool(model, settings, progress);
    };
    let threads = threads.get();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Error::Threads {
        threads,
        reason: error.to_string(),
    })?;
    pool.install(|| on_this_pool(model, settings, progress))
}

/// [`propagate`] in the pool that it is called in, with settings that were checked.
fn on_this_pool<M: Model>(
    model: &M,
    settings: &Settings,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Propagation, Error> {
    let mut values = Values::new(model.outputs());
    let append =
        |values: &mut Values, trials| values.append(model, settings.seed, trials, progress);
    let stability = match settings.trials {
        Trials::Fixed(trials) => {
            append(&mut values, trials)?;
            None
        }
        Trials::Adaptive {
            significant_digits,
            most,
        } => {
            let mut blocks = Blocks::new(settings.coverage, significant_digits);
            loop {
                append(&mut values, blocks.trials)?;
                let stability = blocks.add(&values)?;
                if stability.stabilised || most - values.trials < blocks.trials {
                    break Some(stability);
                }
            }
        }
    };
    let trials = values.trials;
    let coverage = settings.coverage;
    let ranks =
        coverage::ranks(trials, coverage).ok_or(Error::TooFewTrials { trials, coverage })?;
    let outputs = values.map_outputs(Part::All, |output, column| {
        Summary::of(output, column, ranks)
    })?;
    Ok(Propagation {
        coverage,
        trials,
        outputs,
        stability,
        values,
    })
}
