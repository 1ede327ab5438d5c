//! Steps and targets in the words of the campaign.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::AxisKind;

/// A step as `run x at X = 40 mm, Y = 0 mm`.
pub(crate) fn step(campaign: &Campaign, step: usize) -> String {
    let step = &campaign.steps[step];
    let positions: Vec<String> = campaign
        .machine
        .axes()
        .iter()
        .zip(&step.positions)
        .map(|(axis, &position)| {
            let name = axis.name();
            match axis.kind() {
                AxisKind::Linear => format!("{name} = {position} mm"),
                // Degrees as the file has them, without the rounding of the conversion.
                AxisKind::Rotary => {
                    format!("{name} = {}°", (position.to_degrees() * 1e9).round() / 1e9)
                }
            }
        })
        .collect();
    format!(
        "run {} at {}",
        campaign.runs[step.run].name,
        positions.join(", ")
    )
}
