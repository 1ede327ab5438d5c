//! Standard uncertainties of component errors, location errors and stations.
//!
//! Component errors do not depend on the reference frame: the gauge removes a rigid motion of the
//! whole. Location errors and stations do, and they take over the errors of axes that stand still
//! while another one is measured.

use nalgebra::{DMatrix, Isometry3, Matrix3, Matrix3xX, Point3, RowDVector, Vector3};
use trueaxis_kinematics::{AxisKind, GeometricErrors, LocationError};

use crate::axis_data::AxisData;
use crate::basis::Basis;
use crate::frame::SmallMotion;
use crate::identify_axes::Identified;
use crate::records::{Context, around};
use crate::sources::{Sources, noise_of};
use crate::state::ModelErrors;
use crate::twist::Twist;

/// Standard uncertainties of one axis' component errors: for each node δ (mm) and ε (rad).
pub(crate) fn of_components(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    k: usize,
) -> Vec<[f64; 6]> {
    let (axis, fits) = (&data[k], &identified.fits[k]);
    let sensitivity = &identified.sensitivities[k];
    let shared = context.measured.noise.shared();
    let width = sensitivity.width();
    // Covariance of the parameters from each record's own noise, their shared part, and for each
    // node the records' own parts.
    let mut own = DMatrix::zeros(width, width);
    let mut parameters_shared = DMatrix::zeros(width, shared.nrows());
    let nodes = axis.nodes.len();
    let mut node_own = vec![DMatrix::zeros(6, 6); nodes];
    let mut node_cross = vec![DMatrix::zeros(6, width); nodes];
    let mut node_shared = vec![DMatrix::zeros(6, shared.nrows()); nodes];
    for (i, record) in axis.records.iter().enumerate() {
        let (d, z) = noise_of(context.measured, axis, i);
        let from_points = &fits[i].from_points;
        let parameters = &sensitivity.parameters[i];
        let weight = 1.0 / axis.nodes[record.node].records as f64;
        let pose_noise = from_points * &d * weight;
        own += parameters * &d * parameters.transpose();
        parameters_shared += parameters * &z;
        node_own[record.node] += &pose_noise * from_points.transpose() * weight;
        node_cross[record.node] += pose_noise * parameters.transpose();
        node_shared[record.node] += from_points * z * weight;
    }
    (0..nodes)
        .map(|node| {
            let effect = &sensitivity.node_effects[node];
            let cross = &node_cross[node] * effect.transpose();
            let through = &node_shared[node] - effect * &parameters_shared;
            let variance =
                effect * &own * effect.transpose() + &node_own[node] - &cross - cross.transpose()
                    + &through * &shared * through.transpose();
            std::array::from_fn(|c| variance[(c, c)].max(0.0).sqrt())
        })
        .collect()
}

/// Standard uncertainties of everything that depends on the frame.
pub(crate) struct FrameDependent {
    /// For each axis, in the order of the data: shifts (mm) and tilts (rad) as a
    /// [`LocationError`] of uncertainties.
    pub(crate) locations: Vec<LocationError>,
    /// For each station x y z (mm) and dead path (mm).
    pub(crate) stations: Vec<[f64; 4]>,
}

/// Propagates to location errors and stations.
pub(crate) fn of_frame_dependent(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    stations_in_ref: &[Point3<f64>],
) -> FrameDependent {
    let sources = Sources::new(context, data, identified, stations_in_ref.len());
    let mut map = FrameMap {
        context,
        data,
        identified,
        sources: &sources,
        axial: vec![RowDVector::zeros(sources.count); data.len()],
    };
    let frame = map.frame();
    map.find_axial(&frame);
    let locations = (0..data.len()).map(|k| map.location(k, &frame)).collect();
    let stations = (0..stations_in_ref.len())
        .map(|j| map.station(j, stations_in_ref[j], &frame))
        .collect();
    FrameDependent {
        locations,
        stations,
    }
}

/// Linear maps from the sources to results.
struct FrameMap<'a> {
    context: &'a Context<'a>,
    data: &'a [AxisData],
    identified: &'a Identified,
    sources: &'a Sources,
    /// For each axis the error of its place along itself; zero for linear axes.
    axial: Vec<RowDVector<f64>>,
}

/// The place of an axis along itself depends on those of the axes it shares targets with; they are
/// across it but for its errors, so the second sweep confirms the first.
const AXIAL_SWEEPS: usize = 3;

impl FrameMap<'_> {
    fn errors(&self) -> ModelErrors<'_> {
        ModelErrors {
            data: self.data,
            state: &self.identified.state,
        }
    }

    /// Three rows that pick three consecutive sources.
    fn pick(&self, first: usize) -> Matrix3xX<f64> {
        Matrix3xX::from_fn(
            self.sources.count,
            |i, j| {
                if j == first + i { 1.0 } else { 0.0 }
            },
        )
    }

    /// A vector across an axis whose two coordinates are consecutive sources.
    fn across(&self, k: usize, first: usize) -> Matrix3xX<f64> {
        let basis = Basis::of(&self.context.machine.axes()[self.data[k].axis]);
        let mut rows = Matrix3xX::zeros(self.sources.count);
        for (i, direction) in basis.across.iter().enumerate() {
            rows.column_mut(first + i).copy_from(direction);
        }
        rows
    }

    /// The error motion of axis `k` where it stands, in the frame of its own base.
    fn twist_of(&self, k: usize, position: f64) -> Twist {
        let axis = &self.context.machine.axes()[self.data[k].axis];
        let location = self.identified.state.axes[k].location;
        let errors = self.errors();
        let error = errors.motion(self.data[k].axis, position);
        let motion = axis.motion(position, &location, &error);
        let at_home = axis.reference_at_home_mm(&location);
        let (mut displacement, mut rotation) = match self.sources.held_at(k, position) {
            Some(first) => (self.pick(first), self.pick(first + 3)),
            None => (
                Matrix3xX::zeros(self.sources.count),
                Matrix3xX::zeros(self.sources.count),
            ),
        };
        let first = self.sources.location[k];
        match axis.kind() {
            AxisKind::Linear => {
                let along = axis.direction().into_inner() * position;
                displacement += -along.cross_matrix() * self.across(k, first);
            }
            AxisKind::Rotary => {
                let turn = axis
                    .commanded_motion(position, &LocationError::default())
                    .rotation;
                let left = Matrix3::identity() - turn.to_rotation_matrix().into_inner();
                displacement += left * self.across(k, first);
                displacement += axis.direction().into_inner() * &self.axial[k];
                rotation += left * self.across(k, first + 2);
            }
        }
        Twist::about(motion * at_home, displacement, rotation)
    }

    /// The error motion of some axes in the reference frame, given in the order of a chain that
    /// starts at the bed; `skip` is the axis under test, which stands at home.
    fn twist_of_chain(&self, chain: &[usize], skip: usize, positions: &[f64]) -> Twist {
        let errors = self.errors();
        let mut sum = Twist::zero(self.sources.count);
        let mut before = Isometry3::identity();
        for &axis in chain.iter().filter(|&&axis| axis != skip) {
            if let Some(k) = self.data.iter().position(|data| data.axis == axis) {
                sum.add(&self.twist_of(k, positions[axis]).seen_from(&before));
            }
            before *= self
                .context
                .machine
                .chain_motion(&errors, &[axis], positions);
        }
        sum
    }

    /// The axis' base: motion of what is outside it, and the error motion of that.
    fn base(&self, k: usize) -> (Isometry3<f64>, Twist) {
        let axis = &self.data[k];
        let Some(run) = axis.runs.first() else {
            return (Isometry3::identity(), Twist::zero(self.sources.count));
        };
        let positions = self.context.positions_of(&axis.records[run.first_record]);
        let target = run.targets.first().copied().unwrap_or(0);
        let carrier = self.context.campaign.targets[target].carrier;
        let (outer, _) = around(self.context.machine, carrier, axis.axis);
        let motion = self
            .context
            .machine
            .chain_motion(&self.errors(), outer, positions);
        (motion, self.twist_of_chain(outer, axis.axis, positions))
    }

    /// Error of a target's home position in the reference frame before the frame is settled, and
    /// where the target is.
    fn target(&self, k: usize, run: usize, place: usize) -> (Matrix3xX<f64>, Point3<f64>) {
        let axis = &self.data[k];
        let content = &axis.runs[run];
        let positions = self
            .context
            .positions_of(&axis.records[content.first_record]);
        let carrier = self.context.campaign.targets[content.targets[place]].carrier;
        let chain = self.context.machine.chain(carrier);
        let errors = self.errors();
        let others: Vec<usize> = chain.iter().copied().filter(|&a| a != axis.axis).collect();
        let motion = self
            .context
            .machine
            .chain_motion(&errors, &others, positions);
        let home = self.identified.state.axes[k].targets_mm[run][place];
        let turn = motion.rotation.to_rotation_matrix().into_inner();
        let own = turn * self.pick(self.sources.targets[k][run][place]);
        let shift = own
            - self
                .twist_of_chain(chain, axis.axis, positions)
                .at(motion * home);
        (shift, motion * home)
    }

    /// The error motion of the frame.
    fn frame(&self) -> Twist {
        let rule = &self.identified.frame;
        let tilts: Vec<Matrix3xX<f64>> = rule.lines.iter().map(|&(k, _)| self.tilt(k)).collect();
        let shifts: Vec<Matrix3xX<f64>> = rule
            .anchors
            .iter()
            .map(|anchor| self.target(anchor.data, anchor.run, anchor.place).0)
            .collect();
        // The rule is linear: one column at a time.
        let column = |m: &Matrix3xX<f64>, j: usize| Vector3::new(m[(0, j)], m[(1, j)], m[(2, j)]);
        let mut displacement = Matrix3xX::zeros(self.sources.count);
        let mut rotation = Matrix3xX::zeros(self.sources.count);
        let mut pivot = Point3::origin();
        for j in 0..self.sources.count {
            let tilts: Vec<_> = tilts.iter().map(|m| column(m, j)).collect();
            let shifts: Vec<_> = shifts.iter().map(|m| column(m, j)).collect();
            let motion: SmallMotion = rule.motion(&tilts, &shifts);
            displacement.column_mut(j).copy_from(&motion.translation);
            rotation.column_mut(j).copy_from(&motion.rotation);
            pivot = motion.pivot;
        }
        Twist::about(pivot, displacement, rotation)
    }

    /// Error of the average direction's tilt in the reference frame, before the frame is settled.
    fn tilt(&self, k: usize) -> Matrix3xX<f64> {
        let axis = &self.context.machine.axes()[self.data[k].axis];
        let (base, carried) = self.base(k);
        let turn = base.rotation.to_rotation_matrix().into_inner();
        let first = match axis.kind() {
            AxisKind::Linear => self.sources.location[k],
            AxisKind::Rotary => self.sources.location[k] + 2,
        };
        let across = without(turn * axis.direction().into_inner());
        turn * self.across(k, first) - across * carried.rotation
    }

    /// Standard uncertainties of an axis' location errors.
    fn location(&self, k: usize, frame: &Twist) -> LocationError {
        let axis = &self.context.machine.axes()[self.data[k].axis];
        let (base, carried) = self.base(k);
        let turn = base.rotation.to_rotation_matrix().into_inner();
        let direction = turn * axis.direction().into_inner();
        let across = without(direction);
        let tilt = turn.transpose() * (self.tilt(k) - across * &frame.rotation);
        let tilt_rad = self.standard(&tilt);
        if axis.kind() == AxisKind::Linear {
            return LocationError {
                offset_mm: Vector3::zeros(),
                tilt_rad,
            };
        }
        let centre = base * axis.reference_at_home_mm(&self.identified.state.axes[k].location);
        let moved = carried.at(centre) + frame.at(centre);
        let mut shift = turn * self.across(k, self.sources.location[k]) - across * moved;
        shift += direction * &self.axial[k];
        let shift = turn.transpose() * shift;
        LocationError {
            offset_mm: self.standard(&shift),
            tilt_rad,
        }
    }

    /// Finds the errors of the places of rotary axes along themselves.
    fn find_axial(&mut self, frame: &Twist) {
        for _ in 0..AXIAL_SWEEPS {
            for k in 0..self.data.len() {
                let index = self.data[k].axis;
                let rotary = self.context.machine.axes()[index].kind() == AxisKind::Rotary;
                if rotary && self.identified.frame.places_along_itself(index) {
                    self.axial[k] = self.axial_shift(k, frame);
                }
            }
        }
    }

    /// Error of the mean shift of an axis' targets along it: one row.
    fn axial_shift(&self, k: usize, frame: &Twist) -> RowDVector<f64> {
        let axis = &self.data[k];
        let (base, _) = self.base(k);
        let along = base.rotation * self.context.machine.axes()[axis.axis].direction();
        let mut sum = RowDVector::zeros(self.sources.count);
        let mut count = 0.0;
        for (r, run) in axis.runs.iter().enumerate() {
            for place in 0..run.targets.len() {
                let (shift, at) = self.target(k, r, place);
                sum += along.transpose() * (shift - frame.at(at));
                count += 1.0;
            }
        }
        sum / count
    }

    fn station(&self, j: usize, in_ref: Point3<f64>, frame: &Twist) -> [f64; 4] {
        let first = self.sources.stations + 4 * j;
        let turn = self
            .identified
            .state
            .ref_from_datum
            .rotation
            .to_rotation_matrix()
            .into_inner();
        let own = turn * self.pick(first) - frame.at(in_ref);
        let position = self.standard(&own);
        let dead_path = self.sources.covariance[(first + 3, first + 3)]
            .max(0.0)
            .sqrt();
        [position.x, position.y, position.z, dead_path]
    }

    /// Standard deviations of three linear functions of the sources.
    fn standard(&self, rows: &Matrix3xX<f64>) -> Vector3<f64> {
        let covariance = rows * &self.sources.covariance * rows.transpose();
        covariance
            .diagonal()
            .map(|variance| variance.max(0.0).sqrt())
    }
}

/// Projection across a direction.
fn without(direction: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() - direction * direction.transpose()
}
