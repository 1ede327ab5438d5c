//! An angle of one linear axis times the position of another one, `$AN_CEC_MULT_BY_TABLE`.
//!
//! With the other axis at home it does nothing, and on the line of the other axis alone, too, so that the tables of the lines
//! stay as they are:
//!
//! ```text
//! added to o = -Σ s(a) l(b)    s(a): slope of the deviation of o along b, with axis a at its position, less that at home
//!                              l(b): position of axis b, mm
//! ```
//!
//! An angle turns what is between its axis and the tool, on the way from the workpiece over the bed: b comes after a on it.
//! The slopes are those with all other axes at home: rotary axes on the way turn the levers that come after them.
//!
//! The manual's example is a boring mill whose foundation sags: ΔX1 = Z1 sin β(X1), with table 1 (X1 for X1, the sine) that is
//! multiplied by table 2 (Z1 for X1, "linear"). That a lever does not act besides follows from the example, in which it
//! would move X1 by all of Z1; whether the table of the sine does makes no difference: 1e-4 are 0.1 µm.

use trueaxis_files::round;
use trueaxis_kinematics::{AxisKind, Branch, Machine};

use crate::export::Request;
use crate::export::line::{Line, interpolate, spacing, take_off};
use crate::export::sinumerik::sag::Product;
use crate::export::sinumerik::table::{Kind, Table};
use crate::{Error, Moved, axis_deviations};

/// What stays below this everywhere gets no table, mm: second-order effects of the levers that no angle turns.
const LEAST: f64 = 1e-5;

/// The slope of the deviation of one axis along another one, over the position of a third (or of the first).
#[derive(Debug, Clone)]
pub(super) struct Lever {
    /// The axis whose angle it is.
    angle_of: usize,
    along: usize,
    pub(super) output: usize,
    /// Of the axis whose angle it is, rising, mm.
    positions: Vec<f64>,
    step: f64,
    /// Actual minus commanded, mm per mm, zero at home.
    slopes: Vec<f64>,
    /// Of the axis that is the lever, mm.
    travel: [f64; 2],
}

impl Lever {
    /// Those of the axes that have lines.
    ///
    /// # Errors
    /// Unequal distances of the positions, or no angle on a lever.
    pub(super) fn all(request: &Request<'_>, lines: &[Line]) -> Result<Vec<Self>, Error> {
        let axes = request.machine.machine().axes();
        let is_linear = |axis: &usize| axes[*axis].kind() == AxisKind::Linear;
        let linear = from_the_workpiece(request.machine.machine());
        let linear: Vec<usize> = linear.into_iter().filter(is_linear).collect();
        let mut all = Vec::new();
        for line in lines.iter().filter(|line| is_linear(&line.axis)) {
            let step = spacing(request, line.axis, &line.positions)?;
            let after = linear.iter().skip_while(|axis| **axis != line.axis);
            for &along in after.skip(1) {
                let travel = axes[along].travel();
                let slopes = slopes(request, line, along, travel);
                for &output in &linear {
                    let lever = Self {
                        angle_of: line.axis,
                        along,
                        output,
                        positions: line.positions.clone(),
                        step,
                        slopes: slopes.iter().map(|slopes| slopes[output]).collect(),
                        travel,
                    };
                    if lever.largest() >= LEAST {
                        all.push(lever);
                    }
                }
            }
        }
        match all.is_empty() {
            true => Err(request.unsuitable(
                "levers with an angle of a linear axis that acts along another one",
                "these axes have none",
            )),
            false => Ok(all),
        }
    }

    fn largest(&self) -> f64 {
        let slope = self.slopes.iter().fold(0.0, |most, x| x.abs().max(most));
        slope * self.travel[0].abs().max(self.travel[1].abs())
    }

    /// Its two tables.
    pub(super) fn product(&self, request: &Request<'_>) -> Product {
        let [low, high] = self.travel.map(|x| round(x, 9));
        Product {
            factor: Table {
                kind: Kind::Factor,
                input: self.angle_of,
                output: self.output,
                min: request.in_file(self.angle_of, self.positions[0]),
                step: request.in_file(self.angle_of, self.step),
                values: self.slopes.clone(),
            },
            lever: Table {
                kind: Kind::Factor,
                input: self.along,
                output: self.output,
                min: low,
                step: high - low,
                values: vec![low, high],
            },
        }
    }

    /// The deviation that it makes, mm.
    pub(super) fn at(&self, commanded: &[f64]) -> f64 {
        let slope = interpolate(
            &self.positions,
            |k| self.slopes[k],
            commanded[self.angle_of],
        );
        let [low, high] = self.travel;
        slope * commanded[self.along].clamp(low, high)
    }
}

/// The axes on the way from the workpiece over the bed to the tool.
fn from_the_workpiece(machine: &Machine) -> Vec<usize> {
    let to_bed = machine.branch(Branch::Workpiece).iter().rev();
    to_bed
        .chain(machine.branch(Branch::Tool))
        .copied()
        .collect()
}

/// For each position of the line the slopes of the deviations of all axes along another one, less those at home.
fn slopes(request: &Request<'_>, line: &Line, along: usize, travel: [f64; 2]) -> Vec<Vec<f64>> {
    let machine = request.machine.machine();
    let [low, high] = travel;
    let slopes_at = |position: f64| -> Vec<f64> {
        let at = |lever: f64| {
            let mut commanded = vec![0.0; machine.axes().len()];
            commanded[line.axis] = position;
            commanded[along] = lever;
            axis_deviations(
                machine,
                request.machine,
                &commanded,
                request.at,
                Moved::Linear,
            )
        };
        let pairs = at(low).into_iter().zip(at(high));
        pairs
            .map(|(low_d, high_d)| (high_d - low_d) / (high - low))
            .collect()
    };
    let mut all: Vec<Vec<f64>> = line.positions.iter().map(|&q| slopes_at(q)).collect();
    // What the table itself has there, where no point may be.
    let axes = 0..machine.axes().len();
    let home = axes.map(|of| interpolate(&line.positions, |k| all[k][of], 0.0));
    let home: Vec<f64> = home.collect();
    take_off(&mut all, &home);
    all
}
