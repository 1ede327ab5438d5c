//! The blind study: does the diagnosis name what was hidden?
//!
//! ```sh
//! cargo run --release -p trueaxis-tests --example blind -- [SEEDS] [STRENGTH] [EFFECT ...]
//! ```
//!
//! SEEDS is a number or a range, as `100..112`; `a+b` hides two effects, `a~` one whose shape is not quite
//! that of the catalogue. `a@0.3` hides `a` beside a hall that breathes and a tripod that sways, both with 0.3 of the
//! usual strength λ = 7, in noise with heavy tails; `mess@0.3` is that alone.
//!
//! For every effect and seed a campaign with that effect hidden in it at the strength λ is diagnosed;
//! the truth is opened afterwards. `clean` as an effect counts false alarms.

#![expect(clippy::print_stdout, reason = "a study prints its counts")]

use std::collections::BTreeMap;

use trueaxis_diagnose::{Diagnosis, Rival, Settings, Verdict, diagnose};
use trueaxis_tests::blind::{self, Hidden, Kind};
use trueaxis_tests::in_parallel;

/// What a diagnosis says of one campaign.
struct Outcome {
    label: String,
    right: bool,
    held: bool,
    line: String,
    inside: Vec<bool>,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seeds = seeds(&arguments.next().unwrap_or_default());
    let strength: f64 = arguments.next().and_then(|a| a.parse().ok()).unwrap_or(7.0);
    let mut names: Vec<String> = arguments.collect();
    if names.is_empty() {
        let catalogued = blind::CATALOGUED
            .iter()
            .filter(|n| **n != "timestamp_offset");
        names = catalogued.map(|n| (*n).to_owned()).collect();
    }
    let mut total = BTreeMap::<&str, usize>::new();
    let mut inside = (0, 0);
    for name in &names {
        let started = std::time::Instant::now();
        let outcomes: Vec<Outcome> =
            in_parallel(seeds.clone(), |seed| outcome(name, seed, strength))
                .into_iter()
                .flatten()
                .collect();
        let mut labels = BTreeMap::<&str, usize>::new();
        let (mut right, mut held) = (0, 0);
        for outcome in &outcomes {
            *labels.entry(&outcome.label).or_default() += 1;
            right += usize::from(outcome.right);
            held += usize::from(outcome.held && !outcome.right);
            inside.0 += outcome.inside.iter().filter(|&&i| i).count();
            inside.1 += outcome.inside.len();
            if !outcome.right {
                println!("    {}", outcome.line);
            }
        }
        let all = outcomes.len();
        println!(
            "{name:24} {right:3} right, {held:3} held, of {all:3}: {labels:?}; {:.1} s",
            started.elapsed().as_secs_f64()
        );
        *total.entry("right").or_default() += right;
        *total.entry("held").or_default() += held;
        *total.entry("all").or_default() += all;
    }
    println!(
        "{total:?}; {} of {} parameters inside 95 %",
        inside.0, inside.1
    );
}

/// `12` or `100..112`.
fn seeds(text: &str) -> std::ops::Range<u64> {
    let range = text.split_once("..");
    let range = range.and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    range.unwrap_or_else(|| 0..text.parse().unwrap_or(10))
}

fn kind_of(name: &str, seed: u64) -> Kind {
    match (name, seed % 4) {
        ("backlash", 1) => Kind::rotary_stage().forward_and_backward(),
        ("backlash", _) => Kind::three_axis().forward_and_backward(),
        ("clean", 1) => Kind::three_axis().forward_and_backward(),
        ("clean", 2) => Kind::rotary_stage(),
        ("clean", 3) => Kind::rotary_stage().forward_and_backward(),
        ("timestamp_offset", _) => Kind::three_axis().on_the_fly(),
        ("loosening_drive", _) => Kind::three_axis().forward_and_backward(),
        (pair, _) if pair.contains("backlash") => Kind::three_axis().forward_and_backward(),
        _ => Kind::three_axis(),
    }
}

/// The strength of which a mess is a part.
const USUAL: f64 = 7.0;

fn outcome(name: &str, seed: u64, strength: f64) -> Option<Outcome> {
    let (name, mess) = match name.split_once('@') {
        Some((name, part)) => (name, part.parse::<f64>().ok()),
        None => (name, None),
    };
    let mut kind = kind_of(name, seed);
    if mess.is_some() {
        kind = kind.with_heavy_tails();
    }
    let hidden: Vec<Hidden> = if ["clean", "mess"].contains(&name) {
        Vec::new()
    } else {
        let mut all = Vec::new();
        for (number, part) in (0..).zip(name.trim_end_matches('~').split('+')) {
            let mut drawn = blind::draw(&kind, part, seed + 1000 * number)?;
            if name.ends_with('~') {
                drawn = blind::misshapen(&drawn, seed);
            }
            all.push(blind::at_strength(&kind, &drawn, seed, strength));
        }
        all
    };
    let mut all = hidden.clone();
    all.extend(
        mess.iter()
            .flat_map(|part| blind::mess(&kind, seed, part * USUAL)),
    );
    let campaign = blind::campaign(&kind, &all, seed);
    let settings = Settings {
        explain_curves: false,
        ..Settings::default()
    };
    let diagnosis = match diagnose(&campaign, &settings) {
        Ok(diagnosis) => diagnosis,
        Err(error) => {
            return Some(Outcome {
                label: "error".to_owned(),
                right: false,
                held: false,
                line: format!("seed {seed}: {error}"),
                inside: Vec::new(),
            });
        }
    };
    Some(judged(name, seed, &kind, &hidden, &diagnosis))
}

/// Whether that is what wanders in one that no catalogue has.
fn is_wandering(hidden: &Hidden, whose: &trueaxis_diagnose::Wandering) -> bool {
    let (layer, station) = (whose.layer.name(), whose.subject.station);
    let of_all =
        station.is_none() && whose.subject.target.is_none() && whose.subject.axis.is_none();
    let with = whose.varies_with;
    match hidden.name {
        "air_conditioning" => of_all && with == ["time"],
        "opposed_warm_ups" => of_all && with == ["time"] && layer != "instrument",
        "tripod_sway" => station == hidden.station && with == ["time"],
        "cross_talk" => station == hidden.station && with == ["position"],
        "warping_axis" => whose.subject.axis == hidden.axis && with == ["time", "position"],
        "loosening_drive" => whose.subject.axis == hidden.axis && with == ["time", "direction"],
        _ => false,
    }
}

fn judged(name: &str, seed: u64, kind: &Kind, hidden: &[Hidden], diagnosis: &Diagnosis) -> Outcome {
    let data = diagnosis
        .causes
        .iter()
        .filter(|c| c.level == trueaxis_effects::Level::Lengths);
    let causes: Vec<_> = data.collect();
    let is = |h: &Hidden, effect: &trueaxis_effects::ResolvedEffect| {
        let subject = &effect.subject;
        h.name == effect.effect.id
            && (h.station.is_none() || h.station == subject.station || subject.station.is_none())
            && (h.target.is_none() || h.target == subject.target)
            && (h.axis.is_none() || h.axis == subject.axis)
    };
    let matches = |effect: &trueaxis_effects::ResolvedEffect| hidden.iter().any(|h| is(h, effect));
    let mut label = diagnosis.verdict.name().to_owned();
    let mut line = format!("seed {seed}: {label}");
    for cause in &causes {
        let id = cause.effect.effect.id;
        label += &format!(" {id}");
        let subject = &cause.effect.subject;
        let who = [subject.station, subject.target, subject.axis];
        let (shape, p) = (cause.effect.shape, cause.p_value);
        line += &format!(" {id} {who:?} at {shape:.0} p={p:.1e}");
        for rival in &cause.rivals {
            line += &match rival {
                Rival::Effect { effect, .. } => {
                    format!(" | {} {:?}", effect.effect.id, effect.subject.station)
                }
                Rival::Disturbance { whose, .. } => {
                    format!(" | ~{}", whose.in_words(&diagnosis.scene))
                }
            };
        }
    }
    for hidden in hidden {
        line += &format!(
            "   TRUTH {} {:?} {:?} {:?}",
            hidden.name, hidden.station, hidden.target, hidden.axis
        );
    }
    for own in &diagnosis.disturbances {
        line += &format!(
            " ~{} {:.2} um {:.0} {}",
            own.whose.in_words(&diagnosis.scene),
            own.rms_um,
            own.correlation_length.value,
            own.correlation_length.unit
        );
    }
    if let Some(unexplained) = &diagnosis.unexplained {
        line += &format!(" [{}]", unexplained.note);
    }
    let wanders = |hidden: &Hidden| {
        let all = diagnosis.disturbances.iter();
        let mut all = all.flat_map(|own| std::iter::once(&own.whose).chain(&own.rivals));
        all.any(|whose| is_wandering(hidden, whose))
    };
    let may_wander = |hidden: &Hidden| {
        let mut rivals = causes.iter().flat_map(|cause| &cause.rivals);
        rivals.any(|rival| match rival {
            Rival::Effect { .. } => false,
            Rival::Disturbance { whose, .. } => is_wandering(hidden, whose),
        })
    };
    let right = if name == "clean" {
        diagnosis.verdict == Verdict::Clean
    } else if name == "mess" {
        diagnosis.verdict != Verdict::Named
    } else if name == "loosening_drive" {
        // Its mean is lost motion.
        let is_mean = |c: &&trueaxis_diagnose::Cause| {
            c.effect.effect.id == "backlash" && c.effect.subject.axis == hidden[0].axis
        };
        hidden.iter().all(wanders) && causes.iter().all(is_mean)
    } else if name == "opposed_warm_ups" && !causes.is_empty() {
        // A machine that warms up, with one time constant or both.
        causes.iter().all(|c| c.effect.effect.id == "warm_up")
    } else if blind::UNCATALOGUED.contains(&name) {
        diagnosis.verdict == Verdict::Unknown && hidden.iter().all(wanders)
    } else {
        diagnosis.verdict == Verdict::Named
            && causes.len() == hidden.len()
            && causes.iter().all(|c| matches(&c.effect))
    };
    let held = !hidden.is_empty()
        && hidden.iter().all(|h| {
            let holds = |c: &trueaxis_diagnose::Cause| {
                is(h, &c.effect) || c.rival_effects().any(|r| is(h, r))
            };
            causes.iter().any(|c| holds(c)) || wanders(h) || may_wander(h)
        });
    let mut inside = Vec::new();
    if let (Some(hidden), Some(cause)) = (hidden.first(), causes.first())
        && matches(&cause.effect)
        && hidden.station == cause.effect.subject.station
    {
        for truth in hidden.parameters(kind) {
            let found = cause.parameters.iter().find(|p| p.name == truth.name);
            inside.extend(found.map(|p| (p.value - truth.value).abs() <= 1.96 * p.u));
        }
    }
    Outcome {
        label,
        right,
        held,
        line,
        inside,
    }
}
