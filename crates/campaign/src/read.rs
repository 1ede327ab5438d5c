//! Reading: from the files of a campaign to the checked [`Campaign`].

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use trueaxis_files::check_names;

use crate::document::{Document, FORMAT, VerificationEntry};
use crate::reading::Reading;
use crate::steps::Steps;
use crate::{
    Campaign, Error, Place, Problem, Stop, date, duplicates, expansion, known_lengths, lengths,
    near_positions, notices, plausibility, point_checks, points, run_axes, setup, text_file,
    verification,
};

/// Reads the campaign at `path` (its `campaign.json`) with every file that it names, and checks all of it.
///
/// Names of files are relative to the folder of `path`. What is unusual but allowed is put into [`Campaign::notices`].
///
/// # Errors
/// The first thing wrong: where it is, what was found, what is expected and how to correct it
/// ([`Error`]). `campaign.json` is checked first, then each row of the data, then rows against
/// each other, then the data against the motion of the machine, then the verifications.
pub fn read(path: &Path) -> Result<Campaign, Error> {
    read_from(path, &from_disk, true)
}

/// [`read`] for those who ask why lengths are not those of the machine: they are not compared with its motion.
///
/// # Errors
/// Those of [`read`], but none that the motion of the machine causes.
pub fn read_uncompared(path: &Path) -> Result<Campaign, Error> {
    read_from(path, &from_disk, false)
}

fn from_disk<'t>(file: &Path, hint: &str) -> Result<Cow<'t, str>, Error> {
    text_file::read(file, hint).map(Cow::Owned)
}

/// Gives the text of a file, or an error that ends in the advice of the second argument.
pub(crate) type TextOf<'t> = dyn Fn(&Path, &str) -> Result<Cow<'t, str>, Error> + 't;

/// [`read`] for texts from anywhere; lengths are compared with the motion of the machine if asked for.
pub(crate) fn read_from(
    path: &Path,
    text_of: &TextOf<'_>,
    is_compared: bool,
) -> Result<Campaign, Error> {
    let text = text_of(path, "give the path of a campaign.json")?;
    let mut document: Document = FORMAT.read(&text, Some(path))?;
    let sources = (document.lengths.take(), document.points.take());
    let verification = std::mem::take(&mut document.verification);
    let mut campaign = without_data(document).map_err(|error| error.in_file(path))?;
    let folder = Folder {
        path,
        text_of,
        is_compared,
    };
    match sources {
        (Some(_), Some(_)) => Err(Problem::TwoMeasurements.at(Place::field(path, "points"))),
        (Some(name), None) => folder.read_lengths(&name, &mut campaign),
        (None, Some(name)) => folder.read_points(&name, &mut campaign),
        (None, None) if verification.is_empty() => {
            Err(Problem::NothingMeasured.at(Place::file(path)))
        }
        (None, None) => Ok(()),
    }?;
    folder.read_verification(verification, &mut campaign)?;
    Ok(campaign)
}

/// Everything that `campaign.json` itself says.
fn without_data(document: Document) -> Result<Campaign, Error> {
    date::check(document.date.as_deref())?;
    let machine = document.machine.build()?;
    let instrument = document.instrument.unwrap_or_default();
    setup::check_instrument(&instrument)?;
    let targets = setup::targets(document.targets, &machine)?;
    let notices = notices::similar_reflectors(&targets);
    Ok(Campaign {
        name: document.name,
        date: document.date,
        operator: document.operator,
        expansions: document.machine.expansions()?,
        machine_name: document.machine.name,
        instrument,
        known_lengths: known_lengths::from_entries(&document.known_lengths, &targets)?,
        targets,
        stations: setup::stations(document.stations)?,
        runs: setup::runs(document.runs, &machine)?,
        machine,

        steps: Vec::new(),
        lengths: None,
        points: None,
        verification: Vec::new(),
        point_checks: Vec::new(),
        notices,
    })
}

/// The campaign's other files.
struct Folder<'f, 't> {
    /// `campaign.json`.
    path: &'f Path,
    text_of: &'f TextOf<'t>,
    is_compared: bool,
}

impl<'t> Folder<'_, 't> {
    fn read_lengths(&self, name: &str, campaign: &mut Campaign) -> Result<(), Error> {
        self.check_lists(campaign, "lengths")?;
        let (file, text) = self.text(name, "lengths")?;
        let (lengths, steps) = lengths::read(&file, &text, campaign)?;
        expansion::check_columns(name, &campaign.expansions, &lengths)
            .map_err(|error| error.in_file(self.path))?;
        let table = (file.as_path(), name, &*text);
        let rows = (&lengths.stops[..], &lengths.readings[..]);
        check_rows(table, campaign, rows, steps, |campaign| {
            match self.is_compared {
                true => plausibility::check_lengths(&file, name, campaign, &lengths),
                false => Ok(Vec::new()),
            }
        })?;
        campaign.lengths = Some(lengths);
        Ok(())
    }

    fn read_points(&self, name: &str, campaign: &mut Campaign) -> Result<(), Error> {
        self.check_lists(campaign, "points")?;
        let (file, text) = self.text(name, "points")?;
        let (points, steps) = points::read(&file, &text, campaign)?;
        let table = (file.as_path(), name, &*text);
        let rows = (&points.stops[..], &points.readings[..]);
        check_rows(table, campaign, rows, steps, |campaign| {
            plausibility::check_points(&file, name, campaign, &points)
        })?;
        campaign.points = Some(points);
        Ok(())
    }

    fn read_verification(
        &self,
        entries: Vec<VerificationEntry>,
        campaign: &mut Campaign,
    ) -> Result<(), Error> {
        let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        check_names("verification", "verification", &names).map_err(|e| e.in_file(self.path))?;
        for (index, entry) in entries.into_iter().enumerate() {
            let machine = &campaign.machine;
            let declared = verification::declared(index, &entry, machine);
            let declared = declared.map_err(|e| e.in_file(self.path))?;
            let field = format!("verification[{index}].readings");
            let (file, text) = self.text(&entry.readings, &field)?;
            let name = &entry.readings;
            let clock = if let Some(declared) = declared {
                let read = verification::read(&file, &text, declared, machine)?;
                let timed = read.readings.iter().map(|r| Some((r.time_s?, r.line)));
                let clock = notices::clock_going_back(name, timed.flatten());
                campaign.verification.push(read);
                clock
            } else {
                let read = point_checks::read(&file, &text, &entry, machine)?;
                let timed = read.readings.iter().map(|r| Some((r.time_s?, r.line)));
                let clock = notices::clock_going_back(name, timed.flatten());
                campaign.point_checks.push(read);
                clock
            };
            let cut = notices::without_line_end(name, &text);
            campaign.notices.extend(clock.into_iter().chain(cut));
        }
        Ok(())
    }

    /// Refuses a table without the lists of `campaign.json` that it refers to.
    fn check_lists(&self, campaign: &Campaign, needed_by: &'static str) -> Result<(), Error> {
        let without_stations = needed_by == "lengths" && campaign.stations.is_empty();
        let lists = [
            ("stations", without_stations),
            ("targets", campaign.targets.is_empty()),
            ("runs", campaign.runs.is_empty()),
        ];
        lists.iter().find(|list| list.1).map_or(Ok(()), |list| {
            Err(Problem::EmptyList { needed_by }.at(Place::field(self.path, list.0)))
        })
    }

    /// The file that `field` of `campaign.json` names: its path and its text.
    fn text(&self, name: &str, field: &str) -> Result<(PathBuf, Cow<'t, str>), Error> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = folder.join(name);
        let hint = format!(
            "{}, field {field}, names it; names of files are relative to that file",
            self.path.display()
        );
        let text = (self.text_of)(&file, &hint)?;
        Ok((file, text))
    }
}

/// Checks the rows of a table (its file, name and text) against each other and then, by `against_machine`, against the motion
/// of the machine; puts the steps and what is unusual into the campaign.
fn check_rows<R: Reading>(
    (file, name, text): (&Path, &str, &str),
    campaign: &mut Campaign,
    (stops, readings): (&[Stop], &[R]),
    steps: Steps,
    against_machine: impl FnOnce(&Campaign) -> Result<Vec<String>, Error>,
) -> Result<(), Error> {
    duplicates::check(file, stops, readings, &campaign.targets)?;
    let mut found = plausibility::check_order(file, name, stops, readings)?;
    near_positions::check(file, campaign, (stops, readings), &steps)?;
    run_axes::check(file, campaign, &steps)?;
    campaign.steps = steps.steps;
    found.extend(notices::without_rows(name, campaign, stops, readings));
    found.extend(against_machine(campaign)?);
    let copies = plausibility::check_copies(file, name, campaign, stops, readings)?;
    let cut = notices::without_line_end(name, text);
    found.extend(copies.into_iter().chain(cut));
    campaign.notices.extend(found);
    Ok(())
}
