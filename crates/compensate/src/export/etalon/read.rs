//! Reading the exchange format of Etalon.

use crate::Error;
use crate::export::named_errors::NamedErrors;

/// Where in the file a line is.
enum State {
    /// Before the first section, or behind a whole one.
    Outside,
    /// Behind `[EXX]`.
    Named(usize, String),
    /// Behind `Gridpoints = {`.
    Points(usize, String),
}

pub(crate) fn read(file: &str, text: &str) -> Result<NamedErrors, Error> {
    let mut read = NamedErrors::new(file);
    let mut state = State::Outside;
    let mut last = 1;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = line.split("//").next().unwrap_or_default().trim();
        if !content.is_empty() {
            last = number;
            state = next(&mut read, number, content, state)?;
        }
    }
    match state {
        State::Outside => Ok(read),
        State::Named(line, name) | State::Points(line, name) => {
            let expected =
                format!("the end of [{name}], begun in line {line}: the file is cut off");
            Err(read.wrong(last, "the end of the file", expected))
        }
    }
}

fn next(
    read: &mut NamedErrors,
    number: usize,
    content: &str,
    state: State,
) -> Result<State, Error> {
    match state {
        State::Outside => {
            let name = content.strip_prefix('[').and_then(|c| c.strip_suffix(']'));
            let name = name.map(str::trim).filter(|name| !name.is_empty());
            let name =
                name.ok_or_else(|| read.wrong(number, content, "[EXX], the name of an error"))?;
            Ok(State::Named(number, name.to_owned()))
        }
        State::Named(line, name) => {
            let parts = content.split_once('=');
            match parts.map(|(key, value)| (key.trim(), value.trim())) {
                Some(("VALUE", value)) => {
                    let value = read.number(number, value)?;
                    read.add_constant(number, &name, value)?;
                    Ok(State::Outside)
                }
                Some(("Gridpoints", "{")) => {
                    read.add_curve(number, &name)?;
                    Ok(State::Points(line, name))
                }
                _ => {
                    let expected = format!("`VALUE = ` or `Gridpoints = {{` of [{name}]");
                    Err(read.wrong(number, content, expected))
                }
            }
        }
        State::Points(..) if content == "}" => Ok(State::Outside),
        State::Points(line, name) => {
            let cells: Vec<&str> = content.split_whitespace().collect();
            let &[argument, value] = cells.as_slice() else {
                let expected = format!("argument and value of [{name}], or `}}` at its end");
                return Err(read.wrong(number, content, expected));
            };
            let point = (read.number(number, argument)?, read.number(number, value)?);
            read.add_point(number, &name, point)?;
            Ok(State::Points(line, name))
        }
    }
}
