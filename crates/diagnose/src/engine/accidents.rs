//! Readings that are wrong by accident: how many are possible, and which they are.

/// Most lines of a table that are named.
const NAMED: usize = 6;

/// How many of `count` readings may be wrong by accident: the share `part`, and at least one.
pub(crate) fn most(part: f64, count: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count"
    )]
    let most = (part * count as f64) as usize;
    most.max(1)
}

/// Line numbers of a table in words; of many only the first are named: `lines 3, 8 and others`.
pub(crate) fn first_lines(lines: impl ExactSizeIterator<Item = usize>) -> String {
    let more = if lines.len() > NAMED {
        " and others"
    } else {
        ""
    };
    let named: Vec<String> = lines.take(NAMED).map(|line| line.to_string()).collect();
    format!("lines {}{more}", named.join(", "))
}
