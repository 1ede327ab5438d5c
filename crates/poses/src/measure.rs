//! The headline verb: from a campaign to the poses of its stages.

use nalgebra::Matrix2;
use trueaxis_campaign::{Campaign, Lengths, Points};
use trueaxis_identify::SixRows;
use trueaxis_kinematics::{MICROMETRE, Machine};
use trueaxis_screening::CoordinateNoise;

use crate::Error;
use crate::lengths::LengthsAdjustment;
use crate::points::equations::{PointEquations, PointPoses, poses_from_points};
use crate::points::noise_shown::noise_shown;
use crate::points::report::points_report;
use crate::points::turned_runs::turned_runs;
use crate::points::{MeasuredPoints, noise_of_coordinates, points_from_coordinates, rigidity};
use crate::poses::{PoseNoise, Poses};
use crate::report::{AdjustmentReport, StepMisfit, TurnedRuns};
use crate::residual::Residual;
use crate::settings::{Method, Settings};

/// The poses of a campaign with what was adjusted beside them.
pub struct MeasuredPoses<'a> {
    campaign: &'a Campaign,
    /// The method used: [`Method::Nine`] where [`Method::Joint`] was asked for measured points.
    pub method: Method,
    /// The poses, with the declared noise or the noise that the residuals show.
    pub poses: Poses,
    /// What the measurement says about itself.
    pub adjustment: AdjustmentReport,
    /// Steps whose targets do not move as a rigid body.
    pub misfits: Vec<StepMisfit>,
    /// Runs between which the stage is turned at equal axis positions; only for measured points.
    pub turned_runs: Vec<TurnedRuns>,
    /// Largest variance of a coordinate of a point at the first step, mm²; `None` where there are no points.
    pub point_variance_mm2: Option<f64>,
    /// The noise that the poses of the joint adjustment would have by equations; `None` for other methods and where
    /// the equations do not give the same poses.
    pub by_equations: Option<NoiseByEquations>,
    /// The adjusted lengths; `None` for a points campaign.
    pub lengths: Option<LengthsAdjustment<'a>>,
    /// The points, and the equations by which the poses follow from them; `None` for the joint adjustment.
    pub(crate) points: Option<(MeasuredPoints, PointEquations)>,
    /// What rigid motions leave of measured coordinates; empty for lengths.
    point_residuals: Vec<Residual>,
    /// What a user must know before using the poses.
    pub notices: Vec<String>,
}

/// The noise of poses by points and equations, for the same lengths and pivots as those of the joint adjustment.
#[derive(Debug, Clone)]
pub struct NoiseByEquations {
    /// By all nine equations, weighted.
    pub nine: PoseNoise,
    /// By the paper's six; `None` where six do not determine the poses.
    pub six: Option<PoseNoise>,
}

/// Most steps for which the joint adjustment is compared with equations: with more the comparison would take most of
/// the time and say the same.
const MOST_STEPS: usize = 10_000;

/// The poses of all stages under test, in the datum: the best fit of the targets to their nominal positions. They
/// come from one adjustment or, as in the paper, from its sections 3 (points) and then 4.1 (equations).
///
/// # Errors
/// See [`Error`]; a result that is not converged or not determined is an error.
pub fn measure<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
) -> Result<MeasuredPoses<'a>, Error> {
    let measured = match (&campaign.lengths, &campaign.points) {
        (Some(lengths), _) => from_lengths(campaign, lengths, settings)?,
        (None, Some(points)) => from_points(campaign, points, settings)?,
        (None, None) => return Err(Error::NothingMeasured),
    };
    if measured.poses.observations.is_empty() {
        return Err(Error::NothingMeasured);
    }
    Ok(measured)
}

fn from_lengths<'a>(
    campaign: &'a Campaign,
    lengths: &'a Lengths,
    settings: &Settings,
) -> Result<MeasuredPoses<'a>, Error> {
    let (lengths, mut notices) = LengthsAdjustment::new(campaign, lengths, settings)?;
    let adjustment = lengths.report();
    notices.extend(lengths.report_notices(&adjustment));
    notices.extend(lengths.reflector_notices());
    notices.extend(lengths.known_notices());
    let joint = settings.method == Method::Joint;
    let by_points = match joint {
        true if lengths.moved().len() > MOST_STEPS => None,
        true => by_points(campaign, &lengths, Method::Nine).ok(),
        false => Some(by_points(campaign, &lengths, settings.method)?),
    };
    let mut misfits = lengths.steps_not_rigid();
    // The test by the remaining lengths of a step takes precedence.
    let mut lost = lengths.lost_targets();
    lost.retain(|lost| misfits.iter().all(|misfit| misfit.step != lost.step));
    misfits.extend(lost);
    let points = by_points.as_ref().map(|(points, _)| points);
    let point_variance_mm2 = points.map(|points| points.noise.largest_variance_mm2());
    let (poses, by_equations, points) = match by_points {
        Some((points, found)) if !joint => (found.poses, None, Some((points, found.equations))),
        compared => {
            let poses = lengths.poses()?;
            let by_equations = compared.and_then(|(points, nine)| {
                let six = Method::Six(SixRows::PAPER);
                let six = poses_from_points(campaign, &points, six).ok();
                Some(NoiseByEquations {
                    nine: nine.poses.noise_about_pivots_of(&poses)?,
                    six: six.and_then(|six| six.poses.noise_about_pivots_of(&poses)),
                })
            });
            (poses, by_equations, None)
        }
    };
    Ok(MeasuredPoses {
        campaign,
        method: settings.method,
        poses,
        adjustment,
        misfits,
        turned_runs: Vec::new(),
        point_variance_mm2,
        by_equations,
        lengths: Some(lengths),
        points,
        point_residuals: Vec::new(),
        notices,
    })
}

/// The points of the lengths without rigid stages, and the poses that follow from them.
fn by_points(
    campaign: &Campaign,
    lengths: &LengthsAdjustment<'_>,
    method: Method,
) -> Result<(MeasuredPoints, PointPoses), Error> {
    let points = lengths.points()?;
    let found = poses_from_points(campaign, &points, method)?;
    Ok((points, found))
}

fn from_points<'a>(
    campaign: &'a Campaign,
    coordinates: &Points,
    settings: &Settings,
) -> Result<MeasuredPoses<'a>, Error> {
    let method = match settings.method {
        Method::Joint => Method::Nine,
        method => method,
    };
    let is_undeclared = coordinates.readings.iter().any(|r| r.sigma_um.is_none());
    let with_noise = |noise: &CoordinateNoise, repeatability_mm: f64| -> Result<_, Error> {
        let noise = (noise, repeatability_mm);
        let (points, turn) =
            points_from_coordinates(campaign, coordinates, settings.by_direction, noise);
        let found = poses_from_points(campaign, &points, method)?;
        Ok((points, found, turn))
    };
    let declared_mm = campaign.instrument.repeatability_um;
    let declared_mm = declared_mm.map(|um| um * MICROMETRE);
    let first_mm = declared_mm.unwrap_or(0.0);
    let (mut points, mut found, turn) = with_noise(&CoordinateNoise::EQUAL, first_mm)?;
    let noise = noise_of_coordinates(coordinates, &points, &found, &turn);
    if noise != CoordinateNoise::EQUAL {
        (points, found, _) = with_noise(&noise, first_mm)?;
    }
    let shown = noise_shown(
        &points,
        rigidity::total(&found),
        (!is_undeclared, declared_mm),
    );
    if let Some((variance_mm2, relative_covariance)) = shown.repeatability {
        (points, found, _) = with_noise(&noise, variance_mm2.sqrt())?;
        found.poses.relative_covariance = relative_covariance;
    }
    let mut point_residuals = found.equations.residuals(&points);
    let (adjustment, mut notices) = points_report(
        campaign,
        settings.by_direction,
        (&points, &noise, &shown),
        (&found, &point_residuals),
    );
    // Undeclared noise is what the residuals show. A mistake must stand out of declared noise, which it makes fail.
    if !adjustment.noise_declared && adjustment.uncertainty_factor > 0.0 {
        for residual in &mut point_residuals {
            residual.standardized /= adjustment.uncertainty_factor;
        }
    }
    let misfits = rigidity::misfits(campaign, &found, adjustment.noise_declared);
    found.poses.follow(&adjustment);
    let noise_dof = adjustment.factor_degrees_of_freedom;
    let turned_runs = turned_runs(campaign, &found.poses, noise_dof);
    notices.extend(turned_runs.iter().map(TurnedRuns::in_words));
    // Trials draw from this noise, too.
    let factor = adjustment.uncertainty_factor.powi(2);
    points.noise.own.iter_mut().for_each(|own| *own *= factor);
    Ok(MeasuredPoses {
        campaign,
        method,
        poses: found.poses,
        adjustment,
        misfits,
        turned_runs,
        point_variance_mm2: Some(points.noise.largest_variance_mm2()),
        by_equations: None,
        lengths: None,
        points: Some((points, found.equations)),
        point_residuals,
        notices,
    })
}

impl Poses {
    /// Multiplies all variances by the square of the report's factor, whose own uncertainty is added.
    fn follow(&mut self, report: &AdjustmentReport) {
        let factor = report.uncertainty_factor.powi(2);
        self.noise.scale(factor);
        self.instrument.scale(factor);
        // The covariance of an estimated repeatability already contains that of the factor.
        let is_open = self.relative_covariance[(0, 0)] <= 0.0;
        if is_open && report.factor_degrees_of_freedom.is_finite() {
            let variance = 2.0 / report.factor_degrees_of_freedom;
            self.relative_covariance += Matrix2::from_element(variance);
        }
    }
}

impl<'a> MeasuredPoses<'a> {
    /// The residuals of all lengths, or of all coordinates that led to poses, in measuring order. Coordinates have
    /// units of the declared noise where it is declared for all of them.
    pub fn residuals(&self) -> Vec<Residual> {
        let of_points = || self.point_residuals.clone();
        let lengths = self.lengths.as_ref();
        lengths.map_or_else(of_points, LengthsAdjustment::residuals)
    }

    /// Standard deviation of the scale that a points campaign declares.
    pub(crate) fn declared_scale(&self) -> f64 {
        let ppm = self.campaign.instrument.scale_sigma_ppm;
        let ppm = ppm.filter(|_| self.lengths.is_none());
        ppm.map_or(0.0, |ppm| ppm * 1e-6)
    }

    /// What `of` gives for lengths; nothing for a points campaign.
    pub fn of_lengths<T: Default>(&self, of: impl FnOnce(&LengthsAdjustment<'a>) -> T) -> T {
        self.lengths.as_ref().map(of).unwrap_or_default()
    }

    /// Standard deviations of the component errors at the reference point of the axis under test for unit noise of
    /// the points, by the equations used and by all nine without weights, mm and rad per mm: the mean over the poses
    /// with these numbers. `None` for the joint adjustment, which has no points.
    pub fn noise_gain(&self, machine: &Machine, poses: &[usize]) -> Option<[[f64; 6]; 2]> {
        let (_, equations) = self.points.as_ref()?;
        let mut mean = [[0.0; 6]; 2];
        for &pose in poses {
            let gains = equations.noise_gain(self.campaign, machine, &self.poses, pose);
            for (mean, gain) in mean.iter_mut().flatten().zip(gains.iter().flatten()) {
                *mean += gain / poses.len() as f64;
            }
        }
        Some(mean)
    }
}
