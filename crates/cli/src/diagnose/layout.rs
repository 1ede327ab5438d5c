//! Lines of text with a label in front.

/// Columns that a line may take.
const WIDTH: usize = 100;

/// Columns of the label.
const LABEL: usize = 15;

/// A text behind its label, over as many lines as it takes.
pub(crate) fn labelled(label: &str, text: &str) -> Vec<String> {
    let mut lines = vec![format!("{:<LABEL$}", format!("  {label}"))];
    let mut empty = true;
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if !empty && line + 1 + word.chars().count() > WIDTH {
            lines.push(" ".repeat(LABEL));
            empty = true;
        }
        if let Some(line) = lines.last_mut() {
            if !empty {
                line.push(' ');
            }
            line.push_str(word);
        }
        empty = false;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_broken_between_words() {
        let text = "lost motion ".repeat(20);
        let lines = labelled("what", &text);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| line.chars().count() <= WIDTH));
        assert!(lines[0].starts_with("  what         lost"));
        assert!(lines[1].starts_with("               "));
    }
}
