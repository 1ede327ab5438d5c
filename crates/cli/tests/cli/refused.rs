//! Damaged campaigns that must be refused: with the right exit code, a message to act on, and
//! nothing written.

use crate::campaign_files::CampaignFiles;
use crate::program::{file_names, run};

/// A name, a damage, the exit code, and what the message must say: parts of it (where, what, how to correct) with
/// ` … ` between them.
pub(crate) type Refusal = (&'static str, fn(&mut CampaignFiles), i32, &'static str);

/// Exit codes of the interface.
pub(crate) const INPUT: i32 = 3;
pub(crate) const NO_ANSWER: i32 = 4;
pub(crate) const NOT_IDENTIFIABLE: i32 = 5;

/// Damages a copy of the shipped campaign in each way alone and calibrates it.
pub(crate) fn assert_calibration_refused(campaign: &str, refusals: &[Refusal]) {
    assert_refused(campaign, "calibrate", &["--out", "out"], refusals);
}

/// The same by free points and nine equations.
pub(crate) fn assert_refused_by_nine(campaign: &str, refusals: &[Refusal]) {
    let options = ["--method", "nine", "--out", "out"];
    assert_refused(campaign, "calibrate", &options, refusals);
}

/// The same for `check`.
pub(crate) fn assert_check_refused(campaign: &str, refusals: &[Refusal]) {
    assert_refused(campaign, "check", &[], refusals);
}

fn assert_refused(campaign: &str, verb: &str, options: &[&str], refusals: &[Refusal]) {
    let sound = CampaignFiles::shipped(campaign);
    for (name, damage, code, says) in refusals {
        let mut files = sound.clone();
        damage(&mut files);
        let folder = tempfile::tempdir().unwrap();
        files.write(folder.path());
        let before = file_names(folder.path());
        let args = [&[verb, "campaign.json"], options].concat();
        run(folder.path(), &args).assert_failed(name, *code, says);
        // No result, and no temporary file.
        assert_eq!(file_names(folder.path()), before, "{name}");
    }
}
