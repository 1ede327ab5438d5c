//! How the results depend on the poses: component errors on those of their axis and, through its base, of other axes
//! ([`crate::propagate::frame_map`]); location errors and stations on all sources ([`crate::propagate::sources`]).

use nalgebra::{DMatrix, Matrix6xX, Point3, RowDVector};

use trueaxis_poses::Station;

use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;
use crate::propagate::axis_noise::AxisForm;
use crate::propagate::base_response::BaseResponse;
use crate::propagate::frame_map::FrameMap;
use crate::propagate::sources::Sources;

/// Influence of a nest on a location error (mm/mm, rad/mm) below which the influence is rounding.
const NEST_TOL: f64 = 1e-9;

/// Linear functions of the sources; columns are the sources.
pub(crate) struct Dependence<'a> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) identified: &'a Identified,
    pub(crate) sources: Sources,
    /// For each axis, in the order of the data: shift (mm) and tilt (rad), three rows each.
    pub(crate) locations: Vec<DMatrix<f64>>,
    /// Positions of the stations in the reference frame, mm.
    pub(crate) stations_in_ref: Vec<Point3<f64>>,
    /// For each station x y z and dead path, mm.
    pub(crate) stations: Vec<DMatrix<f64>>,
    /// For each axis its response to motions of its base, and for each run that motion.
    bases: Vec<(BaseResponse<'a>, Vec<Matrix6xX<f64>>)>,
}

impl<'a> Dependence<'a> {
    /// The input and the result of the identification.
    pub(crate) fn parts(&self) -> (&'a Context<'a>, &'a Identified) {
        (self.context, self.identified)
    }

    pub(crate) fn new(
        context: &'a Context<'a>,
        identified: &'a Identified,
        stations: &[Station],
    ) -> Self {
        let ref_from_datum = identified.state.ref_from_datum;
        let stations = stations.iter().map(|s| ref_from_datum * s.position_mm);
        let stations_in_ref: Vec<Point3<f64>> = stations.collect();
        let sources = Sources::new(context, identified, stations_in_ref.len());
        let mut map = FrameMap::new(context, identified, &sources);
        let frame = map.solve();
        let axes = 0..context.data.len();
        let locations = axes.clone().map(|k| map.location(k, &frame)).collect();
        let stations = stations_in_ref.iter().enumerate();
        let stations = stations.map(|(j, &p)| map.station(j, p, &frame)).collect();
        let motions = axes.map(|k| {
            let runs = 0..context.data[k].runs.len();
            runs.map(|run| map.base_motion(k, run).rows()).collect()
        });
        let motions: Vec<Vec<Matrix6xX<f64>>> = motions.collect();
        let bases = map.responses.into_iter().zip(motions).collect();
        Self {
            context,
            identified,
            sources,
            locations,
            stations_in_ref,
            stations,
            bases,
        }
    }

    /// The variance of a function of the sources caused by nests, mm² or rad².
    pub(crate) fn variance_of_nests(&self, coefficients: &RowDVector<f64>) -> f64 {
        let of_nests = self.of_nests(coefficients);
        let variances = of_nests.zip(&self.sources.nest_variances_mm2);
        variances
            .map(|(c, variance_mm2)| c * c * variance_mm2)
            .sum()
    }

    /// Whether row `place` of the location of axis `k` depends on the positions of the nests of the targets.
    pub(crate) fn depends_on_nests(&self, k: usize, place: usize) -> bool {
        let row = self.locations[k].row(place).into_owned();
        self.of_nests(&row).any(|c| c.abs() > NEST_TOL)
    }

    /// The coefficients of the nests' coordinates among those of all sources.
    pub(crate) fn of_nests<'c>(
        &self,
        coefficients: &'c RowDVector<f64>,
    ) -> impl Iterator<Item = f64> + 'c {
        let count = self.sources.nest_variances_mm2.len();
        coefficients
            .iter()
            .skip(self.sources.nests)
            .take(count)
            .copied()
    }

    /// Whether the base of axis `k` may have had another position in another run.
    pub(crate) fn has_moving_base(&self, k: usize) -> bool {
        self.bases[k].1.len() > 1
    }

    /// Response of a pose of axis `k` to the sources through its base, with the sign of the base's motion, which the
    /// pose error has opposite: six rows.
    pub(crate) fn response_to_base(&self, k: usize, pose: usize) -> DMatrix<f64> {
        let (response, motions) = &self.bases[k];
        let run = self.context.data[k].poses[pose].run;
        let rows = response.of_pose(pose) * &motions[run];
        DMatrix::from_column_slice(6, rows.ncols(), rows.as_slice())
    }

    /// Response of functions of axis `k` to the errors of its base; `None` if it has one run, so that its base stands
    /// still.
    pub(crate) fn through_base(&self, k: usize, form: &AxisForm) -> Option<DMatrix<f64>> {
        if !self.has_moving_base(k) {
            return None;
        }
        let (response, motions) = &self.bases[k];
        let of_run = |(run, motion): (usize, &Matrix6xX<f64>)| -(response.of(form, run) * motion);
        let runs = motions.iter().enumerate().map(of_run);
        runs.reduce(|sum, rows| sum + rows)
    }
}
