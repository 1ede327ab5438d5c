//! What wanders in a course that nobody knows: beside a cause it takes no name away, alone it gets none.
//!
//! The fast part of the studies of docs/diagnosis-tests.md (`examples/blind.rs`).

use trueaxis_campaign::Campaign;
use trueaxis_diagnose::{Diagnosis, Rival, Settings, Verdict, Wandering, diagnose};
use trueaxis_effects::Level;
use trueaxis_tests::blind::{self, Hidden, Kind};
use trueaxis_tests::in_parallel;

fn both_sides() -> Kind {
    Kind::three_axis().forward_and_backward()
}

fn diagnosed(kind: &Kind, hidden: &[Hidden], seed: u64) -> Diagnosis {
    diagnosed_campaign(&blind::campaign(kind, hidden, seed))
}

fn diagnosed_campaign(campaign: &Campaign) -> Diagnosis {
    let settings = Settings {
        explain_curves: false,
        ..Settings::default()
    };
    diagnose(campaign, &settings).unwrap()
}

fn hide(kind: &Kind, name: &str, seed: u64, strength: f64) -> Hidden {
    let drawn = blind::draw(kind, name, seed).unwrap();
    blind::at_strength(kind, &drawn, seed, strength)
}

fn names(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let causes = diagnosis.causes.iter();
    let of_lengths = causes.filter(|cause| cause.level == Level::Lengths);
    of_lengths.map(|cause| cause.effect.effect.id).collect()
}

/// Lost motion of λ = 14 in a hall that breathes with λ = 20: the name stays, its value is inside three of its
/// uncertainties (missed with a probability of 0.3 %), what breathes is told beside it, and all parts add up.
#[test]
fn lost_motion_keeps_its_name_in_a_hall_that_breathes() {
    let seed = 300;
    let kind = both_sides();
    let lost_motion = hide(&kind, "backlash", seed, 14.0);
    let hall = hide(&kind, "air_conditioning", seed, 20.0);
    let diagnosis = diagnosed(&kind, &[lost_motion.clone(), hall], seed);
    assert_eq!(diagnosis.verdict, Verdict::Named, "seed {seed}");
    assert_eq!(names(&diagnosis), ["backlash"], "seed {seed}");
    let cause = &diagnosis.causes[0];
    assert_eq!(cause.effect.subject.axis, lost_motion.axis);
    let truth = &lost_motion.parameters(&kind)[0];
    let found = &cause.parameters[0];
    assert!(
        (found.value - truth.value).abs() < 3.0 * found.u,
        "{found:?}, {truth:?}"
    );
    let own = diagnosis.disturbances.first().expect("the hall");
    assert_eq!(own.whose.varies_with, ["time"]);
    let shares = &diagnosis.levels[0].shares;
    let parts = shares.causes.iter().chain(&shares.disturbances);
    let sum = parts.sum::<f64>() + shares.unexplained + shares.noise;
    assert!((sum - 1.0).abs() < 1e-9, "{shares:?}");
}

/// What the catalogue does not have gets no name but its subject, its size and its course; in the same noise without
/// it all is clean (one of four alarms with a probability of 5 %).
#[test]
fn what_no_catalogue_has_is_told_by_what_wanders() {
    let kind = Kind::three_axis();
    let wrong: Vec<String> =
        in_parallel(["air_conditioning", "tripod_sway", "cross_talk"], |name| {
            let seed = 310;
            let hidden = hide(&kind, name, seed, 20.0);
            let diagnosis = diagnosed(&kind, std::slice::from_ref(&hidden), seed);
            let own = diagnosis.disturbances.first();
            let right = own.is_some_and(|own| {
                let is_seen = own.curve.iter().any(|point| {
                    let pairs = point.value_um.iter().zip(&point.u_um);
                    pairs.into_iter().any(|(value, u)| value.abs() > 3.0 * u)
                });
                own.whose.subject.station == hidden.station && is_seen && own.curve.len() >= 33
            });
            let is_unknown = diagnosis.verdict == Verdict::Unknown && names(&diagnosis).is_empty();
            (!is_unknown || !right).then(|| format!("{name}: {own:?}"))
        })
        .into_iter()
        .flatten()
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let control = diagnosed(&kind, &[], 310);
    assert_eq!(control.verdict, Verdict::Clean);
    assert!(control.disturbances.is_empty());
}

/// An axis that warms up while it is measured, and a drive whose lost motion changes (its mean may have its name), are told by
/// axis with λ = 40, and no other cause is named. Those that warm up, two of them in the study, are of twelve whose steep beginning was called a target
/// that slips, or an axis that expands, by half waves that end where the campaign does.
#[test]
fn what_an_axis_does_with_time_is_told() {
    assert_axes_are_told(&[
        ("warping_axis", 312, ["time", "position"]),
        ("loosening_drive", 312, ["time", "direction"]),
    ]);
}

#[test]
#[ignore = "study: two more campaigns"]
fn what_other_axes_do_with_time_is_told() {
    assert_axes_are_told(&[318, 323].map(|seed| ("warping_axis", seed, ["time", "position"])));
}

fn assert_axes_are_told(cases: &[(&str, u64, [&str; 2])]) {
    let wrong: Vec<String> = in_parallel(cases, |&(name, seed, with)| {
        let kind = match name {
            "loosening_drive" => both_sides(),
            _ => Kind::three_axis(),
        };
        let hidden = hide(&kind, name, seed, 40.0);
        let diagnosis = diagnosed(&kind, std::slice::from_ref(&hidden), seed);
        let is_it =
            |whose: &Wandering| whose.varies_with == with && whose.subject.axis == hidden.axis;
        let is_told = diagnosis.disturbances.iter().any(|own| is_it(&own.whose));
        let is_other = names(&diagnosis).iter().any(|name| *name != "backlash");
        (!is_told || is_other).then(|| format!("{name}, seed {seed}: {:?}", names(&diagnosis)))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A tripod that sways with λ = 10 may look like a drift or a jump (`ideal_observer`), but then what sways is among the rivals:
/// with the six of seeds 3010 to 3015 one may miss it (of twenty, two did).
#[test]
fn what_sways_is_a_rival_of_the_drift_that_it_looks_like() {
    let kind = Kind::three_axis();
    let missed: Vec<String> = in_parallel(3010..3016_u64, |seed| {
        let hidden = hide(&kind, "tripod_sway", seed, 10.0);
        let diagnosis = diagnosed(&kind, std::slice::from_ref(&hidden), seed);
        let is_it = |whose: &Wandering| whose.subject.station == hidden.station;
        let is_told = diagnosis.disturbances.iter().any(|own| is_it(&own.whose));
        let mut rivals = diagnosis.causes.iter().flat_map(|cause| &cause.rivals);
        let is_rival = rivals.any(|rival| match rival {
            Rival::Disturbance { whose, .. } => is_it(whose),
            Rival::Effect { .. } => false,
        });
        let is_named = diagnosis.verdict == Verdict::Named;
        (is_named || !is_told && !is_rival).then(|| format!("{seed}: {:?}", names(&diagnosis)))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(missed.len() < 2, "{missed:#?}");
}

/// A hall that breathes at a quarter to once the usual strength is never two or three stacked causes.
#[test]
fn a_hall_that_breathes_is_no_stack_of_causes() {
    let kind = Kind::three_axis();
    let cases: Vec<(u64, f64)> = (320..324)
        .flat_map(|seed| [(seed, 5.0), (seed, 7.0)])
        .collect();
    let stacked: Vec<String> = in_parallel(cases, |(seed, strength)| {
        let hall = hide(&kind, "air_conditioning", seed, strength);
        let names = names(&diagnosed(&kind, &[hall], seed));
        (names.len() > 1).then(|| format!("seed {seed}, λ = {strength}: {names:?}"))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(stacked.is_empty(), "{stacked:#?}");
}

/// One length in fifty is wrong by 20 to 300 µm: they are left out, what is clean is clean, and a slip of 8 µm keeps its name and size. When
/// more than one in a hundred stayed in, one in ten of these had a slip of hundreds of micrometres (2 of 6 here).
#[test]
fn many_wrong_lengths_are_left_out_and_name_nothing() {
    let kind = Kind::three_axis();
    let slip = || hide(&kind, "target_slip", 343, 40.0);
    let wrong: Vec<String> = in_parallel(
        [(340, false), (341, false), (342, false), (343, true)],
        |(seed, slips)| {
            let hidden: Vec<_> = slips.then(slip).into_iter().collect();
            let mut campaign = blind::campaign(&kind, &hidden, seed);
            let readings = &mut campaign.lengths.as_mut().unwrap().readings;
            for (k, reading) in readings.iter_mut().step_by(50).enumerate() {
                let size_mm = 0.02 + 0.28 * ((7 * k) % 47) as f64 / 47.0;
                reading.length_mm += if k % 3 == 0 { -size_mm } else { size_mm };
            }
            let diagnosis = diagnosed_campaign(&campaign);
            let causes: Vec<&str> = diagnosis
                .causes
                .iter()
                .map(|c| c.effect.effect.id)
                .collect();
            let right = match slips {
                true => causes == ["target_slip"],
                false => diagnosis.verdict == Verdict::Clean,
            };
            (!right).then(|| format!("{seed}: {} {causes:?}", diagnosis.verdict.name()))
        },
    )
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// One length that is wrong by 8 µm to 5 mm is left out, with its line, and all else is clean as without it.
#[test]
fn one_wrong_length_is_left_out_and_names_nothing() {
    let kind = Kind::three_axis();
    let wrong: Vec<String> = in_parallel(
        [
            (330, 700, 0.0),
            (330, 700, 0.008),
            (331, 1500, -0.05),
            (332, 40, 0.3),
            (333, 2300, 5.0),
        ],
        |(seed, number, by_mm)| {
            let mut campaign = blind::campaign(&kind, &[], seed);
            let reading = &mut campaign.lengths.as_mut().unwrap().readings[number];
            reading.length_mm += by_mm;
            let line = reading.line.to_string();
            let diagnosis = diagnosed_campaign(&campaign);
            let is_told = diagnosis
                .notices
                .iter()
                .any(|text| text.ends_with(&format!("1 length, line {line}")));
            let right = diagnosis.verdict == Verdict::Clean && is_told == (by_mm != 0.0);
            let verdict = diagnosis.verdict.name();
            (!right).then(|| {
                format!(
                    "{by_mm} mm: {verdict} {:?} {:?}",
                    diagnosis.notices, diagnosis.unexplained
                )
            })
        },
    )
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
