//! All effects.

mod axis_expansion;
mod backlash;
mod dead_path_drift;
mod dead_path_jump;
mod dead_path_offset;
mod fixture_expansion;
mod length_scale;
mod machine_drift;
mod machine_shift;
mod refraction_drift;
mod stage_bending;
mod station_drift;
mod station_jump;
mod target_creep;
mod target_slip;
mod timestamp_offset;
mod warm_up;

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
        &stage_bending::StageBending,
    ]
}

/// The effect of that name.
pub fn effect(id: &str) -> Option<&'static dyn Effect> {
    catalogue().iter().copied().find(|effect| effect.id() == id)
}
