//! Tripods that settle: told from a machine that warms up where the lengths can, and a rival of it where they cannot. Machines
//! that warm up with two time constants.

use trueaxis_diagnose::{Cause, Settings, diagnose};
use trueaxis_tests::blind::{self, Act, Course, Kind};
use trueaxis_tests::in_parallel;

/// Ids and stations of a cause and its rivals.
fn explanations(cause: &Cause) -> Vec<(&'static str, Option<usize>)> {
    let rivals = cause.rival_effects();
    let all = rivals.chain([&cause.effect]);
    all.map(|e| (e.effect.id, e.subject.station)).collect()
}

/// At λ = 12 one of five is missed with a probability below 1e-5; time constants are 3 to 30 % of an occupation.
#[test]
fn a_tripod_that_settles_is_no_machine_that_warms_up() {
    let kind = Kind::three_axis();
    let (mut first, mut later) = (0, 0);
    for seed in 0..5 {
        let hidden = blind::draw(&kind, "station_settling", seed).unwrap();
        let hidden = blind::at_strength(&kind, &hidden, seed, 12.0);
        let campaign = blind::campaign(&kind, std::slice::from_ref(&hidden), seed);
        let settings = Settings {
            explain_curves: false,
            ..Settings::default()
        };
        let diagnosis = diagnose(&campaign, &settings).unwrap();
        let all: Vec<_> = diagnosis.causes.iter().flat_map(explanations).collect();
        println!("{seed} {:?}: {all:?}", hidden.station);
        assert!(all.contains(&("station_settling", hidden.station)));
        let warms_up = all.contains(&("warm_up", None));
        // What a machine does while it warms up within the first occupation, the first tripod does as well.
        match hidden.station {
            Some(0) => first += usize::from(warms_up),
            _ => later += usize::from(warms_up),
        }
    }
    assert!(first >= 1 && later == 0, "{first} {later}");
}

/// A spindle that warms up within minutes while the bed does within hours, the other way: both have their name and their values, or what
/// wanders has all of it; one time constant and "the scale of an axis" was said. Of sixteen values one is beyond four standard
/// uncertainties with a probability of 0.1 %.
#[test]
fn a_machine_warms_up_with_two_time_constants() {
    let kind = Kind::three_axis();
    let both: Vec<bool> = in_parallel(3000..3004, |seed| {
        let hidden = blind::draw(&kind, "opposed_warm_ups", seed).unwrap();
        let hidden = blind::at_strength(&kind, &hidden, seed, 40.0);
        let campaign = blind::campaign(&kind, std::slice::from_ref(&hidden), seed);
        let settings = Settings {
            explain_curves: false,
            ..Settings::default()
        };
        let mut causes = diagnose(&campaign, &settings).unwrap().causes;
        assert!(causes.iter().all(|c| c.effect.effect.id == "warm_up"));
        if causes.is_empty() {
            return false;
        }
        let (
            Act::Machine(growth),
            Course::OpposedWarmUps {
                fast_s,
                slow_s,
                ratio,
            },
        ) = (&hidden.act, &hidden.course)
        else {
            panic!("{hidden:?}");
        };
        causes.sort_by(|a, b| a.effect.shape.total_cmp(&b.effect.shape));
        assert_eq!(causes.len(), 2, "seed {seed}");
        for (cause, (growth, time_s)) in causes
            .iter()
            .zip([(*growth, fast_s), (-*ratio * growth, slow_s)])
        {
            let truth = growth.iter().chain([time_s]);
            for (parameter, truth) in cause.parameters.iter().zip(truth) {
                let error = (parameter.value - truth).abs();
                assert!(
                    error < 4.0 * parameter.u,
                    "seed {seed}: {truth}, {parameter:?}"
                );
            }
        }
        true
    });
    let count = both.iter().filter(|&&both| both).count();
    assert!(count >= 2, "{count}");
}
