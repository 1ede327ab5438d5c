//! From coordinates.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use trueaxis_calibrate::calibrate_for_replay;
use trueaxis_campaign::{PointReading, Points};
use trueaxis_montecarlo::Model;

use super::*;

/// Standard deviations of the readings of the first and second repeat, µm.
const SIGMAS_UM: [f64; 2] = [10.0, 20.0];

/// The points of a simulated campaign as another instrument would read them in its frame, once or
/// twice.
pub(crate) fn points_campaign(
    mut campaign: Campaign,
    repeats: u32,
    instrument_from_ref: &Isometry3<f64>,
) -> Campaign {
    let calibration = calibrate(&campaign, &settings(Method::Nine)).unwrap();
    let errors = calibration.calibrated_machine();
    let lengths = campaign.lengths.take().unwrap();
    let mut points = Points::default();
    for repeat in 1..=repeats {
        for stop in lengths.stops.iter().filter(|stop| stop.station == 0) {
            let first = points.readings.len();
            for reading in &lengths.readings[stop.readings.clone()] {
                let place = target_at(&campaign, (&calibration, &errors), stop, reading.target);
                let number = points.readings.len();
                points.readings.push(PointReading {
                    time_s: number as f64,
                    target: reading.target,
                    position_mm: instrument_from_ref * place,
                    sigma_um: Some(SIGMAS_UM[usize::from(repeat > 1)]),
                    line: number + 2,
                });
            }
            points.stops.push(Stop {
                repeat,
                readings: first..points.readings.len(),
                ..stop.clone()
            });
        }
    }
    campaign.stations.clear();
    campaign.points = Some(points);
    campaign
}

/// Response to every coordinate.
pub(crate) fn response(campaign: &Campaign, method: Method) -> Response {
    let count = 3 * campaign.points.as_ref().unwrap().readings.len();
    Response::new(count, |i, step_mm| {
        let mut changed = campaign.clone();
        let readings = &mut changed.points.as_mut().unwrap().readings;
        readings[i / 3].position_mm[i % 3] += step_mm;
        calibrate(&changed, &settings(method)).unwrap()
    })
}

/// Covariances of the coordinates, mm²: the instrument's own, and that of the machine's repeatability.
pub(crate) fn covariances(campaign: &Campaign) -> [DMatrix<f64>; 2] {
    let points = campaign.points.as_ref().unwrap();
    let count = 3 * points.readings.len();
    let mut own = DMatrix::zeros(count, count);
    let mut returns = DMatrix::zeros(count, count);
    for stop in &points.stops {
        for i in stop.readings.clone() {
            let sigma_mm = points.readings[i].sigma_um.unwrap() * MICROMETRE;
            for c in 0..3 {
                own[(3 * i + c, 3 * i + c)] = sigma_mm * sigma_mm;
                for j in stop.readings.clone() {
                    returns[(3 * i + c, 3 * j + c)] = repeatability_variance_mm2(campaign);
                }
            }
        }
    }
    [own, returns]
}

/// No residual of a single visit shows how well the machine returns.
#[test]
fn one_visit_without_a_declared_repeatability_is_said_to_lack_it() {
    let lacks = |repeats: u32, repeatability_um: Option<f64>| {
        let mut campaign =
            points_campaign(simulated(&two_branches()), repeats, &Isometry3::identity());
        campaign.instrument.repeatability_um = repeatability_um;
        let calibration = calibrate(&campaign, &settings(Method::Nine)).unwrap();
        let lacks = calibration.uncertainty.lacks;
        lacks.iter().any(|part| part.starts_with("repeatability"))
    };
    assert!(lacks(1, None) && !lacks(2, None) && !lacks(1, Some(1.0)));
}

/// The mean of both sides of approach, as of X here, is that of two visits.
#[test]
fn both_sides_of_approach_are_two_visits() {
    let mut campaign = points_campaign(simulated(&two_branches()), 1, &Isometry3::identity());
    campaign.instrument.repeatability_um = None;
    for by_direction in [false, true] {
        let mut settings = settings(Method::Nine);
        settings.poses.by_direction = by_direction;
        let lacks = calibrate(&campaign, &settings).unwrap().uncertainty.lacks;
        let said = lacks.iter().any(|part| part.starts_with("repeatability"));
        assert_eq!(said, by_direction);
    }
}

#[test]
fn coordinates_propagate_to_everything() {
    let frame = Isometry3::new(
        Vector3::new(700.0, -300.0, 50.0),
        Vector3::new(0.3, -0.2, 1.1),
    );
    let campaign = points_campaign(simulated(&two_branches()), 2, &frame);
    let response = response(&campaign, Method::Nine);
    let [own, returns] = covariances(&campaign);
    response.assert_stated("coordinates", &(&own + &returns));

    let (own, returns) = (response.propagated(&own), response.propagated(&returns));
    for (i, (budget, _)) in response.budgets().into_iter().enumerate() {
        let limit = COVARIANCE_TOL * (own[(i, i)] + returns[(i, i)]).max(ROUNDING * ROUNDING);
        assert!(
            (budget.laser - own[(i, i)]).abs() <= limit,
            "{i}: {budget:?}"
        );
        let difference = budget.repeatability - returns[(i, i)];
        assert!(difference.abs() <= limit, "{i}: {budget:?}");
        assert!(budget.station_geometry.abs() < f64::MIN_POSITIVE);
    }
}

/// Coordinates with errors of some µm, read once with this declared noise.
fn noisy_points(sigma_um: Option<f64>) -> Campaign {
    let mut campaign = points_campaign(simulated(&two_branches()), 1, &Isometry3::identity());
    let readings = &mut campaign.points.as_mut().unwrap().readings;
    for (i, reading) in readings.iter_mut().enumerate() {
        reading.sigma_um = sigma_um;
        let wild = |c: usize| ((7 * i + 3 * c) as f64 * (1 + c) as f64).sin();
        reading.position_mm += Vector3::from_fn(|c, _| 4.0 * MICROMETRE * wild(c));
    }
    campaign
}

/// Where `sigma_um` is not declared, the residuals tell the instrument's noise, but not the repeatability that is declared: it
/// was multiplied by what they say, too.
#[test]
fn a_declared_repeatability_is_not_what_the_residuals_make_of_it() {
    let calibrated = |sigma_um| {
        let settings = settings(Method::Nine);
        calibrate(&noisy_points(sigma_um), &settings).unwrap()
    };
    let undeclared = calibrated(None);
    let sigma0 = undeclared.adjustment.sigma0;
    assert!((1.5..6.0).contains(&sigma0), "{sigma0}");
    // As with the noise that the residuals show, declared.
    let known = calibrated(Some(sigma0));
    for (found, expected) in undeclared.results().iter().zip(known.results()) {
        let off = found.u - expected.u;
        assert!(off.abs() <= 1e-3 * expected.u, "{:?}: {off}", found.output);
    }
}

/// True noise of [`repeated_points`].
const SIGMA_UM: f64 = 1.0;
const RETURNS_UM: f64 = 3.0;

/// Eight repeats with noise, by which some 100 visits know the repeatability to 7 %.
fn repeated_points() -> Campaign {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut normal = |sigma_um: f64| {
        let sigma = Normal::new(0.0, sigma_um * MICROMETRE).unwrap();
        Vector3::from_fn(|_, _| sigma.sample(&mut random))
    };
    let mut campaign = points_campaign(simulated(&two_branches()), 8, &Isometry3::identity());
    let points = campaign.points.as_mut().unwrap();
    for stop in &points.stops {
        let return_mm = normal(RETURNS_UM);
        for reading in &mut points.readings[stop.readings.clone()] {
            reading.position_mm += return_mm + normal(SIGMA_UM);
        }
    }
    campaign
}

/// Calibrated with this noise declared.
fn declaring(
    campaign: &Campaign,
    sigma_um: Option<f64>,
    repeatability_um: Option<f64>,
) -> Calibration {
    let mut campaign = campaign.clone();
    campaign.instrument.repeatability_um = repeatability_um;
    for reading in &mut campaign.points.as_mut().unwrap().readings {
        reading.sigma_um = sigma_um;
    }
    calibrate(&campaign, &settings(Method::Nine)).unwrap()
}

fn assert_as_uncertain(found: &Calibration, known: &Calibration) {
    for (found, known) in found.results().iter().zip(known.results()) {
        let off = (found.u / known.u).ln();
        assert!(
            known.u <= 0.0 || off.abs() < 0.25,
            "{:?}: {off}",
            found.output
        );
    }
}

/// Repeats scatter by the repeatability, which all targets of a visit share, beside the instrument's noise: it was taken for
/// more noise of each coordinate, and angles got twice their uncertainty.
#[test]
fn repeats_tell_an_undeclared_repeatability() {
    let campaign = repeated_points();
    let known = declaring(&campaign, Some(SIGMA_UM), Some(RETURNS_UM));
    for sigma_um in [None, Some(SIGMA_UM)] {
        assert_as_uncertain(&declaring(&campaign, sigma_um, None), &known);
    }
}

/// One factor multiplied all uncertainties where either part of the noise was declared wrong: too small a repeatability made those of
/// translations too small and those of rotations too large. Both parts are known to some 10 % at another seed.
#[test]
fn a_part_declared_wrong_leaves_the_other_as_declared() {
    let campaign = repeated_points();
    let known = declaring(&campaign, Some(SIGMA_UM), Some(RETURNS_UM));
    let says = |calibration: &Calibration, text: &str| {
        calibration.notices.iter().any(|own| own.contains(text))
    };
    let [of_return, of_sigma] = ["repeatability_um is declared as", "sigma_um, declared as"];
    assert!(!says(&known, of_return) && !says(&known, of_sigma));
    assert!((known.adjustment.uncertainty_factor - 1.0).abs() < f64::EPSILON);
    for (sigma_um, repeatability_um) in [
        (Some(SIGMA_UM), RETURNS_UM / 3.0),
        (Some(SIGMA_UM), RETURNS_UM * 3.0),
        (None, RETURNS_UM / 3.0),
        (Some(SIGMA_UM / 3.0), RETURNS_UM),
        (Some(SIGMA_UM * 3.0), RETURNS_UM),
        (Some(SIGMA_UM * 3.0), RETURNS_UM / 3.0),
    ] {
        let found = declaring(&campaign, sigma_um, Some(repeatability_um));
        assert_as_uncertain(&found, &known);
        let is_wrong = |declared: f64, right: f64| (declared / right).ln().abs() > 0.1;
        let wrong_sigma = sigma_um.is_some_and(|sigma| is_wrong(sigma, SIGMA_UM));
        let wrong_return = is_wrong(repeatability_um, RETURNS_UM);
        let said = [of_return, of_sigma].map(|text| says(&found, text));
        assert_eq!(said, [wrong_return, wrong_sigma], "{:?}", found.notices);
        let undeclared = says(&found, "sigma_um is not declared");
        assert_eq!(undeclared, sigma_um.is_none());
    }
}

/// Where each visit sees one target, nothing tells its noise from the repeatability: one factor for both.
#[test]
fn visits_of_single_targets_tell_the_whole_noise_alone() {
    let mut campaign = points_campaign(simulated(&two_branches()), 8, &Isometry3::identity());
    let points = campaign.points.as_mut().unwrap();
    let single = |stop: &Stop| {
        let of = |reading: usize| Stop {
            readings: reading..reading + 1,
            ..stop.clone()
        };
        stop.readings.clone().map(of).collect::<Vec<_>>()
    };
    points.stops = points.stops.iter().flat_map(single).collect();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let whole = Normal::new(0.0, SIGMA_UM.hypot(RETURNS_UM) * MICROMETRE).unwrap();
    for reading in &mut points.readings {
        reading.position_mm += Vector3::from_fn(|_, _| whole.sample(&mut random));
    }
    let known = declaring(&campaign, Some(SIGMA_UM), Some(RETURNS_UM));
    let found = declaring(&campaign, Some(SIGMA_UM), Some(RETURNS_UM / 3.0));
    assert_as_uncertain(&found, &known);
    let text = "all uncertainties are multiplied by this";
    assert!(found.notices.iter().any(|own| own.contains(text)));
}

/// A visit in which all targets are a metre off made the machine return within a hundred millimetres, with a covariance that
/// had no inverse.
#[test]
fn a_mistake_in_repeats_is_no_repeatability() {
    let mut campaign = points_campaign(simulated(&two_branches()), 8, &Isometry3::identity());
    campaign.instrument.repeatability_um = None;
    let points = campaign.points.as_mut().unwrap();
    let last = points.stops.last().unwrap().readings.clone();
    points.readings[last]
        .iter_mut()
        .for_each(|reading| reading.position_mm.x += 1e3);
    for sigma_um in [None, Some(1.0)] {
        for reading in &mut campaign.points.as_mut().unwrap().readings {
            reading.sigma_um = sigma_um;
        }
        let said = match calibrate(&campaign, &settings(Method::Nine)) {
            Ok(calibration) => calibration.notices.join("; "),
            Err(error) => error.to_string(),
        };
        // Of the mistake, not of a covariance that it makes.
        assert!(said.contains("axis C does not move as commanded"), "{said}");
    }
}

/// Trials drew an undeclared noise as 1 µm, whatever the residuals say. The results have some ten degrees of freedom: the rms of
/// 100 trials is known to 3 %.
#[test]
fn trials_draw_the_noise_that_residuals_show() {
    let mut campaign = noisy_points(None);
    campaign.instrument.repeatability_um = None;
    let (_, replay) = calibrate_for_replay(&campaign, &settings(Method::Nine)).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut workspace = replay.workspace();
    let mut values = vec![0.0; replay.outputs()];
    let (mut squares, mut count) = (0.0, 0.0);
    for _ in 0..100 {
        replay.trial(&mut random, &mut workspace, &mut values);
        for (value, result) in values.iter().zip(replay.results()) {
            let off = value * result.output.unit().size() - result.value;
            squares += (off / result.u).powi(2);
            count += 1.0;
        }
    }
    let rms = f64::sqrt(squares / count);
    assert!((rms - 1.0).abs() < 0.15, "{rms}");
}
