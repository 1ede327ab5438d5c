//! Points under wrong names, and an axis that is declared the other way: the refusal says which and where.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::{Campaign, Stop};

use crate::made_points::{Plan, made};

fn refusal(campaign: &Campaign) -> String {
    match calibrate(campaign, &Settings::default()) {
        Ok(_) => panic!("not refused"),
        Err(error) => error.to_string(),
    }
}

/// It was a contradiction without a cause, or the axis that fits worst.
#[test]
fn exchanged_targets_of_points_are_named_with_their_lines() {
    // A run, and a repeat of it.
    for (seed, is_of_repeat) in [(0, false), (1, true)] {
        let is_part =
            |stop: &Stop, run: Option<usize>| run == Some(1) && (!is_of_repeat || stop.repeat == 2);
        let mut campaign = made(&Plan::THREE_AXES, &[], seed);
        let (steps, points) = (&campaign.steps, campaign.points.as_mut().unwrap());
        let mut lines = [usize::MAX, 0];
        for stop in &points.stops {
            if !is_part(stop, steps[stop.step].run) {
                continue;
            }
            for reading in &mut points.readings[stop.readings.clone()] {
                lines = [lines[0].min(reading.line), lines[1].max(reading.line)];
                reading.target = match reading.target {
                    0 => 2,
                    2 => 0,
                    other => other,
                };
            }
        }
        let names = [0, 2].map(|target| campaign.targets[target].name.clone());
        let said = refusal(&campaign);
        let exchanged = format!("targets {} and {} are exchanged", names[0], names[1]);
        let of_lines = format!("(lines {} to {} of the points)", lines[0], lines[1]);
        assert!(
            said.contains(&exchanged) && said.contains(&of_lines),
            "{said}"
        );
        assert_eq!(said.contains("repeat 2"), is_of_repeat, "{said}");
    }
}

#[test]
fn a_reversed_axis_of_points_is_named() {
    let mut campaign = made(&Plan::THREE_AXES, &[], 3);
    for step in &mut campaign.steps {
        step.positions[1] *= -1.0;
    }
    let said = refusal(&campaign);
    assert!(
        said.contains("axis Y moves in the other direction"),
        "{said}"
    );
}
