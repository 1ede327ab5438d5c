//! What a table can take away: said beforehand, by the calibration itself.
//!
//! The control's rule is applied to the machine as calibrated: along the line of each axis and over the whole volume, at nodes
//! of a grid and between them, since a grid may have its nodes where the table has its points.
//! What the calibration does not know is in none of these figures.

use trueaxis_kinematics::MotionError;
use trueaxis_predict::Places;

use crate::export::line::own_deviation;
use crate::export::{Request, Rule};
use crate::{Error, Sizes};

/// Nodes along each linear axis.
const NODES: usize = 11;

/// Positions along a line.
const ON_A_LINE: usize = 101;

/// The positioning of one axis along the line of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct LineFigures {
    /// Index of the axis.
    pub axis: usize,
    /// Largest minus smallest deviation without the table, mm or rad.
    pub before: f64,
    /// With it.
    pub after: f64,
}

/// Before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct Announcement {
    /// Positioning of each measured axis.
    pub lines: Vec<LineFigures>,
    /// Over the volume, without the tables.
    pub before: Sizes,
    /// With them.
    pub after: Sizes,
}

impl Announcement {
    pub(crate) fn new(request: &Request<'_>, rule: &Rule) -> Result<Self, Error> {
        let nodes = request.machine.places(NODES, request.at);
        let places = [nodes.clone(), nodes.between()];
        let before = Seen::new(request, None)?;
        let after = Seen::new(request, Some(rule))?;
        let lines = request.axes()?.into_iter().map(|axis| {
            Ok(LineFigures {
                axis,
                before: before.on_the_line_of(axis)?,
                after: after.on_the_line_of(axis)?,
            })
        });
        Ok(Self {
            lines: lines.collect::<Result<_, Error>>()?,
            before: before.over(&places)?,
            after: after.over(&places)?,
        })
    }
}

/// The machine with the rule applied or not.
struct Seen<'a> {
    request: &'a Request<'a>,
    rule: Option<&'a Rule>,
    home: MotionError,
}

impl<'a> Seen<'a> {
    fn new(request: &'a Request<'a>, rule: Option<&'a Rule>) -> Result<Self, Error> {
        let mut seen = Self {
            request,
            rule,
            home: MotionError::default(),
        };
        seen.home = seen.error(&vec![0.0; request.machine.machine().axes().len()])?;
        Ok(seen)
    }

    /// The error of the tool against where the command means it to be.
    fn error(&self, commanded: &[f64]) -> Result<MotionError, Error> {
        let mut positions = commanded.to_vec();
        if let Some(rule) = self.rule {
            let added = rule(commanded)?;
            positions
                .iter_mut()
                .zip(added)
                .for_each(|(q, added)| *q += added);
        }
        let machine = self.request.machine;
        let nominal = machine.machine();
        let error = nominal.tool_error_at(machine, commanded, &positions, self.request.at);
        Ok(MotionError::new(
            error.translation_mm - self.home.translation_mm,
            error.rotation_rad,
        ))
    }

    fn over(&self, places: &[Places]) -> Result<Sizes, Error> {
        let all = places.iter().flat_map(|p| (0..p.count()).map(|k| p.at(k)));
        let errors = all.map(|commanded| Ok(self.error(&commanded)?.to_vector()));
        Ok(Sizes::of(&errors.collect::<Result<Vec<_>, Error>>()?))
    }

    fn on_the_line_of(&self, axis: usize) -> Result<f64, Error> {
        let machine = self.request.machine.machine();
        let steps = self.request.machine.steps(axis);
        let (first, last) = (steps[0], steps[steps.len() - 1]);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..ON_A_LINE {
            let mut commanded = vec![0.0; machine.axes().len()];
            commanded[axis] = first + (last - first) * k as f64 / (ON_A_LINE - 1) as f64;
            let error = self.error(&commanded)?;
            let deviation = own_deviation(self.request, axis, &error)[axis];
            low = deviation.min(low);
            high = deviation.max(high);
        }
        Ok(high - low)
    }
}
