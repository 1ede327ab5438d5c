//! Names of errors and effects in plain words.

use serde_json::{Map, Value};
use trueaxis_files::told_effect;

use crate::calibration::Machine;

const LETTERS: [char; 3] = ['X', 'Y', 'Z'];

/// `straightness of X in the Z direction`, for `EZX`.
pub(crate) fn component(name: &str, axis: &str, machine: &Machine) -> String {
    let Some(letter) = name.chars().nth(1) else {
        return String::new();
    };
    let along = principal(axis, machine);
    let is_own = |k: usize| along == Some(k);
    let rotary = machine.is_rotary(axis);
    match (LETTERS.iter().position(|&x| x == letter), rotation(letter)) {
        (Some(k), _) if rotary && is_own(k) => format!("axial motion of {axis}"),
        (Some(_), _) if rotary => format!("radial motion of {axis} in the {letter} direction"),
        (Some(k), _) if is_own(k) => format!("positioning of {axis}"),
        (Some(_), _) => format!("straightness of {axis} in the {letter} direction"),
        (_, Some(k)) if rotary && is_own(k) => format!("angular positioning of {axis}"),
        (_, Some(k)) if rotary => format!("tilt motion of {axis} about {}", LETTERS[k]),
        (_, Some(k)) if is_own(k) => format!("roll of {axis}"),
        (_, Some(k)) => format!("rotation of {axis} about {}", LETTERS[k]),
        _ => String::new(),
    }
}

/// `squareness of Y to X`, for `C0Y`.
pub(crate) fn location(name: &str, machine: &Machine) -> String {
    let Some((letter, axis)) = name.split_once('0') else {
        return String::new();
    };
    let letter = letter.chars().next().unwrap_or_default();
    let turned = rotation(letter);
    if machine.is_rotary(axis) {
        return match turned {
            Some(k) => format!("tilt of {axis} about {}", LETTERS[k]),
            None => format!("offset of {axis} in the {letter} direction"),
        };
    }
    // The axis turns about the normal of the plane that it spans with the other one.
    match (turned, principal(axis, machine)) {
        (Some(k), Some(own)) if k != own => {
            format!("squareness of {axis} to {}", LETTERS[3 - k - own])
        }
        (Some(k), _) => format!("direction of {axis} about {}", LETTERS[k]),
        _ => String::new(),
    }
}

fn rotation(letter: char) -> Option<usize> {
    ['A', 'B', 'C'].iter().position(|&x| x == letter)
}

/// The reference direction that an axis follows.
fn principal(axis: &str, machine: &Machine) -> Option<usize> {
    let axis = machine.axes.iter().find(|a| a.name == axis)?;
    (0..3).max_by(|&a, &b| axis.direction[a].abs().total_cmp(&axis.direction[b].abs()))
}

/// `backlash of axis C`.
pub(crate) fn effect(id: &str, subject: &Map<String, Value>) -> String {
    told_effect(id, |field| subject.get(field).and_then(Value::as_str))
}

/// The text, cut to `most` letters where it is longer.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    match text.chars().count() > most {
        true => text.chars().take(most - 1).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

/// With a capital.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}
