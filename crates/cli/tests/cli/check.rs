//! `trueaxis check` of what is right.

use crate::program::{file_names, run, shipped};

#[test]
fn says_what_is_in_the_shipped_campaigns() {
    let folder = tempfile::tempdir().unwrap();
    for (campaign, says) in [
        (
            "rotary-stage",
            &[
                "bed to workpiece: C (rotary)",
                "684 in 228 stops",
                "19 steps",
            ][..],
        ),
        (
            "fxyz",
            &[
                "bed to tool: X (linear), Y (linear), Z (linear)",
                "stations  S1, S2, S3, S4",
                "run       x: axis X, 23 steps",
            ],
        ),
        ("five-axis", &["U on C", "run       a: axis A, 11 steps"]),
    ] {
        let path = shipped(campaign).join("campaign.json");
        let outcome = run(folder.path(), &["check", path.to_str().unwrap()]);
        outcome.assert_good();
        assert_eq!(outcome.stdout, "");
        assert!(outcome.stderr.ends_with("campaign.json: good\n"));
        assert!(!outcome.stderr.contains("notice"), "{}", outcome.stderr);
        for part in says {
            assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
        }
    }
    assert!(file_names(folder.path()).is_empty());
}
