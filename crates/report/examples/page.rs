//! `cargo run -p trueaxis-report --example page -- DIR` makes DIR/report.html of the results in DIR.

use std::path::PathBuf;

use trueaxis_report::{Report, Settings, report};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(
        std::env::args_os()
            .nth(1)
            .ok_or("give a folder of results")?,
    );
    let report = report(&folder, &Settings::default())?;
    std::fs::write(folder.join(Report::FILE), report.html)?;
    Ok(())
}
