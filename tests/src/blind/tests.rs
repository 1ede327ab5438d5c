//! What must hold for the generator itself: at once for the smallest kind, in the studies for all.

mod absorbed;
mod campaigns;
mod drawn;
mod forms;
mod strengths;

use super::Kind;

/// The fewest readings from both sides.
fn smallest() -> [Kind; 1] {
    [Kind::rotary_stage().forward_and_backward()]
}

/// Kinds of all geometries and ways to measure.
fn kinds() -> [Kind; 7] {
    [
        Kind::three_axis(),
        Kind::three_axis().forward_and_backward(),
        Kind::three_axis().on_the_fly(),
        Kind::rotary_stage(),
        Kind::rotary_stage().forward_and_backward(),
        Kind {
            stations: 5,
            ..Kind::rotary_stage()
        },
        Kind::five_axis().forward_and_backward(),
    ]
}
