//! Writing: from a [`Campaign`] to the files that [`crate::read()`] reads.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use crate::document::{Document, FORMAT};
use crate::read::read_from;
use crate::{
    Campaign, Error, Instrument, Place, Problem, known_lengths, lengths, point_checks, points,
    setup, verification,
};

const CAMPAIGN_FILE: &str = "campaign.json";
const LENGTHS_FILE: &str = "lengths.csv";
const POINTS_FILE: &str = "points.csv";

/// Writes `campaign` into `folder`, which is made if it is not there, and returns the path of its `campaign.json`.
///
/// Only what [`crate::read()`] accepts is written: the texts are read back before a file is touched. Each file is whole or not
/// there: it is written under a temporary name and renamed, the tables first and `campaign.json` last.
///
/// `read` gives the same campaign again, with the same bits in every number, if
///
/// - lengths have at most 7 decimals (1e-7 mm) and times at most 3 (1 ms): more are rounded off, to
///   keep the file of a large campaign small. `(x * 1e7).round() / 1e7` is on that grid;
/// - rotary positions are degrees of at most 15 digits, as all that were read are (others may come
///   back one unit in the last place away);
/// - the reference points of linear axes are the origin: the file has no place for them;
/// - steps are numbered as they first appear, lines of readings count on from 2, and the notices
///   are those that `read` makes.
///
/// # Errors
/// [`Problem::Unwritable`] if the operating system refuses, [`Problem::Inconsistent`] if the stops do
/// not cover the readings, and otherwise what `read` would say to the files.
pub fn write(campaign: &Campaign, folder: &Path) -> Result<PathBuf, Error> {
    let path = folder.join(CAMPAIGN_FILE);
    let files = texts(campaign, folder)?;
    check(campaign, &path, &files)?;
    fs::create_dir_all(folder)
        .map_err(|source| Problem::Unwritable { source }.at(Place::file(folder)))?;
    for (file, text) in &files {
        trueaxis_files::write_whole(file, text.as_bytes())
            .map_err(|source| Problem::Unwritable { source }.at(Place::file(file)))?;
    }
    Ok(path)
}

/// All files of the campaign and their texts, `campaign.json` last.
fn texts(campaign: &Campaign, folder: &Path) -> Result<Vec<(PathBuf, String)>, Error> {
    let mut document = document(campaign);
    let mut files = Vec::new();
    if let Some(lengths) = &campaign.lengths {
        files.push((folder.join(LENGTHS_FILE), lengths::text(campaign, lengths)));
        document.lengths = Some(LENGTHS_FILE.to_owned());
    }
    if let Some(points) = &campaign.points {
        files.push((folder.join(POINTS_FILE), points::text(campaign, points)));
        document.points = Some(POINTS_FILE.to_owned());
    }
    for (index, verification) in campaign.verification.iter().enumerate() {
        let name = format!("verification_{}.csv", index + 1);
        let machine = &campaign.machine;
        files.push((
            folder.join(&name),
            verification::text(verification, machine),
        ));
        let entry = verification::to_entry(verification, machine, name);
        document.verification.push(entry);
    }
    for (index, check) in campaign.point_checks.iter().enumerate() {
        let name = format!("point_check_{}.csv", index + 1);
        let text = point_checks::text(check, &campaign.machine);
        files.push((folder.join(&name), text));
        document
            .verification
            .push(point_checks::to_entry(check, name));
    }
    let json = trueaxis_files::to_json(&document).map_err(|error| {
        Problem::Inconsistent {
            problem: error.to_string(),
        }
        .at(Place::file(folder))
    })?;
    files.push((folder.join(CAMPAIGN_FILE), json));
    Ok(files)
}

/// Reads the texts back, and refuses those that hold less than the campaign.
fn check(campaign: &Campaign, path: &Path, files: &[(PathBuf, String)]) -> Result<(), Error> {
    let text_of = |file: &Path, _: &str| {
        let text = files.iter().find(|(name, _)| name == file);
        Ok(text.map_or(Cow::Borrowed(""), |(_, text)| Cow::Borrowed(text.as_str())))
    };
    let read_back = read_from(path, &text_of, true)?;
    let rows = |campaign: &Campaign| {
        let lengths = campaign.lengths.as_ref().map(|l| l.readings.len());
        let points = campaign.points.as_ref().map(|p| p.readings.len());
        (lengths, points)
    };
    if rows(campaign) != rows(&read_back) {
        return Err(Problem::Inconsistent {
            problem: "its stops do not cover its readings".to_owned(),
        }
        .at(Place::file(path)));
    }
    Ok(())
}

/// `campaign.json` without the names of other files.
fn document(campaign: &Campaign) -> Document {
    let machine = &campaign.machine;
    Document {
        format: FORMAT.name.to_owned(),
        version: FORMAT.version,
        name: campaign.name.clone(),
        date: campaign.date.clone(),
        operator: campaign.operator.clone(),
        machine: campaign.machine_spec(),
        instrument: (campaign.instrument != Instrument::default())
            .then(|| campaign.instrument.clone()),
        targets: setup::targets_to_entries(&campaign.targets, machine),
        stations: setup::stations_to_entries(&campaign.stations),
        known_lengths: known_lengths::to_entries(&campaign.known_lengths, &campaign.targets),
        runs: setup::runs_to_entries(&campaign.runs, machine),
        lengths: None,
        points: None,
        verification: Vec::new(),
    }
}
