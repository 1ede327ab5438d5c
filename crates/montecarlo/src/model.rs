//! What is propagated.

use rand_chacha::ChaCha8Rng;

/// A measurement model together with the distributions of its inputs.
///
/// The generator is [`ChaCha8Rng`]: it has 2⁶⁴ streams under one seed, which a trial reaches
/// without stepping through those before it, and with 8 rounds it already passes the known tests of
/// randomness; the 12 or 20 rounds of its siblings serve secrecy.
pub trait Model: Sync {
    /// Storage that a trial may use, so that it need not allocate. What a trial leaves in it must
    /// not change the result of a later one.
    type Workspace;

    /// Number of output quantities, the same for every trial.
    fn outputs(&self) -> usize;

    /// Storage for trials; made a few times per thread, not once per trial.
    fn workspace(&self) -> Self::Workspace;

    /// One trial: draws every input from `rng`, which stands at the start of the trial's own
    /// stream, and writes the [`Model::outputs`] values of the model. A trial that fails leaves or
    /// writes a value that is not finite (`outputs` comes filled with NaN); the propagation then
    /// ends with [`Error::NotFinite`](crate::Error::NotFinite), because leaving failures out would
    /// bias the distribution.
    fn trial(&self, rng: &mut ChaCha8Rng, workspace: &mut Self::Workspace, outputs: &mut [f64]);
}
