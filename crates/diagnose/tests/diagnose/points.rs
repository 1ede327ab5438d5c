//! Points campaigns: every effect of the level, clean ones, gross errors, and what cannot be judged.

use nalgebra::{Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Campaign, Stop};
use trueaxis_diagnose::{
    Cause, Diagnosis, Rejected, Rival, Settings, Verdict, Wandering, diagnose, without_wrong_points,
};
use trueaxis_effects::{Layer, Level, ResolvedEffect};

use crate::made_points::{Hidden, PERIOD_MM, Plan, made};
use crate::{counts, generator, report};

/// Of a three-axis machine, and which of them a rotary stage can show.
const EFFECTS: [(&str, bool); 12] = [
    ("station_drift", true),
    ("station_settling", true),
    ("station_jump", true),
    ("target_slip", true),
    ("target_creep", true),
    ("fixture_expansion", true),
    ("machine_drift", true),
    ("warm_up", true),
    ("machine_shift", true),
    ("axis_expansion", false),
    ("backlash", true),
    ("stage_bending", true),
];

#[derive(Debug, Default, Clone)]
struct Count {
    named: usize,
    among: usize,
    unknown: usize,
    missed: usize,
    wrong: usize,
    /// Parameters inside their 95 % interval, and of how many.
    inside: [usize; 2],
    odd: Vec<String>,
}

impl Count {
    fn add(&mut self, found: &Diagnosis, hidden: &Hidden, plan: &Plan) {
        let is_it = |e: &ResolvedEffect| {
            let is_mean = hidden.id == "loosening_drive" && e.effect.id == "backlash";
            (e.effect.id == hidden.id || is_mean)
                && e.subject
                    .target
                    .is_none_or(|target| target == hidden.target)
                && e.subject.axis.is_none_or(|axis| axis == hidden.axis)
        };
        for cause in found.causes.iter().filter(|c| is_it(&c.effect)) {
            for (parameter, truth) in cause.parameters.iter().zip(hidden.truth(plan)) {
                let is_inside = (parameter.value - truth).abs() < 1.96 * parameter.u;
                self.inside[0] += usize::from(is_inside && parameter.u.is_finite());
                self.inside[1] += usize::from(parameter.u.is_finite());
            }
        }
        let may_wander = |c: &Cause| what_may_wander(c).any(|whose| is_of(hidden, whose));
        let explains =
            |c: &Cause| is_it(&c.effect) || c.rival_effects().any(&is_it) || may_wander(c);
        let of_points = || found.causes.iter().filter(|c| c.share_of_curve.is_none());
        let is_wrong = of_points().any(|c| c.rivals.is_empty() && !is_it(&c.effect));
        match found.verdict {
            _ if is_wrong => self.wrong += 1,
            _ if of_points().any(|c| is_it(&c.effect) && c.rivals.is_empty()) => {
                self.named += 1;
                return;
            }
            _ if of_points().any(explains) => {
                self.among += 1;
                return;
            }
            Verdict::Unknown => self.unknown += 1,
            Verdict::Clean => self.missed += 1,
            _ => self.wrong += 1,
        }
        self.odd.push(counts::summary(found));
    }

    fn right(&self) -> usize {
        self.named + self.among
    }
}

fn without_curves() -> Settings {
    Settings {
        explain_curves: false,
        ..Settings::default()
    }
}

fn count(plan: &Plan, id: &'static str, size: f64, seeds: std::ops::Range<u64>) -> Count {
    let mut count = Count::default();
    for seed in seeds {
        let hidden = Hidden::draw(id, size, plan, &mut generator(seed, 3));
        let campaign = made(plan, std::slice::from_ref(&hidden), seed);
        let found = diagnose(&campaign, &without_curves()).unwrap();
        count.add(&found, &hidden, plan);
    }
    count
}

#[test]
fn each_effect_is_named_in_points_of_a_three_axis_machine() {
    for (id, _) in EFFECTS {
        let count = count(&Plan::THREE_AXES, id, 1.0, 1..2);
        assert_eq!((count.right(), count.wrong), (1, 0), "{id}: {count:?}");
    }
}

#[test]
#[ignore = "study: 460 campaigns of points, two machines"]
fn effects_are_named_in_nineteen_of_twenty_points_campaigns() {
    let from = std::env::var("SEED").map_or(1000, |s| s.parse().unwrap());
    let size = std::env::var("SIZE").map_or(1.0, |s| s.parse().unwrap());
    let mut inside = [0; 2];
    for (name, plan) in [
        ("three axes", Plan::THREE_AXES),
        ("rotary stage", Plan::ROTARY),
    ] {
        for (id, of_rotary) in EFFECTS {
            if plan.is_rotary && !of_rotary {
                continue;
            }
            let count = count(&plan, id, size, from..from + 20);
            report(&format!("{name}, {id} × {size}: {count:?}"));
            inside = [inside[0] + count.inside[0], inside[1] + count.inside[1]];
            assert!(
                size < 1.0 || (count.right() >= 19 && count.wrong == 0),
                "{name}, {id}: {count:?}"
            );
        }
    }
    // Of some 600 values, of which three at a time share their noise: three standard errors.
    report(&format!("{} of {} values inside", inside[0], inside[1]));
    let share = inside[0] as f64 / inside[1] as f64;
    assert!(size < 1.0 || (0.91..0.985).contains(&share), "{share}");
}

fn alarms(plan: &Plan, seeds: std::ops::Range<u64>) -> Vec<String> {
    let found = seeds.map(|seed| diagnose(&made(plan, &[], seed), &without_curves()).unwrap());
    found
        .filter(|found| found.verdict != Verdict::Clean || !found.rejected.is_empty())
        .map(|found| counts::summary(&found))
        .collect()
}

/// At a level of 0.7 % one in ten alarms in 7 % of all choices of seeds.
#[test]
fn clean_points_are_clean() {
    let found = alarms(&Plan::THREE_AXES, 1..6);
    assert!(found.is_empty(), "{found:?}");
    let found = alarms(&Plan::ROTARY, 1..6);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
#[ignore = "study: 300 clean campaigns of points"]
fn clean_points_campaigns_have_few_alarms() {
    let from = std::env::var("SEED").map_or(1000, |s| s.parse().unwrap());
    let one = Plan {
        repeats: 1,
        both_sides: false,
        ..Plan::THREE_AXES
    };
    for plan in [Plan::THREE_AXES, Plan::ROTARY, one] {
        let found = alarms(&plan, from..from + 100);
        report(&format!(
            "{plan:?}: {} alarms of 100: {found:?}",
            found.len()
        ));
        // With 0.7 % the odds of four are 1 in 170.
        assert!(found.len() <= 3, "{found:?}");
    }
}

/// One target with four times the noise of the others: it weighs less, a notice names it, and nothing is wrong; of 42 such campaigns 16 had
/// alarmed, three with the slip of a target alone. A slip of another target is found beside it.
#[test]
fn a_target_that_scatters_weighs_less() {
    for (seed, id) in [(41, None), (42, None), (43, Some("backlash"))] {
        let plan = Plan::THREE_AXES;
        let hidden = id.map(|id| Hidden::draw(id, 1.0, &plan, &mut generator(seed, 3)));
        let mut campaign = made(&plan, hidden.as_slice(), seed);
        let mut rng = generator(seed, 4);
        for reading in &mut campaign.points.as_mut().unwrap().readings {
            if reading.target == 1 {
                let more: Vector3<f64> = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
                reading.position_mm += 15.0_f64.sqrt() * plan.noise_mm * more;
            }
        }
        let found = diagnose(&campaign, &without_curves()).unwrap();
        let summary = counts::summary(&found);
        let verdict = id.map_or(Verdict::Clean, |_| Verdict::Named);
        assert_eq!(found.verdict, verdict, "{summary}");
        assert_eq!(found.rejected, [], "{summary}");
        let name = &campaign.targets[1].name;
        let said = format!("target {name}: its points scatter more");
        let is_said = |notice: &String| notice.starts_with(&said);
        assert!(found.notices.iter().any(is_said), "{:?}", found.notices);
    }
}

/// A point that is off by 0.3 mm, in a clean campaign and beside a slip: found with its line, nothing else.
#[test]
fn a_gross_error_is_found_with_its_line() {
    for (seed, id, wrong) in [
        (11, None, 310),
        (12, None, 0),
        (13, Some("target_slip"), 505),
        (14, Some("backlash"), 755),
    ] {
        let plan = Plan::THREE_AXES;
        let hidden = id.map(|id| Hidden::draw(id, 1.0, &plan, &mut generator(seed, 3)));
        let mut campaign = made(&plan, hidden.as_slice(), seed);
        let points = campaign.points.as_mut().unwrap();
        points.readings[wrong].position_mm.y += 0.3;
        let found = diagnose(&campaign, &without_curves()).unwrap();
        let rows: Vec<usize> = found.rejected.iter().map(|r| r.row).collect();
        assert_eq!(rows, [wrong + 2], "{}", counts::summary(&found));
        let rejected = &found.rejected[0];
        assert!(
            (rejected.error_um - 300.0).abs() < 4.0 * rejected.u_um,
            "{rejected:?}"
        );
        let verdict = match id {
            None => Verdict::Clean,
            Some(_) => Verdict::Named,
        };
        assert_eq!(found.verdict, verdict, "{}", counts::summary(&found));
    }
}

/// A stop whose three points are off by 20 or 200 µm, as where the machine had not arrived: its three lines, and nothing else. Taken for
/// repeatability it was clean at any size, and calibrated. The others of its step are three stops.
#[test]
fn a_stop_that_is_off_leaves_with_its_lines() {
    for (plan, seed, stop, off_mm) in [
        (Plan::THREE_AXES, 15, 100, 0.2),
        (Plan::THREE_AXES, 16, 31, 0.2),
        (Plan::THREE_AXES, 17, 200, 0.02),
        (TRACKER, 18, 60, 0.05),
    ] {
        let mut campaign = made(&plan, &[], seed);
        let points = campaign.points.as_mut().unwrap();
        let rows = points.stops[stop].readings.clone();
        for reading in &mut points.readings[rows.clone()] {
            reading.position_mm += Vector3::new(0.8, -0.6, 0.0) * off_mm;
        }
        let expected: Vec<usize> = rows.map(|row| row + 2).collect();
        let found = diagnose(&campaign, &without_curves()).unwrap();
        let told = |rejected: &[Rejected]| rejected.iter().map(|r| r.row).collect::<Vec<_>>();
        let summary = counts::summary(&found);
        assert_eq!(told(&found.rejected), expected, "{summary}");
        assert_eq!(found.verdict, Verdict::Clean, "{summary}");
        let off_um = found.rejected[0].error_um - 1e3 * off_mm;
        assert!(off_um.abs() < 4.0 * found.rejected[0].u_um, "{off_um}");
        // `calibrate` goes without the same.
        let screened = without_wrong_points(&campaign, false).unwrap();
        assert_eq!(told(&screened.left_out), expected);
        let kept = screened.campaign.points.unwrap();
        assert_eq!(kept.readings.len(), 756 - 3);
    }
}

/// Three stops in a row that were read while the axis was still on its way are left out, beside a cause, too: they had silenced it, since
/// what wandered explained both.
#[test]
fn stops_that_were_read_too_early_silence_no_cause() {
    for (seed, id, first) in [(21, "backlash", 68), (22, "target_slip", 150)] {
        let plan = Plan::THREE_AXES;
        let hidden = Hidden::draw(id, 2.0, &plan, &mut generator(seed, 3));
        let mut campaign = made(&plan, &[hidden], seed);
        let points = campaign.points.as_mut().unwrap();
        let rows = points.stops[first].readings.start..points.stops[first + 2].readings.end;
        for (stop, off_mm) in [0.06, 0.05, 0.04].into_iter().enumerate() {
            for reading in &mut points.readings[points.stops[first + stop].readings.clone()] {
                reading.position_mm += Vector3::new(0.8, -0.6, 0.0) * off_mm;
            }
        }
        let found = diagnose(&campaign, &without_curves()).unwrap();
        let summary = counts::summary(&found);
        let told: Vec<usize> = found.rejected.iter().map(|r| r.row - 2).collect();
        assert_eq!(told, rows.collect::<Vec<_>>(), "{summary}");
        assert_eq!(found.verdict, Verdict::Named, "{summary}");
        assert!(
            found
                .causes
                .iter()
                .all(|cause| cause.effect.effect.id == id),
            "{summary}"
        );
    }
}

/// Both visits of one side see a target elsewhere by 0.1 mm. The other side has seen it, so that both leave, as in the diagnosis, unless
/// each side has a pose of its own: then they stay, with a notice.
#[test]
fn two_wrong_visits_of_one_side_leave() {
    for (seed, step) in [(23, 43), (24, 44), (25, 45)] {
        let mut campaign = made(&Plan::THREE_AXES, &[], seed);
        let points = campaign.points.as_mut().unwrap();
        let target = 1;
        let own = points.stops.iter();
        let own = own.filter(|stop| stop.step == step && stop.direction.sign() > 0);
        let own = own.flat_map(|stop| stop.readings.clone());
        let own: Vec<usize> = own
            .filter(|&row| points.readings[row].target == target)
            .collect();
        assert_eq!(own.len(), 2);
        for (&row, off) in own.iter().zip([Vector3::x(), Vector3::z()]) {
            points.readings[row].position_mm += 0.1 * off;
        }
        let expected: Vec<usize> = own.iter().map(|row| row + 2).collect();
        let told = |rejected: &[Rejected]| rejected.iter().map(|r| r.row).collect::<Vec<_>>();
        let both = without_wrong_points(&campaign, false).unwrap();
        assert_eq!(told(&both.left_out), expected);
        assert!(both.kept.is_empty());
        let each = without_wrong_points(&campaign, true).unwrap();
        assert!(each.left_out.is_empty());
        let kept = each.kept.iter().map(|kept| kept.wrong.row);
        assert_eq!(kept.collect::<Vec<_>>(), expected);
        let left = each.campaign.points.unwrap();
        assert_eq!(left.readings.len(), 756);
    }
}

/// A point that is measured once stays, with a notice: without it the step would have two targets.
#[test]
fn a_pose_keeps_its_three_targets() {
    let plan = Plan {
        repeats: 1,
        both_sides: false,
        ..Plan::THREE_AXES
    };
    let mut campaign = made(&plan, &[], 18);
    let points = campaign.points.as_mut().unwrap();
    points.readings[70].position_mm.y += 0.3;
    let screened = without_wrong_points(&campaign, false).unwrap();
    assert!(screened.left_out.is_empty());
    assert_eq!(screened.campaign.points, campaign.points);
    let [kept] = &screened.kept[..] else {
        panic!("{} points", screened.kept.len());
    };
    assert_eq!(kept.wrong.row, 72);
    let notice = kept.in_words();
    assert!(
        notice.contains("do not trust the results there"),
        "{notice}"
    );
    assert!(notice.contains("run "), "{notice}");
}

/// The instrument stands elsewhere, turned by 20″, while the runs of Y are measured, in each repeat: nothing within a run shows it, and the
/// squareness is off by it. Where all axes stand at home the stage is turned.
#[test]
fn a_frame_that_moves_between_runs_is_told() {
    const ARCSEC: f64 = 4.848_136_811e-6;
    for seed in [31, 32] {
        let turned = Rotation3::new(Vector3::new(0.0, 0.6, 0.8) * (20.0 * ARCSEC));
        let mut campaign = made(&Plan::THREE_AXES, &[], seed);
        let of_y = |stop: &Stop| campaign.steps[stop.step].run == Some(1);
        let points = campaign.points.as_ref().unwrap();
        let rows = points.stops.iter().filter(|stop| of_y(stop));
        let rows: Vec<usize> = rows.flat_map(|stop| stop.readings.clone()).collect();
        for row in rows {
            let reading = &mut campaign.points.as_mut().unwrap().readings[row];
            reading.position_mm = turned * reading.position_mm + Vector3::new(0.01, 0.0, -0.01);
        }
        let found = diagnose(&campaign, &without_curves()).unwrap();
        assert_eq!(
            found.verdict,
            Verdict::Unknown,
            "{}",
            counts::summary(&found)
        );
        let left = found.unexplained.as_ref().unwrap();
        assert_eq!(left.varies_with, ["run"], "{}", left.note);
        let calibration = found.calibration.as_ref().unwrap();
        let pairs: Vec<_> = calibration
            .turned_runs
            .iter()
            .map(|own| own.runs.clone())
            .collect();
        assert_eq!(pairs, [["x", "y"], ["y", "z"]]);
        for own in &calibration.turned_runs {
            let off = own.turned_rad.norm() - 20.0 * ARCSEC;
            assert!(off.abs() < 4.0 * own.u_rad.norm(), "{own:?}");
        }
    }
}

/// A clean campaign of which one in so many points is off by 0.3 mm, in the sense of y or against it; and which.
fn partly_wrong(seed: u64, one_in: usize) -> (Campaign, Vec<usize>) {
    let mut campaign = made(&Plan::THREE_AXES, &[], seed);
    let points = campaign.points.as_mut().unwrap();
    let mut lines = Vec::new();
    for (k, reading) in points.readings.iter_mut().enumerate() {
        if (7 * k + 3) % one_in == 0 {
            reading.position_mm.y += if k % 3 == 0 { 0.3 } else { -0.3 };
            lines.push(reading.line);
        }
    }
    (campaign, lines)
}

/// Fifteen points of 756 (2 %): they and no others are left out. With up to 1 % only, all stayed, and one in ten such campaigns had a target
/// that slipped.
#[test]
fn two_per_cent_of_gross_errors_are_left_out() {
    let (campaign, lines) = partly_wrong(21, 50);
    let found = diagnose(&campaign, &without_curves()).unwrap();
    assert_eq!(found.verdict, Verdict::Clean, "{}", counts::summary(&found));
    let left_out: Vec<usize> = found.rejected.iter().map(|own| own.row).collect();
    assert_eq!(left_out, lines);
}

/// Thirty-one points of 756 (4 %), and 76 (10 %): too many to leave out, so that all stay, and the campaign is not clean.
#[test]
fn too_many_gross_errors_are_not_clean() {
    for (seed, one_in) in [(21, 25), (22, 10)] {
        let (campaign, _) = partly_wrong(seed, one_in);
        let found = diagnose(&campaign, &without_curves()).unwrap();
        assert!(found.rejected.is_empty(), "{}", counts::summary(&found));
        assert_eq!(
            found.verdict,
            Verdict::Unknown,
            "{}",
            counts::summary(&found)
        );
        let left = found.unexplained.unwrap();
        assert_eq!(left.varies_with, ["reading"], "{}", left.note);
        // Each of them in a stop of its own, of three points.
        let words: Vec<&str> = left.note.split(' ').collect();
        let ["in", stops, "of", "252", "stops", ..] = words[..] else {
            panic!("{}", left.note);
        };
        let (stops, wrong): (usize, usize) = (stops.parse().unwrap(), 756 / one_in);
        assert!(
            (wrong - wrong / 20..=wrong + 1).contains(&stops),
            "{}",
            left.note
        );
    }
}

/// One target is no body: without repeats and second side nothing is redundant; with both, lost motion shows.
#[test]
fn one_target_is_judged_by_repeats_and_sides_only() {
    let once = Plan {
        targets: 1,
        repeats: 1,
        both_sides: false,
        ..Plan::THREE_AXES
    };
    let found = diagnose(&made(&once, &[], 1), &without_curves()).unwrap();
    assert_eq!(found.verdict, Verdict::NotJudged);
    let text = found.notices.join("; ");
    assert!(
        text.contains("measure every step twice or from both sides"),
        "{text}"
    );
    let plan = Plan {
        targets: 1,
        ..Plan::THREE_AXES
    };
    // At a constant feed readings that are late look the same.
    let count = count(&plan, "backlash", 2.0, 2..4);
    assert_eq!((count.among, count.wrong), (2, 0), "{count:?}");
}

/// A stage that stands some minutes of arc askew, another way at each step, as of a robot: what slips out of the plane of its targets stays
/// unseen. With the directions commanded slips of 10 to 100 mm came out.
#[test]
fn what_slips_out_of_the_plane_is_not_seen_by_a_stage_that_stands_askew() {
    let once = Plan {
        repeats: 1,
        both_sides: false,
        ..Plan::THREE_AXES
    };
    for seed in 1..=4 {
        let mut rng = generator(seed, 5);
        let hidden = Hidden::draw("target_slip", 10.0, &once, &mut rng);
        let mut campaign = made(&once, &[hidden], seed);
        let points = campaign.points.as_mut().unwrap();
        for (number, stop) in points.stops.iter().enumerate() {
            let own = &mut points.readings[stop.readings.clone()];
            let at = own[0].position_mm;
            let askew = Rotation3::new(Vector3::new(2e-3, -1e-3, 1e-3) * (number as f64).sin());
            for reading in own {
                reading.position_mm = at + askew * (reading.position_mm - at);
            }
        }
        let found = diagnose(&campaign, &without_curves()).unwrap();
        let slips = found
            .causes
            .iter()
            .filter(|c| c.effect.effect.id == "target_slip");
        let values: Vec<f64> = slips
            .flat_map(|slip| &slip.parameters[..3])
            .map(|p| p.value.abs())
            .collect();
        assert_eq!(values.len(), 3, "{seed}: {:?}", found.verdict);
        assert!(values.iter().all(|um| *um < 40.0), "{seed}: {values:?}");
    }
}

/// A target that is elsewhere at the other of two positions has no law that they test: its bending is not named, and it is said why.
#[test]
fn two_positions_name_no_bending() {
    let mut plan = Plan::ROTARY;
    plan.repeats = 6;
    let mut campaign = made(&plan, &[], 3);
    let steps = campaign.steps.clone();
    let is_kept = |step: usize| [0.0, steps[8].positions[0]].contains(&steps[step].positions[0]);
    let points = campaign.points.as_mut().unwrap();
    let mut readings = Vec::new();
    points.stops.retain(|stop| is_kept(stop.step));
    for stop in &mut points.stops {
        let first = readings.len();
        readings.extend_from_slice(&points.readings[stop.readings.clone()]);
        stop.readings = first..readings.len();
        if steps[stop.step].positions[0] > 0.0 {
            readings[first].position_mm.x += 0.05;
        }
    }
    points.readings = readings;
    let kept: Vec<usize> = (0..steps.len()).filter(|&step| is_kept(step)).collect();
    for stop in &mut points.stops {
        stop.step = kept.iter().position(|&step| step == stop.step).unwrap();
    }
    campaign.steps = kept.iter().map(|&step| steps[step].clone()).collect();
    let found = diagnose(&campaign, &without_curves()).unwrap();
    assert_ne!(found.verdict, Verdict::Clean);
    let is_bending = |id: &str| id == "stage_bending";
    assert!(
        found.causes.iter().all(|c| !is_bending(c.effect.effect.id)),
        "{}",
        counts::summary(&found)
    );
    let unseen = found.not_observable.iter().find(|u| is_bending(u.effect));
    assert!(
        unseen.is_some_and(|u| u.reason.contains("two positions")),
        "{unseen:?}"
    );
}

/// What stands on the bed tells an instrument that moves from a machine that does.
#[test]
fn targets_on_the_bed_tell_confounded_effects_apart() {
    let plan = Plan {
        bed: true,
        ..Plan::THREE_AXES
    };
    let pairs = [
        ("machine_shift", "station_jump"),
        ("machine_drift", "station_drift"),
    ];
    for (id, confounded) in pairs.into_iter().flat_map(|(a, b)| [(a, b), (b, a)]) {
        let seed = 5;
        let hidden = Hidden::draw(id, 2.0, &plan, &mut generator(seed, 3));
        let found = diagnose(&made(&plan, &[hidden], seed), &without_curves()).unwrap();
        let [cause] = &found.causes[..] else {
            panic!("{id}: {}", counts::summary(&found));
        };
        let is_confounded = |e: &ResolvedEffect| e.effect.id == confounded;
        let mut all = cause.rival_effects().chain([&cause.effect]);
        assert!(!all.any(is_confounded), "{id}: {cause:?}");
        assert_eq!(cause.effect.effect.id, id, "{}", counts::summary(&found));
    }
}

/// The figure of a cause has each coordinate in the reference frame, the misfit follows the effect in each, and what is
/// left is noise as stated.
#[test]
fn a_cause_is_drawn_in_each_coordinate() {
    let plan = Plan {
        bed: true,
        ..Plan::THREE_AXES
    };
    let hidden = Hidden::draw("machine_shift", 4.0, &plan, &mut generator(5, 3));
    let truth = hidden.vector;
    let found = diagnose(&made(&plan, &[hidden], 5), &without_curves()).unwrap();
    let fitted = found.causes[0].fitted.as_ref().unwrap();
    let mut jump = Vector3::zeros();
    for of in fitted.beside.iter().chain([fitted]) {
        let values = |is_late: bool| {
            let points = of.points.iter().enumerate();
            points.filter(move |(k, _)| (*k > of.points.len() / 2) == is_late)
        };
        let mean = |is_late| {
            let (sum, count) = values(is_late).fold((0.0, 0.0), |(sum, count), (_, p)| {
                (sum + p.fitted, count + 1.0)
            });
            sum / count
        };
        let coordinate = ["x", "y", "z"].iter().position(|c| of.of.starts_with(c));
        jump[coordinate.unwrap()] = mean(true) - mean(false);
        let left = of
            .points
            .iter()
            .map(|p| ((p.misfit - p.fitted) / p.u).powi(2));
        let rms = (left.sum::<f64>() / of.points.len() as f64).sqrt();
        // Poses and shapes take a part of the noise.
        assert!((0.5..1.1).contains(&rms), "{}: {rms}", of.of);
    }
    assert!(jump.normalize().dot(&truth) > 0.99, "{jump:?} {truth:?}");
}

/// Two troubles of different things come out together.
#[test]
fn a_slip_and_lost_motion_are_both_named() {
    let plan = Plan::THREE_AXES;
    let mut rng = generator(21, 3);
    let hidden = ["target_slip", "backlash"].map(|id| Hidden::draw(id, 1.5, &plan, &mut rng));
    let found = diagnose(&made(&plan, &hidden, 21), &without_curves()).unwrap();
    let mut ids: Vec<&str> = found.causes.iter().map(|c| c.effect.effect.id).collect();
    ids.sort_unstable();
    assert_eq!(
        ids,
        ["backlash", "target_slip"],
        "{}",
        counts::summary(&found)
    );
    let shares = &found.levels[0].shares;
    let sum = shares.causes.iter().sum::<f64>() + shares.unexplained + shares.noise;
    assert!((sum - 1.0).abs() < 1e-9, "{shares:?}");
    assert!(found.levels[0].gain.is_some_and(|gain| gain.is_claimed()));
}

/// A spindle that warms up within minutes and a bed that does so, the other way, within hours: both have their name, which the frame may
/// bear, too, and their values within four standard uncertainties (of 16 one is beyond with a probability of 0.1 %).
#[test]
fn a_machine_warms_up_with_two_time_constants() {
    let plan = Plan::THREE_AXES;
    for seed in [901, 902] {
        let fast = Hidden::draw("warm_up", 2.0, &plan, &mut generator(seed, 3));
        let of_time = |at: f64, vector| Hidden {
            at,
            vector,
            ..fast.clone()
        };
        let hidden = [of_time(-0.2, fast.vector), of_time(1.0, -fast.vector)];
        let campaign = made(&plan, &hidden, seed);
        let mut causes = diagnose(&campaign, &without_curves()).unwrap().causes;
        assert!(causes.iter().all(|c| c.effect.effect.id == "warm_up"));
        causes.sort_by(|a, b| a.effect.shape.total_cmp(&b.effect.shape));
        assert_eq!(causes.len(), 2, "{seed}");
        let stops = campaign.points.as_ref().unwrap().stops.len();
        for (cause, hidden) in causes.iter().zip(&hidden) {
            let time_constant_s = (0.1 + 0.3 * hidden.at) * 20.0 * stops as f64;
            let growth_um = 6.0 * hidden.size * hidden.vector;
            let truth = growth_um.iter().chain([&time_constant_s]);
            for (parameter, truth) in cause.parameters.iter().zip(truth) {
                let error = (parameter.value - truth).abs();
                assert!(error < 4.0 * parameter.u, "{seed}: {truth}, {parameter:?}");
            }
        }
    }
}

/// Poses take a cyclic error whole: it contradicts nothing, and stands in the error curve.
#[test]
fn a_cyclic_error_in_points_is_found_in_the_curve() {
    let plan = Plan::THREE_AXES;
    let hidden = Hidden::draw("cyclic_error", 1.0, &plan, &mut generator(22, 3));
    let axis = hidden.axis;
    let found = diagnose(&made(&plan, &[hidden], 22), &Settings::default()).unwrap();
    assert_eq!(found.verdict, Verdict::Clean, "{}", counts::summary(&found));
    let is_it = |c: &&Cause| {
        c.level == Level::Components
            && c.effect.effect.id == "cyclic_error"
            && c.effect.subject.axis == Some(axis)
            && (c.effect.shape / PERIOD_MM - 1.0).abs() < 0.03
    };
    assert!(
        found.causes.iter().any(|c| is_it(&c)),
        "{}",
        counts::summary(&found)
    );
}

/// Points of a tracker, at some 1.9 m: 0.6 µm along the beam, 3 µm/m across. Directions that were the same for all points
/// made an alarm in 7 of 180 such campaigns, one of which was a target slip alone.
const TRACKER: Plan = Plan {
    noise_mm: 0.6e-3,
    angles: Some(3e-6),
    return_mm: 0.5e-3,
    ..Plan::THREE_AXES
};

/// At a level of 0.7 % one in eight alarms in 5 % of all choices of seeds.
#[test]
fn clean_points_of_a_tracker_are_clean() {
    let found = alarms(&TRACKER, 1..9);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
#[ignore = "study: 200 clean campaigns of points of a tracker"]
fn points_of_a_tracker_make_few_alarms() {
    let from = std::env::var("SEED").map_or(1000, |s| s.parse().unwrap());
    let found = alarms(&TRACKER, from..from + 200);
    report(&format!(
        "tracker: {} alarms of 200: {found:?}",
        found.len()
    ));
    // At 0.7 % the odds of six are 1 in 300.
    assert!(found.len() <= 5, "{found:?}");
}

/// An instrument that is three times worse across its beam, and ten times better along it.
#[test]
#[ignore = "study: 200 clean campaigns of points with noise that differs between directions"]
fn unlike_directions_make_few_alarms() {
    let from = std::env::var("SEED").map_or(1000, |s| s.parse().unwrap());
    for return_mm in [1e-3, 0.0] {
        let unlike = Plan {
            unlike: [3.0, 1.0, 0.3],
            return_mm,
            ..Plan::THREE_AXES
        };
        let found = alarms(&unlike, from..from + 100);
        report(&format!(
            "{unlike:?}: {} alarms of 100: {found:?}",
            found.len()
        ));
        // At 3 %, since six variances are estimated, the odds of nine are 1 in 300.
        assert!(found.len() <= 8, "{found:?}");
    }
}

/// What may wander instead of a cause.
fn what_may_wander(cause: &Cause) -> impl Iterator<Item = &Wandering> {
    cause.rivals.iter().filter_map(|rival| match rival {
        Rival::Disturbance { whose, .. } => Some(whose),
        Rival::Effect { .. } => None,
    })
}

/// Whether that is what wanders in one that no catalogue has.
fn is_of(hidden: &Hidden, whose: &Wandering) -> bool {
    let is_it = match hidden.id {
        "breathing" => whose.layer == Layer::Setup && whose.subject.target.is_none(),
        "warming_axis" | "loosening_drive" => whose.subject.axis == Some(hidden.axis),
        _ => whose.subject.target == Some(hidden.target),
    };
    let with: &[&str] = match hidden.id {
        "breathing" | "swaying_target" => &["time"],
        "wavy_stage" => &["position"],
        "warming_axis" => &["time", "position"],
        "loosening_drive" => &["time", "direction"],
        _ => return false,
    };
    is_it && whose.varies_with == with
}

/// A hall that breathes (and the frame of the instrument with it), a holder that sways, a stage that is wavy, an axis that warms
/// up, a drive that works loose: of no catalogue, and what wanders is said. Of a target nothing is seen that goes across the plane of the three, and along the line
/// to another target it may as well be that one: fewer are found, and fewer with the right target.
#[test]
#[ignore = "study: 120 campaigns of points with what no effect is"]
fn what_is_in_no_catalogue_is_not_named() {
    let from = std::env::var("SEED").map_or(1000, |s| s.parse().unwrap());
    let ids = [
        "breathing",
        "swaying_target",
        "wavy_stage",
        "warming_axis",
        "loosening_drive",
    ];
    for id in ids {
        for plan in [Plan::THREE_AXES, Plan::ROTARY] {
            let mut count = Count::default();
            let (mut whose, mut gained) = (0, 0);
            for seed in from..from + 20 {
                let hidden = Hidden::draw(id, 1.0, &plan, &mut generator(seed, 3));
                let campaign = made(&plan, std::slice::from_ref(&hidden), seed);
                let found = diagnose(&campaign, &without_curves()).unwrap();
                count.add(&found, &hidden, &plan);
                let first = found.disturbances.first().into_iter();
                let first = first.flat_map(|d| d.rivals.iter().chain([&d.whose]));
                let rivals = found.causes.iter().flat_map(what_may_wander);
                let is_right = first.chain(rivals).any(|whose| is_of(&hidden, whose));
                whose += usize::from(is_right);
                let gain = found.levels[0].gain;
                gained += usize::from(gain.is_some_and(|gain| gain.is_claimed()));
            }
            let line = format!(
                "{id}, rotary {}: {whose} of 20 with its subject, {gained} with a gain: {count:?}",
                plan.is_rotary
            );
            report(&line);
            // The mean of what is lost is a lost motion. Of an axis that is measured for a tenth of the time, and again soon, little is seen:
            // of the 20 campaigns from 900 on an observer who knows noise, form and size tells 15 from all else.
            let least = match id {
                "wavy_stage" => 13,
                "warming_axis" if !plan.is_rotary => 13,
                // Lost motion is there, and named; whether it is seen to grow is counted, not claimed.
                "loosening_drive" => 0,
                _ => 17,
            };
            let told = count.unknown + count.right();
            assert!(
                count.wrong <= 1 && (told >= 17 || id == "warming_axis"),
                "{line}"
            );
            assert!(whose >= least, "{line}");
        }
    }
}
