//! The quantities of each axis on which results depend, with their joint covariance.
//!
//! All of them are linear in the measured points, `θ = Σ_i F_i dp_i`, and so
//!
//! ```text
//! cov(θ) = [same axis] Σ_i F_i D_i F_iᵀ + (Σ F Z) Σ (Σ F Z)ᵀ
//! ```
//!
//! Each axis contributes its location parameters, the home positions of its targets, and its
//! component errors where it stands while others are measured. The stations are shared sources
//! themselves.

use nalgebra::{DMatrix, Matrix3, Matrix3xX, Matrix6xX};

use crate::axis_data::AxisData;
use crate::gauge::{Gauge, PER_RUN};
use crate::identify_axes::Identified;
use crate::measured::Measured;
use crate::records::{Context, RecordFit, around, select_rows, select_targets};
use crate::state::ModelErrors;
use crate::twist::cross_matrix;

/// All quantities, their places and their covariance.
pub(crate) struct Sources {
    /// Number of quantities.
    pub(crate) count: usize,
    /// First location parameter of each axis.
    pub(crate) location: Vec<usize>,
    /// For each axis, run and target the first of three coordinates.
    pub(crate) targets: Vec<Vec<Vec<usize>>>,
    /// Where other axes stand: axis, position, first of its six component errors.
    pub(crate) held: Vec<Held>,
    /// First unknown of the first station (x y z L each).
    pub(crate) stations: usize,
    /// Covariance, mm and rad.
    pub(crate) covariance: DMatrix<f64>,
}

/// Component errors of an axis at a position where it stands while another one is measured.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Held {
    /// Index of the axis data.
    pub(crate) data: usize,
    /// Position, mm or rad.
    pub(crate) position: f64,
    /// First of its six rows.
    pub(crate) first: usize,
}

impl Sources {
    pub(crate) fn new(
        context: &Context<'_>,
        data: &[AxisData],
        identified: &Identified,
        stations: usize,
    ) -> Self {
        let mut sources = Self::layout(context, data, identified, stations);
        let shared = context.measured.noise.shared();
        let mut through_shared = DMatrix::zeros(sources.count, shared.nrows());
        for k in 0..data.len() {
            sources.add_axis(context, data, identified, k, &mut through_shared);
        }
        for i in 0..4 * stations {
            through_shared[(sources.stations + i, i)] = 1.0;
        }
        sources.covariance += &through_shared * shared * through_shared.transpose();
        sources
    }

    fn layout(
        context: &Context<'_>,
        data: &[AxisData],
        identified: &Identified,
        stations: usize,
    ) -> Self {
        let mut next = 0;
        let mut take = |rows: usize| {
            next += rows;
            next - rows
        };
        let location = identified
            .gauges
            .iter()
            .map(|g| take(g.location_parameters))
            .collect();
        let targets = data
            .iter()
            .map(|axis| {
                axis.runs
                    .iter()
                    .map(|run| run.targets.iter().map(|_| take(3)).collect())
                    .collect()
            })
            .collect();
        let mut held: Vec<Held> = Vec::new();
        for axis in data {
            for run in &axis.runs {
                let positions = positions_of(context, axis, run.first_record);
                for &target in &run.targets {
                    let carrier = context.campaign.targets[target].carrier;
                    for &other in context.machine.chain(carrier) {
                        let Some(k) = data.iter().position(|d| d.axis == other) else {
                            continue;
                        };
                        let position = positions[other];
                        if other != axis.axis && find(&held, k, position).is_none() {
                            held.push(Held {
                                data: k,
                                position,
                                first: take(6),
                            });
                        }
                    }
                }
            }
        }
        let stations = take(4 * stations);
        let covariance = DMatrix::zeros(next, next);
        Self {
            count: next,
            location,
            targets,
            held,
            stations,
            covariance,
        }
    }

    /// The place of a held axis' component errors.
    pub(crate) fn held_at(&self, data: usize, position: f64) -> Option<usize> {
        find(&self.held, data, position)
    }

    fn add_axis(
        &mut self,
        context: &Context<'_>,
        data: &[AxisData],
        identified: &Identified,
        k: usize,
        through_shared: &mut DMatrix<f64>,
    ) {
        let (axis, gauge, fits) = (&data[k], &identified.gauges[k], &identified.fits[k]);
        // The axis' own rows, in a compact order: location, targets, held.
        let mut rows: Vec<usize> = (0..gauge.location_parameters)
            .map(|i| self.location[k] + i)
            .collect();
        rows.extend(
            self.targets[k]
                .iter()
                .flatten()
                .flat_map(|&first| first..first + 3),
        );
        let held: Vec<Held> = self.held.iter().copied().filter(|h| h.data == k).collect();
        rows.extend(held.iter().flat_map(|h| h.first..h.first + 6));

        let from_parameters = from_parameters(context, data, identified, k, &held, rows.len());
        let mut own = DMatrix::zeros(rows.len(), rows.len());
        let mut shared = DMatrix::zeros(rows.len(), context.measured.noise.shared_sources());
        for i in 0..axis.records.len() {
            let mut f = &from_parameters * &gauge.shares[i] * &fits[i].from_points;
            add_held_itself(axis, gauge, &held, i, fits, &mut f);
            add_distortion(
                context,
                data,
                identified,
                k,
                i,
                gauge.location_parameters,
                &mut f,
            );
            let (d, z) = noise_of(context.measured, axis, i);
            own += &f * d * f.transpose();
            shared -= &f * z;
        }
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in rows.iter().enumerate() {
                self.covariance[(row, column)] += own[(i, j)];
            }
            for j in 0..shared.ncols() {
                through_shared[(row, j)] += shared[(i, j)];
            }
        }
    }
}

/// `D` and `Z` of a record's points.
pub(crate) fn noise_of(
    measured: &Measured,
    axis: &AxisData,
    record: usize,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let record = &axis.records[record];
    (
        select_targets(&measured.noise.own(record.group), record),
        select_rows(&measured.noise.coupling(record.group), record),
    )
}

/// Positions of all axes at a record.
pub(crate) fn positions_of<'a>(context: &Context<'a>, axis: &AxisData, record: usize) -> &'a [f64] {
    let group = axis.records[record].group;
    &context.campaign.steps[context.measured.groups[group].step].positions
}

fn find(held: &[Held], data: usize, position: f64) -> Option<usize> {
    let same = |h: &&Held| h.data == data && h.position.total_cmp(&position).is_eq();
    held.iter().find(same).map(|h| h.first)
}

/// How the axis' rows follow from its gauge parameters.
fn from_parameters(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    k: usize,
    held: &[Held],
    rows: usize,
) -> DMatrix<f64> {
    let (axis, gauge) = (&data[k], &identified.gauges[k]);
    let values = &identified.state.axes[k];
    let errors = ModelErrors {
        data,
        state: &identified.state,
    };
    let geometry = &context.machine.axes()[axis.axis];
    let reference = geometry.reference_at_home_mm(&values.location);
    let mut map = DMatrix::zeros(rows, gauge.parameters());
    for i in 0..gauge.location_parameters {
        map[(i, i)] = 1.0;
    }
    let mut next = gauge.location_parameters;
    for (r, run) in axis.runs.iter().enumerate() {
        let first = gauge.location_parameters + PER_RUN * r;
        for (place, &target) in run.targets.iter().enumerate() {
            // C⁻¹ (g_δ + g_ε × (C r - o))
            let carrier = context.campaign.targets[target].carrier;
            let (_, inner) = around(context.machine, carrier, axis.axis);
            let positions = positions_of(context, axis, run.first_record);
            let inside = context.machine.chain_motion(&errors, inner, positions);
            let back = inside.rotation.inverse().to_rotation_matrix().into_inner();
            let lever = inside * values.targets_mm[r][place] - reference;
            map.fixed_view_mut::<3, 3>(next, first).copy_from(&back);
            map.fixed_view_mut::<3, 3>(next, first + 3)
                .copy_from(&(-back * cross_matrix(lever)));
            next += 3;
        }
    }
    for place in held {
        let mut effect = Matrix6xX::zeros(gauge.parameters());
        for (node, weight) in axis.weights_at(place.position) {
            effect += &gauge.node_effects[node] * weight;
        }
        map.rows_mut(next, 6).copy_from(&(-effect));
        next += 6;
    }
    map
}

/// The record's own pose error in the held component errors.
fn add_held_itself(
    axis: &AxisData,
    gauge: &Gauge,
    held: &[Held],
    record: usize,
    fits: &[RecordFit],
    f: &mut DMatrix<f64>,
) {
    let targets: usize = axis.runs.iter().map(|run| 3 * run.targets.len()).sum();
    let node = axis.records[record].node;
    for (h, place) in held.iter().enumerate() {
        let weight: f64 = axis
            .weights_at(place.position)
            .iter()
            .filter(|w| w.0 == node)
            .map(|w| w.1)
            .sum();
        if weight > 0.0 {
            let share = weight / axis.nodes[node].records as f64;
            let first = gauge.location_parameters + targets + 6 * h;
            let mut rows = f.rows_mut(first, 6);
            rows += &fits[record].from_points * share;
        }
    }
}

/// The record's part in the mean shape of the targets: what its rigid motion leaves.
fn add_distortion(
    context: &Context<'_>,
    data: &[AxisData],
    identified: &Identified,
    k: usize,
    record: usize,
    first_row: usize,
    f: &mut DMatrix<f64>,
) {
    let (axis, fit) = (&data[k], &identified.fits[k][record]);
    let own = &axis.records[record];
    let errors = ModelErrors {
        data,
        state: &identified.state,
    };
    let mut row = first_row;
    for (r, run) in axis.runs.iter().enumerate() {
        for (t, &target) in run.targets.iter().enumerate() {
            let place = own.targets.iter().position(|&(t, _)| t == target);
            if let (true, Some(place)) = (r == own.run, place) {
                let carrier = context.campaign.targets[target].carrier;
                let (_, inner) = around(context.machine, carrier, axis.axis);
                let positions = positions_of(context, axis, run.first_record);
                let inside = context.machine.chain_motion(&errors, inner, positions);
                let home_from_base = inside.rotation.inverse().to_rotation_matrix().into_inner()
                    * fit.stage_from_base;
                let turned = home_from_base / run.measured[t] as f64;
                let mut rows = f.rows_mut(row, 3);
                rows += distortion(fit, place, &turned);
            }
            row += 3;
        }
    }
}

/// `Q (I - A P)` of one target: columns for the record's points in datum coordinates.
fn distortion(fit: &RecordFit, place: usize, home_from_base: &Matrix3<f64>) -> Matrix3xX<f64> {
    let translations = fit.from_points.fixed_rows::<3>(0);
    let rotations = fit.from_points.fixed_rows::<3>(3);
    let mut left = cross_matrix(fit.levers_mm[place]) * rotations - translations;
    let mut own = left.fixed_columns_mut::<3>(3 * place);
    own += fit.base_from_datum;
    home_from_base * left
}
