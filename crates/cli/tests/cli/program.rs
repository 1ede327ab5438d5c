//! Runs the program, with a limit of time.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A run takes a tenth of a second; one that takes so long does not end at all.
const TIME_LIMIT: Duration = Duration::from_secs(120);

const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// How the program ended and what it said.
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs `trueaxis` with `args` in the folder `current`.
pub(crate) fn run(current: &Path, args: &[&str]) -> Outcome {
    run_with_environment(current, args, &[])
}

/// [`run`] with the words of a line, in which `@fxyz` is the file of the shipped campaign `fxyz`.
pub(crate) fn run_line(current: &Path, line: &str) -> Outcome {
    let words = line.split(' ').map(|word| match word.strip_prefix('@') {
        Some(name) => shipped(name).join("campaign.json").display().to_string(),
        None => word.to_owned(),
    });
    let words: Vec<String> = words.collect();
    run(
        current,
        &words.iter().map(String::as_str).collect::<Vec<_>>(),
    )
}

/// [`run`] with additional environment variables.
pub(crate) fn run_with_environment(
    current: &Path,
    args: &[&str],
    environment: &[(&str, &str)],
) -> Outcome {
    let mut child = Command::new(env!("CARGO_BIN_EXE_trueaxis"))
        .args(args)
        .envs(environment.iter().copied())
        .current_dir(current)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Read while it runs: a full pipe would stop it.
    let stdout = read_all(child.stdout.take().unwrap());
    let stderr = read_all(child.stderr.take().unwrap());
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > TIME_LIMIT {
            child.kill().unwrap();
            panic!("trueaxis {} does not end", args.join(" "));
        }
        thread::sleep(POLL_INTERVAL);
    };
    Outcome {
        code: status.code(),
        stdout: stdout.join().unwrap(),
        stderr: stderr.join().unwrap(),
    }
}

fn read_all(mut pipe: impl Read + Send + 'static) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut text = String::new();
        pipe.read_to_string(&mut text).unwrap();
        text
    })
}

impl Outcome {
    /// The run ended well.
    #[track_caller]
    pub(crate) fn assert_good(&self) {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
    }

    /// The run ended with `code`, without data on standard output and without a bug of its own. What it must say are
    /// parts of the message, with ` … ` between them.
    #[track_caller]
    pub(crate) fn assert_failed(&self, name: &str, code: i32, says: &str) {
        let stderr = &self.stderr;
        assert_eq!(self.code, Some(code), "{name}: {stderr}");
        assert_eq!(self.stdout, "", "{name}: data on standard output");
        for bug in ["panicked", "internal error", "NaN"] {
            let is_quoted = stderr.contains(&format!("\"{bug}\""));
            assert!(is_quoted || !stderr.contains(bug), "{name}: {stderr}");
        }
        for part in says.split(" … ") {
            assert!(stderr.contains(part), "{name}: no `{part}` in: {stderr}");
        }
    }
}

/// A campaign that the repository ships.
pub(crate) fn shipped(campaign: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../campaigns")
        .join(campaign)
}

/// Calibrates a shipped campaign into the folder `calibrated` in `current`.
#[track_caller]
pub(crate) fn calibrate_shipped(current: &Path, campaign: &str) {
    run_line(current, &format!("calibrate @{campaign} --out calibrated")).assert_good();
}

/// All files below a folder with their bytes, by path.
pub(crate) fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(contents(&path));
        } else {
            let bytes = fs::read(&path).unwrap();
            files.push((path, bytes));
        }
    }
    files.sort();
    files
}

/// The names of [`contents`], relative to the folder.
pub(crate) fn file_names(folder: &Path) -> Vec<String> {
    let name = |path: PathBuf| path.strip_prefix(folder).unwrap().display().to_string();
    contents(folder)
        .into_iter()
        .map(|(path, _)| name(path))
        .collect()
}
