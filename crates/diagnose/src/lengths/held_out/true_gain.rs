//! The held-out gain against the gain on fresh measurements of the same machine.
//!
//! A campaign with a disturbance is diagnosed and its held-out ratio taken. Then the same machine, with the
//! same disturbance, is measured again and again with fresh noise; the ratio with which the models of
//! the first campaign predict those lengths is the true one.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_simulate::{Scenario, simulate};

use super::{HeldOut, held_out_stations, held_out_sweeps};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::search::look;

/// Fresh campaigns behind each true ratio.
const FRESH: u64 = 4;

/// Squares without and with the causes of a fresh campaign, predicted by models of another.
fn squares_on(fresh: &Base<'_>, base: &Base<'_>, plain: &Adjusted, named: &Adjusted) -> [f64; 2] {
    [plain, named].map(|model| {
        let mut misfit_mm = base.predicted_misfit_mm(fresh, model);
        named.whitened.whiten(&mut misfit_mm);
        misfit_mm.iter().map(|e| e * e).sum()
    })
}

/// A disturbance of random size that shows clearly to hardly.
fn disturbed(scenario: &str, generator: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario::from_json(scenario).unwrap();
    let size = 4.0 * 4.0_f64.powf(generator.random());
    let mut component = || size * generator.random_range(-1.0..1.0);
    let vector = |name: &str, v: [f64; 3]| -> String {
        let parts = ["x", "y", "z"].iter().zip(v).map(|(axis, value)| {
            format!(r#"{{ "name": "{name}_{axis}", "value": {value}, "unit": "um" }}"#)
        });
        parts.collect::<Vec<_>>().join(", ")
    };
    let v = [component(), component(), component()];
    let station = &scenario.stations[generator.random_range(0..scenario.stations.len())].name;
    let time_s = generator.random_range(500.0..2500.0);
    let time = format!(r#"{{ "name": "time", "value": {time_s}, "unit": "s" }}"#);
    let effect = match generator.random_range(0..4) {
        0 => format!(
            r#"[{{ "effect": "station_drift", "subject": {{ "station": "{station}" }}, "parameters": [{}] }}]"#,
            vector("creep", v)
        ),
        1 => format!(
            r#"[{{ "effect": "machine_shift", "subject": {{}}, "parameters": [{}, {time}] }}]"#,
            vector("shift", v)
        ),
        2 => format!(
            r#"[{{ "effect": "target_slip", "subject": {{ "target": "Q" }}, "parameters": [{}, {time}] }}]"#,
            vector("slip", v)
        ),
        _ => format!(
            r#"[{{ "effect": "dead_path_drift", "subject": {{ "station": "{station}" }}, "parameters": [{{ "name": "rate_{station}", "value": {}, "unit": "um" }}] }}]"#,
            v[0]
        ),
    };
    scenario.effects = serde_json::from_str(&effect).unwrap();
    scenario
}

/// The true ratio and the held-out one of a case; `None` if no cause was named.
fn case(
    seed: u64,
    scenario: &str,
    held_out: impl Fn(&Base<'_>, &Adjusted) -> Option<HeldOut>,
) -> Option<(f64, HeldOut)> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let scenario = disturbed(scenario, &mut generator);
    let measured = |seed: u64| simulate(&scenario, seed).unwrap().campaign;
    let campaign = measured(1000 * seed);
    let base = Base::new(&campaign, campaign.lengths.as_ref().unwrap(), None).unwrap();
    let looked = look(&base).unwrap();
    if looked.named.found.is_empty() {
        return None;
    }
    let held_out = held_out(&base, &looked.named.adjusted)?;
    let mut sums = [0.0; 2];
    for repetition in 1..=FRESH {
        let campaign = measured(1000 * seed + repetition);
        let lengths = campaign.lengths.as_ref().unwrap();
        let all = trueaxis_multilateration::network_from_campaign(&campaign, lengths, false);
        let gross: Vec<usize> = base.left_out.iter().map(|l| l.number).collect();
        let fresh = Base::leaving_out(&campaign, lengths, all, &gross, None).unwrap();
        let squares = squares_on(&fresh, &base, &looked.plain, &looked.named.adjusted);
        sums = [sums[0] + squares[0], sums[1] + squares[1]];
    }
    Some(((sums[1] / sums[0]).sqrt(), held_out))
}

/// Counts in how many cases the 95 % interval holds the true ratio, and in how many a gain is claimed
/// although there is none.
#[expect(clippy::print_stdout, reason = "a study prints its counts")]
fn count(
    seeds: std::ops::Range<u64>,
    scenario: &str,
    held_out: impl Fn(&Base<'_>, &Adjusted) -> Option<HeldOut> + Sync,
) -> (usize, usize) {
    let (mut inside, mut cases, mut false_claims) = (0, 0, 0);
    for seed in seeds {
        let Some((truth, held)) = case(seed, scenario, &held_out) else {
            println!("  seed {seed}: no cause named");
            continue;
        };
        let [low, high] = held.interval;
        let ratio = held.after / held.before;
        let is_inside = (low..=high).contains(&truth);
        println!(
            "  seed {seed}: true {truth:.4}, held out {ratio:.4} ({low:.4} to {high:.4}){}",
            if is_inside { "" } else { "  outside" }
        );
        cases += 1;
        inside += usize::from(is_inside);
        false_claims += usize::from(high < 1.0 && truth >= 1.0);
    }
    println!(
        "true gain inside the 95 % interval: {inside} of {cases}; gains claimed where there is none: {false_claims}"
    );
    assert_eq!(false_claims, 0);
    (inside, cases)
}

const ROTARY: &str = include_str!("../../../../../campaigns/rotary-stage/scenario.json");

fn sweeps(base: &Base<'_>, adjusted: &Adjusted) -> Option<HeldOut> {
    held_out_sweeps(base, adjusted).unwrap()
}

/// Of 3 cases right intervals lose more than one in 1 of 140 sets of seeds.
#[test]
fn the_interval_holds_the_true_gain() {
    let (inside, cases) = count(0..4, ROTARY, sweeps);
    assert!(cases >= 3 && inside + 1 >= cases, "{inside} of {cases}");
}

const FXYZ: &str = include_str!("../../../../../campaigns/fxyz/scenario.json");

/// The figures in docs/diagnosis.md: of 136 cases right intervals lose more than 13 with a probability of
/// 8e-3.
#[test]
#[ignore = "study: 180 cases of five campaigns"]
fn the_interval_holds_the_true_gain_in_95_of_100() {
    let (rotary_inside, rotary) = count(100..220, ROTARY, sweeps);
    let (fxyz_inside, fxyz) = count(300..360, FXYZ, sweeps);
    let (inside, cases) = (rotary_inside + fxyz_inside, rotary + fxyz);
    assert!(cases >= 100, "{cases} named");
    assert!(10 * inside >= 9 * cases, "{inside} of {cases}");
}

/// Two more stations, and one effect.
fn six_stations(effect: &str) -> Scenario {
    let mut scenario = Scenario::from_json(ROTARY).unwrap();
    for (name, [x, y, z]) in [
        ("S5", [-900.0, 700.0, 500.0]),
        ("S6", [300.0, -900.0, 800.0]),
    ] {
        let mut station = scenario.stations[0].clone();
        name.clone_into(&mut station.name);
        station.position_mm = [x, y, z];
        scenario.stations.push(station);
    }
    scenario.effects = serde_json::from_str(effect).unwrap();
    scenario
}

fn stations_out(effect: &str) -> HeldOut {
    let campaign = simulate(&six_stations(effect), 5).unwrap().campaign;
    let base = Base::new(&campaign, campaign.lengths.as_ref().unwrap(), None).unwrap();
    let looked = look(&base).unwrap();
    assert!(!looked.named.found.is_empty());
    held_out_stations(&base, &looked.named.adjusted)
        .unwrap()
        .expect("six stations")
}

#[test]
fn a_slip_seen_by_five_stations_predicts_the_sixth() {
    let slip = stations_out(
        r#"[{ "effect": "target_slip", "subject": { "target": "Q" }, "parameters": [
            { "name": "slip_x", "value": 2, "unit": "um" }, { "name": "slip_y", "value": -8, "unit": "um" },
            { "name": "slip_z", "value": 3, "unit": "um" }, { "name": "time", "value": 1800, "unit": "s" }] }]"#,
    );
    assert!(slip.interval[1] < 0.9, "{slip:?}");
}

#[test]
fn a_bump_of_one_station_is_nothing_the_others_know_of() {
    let bump = stations_out(
        r#"[{ "effect": "station_jump", "subject": { "station": "S3" }, "parameters": [
            { "name": "jump_x", "value": 6, "unit": "um" }, { "name": "jump_y", "value": -8, "unit": "um" },
            { "name": "jump_z", "value": 3, "unit": "um" }, { "name": "time", "value": 3200, "unit": "s" }] }]"#,
    );
    let ratio = bump.after / bump.before;
    assert!(bump.interval[1] >= 0.99 && ratio > 0.9, "{bump:?}");
}
