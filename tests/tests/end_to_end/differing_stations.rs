//! Stations that differ from the others: one whose lengths scatter more, one from which the machine was measured on another day.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Settings as Calibrating, calibrate};
use trueaxis_campaign::{Campaign, Stop};
use trueaxis_diagnose::{Diagnosis, Rival, Settings, Verdict, diagnose};
use trueaxis_effects::Layer;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::blind::{self, Kind};
use trueaxis_tests::estimators::SCENARIOS;
use trueaxis_tests::{Kind as Of, Scatter, in_parallel};

fn diagnosed(campaign: &Campaign) -> Diagnosis {
    let settings = Settings {
        explain_curves: false,
        ..Settings::default()
    };
    diagnose(campaign, &settings).unwrap()
}

/// Noise of so many µm on the lengths of the third station, besides.
fn scattered(campaign: &mut Campaign, sigma_um: f64, seed: u64) {
    scattered_at(campaign, sigma_um, seed, |_, stop, _| stop.station == 2);
}

/// The same on some lengths, by their part of the campaign, their stop and their target.
fn scattered_at(
    campaign: &mut Campaign,
    sigma_um: f64,
    seed: u64,
    is_at: impl Fn(f64, &Stop, usize) -> bool,
) {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let lengths = campaign.lengths.as_mut().unwrap();
    let count = lengths.stops.len() as f64;
    for (number, stop) in (0_u32..).zip(&lengths.stops) {
        for reading in &mut lengths.readings[stop.readings.clone()] {
            if is_at(f64::from(number) / count, stop, reading.target) {
                let noise: f64 = StandardNormal.sample(&mut generator);
                reading.length_mm += 1e-3 * sigma_um * noise;
            }
        }
    }
}

/// One tripod of four on a soft floor: in the noise of all, seven of twelve such campaigns had a jump, a slip or something unknown.
/// Two clean campaigns alarm with a probability of some 2 %; these seeds do not.
#[test]
fn a_station_that_scatters_more_names_nothing() {
    for (seed, sigma_um) in [(1, 2.0), (2, 1.0)] {
        let mut campaign = blind::campaign(&Kind::three_axis(), &[], 300 + seed);
        scattered(&mut campaign, sigma_um, seed);
        let found = diagnosed(&campaign);
        assert_eq!(
            found.verdict,
            Verdict::Clean,
            "seed {seed}: {:?}",
            found.causes
        );
        let is_said = |notice: &String| {
            notice.starts_with("station S3: its lengths scatter") && notice.contains("weigh less")
        };
        assert!(
            found.notices.iter().any(is_said),
            "seed {seed}: {:?}",
            found.notices
        );
        // So it is of a calibration, which removes none of these lengths.
        let calibration = calibrate(&campaign, &Calibrating::default()).unwrap();
        let mut notices = calibration.notices.iter();
        let says_so = |n: &String| n.starts_with("station S3: its lengths scatter");
        assert!(notices.any(says_so), "seed {seed}");
        assert!(calibration.adjustment.rejected.is_empty(), "seed {seed}");
    }
}

/// A forklift beside the machine for a quarter of the campaign: lengths with three times the noise were a cause, or unknown, in 9 of 32
/// campaigns, and in 3 since they weigh less. Of four one may alarm (more would with a probability of 5 %; these seeds do not).
#[test]
fn a_part_of_the_campaign_that_scatters_more_names_nothing() {
    let outcomes = in_parallel(0..4_u64, |seed| {
        let mut campaign = blind::campaign(&Kind::three_axis(), &[], 700 + seed);
        let first = 0.2 * (seed as f64 + 0.5);
        scattered_at(&mut campaign, 0.76, seed, |part, _, _| {
            (first..first + 0.25).contains(&part)
        });
        let found = diagnosed(&campaign);
        let mut notices = found.notices.iter();
        let is_said = notices.any(|n| n.contains("as much as the others, and weigh less"));
        assert_ne!(
            found.verdict,
            Verdict::Named,
            "seed {seed}: {:?}",
            found.causes
        );
        (is_said, found.verdict == Verdict::Clean)
    });
    assert!(outcomes.iter().all(|(is_said, _)| *is_said), "{outcomes:?}");
    let alarms = outcomes.iter().filter(|(_, is_clean)| !is_clean).count();
    assert!(alarms <= 1, "{outcomes:?}");
}

/// A dirty reflector: in the noise of all, twenty of a hundred campaigns had a cause, or something unknown.
#[test]
fn a_target_that_scatters_more_is_said_and_names_nothing() {
    let mut campaign = blind::campaign(&Kind::three_axis(), &[], 400);
    scattered_at(&mut campaign, 1.0, 0, |_, _, target| target == 2);
    let found = diagnosed(&campaign);
    assert_eq!(found.verdict, Verdict::Clean, "{:?}", found.causes);
    let calibration = calibrate(&campaign, &Calibrating::default()).unwrap();
    for notices in [found.notices, calibration.notices] {
        let is_said = |n: &String| n.starts_with("target K: its lengths scatter");
        assert!(notices.iter().any(is_said), "{notices:?}");
    }
}

/// What a calibration states with a dirty reflector, or a tripod on a soft floor, is its scatter: error / u and the share of
/// the 95 % intervals, pooled over 12 campaigns, within 5 standard errors (by chance one of the six fails with a probability of 3e-3).
/// With 4 µm, many lengths are gross errors by the noise of all, and calibrations were refused. Errors are smaller than with the same weight for all, on the same lengths.
#[test]
fn u_is_the_scatter_where_some_lengths_scatter_more() {
    let (_, text) = SCENARIOS[0];
    let scenario = Scenario::from_json(text).unwrap();
    let mut alike = Calibrating::default();
    alike.poses.robust = false;
    for (of_target, sigma_um) in [(true, 1.0), (false, 1.0), (false, 4.0)] {
        let calibrated = in_parallel(500..512_u64, |seed| {
            let mut simulated = simulate(&scenario, seed).unwrap();
            scattered_at(
                &mut simulated.campaign,
                sigma_um,
                seed,
                |_, stop, target| {
                    if of_target {
                        target == 2
                    } else {
                        stop.station == 2
                    }
                },
            );
            [Calibrating::default(), alike].map(|settings| {
                let calibration = calibrate(&simulated.campaign, &settings).unwrap();
                let mut scatter = Scatter::default();
                scatter.add(&calibration, &simulated.truth);
                scatter
            })
        });
        let [weighed, alike] = [0, 1].map(|which| Scatter {
            campaigns: calibrated
                .iter()
                .flat_map(|of_seed| of_seed[which].campaigns.clone())
                .collect(),
        });
        let pooled = weighed.pooled(|d| d.kind.is_of_machine());
        println!("target: {of_target}, {sigma_um} µm: {pooled}");
        assert!(
            pooled.is_as_stated(5.0),
            "target: {of_target}, {sigma_um} µm: {pooled}"
        );
        let is_length = |kind: Of| matches!(kind, Of::Component(own) if !own.is_angular());
        let rms_mm = |scatter: &Scatter| scatter.pooled(|d| is_length(d.kind)).rms;
        let gain = rms_mm(&weighed) / rms_mm(&alike);
        println!(
            "target: {of_target}, {sigma_um} µm: rms error {gain:.2} of that with the same weight"
        );
        assert!(gain < 1.0, "target: {of_target}, {sigma_um} µm: {gain}");
    }
}

/// How many of a hundred campaigns with a dirty reflector alarm, and in how many it is named.
#[test]
#[ignore = "study: 300 diagnoses"]
fn targets_that_scatter_more_hardly_ever_name_anything() {
    for sigma_um in [0.5, 1.0, 4.0] {
        let outcomes = in_parallel(0..100_u64, |seed| {
            let mut campaign = blind::campaign(&Kind::three_axis(), &[], 400 + seed);
            scattered_at(&mut campaign, sigma_um, seed, |_, _, target| target == 2);
            let found = diagnosed(&campaign);
            let says_so = |n: &String| n.starts_with("target K: its lengths scatter");
            let is_said = found.notices.iter().any(says_so);
            let is_other = found
                .notices
                .iter()
                .any(|n| n.contains("lengths scatter") && !says_so(n));
            (found.verdict != Verdict::Clean, is_said, is_other)
        });
        let count = |is: fn(&(bool, bool, bool)) -> bool| outcomes.iter().filter(|o| is(o)).count();
        let [alarms, said, others] = [count(|o| o.0), count(|o| o.1), count(|o| o.2)];
        println!(
            "{sigma_um} µm: {alarms} of 100 alarm; K is said to scatter in {said}, others in {others}"
        );
        assert!(
            alarms < 8 && said > 95 && others == 0,
            "{sigma_um} µm: {alarms}, {said}, {others}"
        );
    }
}

/// How many of a hundred campaigns with such a station alarm. Of clean ones some 1 to 1.5 % do; eight of a hundred would be by chance
/// with a probability of 4e-4.
#[test]
#[ignore = "study: 300 diagnoses"]
fn stations_that_scatter_more_hardly_ever_name_anything() {
    for sigma_um in [0.5, 1.0, 3.0] {
        let alarms = in_parallel(0..100_u64, |seed| {
            let mut campaign = blind::campaign(&Kind::three_axis(), &[], 400 + seed);
            scattered(&mut campaign, sigma_um, seed);
            diagnosed(&campaign).verdict != Verdict::Clean
        })
        .into_iter()
        .filter(|&is| is);
        let alarms = alarms.count();
        println!("{sigma_um} µm: {alarms} of 100 alarm");
        assert!(alarms < 8, "{sigma_um} µm: {alarms}");
    }
}

/// From one station a machine that is larger by some ppm, since it is warmer, is a scale of its lengths: "wrong air" was named alone in 11
/// of 24 such campaigns. Targets on the bed stay where they are, and tell.
#[test]
fn a_scale_of_one_station_may_be_a_warmer_machine() {
    for (kind, is_told) in [
        (Kind::three_axis(), false),
        (Kind::three_axis().with_bed(5), true),
    ] {
        let hidden = blind::draw(&kind, "station_scale", 1).unwrap();
        let hidden = blind::at_strength(&kind, &hidden, 1, 12.0);
        let found = diagnosed(&blind::campaign(&kind, &[hidden], 1));
        let mut causes = found.causes.iter();
        let cause = causes
            .find(|cause| cause.effect.effect.id == "station_scale")
            .unwrap();
        let is_machine = |rival: &Rival| match rival {
            Rival::Disturbance { whose, .. } => whose.layer == Layer::Machine,
            Rival::Effect { .. } => false,
        };
        assert_eq!(
            cause.rivals.iter().any(is_machine),
            !is_told,
            "{:?}",
            cause.rivals
        );
    }
}
