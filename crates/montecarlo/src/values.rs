//! Running the trials and keeping their values.

use std::sync::atomic::{AtomicUsize, Ordering};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use crate::error::Error;
use crate::model::Model;

/// Trials that one thread makes in a row. Inside a chunk the values of an output stand together,
/// so that collecting an output over all trials reads whole cache lines.
const CHUNK_TRIALS: usize = 128;

/// Which trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    All,
    LastBatch,
}

/// The values of all outputs in all trials.
///
/// Each batch holds chunks of trials in order, each chunk its values output by output: output 0 of
/// the chunk's trials, output 1 of them, and so on.
#[derive(Clone, Default)]
pub(crate) struct Values {
    outputs: usize,
    pub(crate) trials: usize,
    batches: Vec<Vec<f64>>,
}

impl std::fmt::Debug for Values {
    /// Without the millions of values themselves.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Values")
            .field("outputs", &self.outputs)
            .field("trials", &self.trials)
            .finish_non_exhaustive()
    }
}

impl Values {
    pub(crate) fn new(outputs: usize) -> Self {
        Self {
            outputs,
            ..Self::default()
        }
    }

    /// Makes further trials, numbered on from those that are there.
    pub(crate) fn append<M: Model>(
        &mut self,
        model: &M,
        seed: u64,
        trials: usize,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<(), Error> {
        let outputs = self.outputs;
        let mut batch = allocated(outputs, trials)?;
        let root = ChaCha8Rng::seed_from_u64(seed);
        let done = AtomicUsize::new(self.trials);
        let failed_chunk = AtomicUsize::new(usize::MAX);

        // Chunks before a failed one always run, so the first failure is found on any number of
        // threads; chunks after it need not.
        let failure = batch
            .par_chunks_mut(CHUNK_TRIALS * outputs)
            .enumerate()
            .map_init(
                || (model.workspace(), vec![f64::NAN; outputs]),
                |(workspace, row), (index, chunk)| {
                    if index > failed_chunk.load(Ordering::Relaxed) {
                        return None;
                    }
                    let first = self.trials + index * CHUNK_TRIALS;
                    let failure = fill_chunk(model, &root, first, workspace, row, chunk);
                    if failure.is_some() {
                        failed_chunk.fetch_min(index, Ordering::Relaxed);
                    }
                    let made = chunk.len() / outputs;
                    progress(done.fetch_add(made, Ordering::Relaxed) + made);
                    failure
                },
            )
            .reduce(|| None, Option::or);
        if let Some(error) = failure {
            return Err(error);
        }
        self.trials += trials;
        self.batches.push(batch);
        Ok(())
    }

    /// The values of one output in the order of the trials.
    pub(crate) fn of(&self, part: Part, output: usize) -> impl Iterator<Item = f64> + '_ {
        let chunks = self
            .batches_of(part)
            .iter()
            .flat_map(|batch| batch.chunks(CHUNK_TRIALS * self.outputs));
        let column = chunks.flat_map(move |chunk| {
            let made = chunk.len() / self.outputs;
            &chunk[output * made..][..made]
        });
        column.copied()
    }

    /// Applies `statistics` to the number of each output and its values; they may be reordered.
    pub(crate) fn map_outputs<T: Send>(
        &self,
        part: Part,
        statistics: impl Fn(usize, &mut [f64]) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let length: usize = self.batches_of(part).iter().map(Vec::len).sum();
        let trials = length / self.outputs;
        let found: Vec<_> = (0..self.outputs)
            .into_par_iter()
            .map_init(Vec::new, |column, output| {
                column.clear();
                column.reserve_exact(trials);
                column.extend(self.of(part, output));
                statistics(output, column)
            })
            .collect();
        // Only now, in the order of the outputs: of several errors the first is reported.
        found.into_iter().collect()
    }

    fn batches_of(&self, part: Part) -> &[Vec<f64>] {
        let last_only = self.batches.len().saturating_sub(1);
        match part {
            Part::All => &self.batches,
            Part::LastBatch => &self.batches[last_only..],
        }
    }
}

/// Room for the values of a number of trials.
fn allocated(outputs: usize, trials: usize) -> Result<Vec<f64>, Error> {
    let no_room = Error::Allocation { outputs, trials };
    let Some(length) = outputs.checked_mul(trials) else {
        return Err(no_room);
    };
    let mut batch = Vec::new();
    batch.try_reserve_exact(length).map_err(|_| no_room)?;
    batch.resize(length, f64::NAN);
    Ok(batch)
}

/// Makes the trials of one chunk from number `first` on, each from its own stream; stops at the
/// first that has an output which is not finite.
fn fill_chunk<M: Model>(
    model: &M,
    root: &ChaCha8Rng,
    first: usize,
    workspace: &mut M::Workspace,
    row: &mut [f64],
    chunk: &mut [f64],
) -> Option<Error> {
    let made = chunk.len() / row.len();
    for place in 0..made {
        let trial = (first + place) as u64;
        let mut rng = root.clone();
        rng.set_stream(trial);
        row.fill(f64::NAN);
        model.trial(&mut rng, workspace, row);
        if let Some(output) = row.iter().position(|value| !value.is_finite()) {
            let value = row[output];
            return Some(Error::NotFinite {
                trial,
                output,
                value,
            });
        }
        for (output, value) in row.iter().enumerate() {
            chunk[output * made + place] = *value;
        }
    }
    None
}
