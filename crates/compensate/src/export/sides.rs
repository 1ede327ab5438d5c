//! Lost motion that the tables of a format do not take away.

use trueaxis_files::round;

use crate::export::Request;
use crate::export::line::Line;

/// A hundredth of a micrometre, or a twentieth of an arc second.
const DECIMALS: i32 = 5;

/// What a format does with the two sides of approach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// A table has a column for each.
    Columns,
    /// A table holds their mean.
    Mean,
    /// Lost motion is a parameter of the control, of which the format says the value.
    Parameter,
    /// No positioning is in the tables.
    Nothing,
}

impl Sides {
    /// What stays, of the axes that tables are asked for; none if nothing does.
    pub(super) fn note(self, request: &Request<'_>) -> Option<String> {
        let axes = request.axes().ok()?;
        let apart = |axis: &&usize| request.machine.keeps_sides_apart(**axis);
        if self == Self::Nothing {
            return None;
        }
        if !axes.iter().any(|axis| apart(&axis)) {
            return Some(
                "the calibration has one curve of an axis, not one for each side of approach: the tables correct both directions \
                 alike, lost motion stays as it is, and the figures above are without it; where both sides were measured, calibrate \
                 --by-direction"
                    .to_owned(),
            );
        }
        if self != Self::Mean {
            return None;
        }
        let lines = axes.iter().filter(apart);
        let lines = lines.filter_map(|&axis| Line::new(request, axis).ok());
        let lost = lines.filter_map(|line| {
            let (name, unit) = (request.name(line.axis), request.unit(line.axis));
            let lost = line.known_lost_motion(request)?;
            Some(format!("{name} {} {unit}", round(lost, DECIMALS)))
        });
        let lost: Vec<String> = lost.collect();
        (!lost.is_empty()).then(|| {
            format!(
                "the tables hold the mean of both sides of approach: lost motion stays ({}), and the figures above are \
                 without it; add it to the backlash of the control",
                lost.join(", ")
            )
        })
    }
}
