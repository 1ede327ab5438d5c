//! What a network does not determine, named by its stations, points and bodies.

use trueaxis_leastsquares::{BLOCK_RANK_TOL, Error as LeastSquaresError};

use crate::bodies::Deformations;
use crate::solve::MIN_STATIONS_PER_POINT;
use crate::state::PER_STATION;
use crate::{Error, Network, StationUnknown};

/// The error with the indices of the network.
pub(crate) fn named(network: &Network, error: LeastSquaresError) -> Error {
    let not_determined = |group: usize, lengths: usize, pivot: f64, limit: f64, of_point: Error| {
        let of_pose = Error::PoseNotDetermined {
            group,
            lengths,
            pivot,
            limit,
        };
        network.body_of(group).map_or(of_point, |_| of_pose)
    };
    match error {
        LeastSquaresError::BlockRank {
            block: group,
            unknown,
            pivot,
            limit,
        } => {
            let of_point = Error::PointNotDetermined {
                group,
                point: unknown / 3,
                pivot,
                limit,
            };
            not_determined(group, lengths_of(network, group), pivot, limit, of_point)
        }
        LeastSquaresError::TooFewRows {
            block: group,
            rows,
            unknowns,
        } => {
            let of_point = Error::PointSeenTooRarely {
                group,
                point: network.groups[group].len().saturating_sub(1),
                seen: rows / unknowns.div_ceil(3).max(1),
                need: MIN_STATIONS_PER_POINT,
            };
            not_determined(group, rows, 0.0, BLOCK_RANK_TOL, of_point)
        }
        LeastSquaresError::SharedRank {
            defect,
            eigenvalue,
            limit,
            free,
        } => {
            let behind_stations = PER_STATION * network.stations.len();
            let behind_zeros = behind_stations + network.interruptions.len();
            // The unknown with the largest share stands for what is free.
            if let Some(&(k, _)) = free.first().filter(|&&(k, _)| k >= behind_zeros) {
                let Deformations { first, shared, .. } = Deformations::new(network);
                return match k < shared {
                    true => Error::ShapeNotDetermined {
                        body: first.partition_point(|first| *first <= k) - 1,
                        eigenvalue,
                        limit,
                    },
                    false => Error::ReflectorsNotDetermined { eigenvalue, limit },
                };
            }
            let unknown = |&(k, _): &(usize, f64)| match k.checked_sub(behind_stations) {
                Some(i) => StationUnknown {
                    station: network.interruptions[i].station,
                    unknown: PER_STATION - 1,
                },
                None => StationUnknown {
                    station: k / PER_STATION,
                    unknown: k % PER_STATION,
                },
            };
            let of_stations = free.iter().filter(|&&(k, _)| k < behind_zeros);
            let free = of_stations.map(unknown).collect();
            Error::StationsNotDetermined {
                defect,
                eigenvalue,
                limit,
                free,
            }
        }
        other => Error::LeastSquares(other),
    }
}

fn lengths_of(network: &Network, group: usize) -> usize {
    let visits = network.visits.iter().filter(|visit| visit.group == group);
    visits.map(|visit| visit.readings.len()).sum()
}
