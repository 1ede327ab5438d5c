//! Runs of measured points that contradict each other in the calibration: something is wrong, but no cause is sought.

use trueaxis_calibrate::Calibration;
use trueaxis_effects::Level;
use trueaxis_kinematics::MICROMETRE;

use crate::said::Entry;
use crate::{LevelReport, Misfit, OmnibusTest, Shares, Unexplained};

/// The result of one test of the calibration.
struct Contradiction {
    said: String,
    columns: usize,
    p_value: f64,
    chi_squared: f64,
    /// Size of the difference of the runs.
    differs_mm: f64,
}

/// What the calibration rejects: contradictory runs of one axis, and runs in which the stage is turned.
pub(crate) fn contradicting_runs(calibration: &Calibration) -> Option<Entry> {
    let of_axes = calibration.axes.iter().filter_map(|axis| {
        let own = axis.runs.as_ref()?;
        Some(Contradiction {
            said: format!("runs {} of axis {} differ", own.runs.join(", "), axis.name),
            columns: own.degrees_of_freedom,
            p_value: own.p_value,
            chi_squared: own.chi_squared,
            differs_mm: own.rms_mm,
        })
    });
    let turned = calibration.turned_runs.iter().map(|own| {
        let runs = own.runs.join(" and ");
        Contradiction {
            said: format!("runs {runs} are turned against each other"),
            columns: own.degrees_of_freedom,
            p_value: own.p_value,
            chi_squared: own.chi_squared,
            differs_mm: own.moved_mm,
        }
    });
    let all: Vec<Contradiction> = of_axes.chain(turned).collect();
    let largest_mm = all.iter().map(|own| own.differs_mm).reduce(f64::max)?;
    let squares: f64 = all.iter().map(|own| own.chi_squared).sum();
    let columns = all.iter().map(|own| own.columns).sum::<usize>() as f64;
    let noise = (columns / squares.max(columns)).min(1.0);
    let rms_um = largest_mm / MICROMETRE;
    let misfit = Misfit {
        rms_um,
        heldout_rms_um: None,
    };
    let said: Vec<&str> = all.iter().map(|own| own.said.as_str()).collect();
    let said = said.join("; ");
    let note = format!(
        "{said}: the instrument or its frame was moved between runs, the machine shifted, or one axis moves another"
    );
    let tests = all.into_iter().map(|own| OmnibusTest {
        varies_with: "run",
        detail: Some(own.said),
        columns: own.columns,
        p_value: own.p_value,
    });
    let tests: Vec<OmnibusTest> = tests.collect();
    Some(Entry {
        causes: Vec::new(),
        disturbances: Vec::new(),
        report: LevelReport {
            level: Level::Points,
            data: "runs".to_owned(),
            noise_floor_um: rms_um * noise.sqrt(),
            prediction_u_um: None,
            before: misfit,
            after: misfit,
            gain: None,
            shares: Shares {
                causes: Vec::new(),
                disturbances: Vec::new(),
                unexplained: 1.0 - noise,
                noise,
            },
            unexplained: Some(Unexplained::new(Level::Points, rms_um, vec!["run"], note)),
            tests: tests.clone(),
            tests_after: tests,
            places: Vec::new(),
        },
    })
}
