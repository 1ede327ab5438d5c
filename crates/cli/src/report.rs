//! `trueaxis report`, and the report that other verbs write.

use std::path::{Path, PathBuf};

use trueaxis_report::{Report, Settings, report};

use crate::args::ReportArgs;
use crate::codes::of_reading;
use crate::exit::Exit;
use crate::output;
use crate::talk::{notice, say};

pub(crate) fn run(args: &ReportArgs) -> anyhow::Result<Exit> {
    let template = args.template.as_deref().map(read_template).transpose()?;
    let made = report(&args.folder, &Settings { template })?;
    let page = write(&args.folder, &made)?;
    let figures = output::folder(Some(&args.folder.join(Report::FIGURES)), "")?;
    for (name, svg) in &made.figures {
        output::write(&figures.join(name), svg.as_bytes())?;
    }
    for path in [page, figures] {
        say(&format!("written: {}", path.display()));
    }
    Ok(Exit::Good)
}

fn read_template(file: &Path) -> Result<String, TemplateUnreadable> {
    std::fs::read_to_string(file).map_err(|source| TemplateUnreadable {
        file: file.to_path_buf(),
        source,
    })
}

/// A template that cannot be read.
#[derive(Debug)]
pub(crate) struct TemplateUnreadable {
    file: PathBuf,
    source: std::io::Error,
}

impl TemplateUnreadable {
    /// The code of the error.
    pub(crate) fn code(&self) -> &'static str {
        of_reading(&self.source)
    }
}

impl std::fmt::Display for TemplateUnreadable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let file = self.file.display();
        write!(
            f,
            "the template {file} cannot be read; give its path to --template"
        )
    }
}

impl std::error::Error for TemplateUnreadable {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// Writes the page of the results in `folder`, and says where; `None` where another file there, as of an earlier
/// version, does not let it, which is no reason to fail. Its figures are in it; as files, dozens of them, they would
/// take longer than all the rest.
pub(crate) fn of_results(folder: &Path) -> anyhow::Result<Option<PathBuf>> {
    match report(folder, &Settings::default()) {
        Ok(made) => write(folder, &made).map(Some),
        Err(reason) => {
            notice(&format!("no {} was written: {reason}", Report::FILE));
            Ok(None)
        }
    }
}

fn write(folder: &Path, made: &Report) -> anyhow::Result<PathBuf> {
    let page = folder.join(Report::FILE);
    output::write(&page, made.html.as_bytes())?;
    Ok(page)
}
