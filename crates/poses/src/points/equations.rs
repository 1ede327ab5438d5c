//! Poses from points: the nine equations of each step (paper Eqs. 20 and 21), or six of them.
//!
//! The points of each body at all steps give its poses and its shape ([`trueaxis_identify::poses_of_body`]). The
//! bodies share the sources of the points ([`crate::points::PointNoise`]); each shape adds its own.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix6xX, Point3};
use trueaxis_campaign::Campaign;
use trueaxis_files::counted;
use trueaxis_identify::{
    BodyNoise, BodyPoses, BodyStep, Equations, Error as Identify, StepError, StepPose,
    poses_of_body,
};
use trueaxis_kinematics::{Ideal, Machine};

use crate::Error;
use crate::points::{MeasuredPoints, PointNoise};
use crate::poses::{PoseNoise, PoseObservation, Poses, TargetBody};
use crate::settings::Method;
use crate::words::{MIN_TARGETS, step_in_words, target_names, too_few_targets};

pub(crate) struct PointPoses {
    pub(crate) poses: Poses,
    pub(crate) equations: PointEquations,
}

/// The equations of all steps at their solution.
pub(crate) struct PointEquations {
    pub(crate) bodies: Vec<BodyPoses>,
    /// The source of each pose.
    pub(crate) sources: Vec<Source>,
}

/// The points that a pose comes from.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    /// The measured group, and the places of the body's points in it.
    pub(crate) group: usize,
    pub(crate) places: Vec<usize>,
    pub(crate) body: usize,
    /// Index among the steps of the body.
    pub(crate) step: usize,
}

/// A body before it is measured.
struct NominalBody {
    targets: Vec<usize>,
    home_mm: Vec<Point3<f64>>,
    steps: Vec<BodyStep>,
    /// The source of each step.
    sources: Vec<usize>,
}

/// The poses of all steps whose targets move with the axis under test.
pub(crate) fn poses_from_points(
    campaign: &Campaign,
    points: &MeasuredPoints,
    method: Method,
) -> Result<PointPoses, Error> {
    let targets = targets_of_runs(campaign, points)?;
    let (nominal, sources) = nominal_bodies(campaign, points, &targets);
    let equations = match method {
        Method::Six(rows) => Equations::Six(rows),
        Method::Joint | Method::Nine => Equations::Weighted,
    };
    let mut bodies = Vec::new();
    for body in &nominal {
        let of_step = |i: usize| points.noise.of(&sources[body.sources[i]]);
        let noise = BodyNoise {
            of_step: &of_step,
            shared: &points.noise.shared,
        };
        let found = poses_of_body(&body.home_mm, &body.steps, &noise, equations);
        bodies.push(found.map_err(|StepError { step, error }| {
            let group = &points.groups[sources[body.sources[step]].group];
            refused(campaign, group.step, &body.targets, &error)
        })?);
    }
    let observation = |source: &Source| {
        let (group, body) = (&points.groups[source.group], &bodies[source.body]);
        let datum_from_home = body.steps[source.step].pose.points_from_home;
        PoseObservation {
            step: group.step,
            direction: group.direction,
            body: source.body,
            datum_from_home,
            pivot_mm: datum_from_home * body.pivot_mm,
        }
    };
    let noise_from = |noise: &PointNoise| pose_noise(noise, &nominal, &bodies, &sources);
    let poses = Poses {
        observations: sources.iter().map(observation).collect(),
        noise: noise_from(&points.noise),
        instrument: noise_from(&points.instrument),
        relative_covariance: points.relative_covariance,
        bodies: nominal
            .iter()
            .zip(&bodies)
            .map(|(nominal, body)| TargetBody {
                targets: nominal.targets.clone(),
                home_mm: body.shape_mm.clone(),
            })
            .collect(),
    };
    let equations = PointEquations { bodies, sources };
    Ok(PointPoses { poses, equations })
}

/// For each run the targets that its axis moves. Targets not measured at every step of a run are left out: the shape
/// must be the same function of the points at every step.
fn targets_of_runs(campaign: &Campaign, points: &MeasuredPoints) -> Result<Vec<Vec<usize>>, Error> {
    let mut common: Vec<Option<Vec<usize>>> = vec![None; campaign.runs.len()];
    for group in &points.groups {
        let Some(run) = campaign.steps[group.step].run else {
            continue;
        };
        let axis = campaign.runs[run].axis;
        let chain = |target: usize| campaign.machine.chain(campaign.targets[target].carrier);
        let mut moved = group.targets.clone();
        moved.retain(|&target| chain(target).contains(&axis));
        if moved.len() < MIN_TARGETS {
            return Err(too_few_targets(campaign, group.step, moved.len()));
        }
        let common = common[run].get_or_insert_with(|| moved.clone());
        common.retain(|target| moved.contains(target));
        if common.len() < MIN_TARGETS {
            return Err(Error::not_identifiable(
                format!(
                    "run {}: only {} at all of its steps, where three are needed \
                     (one is missing in {})",
                    campaign.runs[run].name,
                    counted(common.len(), "target"),
                    step_in_words(campaign, group.step),
                ),
                "measure the missing targets, or leave out the rows of the steps that lack them",
            ));
        }
    }
    Ok(common.into_iter().map(Option::unwrap_or_default).collect())
}

/// The bodies with their nominal shapes, and the source of each pose.
fn nominal_bodies(
    campaign: &Campaign,
    points: &MeasuredPoints,
    targets_of_runs: &[Vec<usize>],
) -> (Vec<NominalBody>, Vec<Source>) {
    let machine = &campaign.machine;
    let mut keys: Vec<(Option<usize>, &[usize])> = Vec::new();
    let (mut bodies, mut sources): (Vec<NominalBody>, Vec<Source>) = (Vec::new(), Vec::new());
    for (number, group) in points.groups.iter().enumerate() {
        let step = &campaign.steps[group.step];
        let Some(run) = step.run else { continue };
        let targets = &targets_of_runs[run];
        let carrier_of = |t: &usize| campaign.targets[*t].carrier;
        let depth = |carrier: &usize| machine.chain(*carrier).len();
        let outermost = targets.iter().filter_map(carrier_of).max_by_key(depth);
        let outermost = Some(outermost.unwrap_or(campaign.runs[run].axis));
        let one_carrier = targets.iter().all(|t| carrier_of(t) == outermost);
        let nominal = machine.motion(&Ideal, outermost, &step.positions);
        // Targets on several carriers are one body only during this run; their home is where the outermost carrier
        // has them when it is at home.
        let key = ((!one_carrier).then_some(run), targets.as_slice());
        let known = keys.iter().position(|known| *known == key);
        let body = known.unwrap_or_else(|| {
            let home = |t: &usize| {
                let home_mm = campaign.targets[*t].home_mm;
                let position = machine.position(&Ideal, carrier_of(t), &step.positions, home_mm);
                nominal.inverse() * position
            };
            bodies.push(NominalBody {
                home_mm: targets.iter().map(home).collect(),
                targets: targets.clone(),
                steps: Vec::new(),
                sources: Vec::new(),
            });
            keys.push(key);
            keys.len() - 1
        });
        let place = |t: &usize| group.targets.iter().position(|seen| seen == t);
        let places: Vec<usize> = targets.iter().filter_map(place).collect();
        let content = &mut bodies[body];
        content.sources.push(sources.len());
        content.steps.push(BodyStep {
            nominal,
            points_mm: places.iter().map(|&place| group.points_mm[place]).collect(),
        });
        sources.push(Source {
            group: number,
            places,
            body,
            step: content.steps.len() - 1,
        });
    }
    (bodies, sources)
}

/// The error for a step without a pose, named as in the campaign.
fn refused(campaign: &Campaign, step: usize, targets: &[usize], error: &Identify) -> Error {
    let in_words = step_in_words(campaign, step);
    let names = target_names(campaign, targets);
    match error {
        Identify::Collinear { .. } => Error::not_identifiable(
            format!("{in_words}: targets {names}: {error}"),
            "place one target well away from the line through the others",
        ),
        Identify::SingularRows { .. } | Identify::NearSingularRows { .. } => {
            Error::not_identifiable(
                format!("{in_words}: targets {names}: {error}"),
                "use the method nine, or move a target",
            )
        }
        Identify::TargetCount { measured, .. } => Error::not_identifiable(
            format!("{in_words}: the method six needs three targets, found {measured}"),
            "use the method nine",
        ),
        Identify::NoPose { .. } => Error::not_trustworthy(
            format!("{in_words}: the points of targets {names} fit no pose of the stage"),
            "see whether targets have each other's names in some rows, or a coordinate is mistyped",
        ),
        _ => {
            let axis = campaign.axis_under_test(step);
            let name = |axis: usize| campaign.machine.axes()[axis].name().to_owned();
            Error::Numerical {
                axis: axis.map(name).unwrap_or_default(),
                what: format!("{in_words}: {error}"),
            }
        }
    }
}

impl PointEquations {
    pub(crate) fn steps(&self) -> impl Iterator<Item = &StepPose> {
        self.sources.iter().map(|source| self.step(source))
    }

    fn step(&self, source: &Source) -> &StepPose {
        &self.bodies[source.body].steps[source.step]
    }

    /// Noise gains of a pose: standard deviations of the component errors at the reference point of
    /// the axis per unit noise of the points, by the equations used and by all nine without weights.
    pub(crate) fn noise_gain(
        &self,
        campaign: &Campaign,
        machine: &Machine,
        poses: &Poses,
        pose: usize,
    ) -> [[f64; 6]; 2] {
        let observation = &poses.observations[pose];
        let step = &campaign.steps[observation.step];
        let axis = step.run.map_or(0, |run| campaign.runs[run].axis);
        let motion = machine.motion(&Ideal, axis, &step.positions);
        let to_reference = observation.to_pivot(&(motion * machine.axes()[axis].reference_mm()));
        let used = &self.step(&self.sources[pose]).pose.from_points;
        let gain = |matrix: Matrix6xX<f64>| {
            let rows = to_reference * matrix;
            std::array::from_fn(|c| rows.row(c).norm())
        };
        let plain = trueaxis_identify::nine(used.targets_mm());
        let plain = plain.map_or([f64::NAN; 6], |plain| gain(plain.matrix()));
        [gain(used.matrix()), plain]
    }

    /// The poses for points near the measured ones, by the same operators: `errors_mm` are the displacements of the
    /// points of each group, x y z of each.
    pub(crate) fn moved(&self, poses: &Poses, errors_mm: &[&[f64]]) -> Vec<Isometry3<f64>> {
        let mut of_bodies: Vec<Vec<DVector<f64>>> = vec![Vec::new(); self.bodies.len()];
        for source in &self.sources {
            let errors = errors_mm[source.group];
            let places = source.places.iter();
            let own = places.flat_map(|place| &errors[3 * place..3 * place + 3]);
            let own = DVector::from_iterator(3 * source.places.len(), own.copied());
            of_bodies[source.body].push(own);
        }
        let bodies = self.bodies.iter().zip(&of_bodies);
        let twists: Vec<_> = bodies.map(|(body, errors)| body.twists(errors)).collect();
        let observations = poses.observations.iter().zip(&self.sources);
        observations
            .map(|(pose, source)| pose.moved(&twists[source.body][source.step]))
            .collect()
    }
}

/// The noise of the poses that follows from `noise` of the points; empty if that is not known.
fn pose_noise(
    noise: &PointNoise,
    nominal: &[NominalBody],
    bodies: &[BodyPoses],
    sources: &[Source],
) -> PoseNoise {
    if noise.own.is_empty() {
        return PoseNoise::default();
    }
    let of_stations = noise.shared.nrows();
    let of_body = |(nominal, body): (&NominalBody, &BodyPoses)| {
        let of_step = |i: usize| noise.of(&sources[nominal.sources[i]]);
        body.noise(&BodyNoise {
            of_step: &of_step,
            shared: &noise.shared,
        })
    };
    let found: Vec<_> = nominal.iter().zip(bodies).map(of_body).collect();
    let mut firsts = vec![of_stations];
    for body in &found {
        firsts.push(firsts[firsts.len() - 1] + body.of_shape.nrows());
    }
    let width = firsts[bodies.len()];
    let mut shared = DMatrix::zeros(width, width);
    let stations = (of_stations, of_stations);
    shared.view_mut((0, 0), stations).copy_from(&noise.shared);
    for (body, &first) in found.iter().zip(&firsts) {
        let size = body.of_shape.shape();
        shared
            .view_mut((first, first), size)
            .copy_from(&body.of_shape);
    }
    let coupling = |source: &Source| -> Vec<f64> {
        let compact = &found[source.body].coupling[source.step];
        let mut coupling = Matrix6xX::zeros(width);
        let of_shape = compact.ncols() - of_stations;
        coupling
            .columns_mut(0, of_stations)
            .copy_from(&compact.columns(0, of_stations));
        coupling
            .columns_mut(firsts[source.body], of_shape)
            .copy_from(&compact.columns(of_stations, of_shape));
        coupling.as_slice().to_vec()
    };
    PoseNoise {
        own: sources.iter().map(|s| found[s.body].own[s.step]).collect(),
        couplings: sources.iter().flat_map(coupling).collect(),
        shared,
        declared: noise.declared.clone().resize(width, width, 0.0),
        stations: noise.stations.clone().resize_horizontally(width, 0.0),
        of_stations,
    }
}
