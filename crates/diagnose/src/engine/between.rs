//! A shape between neighbours in a list.

/// The neighbours of a value in an unsorted list.
pub(crate) fn neighbours(all: &[f64], value: f64) -> [Option<f64>; 2] {
    let before = all.iter().copied().filter(|&other| other < value);
    let after = all.iter().copied().filter(|&other| other > value);
    [before.reduce(f64::max), after.reduce(f64::min)]
}

/// A value that is closer to a neighbour than this share of the distance of both is at an end of what was tried.
const AT_END: f64 = 0.01;

/// The values of a list on either side of one that is not at an end.
pub(crate) fn around(all: &[f64], value: f64) -> [Option<f64>; 2] {
    let [before, after] = neighbours(all, value);
    let (Some(low), Some(high)) = (before, after) else {
        return [before, after];
    };
    let near = AT_END * (high - low);
    let beyond = |end: f64, side: usize| match (value - end).abs() < near {
        true => neighbours(all, end)[side].or(Some(end)),
        false => Some(end),
    };
    [beyond(low, 0), beyond(high, 1)]
}

/// The place of the maximum of `value` between two ends, by golden section until `is_close`.
pub(crate) fn golden_section(
    [mut low, mut high]: [f64; 2],
    is_close: impl Fn(f64, f64) -> bool,
    value: impl Fn(f64) -> f64,
) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut of_a, mut of_b) = (value(a), value(b));
    // One of the inner points is also one of the next interval.
    while !is_close(low, high) {
        if of_a > of_b {
            (high, b, of_b) = (b, a, of_a);
            a = inner(low, high)[0];
            of_a = value(a);
        } else {
            (low, a, of_a) = (a, b, of_b);
            b = inner(low, high)[1];
            of_b = value(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_is_found_between_its_neighbours() {
        let ends = neighbours(&[7.0, 5.0, 3.0, 1.0], 3.0);
        assert_eq!(ends, [Some(1.0), Some(5.0)]);
        assert_eq!(neighbours(&[7.0, 5.0], 7.0), [Some(5.0), None]);
        let top = golden_section([1.0, 5.0], |a, b| b - a < 1e-6, |x| -(x - 3.7).powi(2));
        assert!((top - 3.7).abs() < 1e-6, "{top}");
    }
}
