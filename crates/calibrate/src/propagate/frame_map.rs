//! The errors of axes, targets, stations and frame as functions of the sources.
//!
//! The sources of an axis ([`crate::propagate::sources`]) are found from its poses in the frame of its base, as if
//! the base were known. One after the other, from the bed outwards, each axis is corrected for the errors of the axes
//! outside it at their positions during its runs; the axes inside it stand still and shift only the targets. The
//! results are relative to the reference frame, which itself moves with the errors of its lines and anchors.

use nalgebra::{DMatrix, Isometry3, Matrix3, Matrix3xX, Point3, RowDVector, Vector3};
use trueaxis_kinematics::{AxisKind, GeometricErrors, Twist};

use crate::identify::basis::Basis;
use crate::identify::context::{Context, ModelErrors};
use crate::identify::identify_axes::Identified;
use crate::propagate::base_response::BaseResponse;
use crate::propagate::sources::Sources;
use trueaxis_kinematics::axis_twist::{AXIS_ERRORS, SHIFT, TILT, axis_twist};

/// Linear maps from the sources to results; columns are the sources.
pub(crate) struct FrameMap<'a, 's> {
    context: &'a Context<'a>,
    identified: &'a Identified,
    sources: &'s Sources,
    /// Response of each axis to motions of its base.
    pub(crate) responses: Vec<BaseResponse<'a>>,
    /// The sources, corrected for the errors of the axes outside.
    corrected: DMatrix<f64>,
    /// For each axis the error of its position along itself; zero for linear axes.
    axial: DMatrix<f64>,
}

/// An axis' position along itself depends on those of axes that share its targets, and targets of axes inside it
/// depend on it. Nominal directions describe this but for errors of the axes, so the second sweep confirms the first.
const AXIAL_SWEEPS: usize = 3;

impl<'a, 's> FrameMap<'a, 's> {
    pub(crate) fn new(
        context: &'a Context<'a>,
        identified: &'a Identified,
        sources: &'s Sources,
    ) -> Self {
        let axes = 0..context.data.len();
        Self {
            context,
            identified,
            sources,
            responses: axes
                .map(|k| BaseResponse::new(context, identified, k))
                .collect(),
            corrected: DMatrix::identity(sources.count, sources.count),
            axial: DMatrix::zeros(context.data.len(), sources.count),
        }
    }

    fn errors(&self) -> ModelErrors<'_> {
        self.context.errors(&self.identified.state)
    }

    /// Three consecutive sources.
    fn pick(&self, first: usize) -> Matrix3xX<f64> {
        self.corrected.fixed_rows::<3>(first).into_owned()
    }

    /// A vector across an axis whose two coordinates are consecutive sources.
    fn across(&self, k: usize, first: usize) -> Matrix3xX<f64> {
        let [a, b] = Basis::of(self.context.axis(k)).across;
        a * self.corrected.row(first) + b * self.corrected.row(first + 1)
    }

    /// Corrects the sources of all axes for the errors outside them, and finds the positions of rotary axes along
    /// themselves; returns the error motion of the frame.
    pub(crate) fn solve(&mut self) -> Twist {
        let mut frame = Twist::zero(self.sources.count);
        for _ in 0..AXIAL_SWEEPS {
            self.free_from_bases();
            frame = self.frame();
            self.find_axial(&frame);
        }
        frame
    }

    /// Corrects one axis after the other, from the bed outwards.
    fn free_from_bases(&mut self) {
        for k in self.context.outwards() {
            let own = &self.sources.axes[k];
            let mut rows = DMatrix::zeros(own.places.len(), self.sources.count);
            for (i, &place) in own.places.iter().enumerate() {
                rows[(i, place)] = 1.0;
            }
            for run in 0..self.context.data[k].runs.len() {
                rows -= self.responses[k].of(&own.form, run) * self.base_motion(k, run).rows();
            }
            for (i, &place) in own.places.iter().enumerate() {
                self.corrected.row_mut(place).copy_from(&rows.row(i));
            }
        }
    }

    /// The errors of axis `k` at a position, in the order of [`axis_twist`].
    fn axis_errors(&self, k: usize, position: f64) -> DMatrix<f64> {
        let axis = self.context.axis(k);
        let mut rows = DMatrix::zeros(AXIS_ERRORS, self.sources.count);
        if let Some(first) = self.sources.held_at(k, position) {
            rows.rows_mut(0, 6)
                .copy_from(&self.corrected.rows(first, 6));
        }
        let first = self.sources.location[k];
        match axis.kind() {
            AxisKind::Linear => rows.rows_mut(TILT, 3).copy_from(&self.across(k, first)),
            AxisKind::Rotary => {
                let along = axis.direction().into_inner() * self.axial.row(k);
                let shift = self.across(k, first) + along;
                rows.rows_mut(SHIFT, 3).copy_from(&shift);
                rows.rows_mut(TILT, 3).copy_from(&self.across(k, first + 2));
            }
        }
        rows
    }

    /// The error motion of axis `k` at a position, in the frame of its own base.
    fn twist_of(&self, k: usize, position: f64) -> Twist {
        let axis = self.context.axis(k);
        let location = self.identified.state.axes[k].location;
        let error = self.errors().motion(self.context.data[k].axis, position);
        axis_twist(axis, position, &location, &error).through(&self.axis_errors(k, position))
    }

    /// The error motion of axes in the order of their chain, in the reference frame; `base` moves all outside them.
    fn twist_of_chain(&self, base: Isometry3<f64>, chain: &[usize], positions: &[f64]) -> Twist {
        let errors = self.errors();
        let mut sum = Twist::zero(self.sources.count);
        let mut before = base;
        for &axis in chain {
            if let Some(k) = self.context.place_of(axis) {
                sum.add(&self.twist_of(k, positions[axis]).seen_from(&before));
            }
            before *= errors.chain_motion(&[axis], positions);
        }
        sum
    }

    /// The error motion of an axis' base in a run; all targets have the same axes outside.
    pub(crate) fn base_motion(&self, k: usize, run: usize) -> Twist {
        let run = &self.context.data[k].runs[run];
        self.twist_of_chain(Isometry3::identity(), &run.outer, &run.positions)
    }

    /// The motion of an axis' base in a run.
    fn base(&self, k: usize, run: usize) -> Isometry3<f64> {
        let run = &self.context.data[k].runs[run];
        self.errors().chain_motion(&run.outer, &run.positions)
    }

    /// Rotation from the axis' base: nearly none, because other rotary axes stand at home.
    fn turn(&self, k: usize) -> Matrix3<f64> {
        self.base(k, 0).rotation.to_rotation_matrix().into_inner()
    }

    /// Errors of the targets' home positions relative to their nests, in the reference frame before it is applied,
    /// and the positions of the targets. Deformations of the shape are left out: the frame follows from none of them.
    fn targets(&self, k: usize, r: usize) -> Vec<(Matrix3xX<f64>, Point3<f64>)> {
        let (run, errors) = (&self.context.data[k].runs[r], self.errors());
        let base = self.base(k, r);
        let values = &self.identified.state.axes[k];
        let reference = self.context.axis(k).reference_at_home_mm(&values.location);
        let first = self.sources.placements[k][r];
        let placed = Twist::about(reference, self.pick(first), self.pick(first + 3));
        let placed = placed.seen_from(&base);
        let homes = errors.targets_mm(k, r);
        let target = |(place, home): (usize, Point3<f64>)| {
            let inner = &run.inside[place];
            let at = base * errors.chain_motion(inner, &run.positions) * home;
            let carried = self.twist_of_chain(base, inner, &run.positions);
            let nest = self.pick(self.sources.nests + 3 * run.targets[place]);
            (placed.at(at) - carried.at(at) + nest, home)
        };
        homes.into_iter().enumerate().map(target).collect()
    }

    /// The error motion of the frame.
    fn frame(&self) -> Twist {
        let rule = &self.identified.frame;
        let tilt = |k: usize| self.turn(k) * self.across(k, self.sources.location[k]);
        let tilts: Vec<Matrix3xX<f64>> = rule.lines.iter().map(|&k| tilt(k)).collect();
        let mut shifts: Vec<Matrix3xX<f64>> = Vec::new();
        // The anchors are all targets of some runs, run after run.
        for run in rule
            .anchors
            .chunk_by(|a, b| (a.data, a.run) == (b.data, b.run))
        {
            let targets = self.targets(run[0].data, run[0].run);
            shifts.extend(run.iter().map(|anchor| targets[anchor.place].0.clone()));
        }
        // The rule is linear: one column at a time.
        let column = |m: &Matrix3xX<f64>, j: usize| Vector3::new(m[(0, j)], m[(1, j)], m[(2, j)]);
        let mut displacement = Matrix3xX::zeros(self.sources.count);
        let mut rotation = Matrix3xX::zeros(self.sources.count);
        let mut pivot = Point3::origin();
        for j in 0..self.sources.count {
            let tilts: Vec<_> = tilts.iter().map(|m| column(m, j)).collect();
            let shifts: Vec<_> = shifts.iter().map(|m| column(m, j)).collect();
            let motion = rule.motion(&tilts, &shifts);
            displacement.column_mut(j).copy_from(&motion.translation);
            rotation.column_mut(j).copy_from(&motion.rotation);
            pivot = motion.pivot;
        }
        Twist::about(pivot, displacement, rotation)
    }

    /// Errors of an axis' shift and tilt, three rows each.
    pub(crate) fn location(&self, k: usize, frame: &Twist) -> DMatrix<f64> {
        let axis = self.context.axis(k);
        let direction = axis.direction().into_inner();
        let across = without(direction) * self.turn(k).transpose();
        let first = self.sources.location[k];
        let mut rows = DMatrix::zeros(6, self.sources.count);
        let tilt = match axis.kind() {
            AxisKind::Linear => self.across(k, first),
            AxisKind::Rotary => {
                let centre = axis.reference_at_home_mm(&self.identified.state.axes[k].location);
                let mut shift = self.across(k, first) - across * frame.at(centre);
                shift += direction * self.axial.row(k);
                rows.rows_mut(0, 3).copy_from(&shift);
                self.across(k, first + 2)
            }
        };
        rows.rows_mut(3, 3)
            .copy_from(&(tilt - across * &frame.rotation));
        rows
    }

    /// Finds the errors of the positions of rotary axes along themselves, from the rest of their targets' shifts.
    fn find_axial(&mut self, frame: &Twist) {
        let rule = &self.identified.frame;
        let left = (0..self.context.data.len()).map(|k| match rule.is_placed(k) {
            true => self.axial_shift(k, frame) - self.axial.row(k),
            false => RowDVector::zeros(self.sources.count),
        });
        let left = DMatrix::from_rows(&left.collect::<Vec<_>>());
        self.axial += rule.axial_places(&left);
    }

    /// Error of the mean shift of an axis' targets along the axis: one row.
    fn axial_shift(&self, k: usize, frame: &Twist) -> RowDVector<f64> {
        let along = self.turn(k) * self.context.axis(k).direction().into_inner();
        let mut sum = RowDVector::zeros(self.sources.count);
        let mut count = 0.0;
        for r in 0..self.context.data[k].runs.len() {
            for (shift, at) in self.targets(k, r) {
                sum += along.transpose() * (shift - frame.at(at));
                count += 1.0;
            }
        }
        sum / count
    }

    /// Errors of a station's position and dead path.
    pub(crate) fn station(&self, j: usize, in_ref: Point3<f64>, frame: &Twist) -> DMatrix<f64> {
        let first = self.sources.stations + 4 * j;
        let ref_from_datum = self.identified.state.ref_from_datum.rotation;
        let turn = ref_from_datum.to_rotation_matrix().into_inner();
        let mut rows = DMatrix::zeros(4, self.sources.count);
        let position = turn * self.pick(first) - frame.at(in_ref);
        rows.rows_mut(0, 3).copy_from(&position);
        rows[(3, first + 3)] = 1.0;
        rows
    }
}

/// Projection across a direction.
fn without(direction: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() - direction * direction.transpose()
}
