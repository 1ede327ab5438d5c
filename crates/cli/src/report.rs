//! `trueaxis report`, and the report that other verbs write.

use std::path::{Path, PathBuf};

use trueaxis_report::{Report, report};

use crate::args::ReportArgs;
use crate::exit::Exit;
use crate::given_file::{Unreadable, read_text};
use crate::output;
use crate::talk::{notice, say};

pub(crate) fn execute(args: &ReportArgs) -> anyhow::Result<Exit> {
    let wanted = "report wants the folder that `calibrate` and other verbs wrote";
    std::fs::metadata(&args.folder).map_err(Unreadable::at(&args.folder, wanted))?;
    let wanted = "--template wants a template of a report";
    let template = args.template.as_deref();
    let template = template.map(|file| read_text(file, wanted)).transpose()?;
    let made = report(&args.folder, template.as_deref())?;
    let page = write(&args.folder, &made)?;
    let figures = output::folder(Some(&args.folder.join(Report::FIGURES)), "")?;
    for (name, svg) in &made.figures {
        output::write_derived(&figures.join(name), svg.as_bytes())?;
    }
    for path in [page, figures] {
        say(&format!("written: {}", path.display()));
    }
    Ok(Exit::Good)
}

/// Writes the page of the results in `folder`, and says where; `None` where another file there, as of an earlier
/// version, does not let it, which is no reason to fail. Its figures are in it; as files, dozens of them, they would
/// take longer than all the rest.
pub(crate) fn of_results(folder: &Path) -> anyhow::Result<Option<PathBuf>> {
    match report(folder, None) {
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
