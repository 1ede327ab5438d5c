//! The range of some numbers.

/// The smallest and the largest of some numbers; ∞ and -∞ if there are none.
pub(crate) fn extremes(numbers: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let numbers = numbers.into_iter();
    numbers.fold(none, |[low, high], x| [low.min(x), high.max(x)])
}
