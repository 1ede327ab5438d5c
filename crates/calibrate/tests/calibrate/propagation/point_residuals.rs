//! Residuals of coordinates: their variances and redundancy numbers against the response to single coordinates, and
//! against simulated noise.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_identify::SixRows;
use trueaxis_poses::Residual;

use super::*;
use crate::propagation::points::{covariances, points_campaign};

/// Second-order terms: an error of a milliradian in the direction of a residual.
const TOL: f64 = 1e-3;

fn residuals(campaign: &Campaign, method: Method) -> Vec<Residual> {
    calibrate(campaign, &settings(method)).unwrap().residuals
}

fn noisy(campaign: &Campaign, seed: u64) -> Campaign {
    let mut campaign = campaign.clone();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut error = |sigma_mm: f64| {
        Vector3::from_fn(|_, _| {
            let normal: f64 = StandardNormal.sample(&mut rng);
            sigma_mm * normal
        })
    };
    let returns_mm = repeatability_variance_mm2(&campaign).sqrt();
    let points = campaign.points.as_mut().unwrap();
    for stop in &points.stops {
        let common = error(returns_mm);
        for reading in &mut points.readings[stop.readings.clone()] {
            let own = error(reading.sigma_um.unwrap() * MICROMETRE);
            reading.position_mm += common + own;
        }
    }
    campaign
}

/// Two readings of each point with different noise; each axis moves alone.
fn twice() -> Campaign {
    points_campaign(simulated(&two_branches()), 2, &Isometry3::identity())
}

#[test]
fn residuals_have_the_variance_and_the_redundancy_that_they_state() {
    let campaign = noisy(&twice(), 1);
    let [own, returns] = covariances(&campaign);
    let covariance = own + returns;
    for method in [Method::Nine, Method::Six(SixRows::PAPER)] {
        let stated = residuals(&campaign, method);
        assert_eq!(stated.len(), covariance.nrows());
        let columns: Vec<DVector<f64>> = (0..stated.len())
            .map(|i| {
                let mut changed = campaign.clone();
                let readings = &mut changed.points.as_mut().unwrap().readings;
                readings[i / 3].position_mm[i % 3] += STEP_MM;
                let changed = residuals(&changed, method);
                let pairs = changed.iter().zip(&stated);
                let change =
                    pairs.map(|(changed, stated)| changed.residual_mm - stated.residual_mm);
                DVector::from_iterator(stated.len(), change) / STEP_MM
            })
            .collect();
        let derivatives = DMatrix::from_columns(&columns);
        let found = &derivatives * &covariance * derivatives.transpose();
        for (i, residual) in stated.iter().enumerate() {
            assert_eq!(
                (residual.reading, residual.coordinate),
                (i / 3, Some(i % 3))
            );
            let redundancy = residual.redundancy.unwrap();
            assert!(
                (redundancy - derivatives[(i, i)]).abs() < TOL,
                "{i}: {residual:?}"
            );
            let u = residual.residual_mm / residual.standardized;
            let variance = u * u;
            assert!(
                (variance - found[(i, i)]).abs() < TOL * found[(i, i)].max(covariance[(i, i)]),
                "{method:?} {i}: {variance:e} {:e}",
                found[(i, i)]
            );
        }
    }
}

#[test]
fn each_coordinate_has_a_row() {
    let campaign = noisy(&twice(), 2);
    let calibration = calibrate(&campaign, &settings(Method::Nine)).unwrap();
    let mut text = Vec::new();
    calibration
        .write_residuals_csv(&campaign, &mut text)
        .unwrap();
    let text = String::from_utf8(text).unwrap();
    let mut lines = text.lines();
    let header = "row,coordinate,target,run,time_s,X,Y,C,residual_um,standardized,redundancy,used";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let readings = &campaign.points.as_ref().unwrap().readings;
    assert_eq!(rows.len(), 3 * readings.len());
    for (k, row) in rows.iter().enumerate() {
        let reading = &readings[k / 3];
        assert_eq!(row[0], reading.line.to_string());
        assert_eq!(row[1], ["x", "y", "z"][k % 3]);
        assert_eq!(row[2], campaign.targets[reading.target].name);
    }
    let sum = |of: &dyn Fn(&Vec<&str>) -> f64| rows.iter().map(of).sum::<f64>();
    let redundancy = sum(&|row| row[10].parse().unwrap());
    let adjustment = &calibration.adjustment;
    // Each point was read twice: half of the coordinates are left over.
    let expected = adjustment.degrees_of_freedom + rows.len() / 2;
    assert!(
        (redundancy - expected as f64).abs() < 0.01,
        "{redundancy} {expected}"
    );
    let squares = sum(&|row| row[8].parse::<f64>().unwrap().powi(2));
    let rms_um = (squares / rows.len() as f64).sqrt();
    assert!((rms_um - adjustment.rms_residual_mm * 1e3).abs() < 1e-3);
}

/// The mean square of simulated campaigns is 1 within three standard errors, of which the campaigns' scatter is the
/// measure: a right program fails with a probability of 0.3 % at another seed.
#[test]
fn standardized_residuals_have_the_mean_square_one() {
    const CAMPAIGNS: u64 = 60;
    let campaign = twice();
    let squares: Vec<f64> = (1..=CAMPAIGNS)
        .map(|seed| {
            let residuals = residuals(&noisy(&campaign, seed), Method::Nine);
            let squares: f64 = residuals.iter().map(|r| r.standardized.powi(2)).sum();
            squares / residuals.len() as f64
        })
        .collect();
    let count = CAMPAIGNS as f64;
    let mean = squares.iter().sum::<f64>() / count;
    let variance = squares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = (variance / count).sqrt();
    assert!((mean - 1.0).abs() < 3.0 * error, "{mean} ± {error}");
    assert!(error < 0.03, "{error}");
}

/// One reading that is 1 mm wrong: the largest residual is its own, and no other stop has one like it.
#[test]
fn a_wrong_target_stands_out() {
    let campaign = noisy(&twice(), 7);
    let stops = campaign.points.as_ref().unwrap().stops.clone();
    // Of the first repeat and of the second, a target on the spindle and one on the table.
    for stop in [&stops[2], &stops[stops.len() - 2]] {
        let wrong = stop.readings.start + 1;
        for coordinate in 0..3 {
            let mut campaign = campaign.clone();
            campaign.points.as_mut().unwrap().readings[wrong].position_mm[coordinate] += 1.0;
            let residuals = residuals(&campaign, Method::Nine);
            let largest = |of: &dyn Fn(usize) -> bool| {
                let of = residuals.iter().filter(|r| of(r.reading));
                of.map(|r| r.standardized.abs()).fold(0.0, f64::max)
            };
            let own = largest(&|reading| reading == wrong);
            let others = largest(&|reading| reading != wrong);
            assert!(
                own > 10.0 && own > others,
                "{wrong} {coordinate}: {own} {others}"
            );
            let step = &campaign.points.as_ref().unwrap().stops;
            let of_step = |reading: usize| {
                let of = step.iter().find(|s| s.readings.contains(&reading)).unwrap();
                (of.step, of.direction) == (stop.step, stop.direction)
            };
            let elsewhere = largest(&|reading| !of_step(reading));
            assert!(
                elsewhere < 0.5 * own,
                "{wrong} {coordinate}: {own} {elsewhere}"
            );
        }
    }
}

/// Of clean campaigns whose noise is not declared, with three to six steps a run, one in a hundred has a step that is
/// not rigid by chance: more than four have a probability of 0.3 %. A wrong target is found.
#[test]
fn few_steps_without_declared_noise_make_few_alarms() {
    const CAMPAIGNS: u64 = 100;
    let campaign = points_campaign(simulated(&two_branches()), 1, &Isometry3::identity());
    let (mut alarms, mut found) = (0, 0);
    for seed in 1..=CAMPAIGNS {
        let mut campaign = noisy(&campaign, seed);
        let readings = &mut campaign.points.as_mut().unwrap().readings;
        readings
            .iter_mut()
            .for_each(|reading| reading.sigma_um = None);
        let misfits = |campaign: &Campaign| {
            let calibration = calibrate(campaign, &Settings::default()).unwrap();
            // Noise of 10 µm that nobody declared contradicts nothing.
            assert!(calibration.adjustment.p_value > 0.99);
            calibration.misfits.len()
        };
        alarms += usize::from(misfits(&campaign) > 0);
        campaign.points.as_mut().unwrap().readings[7].position_mm += Vector3::new(0.5, -0.5, 0.7);
        found += usize::from(misfits(&campaign) == 1);
    }
    println!("{alarms} alarms of {CAMPAIGNS}, {found} wrong targets found");
    assert!(alarms <= 4, "{alarms}");
    assert!(found >= 95, "{found}");
}
