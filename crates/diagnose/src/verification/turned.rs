//! Ends of the travel at which an axis turned round without going beyond them.
//!
//! ISO 230-2 asks for a run beyond the last position, so that it is reached from both sides. Where the axis turns at
//! it, both readings there came from one side, whatever the table says: they agree, while everywhere else the sides
//! differ. Taken as it is, this is lost motion that the ends do not have, as of a worn drive.
//!
//! The difference of the sides at the inner positions, averaged over the cycles, is a straight line (because of drift
//! on the way there and back); an end at which they agree, plainly off this line, has readings of one side.

use trueaxis_campaign::{Direction, Verification};
use trueaxis_kinematics::AxisKind;
use trueaxis_leastsquares::f_upper_tail;

use crate::numbers::{mean, squares_about_mean};
use crate::verification::arrivals::is_same;
use crate::verification::base::{count, lines, places};
use crate::verification::comparison::{Comparison, line};

/// Fewest positions between the ends: fewer do not show what is alike everywhere.
const LEAST_WITHIN: usize = 3;

/// Probability of taking an end that was reached from both sides for one that was not.
const LEVEL: f64 = 1e-4;

/// Probability below which the inner lost motion is no straight line.
const CURVED: f64 = 0.01;

/// Largest share of the inner lost motion at an end that has none.
const NONE: f64 = 0.25;

/// The positions of such ends of a single line, the side from which the axis came to each, and the notice.
pub(crate) fn turned(comparison: &Comparison<'_>) -> Option<(Vec<(f64, Direction)>, String)> {
    let axis = comparison.line()?;
    if count(&lines(comparison)) > 1 {
        return None;
    }
    let resolution_um = comparison.resolution_um()?;
    let differences = differences(comparison)?;
    let positions = comparison.positions(axis);
    let last = differences.len() - 1;
    let ends = [(0, Direction::Backward), (last, Direction::Forward)];
    let ends = ends.into_iter();
    let ends = ends.filter(|&(end, _)| agrees_alone(&differences, end, resolution_um));
    let ends: Vec<(f64, Direction)> = ends.map(|(end, from)| (positions[end], from)).collect();
    let content = &comparison.machine.axes()[axis];
    let place = |&(at, _): &(f64, Direction)| match content.kind() {
        AxisKind::Linear => format!("{at:.1} mm"),
        AxisKind::Rotary => format!("{:.1}°", at.to_degrees()),
    };
    let places: Vec<String> = ends.iter().map(place).collect();
    let said = format!(
        "at {} = {} both sides of approach read the same, while everywhere else they differ: the axis turned round there, so both \
         readings came from one side and are treated so; let it travel beyond its ends and come back (ISO 230-2)",
        content.name(),
        places.join(" and ")
    );
    (!ends.is_empty()).then_some((ends, said))
}

/// Gives the readings there the side from which they came.
pub(crate) fn put_right(verification: &mut Verification, ends: &[(f64, Direction)]) {
    let Some(axis) = line(&verification.kind) else {
        return;
    };
    for reading in &mut verification.readings {
        let at = reading.positions[axis];
        let end = ends.iter().find(|(end, _)| is_same(at, *end));
        reading.direction = end.map_or(reading.direction, |(_, from)| *from);
    }
}

/// The difference of the sides at each position, forward less backward, in each cycle in which both were read; `None`
/// if a position lacks that or there are no repeats.
fn differences(comparison: &Comparison<'_>) -> Option<Vec<Vec<f64>>> {
    let places = places(comparison);
    let numbers = count(&places);
    if numbers < LEAST_WITHIN + 2 {
        return None;
    }
    let mut all = vec![Vec::new(); numbers];
    for (arrival, &place) in comparison.arrivals.iter().zip(&places) {
        if arrival.direction < 0.0 {
            continue;
        }
        let mut others = comparison.arrivals.iter().zip(&places);
        let back = others.find(|(other, at)| {
            **at == place && other.cycle == arrival.cycle && other.direction < 0.0
        });
        all[place].extend(back.map(|(back, _)| arrival.value_um - back.value_um));
    }
    all.iter().all(|own| own.len() > 1).then_some(all)
}

/// Whether the sides agree at an end, and differ by a straight line over the positions between the ends.
fn agrees_alone(differences: &[Vec<f64>], end: usize, resolution_um: f64) -> bool {
    let squares: f64 = differences.iter().map(|own| squares_about_mean(own)).sum();
    let freedom: f64 = differences.iter().map(|own| own.len() as f64 - 1.0).sum();
    let variance = squares / freedom + 2.0 * resolution_um * resolution_um;
    // Weighted by the number of cycles: a straight line over the indices of the positions, about their mean.
    let within = || (1..differences.len() - 1).map(|k| (k as f64, &differences[k]));
    let weight: f64 = within().map(|(_, own)| own.len() as f64).sum();
    let weighted = |f: &dyn Fn(f64, f64) -> f64| {
        let terms = within().map(|(k, own)| own.len() as f64 * f(k, mean(own)));
        terms.sum::<f64>()
    };
    let [centre, level] = [weighted(&|k, _| k), weighted(&|_, d| d)].map(|sum| sum / weight);
    let spread = weighted(&|k, _| (k - centre).powi(2));
    let slope = weighted(&|k, d| (k - centre) * d) / spread;
    let line = |k: f64| level + slope * (k - centre);
    let bent = weighted(&|k, d| (d - line(k)).powi(2));
    let within_freedom = differences.len() as f64 - 4.0;
    let p_value = |squares: f64, freedom_above: f64| {
        f_upper_tail(squares / freedom_above / variance, freedom_above, freedom)
    };
    let is_straight = within_freedom < 1.0 || p_value(bent, within_freedom) > CURVED;
    let at = end as f64;
    let of_line = 1.0 / weight + (at - centre).powi(2) / spread;
    let own = mean(&differences[end]);
    let off = (own - line(at)).powi(2) / (1.0 / differences[end].len() as f64 + of_line);
    is_straight && p_value(off, 1.0) < LEVEL && own.abs() < NONE * level.abs()
}
