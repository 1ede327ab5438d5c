//! The largest value between two ends.

/// Where `value` is largest between two ends, by golden section until `is_close`.
pub(crate) fn golden_section(
    [mut low, mut high]: [f64; 2],
    is_close: impl Fn(f64, f64) -> bool,
    value: impl Fn(f64) -> f64,
) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    while !is_close(low, high) {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if value(a) > value(b) {
            high = b;
        } else {
            low = a;
        }
    }
    0.5 * (low + high)
}
