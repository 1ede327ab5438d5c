//! All effects.

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
mod length_scale;
mod machine_drift;
mod machine_shift;
mod position_dependent_backlash;
mod refraction_drift;
mod scale_error;
mod squareness_error;
mod stage_bending;
mod station_drift;
mod station_jump;
mod target_creep;
mod target_slip;
mod timestamp_offset;
mod warm_up;
mod worm_gear;

use crate::Effect;

/// Every effect, layer after layer: instrument, set-up, machine.
pub fn catalogue() -> &'static [&'static dyn Effect] {
    &[
        &dead_path_drift::DeadPathDrift,
        &dead_path_jump::DeadPathJump,
        &refraction_drift::RefractionDrift,
        &timestamp_offset::TimestampOffset,
        &length_scale::LengthScale,
        &dead_path_offset::DeadPathOffset,
        &station_drift::StationDrift,
        &station_jump::StationJump,
        &target_slip::TargetSlip,
        &target_creep::TargetCreep,
        &fixture_expansion::FixtureExpansion,
        &machine_drift::MachineDrift,
        &warm_up::WarmUp,
        &machine_shift::MachineShift,
        &axis_expansion::AxisExpansion,
        &backlash::Backlash,
        &position_dependent_backlash::PositionDependentBacklash,
        &cross_coupling::CrossCoupling,
        &squareness_error::SquarenessError,
        &stage_bending::StageBending,
        &scale_error::ScaleError,
        &guideway_bow::GuidewayBow,
        &cyclic_error::CyclicError,
        &encoder_eccentricity::EncoderEccentricity,
        &encoder_ellipticity::EncoderEllipticity,
        &worm_gear::WormGear,
        &axis_wobble::AxisWobble,
        &axis_runout::AxisRunout,
    ]
}

/// The effect of that name.
pub fn effect(id: &str) -> Option<&'static dyn Effect> {
    catalogue().iter().copied().find(|effect| effect.id() == id)
}
