//! One block's whitened rows.

/// The rows `[A | B | r]` of one block: columns of the block's own unknowns, of the shared ones,
/// and the residual (observed minus computed), all whitened to unit standard deviation.
///
/// Columns are contiguous. New rows are zero.
#[derive(Debug, Clone, Default)]
pub struct BlockRows {
    rows: usize,
    block: usize,
    shared: usize,
    data: Vec<f64>,
}

impl BlockRows {
    /// Makes these zero rows of another shape; keeps the memory.
    pub fn reset(&mut self, rows: usize, block: usize, shared: usize) {
        (self.rows, self.block, self.shared) = (rows, block, shared);
        self.data.clear();
        self.data.resize(rows * (block + shared + 1), 0.0);
    }

    /// Column of the block's own unknown `k`: derivative of the observations.
    pub fn block_mut(&mut self, k: usize) -> &mut [f64] {
        self.column_mut(k)
    }

    /// Column of the shared unknown `k`.
    pub fn shared_mut(&mut self, k: usize) -> &mut [f64] {
        self.column_mut(self.block + k)
    }

    /// The residuals, observed minus computed.
    pub fn residual_mut(&mut self) -> &mut [f64] {
        self.column_mut(self.block + self.shared)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    fn column_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.data[k * self.rows..(k + 1) * self.rows]
    }
}
