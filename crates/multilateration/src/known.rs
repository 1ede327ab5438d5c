//! What is known of the shared unknowns beside the lengths.
//!
//! ```text
//! 0 = a_m + e     σ of the reflectors: each contrast of their constants ([`crate::reflectors`])
//! L̂_j = L_j + m + e     a dead path that is known (absolute distance meter)
//! ```
//!
//! Lengths `|p - S| - L + k` leave open what the constants of all reflectors have in common: a solution has it in its
//! dead paths `L`. Where some of these are known, the common part is an unknown `m` of its own, the mean constant; no
//! length contains it.

use crate::Network;
use crate::state::{State, zero_column};

/// Columns of some of the shared unknowns, and the number of all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns {
    /// The mean constant of the reflectors, if there is one.
    pub(crate) mean_constant: usize,
    /// The first contrast of their constants.
    pub(crate) contrasts: usize,
    /// Number of shared unknowns.
    pub(crate) count: usize,
}

impl Columns {
    /// Columns that follow the first `behind`.
    pub(crate) fn new(network: &Network, behind: usize) -> Self {
        let contrasts = behind + usize::from(network.has_mean_constant());
        Self {
            mean_constant: behind,
            contrasts,
            count: contrasts + network.contrasts(),
        }
    }
}

/// A whitened observation of shared unknowns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KnownRow {
    /// Derivatives by the unknowns of these columns, ascending.
    pub(crate) columns: Vec<(usize, f64)>,
    /// Observed minus computed.
    pub(crate) residual: f64,
}

impl KnownRow {
    /// What the row makes of values of all shared unknowns.
    pub(crate) fn of(&self, shared: &[f64]) -> f64 {
        let parts = self.columns.iter().map(|&(k, x)| x * shared[k]);
        parts.sum()
    }

    /// `k Σ kᵀ`: the variance of what the row observes.
    pub(crate) fn variance(&self, covariance: impl Fn(usize, usize) -> f64) -> f64 {
        let all = self.columns.iter();
        let pairs = all.flat_map(|&(i, x)| self.columns.iter().map(move |&(j, y)| (i, j, x * y)));
        pairs.map(|(i, j, xy)| xy * covariance(i, j)).sum()
    }
}

impl Network {
    /// Whether the mean constant of the reflectors is an unknown.
    pub(crate) fn has_mean_constant(&self) -> bool {
        !self.dead_paths.is_empty()
    }

    /// All that is known: first the contrasts, then the dead paths.
    pub(crate) fn known_rows(&self, columns: Columns, state: &State) -> Vec<KnownRow> {
        let mut rows = Vec::new();
        if let Some(sigma_mm) = self.contrast_sigma_mm() {
            let contrasts = state.contrasts_mm.iter().enumerate();
            rows.extend(contrasts.map(|(m, contrast_mm)| KnownRow {
                columns: vec![(columns.contrasts + m, 1.0 / sigma_mm)],
                residual: -contrast_mm / sigma_mm,
            }));
        }
        rows.extend(self.dead_paths.iter().map(|known| {
            let weight = 1.0 / known.sigma_mm;
            let computed_mm = state.dead_paths_mm[known.station] + state.mean_constant_mm;
            let dead_path = zero_column(known.station, self.stations.len());
            KnownRow {
                columns: vec![(dead_path, weight), (columns.mean_constant, weight)],
                residual: (known.length_mm - computed_mm) * weight,
            }
        }));
        rows
    }
}
