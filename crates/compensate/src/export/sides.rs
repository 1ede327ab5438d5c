//! Lost motion that the tables of a format do not take away.

use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};

use crate::export::Request;
use crate::export::line::Line;

/// What a format does with the two sides of approach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sides {
    /// A table has a column for each.
    Columns,
    /// A table holds their mean.
    Mean,
    /// Lost motion is a parameter of the control, of which the format says the value, or no positioning is in the tables.
    Elsewhere,
}

impl Sides {
    /// What stays, of the axes that tables are asked for; none if nothing does.
    pub(super) fn note(self, request: &Request<'_>) -> Option<String> {
        let axes = request.axes().ok()?;
        let apart = |axis: &&usize| request.machine.keeps_sides_apart(**axis);
        match self {
            Self::Elsewhere => None,
            Self::Columns => axes.iter().all(|axis| !apart(&axis)).then(|| {
                "the calibration joins both sides of approach, so both columns are alike and lost motion stays as it is; where both \
                 sides were measured, calibrate --by-direction"
                    .to_owned()
            }),
            Self::Mean => {
                let lost = axes.iter().filter(apart);
                let lost: Vec<String> = lost.filter_map(|&axis| lost_motion(request, axis)).collect();
                (!lost.is_empty()).then(|| {
                    format!(
                        "the tables hold the mean of both sides of approach: lost motion stays ({}), and the figures above are \
                         without it; give it to the control as its backlash",
                        lost.join(", ")
                    )
                })
            }
        }
    }
}

/// The mean over the line of an axis, with its name.
fn lost_motion(request: &Request<'_>, axis: usize) -> Option<String> {
    let line = Line::new(request, axis, "").ok()?;
    let (unit, symbol) = match request.machine.machine().axes()[axis].kind() {
        AxisKind::Linear => (MICROMETRE, "µm"),
        AxisKind::Rotary => (ARCSEC, "″"),
    };
    let lost = -line.reversal() / unit;
    Some(format!("{} {lost:.2} {symbol}", request.name(axis)))
}
