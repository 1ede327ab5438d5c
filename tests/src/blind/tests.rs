//! What must hold for the generator itself.

mod absorbed;
mod campaigns;
mod drawn;
mod forms;
mod strengths;

use super::Kind;

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
