//! The table of coverage: how many lengths of which target from which station in which run.
//!
//! ```text
//!   coverage  run  targets    S1    S2    S3    S4
//!             x    P K        69    69    69    69
//!             x    Q          69   68*   66!     –
//! ```
//!
//! Targets of a run with the same numbers share a line, and a table that is too wide goes on below.

use trueaxis_campaign::{Campaign, Coverage, Hole};

/// Columns of the terminal.
const WIDTH: usize = 100;

/// What the other lines of `check` begin with.
const INDENT: &str = "            ";

/// The table, and what its marks mean; nothing without readings.
pub(super) fn lines(campaign: &Campaign) -> Vec<String> {
    let rows = rows(campaign);
    if rows.is_empty() {
        return Vec::new();
    }
    let mut table = vec![header(campaign)];
    table.extend(rows);
    let columns = table[0].len();
    let width = |column: usize| {
        let cells = table.iter().map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let room = WIDTH.saturating_sub(INDENT.len() + widths[0] + 2 + widths[1]);
    let mut lines = Vec::new();
    let mut first = 2;
    while first < columns {
        let mut end = first + 1;
        let taken = |end: usize| widths[first..end].iter().map(|width| 2 + width).sum();
        while end < columns && room >= taken(end + 1) {
            end += 1;
        }
        for (i, row) in table.iter().enumerate() {
            let start = match (i, first) {
                (0, 2) => "  coverage  ",
                _ => INDENT,
            };
            let mut line = format!(
                "{start}{:<2$}  {:<3$}",
                row[0], row[1], widths[0], widths[1]
            );
            for column in first..end {
                line += &format!("  {:>1$}", row[column], widths[column]);
            }
            lines.push(line.trim_end().to_owned());
        }
        first = end;
    }
    lines.extend(legend(&table));
    lines
}

fn header(campaign: &Campaign) -> Vec<String> {
    let stations = if campaign.lengths.is_some() {
        campaign.stations.iter().map(|s| s.name.clone()).collect()
    } else {
        vec!["points".to_owned()]
    };
    let mut header = vec!["run".to_owned(), "targets".to_owned()];
    header.extend(stations);
    header
}

/// Targets of a run with the same cells share a row.
fn rows(campaign: &Campaign) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for covered in campaign.coverage() {
        let run = covered.run.map(|run| campaign.runs[run].name.clone());
        let run = run.unwrap_or_else(|| "(bed)".to_owned());
        let target = &campaign.targets[covered.target].name;
        let cells: Vec<String> = (0..covered.seen.len()).map(|s| cell(&covered, s)).collect();
        match rows
            .iter_mut()
            .find(|row| row[0] == run && row[2..] == cells)
        {
            Some(row) => row[1] += &format!(" {target}"),
            None => {
                let names = [run, target.clone()];
                rows.push(names.into_iter().chain(cells).collect());
            }
        }
    }
    rows
}

/// The number with the mark of its hole; a blank stands where a mark would be.
fn cell(covered: &Coverage, station: usize) -> String {
    let count = covered.seen[station].readings;
    match covered.hole(station) {
        None => format!("{count} "),
        Some(Hole::NotSeen) => "– ".to_owned(),
        Some(Hole::Steps) => format!("{count}!"),
        Some(Hole::Readings) => format!("{count}*"),
    }
}

fn legend(table: &[Vec<String>]) -> Vec<String> {
    let marks = [
        ('–', "never seen from there"),
        ('!', "some steps never seen from there"),
        ('*', "fewer than from another station"),
    ];
    let has = |mark: char| {
        table[1..]
            .iter()
            .any(|row| row[2..].iter().any(|c| c.contains(mark)))
    };
    let found = marks.into_iter().filter(|&(mark, _)| has(mark));
    let found: Vec<String> = found.map(|(mark, says)| format!("{mark} {says}")).collect();
    if found.is_empty() {
        return Vec::new();
    }
    vec![format!("{INDENT}{}", found.join("; "))]
}
