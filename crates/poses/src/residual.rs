//! What the adjustment leaves of each observation.

/// The residual of one observation, a length or a coordinate of a measured point: observed minus computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// The reading of the campaign.
    pub reading: usize,
    /// The coordinate of a measured point, 0 to 2: x y z along the axes of the datum; `None` for a length.
    pub coordinate: Option<usize>,
    /// The residual, mm; for a removed length its difference from what the others predict.
    pub residual_mm: f64,
    /// In units of its standard deviation (Baarda's w): standard normal if nothing is wrong; zero where
    /// nothing checks the observation.
    pub standardized: f64,
    /// Redundancy number, the part of an error in the observation that its residual shows; `None` for a removed
    /// length.
    pub redundancy: Option<f64>,
}
