//! Rows and times between which an instant may lie.

use std::ops::Range;

/// A visit of a network, a stop, or several of them in time order.
#[derive(Debug, Clone)]
pub struct VisitTimes {
    /// Rows of the visit.
    pub rows: Range<usize>,
    /// Time of each row, s.
    pub times_s: Vec<f64>,
    /// First and last time, s.
    pub span_s: [f64; 2],
}

impl VisitTimes {
    /// The visit of these rows, with their times, s.
    pub fn new(rows: Range<usize>, times_s: impl Iterator<Item = f64>) -> Self {
        let times_s: Vec<f64> = times_s.collect();
        Self {
            rows,
            span_s: span_s(&times_s),
            times_s,
        }
    }

    /// Numbers of first rows that all lie before the rest in time, whatever their own order.
    pub(crate) fn cuts(&self) -> impl Iterator<Item = usize> + '_ {
        let first_of_rest = self.times_s.iter().rev();
        let first_of_rest = first_of_rest.scan(f64::INFINITY, |first, time| {
            *first = first.min(*time);
            Some(*first)
        });
        let mut first_of_rest: Vec<f64> = first_of_rest.collect();
        first_of_rest.reverse();
        let last_before = self.times_s.iter().scan(f64::NEG_INFINITY, |last, time| {
            *last = last.max(*time);
            Some(*last)
        });
        let pairs = last_before.zip(first_of_rest.into_iter().skip(1));
        let parted = pairs.enumerate().filter(|(_, (last, first))| last < first);
        parted.map(|(i, _)| i + 1)
    }
}

/// Earliest and latest of some times.
pub(crate) fn span_s(times_s: &[f64]) -> [f64; 2] {
    let all = || times_s.iter().copied();
    [
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    ]
}

#[cfg(test)]
mod tests {
    use super::VisitTimes;

    /// A visit whose readings are not in time order is cut only where all first rows are before all others.
    #[test]
    fn an_instant_parts_rows_by_their_times() {
        let cuts = |times_s: &[f64]| -> Vec<usize> {
            let visit = VisitTimes::new(0..times_s.len(), times_s.iter().copied());
            visit.cuts().collect()
        };
        assert_eq!(cuts(&[1.0, 2.0, 3.0]), [1, 2]);
        assert_eq!(cuts(&[1.0, 1.0, 3.0]), [2]);
        assert_eq!(cuts(&[2.0, 1.0, 5.0, 4.0, 6.0]), [2, 4]);
        assert!(cuts(&[3.0, 1.0, 2.0]).is_empty());
    }
}
