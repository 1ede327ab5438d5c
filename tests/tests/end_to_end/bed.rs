//! Targets on the bed: they stand still, whatever the machine does.

use nalgebra::Point3;
use trueaxis_calibrate::{Calibration, Method, calibrate};
use trueaxis_campaign::{read, write};
use trueaxis_simulate::{
    BedSpec, KnownLengthSpec, NoiseSpec, Scenario, Simulated, TargetSpec, simulate,
};
use trueaxis_tests::estimators::{SCENARIOS, settings};

use crate::coverage::assert_scatter_is_as_stated;

/// Where nests on the bed are, mm, and by how much they are not where they should be.
const ON_BED: [([f64; 3], [f64; 3]); 3] = [
    ([-120.0, 260.0, 30.0], [3.0, -2.0, 0.5]),
    ([880.0, 350.0, 70.0], [-1.0, 4.0, 1.0]),
    ([420.0, 1210.0, 10.0], [2.0, 2.0, -3.0]),
];

/// The three-axis scenario with so many targets on the bed, read five times in each occupation.
fn with_bed(targets: usize) -> Scenario {
    let (_, text) = SCENARIOS[0];
    let mut scenario = Scenario::from_json(text).unwrap();
    let nests = ON_BED.iter().take(targets).enumerate();
    scenario
        .targets
        .extend(nests.map(|(i, (position_mm, off_mm))| TargetSpec {
            name: format!("B{}", i + 1),
            position_mm: *position_mm,
            carried_by: None,
            mounting_error_mm: *off_mm,
            // One reflector, carried from nest to nest.
            reflector: Some("R".to_owned()),
            position_sigma_mm: None,
        }));
    scenario.bed = (targets > 0).then_some(BedSpec { readings: 5 });
    scenario
}

fn calibrated(simulated: &Simulated, scenario: &Scenario, method: Method) -> Calibration {
    calibrate(&simulated.campaign, &settings(scenario, method)).unwrap()
}

/// They are no poses and no runs, and their places are found.
#[test]
fn targets_on_the_bed_are_no_poses() {
    let bare = with_bed(0);
    let without = simulate(&bare, 1).unwrap();
    let scenario = with_bed(3);
    let simulated = simulate(&scenario, 1).unwrap();
    let lengths = simulated.campaign.lengths.as_ref().unwrap();
    let on_bed = |target: usize| simulated.campaign.targets[target].carrier.is_none();
    let of_bed = lengths.readings.iter().filter(|r| on_bed(r.target)).count();
    assert_eq!(of_bed, 4 * 5 * 3);
    for method in [Method::Joint, Method::Nine] {
        let found = calibrated(&simulated, &scenario, method);
        let before = calibrated(&without, &bare, method);
        assert!(
            found.adjustment.rejected.is_empty(),
            "{:?}",
            found.adjustment.rejected
        );
        assert!(found.misfits.is_empty());
        for (a, b) in found.axes.iter().zip(&before.axes) {
            assert_eq!(a.nodes.len(), b.nodes.len());
        }
        for (found, truth) in found.targets.iter().zip(&simulated.truth.targets) {
            let distance_mm = (found.position_mm - truth.home_mm).norm();
            assert!(distance_mm < 0.02, "{}: {distance_mm}", found.name);
        }
        assert_eq!(found.targets.len(), 6);
    }
}

/// With the noise that is declared every coordinate of every station is known better, if only a little: a nest brings
/// three coordinates for the lengths from four stations.
#[test]
fn targets_on_the_bed_make_stations_better() {
    let exact = |targets: usize| {
        let mut scenario = with_bed(targets);
        scenario.noise = NoiseSpec::NONE;
        let simulated = simulate(&scenario, 1).unwrap();
        calibrated(&simulated, &scenario, Method::Joint)
    };
    let (with, without) = (exact(3), exact(0));
    for (a, b) in with.stations.iter().zip(&without.stations) {
        let ratios = a.u_mm.iter().zip(&b.u_mm).map(|(a, b)| a / b);
        let ratios: Vec<f64> = ratios.collect();
        println!("{}: u of x, y, z times {ratios:.4?}", a.name);
        assert!(
            ratios.iter().all(|ratio| *ratio < 1.0),
            "{}: {ratios:?}",
            a.name
        );
    }
}

/// Stated uncertainties are the scatter with targets on the bed, of which one alone, two and three make no body.
#[test]
fn uncertainties_are_the_scatter_with_targets_on_the_bed() {
    for targets in [1, 2, 3] {
        let scenario = with_bed(targets);
        assert_scatter_is_as_stated(&format!("{targets} on the bed"), &scenario);
    }
}

/// A bar between two nests on the bed tells the scale.
#[test]
fn a_bar_on_the_bed_tells_the_scale() {
    let mut scenario = with_bed(2);
    scenario.systematic.scale_sigma_ppm = Some(20.0);
    scenario.known_lengths = vec![KnownLengthSpec {
        targets: ["B1", "B2"].map(str::to_owned),
        sigma_um: 0.5,
    }];
    let simulated = simulate(&scenario, 3).unwrap();
    for method in [Method::Joint, Method::Nine] {
        let scale = calibrated(&simulated, &scenario, method).scale.unwrap();
        let error_ppm = scale.value * 1e6 - simulated.truth.scale_ppm;
        println!(
            "{method:?}: {:.2} ppm, off by {error_ppm:+.3} ± {:.3}",
            scale.value * 1e6,
            scale.u * 1e6
        );
        // 0.5 µm of a metre, and what the lengths leave.
        assert!(scale.u < 1.5e-6 && error_ppm.abs() < 3.0 * scale.u * 1e6);
    }
    assert_scatter_is_as_stated("bar on the bed", &scenario);
}

/// What is written is read again, bed and all.
#[test]
fn a_campaign_with_a_bed_comes_back() {
    let simulated = simulate(&with_bed(2), 1).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = write(&simulated.campaign, folder.path()).unwrap();
    let text = std::fs::read_to_string(folder.path().join("lengths.csv")).unwrap();
    // Before the first sweep, at its start.
    assert!(
        text.lines().nth(1).unwrap().contains(",S1,1,,,0,0,0,B1,"),
        "{text:.200}"
    );
    let mut again = read(&path).unwrap();
    again.notices.clear();
    assert_eq!(again, simulated.campaign);
    let coverage = again.coverage();
    let bed: Vec<_> = coverage.iter().filter(|c| c.run.is_none()).collect();
    assert_eq!(bed.len(), 2);
    assert!(
        bed.iter()
            .all(|c| c.hole(0).is_none() && c.seen[0].readings == 5)
    );
}

/// A nest far from where it should be does no harm.
#[test]
fn rough_places_on_the_bed_are_good_enough() {
    let mut scenario = with_bed(3);
    let simulated = simulate(&scenario, 1).unwrap();
    let right = calibrated(&simulated, &scenario, Method::Joint);
    let mut rough = simulated.clone();
    for target in &mut rough.campaign.targets {
        if target.carrier.is_none() {
            target.home_mm += Point3::new(20.0, -15.0, 10.0).coords;
        }
    }
    scenario.bed = None;
    let found = calibrated(&rough, &scenario, Method::Joint);
    assert!(found.adjustment.rejected.is_empty());
    for (a, b) in right.axes.iter().zip(&found.axes) {
        for (a, b) in a.nodes.iter().zip(&b.nodes) {
            let moved = a.error.to_vector() - b.error.to_vector();
            for c in 0..6 {
                assert!(moved[c].abs() <= 1e-3 * a.u[c] + 1e-12, "{}", moved[c]);
            }
        }
    }
}
