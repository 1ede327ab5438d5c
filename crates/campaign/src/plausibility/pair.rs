//! Two readings between which something was measured.

/// Two readings, and what was measured between them.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    /// Station of both.
    pub(crate) station: usize,
    /// Run of both.
    pub(crate) run: usize,
    /// The readings, the earlier row first.
    pub(crate) ends: [End; 2],
    /// Change of the length, or distance of the points, mm.
    pub(crate) observed_mm: f64,
}

/// One of the two readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    pub(crate) step: usize,
    pub(crate) target: usize,
    pub(crate) line: usize,
}
