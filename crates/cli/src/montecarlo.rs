//! `trueaxis montecarlo`.

use anyhow::Context;
use trueaxis_calibrate::{NumberedResult, calibrate_for_replay};
use trueaxis_campaign::{Campaign, checksums, read};
use trueaxis_files::counted;
use trueaxis_montecarlo::{
    FirstOrder, Outcome, Propagation, Settings, Trials, Validation, chance_of_ratio, propagate,
    validate,
};
use trueaxis_poses::at_one_temperature;
use trueaxis_predict::{Output, Unit};

use crate::args::MontecarloArgs;
use crate::exit::Exit;
use crate::montecarlo_file::{self, Compared};
use crate::summary::{first_ones, in_words};
use crate::talk::{notice, notice_all, say_all};
use crate::traceability::traced;
use crate::{progress, summary};

/// Trials without `--trials`: fixed, and most with `--digits` (or what the memory takes).
const TRIALS: usize = 10_000;
const MOST_TRIALS: usize = 1_000_000;

/// Significant digits of u to which the first-order result is compared.
const DIGITS: u32 = 1;

pub(crate) fn execute(args: &MontecarloArgs) -> anyhow::Result<Exit> {
    let mut campaign = read(&args.campaign)?;
    let systematic = without_systematic_parts(&mut campaign);
    let campaign = at_one_temperature(&campaign);
    let in_file = || args.campaign.display().to_string();
    let (calibration, replay) =
        calibrate_for_replay(&campaign, &args.model.settings()).with_context(in_file)?;
    let defaults = Settings::default();
    let fitting = defaults.memory_limit_bytes / size_of::<f64>() as u64;
    let fitting = usize::try_from(fitting).unwrap_or(usize::MAX) / replay.results().len().max(1);
    let most = args.trials.unwrap_or(match args.digits {
        None => TRIALS,
        Some(_) => MOST_TRIALS.min(fitting),
    });
    let settings = Settings {
        trials: match args.digits {
            None => Trials::Fixed(most),
            Some(significant_digits) => Trials::Adaptive {
                significant_digits,
                most,
            },
        },
        seed: args.seed,
        threads: args.threads,
        ..defaults
    };
    let bar = progress::bar(most);
    let propagation = propagate(&replay, &settings, &|done| bar.set_position(done as u64));
    bar.finish_and_clear();
    let propagation = propagation.map_err(|error| in_words_of_results(error, replay.results()))?;
    let compared = compare(
        replay.results(),
        &propagation,
        args.digits.unwrap_or(DIGITS),
    )?;

    let document = montecarlo_file::document(&campaign.name, args.seed, &propagation, &compared)?;
    let text = traced(document, &checksums(&args.campaign)?, Some(args.seed))?;
    let mut results = args.result.folder(&campaign.name)?;
    results.write("montecarlo.json", text.as_bytes())?;
    let adjustment = summary::adjustment(&calibration);
    say_all(adjustment.into_iter().chain(lines(&propagation, &compared)));
    notice_all(campaign.notices.iter().chain(&calibration.notices));
    if systematic {
        notice(
            "noise is redrawn; how well nests were set and temperatures are known is no noise, and left out of \
             both sides of the comparison",
        );
    }
    results.end(args.result.json.then_some(&text))?;
    Ok(Exit::Good)
}

/// Takes out what enters uncertainties and is no noise; returns whether there was any.
fn without_systematic_parts(campaign: &mut Campaign) -> bool {
    let nests = campaign.targets.iter_mut();
    let nests = nests
        .filter_map(|target| target.position_sigma_mm.take())
        .count();
    let expansions = campaign.expansions.iter_mut();
    let temperatures = expansions
        .filter_map(|e| e.temperature_sigma_k.take())
        .count();
    nests + temperatures > 0
}

fn compare<'a>(
    results: &'a [NumberedResult],
    propagation: &Propagation,
    digits: u32,
) -> anyhow::Result<Vec<Compared<'a>>> {
    let all = results.iter().zip(&propagation.outputs);
    all.map(|(result, &monte_carlo)| {
        let unit = result.output.unit().size();
        let (value, u) = (result.value / unit, result.u / unit);
        let first_order = FirstOrder::normal(value, u, propagation.coverage);
        Ok(Compared {
            result,
            first_order,
            monte_carlo,
            validation: decided(
                validate(&first_order, &monte_carlo, digits)?,
                propagation.trials,
            ),
        })
    })
    .collect()
}

/// Fewer trials than the guide asks for do not refute a first-order result.
const LEAST_DECIDING: usize = 10_000;

fn decided(validation: Validation, trials: usize) -> Validation {
    match validation.outcome {
        Outcome::NotValidated if trials < LEAST_DECIDING => Validation {
            outcome: Outcome::Undecided,
            ..validation
        },
        _ => validation,
    }
}

/// Which result failed, and why that happens.
fn in_words_of_results(
    error: trueaxis_montecarlo::Error,
    results: &[NumberedResult],
) -> anyhow::Error {
    let trueaxis_montecarlo::Error::NotFinite { output, .. } = error else {
        return error.into();
    };
    let name = in_words(&results[output].output);
    anyhow::Error::new(error).context(format!(
        "{name} does not converge in one of the trials: the lengths determine stations or points too weakly \
         for their noise; measure more, or spread the stations"
    ))
}

fn lines(propagation: &Propagation, compared: &[Compared<'_>]) -> Vec<String> {
    let mut lines = vec![format!(
        "{} of this noise, {}",
        counted(propagation.trials, "trial"),
        counted(compared.len(), "result")
    )];
    if let Some(stability) = &propagation.stability {
        let open = stability.outputs.iter().filter(|o| !o.is_stabilised());
        lines.push(match open.count() {
            0 => "all results are stable to the digits asked for".to_owned(),
            1 => "1 result is not stable to the digits asked for: allow more --trials".to_owned(),
            open => format!(
                "{open} results are not stable to the digits asked for: allow more --trials"
            ),
        });
    }
    lines.push(String::new());
    lines.push(format!(
        "{:<24}{:>12}{:>12}{:>12}{:>26}",
        "location errors", "value", "u", "u (trials)", "95 % interval (trials)"
    ));
    for one in compared {
        let Output::LocationError { .. } = one.result.output else {
            continue;
        };
        let (unit, per_unit) = match one.result.output.unit() {
            Unit::Arcsec => ("″ ", 1.0),
            _ => ("µm", 1e3),
        };
        let of = |x: f64| format!("{:>9.3} {unit}", x * per_unit);
        lines.push(format!(
            "  {:<22}{}{}{}   {} …{}",
            one.result.output.name(),
            of(one.first_order.value),
            of(one.first_order.u),
            of(one.monte_carlo.u),
            of(one.monte_carlo.symmetric.low),
            of(one.monte_carlo.symmetric.high)
        ));
    }
    lines.push(String::new());
    lines.extend(verdict(compared, propagation.trials));
    lines
}

/// Below this probability the largest difference is not by chance.
const SURPRISE: f64 = 0.01;

/// How first order and Monte Carlo agree.
fn verdict(compared: &[Compared<'_>], trials: usize) -> Vec<String> {
    let ratio = |one: &&Compared<'_>| one.monte_carlo.u / one.first_order.u - 1.0;
    let mut lines = Vec::new();
    let worst = compared
        .iter()
        .max_by(|a, b| ratio(a).abs().total_cmp(&ratio(b).abs()));
    if let Some(worst) = worst {
        let chance = chance_of_ratio(1.0 + ratio(&worst), trials, compared.len());
        let counts = format!(
            "the largest of {} by {}",
            counted(compared.len(), "result"),
            counted(trials, "trial")
        );
        let judged = match chance < SURPRISE {
            true => format!("more than chance makes {counts} (p at most {chance:.0e})"),
            false => format!("no more than chance makes {counts}"),
        };
        lines.push(format!(
            "u by trials against first order: {:+.1} % at most ({}), {judged}",
            100.0 * ratio(&worst),
            in_words(&worst.result.output),
        ));
    }
    let of = |outcome: Outcome| -> Vec<&Compared<'_>> {
        let all = compared.iter();
        all.filter(|one| one.validation.outcome == outcome)
            .collect()
    };
    lines.push(format!(
        "first-order 95 % intervals (JCGM 101, clause 8): {} validated, {} not decided by so few trials, \
         {} not validated",
        of(Outcome::Validated).len(),
        of(Outcome::Undecided).len(),
        of(Outcome::NotValidated).len()
    ));
    lines.extend(first_ones(&of(Outcome::NotValidated), "", |one| {
        format!(
            "  {}: ends off by {:.3} and {:.3}, tolerance {:.3} {}",
            in_words(&one.result.output),
            one.validation.d_low,
            one.validation.d_high,
            one.validation.tolerance,
            one.result.output.unit().suffix()
        )
    }));
    lines
}
