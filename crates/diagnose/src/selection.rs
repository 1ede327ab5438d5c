//! Choosing a cause: hypotheses against residuals.
//!
//! The base model leaves the whitened residuals `e = M y`, where `M` projects out everything that it
//! absorbs ([`Projection`]). A hypothesis brings columns `X` (what a unit of each of its parameters does
//! to the observations). What it explains is
//!
//! ```text
//! T = sᵀ G⁺ s      s = Xᵀ e      G = Xᵀ M X
//! ```
//!
//! the drop of the sum of squares when its parameters join the adjustment. Hypotheses with an instant,
//! a time constant or a period do this for each of its values ([`Scan`]).
//!
//! Three numbers judge it. Its *p-value* is that of the F test of `T`; over all hypotheses and shapes
//! together the smallest p-value is compared with what noise alone gives through the same projection
//! ([`Null`]). Its *BIC* is the usual one. Its *evidence* is twice the logarithm of the marginal
//! likelihood ratio against the base model, with a prior for the parameters that is isotropic in their
//! common unit and as wide as suits the data best, and flat over shapes and subjects
//! ([`Score::evidence`]): a vector that happens to point along the beam costs what this coincidence is
//! worth, where the BIC charges every parameter alike.

mod f_test;
mod fixed_scan;
mod gram;
mod gram_matrix;
mod null;
mod projection;
mod rivals;
mod scan;
mod score;
mod shares;
mod soft;
mod step_scan;

pub(crate) use f_test::{f_test, ln_f_test};
pub(crate) use fixed_scan::{FixedScan, middle};
pub(crate) use gram::{Gram, restricted_likelihood};
pub(crate) use gram_matrix::{gram as gram_of, gram_matrix};
pub(crate) use null::Null;
pub(crate) use projection::{Projection, add, combined, lengths_beside_earlier};
pub(crate) use rivals::{ALIKE, DECISIVE, Fit, cosine, is_rival};
pub(crate) use scan::{Hypothesis, Scan};
pub(crate) use score::{EQUAL, Score, best_shape, by_evidence, mean_evidence, rank};
pub(crate) use shares::Part;
pub use shares::Shares;
pub(crate) use step_scan::{StepScan, VisitTimes};
pub(crate) use trueaxis_leastsquares::dot;
