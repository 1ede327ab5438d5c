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
                let lines = axes.iter().filter(apart);
                let lines = lines.filter_map(|&axis| Line::new(request, axis).ok());
                let lost = lines.map(|line| {
                    let (name, unit) = (request.name(line.axis), request.unit(line.axis));
                    format!("{name} {} {unit}", round(line.lost_motion(request), DECIMALS))
                });
                let lost: Vec<String> = lost.collect();
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
