//! All effects, one file each.
//!
//! Their formulas say what `D_p` (of the target), `D_S` (of the station) and `D_l` (of what the instrument
//! shows beyond the distance) are, with
//!
//! | | |
//! | --- | --- |
//! | u | unit vector from station to target |
//! | l | distance from station to target |
//! | t, t0 | time, instant; `[t > t0]` is 1 after it and 0 before |
//! | τ, w | progress of time over the campaign, over the occupation of the station, 0 to 1 |
//! | q | commanded position of the axis |
//! | ϑ, ϑ0 | logged temperature, now and at the first reading |

mod axis_expansion;
mod axis_runout;
mod axis_wobble;
mod backlash;
mod cross_coupling;
mod cyclic_error;
mod dead_path_drift;
mod dead_path_jump;
mod dead_path_offset;
mod encoder_eccentricity;
mod encoder_ellipticity;
mod fixture_expansion;
mod guideway_bow;
mod instrument_drift;
mod instrument_jump;
mod length_scale;
mod machine_drift;
mod machine_shift;
mod position_dependent_backlash;
mod reflector_offset;
mod refraction_drift;
mod scale_error;
mod squareness_error;
mod stage_bending;
mod station_drift;
mod station_jump;
mod station_scale;
mod station_settling;
mod target_creep;
mod target_slip;
mod thermal_growth;
mod timestamp_offset;
mod warm_up;
mod worm_gear;

use crate::Effect;

/// Lost motion that is the same all along an axis.
pub const BACKLASH: &Effect = &backlash::EFFECT;

/// Lost motion that changes along an axis.
pub const POSITION_DEPENDENT_BACKLASH: &Effect = &position_dependent_backlash::EFFECT;

/// What one axis does to the errors of another.
pub const CROSS_COUPLING: &Effect = &cross_coupling::EFFECT;

pub(crate) use backlash::OVER_COMPENSATED;
pub use position_dependent_backlash::{LOST_MOTION_OF_BOTH_SIGNS, WORN_IN_THE_MIDDLE};
pub(crate) use worm_gear::{FEW_WAVES, MOST_OF_FEW};

/// Every effect, layer after layer: instrument, set-up, machine.
pub fn catalogue() -> &'static [&'static Effect] {
    &[
        &dead_path_drift::EFFECT,
        &dead_path_jump::EFFECT,
        &refraction_drift::EFFECT,
        &station_scale::EFFECT,
        &timestamp_offset::EFFECT,
        &length_scale::EFFECT,
        &dead_path_offset::EFFECT,
        &instrument_drift::EFFECT,
        &instrument_jump::EFFECT,
        &station_drift::EFFECT,
        &station_settling::EFFECT,
        &station_jump::EFFECT,
        &reflector_offset::EFFECT,
        &target_slip::EFFECT,
        &target_creep::EFFECT,
        &fixture_expansion::EFFECT,
        &machine_drift::EFFECT,
        &warm_up::EFFECT,
        &machine_shift::EFFECT,
        &thermal_growth::EFFECT,
        &axis_expansion::EFFECT,
        &backlash::EFFECT,
        &position_dependent_backlash::EFFECT,
        &cross_coupling::EFFECT,
        &squareness_error::EFFECT,
        &stage_bending::EFFECT,
        &scale_error::EFFECT,
        &guideway_bow::EFFECT,
        &cyclic_error::EFFECT,
        &encoder_eccentricity::EFFECT,
        &encoder_ellipticity::EFFECT,
        &worm_gear::EFFECT,
        &axis_wobble::EFFECT,
        &axis_runout::EFFECT,
    ]
}

/// The effect of that name.
pub fn effect(id: &str) -> Option<&'static Effect> {
    catalogue().iter().copied().find(|effect| effect.id == id)
}
