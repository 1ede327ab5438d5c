//! Choosing a cause: hypotheses compared by residuals.
//!
//! The base model leaves the whitened residuals `e = M y`, where `M` projects out everything that it absorbs
//! ([`Projection`]). A hypothesis adds columns `X`: the effect of a unit of each of its parameters on the
//! observations. It explains
//!
//! ```text
//! T = sᵀ G⁺ s      s = Xᵀ e      G = Xᵀ M X
//! ```
//!
//! the drop of the sum of squares when its parameters join the adjustment. For hypotheses with an instant, a time
//! constant or a period, `T` is computed for each value of that shape ([`Scan`]).
//!
//! Three numbers judge a hypothesis. Its *p-value* is that of the F test of `T`; the smallest p-value over all
//! hypotheses and shapes is compared with what noise alone gives through the same projection ([`Null`]). Its *BIC* is
//! the usual one. Its *2 ln B* is twice the logarithm of the Bayes factor against the base model (Kass and Raftery 1995), with
//! a prior of the parameters that is isotropic in their common unit, as wide as the data suggest, and flat over
//! shapes and subjects ([`Score::two_ln_b`]): a vector that happens to point along the beam costs as much as this
//! coincidence is unlikely, whereas the BIC charges every parameter alike.
//!
//! Noun in: whitened residuals and the columns that their base model absorbs (a [`Projection`]), and hypotheses with
//! whitened columns ([`Scan`]); noun out: a [`Score`] of each, and whether two of them are rivals ([`is_rival`]). The
//! crate knows neither machines nor lengths, does not whiten, and decides nothing about a machine:
//! `trueaxis-diagnose` does.
//!
//! ```
//! use trueaxis_selection::{Fit, Projection, f_test, gram_of};
//!
//! // Six readings whose mean is the base model; from the third on they are 2 higher, with noise of 0.1.
//! let readings = vec![0.1, -0.1, 2.0, 2.1, 1.9, 2.0];
//! let base = Projection::dense(readings, &[vec![1.0; 6]]);
//! let step = vec![vec![0.0, 0.0, 1.0, 1.0, 1.0, 1.0]];
//! let fit = Fit::new(&base, &step);
//! assert!((fit.estimates[0] - 2.0).abs() < 1e-12);
//! // T of one column, and the F test of it with 5 - 1 degrees of freedom.
//! assert_eq!(gram_of(&base, &step).rank(), 1);
//! assert!(f_test(fit.gained(), base.squares, 1, 5.0) < 1e-4);
//! ```

mod f_test;
mod fixed_scan;
mod gram;
mod gram_matrix;
mod instant_scan;
mod ln_chi_squared;
mod null;
mod projection;
mod rivals;
mod running_sums;
mod scan;
mod score;
mod shape_columns;
mod soft;
mod visit_times;

pub use f_test::{f_test, ln_f_test};
pub use fixed_scan::{FixedScan, middle};
pub use gram::{Gram, restricted_likelihood};
pub use gram_matrix::{gram as gram_of, gram_matrix};
pub use instant_scan::InstantScan;
pub use ln_chi_squared::ln_chi_squared;
pub use null::Null;
pub use projection::{Projection, add, combined, lengths_beside_earlier};
pub use rivals::{ALIKE, DECISIVE, Fit, cosine, is_rival};
pub use scan::{Hypothesis, OfOne, OfSeveral, Scan, Tried};
pub use score::{EQUAL, Score, best_shape, by_two_ln_b, mean_two_ln_b, rank};
pub use shape_columns::ShapeColumns;
pub use visit_times::VisitTimes;
