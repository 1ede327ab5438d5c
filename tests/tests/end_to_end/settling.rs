//! Tripods that settle: told from a machine that warms up where the lengths can, and a rival of it where they cannot.

use trueaxis_diagnose::{Cause, Settings, diagnose};
use trueaxis_tests::blind::{self, Kind};

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
