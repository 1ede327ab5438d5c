//! Rank-checked weighted least squares, dense and in block-arrowhead form.
//!
//! The problem: unknowns that fall into many small *blocks* `x_i` (the coordinates of a point, the
//! pose of a stage) and a few *shared* ones `s` (stations, dead paths), with whitened residuals
//!
//! ```text
//! minimise  Σ_i | r_i - A_i δx_i - B_i δs |²   subject to   Σ_i H_iᵀ δx_i = h
//! ```
//!
//! Every block is eliminated on its own by Householder reflections, which leaves a small system in
//! `s` and the datum multipliers. Time and memory are linear in the number of rows; the matrix of
//! the whole problem is never formed. The same factors give the covariance of everything:
//! `cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ` ([`Covariance`]).
//!
//! Noun in: an [`Adjustment`] (a model that linearises itself at a state); noun out: an
//! [`Adjusted`] state with its covariance and the reason why the iteration stopped. [`dense`]
//! is the same for small full matrices, linear ([`dense::solve`]) and not ([`dense::adjust()`]).
//! Rank is decided here, with numbers, never left to a factorisation that divides by zero. The
//! crate knows no geometry and no files.
//!
//! ```
//! use trueaxis_leastsquares::{Arrowhead, BlockRows, Datum};
//!
//! // Two scales with unknown zero (shared) weigh two masses (blocks); mass 0 is held at 1.
//! let mut system = Arrowhead::new(2, 1);
//! for (readings, datum) in [([1.5, 3.0], 1.0), ([2.5, 4.0], 0.0)] {
//!     let mut rows = BlockRows::new(2, 1, 2);
//!     for (scale, reading) in readings.into_iter().enumerate() {
//!         rows.block_mut(0)[scale] = 1.0;
//!         rows.shared_mut(scale)[scale] = 1.0;
//!         rows.residual_mut()[scale] = reading;
//!     }
//!     system.eliminate(&mut rows, &[datum])?;
//! }
//! // The data do not change when the masses grow and both zeros fall by as much.
//! let datum = Datum { free_motions: vec![vec![-1.0, -1.0]], closure: vec![1.0] };
//! let solved = system.solve(&datum)?;
//! assert!((solved.correction.shared[0] - 0.5).abs() < 1e-12);
//! assert!((solved.correction.shared[1] - 2.0).abs() < 1e-12);
//! assert!((solved.correction.block(1)[0] - 2.0).abs() < 1e-12);
//! # Ok::<(), trueaxis_leastsquares::Error>(())
//! ```

mod arrowhead;
mod block;
mod chi_squared;
mod covariance;
pub mod dense;
mod error;
mod gauss_newton;
mod reduced;
mod student;

pub use arrowhead::{Arrowhead, Correction, Solved};
pub use block::BlockRows;
pub use chi_squared::{chi_squared_quantile, chi_squared_upper_tail};
pub use covariance::Covariance;
pub use error::Error;
pub use gauss_newton::{Adjusted, Adjustment, Settings, Termination, adjust};
pub use reduced::Datum;
pub use student::student_two_sided;
