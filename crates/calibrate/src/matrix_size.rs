//! Refusal of matrices that would not fit.

use crate::Error;

/// Size of the largest matrix that is made, GiB.
const LIMIT_GIB: f64 = 1.0;

/// Refuses a matrix of numbers that is too large; `instead` says what to do.
pub(crate) fn check_size(
    matrix: impl FnOnce() -> String,
    [rows, columns]: [usize; 2],
    instead: &'static str,
) -> Result<(), Error> {
    let gib = rows as f64 * columns as f64 * size_of::<f64>() as f64 / 1024_f64.powi(3);
    if gib <= LIMIT_GIB {
        return Ok(());
    }
    Err(Error::TooLarge {
        matrix: matrix(),
        gib,
        limit_gib: LIMIT_GIB,
        instead,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_its_size() {
        let matrix = || "the covariance".to_owned();
        assert_eq!(check_size(matrix, [11_585; 2], "leave it out"), Ok(()));
        let refused = check_size(matrix, [40_000; 2], "leave it out").unwrap_err();
        let text = refused.to_string();
        let says = "the covariance takes 11.9 GiB, at most 1 GiB are made; leave it out";
        assert_eq!(text, says);
    }
}
