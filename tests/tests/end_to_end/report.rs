//! The report in a real browser: headless Chromium, where there is one.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use trueaxis_calibrate::{Calibration, Settings, calibrate};
use trueaxis_diagnose::{Against, Cause, Fitted, FittedPoint, diagnose};
use trueaxis_predict::VolumeSettings;
use trueaxis_report::{Report, report};
use trueaxis_simulate::{Scenario, simulate};

/// What runs in each page: it says what is wrong with it.
const LOOK: &str = include_str!("report_look.js");

/// Widths of a desktop and of a phone, px; a third frame becomes paper.
const WIDTHS: [u32; 2] = [1280, 390];
const PAPER: u32 = 700;

/// The results of a five-axis machine with lost motion, whose name would run as script if it could.
fn results(folder: &Path) -> Calibration {
    let scenario = include_str!("../../../campaigns/five-axis/scenario.json");
    let mut campaign = simulate(&Scenario::from_json(scenario).unwrap(), 1)
        .unwrap()
        .campaign;
    campaign.name = "<script>document.title = 'taken'</script>".to_owned();
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    let diagnosis = diagnose(&campaign, &trueaxis_diagnose::Settings::default()).unwrap();
    shows_its_effect(&diagnosis.causes[0]);
    let machine = calibration.calibrated_machine();
    let volume = machine.volume(&VolumeSettings {
        points: 3,
        tool_home_mm: machine.reference_point_mm(),
        draws: 20,
        seed: 1,
    });
    let mut residuals = std::fs::File::create(folder.join("residuals.csv")).unwrap();
    calibration
        .write_residuals_csv(&campaign, &mut residuals)
        .unwrap();
    for (name, text) in [
        ("calibration.json", calibration.to_json()),
        ("diagnosis.json", diagnosis.to_json()),
        ("volume.json", volume.to_json(&machine)),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    calibration
}

/// The misfit without a cause follows what the fitted cause explains of it: its slope is 1 ± 0.15.
fn shows_its_effect(cause: &Cause) {
    let Fitted {
        against, points, ..
    } = cause.fitted.as_ref().unwrap();
    assert_eq!(*against, Against::Position("C".to_owned(), "deg"));
    assert!(
        [1, -1]
            .iter()
            .all(|side| points.iter().any(|p| p.direction == *side))
    );
    let sum = |f: fn(&FittedPoint) -> f64| points.iter().map(f).sum::<f64>();
    let slope = sum(|p| p.misfit * p.fitted) / sum(|p| p.fitted * p.fitted);
    assert!((slope - 1.0).abs() < 0.5, "{slope}");
}

/// Chromium, by `TRUEAXIS_CHROMIUM` or one of its usual names.
fn chromium() -> Option<PathBuf> {
    let named = std::env::var_os("TRUEAXIS_CHROMIUM").map(PathBuf::from);
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let usual = std::env::split_paths(&folders).flat_map(|folder| {
        ["chromium", "chromium-browser", "google-chrome"].map(|name| folder.join(name))
    });
    named.into_iter().chain(usual).find(|path| path.is_file())
}

/// What the browser makes of a page, and what it says to its console.
fn browse(browser: &Path, folder: &Path, page: &Path, options: &[&str]) -> (String, String) {
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
        ])
        .args([
            "--enable-logging=stderr",
            "--no-first-run",
            "--window-size=1400,900",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .args(options)
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    let console = stderr.lines().filter(|line| line.contains("CONSOLE"));
    let console: Vec<&str> = console.collect();
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        console.join("\n"),
    )
}

#[test]
fn a_page_in_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = results(folder.path());
    let Report { html, figures } = report(folder.path(), None).unwrap();
    let again = report(folder.path(), None).unwrap();
    assert!(
        again.html == html && again.figures == figures,
        "the same files, the same bytes"
    );
    // 4 MB at most, and nothing from a network.
    assert!(html.len() < 1_000_000, "{} bytes", html.len());
    for address in ["http:", "https:", "src=\"//", "@import", "url("] {
        assert!(!html.contains(address), "{address}");
    }
    // Six curves of each axis, the machine, residuals in time, by station, quantiles, over each axis, the split of the
    // misfit, misfits by place and of each cause.
    let axes = calibration.axes.len();
    let names: Vec<&str> = figures.iter().map(|(name, _)| name.as_str()).collect();
    assert!(
        figures.len() >= 6 * axes + 1 + 3 + axes + 2 + 2,
        "{names:?}"
    );

    let Some(browser) = chromium() else {
        println!("skipped: there is no Chromium (TRUEAXIS_CHROMIUM names one that is elsewhere)");
        return;
    };
    // The page in frames of both widths; what is found ends up in the page around them.
    let quoted = html.replace('&', "&amp;").replace('"', "&quot;");
    let frames = [WIDTHS[0], WIDTHS[1], PAPER].map(|width| {
        format!(
            "<iframe style=\"border:0;width:{width}px;height:2000px\" srcdoc=\"{quoted}\"></iframe>"
        )
    });
    let around = format!(
        "<!doctype html><meta charset=\"utf-8\"><body>{}<pre id=\"found\"></pre><script>{LOOK}</script>",
        frames.concat()
    );
    let page = folder.path().join("around.html");
    std::fs::write(&page, around).unwrap();
    let (dom, console) = browse(
        &browser,
        folder.path(),
        &page,
        &["--virtual-time-budget=5000", "--dump-dom"],
    );
    assert_eq!(console, "", "the console is silent");
    let found = dom
        .split("<pre id=\"found\">")
        .nth(1)
        .and_then(|rest| rest.split("</pre>").next());
    let found = found
        .unwrap_or_default()
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    let found: Value =
        serde_json::from_str(&found).unwrap_or_else(|_| panic!("no answer: {found:?}"));
    for (page, width) in found.as_array().unwrap().iter().zip(WIDTHS) {
        assert_eq!(page["width"], width);
        assert_eq!(page["figures"], figures.len(), "figures at {width} px");
        for what in ["overlaps", "outside", "wide"] {
            assert_eq!(page[what], Value::Array(Vec::new()), "{what} at {width} px");
        }
        assert_eq!(page["turns"], true, "the view turns at {width} px");
        assert_eq!(page["drawn"], true, "the view is drawn at {width} px");
        let hovered = page["hovered"].as_str().unwrap();
        assert!(
            hovered.contains("EXX = ") && hovered.contains('±'),
            "{hovered}"
        );
        assert_eq!(page["focused"], true, "a figure takes the keyboard");
        let pressed = page["pressed"].as_array().unwrap();
        let says_value = |said: &Value| said.as_str().unwrap().contains("EXX = ");
        assert!(pressed[..4].iter().all(says_value), "{pressed:?}");
        assert_eq!(pressed[2], pressed[0], "there and back");
        assert!(pressed[1] != pressed[0] && pressed[3] != pressed[1] && pressed[4] == "");
        assert!(
            !page["title"].as_str().unwrap().starts_with("taken"),
            "a name ran as script"
        );
    }

    // On paper every figure is whole on one sheet.
    let sheets = &found[WIDTHS.len()];
    assert_eq!(sheets["cut"], Value::Array(Vec::new()), "cut on paper");
    assert_eq!(sheets["figures"], figures.len(), "figures on paper");
    let page = folder.path().join("report.html");
    std::fs::write(&page, html).unwrap();
    let paper = folder.path().join("report.pdf");
    let print = format!("--print-to-pdf={}", paper.display());
    browse(
        &browser,
        folder.path(),
        &page,
        &["--no-pdf-header-footer", &print],
    );
    let paper = std::fs::read(paper).unwrap();
    assert!(paper.starts_with(b"%PDF"), "{} bytes", paper.len());
    // The printer breaks the page where the columns do.
    let page = b"/Type /Page\n";
    let printed = paper.windows(page.len()).filter(|part| part == page);
    assert_eq!(sheets["sheets"], printed.count(), "sheets of paper");
}
