//! Errors of neighbouring stops that are alike, as in air that stirs: an autoregressive process of first order.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Verification;
use trueaxis_diagnose::{Diagnosis, Verdict};

use crate::counts::summary;
use crate::iso_run::{Place, there_and_back};
use crate::{found, generator};

const SIGMA_UM: f64 = 0.7;

/// Five cycles over 500 mm whose noise has this correlation from stop to stop.
fn line(
    correlation: f64,
    random: &mut ChaCha8Rng,
    timed: bool,
    mut read_um: impl FnMut(&Place) -> f64,
) -> Verification {
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let mut noise = normal();
    there_and_back((5, 500.0, timed), 0.0, &mut |place| {
        let read = read_um(place) + SIGMA_UM * noise;
        noise = correlation * noise + (1.0 - correlation * correlation).sqrt() * normal();
        read
    })
}

/// How many of `lines` without anything but noise are not clean.
fn alarms(correlation: f64, lines: u64) -> usize {
    let is_alarm = |seed: &u64| {
        let line = line(
            correlation,
            &mut generator(*seed, 120),
            seed.is_multiple_of(2),
            |_| 0.0,
        );
        found(line).verdict != Verdict::Clean
    };
    (0..lines).filter(is_alarm).count()
}

/// Of lines that lose 1.5 µm without a clock: how many say so, and of those how many have it inside two standard uncertainties.
fn told(correlation: f64, lines: u64) -> (usize, usize) {
    let sizes = (0..lines).filter_map(|seed| {
        let line = line(correlation, &mut generator(seed, 121), false, |place| {
            -0.5 * place.side() * 1.5
        });
        lost_motion(&found(line))
    });
    let sizes: Vec<[f64; 2]> = sizes.collect();
    let is_inside = |[value, u]: &&[f64; 2]| (value - 1.5).abs() < 2.0 * u;
    (sizes.len(), sizes.iter().filter(is_inside).count())
}

fn lost_motion(found: &Diagnosis) -> Option<[f64; 2]> {
    let cause = found.causes.iter().find(|cause| {
        let is_it = cause.effect.effect.id.contains("backlash");
        assert!(is_it, "{}", summary(found));
        is_it
    })?;
    let size = cause.mean_lost_motion.as_ref();
    let size = size.unwrap_or(&cause.parameters[0]);
    Some([size.value, size.u])
}

/// Taken as independent, such errors were "unknown" or a jump in 33 of 40 lines. Of 200 lines 5 to 8 % are alarms (below): more than four
/// of 20 with a probability of 0.01.
#[test]
fn air_that_stirs_is_no_cause() {
    let alarms = alarms(0.5, 20);
    assert!(alarms <= 4, "{alarms} of 20");
}

/// Two standard uncertainties hold the lost motion in 17 of 20 lines at least (fewer with a probability of 0.003; 29 of 34 held it before).
#[test]
fn lost_motion_in_air_that_stirs_has_its_uncertainty() {
    let (told, inside) = told(0.5, 20);
    assert!(told >= 19 && inside + 3 >= told, "{inside} of {told} of 20");
}

/// `cargo test -p trueaxis-diagnose --test diagnose correlated -- --ignored --nocapture`
#[test]
#[ignore = "a study"]
fn counts_by_correlation() {
    for correlation in [0.0, 0.3, 0.5, 0.7] {
        let alarms = alarms(correlation, 200);
        let (told, inside) = told(correlation, 200);
        crate::report(&format!(
            "correlation {correlation}: {alarms} alarms of 200; lost motion told in {told} of 200, inside 2 u in {inside}"
        ));
    }
}
