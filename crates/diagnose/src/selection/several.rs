//! Whether the weakest of several causes is one of its own.

/// A further cause that explains less than this part of what the others explain may be no more than
/// their shape, which is never quite that of the catalogue; for the same reason it must be more certain.
pub(crate) const SHAPE_ERROR: f64 = 0.05;
const FURTHER_LEVEL: f64 = 0.001;

/// What the weakest of several causes explains, from the drops of the squares by each with its p-value; and whether
/// it may be no more than the shape of the others, or one of them is not certain enough.
pub(crate) fn weakest(causes: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, bool) {
    let all: f64 = causes.clone().map(|(statistic, _)| statistic).sum();
    let weakest = causes
        .clone()
        .map(|(statistic, _)| statistic)
        .fold(all, f64::min);
    let is_uncertain = causes
        .into_iter()
        .any(|(_, p_value)| p_value > FURTHER_LEVEL);
    (
        weakest,
        weakest < SHAPE_ERROR * (all - weakest) || is_uncertain,
    )
}
