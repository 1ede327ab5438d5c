//! Correct campaigns: what is read from them, and that writing and reading give them again.

use std::path::{Path, PathBuf};

use trueaxis_campaign::{Campaign, Direction, Hole, Seen, VerificationKind, read, write};

use crate::fixture::{rotary_table, table_points, three_axes};

#[test]
fn lengths_become_stops_and_steps() {
    let campaign = three_axes().read().unwrap();
    let lengths = campaign.lengths.as_ref().unwrap();
    assert_eq!(lengths.readings.len(), 4 * 3 * 10 * 3);
    assert_eq!(lengths.stops.len(), 4 * 3 * 10);
    assert_eq!(
        campaign.steps.len(),
        3 * 5,
        "shared by stations and directions"
    );
    let second = &lengths.stops[1];
    assert_eq!((second.station, second.repeat, second.step), (0, 1, 1));
    assert_eq!(second.direction, Direction::Forward);
    assert_eq!(second.readings, 3..6);
    assert_eq!(campaign.steps[1].positions, [100.0, 0.0, 0.0]);
    assert_eq!(campaign.steps[1].run, Some(0));
    let turning_point = &lengths.stops[5];
    assert_eq!(turning_point.direction, Direction::Backward);
    assert_eq!(turning_point.step, lengths.stops[4].step);
    let reading = &lengths.readings[4];
    assert_eq!((reading.target, reading.line), (1, 6));
    assert_eq!(lengths.logged, []);
    assert_eq!(campaign.targets[2].carrier, Some(2));
    assert_eq!(campaign.instrument.repeatability_um, Some(1.0));
    let value_um = campaign.verification[0].readings[4].value_um;
    assert_eq!(Some(value_um), Some(3.0));
    assert_eq!(campaign.notices, [""; 0]);
}

#[test]
fn coverage_counts_readings_and_steps() {
    let mut files = three_axes();
    files.lines("lengths.csv", |lines| {
        // One of two lengths at Y = 100 from S2: the step is still seen.
        let is = |l: &String| l.contains(",S2,1,y,1,0,100,0,Q,");
        lines.retain(|line| !is(line));
        // Both directions at Z = 400 from S3.
        lines.retain(|line| !(line.contains(",S3,1,z,") && line.contains(",0,0,400,K,")));
        lines.retain(|line| !(line.contains(",S1,1,x,") && line.contains(",P,")));
    });
    let coverage = files.read().unwrap().coverage();
    assert_eq!(coverage.len(), 9);
    let full = Seen {
        readings: 10,
        steps: 5,
    };
    for covered in &coverage {
        assert_eq!(covered.steps_of_run, 5);
        for (station, &seen) in covered.seen.iter().enumerate() {
            let hole = match (covered.run, covered.target, station) {
                (Some(0), 0, 0) => Some((Hole::NotSeen, 0, 0)),
                (Some(1), 1, 1) => Some((Hole::Readings, 9, 5)),
                (Some(2), 2, 2) => Some((Hole::Steps, 8, 4)),
                _ => None,
            };
            assert_eq!(covered.hole(station), hole.map(|(hole, ..)| hole));
            let expected = hole.map_or(full, |(_, readings, steps)| Seen { readings, steps });
            assert_eq!(seen, expected);
        }
    }
    let points = table_points().read().unwrap().coverage();
    assert_eq!(points.len(), 3);
    assert_eq!(points[2].seen.len(), 1);
    assert_eq!(points[2].hole(0), None);
}

#[test]
fn rotary_positions_become_radians() {
    let campaign = table_points().read().unwrap();
    let [low, high] = campaign.machine.axes()[0].travel();
    assert_eq!((low, high), (0.0, 360_f64.to_radians()));
    assert_eq!(campaign.steps[4].positions, [90_f64.to_radians()]);
    let points = campaign.points.as_ref().unwrap();
    assert_eq!(points.stops.len(), 17);
    assert_eq!(points.readings[0].sigma_um, Some(15.0));
    let ballbar = &campaign.verification[0];
    assert!(matches!(
        ballbar.kind,
        VerificationKind::Ballbar {
            ball_carrier: 0,
            ..
        }
    ));
    assert_eq!(ballbar.readings[1].time_s, Some(10.0));
    assert_eq!(ballbar.readings[1].positions, [90_f64.to_radians()]);
}

#[test]
fn a_verification_alone_is_a_campaign() {
    let mut files = three_axes();
    files.lines("campaign.json", |lines| {
        let from =
            |lines: &[String], key: &str| lines.iter().position(|l| l.contains(key)).unwrap();
        let targets = from(lines, "\"targets\"");
        let verification = from(lines, "\"verification\"");
        lines.drain(targets..verification);
    });
    let campaign = files.read().unwrap();
    assert_eq!(campaign.lengths, None);
    assert_eq!(campaign.verification.len(), 1);
    assert_eq!(written_and_read(&campaign), campaign);
}

#[test]
fn air_and_machine_state_is_optional_cell_by_cell() {
    let mut files = three_axes();
    files.lines("lengths.csv", |lines| {
        for (i, line) in lines.iter_mut().enumerate() {
            *line += match i {
                0 => ",machine_temp_c,air_temp_c",
                1 => ",20.25,",
                _ => ",,",
            };
        }
    });
    let campaign = files.read().unwrap();
    let lengths = campaign.lengths.as_ref().unwrap();
    let values = |name: &str| &lengths.logged_column(name).unwrap().values;
    assert_eq!(values("machine_temp_c").len(), 360);
    assert_eq!(values("machine_temp_c")[..2], [Some(20.25), None]);
    assert!(values("air_temp_c").iter().all(Option::is_none));
    assert_eq!(written_and_read(&campaign), campaign);
}

#[test]
fn writing_and_reading_gives_the_same_campaign() {
    for files in [three_axes(), rotary_table(), table_points()] {
        let mut campaign = files.read().unwrap();
        assert_eq!(written_and_read(&campaign), campaign);
        // Names that need quotes, and nothing declared.
        campaign.instrument = Default::default();
        campaign.targets[1].name = "Q, \"upper\"".to_owned();
        campaign
            .stations
            .iter_mut()
            .for_each(|s| s.approx_mm = None);
        assert_eq!(written_and_read(&campaign), campaign);
    }
}

#[test]
fn writing_again_gives_the_same_bytes() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let campaign = rotary_table().read().unwrap();
    let first = write(&campaign, folders[0].path()).unwrap();
    let second = write(&read(&first).unwrap(), folders[1].path()).unwrap();
    for name in ["campaign.json", "lengths.csv", "verification_1.csv"] {
        let bytes = |path: &Path| std::fs::read(path.with_file_name(name)).unwrap();
        assert!(!bytes(&first).is_empty());
        assert!(bytes(&first) == bytes(&second), "{name}");
    }
    let lengths = std::fs::read_to_string(first.with_file_name("lengths.csv")).unwrap();
    assert!(lengths == rotary_table().0["lengths.csv"], "other text");
}

#[test]
fn a_campaign_that_contradicts_itself_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: fn(&mut Campaign)| {
        let mut campaign = three_axes().read().unwrap();
        change(&mut campaign);
        let message = write(&campaign, folder.path()).unwrap_err().to_string();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        message
    };
    let readings = refused(|c| c.lengths.as_mut().unwrap().readings[5].target = 7);
    assert!(
        readings.contains("lengths.csv line 7, column target: unknown target ``"),
        "{readings}"
    );
    let stops = refused(|c| c.lengths.as_mut().unwrap().stops.truncate(100));
    assert!(
        stops.contains("its stops do not cover its readings"),
        "{stops}"
    );
    let number = refused(|c| c.targets[0].home_mm.x = f64::NAN);
    assert!(
        number.contains("field targets[0].position_mm[0]"),
        "{number}"
    );
    let length = refused(|c| c.lengths.as_mut().unwrap().readings[5].length_mm = f64::INFINITY);
    assert!(
        length.contains("lengths.csv line 7, column length_mm"),
        "{length}"
    );
}

/// Two real axes measured by a camera: coarse, with gaps, in a frame of its own.
#[test]
#[expect(clippy::print_stdout, reason = "says what was not tested")]
fn real_measurements_are_read() {
    for (name, steps) in [("positioner-rotation", 16), ("positioner-tilt", 13)] {
        let Some(path) = real(name) else {
            println!("skipped: no {name} beside the repository");
            continue;
        };
        let campaign = read(&path).unwrap();
        assert_eq!(campaign.steps.len(), steps);
        assert_eq!(campaign.points.as_ref().unwrap().readings.len(), 3 * steps);
        assert_eq!(campaign.notices, [""; 0]);
        assert_eq!(written_and_read(&campaign), campaign);
    }
}

fn real(name: &str) -> Option<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2)?;
    let campaign = repository
        .parent()?
        .join("shared/real")
        .join(name)
        .join("campaign.json");
    campaign.exists().then_some(campaign)
}

fn written_and_read(campaign: &Campaign) -> Campaign {
    let folder = tempfile::tempdir().unwrap();
    read(&write(campaign, &folder.path().join("new")).unwrap()).unwrap()
}
