//! What the residuals of adjusted lengths say about the measurement and its noise.

use trueaxis_kinematics::{ARCSEC, Axis, MICROMETRE};
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_screening::{AxisReturn, Jump, NoiseBasis, PartEstimate, Slip, WanderingZero, slow};

use crate::lengths::LengthsAdjustment;
use crate::lengths::network::target_at;
use crate::report::{
    AdjustmentReport, InterruptedOccupation, NoiseReport, PartReport, RejectedLength,
    approached_from_both_sides,
};
use crate::words::{length_in_words, step_in_words, stop_of};

/// Standard uncertainties by which a result may be wrong unnoticed before a notice says so.
const HARMFUL: f64 = 3.0;

impl LengthsAdjustment<'_> {
    /// The report of the adjusted lengths.
    pub(crate) fn report(&self) -> AdjustmentReport {
        let (campaign, lengths, screened) = (self.campaign, self.lengths, &self.screened);
        let solution = &screened.solution;
        let degrees_of_freedom = solution.degrees_of_freedom();
        let noise_declared = self.campaign.instrument.declares_noise();
        let sigma0 = match noise_declared {
            true => self.given_sigma0(),
            false if degrees_of_freedom > 0 => self.widening() * solution.sigma0(),
            false => 1.0,
        };
        let squares = sigma0.powi(2) * degrees_of_freedom as f64;
        let rejected = screened.removed.iter().map(|removed| RejectedLength {
            line: lengths.readings[removed.reading].line,
            length: length_in_words(campaign, lengths, removed.reading),
            error_mm: removed.error_mm,
            u_mm: removed.u_mm,
            unchecked: removed.unchecked,
        });
        AdjustmentReport {
            observations: screened.kept.len(),
            unknowns: screened.kept.len() - degrees_of_freedom,
            degrees_of_freedom,
            sigma0,
            p_value: chi_squared_upper_tail(squares, degrees_of_freedom as f64),
            noise_declared,
            uncertainty_factor: self.widening(),
            factor_degrees_of_freedom: f64::INFINITY,
            rms_residual_mm: solution.rms_residual_mm(),
            noise: Some(self.noise_report()),
            iterations: solution.iterations,
            termination: solution.termination.to_string(),
            rejected: rejected.collect(),
            interruptions: screened
                .jumps
                .iter()
                .map(|j| self.interruption(j))
                .collect(),
        }
    }

    /// What a user must know of it.
    pub(crate) fn report_notices(&self, report: &AdjustmentReport) -> Vec<String> {
        let screened = &self.screened;
        let consequence = match screened.noise.basis {
            NoiseBasis::Given => "uncertainties are those of the declared noise",
            _ => "uncertainties follow the residuals",
        };
        let both_sides = !self.settings.by_direction && approached_from_both_sides(self.campaign);
        let mut notices = report.residual_notices(consequence, both_sides);
        if screened.noise.basis == NoiseBasis::CommonFactor {
            let declared = self.campaign.instrument.repeatability_um.is_some();
            notices.push(match declared {
                true => "the lengths do not separate their own noise from the machine's repeatability: the declared \
                         ratio of the two is kept"
                    .to_owned(),
                false => "the lengths do not separate their own noise from the machine's repeatability, and no \
                          `repeatability_um` is declared: all noise is taken for that of single lengths"
                    .to_owned(),
            });
        }
        if !screened.converged {
            notices.push(
                "the search for gross errors did not come to an end: some lengths still contradict the \
                 others"
                    .to_owned(),
            );
        }
        notices.extend(self.alike());
        notices.extend(self.slow());
        notices.extend(self.wandering_zeros());
        notices.extend(self.slip(both_sides));
        notices.extend(self.unnoticed_jump());
        let changed = !screened.removed.is_empty() || !screened.jumps.is_empty();
        if both_sides && changed && !report.is_contradicted() {
            notices.push(
                "positions were approached from both sides: lost motion, too, makes lengths contradict each \
                 other; compare with --by-direction"
                    .to_owned(),
            );
        }
        if report.is_contradicted() && report.noise_declared {
            let worst = self.worst_length();
            notices.push(format!("the largest residual is that of {worst}"));
        }
        notices
    }

    /// Factor on U for what all repeats of a stop have in common.
    fn widening(&self) -> f64 {
        self.alike.as_ref().map_or(1.0, |alike| alike.factor)
    }

    /// What all repeats of a stop have in common.
    fn alike(&self) -> Option<String> {
        self.alike.as_ref().map(|alike| {
            format!(
                "repeats of a stop agree with each other {:.1} times as well as with the model ({}): what they have in common is no noise; all U are \
                 {:.1} times those of the noise, but what moves or warms up in the course of a campaign may do more; `trueaxis diagnose` \
                 looks for it",
                alike.ratio,
                trueaxis_files::p_value(alike.p_value),
                alike.factor
            )
        })
    }

    /// What the steps of a run have in common.
    fn slow(&self) -> Option<String> {
        self.slow.as_ref().map(|slow| {
            format!(
                "what the model leaves of the lengths changes slowly from step to step (correlation {:.2}; {}): something drifts or slipped, or the air \
                 stirs; U of squareness and location is {:.1} times that of independent errors; `trueaxis diagnose` looks for it",
                slow.correlation,
                trueaxis_files::p_value(slow.p_value),
                slow.ratio.sqrt()
            )
        })
    }

    /// Zeros that wander; those of most stations do not wander by chance.
    fn wandering_zeros(&self) -> Vec<String> {
        let zeros = &self.screened.wandering;
        let name = |zero: &WanderingZero| self.campaign.stations[zero.station].name.as_str();
        let rms_um = |zero: &WanderingZero| zero.rms_mm / MICROMETRE;
        if zeros.len() > 1 && 2 * zeros.len() > self.campaign.stations.len() {
            let names: Vec<&str> = zeros.iter().map(name).collect();
            return vec![format!(
                "stations {}: their zeros seem to wander by up to {:.1} µm rms; with so many it is rather something that all of them see, such \
                 as a target that moved, an axis or a workshop that warms up: `trueaxis diagnose` looks for it",
                names.join(", "),
                zeros.iter().map(rms_um).fold(0.0, f64::max)
            )];
        }
        let said = zeros.iter().map(|zero| {
            format!(
                "station {}: its zero wanders smoothly by {:.1} µm rms, or its tripod does: this is no \
                 interruption, and nothing is split; `trueaxis diagnose` says what wanders and calibrates without it",
                name(zero),
                rms_um(zero)
            )
        });
        said.collect()
    }

    /// The target that most plainly slipped or another that may have; none where it leaves what changes slowly, or where both sides of
    /// approach share poses: lost motion looks the same.
    fn slip(&self, both_sides: bool) -> Option<String> {
        if self.settings.asks_why || both_sides {
            return None;
        }
        let slips = self.screened.slips()?;
        let name = |slip: &Slip| self.target(slip.place);
        let station = |j: usize| &self.campaign.stations[j].name;
        let recurs = self.alike.is_some() && self.slow.is_none();
        if recurs || slow(&self.screened.network, &slips.left, &self.runs()).is_some() {
            return None;
        }
        let names: Vec<&str> = slips.targets.iter().map(name).collect();
        let slip = slips.targets.first()?;
        let seen = slip.station.map(station);
        let seen = seen.map(|name| format!(", while station {name} saw it"));
        Some(format!(
            "from about line {} on the lengths change as if target {} had shifted by {:.1} ± {:.1} µm in its nest{}, or something drifts ({}): U does not \
             contain what that does to the results; `trueaxis diagnose` looks for the cause and calibrates without it",
            self.lengths.readings[self.screened.kept[slip.first_reading]].line,
            names.join(" or "),
            slip.moved_mm.norm() / MICROMETRE,
            slip.u_mm / MICROMETRE,
            seen.unwrap_or_default(),
            trueaxis_files::p_value(slip.p_value)
        ))
    }

    /// The jump of a zero that does most harm without being found, where it does much.
    fn unnoticed_jump(&self) -> Option<String> {
        let worst = self
            .screened
            .unnoticed_jump()
            .filter(|worst| worst.in_u > HARMFUL)?;
        Some(format!(
            "most stops were read once from each station: a jump of the zero of station {} in mid-campaign (the beam is interrupted, the tripod \
             moves) below {:.1} µm is not found, and changes results by up to {:.0} u ({}), which U does not contain; read \
             each run there and back",
            self.campaign.stations[worst.station].name,
            worst.jump_mm / MICROMETRE,
            worst.in_u,
            step_in_words(self.campaign, self.groups[worst.group].step)
        ))
    }

    /// Axes that miss their steps by a different angle at each visit, or by more than others.
    pub(crate) fn returns(&self, ratios: &[AxisReturn]) -> Vec<String> {
        let axes = || self.campaign.machine.axes().iter().zip(ratios);
        let turning = axes().filter(|(_, own)| own.angle > 0.0);
        let repeatability_mm = self.screened.network.noise.repeatability_mm;
        let said = turning.map(|(axis, own)| {
            format!(
                "axis {}: it stops at a different angle each time, {:.1}″ (standard deviation) beyond what the repeatability of a coordinate \
                 explains: U contains it; see whether its worm or its clamping is worn",
                axis.name(),
                own.angle * repeatability_mm / ARCSEC
            )
        });
        let uneven = axes().any(|(_, own)| own.variance.total_cmp(&1.0).is_ne()).then(|| {
            let size = |(axis, own): (&Axis, &AxisReturn)| {
                format!("{} {:.1}", axis.name(), own.variance.sqrt() * repeatability_mm / MICROMETRE)
            };
            format!(
                "some axes return to their steps worse than others, {} µm (standard deviation of a coordinate): U of each contains its own",
                axes().map(size).collect::<Vec<_>>().join(", ")
            )
        });
        said.chain(uneven).collect()
    }

    /// The name of the target at a place of a body.
    fn target(&self, place: (usize, usize)) -> &str {
        let target = target_at(&self.screened.network, &self.groups, place);
        target.map_or("", |target| self.campaign.targets[target].name.as_str())
    }

    fn noise_report(&self) -> NoiseReport {
        let instrument = &self.campaign.instrument;
        let part = |declared_um: Option<f64>, used: PartEstimate| PartReport {
            declared_mm: declared_um.map(|um| um * MICROMETRE),
            used: PartEstimate {
                p_value: used.p_value.filter(|_| declared_um.is_some()),
                ..used
            },
        };
        let noise = &self.screened.noise;
        NoiseReport {
            basis: noise.basis,
            length: part(instrument.length_sigma_um, noise.length),
            length_ppm: noise.noise.length_sigma_relative * 1e6,
            repeatability: part(instrument.repeatability_um, noise.repeatability),
        }
    }

    fn interruption(&self, jump: &Jump) -> InterruptedOccupation {
        let readings = &self.lengths.readings;
        let after = jump.first_reading;
        let of_station = |&i: &usize| stop_of(self.lengths, i).station == jump.station;
        let pair = [(0..after).rfind(of_station).unwrap_or(after), after];
        InterruptedOccupation {
            station: self.campaign.stations[jump.station].name.clone(),
            lines: pair.map(|i| readings[i].line),
            times_s: pair.map(|i| readings[i].time_s),
            change_mm: jump.change_mm,
            u_mm: jump.u_mm,
            tripod_may_have_moved: jump.tripod_may_have_moved,
            may_wander: jump.may_wander,
        }
    }

    /// A description of the used length with the largest residual.
    fn worst_length(&self) -> String {
        let residuals = &self.screened.solution.residuals_mm;
        let residuals = self.screened.kept.iter().zip(residuals);
        let worst = residuals.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        worst.map_or_else(String::new, |(&reading, residual_mm)| {
            format!(
                "{} with {:.1} µm",
                length_in_words(self.campaign, self.lengths, reading),
                residual_mm.abs() / MICROMETRE
            )
        })
    }
}
