//! What the residuals say about the measurement and its noise.

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::{NoiseBasis, PartEstimate, Screened};

use crate::from_lengths;
use crate::lengths_in_words::{length_in_words, stop_of};

/// What the measurement says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct AdjustmentReport {
    /// Lengths used, or coordinates of a points campaign.
    pub observations: usize,
    /// Unknowns that they determine.
    pub unknowns: usize,
    /// Redundancy.
    pub degrees_of_freedom: usize,
    /// Standard deviation of unit weight with the declared noise: 1 if the noise is as declared.
    pub sigma0: f64,
    /// Probability of residuals at least as large if the noise is as declared.
    pub p_value: f64,
    /// Whether the noise was declared.
    pub noise_declared: bool,
    /// Factor on all standard uncertainties beyond the noise that was used: 1 unless a points
    /// campaign's residuals contradict its declared noise.
    pub uncertainty_factor: f64,
    /// Degrees of freedom of that factor; infinite where it is 1 because the declared noise holds.
    pub factor_degrees_of_freedom: f64,
    /// Rms of the residuals, mm.
    pub rms_residual_mm: f64,
    /// The noise of the lengths; `None` for a points campaign.
    pub noise: Option<NoiseReport>,
    /// Lengths that were removed as gross errors, in measuring order.
    pub rejected: Vec<RejectedLength>,
    /// Turns that were split because the zero of the interferometer jumped, in measuring order.
    pub interruptions: Vec<InterruptedTurn>,
    /// Iterations of the adjustment.
    pub iterations: usize,
    /// Why it stopped.
    pub termination: String,
}

/// The noise that was used for weights and uncertainties.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseReport {
    /// What it rests on.
    pub basis: NoiseBasis,
    /// Constant part of a length's standard deviation.
    pub length: PartReport,
    /// Proportional part of it, µm per m; it keeps its declared ratio to the constant one.
    pub length_ppm: f64,
    /// Standard deviation per coordinate of the machine's return.
    pub machine_return: PartReport,
}

/// One part of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartReport {
    /// The declared standard deviation, mm.
    pub declared_mm: Option<f64>,
    /// The one used; its p-value is that of the test against the declared one.
    pub used: PartEstimate,
}

/// A length that contradicts the others.
#[derive(Debug, Clone, PartialEq)]
pub struct RejectedLength {
    /// Line of the file, from 1 (the header).
    pub line: usize,
    /// Station, target and step in words.
    pub length: String,
    /// Its estimated error, observed minus right, mm.
    pub error_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_mm: f64,
    /// It does not contradict the others, but nothing checks it beside a length of the same point that
    /// does.
    pub unchecked: bool,
}

/// A turn of a station in which all lengths change by a constant from an instant on.
#[derive(Debug, Clone, PartialEq)]
pub struct InterruptedTurn {
    /// Name of the station.
    pub station: String,
    /// The last line before the jump and the first one after it, of this station.
    pub lines: [usize; 2],
    /// Their times, s.
    pub times_s: [f64; 2],
    /// By how much the lengths change, mm.
    pub change_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_mm: f64,
}

/// Significance at which the declared noise is given up for the residuals' own in a points campaign,
/// and at which a word is said about it: one clean campaign in a thousand.
pub(crate) const GLOBAL_TEST_LEVEL: f64 = 1e-3;

/// The report of adjusted lengths, and what a user must know of it added to `notices`.
pub(crate) fn of_lengths(
    campaign: &Campaign,
    lengths: &Lengths,
    by_direction: bool,
    screened: &Screened,
    notices: &mut Vec<String>,
) -> AdjustmentReport {
    let solution = &screened.solution;
    let degrees_of_freedom = solution.degrees_of_freedom();
    let noise_declared = from_lengths::is_noise_declared(campaign);
    let sigma0 = match noise_declared {
        true => from_lengths::given_sigma0(screened),
        false if degrees_of_freedom > 0 => solution.sigma0(),
        false => 1.0,
    };
    let squares = sigma0.powi(2) * degrees_of_freedom as f64;
    let p_value = chi_squared_upper_tail(squares, degrees_of_freedom as f64);
    let noise = noise_report(campaign, screened);
    let residuals = Residuals {
        sigma0,
        p_value,
        degrees_of_freedom,
        noise_declared,
        consequence: match noise.basis {
            NoiseBasis::Given => "uncertainties are those of the declared noise",
            _ => "uncertainties follow the residuals",
        },
    };
    let both_sides = !by_direction && approached_from_both_sides(campaign);
    residuals.notices(both_sides, notices);
    noise_notices(&noise, notices);
    if !screened.settled {
        notices.push(
            "the search for gross errors did not come to an end: some lengths still contradict the \
             others"
                .to_owned(),
        );
    }
    let changed = !screened.removed.is_empty() || !screened.jumps.is_empty();
    if both_sides && changed && p_value >= GLOBAL_TEST_LEVEL {
        notices.push(
            "positions were approached from both sides: lost motion, too, makes lengths contradict each \
             other; compare with --by-direction"
                .to_owned(),
        );
    }
    if p_value < GLOBAL_TEST_LEVEL && noise_declared {
        notices.push(format!(
            "the largest residual is that of {}",
            worst_length(campaign, lengths, screened)
        ));
    }
    AdjustmentReport {
        observations: solution.observations,
        unknowns: solution.unknowns,
        degrees_of_freedom,
        sigma0,
        p_value,
        noise_declared,
        uncertainty_factor: 1.0,
        factor_degrees_of_freedom: f64::INFINITY,
        rms_residual_mm: solution.rms_residual_mm(),
        noise: Some(noise),
        rejected: screened
            .removed
            .iter()
            .map(|removed| RejectedLength {
                line: lengths.readings[removed.reading].line,
                length: length_in_words(campaign, lengths, removed.reading),
                error_mm: removed.error_mm,
                u_mm: removed.u_mm,
                unchecked: removed.unchecked,
            })
            .collect(),
        interruptions: interruptions(campaign, lengths, screened),
        iterations: solution.iterations,
        termination: solution.termination.to_string(),
    }
}

/// What a user must know of a noise that could not be told apart.
fn noise_notices(noise: &NoiseReport, notices: &mut Vec<String>) {
    if noise.basis != NoiseBasis::CommonFactor {
        return;
    }
    notices.push(match noise.machine_return.declared_mm {
        Some(_) => {
            "the lengths do not tell their own noise from the machine's return: the declared ratio \
                    of the two is kept"
                .to_owned()
        }
        None => "the lengths do not tell their own noise from the machine's return, and no \
                 `repeatability_um` is declared: all noise is taken for that of single lengths"
            .to_owned(),
    });
}

fn noise_report(campaign: &Campaign, screened: &Screened) -> NoiseReport {
    let instrument = &campaign.instrument;
    let part = |declared_um: Option<f64>, used: PartEstimate| PartReport {
        declared_mm: declared_um.map(|um| um * MICROMETRE),
        used: PartEstimate {
            p_value: used.p_value.filter(|_| declared_um.is_some()),
            ..used
        },
    };
    let noise = &screened.noise;
    NoiseReport {
        basis: noise.basis,
        length: part(instrument.length_sigma_um, noise.length),
        length_ppm: noise.noise.length_sigma_relative * 1e6,
        machine_return: part(instrument.repeatability_um, noise.machine_return),
    }
}

fn interruptions(
    campaign: &Campaign,
    lengths: &Lengths,
    screened: &Screened,
) -> Vec<InterruptedTurn> {
    let turn = |jump: &trueaxis_multilateration::Jump| {
        let after = jump.first_reading;
        let before = (0..after).rfind(|&i| stop_of(lengths, i).station == jump.station);
        let pair = [before.unwrap_or(after), after];
        InterruptedTurn {
            station: campaign.stations[jump.station].name.clone(),
            lines: pair.map(|i| lengths.readings[i].line),
            times_s: pair.map(|i| lengths.readings[i].time_s),
            change_mm: jump.change_mm,
            u_mm: jump.u_mm,
        }
    };
    screened.jumps.iter().map(turn).collect()
}

/// The used length with the largest residual, in words.
fn worst_length(campaign: &Campaign, lengths: &Lengths, screened: &Screened) -> String {
    let residuals = screened.kept.iter().zip(&screened.solution.residuals_mm);
    residuals
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .map_or_else(String::new, |(&reading, residual_mm)| {
            format!(
                "{} with {:.1} µm",
                length_in_words(campaign, lengths, reading),
                residual_mm.abs() / MICROMETRE
            )
        })
}

/// How the residuals compare with the declared noise.
pub(crate) struct Residuals {
    pub(crate) sigma0: f64,
    pub(crate) p_value: f64,
    pub(crate) degrees_of_freedom: usize,
    pub(crate) noise_declared: bool,
    pub(crate) consequence: &'static str,
}

impl Residuals {
    pub(crate) fn notices(&self, both_sides: bool, notices: &mut Vec<String>) {
        let Self {
            sigma0,
            p_value,
            degrees_of_freedom,
            consequence,
            ..
        } = self;
        if *degrees_of_freedom == 0 {
            notices.push(
                "nothing checks the measurement: there are no more observations than unknowns"
                    .to_owned(),
            );
        } else if !self.noise_declared {
            notices.push(format!(
                "the noise is not declared: uncertainties follow from the residuals \
                 ({degrees_of_freedom} degrees of freedom)"
            ));
        } else if *p_value < GLOBAL_TEST_LEVEL {
            notices.push(format!(
                "the residuals are {sigma0:.2} times what the declared noise explains (p {}): the model \
                 or the declared noise is wrong; {consequence}",
                match *p_value < f64::MIN_POSITIVE {
                    true => "below 1e-300".to_owned(),
                    false => format!("= {p_value:.0e}"),
                }
            ));
            if both_sides {
                notices.push(
                    "positions were approached from both sides: lost motion makes such residuals; \
                     --by-direction gives each side curves of its own"
                        .to_owned(),
                );
            }
        } else if *p_value > 1.0 - GLOBAL_TEST_LEVEL {
            notices.push(format!(
                "the residuals are only {sigma0:.3} times what the declared noise explains: it is \
                 declared too large; {consequence}"
            ));
        }
    }
}

pub(crate) fn approached_from_both_sides(campaign: &Campaign) -> bool {
    let lengths = campaign.lengths.iter().flat_map(|lengths| &lengths.stops);
    let points = campaign.points.iter().flat_map(|points| &points.stops);
    let mut directions = lengths.chain(points).map(|stop| stop.direction);
    let first = directions.next();
    directions.any(|direction| Some(direction) != first)
}
