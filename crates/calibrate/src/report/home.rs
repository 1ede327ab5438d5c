//! Home as in the campaign, compared with the measurement.

use nalgebra::Vector3;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::AxisKind;

use crate::result::calibration::AxisResult;

/// The notice about linear axes that never reach home, to which their results refer.
pub(crate) fn homes_out_of_reach(campaign: &Campaign, measured: &[AxisResult]) -> Option<String> {
    let (mut travels, mut point) = (Vec::new(), Vector3::zeros());
    for axis in measured
        .iter()
        .map(|own| &campaign.machine.axes()[own.axis])
    {
        let [low, high] = axis.travel();
        if axis.kind() == AxisKind::Linear && (low > 0.0 || high < 0.0) {
            travels.push(format!("{} ({low} to {high} mm)", axis.name()));
            // The point that is at the origin of the frame when the axes are nearest to home.
            point -= axis.direction().into_inner() * if low > 0.0 { low } else { high };
        }
    }
    if travels.is_empty() {
        return None;
    }
    Some(format!(
        "the travel of {} does not contain 0, which is home: the errors are zero at the position nearest to it, and \
         the point that translations and squareness belong to is never where it is said to be; --reference-point \
         {:.0},{:.0},{:.0} is at the origin of the frame where these axes come nearest to home",
        travels.join(", "),
        point.x + 0.0,
        point.y + 0.0,
        point.z + 0.0
    ))
}
