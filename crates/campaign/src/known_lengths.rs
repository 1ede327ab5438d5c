//! `known_lengths` of `campaign.json`: calibrated distances between two targets.

use trueaxis_files::{DocumentError, DocumentProblem, index_of};

use crate::document::KnownLengthEntry;
use crate::{KnownLength, Target};

/// How far the nominal positions of two targets may be from their known distance: this part of it, and
/// [`MOUNTING_SLACK_MM`]. More is another unit, or another pair of targets.
const NOMINAL_PART: f64 = 0.2;

/// Targets are mounted by hand, mm.
const MOUNTING_SLACK_MM: f64 = 10.0;

/// The known lengths, with their targets looked up.
pub(crate) fn from_entries(
    entries: &[KnownLengthEntry],
    targets: &[Target],
) -> Result<Vec<KnownLength>, DocumentError> {
    let known = entries.iter().enumerate();
    known
        .map(|(i, entry)| from_entry(&format!("known_lengths[{i}]"), entry, targets))
        .collect()
}

fn from_entry(
    path: &str,
    entry: &KnownLengthEntry,
    targets: &[Target],
) -> Result<KnownLength, DocumentError> {
    let refused = |field: &str, found: String, expected: &str| {
        let problem = DocumentProblem::value(found, expected);
        Err(problem.in_field(format!("{path}.{field}")))
    };
    let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
    let [first, second] = entry.targets.each_ref();
    let a = index_of(format!("{path}.targets[0]"), "target", first, &names)?;
    let b = index_of(format!("{path}.targets[1]"), "target", second, &names)?;
    let &KnownLengthEntry {
        length_mm,
        sigma_um,
        ..
    } = entry;
    if a == b {
        let found = format!("target `{first}` twice");
        return refused("targets", found, "two targets, the ends of the bar");
    }
    if targets[a].carrier != targets[b].carrier {
        let found = format!("`{first}` and `{second}` are carried by different axes");
        return refused("targets", found, "two targets of one stage");
    }
    if length_mm <= 0.0 {
        let found = format!("a length of {length_mm} mm");
        return refused("length_mm", found, "more than zero");
    }
    if sigma_um <= 0.0 {
        let found = format!("a standard uncertainty of {sigma_um} um");
        return refused("sigma_um", found, "more than zero, as in its certificate");
    }
    let nominal_mm = nalgebra::distance(&targets[a].home_mm, &targets[b].home_mm);
    let misfit_mm = (length_mm - nominal_mm).abs();
    if misfit_mm > MOUNTING_SLACK_MM + NOMINAL_PART * length_mm.min(nominal_mm) {
        let found = format!(
            "a length of {length_mm} mm, but `{first}` and `{second}` are nominally \
             {nominal_mm:.1} mm apart"
        );
        return refused("length_mm", found, "their distance in mm");
    }
    Ok(KnownLength {
        targets: [a, b],
        length_mm,
        sigma_um,
    })
}

/// The entries that [`from_entries`] reads.
pub(crate) fn to_entries(known: &[KnownLength], targets: &[Target]) -> Vec<KnownLengthEntry> {
    let name = |target: usize| {
        let target = targets.get(target);
        target.map(|target| target.name.clone()).unwrap_or_default()
    };
    let entries = known.iter().map(|known| KnownLengthEntry {
        targets: known.targets.map(name),
        length_mm: known.length_mm,
        sigma_um: known.sigma_um,
    });
    entries.collect()
}
