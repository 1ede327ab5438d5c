//! What a measurement says about itself and its noise.

use nalgebra::Vector3;
use trueaxis_campaign::{Campaign, Direction};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_screening::{NoiseBasis, PartEstimate};

/// What the measurement says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct AdjustmentReport {
    /// Lengths used, or coordinates of a points campaign.
    pub observations: usize,
    /// Unknowns that they determine.
    pub unknowns: usize,
    /// Redundancy.
    pub degrees_of_freedom: usize,
    /// Standard deviation of unit weight with the declared noise: about 1 if the noise is as declared.
    pub sigma0: f64,
    /// Probability of residuals at least as large if the noise is as declared.
    pub p_value: f64,
    /// Whether the noise was declared.
    pub noise_declared: bool,
    /// Factor on all standard uncertainties beyond the noise of the weights: 1 unless the residuals of a points
    /// campaign contradict the declared noise. A repeatability that holds was weighted as so much smaller.
    pub uncertainty_factor: f64,
    /// Degrees of freedom of the factor; infinite where it is 1 because the declared noise holds.
    pub factor_degrees_of_freedom: f64,
    /// Rms of the residuals, mm.
    pub rms_residual_mm: f64,
    /// The noise of the lengths; `None` for a points campaign.
    pub noise: Option<NoiseReport>,
    /// Iterations of the adjustment.
    pub iterations: usize,
    /// Why the iteration stopped.
    pub termination: String,
    /// Lengths that were removed as gross errors, in measuring order.
    pub rejected: Vec<RejectedLength>,
    /// Occupations that were split because the zero of the interferometer jumped, in measuring order.
    pub interruptions: Vec<InterruptedOccupation>,
}

/// The noise that was used for weights and uncertainties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseReport {
    /// The source of the noise.
    pub basis: NoiseBasis,
    /// Constant part of a length's standard deviation.
    pub length: PartReport,
    /// Proportional part of the standard deviation, µm per m; it keeps its declared ratio to the constant part.
    pub length_ppm: f64,
    /// Standard deviation per coordinate of the machine's repeatability.
    pub repeatability: PartReport,
}

/// One part of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartReport {
    /// The declared standard deviation, mm.
    pub declared_mm: Option<f64>,
    /// The value used; its p-value is that of the test against the declared one.
    pub used: PartEstimate,
}

/// A length that contradicts the others.
#[derive(Debug, Clone, PartialEq)]
pub struct RejectedLength {
    /// Line of the file, from 1 (the header).
    pub line: usize,
    /// A description: station, target and step.
    pub length: String,
    /// Its estimated error, observed minus true, mm.
    pub error_mm: f64,
    /// Standard uncertainty of the error, mm.
    pub u_mm: f64,
    /// The length itself does not contradict the others, but nothing checks it since a length of the same point was
    /// removed.
    pub unchecked: bool,
}

/// An occupation of a station in which all lengths change by a constant at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct InterruptedOccupation {
    /// Name of the station.
    pub station: String,
    /// The last line before the jump and the first one after it, for this station.
    pub lines: [usize; 2],
    /// Their times, s.
    pub times_s: [f64; 2],
    /// By how much the lengths change, mm.
    pub change_mm: f64,
    /// Standard uncertainty of the change, mm.
    pub u_mm: f64,
    /// A tripod that moved explains the jump as well as an interrupted beam.
    pub tripod_may_have_moved: bool,
    /// A zero or a tripod that wanders in a smooth course explains the jump nearly as well.
    pub may_wander: bool,
}

impl InterruptedOccupation {
    /// A description of what made the lengths jump.
    pub fn cause(&self) -> &'static str {
        match self.tripod_may_have_moved {
            _ if self.may_wander => {
                "the beam was interrupted, or the tripod moved, or the zero wanders"
            }
            true => "the beam was interrupted, or the tripod moved",
            false => "the beam was interrupted",
        }
    }
}

/// A step whose points do not move as a rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct StepMisfit {
    /// A description of the step.
    pub step: String,
    /// Rms of what a rigid motion leaves of measured coordinates; for lengths, of the difference of the triangle, µm.
    pub rms_um: f64,
    /// `vᵀ C⁻¹ v`; for lengths the drop of that of the whole adjustment if the step has a triangle of its own.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a value as large if the targets are rigid.
    pub p_value: f64,
}

/// Two runs between which the stage is turned at a position of all axes that they share.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedRuns {
    /// Their names.
    pub runs: [String; 2],
    /// The position, as the first run has it.
    pub at: String,
    /// Rotation of the second run against the first about the reference axes, rad.
    pub turned_rad: Vector3<f64>,
    /// Standard uncertainties.
    pub u_rad: Vector3<f64>,
    /// Displacement of the targets by this rotation, rms about their middle, mm.
    pub moved_mm: f64,
    /// `θᵀ C⁻¹ θ`.
    pub chi_squared: f64,
    /// Its degrees of freedom: angles about rotary axes that carry the targets are not tested.
    pub degrees_of_freedom: usize,
    /// Probability of a value as large if nothing moved between the runs.
    pub p_value: f64,
}

impl TurnedRuns {
    /// The notice about it.
    pub fn in_words(&self) -> String {
        let [a, b] = &self.runs;
        let parts = ["A", "B", "C"]
            .iter()
            .zip(self.turned_rad.iter().zip(&self.u_rad));
        let parts = parts.map(|(name, (value, u))| {
            format!("{name} {:+.1} ± {:.1}″", value / ARCSEC, u / ARCSEC)
        });
        format!(
            "runs {a} and {b} see the stage turned against each other where all axes stand alike ({}): {} (u); the instrument was moved or \
             turned between them, the machine shifted, or an axis tilts the stage by its lost motion; the angles between their lines \
             (squareness, axis locations) are wrong by as much, which their U does not contain",
            self.at,
            parts.collect::<Vec<_>>().join(", ")
        )
    }
}

/// A known dead path or length that contradicts the measured lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownMisfit {
    /// A description of what it is.
    pub what: String,
    /// Known value less what the lengths and all other known values say, mm.
    pub difference_mm: f64,
    /// The square of the difference in units of its variance.
    pub chi_squared: f64,
    /// Probability of a value as large if nothing contradicts the lengths.
    pub p_value: f64,
}

/// Significance at which a points campaign gives up the declared noise for that of its residuals, and at which a
/// notice says so: one clean campaign in a thousand.
pub(crate) const GLOBAL_TEST_LEVEL: f64 = 1e-3;

/// Degrees of freedom that are as good as infinite.
pub(crate) const MANY: f64 = 1e6;

impl AdjustmentReport {
    /// Whether the residuals are larger than the noise that was assumed.
    pub(crate) fn is_contradicted(&self) -> bool {
        self.p_value < GLOBAL_TEST_LEVEL
    }

    /// How the residuals compare with the declared noise, if that needs a notice, and the consequence. `both_sides`
    /// says whether the mean of both sides of approach is adjusted.
    pub(crate) fn residual_notices(&self, consequence: &str, both_sides: bool) -> Vec<String> {
        let (sigma0, p_value, degrees_of_freedom) =
            (self.sigma0, self.p_value, self.degrees_of_freedom);
        if degrees_of_freedom == 0 {
            let notice =
                "nothing checks the measurement: there are no more observations than unknowns";
            return vec![notice.to_owned()];
        }
        if !self.noise_declared {
            return self.undeclared_notices();
        }
        if self.is_contradicted() {
            let notice = format!(
                "the residuals are {sigma0:.2} times what the declared noise explains ({}): the model or the \
                 declared noise is wrong; {consequence}",
                trueaxis_files::p_value(p_value)
            );
            let lost_motion = "positions were approached from both sides: lost motion makes such \
                               residuals; --by-direction gives each side curves of its own";
            return match both_sides {
                true => vec![notice, lost_motion.to_owned()],
                false => vec![notice],
            };
        }
        if p_value > 1.0 - GLOBAL_TEST_LEVEL {
            return vec![format!(
                "the residuals are only {sigma0:.3} times what the declared noise explains: it is \
                 declared too large; {consequence}"
            )];
        }
        Vec::new()
    }

    /// What noise is not declared, and what is declared otherwise than the lengths show.
    fn undeclared_notices(&self) -> Vec<String> {
        let of_noise = |noise: &NoiseReport| {
            [
                ("`length_sigma_um`", noise.length),
                ("`repeatability_um`", noise.repeatability),
            ]
        };
        let parts: Vec<(&str, PartReport)> = self.noise.iter().flat_map(of_noise).collect();
        let lacking = parts.iter().filter(|(_, part)| part.declared_mm.is_none());
        let lacking: Vec<&str> = lacking.map(|(name, _)| *name).collect();
        let what = match lacking.as_slice() {
            [one] => *one,
            _ => "the noise",
        };
        let mut notices = vec![format!(
            "{what} is not declared: uncertainties follow from the residuals ({} degrees of freedom)",
            self.degrees_of_freedom
        )];
        for (name, PartReport { declared_mm, used }) in parts {
            let (Some(declared_mm), Some(p_value)) = (declared_mm, used.p_value) else {
                continue;
            };
            if p_value < GLOBAL_TEST_LEVEL {
                notices.push(format!(
                    "{name} is declared as {} µm, but the lengths show {:.3} ± {:.3} µm ({}), which is used: is it in µm?",
                    declared_mm / MICROMETRE,
                    used.sigma_mm / MICROMETRE,
                    2.0 * used.u_mm / MICROMETRE,
                    trueaxis_files::p_value(p_value)
                ));
            }
        }
        notices
    }
}

/// Whether a step of a run was approached from both sides.
pub(crate) fn approached_from_both_sides(campaign: &Campaign) -> bool {
    let stops = campaign.stops().iter();
    let mut in_runs = stops.filter(|stop| campaign.steps[stop.step].run.is_some());
    let mut steps: Vec<Option<Direction>> = vec![None; campaign.steps.len()];
    in_runs.any(|stop| *steps[stop.step].get_or_insert(stop.direction) != stop.direction)
}
