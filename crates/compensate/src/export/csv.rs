//! Old tables as CSV: a header, and rows of as many numbers.

use crate::Error;
use crate::export::ExportedFile;
use crate::export::named_errors::wrong;

/// The names in the first line.
pub(crate) fn header(file: &ExportedFile) -> Vec<&str> {
    let first = file.text.lines().next().unwrap_or_default();
    first.split(',').map(str::trim).collect()
}

/// The other lines, `width` numbers in each; row `k` is line `k + 2`.
pub(crate) fn rows(file: &ExportedFile, width: usize) -> Result<Vec<Vec<f64>>, Error> {
    let lines = (1..).zip(file.text.lines()).skip(1);
    let row = |(number, line): (usize, &str)| {
        let cells = line.split(',').map(|cell| cell.trim().parse().ok());
        let cells: Option<Vec<f64>> = cells.collect();
        let is_whole = |c: &Vec<f64>| c.len() == width && c.iter().all(|x| x.is_finite());
        cells.filter(is_whole).ok_or_else(|| {
            let expected = format!("{width} numbers, as in the header");
            wrong(&file.name, number, line, expected)
        })
    };
    lines.map(row).collect()
}
