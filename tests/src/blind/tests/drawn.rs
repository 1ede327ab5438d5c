//! Disturbances that are drawn.

use super::kinds;
use crate::blind::layout::Layout;
use crate::blind::schedule::Schedule;
use crate::blind::{CATALOGUED, Course, Kind, UNCATALOGUED, draw, misshapen, names, scaled};

#[test]
fn every_effect_can_be_drawn_where_it_leaves_a_trace() {
    let (standing, turning) = (Kind::three_axis(), Kind::rotary_stage());
    let none = |kind: &Kind| -> Vec<&str> {
        names()
            .filter(|name| draw(kind, name, 1).is_none())
            .collect()
    };
    let without_sides = ["timestamp_offset", "backlash", "loosening_drive"];
    assert_eq!(none(&standing), without_sides);
    assert_eq!(
        none(&turning),
        [
            "timestamp_offset",
            "axis_expansion",
            "backlash",
            "warping_axis",
            "loosening_drive"
        ]
    );
    assert_eq!(none(&standing.forward_and_backward()), ["timestamp_offset"]);
    assert_eq!(none(&standing.on_the_fly()), [""; 0]);
    assert_eq!(draw(&standing, "no_such_effect", 1), None);
}

#[test]
fn an_instant_lies_well_inside_a_turn() {
    for kind in kinds() {
        let schedule = Schedule::new(&kind, &Layout::new(&kind));
        for name in names() {
            for seed in 0..20 {
                let Some(hidden) = draw(&kind, name, seed) else {
                    continue;
                };
                assert_eq!(draw(&kind, name, seed), Some(hidden.clone()), "same seed");
                let Some(instant_s) = hidden.instant_s() else {
                    continue;
                };
                let inside = |[from, to]: &[f64; 2]| {
                    let part = (instant_s - from) / (to - from);
                    (0.1..=0.9).contains(&part)
                };
                let occupation = schedule.occupations_s.iter().position(inside);
                assert!(occupation.is_some(), "{name} at {instant_s} s");
                if hidden.station.is_some() {
                    assert_eq!(hidden.station, occupation, "{name} in its own occupation");
                }
            }
        }
    }
}

/// Each name gives as many disturbances as seeds, and no subject is favoured: of a binomial count with
/// probability 1/2 at most, 30 of 40 are exceeded with a probability of 1e-3 at most; seeds are fixed.
#[test]
fn subjects_and_sizes_differ_from_seed_to_seed() {
    let kind = Kind::five_axis().forward_and_backward();
    for name in names() {
        let all: Vec<_> = (0..40).filter_map(|seed| draw(&kind, name, seed)).collect();
        for subject in 0..6 {
            let subject = Some(subject);
            let of_stations = all.iter().filter(|h| h.station == subject).count();
            let of_targets = all.iter().filter(|h| h.target == subject).count();
            let of_axes = all.iter().filter(|h| h.axis == subject).count();
            assert!(of_stations.max(of_targets).max(of_axes) <= 30, "{name}");
        }
        let distinct = |i: usize| all[i + 1..].iter().all(|other| *other != all[i]);
        assert!((0..all.len()).all(distinct), "{name}");
    }
}

#[test]
fn parameters_are_those_of_the_catalogue() {
    let kind = Kind::rotary_stage().forward_and_backward();
    let backlash = draw(&kind, "backlash", 1).unwrap();
    let twice = scaled(&backlash, 2.0).parameters(&kind);
    let once = backlash.parameters(&kind);
    assert_eq!(
        (once[0].name.as_str(), once[0].unit),
        ("lost_motion", "arcsec")
    );
    assert!((twice[0].value - 2.0 * once[0].value).abs() < 1e-12);
    let kind = Kind::three_axis().on_the_fly();
    for &name in CATALOGUED {
        let hidden = draw(&kind, name, 2).unwrap();
        assert_eq!(hidden.name, name);
        assert!(!hidden.parameters(&kind).is_empty(), "{name}");
    }
    for name in UNCATALOGUED {
        assert!(draw(&kind, name, 2).unwrap().parameters(&kind).is_empty());
    }
}

#[test]
fn a_misshapen_disturbance_keeps_its_name_subject_and_instant() {
    let kind = Kind::three_axis();
    for seed in 0..20 {
        let ideal = draw(&kind, "machine_shift", seed).unwrap();
        let other = misshapen(&ideal, seed);
        assert_eq!(other.name, ideal.name);
        assert_eq!(other.instant_s(), ideal.instant_s());
        let Course::Jump { spread_s, .. } = other.course else {
            panic!("still a jump");
        };
        assert!((5.0..=10.0).contains(&spread_s));
        let ideal = draw(&kind, "stage_bending", seed).unwrap();
        let other = misshapen(&ideal, seed);
        assert_eq!((other.axis, other.target), (ideal.axis, ideal.target));
        assert_ne!(other.act, ideal.act);
    }
}
