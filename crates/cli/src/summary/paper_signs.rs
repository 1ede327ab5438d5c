//! Squareness and tilts with the signs of the paper.

use nalgebra::Vector3;
use trueaxis_calibrate::Calibration;
use trueaxis_campaign::Campaign;
use trueaxis_fitting::{paper_c_axis_tilt, paper_squareness};
use trueaxis_kinematics::{ARCSEC, AxisKind};

/// The paper's Eq. 23 and its tilts of a C axis.
pub(super) fn with_paper_signs(campaign: &Campaign, calibration: &Calibration) -> Vec<String> {
    let mut lines = vec![String::new(), "with the signs of the paper".to_owned()];
    let direction = |name: &str, nominal: Vector3<f64>| {
        let result = calibration.axis(name)?;
        let axis = &campaign.machine.axes()[result.axis];
        let along = axis.direction().dot(&nominal) > 0.5 && axis.kind() == AxisKind::Linear;
        along.then(|| axis.average_direction(&result.location))
    };
    let x = direction("X", Vector3::x());
    let (y, z) = (direction("Y", Vector3::y()), direction("Z", Vector3::z()));
    if let (Some(x), Some(y), Some(z)) = (x, y, z)
        && let Ok(paper) = paper_squareness(x, y, z)
    {
        for (name, value) in [
            ("θxy (Sxy)", paper.theta_xy_rad),
            ("θxz (Sxz)", paper.theta_xz_rad),
            ("θyz (Syz)", paper.theta_yz_rad),
        ] {
            lines.push(format!("  {name:<22}{:>9.2} ″", value / ARCSEC));
        }
    }
    if let Some(c) = calibration.axis("C").filter(|c| c.kind == AxisKind::Rotary) {
        let axis = &campaign.machine.axes()[c.axis];
        let tilt = paper_c_axis_tilt(axis.average_direction(&c.location));
        lines.push(format!("  {:<22}{:>9.2} ″", "SxC", tilt.s_xc_rad / ARCSEC));
        lines.push(format!("  {:<22}{:>9.2} ″", "SyC", tilt.s_yc_rad / ARCSEC));
    }
    if lines.len() == 2 {
        lines.push("  nothing to list: they are defined for X, Y, Z together and for C".to_owned());
    }
    lines
}
