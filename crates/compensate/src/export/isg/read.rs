//! Reading `ISG_CSV`.

use crate::Error;
use crate::export::named_errors::NamedErrors;

/// Zero position and orientation of the tool: kinematics of the control, no errors.
const OF_THE_TOOL: [&str; 6] = ["P0X", "P0Y", "P0Z", "N0X", "N0Y", "N0Z"];

/// Of an axis in a header: an argument.
const ARGUMENTS: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// The names above a block.
struct Header {
    line: usize,
    names: Vec<String>,
    /// Place of the argument.
    argument: Option<usize>,
    rows: usize,
}

pub(crate) fn read(file: &str, text: &str) -> Result<NamedErrors, Error> {
    let mut read = NamedErrors::new(file);
    let mut header: Option<Header> = None;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = line.split("//").next().unwrap_or_default().trim();
        if content.starts_with('#') {
            check_end(&read, header.take())?;
        } else if !content.is_empty() {
            let cells: Vec<&str> = content.split_whitespace().collect();
            match &mut header {
                None => header = Some(begun(&mut read, number, &cells)?),
                Some(header) => row(&mut read, number, content, &cells, header)?,
            }
        }
    }
    check_end(&read, header)?;
    Ok(read)
}

fn begun(read: &mut NamedErrors, number: usize, cells: &[&str]) -> Result<Header, Error> {
    let content = cells.join(" ");
    let is_name = |cell: &&str| {
        let is_plain = cell.chars().all(|c| c.is_ascii_alphanumeric());
        is_plain && cell.parse::<f64>().is_err()
    };
    if !cells.iter().all(is_name) {
        let expected = "the names of errors above their values, as `X EXX EYX`";
        return Err(read.wrong(number, &content, expected));
    }
    if cells.iter().filter(|c| ARGUMENTS.contains(c)).count() > 1 {
        let expected =
            "one axis that the errors depend on: a calibration has errors of one axis each";
        return Err(read.wrong(number, &content, expected));
    }
    let argument = cells.iter().position(|cell| ARGUMENTS.contains(cell));
    for (place, name) in cells.iter().enumerate() {
        let Some(of) = argument.filter(|&of| of != place) else {
            continue;
        };
        if !(name.starts_with('E') && name.ends_with(cells[of])) {
            let expected = format!("component errors of {0}, as EX{0}", cells[of]);
            return Err(read.wrong(number, name, expected));
        }
        read.add_curve(number, name)?;
    }
    Ok(Header {
        line: number,
        names: cells.iter().map(|cell| (*cell).to_owned()).collect(),
        argument,
        rows: 0,
    })
}

fn row(
    read: &mut NamedErrors,
    number: usize,
    content: &str,
    cells: &[&str],
    header: &mut Header,
) -> Result<(), Error> {
    if cells.len() != header.names.len() {
        let expected = format!(
            "{} numbers, one for each name of line {}; the file may be cut off",
            header.names.len(),
            header.line
        );
        return Err(read.wrong(number, content, expected));
    }
    let values = cells.iter().map(|cell| read.number(number, cell));
    let values = values.collect::<Result<Vec<f64>, Error>>()?;
    header.rows += 1;
    if header.argument.is_none() && header.rows > 1 {
        let expected = "one row of values that depend on nothing, then `#` and the next names";
        return Err(read.wrong(number, content, expected));
    }
    for (place, (name, &value)) in header.names.iter().zip(&values).enumerate() {
        match header.argument {
            None if OF_THE_TOOL.contains(&name.as_str()) => {}
            None => read.add_constant(number, name, value)?,
            Some(of) if of == place => {}
            Some(of) => read.add_point(number, name, (values[of], value))?,
        }
    }
    Ok(())
}

/// Names have values below them.
fn check_end(read: &NamedErrors, header: Option<Header>) -> Result<(), Error> {
    let empty = header.filter(|header| header.rows == 0);
    empty.map_or(Ok(()), |header| {
        let expected = "values below these names; the file may be cut off";
        Err(read.wrong(header.line, &header.names.join(" "), expected))
    })
}
