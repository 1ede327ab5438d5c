//! What differs between kinds of data that may have disturbances.

use trueaxis_effects::{Displaced, Subject};
use trueaxis_selection::Projection;

use crate::Error;
use crate::engine::coordinate::Coordinate;
use crate::engine::disturbance::{Disturbance, Here, Wanderer, With};
use crate::engine::{Measured, Suspect};

/// Data that may have disturbances.
pub(crate) trait Wanders: Measured + Clone + Send {
    type Noise: Copy + Send + Sync;

    /// Rows of a reading.
    const ROWS: usize;

    /// All wanderers that these data may show.
    fn wanderers(&self) -> Vec<Wanderer>;

    /// Another wanderer with the same columns, if there is one.
    fn twin(&self, wanderer: Wanderer) -> Option<Wanderer>;

    /// Time and place of each reading.
    fn here(&self) -> Vec<Here>;

    /// Number of stops of a course.
    fn stops(&self, with: With) -> usize;

    /// Positions of an axis at 0 and 1 of its range, mm or rad.
    fn ends(&self, axis: usize) -> [f64; 2];

    /// Changes of the rows by a unit of each coefficient, mm.
    fn columns_mm(&self, model: &Self::Model, wanderer: Wanderer) -> Vec<Vec<f64>>;

    /// Displacements of each reading by a unit of each of some coordinates of a subject.
    fn moved(
        &self,
        model: &Self::Model,
        coordinates: &[Coordinate],
        subject: &Subject,
    ) -> Vec<Vec<Displaced>>;

    /// The same data with disturbances in their covariance.
    fn beside(&self, disturbances: Vec<Disturbance>) -> Self;

    fn disturbances(&self) -> &[Disturbance];

    /// Adjusts everything with causes, with this noise or the estimated one.
    fn adjust(
        &self,
        suspects: Vec<Suspect>,
        noise: Option<Self::Noise>,
    ) -> Result<Self::Model, Error>;

    fn noise(model: &Self::Model) -> Self::Noise;

    fn variance(noise: &Self::Noise) -> f64;

    /// A model with another projection and without causes.
    fn with(model: &Self::Model, projection: Projection) -> Self::Model;
}
