//! Results that show a mistake which no length contradicts.

use nalgebra::Point3;
use trueaxis_campaign::Campaign;

/// Difference of a distance between targets from nominal, mm, that is too large for badly set nests.
const ELSEWHERE_MM: f64 = 10.0;

/// Name of a target and where it was found at home, mm.
pub type FoundTarget<'a> = (&'a str, Point3<f64>);

/// Least common scale of the axes that is reported: screws and scales, thermal expansion included, are mostly better.
const COMMON_SCALE: f64 = 50e-6;

/// Part of their mean by which scales that are alike differ from it at most.
const ALIKE: f64 = 0.1;

/// A scale of the instrument beyond this gets a notice: no laser in corrected air is that bad.
const ABSURD_SCALE: f64 = 50e-6;

/// Error of a paced-off position of a station, mm.
const APPROXIMATE_MM: f64 = 500.0;

/// Thermal expansion of steel, 1/K.
const STEEL_PER_K: f64 = 11.5e-6;

/// The notice about linear axes that are all longer, or all shorter, than commanded by the same part of their length:
/// `scales` are these parts by the names of the axes. Lengths alone do not tell the scale of the instrument from that of the machine.
pub fn common_scale(scales: &[(&str, f64)]) -> Option<String> {
    let mean = scales.iter().map(|(_, scale)| scale).sum::<f64>() / scales.len().max(1) as f64;
    let is_alike = |(_, scale): &(&str, f64)| (scale - mean).abs() < ALIKE * mean.abs();
    let are_alike = scales.len() > 1 && scales.iter().all(is_alike);
    let names: Vec<&str> = scales.iter().map(|(name, _)| *name).collect();
    let side = if mean > 0.0 { "longer" } else { "shorter" };
    (are_alike && mean.abs() > COMMON_SCALE).then(|| {
        format!(
            "axes {} are {side} than commanded by {:.0} ppm alike: rather a scale of the lengths (wavelength, air or unit of the instrument) \
             than that of {} screws, unless the whole machine is {:+.0} K from where it is right (steel); a known length would tell",
            names.join(", "),
            1e6 * mean.abs(),
            scales.len(),
            mean / STEEL_PER_K
        )
    })
}

/// The notice about a scale of the lengths by known lengths that is more likely a mistake in one of these; positive where
/// lengths are shown too long.
pub fn absurd_scale(scale: f64) -> Option<String> {
    let side = if scale > 0.0 { "long" } else { "short" };
    (scale.abs() > ABSURD_SCALE).then(|| {
        format!(
            "lengths are shown too {side} by {:.0} ppm against known lengths, and all results were scaled by that: check `length_mm` of the \
             known lengths, and whether the lengths are corrected for the air",
            1e6 * scale.abs()
        )
    })
}

/// The notices about stations that were found, in the order of the campaign, far from their rough positions there.
pub fn stations_elsewhere(
    campaign: &Campaign,
    found_mm: impl Iterator<Item = Point3<f64>>,
) -> Vec<String> {
    let stations = campaign.stations.iter().zip(found_mm);
    let elsewhere = stations.filter_map(|(station, found_mm)| {
        let distance_mm = (found_mm - station.approx_mm?).norm();
        (distance_mm > APPROXIMATE_MM).then(|| {
            format!(
                "station {} was found {distance_mm:.0} mm from its approx_mm: check its name and \
                 `approx_mm`",
                station.name
            )
        })
    });
    elsewhere.collect()
}

/// The notice about targets of one stage that are not at their nominal positions relative to the others. Nominal
/// positions of targets on the bed do not matter.
pub fn targets_elsewhere(campaign: &Campaign, found: &[FoundTarget<'_>]) -> Vec<String> {
    let places = found.iter().filter_map(|&found| {
        let target = campaign.targets.iter().find(|t| t.name == found.0)?;
        Some((target.carrier?, target.home_mm, found))
    });
    let mut places: Vec<OnStage<'_>> = places.collect();
    places.sort_by_key(|(carrier, ..)| *carrier);
    let stages = places.chunk_by(|a, b| a.0 == b.0);
    stages.filter_map(elsewhere_on_stage).collect()
}

/// The carrier of a target, its nominal position, mm, and the measured one.
type OnStage<'a> = (usize, Point3<f64>, FoundTarget<'a>);

fn elsewhere_on_stage(targets: &[OnStage<'_>]) -> Option<String> {
    let mut wrong = Vec::new();
    for (i, (_, nominal, found)) in targets.iter().enumerate() {
        for (j, (_, other_nominal, other)) in targets.iter().enumerate().skip(i + 1) {
            let distance_mm = (found.1 - other.1).norm();
            let difference_mm = distance_mm - (nominal - other_nominal).norm();
            if difference_mm.abs() > ELSEWHERE_MM {
                wrong.push((i, j, difference_mm));
            }
        }
    }
    let largest = wrong.iter().map(|(.., mm)| mm.abs()).fold(0.0, f64::max);
    let in_all = |k: &usize| wrong.iter().all(|(i, j, _)| i == k || j == k);
    let mut suspects = (0..targets.len()).filter(in_all);
    let name = |k: usize| targets[k].2.0;
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
            let x = x + moved.map(|(_, by)| by).sum::<f64>();
            (["T0", "T1", "T2", "T3"][k], Point3::new(x, y, z))
        });
        let targets = nominal.iter().zip(found);
        let targets = targets.map(|(&nominal, found)| (0, Point3::from(nominal), found));
        elsewhere_on_stage(&targets.collect::<Vec<_>>())
    }

    #[test]
    fn axes_that_are_longer_alike_are_named() {
        let of = |scales: [f64; 3]| {
            common_scale(&[("X", scales[0]), ("Y", scales[1]), ("Z", scales[2])])
        };
        let said = of([1.0e-3, 1.01e-3, 0.99e-3]).unwrap();
        assert!(
            said.contains("longer than commanded by 1000 ppm") && said.contains("+87 K"),
            "{said}"
        );
        assert!(of([-1.0e-3; 3]).unwrap().contains("shorter"));
        assert_eq!(of([4e-5; 3]), None);
        assert_eq!(of([1e-3, 1e-3, 0.7e-3]), None);
        assert_eq!(common_scale(&[("X", 1e-3)]), None);
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
