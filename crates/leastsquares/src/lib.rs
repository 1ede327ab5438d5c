//! Rank-checked weighted least squares and block-arrowhead adjustment.
