//! The places at which the volumetric error is looked at.
//!
//! Up to three linear axes, one for each reference direction, make a grid over their steps. All other measured axes
//! take, at each node of the grid, the next value of a low-discrepancy sequence over theirs, the radical inverse of
//! the number of the place in a prime base (J. H. Halton, *Numerische Mathematik* 2, 84, 1960): the number of places does not
//! grow with the number of axes. Axes that were not measured stand at home.

use std::iter::StepBy;
use std::ops::Range;

use nalgebra::Point3;
use trueaxis_kinematics::AxisKind;

use crate::calibrated_machine::CalibratedMachine;

/// Bases of the sequences.
const PRIMES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];

/// Reference directions.
const DIRECTIONS: usize = 3;

/// Where between two nodes, as part of their distance: the golden section meets no table's points often.
const BETWEEN: f64 = 0.381_966;

/// Where axes stand.
#[derive(Debug, Clone, PartialEq)]
pub struct Places {
    /// For each reference direction the linear axis that makes the grid along it, with its positions, mm.
    pub grid: [Option<GridAxis>; DIRECTIONS],
    /// The other measured axes, with the range of their steps, mm or rad.
    pub sampled: Vec<(usize, [f64; 2])>,
    /// The tool point at home, mm.
    pub tool_home_mm: Point3<f64>,
    /// How often each node of the grid is visited, with the other axes elsewhere.
    visits: usize,
    axes: usize,
}

/// A linear axis of the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct GridAxis {
    /// Index among the machine's axes.
    pub axis: usize,
    /// Equally spaced from its first to its last step.
    pub positions: Vec<f64>,
}

impl Places {
    /// With `points` nodes (two at least) along each axis of the grid; where fewer axes than three make the grid, its nodes are visited
    /// as often as the others would make nodes.
    pub(crate) fn new(
        machine: &CalibratedMachine,
        points: usize,
        tool_home_mm: Point3<f64>,
    ) -> Self {
        let mut grid = [const { None }; DIRECTIONS];
        let mut sampled = Vec::new();
        for axis in &machine.axes {
            let geometry = &machine.machine.axes()[axis.axis];
            let [low, high] = axis.range;
            let place = &mut grid[geometry.principal()];
            if geometry.kind() == AxisKind::Linear && place.is_none() {
                let share = |i: usize| i as f64 / (points - 1) as f64;
                *place = Some(GridAxis {
                    axis: axis.axis,
                    positions: (0..points).map(|i| low + (high - low) * share(i)).collect(),
                });
            } else {
                sampled.push((axis.axis, axis.range));
            }
        }
        let more = DIRECTIONS - grid.iter().flatten().count();
        let more = more.min(sampled.len());
        Self {
            grid,
            sampled,
            tool_home_mm,
            visits: (0..more).map(|_| points).product(),
            axes: machine.machine.axes().len(),
        }
    }

    /// The same between the nodes of the grid, which may be where a table has its points.
    #[must_use]
    pub fn between(mut self) -> Self {
        for axis in self.grid.iter_mut().flatten() {
            let pairs = axis.positions.windows(2);
            axis.positions = pairs.map(|q| q[0] + BETWEEN * (q[1] - q[0])).collect();
        }
        self
    }

    /// Nodes of the grid along each reference direction: one where no axis makes it.
    pub fn nodes(&self) -> [usize; DIRECTIONS] {
        self.grid
            .each_ref()
            .map(|axis| axis.as_ref().map_or(1, |axis| axis.positions.len()))
    }

    /// Number of places.
    pub fn count(&self) -> usize {
        self.nodes().iter().product::<usize>() * self.visits
    }

    /// The numbers of at most `most` places at equal distances, which do not keep to a plane of the grid.
    pub fn some(&self, most: usize) -> StepBy<Range<usize>> {
        let mut stride = self.count().div_ceil(most).max(1);
        let is_in_plane = |stride, nodes: &[usize]| {
            let mut nodes = nodes.iter();
            nodes.any(|&nodes| common_divisor(stride, nodes) > 1)
        };
        while is_in_plane(stride, &self.nodes()) {
            stride += 1;
        }
        (0..self.count()).step_by(stride)
    }

    /// Numbers of the nodes of the grid, with the other axes at home.
    pub fn map(&self) -> Range<usize> {
        0..self.nodes().iter().product()
    }

    /// Positions of all axes at a node of the grid (x runs fastest), the others at home, mm or rad.
    pub fn at_node(&self, number: usize) -> Vec<f64> {
        let mut positions = vec![0.0; self.axes];
        let mut rest = number;
        for (axis, nodes) in self.grid.iter().zip(self.nodes()) {
            if let Some(axis) = axis {
                positions[axis.axis] = axis.positions[rest % nodes];
            }
            rest /= nodes;
        }
        positions
    }

    /// Positions of all axes at place `number`, mm or rad.
    pub fn at(&self, number: usize) -> Vec<f64> {
        let mut positions = self.at_node(number / self.visits);
        for (i, &(axis, [low, high])) in self.sampled.iter().enumerate() {
            let share = radical_inverse(number + 1, PRIMES[i % PRIMES.len()]);
            positions[axis] = low + (high - low) * share;
        }
        positions
    }
}

fn common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// The digits of a number mirrored at the point.
fn radical_inverse(mut number: usize, base: usize) -> f64 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= base as f64;
        inverse += digit * (number % base) as f64;
        number /= base;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radical_inverses_fill_the_interval() {
        let found: Vec<f64> = (1..8).map(|i| radical_inverse(i, 2)).collect();
        assert_eq!(found, [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
        assert!((radical_inverse(5, 3) - (2.0 / 3.0 + 1.0 / 9.0)).abs() < 1e-15);
    }
}
