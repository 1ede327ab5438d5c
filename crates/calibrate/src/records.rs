//! The nine equations at every record of an axis, relative to the current model.
//!
//! With everything outside the axis under test (`B`) and inside it (`C`) taken from the model,
//!
//! ```text
//! Δ = B⁻¹ p - T(q) C r
//! ```
//!
//! is what the model of the axis itself leaves. The linear error model turns it into a correction
//! of the six component errors; as the prediction is exact, repeating this leaves no second-order
//! error (Newton's method on the pose).

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Matrix6xX, Point3, UnitQuaternion, Vector3, Vector6,
};
use trueaxis_campaign::Campaign;
use trueaxis_identify::{Operator, RigidMisfit, equations, nine, nine_weighted, rigid_misfit};
use trueaxis_kinematics::{Machine, MotionError};

use crate::axis_data::{AxisData, Record, RunData, points_of};
use crate::measured::Measured;
use crate::settings::Method;
use crate::state::{ModelErrors, State};
use crate::{Error, describe, in_order};

/// The pose of one record.
pub(crate) struct PoseFit {
    /// Component errors of this record alone, before the gauge.
    pub(crate) error: Vector6<f64>,
    /// What an unweighted rigid fit leaves of the volumetric errors, turned back to the stage at
    /// home, mm.
    pub(crate) distortion_mm: Vec<Vector3<f64>>,
    /// Distance of the farthest target from the reference point, mm.
    pub(crate) lever_mm: f64,
}

/// The identification of one record.
pub(crate) struct RecordFit {
    /// What was found.
    pub(crate) pose: PoseFit,
    /// How the component errors follow from displacements of the record's points in datum coordinates.
    pub(crate) from_points: Matrix6xX<f64>,
    /// Volumetric errors of the targets, seen from the base of the axis.
    pub(crate) deltas_mm: Vec<Vector3<f64>>,
    /// Generalised coordinates of the targets, mm.
    pub(crate) levers_mm: Vec<Vector3<f64>>,
    /// How what an unweighted rigid fit leaves follows from displacements of the record's points in datum coordinates.
    pub(crate) distortion_from_points: DMatrix<f64>,
    /// Rotations: base of the axis from datum, and stage at home from base.
    pub(crate) base_from_datum: Matrix3<f64>,
    pub(crate) stage_from_base: Matrix3<f64>,
    /// The rigid-body test.
    pub(crate) misfit: Misfit,
    /// Standard deviations of the components per unit noise of the points, by the method used and
    /// by nine equations without weights.
    pub(crate) noise_gain: Vector6<f64>,
    pub(crate) noise_gain_nine: Vector6<f64>,
}

/// Whether the points of a record move as a rigid body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Misfit {
    pub(crate) rms_um: f64,
    pub(crate) chi_squared: f64,
    pub(crate) degrees_of_freedom: usize,
}

impl From<&RigidMisfit> for Misfit {
    fn from(misfit: &RigidMisfit) -> Self {
        Self {
            rms_um: misfit.rms_um,
            chi_squared: misfit.chi_squared,
            degrees_of_freedom: misfit.degrees_of_freedom,
        }
    }
}

/// What is common to the records of an axis.
pub(crate) struct Context<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) machine: &'a Machine,
    pub(crate) measured: &'a Measured,
    /// The points, which a replay moves, mm.
    pub(crate) points_mm: &'a [Point3<f64>],
    pub(crate) method: Method,
}

/// What the other axes do to the targets of a run, during which they stand still.
struct Surroundings {
    base_from_datum: Isometry3<f64>,
    /// The targets on the stage as the axes inside it place them, the axis itself at home, mm.
    on_stage_mm: Vec<Point3<f64>>,
}

/// A record's pose with what it was found by.
struct SolvedPose {
    pose: PoseFit,
    deviation: Deviation,
    covariance: DMatrix<f64>,
    operator: Operator,
    /// All equations without weights.
    plain: Operator,
}

/// What the model leaves of the targets' places at one record.
struct Deviation {
    /// Volumetric errors, seen from the base of the axis, mm.
    deltas_mm: Vec<Vector3<f64>>,
    /// Generalised coordinates, mm.
    levers_mm: Vec<Vector3<f64>>,
    base_from_datum: Matrix3<f64>,
    stage_from_base: Matrix3<f64>,
    /// The component errors of the model.
    current: MotionError,
}

/// The axes before and after `axis` in the chain of a target.
pub(crate) fn around(machine: &Machine, carrier: usize, axis: usize) -> (&[usize], &[usize]) {
    let chain = machine.chain(carrier);
    let place = chain.iter().position(|&a| a == axis).unwrap_or(0);
    (&chain[..place], &chain[place + 1..])
}

impl<'a> Context<'a> {
    /// Positions of all axes at a record.
    pub(crate) fn positions_of(&self, record: &Record) -> &'a [f64] {
        &self.campaign.steps[self.measured.groups[record.group].step].positions
    }

    /// Identifies every record of the axis `data[index]`; `weights` are the covariances of
    /// [`crate::weights`].
    pub(crate) fn fit_records(
        &self,
        data: &[AxisData],
        state: &State,
        index: usize,
        weights: &[DMatrix<f64>],
    ) -> Result<Vec<RecordFit>, Error> {
        let surroundings = self.surroundings(data, state, index);
        in_order::try_map(weights.len(), |i| {
            let solved = self.solved(data, state, index, &surroundings, i, &weights[i])?;
            self.fit(&data[index], &data[index].records[i], solved)
        })
    }

    /// The poses alone of what [`Context::fit_records`] finds.
    pub(crate) fn fit_poses(
        &self,
        data: &[AxisData],
        state: &State,
        index: usize,
        weights: &[DMatrix<f64>],
    ) -> Result<Vec<PoseFit>, Error> {
        let surroundings = self.surroundings(data, state, index);
        in_order::try_map(weights.len(), |i| {
            let solved = self.solved(data, state, index, &surroundings, i, &weights[i])?;
            Ok(solved.pose)
        })
    }

    /// The points of a record in the order of its targets.
    pub(crate) fn points_of<'b>(
        &'b self,
        record: &'b Record,
    ) -> impl Iterator<Item = (usize, Point3<f64>)> + 'b {
        points_of(self.measured, self.points_mm, record)
    }

    /// The poses of an axis' records with the operators of `fits`.
    pub(crate) fn poses(
        &self,
        data: &[AxisData],
        state: &State,
        index: usize,
        fits: &[RecordFit],
    ) -> Vec<PoseFit> {
        let surroundings = self.surroundings(data, state, index);
        let records = data[index].records.iter().zip(fits);
        records
            .map(|(record, fit)| {
                fit.replayed(&self.deviation(data, state, index, &surroundings, record))
            })
            .collect()
    }

    /// For each run of the axis `data[index]`.
    fn surroundings(&self, data: &[AxisData], state: &State, index: usize) -> Vec<Surroundings> {
        let (own, values) = (&data[index], &state.axes[index]);
        let errors = ModelErrors { data, state };
        let of_run = |(run, homes_mm): (&RunData, &Vec<Point3<f64>>)| {
            let positions = self.positions_of(&own.records[run.first_record]);
            let mut base_from_datum = state.ref_from_datum;
            let mut on_stage_mm = Vec::with_capacity(homes_mm.len());
            for (&target, home) in run.targets.iter().zip(homes_mm) {
                let carrier = self.campaign.targets[target].carrier;
                let (outer, inner) = around(self.machine, carrier, own.axis);
                let base = self.machine.chain_motion(&errors, outer, positions);
                base_from_datum = base.inverse() * state.ref_from_datum;
                let inside = self.machine.chain_motion(&errors, inner, positions);
                on_stage_mm.push(inside * home);
            }
            Surroundings {
                base_from_datum,
                on_stage_mm,
            }
        };
        own.runs
            .iter()
            .zip(&values.targets_mm)
            .map(of_run)
            .collect()
    }

    fn deviation(
        &self,
        data: &[AxisData],
        state: &State,
        index: usize,
        surroundings: &[Surroundings],
        record: &Record,
    ) -> Deviation {
        let (own, values) = (&data[index], &state.axes[index]);
        let axis = &self.machine.axes()[own.axis];
        let node = &own.nodes[record.node];
        let current = values.curve[record.node];
        let motion = axis.motion(node.position, &values.location, &current);
        let reference = motion * axis.reference_at_home_mm(&values.location);

        let Surroundings {
            base_from_datum,
            on_stage_mm,
        } = &surroundings[record.run];
        let mut levers_mm = Vec::with_capacity(on_stage_mm.len());
        let mut deltas_mm = Vec::with_capacity(on_stage_mm.len());
        for ((_, point), on_stage) in self.points_of(record).zip(on_stage_mm) {
            let predicted = motion * on_stage;
            levers_mm.push(predicted - reference);
            deltas_mm.push(base_from_datum * point - predicted);
        }
        Deviation {
            deltas_mm,
            levers_mm,
            base_from_datum: base_from_datum.rotation.to_rotation_matrix().into_inner(),
            stage_from_base: motion.rotation.inverse().to_rotation_matrix().into_inner(),
            current,
        }
    }

    fn solved(
        &self,
        data: &[AxisData],
        state: &State,
        index: usize,
        surroundings: &[Surroundings],
        record: usize,
        weight: &DMatrix<f64>,
    ) -> Result<SolvedPose, Error> {
        let own = &data[index];
        let record = &own.records[record];
        let deviation = self.deviation(data, state, index, surroundings, record);
        let Deviation {
            deltas_mm,
            levers_mm,
            stage_from_base,
            current,
            ..
        } = &deviation;
        let covariance = rotated(weight, &deviation.base_from_datum);
        let operator = self
            .operator(levers_mm, &covariance)
            .map_err(|error| self.refused(own, record, &error))?;
        // The shape of the targets is what no rigid motion explains in the plain sense: unweighted,
        // so that it is the same function of the points at every record.
        let plain = nine(levers_mm).map_err(|error| self.refused(own, record, &error))?;
        let correction = operator.apply(deltas_mm);
        let mut distortion_mm = plain.residual_mm(deltas_mm);
        for v in &mut distortion_mm {
            *v = stage_from_base * *v;
        }
        let pose = PoseFit {
            error: composed(&correction, current).to_vector(),
            distortion_mm,
            lever_mm: farthest(levers_mm),
        };
        Ok(SolvedPose {
            pose,
            deviation,
            covariance,
            operator,
            plain,
        })
    }

    fn fit(&self, own: &AxisData, record: &Record, solved: SolvedPose) -> Result<RecordFit, Error> {
        let SolvedPose {
            pose,
            deviation,
            covariance,
            operator,
            plain,
        } = solved;
        let Deviation {
            deltas_mm,
            levers_mm,
            base_from_datum,
            stage_from_base,
            ..
        } = deviation;
        let misfit = rigid_misfit(&operator, &deltas_mm, &covariance)
            .map_err(|error| self.refused(own, record, &error))?;
        Ok(RecordFit {
            pose,
            from_points: rotated_columns(&operator.matrix(), &base_from_datum),
            noise_gain: operator.noise_gain(),
            noise_gain_nine: plain.noise_gain(),
            distortion_from_points: distortion(&plain, &stage_from_base, &base_from_datum),
            levers_mm,
            base_from_datum,
            stage_from_base,
            misfit: Misfit::from(&misfit),
            deltas_mm,
        })
    }

    fn operator(
        &self,
        levers_mm: &[Vector3<f64>],
        covariance: &DMatrix<f64>,
    ) -> Result<Operator, trueaxis_identify::Error> {
        match (self.method, levers_mm) {
            (Method::Nine, _) => nine_weighted(levers_mm, covariance),
            (Method::Six(rows), &[p, q, k]) => rows.operator(&[p, q, k]),
            (Method::Six(_), _) => {
                let (nominal, measured) = (3, levers_mm.len());
                Err(trueaxis_identify::Error::TargetCount { nominal, measured })
            }
        }
    }

    fn refused(&self, own: &AxisData, record: &Record, error: &trueaxis_identify::Error) -> Error {
        use trueaxis_identify::Error as Identify;
        let step = describe::step(self.campaign, self.measured.groups[record.group].step);
        let names: Vec<&str> = record
            .targets
            .iter()
            .map(|&(t, _)| self.campaign.targets[t].name.as_str())
            .collect();
        let names = names.join(", ");
        match error {
            Identify::Collinear { .. } => Error::NotIdentifiable {
                what: format!("{step}: targets {names}: {error}"),
                mend: "place one target well away from the line through the others".to_owned(),
            },
            Identify::BlindRows { .. } | Identify::SingularRows { .. } => Error::NotIdentifiable {
                what: format!("{step}: targets {names}: {error}"),
                mend: "use the method nine, or move a target".to_owned(),
            },
            Identify::TargetCount { measured, .. } => Error::NotIdentifiable {
                what: format!("{step}: the method six needs three targets, found {measured}"),
                mend: "use the method nine".to_owned(),
            },
            _ => Error::Numerical {
                axis: self.machine.axes()[own.axis].name().to_owned(),
                what: format!("{step}: {error}"),
            },
        }
    }
}

impl RecordFit {
    /// The pose for other points near the fitted ones, with the same operators.
    fn replayed(&self, deviation: &Deviation) -> PoseFit {
        let datum_from_base = self.base_from_datum.transpose();
        let mut deltas = DVector::zeros(3 * deviation.deltas_mm.len());
        for (i, delta) in deviation.deltas_mm.iter().enumerate() {
            deltas
                .fixed_rows_mut::<3>(3 * i)
                .copy_from(&(datum_from_base * delta));
        }
        let correction = MotionError::from_vector(&(&self.from_points * &deltas));
        let distortion = &self.distortion_from_points * &deltas;
        PoseFit {
            error: composed(&correction, &deviation.current).to_vector(),
            distortion_mm: (0..deviation.deltas_mm.len())
                .map(|i| distortion.fixed_rows::<3>(3 * i).into_owned())
                .collect(),
            lever_mm: farthest(&deviation.levers_mm),
        }
    }
}

fn farthest(levers_mm: &[Vector3<f64>]) -> f64 {
    levers_mm.iter().map(|r| r.norm()).fold(0.0, f64::max)
}

/// `Q (I - A P) R`: residuals of an unweighted rigid fit, turned to the stage at home, from
/// displacements in the datum.
fn distortion(
    plain: &Operator,
    stage_from_base: &Matrix3<f64>,
    base_from_datum: &Matrix3<f64>,
) -> DMatrix<f64> {
    let size = 3 * plain.targets_mm().len();
    let residual = DMatrix::identity(size, size) - equations(plain.targets_mm()) * plain.matrix();
    let mut turned = residual.clone();
    for i in 0..size / 3 {
        for j in 0..size / 3 {
            let block =
                stage_from_base * residual.fixed_view::<3, 3>(3 * i, 3 * j) * base_from_datum;
            turned
                .fixed_view_mut::<3, 3>(3 * i, 3 * j)
                .copy_from(&block);
        }
    }
    turned
}

/// `exp(ε₂) exp(ε₁)` and the sum of the translations: a correction on top of an error.
fn composed(correction: &MotionError, current: &MotionError) -> MotionError {
    let turn = |e: &MotionError| UnitQuaternion::from_scaled_axis(e.rotation_rad);
    MotionError::new(
        correction.translation_mm + current.translation_mm,
        (turn(correction) * turn(current)).scaled_axis(),
    )
}

/// `Q C Qᵀ` with the same rotation for every point.
pub(crate) fn rotated(covariance: &DMatrix<f64>, rotation: &Matrix3<f64>) -> DMatrix<f64> {
    let points = covariance.nrows() / 3;
    let mut turned = covariance.clone();
    for i in 0..points {
        for j in 0..=i {
            let block =
                rotation * covariance.fixed_view::<3, 3>(3 * i, 3 * j) * rotation.transpose();
            // Symmetric to the last bit, as the identification asks.
            let block = match i == j {
                true => (block + block.transpose()) * 0.5,
                false => block,
            };
            turned
                .fixed_view_mut::<3, 3>(3 * i, 3 * j)
                .copy_from(&block);
            turned
                .fixed_view_mut::<3, 3>(3 * j, 3 * i)
                .copy_from(&block.transpose());
        }
    }
    turned
}

/// `P Q` with the same rotation for every point.
fn rotated_columns(matrix: &Matrix6xX<f64>, rotation: &Matrix3<f64>) -> Matrix6xX<f64> {
    let mut turned = matrix.clone();
    for j in 0..matrix.ncols() / 3 {
        let block = matrix.fixed_columns::<3>(3 * j) * rotation;
        turned.fixed_columns_mut::<3>(3 * j).copy_from(&block);
    }
    turned
}
