//! All 84 choices of six equations.

use nalgebra::Vector6;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_identify::{Error, SixRows, nine};

use crate::targets::{
    ROTARY, THREE_AXIS, condition_number, displacement, is_blind, random_error, random_targets,
    reach, relative_difference,
};

/// Rounding the volumetric errors and the coordinates alone, each by half of EPSILON, changes the
/// solution by up to `EPSILON * condition`. The solver may add as much.
const ROUNDING_FACTOR: f64 = 2.0;

#[test]
fn seventy_eight_choices_recover_the_errors_and_six_are_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for trial in 0..200 {
        let r = match trial {
            0 => THREE_AXIS,
            1 => ROTARY,
            _ => random_targets(&mut rng),
        };
        let truth = random_error(&mut rng);
        let delta = r.map(|r| displacement(&truth, &r));
        let mut solved = 0;
        for rows in SixRows::all() {
            match rows.operator(&r) {
                Ok(operator) => {
                    solved += 1;
                    let found = operator.apply(&delta);
                    let error = relative_difference(&found, &truth, reach(&r));
                    let condition = condition_number(rows, &r);
                    let bound = ROUNDING_FACTOR * f64::EPSILON * condition;
                    assert!(error < bound, "{rows} {error:e} {bound:e} {r:?}");
                }
                Err(refused) => assert!(
                    matches!(refused, Error::SingularRows { .. }) && is_blind(rows),
                    "{rows} {refused} {r:?}"
                ),
            }
        }
        assert_eq!(solved, 78);
    }
}

/// On the paper's own targets every choice that works is good to 13 digits.
#[test]
fn paper_targets_are_recovered_to_thirteen_digits() {
    let truth = random_error(&mut ChaCha8Rng::seed_from_u64(2));
    for r in [THREE_AXIS, ROTARY] {
        let delta = r.map(|r| displacement(&truth, &r));
        for rows in SixRows::all().filter(|rows| !is_blind(*rows)) {
            let found = rows.operator(&r).unwrap().apply(&delta);
            assert!(
                relative_difference(&found, &truth, reach(&r)) < 1e-13,
                "{rows}"
            );
        }
        let found = nine(&r).unwrap().apply(&delta);
        assert!(relative_difference(&found, &truth, reach(&r)) < 1e-14);
    }
}

/// A choice of rows leaves the other three coordinates without influence.
#[test]
fn unchosen_coordinates_do_not_count() {
    let p = SixRows::PAPER.operator(&THREE_AXIS).unwrap().matrix();
    for row in (0..9).filter(|&row| SixRows::PAPER.rows().all(|chosen| chosen != row)) {
        assert_eq!(p.column(row), Vector6::zeros());
    }
}

#[test]
fn prints_circled_numbers() {
    assert_eq!(SixRows::PAPER.to_string(), "①②④⑥⑧⑨");
    assert_eq!(SixRows::new([8, 7, 5, 3, 1, 0]), Ok(SixRows::PAPER));
}

#[test]
fn refuses_what_is_no_choice() {
    for rows in [[0, 1, 2, 3, 4, 4], [0, 1, 2, 3, 4, 9]] {
        assert_eq!(SixRows::new(rows), Err(Error::RowChoice { rows }));
    }
}

/// The six of the paper's section 4.1.1, and no more.
#[test]
fn six_choices_are_blind() {
    let blind = SixRows::all().filter(|rows| rows.operator(&THREE_AXIS).is_err());
    let mut blind: Vec<String> = blind.map(|rows| rows.to_string()).collect();
    blind.sort();
    assert_eq!(
        blind,
        ["①②③④⑤⑥", "①②③⑦⑧⑨", "①②④⑤⑦⑧", "①③④⑥⑦⑨", "②③⑤⑥⑧⑨", "④⑤⑥⑦⑧⑨",]
    );
    assert_eq!(SixRows::all().count(), 84);
}
