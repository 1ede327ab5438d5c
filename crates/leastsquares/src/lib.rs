//! Rank-checked weighted least squares, dense and in block-arrowhead form.
//!
//! The problem: unknowns that fall into many small *blocks* `x_i` (the coordinates of a point, the
//! pose of a stage) and a few *shared* ones `s` (stations, dead paths), with whitened residuals
//!
//! ```text
//! minimise  Σ_i | r_i - A_i δx_i - B_i δs |²   subject to   Σ_i H_iᵀ δx_i = h
//! ```
//!
//! Blocks are eliminated eight at a time ([`BlockBatch`]), which leaves a small system in `s` and the
//! datum multipliers ([`Reduced`]). Time and memory are linear in the number of rows; the matrix of
//! the whole problem is never formed. The factors of all blocks ([`Factors`]) give the covariance of
//! everything:
//! `cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ` ([`Covariance`]).
//!
//! Noun in: an [`Adjustment`] (a model that linearises itself at a state); noun out: an
//! [`Adjusted`] state, its covariance and the reason why the iteration stopped. [`dense`]
//! is the same for small full matrices, linear ([`dense::solve`]) and not ([`dense::adjust()`]).
//! Rank is decided here, with numbers, never left to a factorisation that divides by zero. The
//! crate knows no geometry and no files.
//!
//! ```
//! use trueaxis_leastsquares::{BlockBatch, LaneSums, Lanes, Shape};
//!
//! // Two balances with unknown zero (shared) weigh two masses (blocks, one in each lane); mass 0 is
//! // held at 1.
//! let mut masses = BlockBatch::default();
//! masses.reset(Shape { rows: 2, unknowns: 1, in_quads: 0, shared: 2, datum: 1 });
//! for (row, readings) in [[1.5, 2.5], [3.0, 4.0]].into_iter().enumerate() {
//!     let row_of_balance = masses.row_mut(row);
//!     *row_of_balance.residual = Lanes::from_fn(|mass| readings[mass % 2]);
//!     row_of_balance.own.fill(Lanes::splat(1.0));
//!     row_of_balance.others.fill(Lanes::ZERO);
//!     row_of_balance.others[row] = Lanes::splat(1.0);
//! }
//! masses.datum_mut(0)[0].0[0] = 1.0;
//! masses.closure_mut()[0].0[0] = 1.0;
//! masses.use_only(2);
//! masses.eliminate(|mass| (mass, 2))?;
//! let mut sums = LaneSums::new(2, 1);
//! sums.count(4, 2);
//! masses.add_to(&mut sums);
//! // The data do not change when the masses grow and both zeros fall by as much.
//! let solved = sums.reduced().solve(|| vec![vec![-1.0, -1.0]])?;
//! assert!((solved.unknowns[0] - 0.5).abs() < 1e-12);
//! assert!((solved.unknowns[1] - 2.0).abs() < 1e-12);
//! let mut kept = vec![Lanes::ZERO; BlockBatch::kept_len(1)];
//! masses.keep(&mut kept);
//! masses.take_off(&solved.unknowns[..2]);
//! assert!((masses.correction(&kept)[0].0[1] - 2.0).abs() < 1e-12);
//! # Ok::<(), trueaxis_leastsquares::Error>(())
//! ```

mod block_batch;
mod chi_squared;
mod covariance;
mod definite;
pub mod dense;
mod dot;
mod error;
mod factors;
mod free_gauge;
mod gauss_newton;
mod half_waves;
mod hat_rows;
pub mod lane_products;
mod lane_sums;
mod lanes;
mod last_digit;
mod median;
mod reduced;
mod student;
mod widest_registers;

pub use block_batch::{BLOCK_RANK_TOL, BlockBatch, RowMut, Shape};
pub use chi_squared::{chi_squared_quantile, chi_squared_upper_tail, f_upper_tail};
pub use covariance::Covariance;
pub use dot::dot;
pub use error::Error;
pub use factors::{BatchFactors, Factors};
pub use free_gauge::Correction;
pub use gauss_newton::{Adjusted, Adjustment, Termination, adjust};
pub use half_waves::{half_waves, matern_roots};
pub use hat_rows::HatRows;
pub use lane_sums::LaneSums;
pub use lanes::{LANES, Lanes, add_times, lanes_only, zeros};
pub use last_digit::last_digit;
pub use median::median;
pub use reduced::{Reduced, ReducedSolution};
pub use student::student_two_sided;
pub use widest_registers::in_widest_registers;
