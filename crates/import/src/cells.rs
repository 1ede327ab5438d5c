//! From a line to its cells.

/// The cells of a line without the blanks around them. Text in double quotes is one cell, two quotes in it are one.
/// A blank as separator stands for any number of blanks and tabs.
pub(crate) fn cells(line: &str, separator: char) -> Vec<String> {
    let blanks = separator == ' ';
    let mut cells = Vec::new();
    let mut rest = line.trim_matches(|c: char| c.is_whitespace() && (blanks || c != separator));
    loop {
        let (cell, behind) = match rest.strip_prefix('"').and_then(quoted) {
            Some(quoted) => quoted,
            None => {
                let end = rest.find(|c| is_separator(c, separator));
                let (cell, behind) = rest.split_at(end.unwrap_or(rest.len()));
                (cell.trim().to_owned(), behind)
            }
        };
        cells.push(cell);
        let Some(at) = behind.find(|c| is_separator(c, separator)) else {
            return cells;
        };
        // The separator is one byte: a sign of ASCII.
        rest = behind[at + 1..]
            .trim_start_matches(|c: char| c.is_whitespace() && (blanks || c != separator));
    }
}

fn is_separator(c: char, separator: char) -> bool {
    c == separator || separator == ' ' && c == '\t'
}

/// The text up to the closing quote, and what comes behind it; none if nothing closes.
fn quoted(text: &str) -> Option<(String, &str)> {
    let mut cell = String::new();
    let mut rest = text;
    loop {
        let (before, behind) = rest.split_once('"')?;
        cell.push_str(before);
        match behind.strip_prefix('"') {
            Some(after) => {
                cell.push('"');
                rest = after;
            }
            None => return Some((cell, behind)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_quotes_and_blanks() {
        assert_eq!(cells(" a ;; \"b;\"\"c\" ; ", ';'), ["a", "", "b;\"c", ""]);
        assert_eq!(cells("a\t\tb\t", '\t'), ["a", "", "b", ""]);
        assert_eq!(cells("  a \t b  \"c d\" e ", ' '), ["a", "b", "c d", "e"]);
        assert_eq!(cells("12\" bore,5", ','), ["12\" bore", "5"]);
        assert_eq!(cells("\"open,5", ','), ["\"open", "5"]);
        assert_eq!(cells("", ','), [""]);
    }
}
