//! Effects that a verification cannot show. They may be present all the same.

use trueaxis_effects::{Parameter, Shape};
use trueaxis_files::round;
use trueaxis_selection::Hypothesis;

use crate::NotObservable;
use crate::engine::{in_words, unseen};
use crate::verification::base::absorbed;
use crate::verification::hypotheses::{is_of_both_sides, sampling};
use crate::verification::problem::Problem;

/// Change of a reading by one unit of a parameter below which the effect does not reach it, µm.
const REACHES_UM: f64 = 1e-9;

/// All such effects of a problem.
pub(crate) fn not_observable(problem: &Problem<'_>) -> Vec<NotObservable> {
    let beside = problem.listed.beside(&[]);
    let mut all = Vec::new();
    for (number, candidate) in problem.listed.candidates.iter().enumerate() {
        let own = &candidate.hypothesis;
        if beside.numbers.contains(&number) {
            all.extend(too_short(problem, own));
            continue;
        }
        let bias = largest(problem, own);
        let why = if !is_of_both_sides(problem.comparison, own) {
            "the axis came from one side only".to_owned()
        } else if bias.is_empty() {
            not_reached(problem, own).to_owned()
        } else {
            let absorbed = absorbed(problem.comparison, problem.calibrated);
            format!("{absorbed} absorbs all that it does")
        };
        let reason = format!("{}: {why}", problem.comparison.name);
        let subject = in_words(&own.subject, problem.scene);
        all.push(unseen(own.effect, subject, reason, bias));
    }
    all
}

/// Why an effect leaves no trace in the readings.
fn not_reached(problem: &Problem<'_>, own: &Hypothesis) -> &'static str {
    let arrivals = &problem.comparison.arrivals;
    let stands = |axis: usize| arrivals.iter().all(|a| a.speeds_per_s[axis].abs() <= 0.0);
    match own.subject.axis {
        Some(axis) if own.effect.is_delay() && stands(axis) => {
            "the axis stands still at the readings, or the table has no times"
        }
        _ => "it does not change what was measured here",
    }
}

/// Largest change of a reading for one unit of each parameter.
fn largest(problem: &Problem<'_>, own: &Hypothesis) -> Vec<(String, String)> {
    let shape = match own.effect.shape {
        Shape::Fixed => 0.0,
        Shape::Instant => f64::NEG_INFINITY,
        _ => 1.0,
    };
    let parameters = own.parameters(problem.scene).into_iter().enumerate();
    let largest = parameters.filter_map(|(k, Parameter { name, unit, .. })| {
        let column = problem.comparison.column(own, k, shape);
        let largest = column.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        let unit = problem.comparison.unit_of(unit);
        let said = format!("{largest:.3} um per {unit} of {name}");
        (largest > REACHES_UM).then(|| ("reading".to_owned(), said))
    });
    largest.collect()
}

/// Periods down to two steps are shown, shorter ones are not.
fn too_short(problem: &Problem<'_>, own: &Hypothesis) -> Option<NotObservable> {
    let axis = own.subject.axis;
    let axis = axis.filter(|_| own.effect.shape == Shape::Period)?;
    let [_, step] = sampling(problem.comparison, axis)?;
    let kind = problem.scene.machine.axes()[axis].kind();
    let reason = format!(
        "{}: periods below {} {}, two steps of the readings",
        problem.comparison.name,
        round(2.0 * kind.position_in_file(step), 4),
        kind.position_unit()
    );
    let measure =
        "read a short stretch in steps of a tenth of the screw pitch or of the grating period";
    Some(NotObservable {
        measure: measure.to_owned(),
        ..unseen::<String>(
            own.effect,
            in_words(&own.subject, problem.scene),
            reason,
            [],
        )
    })
}
