//! `trueaxis report`, and the report that other verbs write.

use std::path::{Path, PathBuf};

use anyhow::Context;
use trueaxis_report::{Report, Settings, report};

use crate::args::ReportArgs;
use crate::exit::Exit;
use crate::output;
use crate::talk::say;

pub(crate) fn run(args: &ReportArgs) -> anyhow::Result<Exit> {
    let template = match &args.template {
        Some(file) => {
            let text = std::fs::read_to_string(file);
            Some(text.with_context(|| format!("the template {} cannot be read", file.display()))?)
        }
        None => None,
    };
    let made = report(&args.folder, &Settings { template })?;
    for path in write(&args.folder, &made)? {
        say(&format!("written: {}", path.display()));
    }
    Ok(Exit::Good)
}

/// Writes the report of the results in `folder`, and says where.
pub(crate) fn of_results(folder: &Path) -> anyhow::Result<PathBuf> {
    let made = report(folder, &Settings::default())?;
    let mut written = write(folder, &made)?;
    Ok(written.swap_remove(0))
}

/// The page, then the folder of its figures.
fn write(folder: &Path, made: &Report) -> anyhow::Result<Vec<PathBuf>> {
    let page = folder.join(Report::FILE);
    output::write(&page, made.html.as_bytes())?;
    let figures = output::folder(Some(&folder.join(Report::FIGURES)), "")?;
    for (name, svg) in &made.figures {
        output::write(&figures.join(name), svg.as_bytes())?;
    }
    Ok(vec![page, figures])
}
