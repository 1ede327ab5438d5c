//! Readings that are wrong by accident: how many are possible, and which they are.
//!
//! With columns `X` of its own in the model, a reading, or several together, is tested against what the others leave
//! (externally studentised residuals; Cook and Weisberg 1982, ch. 2):
//!
//! ```text
//! d = sᵀ G⁻¹ s      s = Xᵀ e      G = Xᵀ M X      F = (d/k)/((S - d)/(ν - k))
//! ```

use trueaxis_files::counted;
use trueaxis_selection::{Gram, ln_f_test};

use crate::numbers::whole;

/// Probability of leaving out anything from readings that are in order, for each file.
pub(crate) const ACCIDENT_LEVEL: f64 = 1e-4;

/// Fewest degrees of freedom of the others; with fewer, Student's limit is beyond anything.
pub(crate) const LEAST_OTHERS: f64 = 5.0;

/// Readings with values of their own in the model.
pub(crate) struct Tested {
    /// The values, with their covariance, rows one after the other.
    pub(crate) errors: Vec<f64>,
    pub(crate) covariance: Vec<f64>,
    /// d.
    pub(crate) drop: f64,
    pub(crate) ln_p: f64,
}

impl Tested {
    /// From `G` and `s` of columns in a model that leaves `squares` with as many degrees of freedom; the variance of
    /// the others is at least this.
    pub(crate) fn new(
        (squares, of_all): (f64, f64),
        (gram, s): (&Gram, &[f64]),
        least_variance: f64,
    ) -> Self {
        let (rank, drop) = (gram.rank(), gram.statistic(s));
        let freedom = of_all - rank as f64;
        let rest = (squares - drop).max(freedom * least_variance);
        let covariance = gram.covariance().into_iter();
        Self {
            errors: gram.estimates(s),
            covariance: covariance.map(|c| c * rest / freedom).collect(),
            ln_p: ln_f_test(drop, drop + rest, rank, of_all),
            drop,
        }
    }
}

/// Most lines of a table that are named.
const NAMED: usize = 6;

/// Share of the readings that may be wrong by accident; of readings, two in a row count as one.
pub(crate) const ACCIDENTS: f64 = 0.03;

/// How many of `count` readings may be wrong by accident: the share `part`, and at least one.
pub(crate) fn most(part: f64, count: usize) -> usize {
    whole(part * count as f64).max(1)
}

/// Names at most six lines of a table: `lines 3, 8 and others`.
pub(crate) fn first_lines(lines: impl ExactSizeIterator<Item = usize>) -> String {
    let more = if lines.len() > NAMED {
        " and others"
    } else {
        ""
    };
    let named: Vec<String> = lines.take(NAMED).map(|line| line.to_string()).collect();
    format!("lines {}{more}", named.join(", "))
}

/// The notice that lengths or points were left out, with their lines in the file.
pub(crate) fn left_out_in_words(noun: &str, lines: impl Iterator<Item = usize>) -> String {
    let lines: Vec<String> = lines.map(|line| line.to_string()).collect();
    format!(
        "left out because all others contradict them: {}, {} {}",
        counted(lines.len(), noun),
        if lines.len() == 1 { "line" } else { "lines" },
        lines.join(", ")
    )
}
