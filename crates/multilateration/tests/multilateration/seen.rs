//! Points that too few stations see are named, wherever they are among groups that are measured by a plan.

use nalgebra::Point3;
use trueaxis_multilateration::{Error, Network, Reading, Visit, solve};

/// Groups of three points read from four stations, the first one without one of the readings.
fn network(groups: usize) -> Network {
    let mut network = Network {
        stations: vec![None; 4],
        ..Network::default()
    };
    for group in 0..groups {
        network.groups.push(3 * group..3 * group + 3);
        network.nominal_mm.extend([Point3::origin(); 3]);
        for station in 0..4 {
            let first = network.readings.len();
            let read = (0..3).filter(|&point| (group, station, point) != (0, 3, 2));
            network.readings.extend(read.map(|point| Reading {
                point,
                length_mm: 0.0,
            }));
            network.visits.push(Visit {
                station,
                group,
                readings: first..network.readings.len(),
            });
        }
    }
    network
}

fn unseen(group: usize, point: usize) -> Error {
    let (seen, need) = (0, 3);
    Error::PointSeenTooRarely {
        group,
        point,
        seen,
        need,
    }
}

#[test]
fn groups_without_visits_follow_no_plan() {
    for planned in [8, 16] {
        let mut network = network(planned);
        network.groups.push(3 * planned..3 * planned + 1);
        network.nominal_mm.push(Point3::origin());
        assert_eq!(solve(&network).err(), Some(unseen(planned, 0)));
    }
}

#[test]
fn a_point_more_than_planned_is_seen_too_rarely() {
    let mut network = network(17);
    network.groups[16].end += 1;
    network.nominal_mm.push(Point3::origin());
    assert_eq!(solve(&network).err(), Some(unseen(16, 3)));
}
