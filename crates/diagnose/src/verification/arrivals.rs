//! The readings of a verification as arrivals of the machine.
//!
//! The repeatability scatter is new at every arrival and common to all readings taken before the axis leaves again.
//! Consecutive readings at the same positions are therefore one arrival with their mean; arrivals are independent. An
//! arrival with several readings is a standstill.
//!
//! The side that the measured axis of a line comes from is the `direction` of the table, in whatever order its rows
//! are: sweep by sweep, or stop by stop from below and from above (step cycle of ISO 230-2). Other axes come from the
//! side of the pass (the readings of one cycle in one direction) where they move alone in it, otherwise from the sign
//! of their speed there ([`side`]). Speeds come from the table: `(q_next - q_last) / (t_next - t_last)` within the
//! pass, zero at a standstill, for a line without times and where uneven steps take even times ([`is_stopped`]).
//! Otherwise a table with one timed reading at each position does not say whether the machine stopped there; it is
//! taken as read on the fly, so that an offset of the time stamps stays among the possible causes. A circle is run at one feed: without times its speeds are per reading.

use trueaxis_campaign::VerificationReading;

use crate::numbers::extremes;
use crate::verification::side::{around, side};
use crate::verification::stopped::is_stopped;

/// One visit of a commanded position.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Arrival {
    /// Clock, s, mean of its readings; the number of the reading, counted from 1, if the table has no times.
    pub(crate) time_s: f64,
    /// Times of each of its readings.
    pub(crate) times_s: Vec<f64>,
    /// Time since the first reading.
    pub(crate) elapsed_s: f64,
    /// Progress of time over the table, 0 to 1.
    pub(crate) progress: f64,
    /// Cycle, from 1.
    pub(crate) cycle: u32,
    /// Direction of the pass, +1 or -1.
    pub(crate) direction: f64,
    /// Commanded positions of all axes, mm or rad.
    pub(crate) positions: Vec<f64>,
    /// Mean reading, µm.
    pub(crate) value_um: f64,
    /// Number of its readings.
    pub(crate) readings: usize,
    /// Line of its first reading in the table.
    pub(crate) line: usize,
    /// Whether it ends a circle where the circle began, after all other positions.
    pub(crate) closes_circle: bool,
    /// For each axis the side it came from, +1 or -1; 0 for an axis that does not move.
    pub(crate) sides: Vec<f64>,
    /// For each axis its speed, mm/s or rad/s; for a circle without a clock, per reading.
    pub(crate) speeds_per_s: Vec<f64>,
}

impl Arrival {
    /// Share of its readings after an instant: this share of what begins there is in their mean.
    pub(crate) fn part_after(&self, instant_s: f64) -> f64 {
        let after = self.times_s.iter().filter(|&&time_s| time_s > instant_s);
        after.count() as f64 / self.readings as f64
    }

    /// Whether two consecutive arrivals belong to one pass: one cycle in one direction.
    pub(crate) fn is_of_pass(&self, next: &Self) -> bool {
        self.cycle == next.cycle && is_same(self.direction, next.direction)
    }
}

/// For each arrival the number of its group: consecutive arrivals of which each two neighbours `are_same`.
pub(crate) fn groups_in_order(
    arrivals: &[Arrival],
    are_same: impl FnMut(&Arrival, &Arrival) -> bool,
) -> Vec<usize> {
    let rows = arrivals.chunk_by(are_same).enumerate();
    rows.flat_map(|(number, row)| std::iter::repeat_n(number, row.len()))
        .collect()
}

/// Whether a table has a clock; otherwise row numbers replace the times.
pub(crate) fn are_timed(readings: &[VerificationReading]) -> bool {
    readings.iter().all(|reading| reading.time_s.is_some())
}

/// The arrivals of a table in the order of its rows. `measured` is the axis of a line.
pub(crate) fn arrivals(readings: &[VerificationReading], measured: Option<usize>) -> Vec<Arrival> {
    let timed = are_timed(readings);
    let mut all: Vec<Arrival> = Vec::new();
    for (row, reading) in readings.iter().enumerate() {
        let time_s = reading.time_s.filter(|_| timed).unwrap_or((row + 1) as f64);
        let direction = f64::from(reading.direction.sign());
        let same = all.last_mut().filter(|last| {
            last.cycle == reading.cycle
                && is_same(last.direction, direction)
                && are_same(&last.positions, &reading.positions)
        });
        if let Some(last) = same {
            // Running means.
            last.readings += 1;
            let weight = 1.0 / last.readings as f64;
            last.value_um += (reading.value_um - last.value_um) * weight;
            last.time_s += (time_s - last.time_s) * weight;
            last.times_s.push(time_s);
        } else {
            all.push(Arrival {
                time_s,
                times_s: vec![time_s],
                elapsed_s: 0.0,
                progress: 0.0,
                cycle: reading.cycle,
                direction,
                positions: reading.positions.clone(),
                value_um: reading.value_um,
                readings: 1,
                line: reading.line,
                closes_circle: false,
                sides: vec![0.0; reading.positions.len()],
                speeds_per_s: vec![0.0; reading.positions.len()],
            });
        }
    }
    set_progress(&mut all);
    set_motion(&mut all, timed, measured.is_none());
    if let Some(axis) = measured.filter(|&axis| timed && is_stopped(&all, axis)) {
        all.iter_mut().for_each(|a| a.speeds_per_s[axis] = 0.0);
    }
    for arrival in &mut all {
        if let Some(axis) = measured {
            arrival.sides[axis] = arrival.direction;
        }
    }
    all
}

/// Commanded positions are copied, not computed: equal ones are the same number.
pub(crate) fn is_same(a: f64, b: f64) -> bool {
    a.total_cmp(&b).is_eq()
}

pub(crate) fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| is_same(*a, *b))
}

fn set_progress(all: &mut [Arrival]) {
    let [first, last] = extremes(all.iter().map(|arrival| arrival.time_s));
    let duration = (last - first).max(f64::MIN_POSITIVE);
    for arrival in all {
        arrival.elapsed_s = arrival.time_s - first;
        arrival.progress = arrival.elapsed_s / duration;
    }
}

/// Sides, and speeds where there are times or a machine that does not stop, pass by pass.
fn set_motion(all: &mut [Arrival], timed: bool, goes_on: bool) {
    for pass in all.chunk_by_mut(Arrival::is_of_pass) {
        let positions: Vec<Vec<f64>> = pass.iter().map(|a| a.positions.clone()).collect();
        // Rows that were left out took time, too.
        let time = |a: &Arrival| if timed { a.time_s } else { a.line as f64 };
        let times: Vec<f64> = pass.iter().map(time).collect();
        let moving = (0..positions[0].len()).filter(|&axis| {
            positions
                .iter()
                .any(|p| !is_same(p[axis], positions[0][axis]))
        });
        let moving: Vec<usize> = moving.collect();
        let last = positions.len() - 1;
        let closed = around(&positions);
        let comes_back = closed.is_some_and(|[before_first, _]| before_first < last);
        pass[last].closes_circle = comes_back && moving.len() > 1;
        for &axis in &moving {
            for (i, arrival) in pass.iter_mut().enumerate() {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
                let step = positions[b][axis] - positions[a][axis];
                // Where one axis moves alone, the table gives its side.
                arrival.sides[axis] = match moving.len() {
                    1 => arrival.direction,
                    _ => side(&positions, closed, axis, i),
                };
                let duration = times[b] - times[a];
                if (timed || goes_on) && arrival.readings == 1 && duration > 0.0 {
                    arrival.speeds_per_s[axis] = step / duration;
                }
            }
        }
    }
}
