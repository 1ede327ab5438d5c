//! The order of measuring.
//!
//! With a clock it is that of the clock, in whatever order the rows are. For a line without one the rows are taken in
//! their order if cycle numbers fall for neither side and no pass goes against its side, or if they are a step cycle:
//! position after position, each from either side in turn. Reports print tables by position or by side with the cycle
//! fastest; there neighbouring rows are a cycle apart, and drifts look like lost motion. Such rows are put in the
//! order of the standard test cycle of ISO 230-2: cycle by cycle, forward ascending, then backward. A test of
//! repeatability with all cycles of one position and side before the next looks the same, so the readings decide
//! ([`tells`]); where they do not, both orders are judged ([`mod@crate::verification::other_order`]).

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};

use trueaxis_campaign::{Direction, Verification, VerificationReading};
use trueaxis_predict::positioning_lines;

use crate::verification::arrivals::{are_timed, is_same};
use crate::verification::base::{count, lines};
use crate::verification::comparison::{Comparison, came_from, line};
use crate::verification::which_order::{Tells, tells};

/// Fewest positions of a pass; fewer may have been approached one by one.
const A_PASS: usize = 3;

/// What was made of the order of rows.
#[derive(Default)]
pub(crate) struct InOrder {
    /// Where the order of the rows does not show that of measuring.
    pub(crate) notice: Option<String>,
    /// The rows in another order that is as likely.
    pub(crate) other: Option<Vec<VerificationReading>>,
}

/// Puts the readings in the order of measuring.
pub(crate) fn put_in_order(verification: &mut Verification) -> InOrder {
    let timed = are_timed(&verification.readings);
    if timed {
        let time_s = |reading: &VerificationReading| reading.time_s.unwrap_or_default();
        let readings = &mut verification.readings;
        readings.sort_by(|a, b| time_s(a).total_cmp(&time_s(b)));
    }
    let Some(axis) = line(&verification.kind) else {
        return InOrder::default();
    };
    let readings = &verification.readings;
    let lines = positioning_lines(axis, readings.iter().map(|r| r.positions.as_slice()));
    let rows = readings.iter().map(|r| Stop {
        cycle: r.cycle,
        direction: r.direction,
        at: r.positions[axis],
    });
    let orders = orders(rows, &lines);
    if timed {
        let said = "by time_s, passes go against their direction: forward and backward may be exchanged, and late time \
                    stamps are not looked for";
        let are_exchanged = orders.contains(&Order::Exchanged);
        return InOrder {
            notice: are_exchanged.then(|| format!("{}: {said}", verification.name)),
            other: None,
        };
    }
    let mut order = orders.into_iter().max().unwrap_or(Order::Measured);
    let mut other = None;
    if order == Order::Printed {
        let sorted = in_standard_order(readings, axis, &lines);
        let told = told_by_readings(readings, &cells(readings, axis, &lines), &sorted);
        order = match told {
            Some(Tells::Listed) => Order::Blocks,
            Some(Tells::Neither) => Order::Open,
            Some(Tells::Other) | None => Order::Printed,
        };
        if order != Order::Blocks {
            let sorted = sorted.iter().map(|&row| readings[row].clone()).collect();
            let listed = std::mem::replace(&mut verification.readings, sorted);
            other = (order == Order::Open).then_some(listed);
        }
    }
    let said = order.in_words();
    InOrder {
        notice: said.map(|said| format!("{}: without time_s {said}", verification.name)),
        other,
    }
}

/// The rows in the order of the standard test cycle.
fn in_standard_order(readings: &[VerificationReading], axis: usize, lines: &[usize]) -> Vec<usize> {
    let key = |row: usize| {
        let reading = &readings[row];
        (lines[row], reading.cycle, Reverse(reading.direction))
    };
    let along = |a: usize, b: usize| {
        let along = readings[a].positions[axis].total_cmp(&readings[b].positions[axis]);
        match readings[a].direction {
            Direction::Forward => along,
            Direction::Backward => along.reverse(),
        }
    };
    let mut rows: Vec<usize> = (0..readings.len()).collect();
    rows.sort_by(|&a, &b| key(a).cmp(&key(b)).then_with(|| along(a, b)));
    rows
}

/// For each row the number of its position and side, in the order in which they first come.
fn cells(readings: &[VerificationReading], axis: usize, lines: &[usize]) -> Vec<usize> {
    let mut known = HashMap::new();
    let cell = |(reading, &line): (&VerificationReading, &usize)| {
        let key = (line, reading.direction, reading.positions[axis].to_bits());
        let next = known.len();
        *known.entry(key).or_insert(next)
    };
    readings.iter().zip(lines).map(cell).collect()
}

/// Whether the readings were taken as they are listed, or in the standard order; `None` where the rows cannot be those
/// of a test of repeatability: all cycles of one position and side before the next, one reading in each. Several
/// readings of a stop share what the machine returns to, and do not tell their order.
fn told_by_readings(
    readings: &[VerificationReading],
    cells: &[usize],
    sorted: &[usize],
) -> Option<Tells> {
    let cycles: Vec<u32> = readings.iter().map(|r| r.cycle).collect();
    let rows: Vec<usize> = (0..readings.len()).collect();
    let mut blocks = rows.chunk_by(|&a, &b| cells[a] == cells[b]).enumerate();
    // No cell comes again if their numbers are those of the blocks.
    let are_blocks = blocks.all(|(number, block)| {
        let of_block = block.iter().map(|&row| cycles[row]);
        cells[block[0]] == number && block.len() > 1 && of_block.is_sorted_by(|a, b| a < b)
    });
    let values_um: Vec<f64> = readings.iter().map(|r| r.value_um).collect();
    are_blocks.then(|| tells(&values_um, cells, &cycles, sorted))
}

fn orders(rows: impl Iterator<Item = Stop>, lines: &[usize]) -> Vec<Order> {
    let found = by_line(rows, lines).into_iter().map(|mut stops| {
        stops.dedup_by(|a, b| a.is(b));
        Order::of(&stops)
    });
    found.collect()
}

/// Whether passes of a line go against their side.
pub(crate) fn goes_against_its_sides(comparison: &Comparison<'_>) -> bool {
    comparison.line().is_some()
        && orders(stops(comparison), &lines(comparison)).contains(&Order::Exchanged)
}

/// Consecutive rows of one line at one position from one side in one cycle.
#[derive(Clone, Copy)]
struct Stop {
    cycle: u32,
    direction: Direction,
    at: f64,
}

/// The stops of each line in their order.
fn by_line(stops: impl Iterator<Item = Stop>, lines: &[usize]) -> Vec<Vec<Stop>> {
    let mut of_lines = vec![Vec::new(); count(lines)];
    for (stop, &line) in stops.zip(lines) {
        of_lines[line].push(stop);
    }
    of_lines
}

impl Stop {
    fn is(&self, other: &Self) -> bool {
        self.is_of_pass(other) && is_same(self.at, other.at)
    }

    fn is_of_pass(&self, other: &Self) -> bool {
        (self.cycle, self.direction) == (other.cycle, other.direction)
    }
}

/// The order of the rows of a line; the later ones need more of a notice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Order {
    /// That of measuring.
    Measured,
    /// Passes go against their side, but not all passes of only one side: the sides may be exchanged.
    Exchanged,
    /// All passes of one side are before those of the other.
    BySide,
    /// Cycle numbers fall, and appear again.
    Again,
    /// Not that of measuring.
    Printed,
    /// Sorted as a report is, but measured like this, as the readings tell.
    Blocks,
    /// Sorted as a report is, and the readings do not tell whether they were measured like this.
    Open,
}

impl Order {
    fn of(stops: &[Stop]) -> Self {
        let sides = [Direction::Forward, Direction::Backward];
        let of = |side: Direction| stops.iter().filter(move |stop| stop.direction == side);
        let falls_for_a_side = sides
            .iter()
            .any(|&side| !of(side).is_sorted_by_key(|stop| stop.cycle));
        // For each side whether its passes agree with it.
        let [forward, backward] = sides.map(|side| {
            let passes = stops.chunk_by(Stop::is_of_pass);
            let of_side = passes.filter(|pass| pass[0].direction == side);
            of_side
                .filter_map(goes_with_its_side)
                .collect::<Vec<bool>>()
        });
        let is_against = |goes: &[bool]| !goes.contains(&true);
        let is_sorted = !forward.is_empty()
            && !backward.is_empty()
            && is_against(&forward) != is_against(&backward);
        if is_step_cycle(stops) {
            Self::Measured
        } else if falls_for_a_side || is_sorted {
            match is_any_again(stops) {
                true => Self::Again,
                false => Self::Printed,
            }
        } else if forward.contains(&false) || backward.contains(&false) {
            Self::Exchanged
        } else if !stops.is_sorted_by_key(|stop| stop.cycle) {
            Self::BySide
        } else {
            Self::Measured
        }
    }

    /// The notice about it; `None` for the order of measuring.
    fn in_words(self) -> Option<&'static str> {
        match self {
            Self::Measured => None,
            Self::Exchanged => Some(
                "its rows were taken in the order of measuring, but passes go against their direction: forward and backward may be \
                 exchanged",
            ),
            Self::BySide => Some(
                "its rows were taken in the order of measuring, all passes of one side before those of the other, which does not \
                 tell lost motion from what goes with time; if the axis went there and back, give time_s, or the rows cycle by cycle",
            ),
            Self::Again => Some(
                "its rows were taken in the order of measuring, but cycle numbers fall or passes go against their direction, and \
                 some come again; number all cycles, or give time_s",
            ),
            Self::Printed => Some(
                "its rows are in the order of a report (cycle numbers fall, or passes go against their direction); they were put in \
                 the order of the standard test cycle of ISO 230-2, cycle by cycle there and back. If it was another, give time_s, or \
                 the rows in the order of measuring",
            ),
            Self::Blocks => Some(
                "its rows are sorted as in a report, but what wanders in them is smooth in their own order, not in that of the \
                 standard test cycle of ISO 230-2; they were taken in their own, as of a test of repeatability with all cycles of one \
                 position and side before the next. If it was another, give time_s, or the rows in the order of measuring",
            ),
            Self::Open => Some(
                "its rows are in the order of a report (cycle numbers fall, or passes go against their direction), or of a test of \
                 repeatability with all cycles of one position and side before the next, and the readings do not tell which. They were \
                 put in the order of the standard test cycle of ISO 230-2, cycle by cycle there and back; what hinges on that is not \
                 named alone. Give time_s, or the rows in the order of measuring",
            ),
        }
    }
}

/// Whether a pass goes up forward and down backward, or the other way round; `None` for too few stops or to and fro.
fn goes_with_its_side(pass: &[Stop]) -> Option<bool> {
    let sign = f64::from(pass.first()?.direction.sign());
    let steps = || pass.windows(2).map(|two| (two[1].at - two[0].at) * sign);
    let goes = |with: bool| pass.len() >= A_PASS && steps().all(|step| (step > 0.0) == with);
    [true, false].into_iter().find(|&with| goes(with))
}

/// Whether rows without a clock were taken as a step cycle: position after position, in all cycles or in each, from
/// either side in turn. Tables with both sides beside each other are printed like that, too.
pub(crate) fn takes_turns(comparison: &Comparison<'_>) -> bool {
    if comparison.line().is_none() || comparison.timed {
        return false;
    }
    let takes_turns = |of_line: &Vec<Stop>| {
        let mut cycles = of_line.chunk_by(|a, b| a.cycle == b.cycle);
        let turns = of_line
            .windows(2)
            .filter(|two| is_same(two[0].at, two[1].at));
        turns.count() > 1 && (is_step_cycle(of_line) || cycles.all(is_step_cycle))
    };
    by_line(stops(comparison), &lines(comparison))
        .iter()
        .any(takes_turns)
}

fn stops(comparison: &Comparison<'_>) -> impl Iterator<Item = Stop> {
    let axis = comparison.axis();
    comparison.arrivals.iter().map(move |arrival| Stop {
        cycle: arrival.cycle,
        direction: came_from(arrival),
        at: arrival.positions[axis],
    })
}

/// Whether all rows of a position follow each other, from either side in turn.
fn is_step_cycle(stops: &[Stop]) -> bool {
    let of_position = || stops.chunk_by(|a, b| is_same(a.at, b.at));
    let mut seen = HashSet::new();
    let mut positions = of_position().map(|stops| stops[0].at.to_bits());
    let take_turns = |stops: &[Stop]| {
        stops
            .windows(2)
            .all(|two| two[0].direction != two[1].direction)
    };
    positions.all(|at| seen.insert(at)) && of_position().all(take_turns)
}

/// Whether a position is given more than once from one side in one cycle, other than in consecutive rows.
fn is_any_again(stops: &[Stop]) -> bool {
    let mut seen = HashSet::new();
    let mut keys = stops.iter().map(|s| (s.cycle, s.direction, s.at.to_bits()));
    !keys.all(|key| seen.insert(key))
}
