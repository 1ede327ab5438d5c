//! The last digit in which numbers are written.

/// Numbers that differ by less than this part of them are equal.
const EQUAL: f64 = 1e-9;

/// The smallest difference of any two unequal numbers stands for their last digit; `None` if all are equal.
pub fn last_digit(numbers: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.into_iter().collect();
    numbers.sort_by(f64::total_cmp);
    let gaps = numbers.windows(2).filter_map(|pair| {
        let (gap, larger) = (pair[1] - pair[0], pair[0].abs().max(pair[1].abs()));
        (gap > EQUAL * larger).then_some(gap)
    });
    gaps.min_by(f64::total_cmp)
}
