//! Readings that are wrong by accident: how many may be, and which they are.

/// Lines of a table that are named.
const NAMED: usize = 6;

/// A `part` of a `count`, and at least one: as many readings may be accidents, more are structure.
pub(crate) fn most(part: f64, count: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count"
    )]
    let most = (part * count as f64) as usize;
    most.max(1)
}

/// The first lines of a table, in words: `lines 3, 8 and others`.
pub(crate) fn first_lines(lines: impl ExactSizeIterator<Item = usize>) -> String {
    let more = if lines.len() > NAMED {
        " and others"
    } else {
        ""
    };
    let named: Vec<String> = lines.take(NAMED).map(|line| line.to_string()).collect();
    format!("lines {}{more}", named.join(", "))
}
