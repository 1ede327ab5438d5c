//! All numbers of a calibration in one list.

use std::io;

use trueaxis_files::WriteSeek;
use trueaxis_kinematics::Component;

use crate::result::calibration::{AxisResult, Calibration, NodeResult, StationResult};
use trueaxis_predict::Output;

/// One number of a calibration with its uncertainty, in mm and rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberedResult {
    /// Which number it is.
    pub output: Output,
    /// Its value, mm or rad.
    pub value: f64,
    /// Its standard uncertainty, mm or rad; zero where gauge or frame define it.
    pub u: f64,
    /// Degrees of freedom of u.
    pub dof: f64,
}

impl Calibration {
    /// All results in a fixed order: the component errors of all axes (six for each position), the location errors,
    /// the stations (x y z and dead path of each).
    pub fn results(&self) -> Vec<NumberedResult> {
        results(&self.axes, &self.stations).collect()
    }

    /// Writes `covariance.npz`.
    pub fn write_covariance_npz(&self, out: &mut dyn WriteSeek) -> io::Result<()> {
        let results = results(&self.axes, &self.stations);
        let per_unit = results.map(|result| result.output.unit().size().recip());
        self.factors.write_npz(out, &per_unit.collect::<Vec<_>>())
    }
}

/// All results in order, one at a time, as there may be half a million.
pub(crate) fn results<'a>(
    axes: &'a [AxisResult],
    stations: &'a [StationResult],
) -> impl Iterator<Item = NumberedResult> {
    let of_node = |axis: &'a AxisResult, node: &'a NodeResult| {
        let values = node.error.to_vector();
        Component::ALL.into_iter().map(move |component| {
            let c = component.index();
            let output = Output::ComponentError {
                axis: axis.name.clone(),
                kind: axis.kind,
                component,
                position: node.position,
                direction: node.direction,
            };
            numbered(output, [values[c], node.u[c], node.dof[c]])
        })
    };
    let of_nodes = move |axis: &'a AxisResult| {
        let nodes = axis.nodes.iter();
        nodes.flat_map(move |node| of_node(axis, node))
    };
    let of_locations = |axis: &'a AxisResult| {
        let locations = axis.location_errors.iter();
        locations.map(move |location| {
            let (axis, component) = (axis.name.clone(), location.component);
            let output = Output::LocationError { axis, component };
            numbered(output, [location.value, location.u, location.dof])
        })
    };
    let of_station = |s: &'a StationResult| {
        let position = (0..3).map(move |coordinate| {
            let output = Output::StationPosition {
                station: s.name.clone(),
                coordinate,
            };
            let position_mm = s.position_mm[coordinate];
            numbered(output, [position_mm, s.u_mm[coordinate], s.dof[coordinate]])
        });
        let station = s.name.clone();
        let of_dead_path = [s.dead_path_mm, s.u_dead_path_mm, s.dof_dead_path];
        position.chain([numbered(Output::DeadPath { station }, of_dead_path)])
    };
    let of_axes = axes.iter().flat_map(of_nodes);
    let of_axes = of_axes.chain(axes.iter().flat_map(of_locations));
    of_axes.chain(stations.iter().flat_map(of_station))
}

fn numbered(output: Output, [value, u, dof]: [f64; 3]) -> NumberedResult {
    NumberedResult {
        output,
        value,
        u,
        dof,
    }
}
