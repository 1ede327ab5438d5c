//! What differs between kinds of data beside which something may wander.

use trueaxis_effects::{Displaced, Subject};
use trueaxis_selection::Projection;

use crate::Error;
use crate::engine::coordinate::Coordinate;
use crate::engine::disturbance::{Disturbance, Here, Wanderer, With};
use crate::engine::{Measured, Suspect};

/// Data beside which something may wander.
pub(crate) trait Wanders: Measured + Clone + Send {
    type Noise: Copy + Send + Sync;

    /// Of a reading.
    const ROWS: usize;

    /// Everything that they may show.
    fn wanderers(&self) -> Vec<Wanderer>;

    /// The other name of the same columns, if it has one.
    fn twin(&self, wanderer: Wanderer) -> Option<Wanderer>;

    /// When and where each reading was taken.
    fn here(&self) -> Vec<Here>;

    /// Stops of a course.
    fn stops(&self, with: With) -> usize;

    /// Positions of an axis where it has travelled 0 and 1, mm or rad.
    fn ends(&self, axis: usize) -> [f64; 2];

    /// What a unit of each coefficient does to the rows, mm.
    fn columns_mm(&self, model: &Self::Model, wanderer: Wanderer) -> Vec<Vec<f64>>;

    /// What a unit of each of some coordinates of a subject moves at each reading.
    fn moved(
        &self,
        model: &Self::Model,
        coordinates: &[Coordinate],
        subject: &Subject,
    ) -> Vec<Vec<Displaced>>;

    /// The same with what wanders in their covariance.
    fn beside(&self, disturbances: Vec<Disturbance>) -> Self;

    fn disturbances(&self) -> &[Disturbance];

    /// Adjusts everything with causes, in this noise or in that which is left.
    fn adjust(
        &self,
        suspects: Vec<Suspect>,
        noise: Option<Self::Noise>,
    ) -> Result<Self::Model, Error>;

    fn noise(model: &Self::Model) -> Self::Noise;

    fn variance(noise: &Self::Noise) -> f64;

    /// A model with another projection and no causes.
    fn with(model: &Self::Model, projection: Projection) -> Self::Model;
}
