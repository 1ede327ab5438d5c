//! A page from the files of a folder.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use trueaxis_report::{Report, report};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    // What `trueaxis diagnose` writes of a campaign in which nothing is wrong.
    let diagnosis = r#"{ "format": "trueaxis-diagnosis", "version": 1, "campaign": "FXYZ machine", "verdict": "clean" }"#;
    std::fs::write(folder.path().join("diagnosis.json"), diagnosis)?;

    let report = report(folder.path(), None)?;
    assert!(
        report
            .html
            .contains("nothing in the data contradicts the rigid machine model")
    );
    println!("a page of {} kB", report.html.len() / 1000);
    std::fs::write(folder.path().join(Report::FILE), report.html)?;
    Ok(())
}
