//! From the campaign to poses, whatever was measured and by whatever method.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix2};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::Machine;
use trueaxis_multilateration::{Screened, Solution};

use crate::adjustment_report::{AdjustmentReport, of_lengths};
use crate::axis_data::AxisData;
use crate::calibration::SideDifference;
use crate::from_lengths::AdjustedLengths;
use crate::identify_axes::Identified;
use crate::nine::{PointPoses, poses_from_points};
use crate::points::MeasuredPoints;
use crate::points_report::of_points;
use crate::pose_errors::Context;
use crate::poses::Poses;
use crate::settings::{Method, Settings};
use crate::sides::side_differences;
use crate::state::ModelErrors;
use crate::{Error, from_points};

/// The poses of a campaign with what they come from.
pub(crate) struct Measured<'a> {
    campaign: &'a Campaign,
    /// How the poses were found.
    pub(crate) method: Method,
    /// Those of the joint adjustment.
    joint: Option<Poses>,
    /// The adjustment, if lengths were measured.
    pub(crate) adjusted: Option<AdjustedLengths<'a>>,
    /// The points and the poses that follow from them by equations; `None` where the joint adjustment
    /// determines poses but not every point.
    pub(crate) points: Option<(MeasuredPoints, PointPoses)>,
}

/// Steps up to which the joint adjustment is compared with equations: beyond, these would take most of the
/// time and say the same.
const MOST_STEPS: usize = 10_000;

/// Adjusts the lengths, or takes the points, of a campaign.
pub(crate) fn measure<'a>(
    campaign: &'a Campaign,
    settings: &Settings,
    notices: &mut Vec<String>,
) -> Result<Measured<'a>, Error> {
    let by_equations = |points: MeasuredPoints, method| {
        let found = poses_from_points(campaign, &points, method)?;
        Ok::<_, Error>((points, found))
    };
    let (method, adjusted) = match (&campaign.lengths, &campaign.points) {
        (Some(lengths), _) => {
            let adjusted = AdjustedLengths::new(campaign, lengths, settings, notices)?;
            (settings.method, Some(adjusted))
        }
        (None, Some(_)) if settings.method == Method::Joint => (Method::Nine, None),
        (None, Some(_)) => (settings.method, None),
        (None, None) => return Err(Error::NothingMeasured),
    };
    let (joint, points) = match (&adjusted, &campaign.points) {
        (Some(adjusted), _) if method == Method::Joint => {
            let few = adjusted.moved().len() <= MOST_STEPS;
            let points = few.then(|| by_equations(adjusted.points()?, Method::Nine));
            (Some(adjusted.poses()?), points.and_then(Result::ok))
        }
        (Some(adjusted), _) => (None, Some(by_equations(adjusted.points()?, method)?)),
        (None, Some(points)) => {
            let points = from_points::measure(campaign, points, settings.by_direction);
            (None, Some(by_equations(points, method)?))
        }
        (None, None) => return Err(Error::NothingMeasured),
    };
    Ok(Measured {
        campaign,
        method,
        joint,
        adjusted,
        points,
    })
}

impl<'a> Measured<'a> {
    /// The poses that the results follow from.
    pub(crate) fn poses(&self) -> &Poses {
        match (&self.joint, &self.points) {
            (Some(poses), _) => poses,
            (None, Some((_, found))) => &found.poses,
            (None, None) => unreachable!("a measurement has poses, or points of which they follow"),
        }
    }

    fn poses_mut(&mut self) -> Option<&mut Poses> {
        match (&mut self.joint, &mut self.points) {
            (Some(poses), _) => Some(poses),
            (None, points) => points.as_mut().map(|(_, found)| &mut found.poses),
        }
    }

    /// The adjusted lengths.
    pub(crate) fn screened(&self) -> Option<&Arc<Screened>> {
        self.adjusted.as_ref().map(|adjusted| &adjusted.screened)
    }

    /// The solution of the adjustment.
    pub(crate) fn solution(&self) -> Option<&Solution> {
        self.screened().map(|screened| &*screened.solution)
    }

    /// The measured poses: datum from home.
    pub(crate) fn isometries(&self) -> Vec<Isometry3<f64>> {
        let observations = self.poses().observations.iter();
        observations.map(|pose| pose.datum_from_home).collect()
    }

    /// What identification needs, with these poses.
    pub(crate) fn context<'b>(
        &'b self,
        machine: &'b Machine,
        measured: &'b [Isometry3<f64>],
    ) -> Context<'b> {
        Context {
            campaign: self.campaign,
            machine,
            poses: self.poses(),
            measured,
        }
    }

    /// What the measurement says about itself, and what a user must know of it added to `notices`.
    pub(crate) fn report(&self, by_direction: bool, notices: &mut Vec<String>) -> AdjustmentReport {
        match (&self.adjusted, &self.campaign.lengths, &self.points) {
            (Some(adjusted), Some(lengths), _) => {
                let screened = &adjusted.screened;
                of_lengths(self.campaign, lengths, by_direction, screened, notices)
            }
            (_, _, Some((points, found))) => {
                of_points(self.campaign, by_direction, points, found, notices)
            }
            _ => unreachable!("a measurement without lengths has points"),
        }
    }

    /// Follows the report: all variances by the square of its factor, which is known as well as it says.
    pub(crate) fn follow(&mut self, report: &AdjustmentReport) {
        let Some(poses) = self.poses_mut() else {
            return;
        };
        let factor = report.uncertainty_factor.powi(2);
        poses.noise.scale(factor);
        poses.instrument.scale(factor);
        if report.factor_degrees_of_freedom.is_finite() {
            let variance = 2.0 / report.factor_degrees_of_freedom;
            poses.relative_covariance = Matrix2::from_element(variance);
        }
    }

    /// For each axis how the sides of approach differ that share its curves.
    pub(crate) fn side_differences(
        &self,
        machine: &Machine,
        data: &[AxisData],
        identified: &Identified,
        by_direction: bool,
    ) -> Vec<Option<SideDifference>> {
        let joined = self
            .adjusted
            .as_ref()
            .filter(|_| self.joint.is_some() && !by_direction);
        let errors = ModelErrors {
            data,
            state: &identified.state,
        };
        joined.map_or_else(
            || vec![None; data.len()],
            |adjusted| side_differences(self.campaign, machine, (data, &errors), adjusted),
        )
    }

    /// Mean noise gains of the steps of an axis, by the equations used and by all nine.
    pub(crate) fn noise_gain(&self, machine: &Machine, axis: &AxisData) -> Option<[[f64; 6]; 2]> {
        let (_, found) = self.points.as_ref().filter(|_| self.joint.is_none())?;
        let gains = |pose| found.noise_gain(self.campaign, machine, pose);
        let mut mean = [[0.0; 6]; 2];
        for record in &axis.records {
            for (mean, gain) in mean.iter_mut().zip(gains(record.pose)) {
                for (sum, g) in mean.iter_mut().zip(gain) {
                    *sum += g / axis.records.len() as f64;
                }
            }
        }
        Some(mean)
    }
}
