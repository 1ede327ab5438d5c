//! Targets on the bed: read beside the runs, and refused where their rows say otherwise.

use trueaxis_campaign::{read, write};

use crate::fixture::{Files, assert_refused, three_axes};

/// The three axes with a target on the bed, read from S1 before all else, and from S4 after it.
fn with_bed() -> Files {
    let mut files = three_axes();
    files.json(
        r#""targets": ["#,
        r#""targets": [ { "name": "B", "position_mm": [0, 0, -200], "carried_by": null },"#,
    );
    files.lines("lengths.csv", |lines| {
        lines.insert(1, "-20,S1,1,,,0,0,0,B,812.25".to_owned());
        lines.push("100000,S4,1,,,0,0,400,B,812.25".to_owned());
    });
    files
}

#[test]
fn targets_on_the_bed_are_read_beside_the_runs() {
    let campaign = with_bed().read().unwrap();
    let lengths = campaign.lengths.as_ref().unwrap();
    assert_eq!(campaign.targets[0].carrier, None);
    let of_bed = lengths
        .readings
        .iter()
        .filter(|reading| reading.target == 0);
    assert_eq!(of_bed.count(), 2);
    let on_bed = campaign.steps.iter().filter(|step| step.run.is_none());
    let positions: Vec<&[f64]> = on_bed.map(|step| step.positions.as_slice()).collect();
    assert_eq!(positions, [[0.0, 0.0, 0.0], [0.0, 0.0, 400.0]]);
    assert_eq!(campaign.axis_under_test(lengths.stops[0].step), None);
    // One row of the table of coverage, with a station that never saw it.
    let coverage = campaign.coverage();
    let last = coverage.last().unwrap();
    assert_eq!((last.run, last.target, last.steps_of_run), (None, 0, 1));
    assert_eq!((last.seen[0].readings, last.seen[0].steps), (1, 1));
    assert!(last.hole(0).is_none() && last.hole(1).is_some() && last.hole(3).is_none());

    let folder = tempfile::tempdir().unwrap();
    let copy = read(&write(&campaign, folder.path()).unwrap()).unwrap();
    assert_eq!(copy, campaign);
}

#[test]
fn rows_of_the_bed_that_are_not_are_refused() {
    assert_refused(
        &with_bed(),
        &[
            (
                |f| f.cell("lengths.csv", 2, "run", "x"),
                "lengths.csv line 2, column run: \"x\" for target `B`, which stands on the \
                 bed … expected an empty cell",
            ),
            (
                |f| f.cell("lengths.csv", 2, "direction", "1"),
                "line 2, column direction: \"1\" for target `B`",
            ),
            (
                |f| f.cell("lengths.csv", 3, "run", ""),
                "line 3, column run: an empty cell for target `P`, which an axis carries … \
                 only targets on the bed (`carried_by` null) have none",
            ),
            (
                |f| f.cell("lengths.csv", 3, "direction", ""),
                "line 3, column direction: an empty cell for target `P`",
            ),
        ],
    );
}
