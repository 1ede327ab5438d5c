//! Between which numbers some lie.

/// The smallest and the largest of some numbers; of none ∞ and -∞.
pub(crate) fn extremes(numbers: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let numbers = numbers.into_iter();
    numbers.fold(none, |[low, high], x| [low.min(x), high.max(x)])
}
