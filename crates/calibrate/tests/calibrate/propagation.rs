//! Stated covariances against the response of the whole calibration to single observations.
//!
//! One observation after the other is changed and the campaign calibrated again, which gives the
//! derivatives `G` of every result. With the covariance `C` of the observations, put together here
//! from its definition, `G C Gᵀ` must be what the calibration states.

mod chains;
mod lengths;
mod point_residuals;
pub(crate) mod points;
mod stations_known;

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use trueaxis_calibrate::{Budget, Calibration, Method, Settings, calibrate};
use trueaxis_campaign::{Campaign, Stop};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_predict::CalibratedMachine;

use crate::{simulated, two_branches};

/// Change of an observation, mm: a twentieth of its noise, so that nothing takes it for an error,
/// and so small beside all distances that second-order terms are below 1e-5 of the response.
const STEP_MM: f64 = 1e-3;

/// Largest difference of two covariances, relative to the standard uncertainties. The propagation
/// is of first order: products with the machine's errors, 1e-4 rad, are left.
const COVARIANCE_TOL: f64 = 1e-3;

/// Uncertainties below this are zero, in µm, arcsec or mm: what the gauge defines comes back with
/// rounding.
const ROUNDING: f64 = 1e-9;

/// Positions of X, Y, C and tool points for which the prediction is looked at: on measured
/// positions, between them, and outside their range.
const PLACES: [([f64; 3], [f64; 3]); 3] = [
    ([0.0, 0.0, 0.0], [150.0, 100.0, 450.0]),
    ([170.0, 130.0, 1.3], [120.0, 60.0, 300.0]),
    ([420.0, 290.0, 5.6], [-80.0, 200.0, 200.0]),
];

/// The observations as they are: nothing is removed. X is approached from both sides.
fn settings(method: Method) -> Settings {
    let mut settings = Settings {
        covariance: true,
        ..Settings::default()
    };
    settings.poses.method = method;
    settings.poses.by_direction = true;
    settings.poses.robust = false;
    settings
}

/// All results in the order and units of their covariance, and behind them the predicted errors at
/// [`PLACES`] in mm and rad.
fn numbers(calibration: &Calibration) -> DVector<f64> {
    let axes = &calibration.axes;
    let nodes = axes.iter().flat_map(|axis| &axis.nodes);
    let components = nodes.flat_map(|node| node.error.to_vector().data.0[0]);
    let locations = axes.iter().flat_map(|axis| &axis.location_errors);
    let stations = calibration.stations.iter().flat_map(|station| {
        let p = station.position_mm;
        [p.x, p.y, p.z, station.dead_path_mm]
    });
    let mut all: Vec<f64> = components
        .chain(locations.map(|location| location.value))
        .chain(stations)
        .collect();
    let outputs = &calibration.covariance.as_ref().unwrap().outputs;
    assert_eq!(all.len(), outputs.len());
    for (value, output) in all.iter_mut().zip(outputs) {
        *value /= output.unit().size();
    }
    let machine = calibration.calibrated_machine();
    for (positions, point) in &PLACES {
        let prediction = machine.predict(positions, Point3::from(*point));
        all.extend_from_slice(prediction.error.to_vector().as_slice());
    }
    DVector::from_vec(all)
}

/// A campaign with the result as it is and the derivatives of [`numbers`] by every observation, one
/// column for each.
pub(crate) struct Response {
    stated: Calibration,
    derivatives: DMatrix<f64>,
}

impl Response {
    /// `calibrated` is the calibration with one observation changed by so many mm.
    fn new(observations: usize, calibrated: impl Fn(usize, f64) -> Calibration) -> Self {
        let stated = calibrated(0, 0.0);
        let start = numbers(&stated);
        let columns: Vec<DVector<f64>> = (0..observations)
            .map(|i| (numbers(&calibrated(i, STEP_MM)) - &start) / STEP_MM)
            .collect();
        Self {
            stated,
            derivatives: DMatrix::from_columns(&columns),
        }
    }

    /// `G C Gᵀ`.
    fn propagated(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        &self.derivatives * covariance * self.derivatives.transpose()
    }

    /// Asserts that the calibration states the covariance that follows from that of the
    /// observations.
    fn assert_stated(&self, what: &str, covariance: &DMatrix<f64>) {
        let found = self.propagated(covariance);
        let stated = &self.stated.covariance.as_ref().unwrap().matrix;
        let size = stated.nrows();
        assert_same(what, stated, &found.view((0, 0), (size, size)).into_owned());
        let machine = self.stated.calibrated_machine();
        for (k, (positions, point)) in PLACES.iter().enumerate() {
            let point = Point3::from(*point);
            let place = machine.predict(positions, point);
            let stated = place.covariance - place.of_interpolation;
            let first = size + 6 * k;
            assert_same(
                &format!("{what}: prediction {k}"),
                &DMatrix::from_column_slice(6, 6, stated.as_slice()),
                &found.view((first, first), (6, 6)).into_owned(),
            );
        }
    }

    /// The budget of each component and location error in the units of their covariance, with its
    /// degrees of freedom.
    fn budgets(&self) -> Vec<(Budget, f64)> {
        let axes = &self.stated.axes;
        let nodes = axes.iter().flat_map(|axis| &axis.nodes);
        let components = nodes.flat_map(|node| node.budget.into_iter().zip(node.dof));
        let locations = axes.iter().flat_map(|axis| &axis.location_errors);
        let all = components.chain(locations.map(|location| (location.budget, location.dof)));
        let outputs = &self.stated.covariance.as_ref().unwrap().outputs;
        all.zip(outputs)
            .map(|((budget, dof), output)| {
                let unit = output.unit().size().powi(2);
                let in_unit = Budget {
                    laser: budget.laser / unit,
                    repeatability: budget.repeatability / unit,
                    station_geometry: budget.station_geometry / unit,
                    effects: budget.effects / unit,
                    systematic: budget.systematic / unit,
                    laser_in_all: budget.laser_in_all / unit,
                };
                (in_unit, dof)
            })
            .collect()
    }
}

/// Where a target is at a step in the reference frame, as calibrated.
fn target_at(
    campaign: &Campaign,
    (calibration, errors): (&Calibration, &CalibratedMachine),
    stop: &Stop,
    target: usize,
) -> Point3<f64> {
    let content = &campaign.targets[target];
    let mut targets = calibration.targets.iter();
    let home_mm = targets
        .find(|t| t.name == content.name)
        .unwrap()
        .position_mm;
    let positions = &campaign.steps[stop.step].positions;
    let machine = &campaign.machine;
    machine.position(errors, content.carrier, positions, home_mm)
}

/// `σ_m²`: variance per coordinate of the place that the machine returns to, mm².
fn repeatability_variance_mm2(campaign: &Campaign) -> f64 {
    (campaign.instrument.repeatability_um.unwrap() * MICROMETRE).powi(2)
}

/// Asserts that two covariances agree.
fn assert_same(what: &str, stated: &DMatrix<f64>, found: &DMatrix<f64>) {
    assert_eq!(stated.shape(), found.shape());
    let u = found
        .diagonal()
        .map(|variance| variance.sqrt().max(ROUNDING));
    let mut worst = (0.0, 0, 0);
    for i in 0..u.len() {
        for j in 0..u.len() {
            let difference = (stated[(i, j)] - found[(i, j)]).abs() / (u[i] * u[j]);
            if difference > worst.0 {
                worst = (difference, i, j);
            }
        }
    }
    let (difference, i, j) = worst;
    println!("{what}: agrees to {difference:.1e} of the uncertainties");
    assert!(
        difference < COVARIANCE_TOL,
        "{what}: ({i}, {j}): {} stated, {} found",
        stated[(i, j)],
        found[(i, j)]
    );
}
