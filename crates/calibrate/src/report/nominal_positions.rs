//! Home and targets as in the campaign, compared with the measurement.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::AxisKind;

use crate::result::calibration::{AxisResult, TargetResult};

/// Difference of a distance between targets from nominal, mm, that is too large for badly set nests.
const ELSEWHERE_MM: f64 = 10.0;

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

/// The notice about targets of one stage that are not at their nominal positions relative to the others. Nominal
/// positions of targets on the bed do not matter.
pub(crate) fn targets_elsewhere(campaign: &Campaign, measured: &[TargetResult]) -> Vec<String> {
    let places = measured.iter().filter_map(|found| {
        let target = campaign.targets.iter().find(|t| t.name == found.name)?;
        Some((target.carrier?, target.home_mm, found))
    });
    let mut places: Vec<OnStage<'_>> = places.collect();
    places.sort_by_key(|(carrier, ..)| *carrier);
    let stages = places.chunk_by(|a, b| a.0 == b.0);
    stages.filter_map(elsewhere_on_stage).collect()
}

/// The carrier of a target, its nominal position, mm, and the measured one.
type OnStage<'a> = (usize, Point3<f64>, &'a TargetResult);

fn elsewhere_on_stage(targets: &[OnStage<'_>]) -> Option<String> {
    let mut wrong = Vec::new();
    for (i, (_, nominal, found)) in targets.iter().enumerate() {
        for (j, (_, other_nominal, other)) in targets.iter().enumerate().skip(i + 1) {
            let distance_mm = (found.position_mm - other.position_mm).norm();
            let difference_mm = distance_mm - (nominal - other_nominal).norm();
            if difference_mm.abs() > ELSEWHERE_MM {
                wrong.push((i, j, difference_mm));
            }
        }
    }
    let largest = wrong.iter().map(|(.., mm)| mm.abs()).fold(0.0, f64::max);
    let in_all = |k: &usize| wrong.iter().all(|(i, j, _)| i == k || j == k);
    let mut suspects = (0..targets.len()).filter(in_all);
    let name = |k: usize| &targets[k].2.name;
    let who = match (suspects.next(), suspects.next()) {
        _ if wrong.is_empty() => return None,
        (Some(one), None) => format!("target {}", name(one)),
        (Some(one), Some(other)) => format!("target {} or {}", name(one), name(other)),
        (None, _) => "more than one target of a stage".to_owned(),
    };
    Some(format!(
        "{who} is not at its nominal position: distances to the other targets of its stage differ by up to \
         {largest:.0} mm; what was measured is used, but the datum and the origin follow from the nominal positions: \
         check `position_mm` in the campaign"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(moved: &[(usize, f64)]) -> Option<String> {
        let nominal = [
            [0.0; 3],
            [300.0, 0.0, 0.0],
            [0.0, 250.0, 0.0],
            [90.0, 80.0, 200.0],
        ];
        let found = nominal.iter().enumerate().map(|(k, &[x, y, z])| {
            let moved = moved.iter().filter(|(target, _)| *target == k);
            TargetResult {
                name: format!("T{k}"),
                position_mm: Point3::new(x + moved.map(|(_, by)| by).sum::<f64>(), y, z),
            }
        });
        let found: Vec<TargetResult> = found.collect();
        let targets = nominal.iter().zip(&found);
        let targets = targets.map(|(&nominal, found)| (0, Point3::from(nominal), found));
        elsewhere_on_stage(&targets.collect::<Vec<_>>())
    }

    #[test]
    fn one_target_elsewhere_is_named() {
        assert_eq!(said(&[]), None);
        assert_eq!(said(&[(3, 4.0)]), None);
        let one = said(&[(1, 25.0)]).unwrap();
        assert!(
            one.starts_with("target T1 is not") && one.contains("25 mm"),
            "{one}"
        );
        let two = said(&[(1, 25.0), (2, -40.0)]).unwrap();
        assert!(two.starts_with("more than one"), "{two}");
    }
}
