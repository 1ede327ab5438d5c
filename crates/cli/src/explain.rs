//! `trueaxis explain`.

use crate::args::ExplainArgs;
use crate::exit::Exit;
use crate::output;
use crate::talk::say_always;

/// A section for each code: `## E001 title`, what it means, an example, what to do.
const TEXT: &str = include_str!("explain/codes.md");

/// What is told of a code.
pub(crate) struct Entry {
    pub(crate) code: &'static str,
    title: &'static str,
    text: &'static str,
}

/// All codes in the order of the text.
pub(crate) fn entries() -> impl Iterator<Item = Entry> {
    let sections = TEXT.split("\n## ").skip(1);
    sections.filter_map(|section| {
        let (heading, text) = section.split_once('\n')?;
        let (code, title) = heading.split_once(' ')?;
        // What comes behind a heading of a higher level belongs to the next group.
        let text = text.split("\n# ").next()?.trim();
        Some(Entry { code, title, text })
    })
}

/// What is told of a code.
pub(crate) fn help(code: &str) -> Option<&'static str> {
    let entry = entries().find(|entry| entry.code == code);
    entry.map(|entry| entry.text)
}

pub(crate) fn execute(args: &ExplainArgs) -> anyhow::Result<Exit> {
    let Some(code) = &args.code else {
        let list = entries().map(|entry| format!("{}  {}\n", entry.code, entry.title));
        output::print(&list.collect::<String>())?;
        return Ok(Exit::Good);
    };
    let wanted = code.to_uppercase();
    let entry = entries()
        .find(|entry| entry.code.trim_start_matches('E') == wanted.trim_start_matches('E'));
    let Some(Entry { code, title, text }) = entry else {
        say_always(&format!(
            "error: there is no code {code}; codes are E and three digits, `trueaxis explain` lists them"
        ));
        return Ok(Exit::Usage);
    };
    output::print(&format!("{code}: {title}\n\n{text}\n"))?;
    Ok(Exit::Good)
}
