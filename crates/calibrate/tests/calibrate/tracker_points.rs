//! Points whose noise follows the beam of a tracker: 0.6 µm along it, 3 µm/m across.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Calibration, Method, Settings, calibrate};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_predict::Output;
use trueaxis_simulate::Scenario;

use crate::propagation::points::points_campaign;
use crate::simulated;

const ALONG_MM: f64 = 0.6 * MICROMETRE;
const ACROSS: f64 = 3e-6;
const RETURNS_MM: f64 = 0.5 * MICROMETRE;

const CAMPAIGNS: u64 = 12;

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.poses.method = Method::Nine;
    settings
}

/// With the errors of a tracker in the origin of the points' frame, which is then left for another one.
fn seen_by_a_tracker(exact: &Campaign, seed: u64, afterwards: &Isometry3<f64>) -> Campaign {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut vector =
        || -> Vector3<f64> { Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)) };
    let mut campaign = exact.clone();
    let points = campaign.points.as_mut().unwrap();
    for stop in &points.stops {
        let returns_mm = vector() * RETURNS_MM;
        for reading in &mut points.readings[stop.readings.clone()] {
            let (beam, distance_mm) = (
                reading.position_mm.coords.normalize(),
                reading.position_mm.coords.norm(),
            );
            let noise = vector();
            let along = beam * beam.dot(&noise);
            let across = (noise - along) * ACROSS * distance_mm;
            reading.position_mm += returns_mm + along * ALONG_MM + across;
            reading.position_mm = afterwards * reading.position_mm;
            reading.sigma_um = None;
        }
    }
    campaign
}

/// Mean squares of error over u of each component error.
fn mean_squares(found: &Calibration, exact: &Calibration) -> BTreeMap<String, f64> {
    let mut of = BTreeMap::<String, Vec<f64>>::new();
    for (found, exact) in found.results().into_iter().zip(exact.results()) {
        if let Output::ComponentError {
            component, axis, ..
        } = found.output
            && found.u > 0.0
        {
            let squares = of.entry(format!("{component:?} of {axis}")).or_default();
            squares.push(((found.value - exact.value) / found.u).powi(2));
        }
    }
    let mean = |own: Vec<f64>| own.iter().sum::<f64>() / own.len() as f64;
    of.into_iter()
        .map(|(name, own)| (name, mean(own)))
        .collect()
}

/// u followed from equal noise in all directions: that of EXZ was 1.4 times too large, that of EYY 1.2 times too small. One
/// of the 36 means over campaigns differs from 1 by five of its standard errors (of twelve campaigns) in one of 90 choices
/// of seeds.
#[test]
fn uncertainties_follow_the_beam() {
    let scenario = include_str!("../../../../campaigns/fxyz/scenario.json");
    let lengths = simulated(&Scenario::from_json(scenario).unwrap());
    let stands = Isometry3::new(
        Vector3::new(1400.0, -300.0, 200.0),
        Vector3::new(0.0, 0.0, 0.2),
    );
    let exact_points = points_campaign(lengths, 2, &stands);
    let exact = calibrate(&exact_points, &settings()).unwrap();
    let another = Isometry3::new(
        Vector3::new(-900.0, 700.0, 400.0),
        Vector3::new(0.4, 0.2, -2.0),
    );
    for (frame, afterwards) in [("the tracker", Isometry3::identity()), ("another", another)] {
        let of_campaign = |seed| {
            let campaign = seen_by_a_tracker(&exact_points, seed, &afterwards);
            let found = calibrate(&campaign, &settings()).unwrap();
            let notices = found.notices.join("; ");
            assert!(
                notices.contains("along the beam of an instrument"),
                "{notices}"
            );
            mean_squares(&found, &exact)
        };
        let all: Vec<BTreeMap<String, f64>> = (0..CAMPAIGNS).map(of_campaign).collect();
        for name in all[0].keys() {
            let own: Vec<f64> = all.iter().map(|campaign| campaign[name]).collect();
            let count = own.len() as f64;
            let mean = own.iter().sum::<f64>() / count;
            let variance = own.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let u = (variance / count).sqrt();
            println!("frame of {frame}, {name}: mean square of error over u {mean:.2} +- {u:.2}");
            assert!((mean - 1.0).abs() < 5.0 * u, "{name}: {mean} +- {u}");
        }
    }
}
