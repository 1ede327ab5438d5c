//! Rows that belong together, and what follows from their order.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::Problem;
use crate::clock::DAY_S;
use crate::columns::Columns;
use crate::map::{Leg, Map};
use crate::path::{PlannedStop, directions};
use crate::unit::Quantity;

/// What a row of an export says itself.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) line: usize,
    pub(crate) station: Option<String>,
    pub(crate) run: Option<String>,
    pub(crate) target: Option<String>,
    pub(crate) repeat: Option<u32>,
    pub(crate) direction: Option<i8>,
    pub(crate) time_s: Option<f64>,
    /// Positions of the axes in mm or degrees; none where the path tells it.
    pub(crate) axes: Vec<Option<f64>>,
    pub(crate) numbers: Vec<Option<f64>>,
}

/// What the table says of a row beside what was measured.
#[derive(Debug, Clone)]
pub(crate) struct Visit {
    /// Number of the stop, from 0.
    pub(crate) stop: usize,
    pub(crate) run: String,
    pub(crate) target: String,
    pub(crate) repeat: u32,
    /// +1 or -1.
    pub(crate) direction: i8,
    /// mm or degrees.
    pub(crate) positions: Vec<f64>,
}

/// Each row with its visit, or what is wrong and in which line.
pub(crate) fn visits(
    rows: Vec<Row>,
    map: &Map,
    columns: &Columns,
    path: &[PlannedStop<'_>],
) -> Result<Vec<(Row, Visit)>, (usize, Problem)> {
    let order = |stop: &PlannedStop<'_>| match stop.leg.targets.is_empty() {
        true => map.stops.targets.clone(),
        false => stop.leg.targets.clone(),
    };
    let orders: Vec<Vec<String>> = match path {
        [] => vec![map.stops.targets.clone()],
        path => path.iter().map(order).collect(),
    };
    let stops = stops(&rows, &orders);
    check_order(&rows, &orders, stops.len(), columns)?;
    if columns.target.is_none()
        && let Some((part, order)) = stops.iter().find(|(stop, order)| stop.len() != order.len())
    {
        return Err((
            rows[part.start].line,
            Problem::PartOfStop {
                found: part.len(),
                expected: order.len(),
                targets: order.to_vec(),
            },
        ));
    }
    let planned = planned(&rows, &stops, path)?;
    let (stops, orders): (Vec<Range<usize>>, Vec<&[String]>) = stops.into_iter().unzip();
    let first_rows = stops.iter().map(|stop| &rows[stop.start]);
    let at_stops = first_rows.zip(planned.iter().copied());
    let positions = at_stops
        .clone()
        .map(|(row, planned)| positions(row, columns, planned));
    let positions: Vec<Vec<f64>> = positions.collect();
    let runs = at_stops.map(|(row, planned)| {
        let of_path = || planned.map(|stop| stop.leg.run.clone());
        row.run.clone().or_else(of_path).unwrap_or_default()
    });
    let runs: Vec<String> = runs.collect();
    let inferred = inferred_directions(&rows, &stops, &runs, &positions);

    let mut seen: BTreeMap<(Option<String>, String, i8, Vec<u64>), u32> = BTreeMap::new();
    let mut visits = Vec::new();
    for (number, stop) in stops.iter().enumerate() {
        let first = &rows[stop.start];
        let planned = planned[number].map(|stop| stop.direction);
        let direction = first.direction.or(planned).unwrap_or(inferred[number]);
        let bits = positions[number].iter().map(|q| q.to_bits()).collect();
        let key = (first.station.clone(), runs[number].clone(), direction, bits);
        let count = seen.entry(key).or_default();
        *count += 1;
        for (index, row) in rows[stop.clone()].iter().enumerate() {
            let by_order = || orders[number].get(index).cloned().unwrap_or_default();
            visits.push(Visit {
                stop: number,
                run: runs[number].clone(),
                target: row.target.clone().unwrap_or_else(by_order),
                repeat: row.repeat.unwrap_or(*count),
                direction,
                positions: positions[number].clone(),
            });
        }
    }
    Ok(rows.into_iter().zip(visits).collect())
}

/// The rows of each stop and the order of its targets, which are those of `orders` in turn, at each station anew. A stop
/// ends where the row says that the machine or the tracker moved, and where the targets begin anew: the next one in the
/// order comes before the last one or, without an order, is read already.
fn stops<'o>(rows: &[Row], orders: &'o [Vec<String>]) -> Vec<(Range<usize>, &'o [String])> {
    let mut stops: Vec<(Range<usize>, &[String])> = Vec::new();
    let mut in_turn = 0;
    for (index, row) in rows.iter().enumerate() {
        let last = index.checked_sub(1).map(|last| &rows[last]);
        let goes_on = stops.last().zip(last).is_some_and(|((stop, order), last)| {
            let rank = |target: &Option<String>| {
                order.iter().position(|name| Some(name) == target.as_ref())
            };
            let stays = row.station == last.station
                && row.run == last.run
                && row.repeat == last.repeat
                && row.direction == last.direction
                && row.axes == last.axes;
            stays
                && match (&row.target, *order) {
                    (None, order) => stop.len() < order.len(),
                    (Some(_), []) => rows[stop.clone()].iter().all(|r| r.target != row.target),
                    (target, _) => rank(target) > rank(&last.target),
                }
        });
        match stops.last_mut() {
            Some((stop, _)) if goes_on => stop.end = index + 1,
            _ => {
                let same_station = last.is_some_and(|last| last.station == row.station);
                in_turn = if same_station { in_turn + 1 } else { 0 };
                stops.push((index..index + 1, orders[in_turn % orders.len()].as_slice()));
            }
        }
    }
    stops
}

/// Refuses rows that were sorted, by target or otherwise: in the order of time they are fewer stops. Of a clock only the
/// time of day counts, since each block of a sorted export may pass the same midnight.
fn check_order(
    rows: &[Row],
    orders: &[Vec<String>],
    stops_given: usize,
    columns: &Columns,
) -> Result<(), (usize, Problem)> {
    let of_day = matches!(&columns.time, Some((_, unit)) if unit.quantity == Quantity::Clock);
    let time_s = |row: &Row| match row.time_s.unwrap_or_default() {
        time_s if of_day => time_s.rem_euclid(DAY_S),
        time_s => time_s,
    };
    let mut pairs = rows.windows(2);
    let Some(back) = pairs.find(|pair| time_s(&pair[1]) < time_s(&pair[0])) else {
        return Ok(());
    };
    let mut by_time = rows.to_vec();
    by_time.sort_by(|a, b| time_s(a).total_cmp(&time_s(b)));
    let stops_by_time = stops(&by_time, orders).len();
    if stops_by_time < stops_given {
        let problem = Problem::NotInMeasuringOrder {
            stops: stops_given,
            stops_by_time,
        };
        return Err((back[1].line, problem));
    }
    Ok(())
}

/// The stop of the path for each stop, at which its targets must be read; each station begins it anew.
fn planned<'p>(
    rows: &[Row],
    stops: &[(Range<usize>, &[String])],
    path: &'p [PlannedStop<'p>],
) -> Result<Vec<Option<&'p PlannedStop<'p>>>, (usize, Problem)> {
    if path.is_empty() {
        return Ok(vec![None; stops.len()]);
    }
    let mut planned = Vec::new();
    let station = |stop: &Range<usize>| &rows[stop.start].station;
    for turn in stops.chunk_by(|(a, _), (b, _)| station(a) == station(b)) {
        for ((stop, order), planned) in turn.iter().zip(path.iter().cycle()) {
            let Row { line, target, .. } = &rows[stop.start];
            if let Some(target) = target
                && !order.is_empty()
                && !order.contains(target)
            {
                let Leg { run, axis, .. } = planned.leg;
                let problem = Problem::NotPlanned {
                    target: target.clone(),
                    stop: format!("run `{run}` at {axis} {}", planned.position),
                    targets: order.to_vec(),
                };
                return Err((*line, problem));
            }
        }
        if !turn.len().is_multiple_of(path.len()) {
            let first = &rows[turn[0].0.start];
            return Err((
                first.line,
                Problem::PartOfPath {
                    stops: turn.len(),
                    station: first.station.clone(),
                    path: path.len(),
                },
            ));
        }
        planned.extend(path.iter().cycle().take(turn.len()).map(Some));
    }
    Ok(planned)
}

/// Positions of all axes: as read, or of the path, in which an axis that nothing is said of stands at 0.
fn positions(row: &Row, columns: &Columns, planned: Option<&PlannedStop<'_>>) -> Vec<f64> {
    let axes = columns.axes.iter().zip(&row.axes);
    axes.map(|(axis, read)| {
        let by_plan = planned.and_then(|stop| {
            let moving = (stop.leg.axis == axis.name).then_some(stop.position);
            moving.or_else(|| stop.leg.at.get(&axis.name).copied())
        });
        read.unwrap_or_else(|| axis.unit.convert(by_plan.unwrap_or(0.0)))
    })
    .collect()
}

/// The side of approach of each stop, by the motion of the axis that moves most in its run during the occupation.
fn inferred_directions(
    rows: &[Row],
    stops: &[Range<usize>],
    runs: &[String],
    positions: &[Vec<f64>],
) -> Vec<i8> {
    let numbers: Vec<usize> = (0..stops.len()).collect();
    let station = |stop: usize| &rows[stops[stop].start].station;
    let together = |&a: &usize, &b: &usize| runs[a] == runs[b] && station(a) == station(b);
    let mut all = Vec::new();
    for turn in numbers.chunk_by(together) {
        let axis_positions =
            |axis: usize| -> Vec<f64> { turn.iter().map(|&stop| positions[stop][axis]).collect() };
        let motion = |axis: &usize| -> f64 {
            let along = axis_positions(*axis);
            along.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
        };
        let axes = 0..positions[turn[0]].len();
        let moving = axes
            .max_by(|a, b| motion(a).total_cmp(&motion(b)))
            .unwrap_or(0);
        all.extend(directions(&axis_positions(moving)));
    }
    all
}
