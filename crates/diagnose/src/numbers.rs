//! Range, mean, squares and the like of some numbers.

/// The smallest and the largest of some numbers; ∞ and -∞ if there are none.
pub(crate) fn extremes(numbers: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let numbers = numbers.into_iter();
    numbers.fold(none, |[low, high], x| [low.min(x), high.max(x)])
}

/// The mean; NaN of no numbers.
pub(crate) fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// `Σ x²`.
pub(crate) fn squares(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum()
}

/// `Σ (x - x̄)²`.
pub(crate) fn squares_about_mean(numbers: &[f64]) -> f64 {
    let mean = mean(numbers);
    numbers.iter().map(|x| (x - mean).powi(2)).sum()
}

pub(crate) fn root_mean_square(numbers: &[f64]) -> f64 {
    (squares(numbers) / numbers.len() as f64).sqrt()
}

/// The whole part of what counts something.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts are small and not negative"
)]
pub(crate) fn whole(count: f64) -> usize {
    count as usize
}

/// Each number once, ascending.
pub(crate) fn distinct(numbers: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut all: Vec<usize> = numbers.into_iter().collect();
    all.sort_unstable();
    all.dedup();
    all
}
