//! `trueaxis predict`.

use serde_json::json;
use trueaxis_campaign::read_positions;
use trueaxis_files::{counted, point_mm, round};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_predict::{CalibratedMachine, Prediction, to_csv};

use crate::args::PredictArgs;
use crate::exit::Exit;
use crate::summary::expanded;
use crate::talk::{notice, say_all};

pub(crate) fn execute(args: &PredictArgs) -> anyhow::Result<Exit> {
    let machine = CalibratedMachine::read(&args.calibration)?;
    let positions = read_positions(&args.positions, machine.machine())?;
    let default_mm = machine.reference_point_mm();
    let places: Vec<_> = positions
        .iter()
        .map(|p| (p.axes.clone(), p.point_mm.unwrap_or(default_mm)))
        .collect();
    let predictions = machine.predict_all(&places);
    let columns = Prediction::columns(machine.machine());
    let rows = predictions.iter().zip(&places);
    let rows = rows
        .map(|(prediction, (axes, point_mm))| prediction.row(machine.machine(), axes, *point_mm));
    let rows: Vec<Vec<f64>> = rows.collect();

    let mut results = args.result.folder(&machine.campaign)?;
    let text = to_csv(&columns, rows.iter().cloned());
    results.write("predicted.csv", text.as_bytes())?;
    say_all(source(&machine));
    let lines: Vec<usize> = positions.iter().map(|p| p.line).collect();
    say_all(summary(&machine, &predictions, &lines));
    if positions.iter().all(|p| p.point_mm.is_none()) {
        notice(&format!(
            "the table has no x_mm,y_mm,z_mm: taken for the reference point {}",
            point_mm(default_mm.into())
        ));
    }
    let document = json!({
        "format": "trueaxis-prediction",
        "version": 1,
        "machine": machine.name,
        "campaign": machine.campaign,
        "effects_taken_out": machine.names_taken_out(),
        "dof": machine.dof.is_finite().then_some(machine.dof),
        "columns": columns,
        "rows": rows,
    });
    let printed = args.result.json.then(|| trueaxis_files::to_json(&document));
    results.end(printed.transpose()?.as_deref())?;
    Ok(Exit::Good)
}

/// Which machine and calibration it is, and what is not in it.
pub(crate) fn source(machine: &CalibratedMachine) -> Vec<String> {
    let effects = match machine.names_taken_out().as_slice() {
        [] => String::new(),
        effects => {
            let names = effects.iter().map(|effect| effect.replace('_', " "));
            let mut names: Vec<String> = names.collect();
            names.sort();
            names.dedup();
            format!(" (without {})", names.join(", "))
        }
    };
    let mut lines = vec![format!(
        "machine {}, calibrated in the campaign {}{effects}",
        machine.name, machine.campaign
    )];
    let unmeasured = machine.unmeasured();
    if !unmeasured.is_empty() {
        lines.push(format!(
            "axes that were not measured are taken for perfect, and no uncertainty contains them: {}",
            unmeasured.join(", ")
        ));
    }
    if !machine.has_uncertainties {
        lines.push(
            "the calibration has no uncertainties (it was imported without --u-um), so that nothing here has one"
                .to_owned(),
        );
    }
    lines
}

fn summary(
    machine: &CalibratedMachine,
    predictions: &[Prediction],
    lines: &[usize],
) -> Vec<String> {
    let k = expanded(1.0, machine.dof);
    let largest = |what: &str, first: usize, unit: f64, symbol: &str| {
        let size = |p: &Prediction| p.error.to_vector().fixed_rows::<3>(first).norm();
        let numbered = predictions.iter().zip(lines);
        let worst = numbered.max_by(|a, b| size(a.0).total_cmp(&size(b.0)));
        worst.map(|(p, line)| {
            let vector = p.error.to_vector();
            let (e, u) = (vector / unit, p.u() * k / unit);
            let part = |i: usize| match machine.has_uncertainties {
                true => format!("{:+.2} ± {:.2}", e[first + i], u[first + i]),
                false => format!("{:+.2}", e[first + i]),
            };
            format!(
                "  largest {what:12} {:.2} {symbol} in line {line}: {}, {}, {} {symbol}",
                size(p) / unit,
                part(0),
                part(1),
                part(2)
            )
        })
    };
    let outside = predictions.iter().filter(|p| p.extrapolated).count();
    let positions = counted(predictions.len(), "position");
    let mut all = vec![match machine.has_uncertainties {
        true => format!("{positions}; ± is U for k = {}", round(k, 2)),
        false => positions,
    }];
    all.extend(largest("displacement", 0, MICROMETRE, "µm"));
    all.extend(largest("rotation", 3, ARCSEC, "″"));
    if outside > 0 {
        all.push(format!(
            "  {outside} of them outside the steps of an axis (`extrapolated`): the errors of the nearest step are taken"
        ));
    }
    all
}
