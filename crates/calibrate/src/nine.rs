//! Poses from points: the nine equations of each step (paper Eqs. 20 and 21), or six of them.
//!
//! The points of a step are tied to the pose of their body by `p = P r`. The shape `r` of the body is not
//! known beforehand; it is nominal plus the mean over all steps of what no rigid motion explains,
//! `w = mean Π Q_i dp_i` (`Q`: home from datum, `Π`: what is left after an unweighted rigid fit), so that it
//! is the same function of the points at every step. With the operator `G_i` of a step
//!
//! ```text
//! x_i = G_i (dp_i - Q_iᵀ w)
//! ```
//!
//! and the noise of the points ([`crate::points`]) the errors of the poses have the form of
//! [`crate::poses`], in which each body's shape adds two sets of shared sources:
//!
//! ```text
//! Z = [G Z_p - S W_z | S | N]     S = G Qᵀ     N = G D Qᵀ Πᵀ / n     cov = | W  -1 |
//!                                                                        | -1  0 |
//! ```
//!
//! with `W = Σ Π Q D Qᵀ Πᵀ / n²` and `W_z = Σ Π Q Z_p / n`. The nine equations are weighted with the
//! covariance of what they are about,
//!
//! ```text
//! C_i = D_i - (D_i V_iᵀ + V_i D_i) / n + Q_iᵀ W Q_i + T_i Σ T_iᵀ     V = Qᵀ Π Q     T = Z_p - Qᵀ W_z
//! ```
//!
//! Weighting with the covariance of the points alone would trust the shape as if it were exact, and take
//! what the stations' errors do to the shape for a rotation.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Matrix6, Matrix6xX, Point3, Vector3, Vector6};
use trueaxis_campaign::Campaign;
use trueaxis_identify::{
    Error as Identify, Operator, RigidMisfit, equations, nine, nine_weighted, rigid_misfit,
};
use trueaxis_kinematics::{Ideal, Machine};

use crate::points::{MeasuredPoints, PointNoise};
use crate::poses::{PoseNoise, PoseObservation, Poses, TargetBody, turned_about};
use crate::rigid_fit::centroid;
use crate::settings::Method;
use crate::{Error, describe, in_order};

/// Poses with the test of each step.
pub(crate) struct PointPoses {
    pub(crate) poses: Poses,
    /// One for each observation.
    pub(crate) fits: Vec<StepFit>,
    /// The measured group and the places of its points, for each observation.
    pub(crate) groups: Vec<(usize, Vec<usize>)>,
}

/// The equations of one step at their solution.
pub(crate) struct StepFit {
    /// Targets from the pivot, datum, mm.
    pub(crate) levers_mm: Vec<Vector3<f64>>,
    /// Measured minus predicted points, datum, mm.
    pub(crate) deltas_mm: Vec<Vector3<f64>>,
    /// What an unweighted rigid fit leaves of the points against the shape, turned home, mm.
    pub(crate) distortion_mm: Vec<Vector3<f64>>,
    /// Rotation home from datum.
    pub(crate) home_from_datum: Matrix3<f64>,
    /// `C`.
    pub(crate) covariance: DMatrix<f64>,
    /// How the pose follows from displacements of the points.
    pub(crate) from_points: Matrix6xX<f64>,
    /// `Π Q`.
    to_shape: DMatrix<f64>,
    pub(crate) misfit: Misfit,
    /// Standard deviations of the component errors at the axis' reference point per unit noise of the
    /// points, by the method used and by nine equations without weights.
    pub(crate) noise_gain: [Vector6<f64>; 2],
}

/// Whether the points of a step move as a rigid body.
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

/// A step on its way to a pose.
struct Step {
    group: usize,
    places: Vec<usize>,
    body: usize,
    /// Nominal motion of the body from home.
    nominal: Isometry3<f64>,
    covariance: DMatrix<f64>,
}

/// Shapes are settled when no coordinate changes by more, mm.
const SETTLED_MM: f64 = 1e-10;

/// Each pass leaves a ten-thousandth (the size of the errors in rad) of the change before it.
const MAX_PASSES: usize = 60;

/// Targets needed to see six component errors.
const MIN_TARGETS: usize = 3;

/// The poses of all steps whose targets move with the axis under test; `machine` has the reference points
/// that noise gains belong to.
pub(crate) fn poses_from_points(
    campaign: &Campaign,
    machine: &Machine,
    points: &MeasuredPoints,
    method: Method,
) -> Result<PointPoses, Error> {
    let (mut bodies, mut steps) = bodies_and_steps(campaign, points)?;
    let shapes: Vec<Shape> = (0..bodies.len())
        .map(|body| Shape::new(&bodies[body], &steps, body, &points.noise))
        .collect();
    let covariances = in_order::map(steps.len(), |i| {
        shapes[steps[i].body].weight(&steps[i], &points.noise)
    });
    for (step, covariance) in steps.iter_mut().zip(covariances) {
        step.covariance = covariance;
    }
    let work = Work {
        campaign,
        machine,
        points,
        method,
        steps: &steps,
    };
    let mut poses: Vec<Isometry3<f64>> = steps.iter().map(|step| step.nominal).collect();
    for _ in 0..MAX_PASSES {
        let found = in_order::try_map(steps.len(), |i| work.improved(&bodies, i, &poses[i]))?;
        let mut change_mm = move_shapes(&mut bodies, &steps, &shapes, &found);
        for (pose, (next, _, moved_mm)) in poses.iter_mut().zip(found) {
            *pose = next;
            change_mm = change_mm.max(moved_mm);
        }
        if change_mm <= SETTLED_MM {
            break;
        }
    }
    let fits = in_order::try_map(steps.len(), |i| work.fit((&bodies, &shapes), i, &poses[i]))?;
    let noise = |noise: &PointNoise| pose_noise(noise, points, &steps, &shapes, &fits);
    let observations = steps.iter().zip(&poses).map(|(step, pose)| {
        let group = &points.groups[step.group];
        PoseObservation {
            step: group.step,
            direction: group.direction,
            body: step.body,
            datum_from_home: *pose,
            pivot_mm: pose * centroid(&bodies[step.body].home_mm),
        }
    });
    Ok(PointPoses {
        poses: Poses {
            observations: observations.collect(),
            noise: noise(&points.noise),
            instrument: noise(&points.instrument),
            relative_covariance: points.relative_covariance,
            bodies,
        },
        groups: steps.into_iter().map(|step| (step.group, step.places)).collect(),
        fits,
    })
}

/// The bodies with their nominal shapes. Targets that were not measured at every step of a run are left
/// out: the shape must be the same function of the points at every step.
fn bodies_and_steps(
    campaign: &Campaign,
    points: &MeasuredPoints,
) -> Result<(Vec<TargetBody>, Vec<Step>), Error> {
    let machine = &campaign.machine;
    let mut common: Vec<Option<Vec<usize>>> = vec![None; campaign.runs.len()];
    for group in &points.groups {
        let run = campaign.steps[group.step].run;
        let axis = campaign.runs[run].axis;
        let moved = |t: &&usize| machine.chain(campaign.targets[**t].carrier).contains(&axis);
        let moved: Vec<usize> = group.targets.iter().filter(moved).copied().collect();
        if moved.len() < MIN_TARGETS {
            return Err(Error::NotIdentifiable {
                what: format!(
                    "{}: {} of the targets that {} moves were measured, three are needed to see \
                     its six component errors",
                    describe::step(campaign, group.step),
                    moved.len(),
                    machine.axes()[axis].name(),
                ),
                mend: "measure the missing targets there, or leave out the rows of this step"
                    .to_owned(),
            });
        }
        match &mut common[run] {
            Some(common) => common.retain(|t| moved.contains(t)),
            none => *none = Some(moved),
        }
        let left = common[run].as_ref().map_or(0, Vec::len);
        if left < MIN_TARGETS {
            return Err(Error::NotIdentifiable {
                what: format!(
                    "run {}: only {left} target(s) were measured at all of its steps, three are needed \
                     (one is missing in {})",
                    campaign.runs[run].name,
                    describe::step(campaign, group.step),
                ),
                mend: "measure the missing targets, or leave out the rows of the steps that lack \
                       them"
                    .to_owned(),
            });
        }
    }
    let mut keys: Vec<(Option<usize>, Vec<usize>)> = Vec::new();
    let (mut bodies, mut steps) = (Vec::new(), Vec::new());
    for (number, group) in points.groups.iter().enumerate() {
        let step = &campaign.steps[group.step];
        let targets = common[step.run].clone().unwrap_or_default();
        let carrier_of = |t: &usize| campaign.targets[*t].carrier;
        let depth = |carrier: &usize| machine.chain(*carrier).len();
        let outermost = targets.iter().map(carrier_of).max_by_key(depth);
        let outermost = outermost.unwrap_or(campaign.runs[step.run].axis);
        let one_carrier = targets.iter().all(|t| carrier_of(t) == outermost);
        let nominal = machine.motion(&Ideal, outermost, &step.positions);
        // On several carriers targets are one body during this run only, and at home where the
        // outermost carrier would bring them from.
        let key = ((!one_carrier).then_some(step.run), targets.clone());
        let body = keys.iter().position(|known| *known == key).unwrap_or_else(|| {
            let home = |t: &usize| {
                let home_mm = campaign.targets[*t].home_mm;
                nominal.inverse()
                    * machine.position(&Ideal, carrier_of(t), &step.positions, home_mm)
            };
            let home_mm = targets.iter().map(home).collect();
            bodies.push(TargetBody {
                targets: targets.clone(),
                home_mm,
            });
            keys.push(key);
            keys.len() - 1
        });
        let place = |t: &usize| group.targets.iter().position(|seen| seen == t);
        steps.push(Step {
            group: number,
            places: targets.iter().filter_map(place).collect(),
            body,
            nominal,
            covariance: DMatrix::zeros(0, 0),
        });
    }
    Ok((bodies, steps))
}

/// The shape of a body as a function of the points, and its noise; both zero for a body of a single step, which is all the shape there is,
/// and for targets on a line, which the identification refuses.
#[derive(Clone)]
struct Shape {
    /// `Π`.
    projection: DMatrix<f64>,
    /// Number of steps `n`.
    steps: f64,
    /// `W` and `W_z`.
    own: DMatrix<f64>,
    coupling: DMatrix<f64>,
}

impl Shape {
    fn new(body: &TargetBody, steps: &[Step], number: usize, noise: &PointNoise) -> Self {
        let size = 3 * body.home_mm.len();
        let count = steps.iter().filter(|step| step.body == number).count();
        let centre = centroid(&body.home_mm);
        let levers: Vec<Vector3<f64>> = body.home_mm.iter().map(|p| p - centre).collect();
        let projection = match nine(&levers) {
            Ok(plain) if count > 1 => {
                DMatrix::identity(size, size) - equations(&levers) * plain.matrix()
            }
            _ => DMatrix::zeros(size, size),
        };
        Self {
            projection,
            steps: count as f64,
            own: DMatrix::zeros(0, 0),
            coupling: DMatrix::zeros(0, 0),
        }
        .with_noise(steps, number, noise)
    }

    /// The same shape with other noise of the points.
    fn with_noise(&self, steps: &[Step], number: usize, noise: &PointNoise) -> Self {
        let size = self.projection.nrows();
        let of_body: Vec<&Step> = steps.iter().filter(|step| step.body == number).collect();
        let zero = || DMatrix::zeros(size, size + noise.shared.nrows());
        let sums = in_order::sum(of_body.len(), zero, |sum, i| {
            let step = of_body[i];
            let (d, z) = noise.of(step.group, &step.places);
            let turned = turned_columns(&self.projection, &home_from_datum(step));
            let mut own = sum.columns_mut(0, size);
            own.gemm(1.0, &(&turned * d), &turned.transpose(), 1.0);
            let mut coupling = sum.columns_mut(size, z.ncols());
            coupling.gemm(1.0, &turned, &z, 1.0);
        });
        Self {
            own: sums.columns(0, size) / (self.steps * self.steps),
            coupling: sums.columns(size, noise.shared.nrows()) / self.steps,
            ..self.clone()
        }
    }

    /// `C`, symmetric to the last bit, as the identification asks.
    fn weight(&self, step: &Step, noise: &PointNoise) -> DMatrix<f64> {
        let (d, z) = noise.of(step.group, &step.places);
        let turn = home_from_datum(step);
        let seen_from_datum =
            |matrix: &DMatrix<f64>| turned_columns(&turned_rows(matrix, &turn.transpose()), &turn);
        let cross = &d * seen_from_datum(&self.projection) / self.steps;
        let through = z - turned_rows(&self.coupling, &turn.transpose());
        let c = d + seen_from_datum(&self.own) - &cross - cross.transpose()
            + &through * &noise.shared * through.transpose();
        (&c + c.transpose()) * 0.5
    }
}

/// `Q`, nominal.
fn home_from_datum(step: &Step) -> Matrix3<f64> {
    let turn = step.nominal.rotation.inverse();
    turn.to_rotation_matrix().into_inner()
}

/// `A Q` with the same rotation for every point.
fn turned_columns(matrix: &DMatrix<f64>, rotation: &Matrix3<f64>) -> DMatrix<f64> {
    let mut turned = matrix.clone();
    for j in (0..matrix.ncols()).step_by(3) {
        let block = matrix.fixed_columns::<3>(j) * rotation;
        turned.fixed_columns_mut::<3>(j).copy_from(&block);
    }
    turned
}

/// `Q A` with the same rotation for every point.
fn turned_rows(matrix: &DMatrix<f64>, rotation: &Matrix3<f64>) -> DMatrix<f64> {
    let mut turned = matrix.clone();
    for i in (0..matrix.nrows()).step_by(3) {
        let block = rotation * matrix.fixed_rows::<3>(i);
        turned.fixed_rows_mut::<3>(i).copy_from(&block);
    }
    turned
}

/// Adds to each shape the mean of what no rigid motion explains; returns the largest change, mm.
fn move_shapes(
    bodies: &mut [TargetBody],
    steps: &[Step],
    shapes: &[Shape],
    found: &[(Isometry3<f64>, Vec<Vector3<f64>>, f64)],
) -> f64 {
    let mut change_mm = 0.0_f64;
    for (number, (body, shape)) in bodies.iter_mut().zip(shapes).enumerate() {
        for (place, home) in body.home_mm.iter_mut().enumerate() {
            let of_body = steps.iter().zip(found).filter(|(step, _)| step.body == number);
            let sum: Vector3<f64> = of_body.map(|(_, (_, distortion, _))| distortion[place]).sum();
            let mean = sum / shape.steps;
            *home += mean;
            change_mm = change_mm.max(mean.norm());
        }
    }
    change_mm
}

/// What is common to all steps.
struct Work<'a> {
    campaign: &'a Campaign,
    machine: &'a Machine,
    points: &'a MeasuredPoints,
    method: Method,
    steps: &'a [Step],
}

impl Work<'_> {
    /// Levers from the pivot and volumetric errors relative to a pose, mm.
    fn errors(
        &self,
        bodies: &[TargetBody],
        i: usize,
        pose: &Isometry3<f64>,
    ) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let step = &self.steps[i];
        let shape_mm = &bodies[step.body].home_mm;
        let pivot = pose * centroid(shape_mm);
        let points_mm = &self.points.groups[step.group].points_mm;
        let of_target = |(home, &place): (&Point3<f64>, &usize)| {
            let predicted = pose * home;
            (predicted - pivot, points_mm[place] - predicted)
        };
        shape_mm.iter().zip(&step.places).map(of_target).unzip()
    }

    /// A better pose, the distortion of the points (home, mm), and by how much the pose moved, mm.
    fn improved(
        &self,
        bodies: &[TargetBody],
        i: usize,
        pose: &Isometry3<f64>,
    ) -> Result<(Isometry3<f64>, Vec<Vector3<f64>>, f64), Error> {
        let (levers, deltas) = self.errors(bodies, i, pose);
        let operator = self.operator(i, &levers)?;
        let plain = nine(&levers).map_err(|error| self.refused(i, &error))?;
        let home_from_datum = pose.rotation.inverse();
        let distortion = plain.residual_mm(&deltas).into_iter();
        let distortion = distortion.map(|v| home_from_datum * v).collect();
        let correction = operator.apply(&deltas);
        let pivot = pose * centroid(&bodies[self.steps[i].body].home_mm);
        let reach_mm = levers.iter().map(|r| r.norm()).fold(0.0, f64::max);
        let moved_mm =
            correction.translation_mm.norm() + reach_mm * correction.rotation_rad.norm();
        Ok((
            turned_about(&pivot, &correction.to_vector()) * pose,
            distortion,
            moved_mm,
        ))
    }

    fn fit(
        &self,
        (bodies, shapes): (&[TargetBody], &[Shape]),
        i: usize,
        pose: &Isometry3<f64>,
    ) -> Result<StepFit, Error> {
        let step = &self.steps[i];
        let (levers_mm, deltas_mm) = self.errors(bodies, i, pose);
        let operator = self.operator(i, &levers_mm)?;
        let plain = nine(&levers_mm).map_err(|error| self.refused(i, &error))?;
        let misfit = rigid_misfit(&operator, &deltas_mm, &step.covariance)
            .map_err(|error| self.refused(i, &error))?;
        let home_from_datum = pose.rotation.inverse();
        let turn = home_from_datum.to_rotation_matrix().into_inner();
        let distortion = plain.residual_mm(&deltas_mm).into_iter();
        let at_reference = self.at_reference(i, &(pose * centroid(&bodies[step.body].home_mm)));
        let gain = |operator: &Operator| {
            let rows = at_reference * operator.matrix();
            Vector6::from_fn(|c, _| rows.row(c).norm())
        };
        Ok(StepFit {
            distortion_mm: distortion.map(|v| home_from_datum * v).collect(),
            home_from_datum: turn,
            to_shape: turned_columns(&shapes[step.body].projection, &turn),
            covariance: step.covariance.clone(),
            from_points: operator.matrix(),
            misfit: Misfit::from(&misfit),
            noise_gain: [gain(&operator), gain(&plain)],
            levers_mm,
            deltas_mm,
        })
    }

    /// δ at the axis' reference point and ε from those at the pivot.
    fn at_reference(&self, i: usize, pivot_mm: &Point3<f64>) -> Matrix6<f64> {
        let group = &self.points.groups[self.steps[i].group];
        let step = &self.campaign.steps[group.step];
        let axis = self.campaign.runs[step.run].axis;
        let motion = self.machine.motion(&Ideal, axis, &step.positions);
        let arm_mm = motion * self.machine.axes()[axis].reference_mm() - pivot_mm;
        let mut map = Matrix6::identity();
        map.fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&-arm_mm.cross_matrix());
        map
    }

    fn operator(&self, i: usize, levers_mm: &[Vector3<f64>]) -> Result<Operator, Error> {
        let operator = match (self.method, levers_mm) {
            (Method::Six(rows), &[p, q, k]) => rows.operator(&[p, q, k]),
            (Method::Six(_), _) => {
                let (nominal, measured) = (MIN_TARGETS, levers_mm.len());
                Err(Identify::TargetCount { nominal, measured })
            }
            _ => nine_weighted(levers_mm, &self.steps[i].covariance),
        };
        operator.map_err(|error| self.refused(i, &error))
    }

    fn refused(&self, i: usize, error: &Identify) -> Error {
        let step = &self.steps[i];
        let group = &self.points.groups[step.group];
        let in_words = describe::step(self.campaign, group.step);
        let name = |&place: &usize| self.campaign.targets[group.targets[place]].name.as_str();
        let names = step.places.iter().map(name).collect::<Vec<_>>().join(", ");
        match error {
            Identify::Collinear { .. } => Error::NotIdentifiable {
                what: format!("{in_words}: targets {names}: {error}"),
                mend: "place one target well away from the line through the others".to_owned(),
            },
            Identify::BlindRows { .. } | Identify::SingularRows { .. } => Error::NotIdentifiable {
                what: format!("{in_words}: targets {names}: {error}"),
                mend: "use the method nine, or move a target".to_owned(),
            },
            Identify::TargetCount { measured, .. } => Error::NotIdentifiable {
                what: format!("{in_words}: the method six needs three targets, found {measured}"),
                mend: "use the method nine".to_owned(),
            },
            _ => {
                let axis = self.campaign.runs[self.campaign.steps[group.step].run].axis;
                Error::Numerical {
                    axis: self.campaign.machine.axes()[axis].name().to_owned(),
                    what: format!("{in_words}: {error}"),
                }
            }
        }
    }
}

impl PointPoses {
    /// The measured poses for other points near the measured ones, with the same operators: `errors_mm` are
    /// the displacements of the points of each group, x y z of each.
    pub(crate) fn moved(&self, errors_mm: &[&[f64]]) -> Vec<Isometry3<f64>> {
        let displacements = |i: usize| {
            let (group, places) = &self.groups[i];
            let all = places.iter().flat_map(|place| &errors_mm[*group][3 * place..3 * place + 3]);
            DVector::from_iterator(3 * places.len(), all.copied())
        };
        let bodies = &self.poses.bodies;
        let zero = |body: &TargetBody| (DVector::zeros(3 * body.home_mm.len()), 0.0);
        let mut shapes: Vec<(DVector<f64>, f64)> = bodies.iter().map(zero).collect();
        for (i, fit) in self.fits.iter().enumerate() {
            let (sum, count) = &mut shapes[self.poses.observations[i].body];
            *sum += &fit.to_shape * displacements(i);
            *count += 1.0;
        }
        let moved = |(i, fit): (usize, &StepFit)| {
            let observation = &self.poses.observations[i];
            let (sum, count) = &shapes[observation.body];
            let mut relative = displacements(i);
            let turn = fit.home_from_datum.transpose();
            for k in (0..relative.len()).step_by(3) {
                let shape = turn * sum.fixed_rows::<3>(k) / *count;
                let mut own = relative.fixed_rows_mut::<3>(k);
                own -= shape;
            }
            observation.moved(&(&fit.from_points * relative))
        };
        self.fits.iter().enumerate().map(moved).collect()
    }
}

/// The noise of the poses that `noise` of the points makes.
fn pose_noise(
    noise: &PointNoise,
    points: &MeasuredPoints,
    steps: &[Step],
    shapes: &[Shape],
    fits: &[StepFit],
) -> PoseNoise {
    if noise.own.is_empty() {
        return PoseNoise::default();
    }
    let sources = noise.shared.nrows();
    // The shapes with this noise, but as functions of the points that they are.
    let of_bodies: Vec<Shape> = shapes
        .iter()
        .enumerate()
        .map(|(body, shape)| match std::ptr::eq(noise, &points.noise) {
            true => shape.clone(),
            false => shape.with_noise(steps, body, noise),
        })
        .collect();
    let mut firsts = Vec::new();
    let mut width = sources;
    for shape in &of_bodies {
        firsts.push(width);
        width += 2 * shape.own.nrows();
    }
    let mut shared = DMatrix::zeros(width, width);
    shared
        .view_mut((0, 0), (sources, sources))
        .copy_from(&noise.shared);
    for (shape, &first) in of_bodies.iter().zip(&firsts) {
        let size = shape.own.nrows();
        shared
            .view_mut((first, first), (size, size))
            .copy_from(&shape.own);
        for i in 0..size {
            shared[(first + i, first + size + i)] = -1.0;
            shared[(first + size + i, first + i)] = -1.0;
        }
    }
    let of_step = |i: usize| {
        let (step, fit) = (&steps[i], &fits[i]);
        let shape = &of_bodies[step.body];
        let (d, z) = noise.of(step.group, &step.places);
        let g = &fit.from_points;
        let mut turned = g.clone();
        for j in (0..g.ncols()).step_by(3) {
            let block = g.fixed_columns::<3>(j) * fit.home_from_datum.transpose();
            turned.fixed_columns_mut::<3>(j).copy_from(&block);
        }
        let with_noise = g * d;
        let size = shape.own.nrows();
        let mut coupling = Matrix6xX::zeros(width);
        coupling
            .columns_mut(0, sources)
            .copy_from(&(g * z - &turned * &shape.coupling));
        let first = firsts[step.body];
        coupling.columns_mut(first, size).copy_from(&turned);
        coupling
            .columns_mut(first + size, size)
            .copy_from(&(&with_noise * fit.to_shape.transpose() / shape.steps));
        (with_noise * g.transpose(), coupling)
    };
    let (own, coupling): (Vec<Matrix6<f64>>, Vec<_>) =
        in_order::map(steps.len(), of_step).into_iter().unzip();
    PoseNoise {
        own,
        coupling,
        shared,
        of_stations: sources,
    }
}
