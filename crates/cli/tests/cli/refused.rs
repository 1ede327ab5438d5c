//! Damaged campaigns that must be refused: with the right exit code, a message to act on, and
//! nothing written.

use crate::campaign_files::CampaignFiles;
use crate::program::{file_names, run};

/// A damage and what the program must answer.
pub(crate) struct Refusal {
    pub(crate) name: &'static str,
    pub(crate) damage: fn(&mut CampaignFiles),
    pub(crate) code: i32,
    /// Parts of the message: where, what, how to correct.
    pub(crate) says: &'static [&'static str],
}

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
    for refusal in refusals {
        let mut files = sound.clone();
        (refusal.damage)(&mut files);
        let folder = tempfile::tempdir().unwrap();
        files.write(folder.path());
        let before = file_names(folder.path());
        let args = [&[verb, "campaign.json"], options].concat();
        run(folder.path(), &args).assert_failed(refusal.name, refusal.code, refusal.says);
        // No result, and no temporary file.
        assert_eq!(file_names(folder.path()), before, "{}", refusal.name);
    }
}
