//! From lengths to poses or to points.

mod adjustment;
mod at_one_temperature;
mod circumstances;
mod common_value;
mod effects;
mod known;
mod measured;
mod network;
mod reflectors;
mod refused;
mod report;
mod residuals;
mod returns;
mod rigid_steps;
pub(crate) mod scale;
mod shared_sources;
mod side_by_side;
mod side_difference;
mod targets_that_moved;
mod uneven;
mod weak_stations;

pub use adjustment::LengthsAdjustment;
pub use at_one_temperature::at_one_temperature;
pub use circumstances::{
    LengthCircumstances, Observation, constant_feed_per_s, length_circumstances, scene_of,
    temperature_histories,
};
pub use effects::EffectsOnLengths;
pub use network::{CampaignNetwork, Group, network_from_campaign};
pub use reflectors::ReflectorConstant;
pub use scale::{ScaleBasis, ScaleResult};
pub use side_difference::SideDifference;
pub use uneven::uneven_in_words;
