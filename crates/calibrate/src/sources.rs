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

use nalgebra::{DMatrix, Matrix6xX};

use crate::axis_data::AxisData;
use crate::gauge::PER_RUN;
use crate::identify_axes::Identified;
use crate::measured::Measured;
use crate::records::{Context, around, select_rows, select_targets};
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
            .sensitivities
            .iter()
            .map(|s| take(s.location_parameters))
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
                let positions = context.positions_of(&axis.records[run.first_record]);
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
        let (axis, sensitivity) = (&data[k], &identified.sensitivities[k]);
        // The axis' own rows, in a compact order: location, targets, held.
        let mut rows: Vec<usize> = (0..sensitivity.location_parameters)
            .map(|i| self.location[k] + i)
            .collect();
        rows.extend(
            self.targets[k]
                .iter()
                .flatten()
                .flat_map(|&first| first..first + 3),
        );
        let held: Vec<Held> = self.held.iter().copied().filter(|h| h.data == k).collect();
        let first_held = rows.len();
        rows.extend(held.iter().flat_map(|h| h.first..h.first + 6));

        let from_parameters = from_parameters(context, data, identified, k, &held, rows.len());
        let mut own = DMatrix::zeros(rows.len(), rows.len());
        let mut shared = DMatrix::zeros(rows.len(), context.measured.noise.shared_sources());
        for (i, record) in axis.records.iter().enumerate() {
            let mut f = &from_parameters * &sensitivity.parameters[i];
            for (h, place) in held.iter().enumerate() {
                let weight = weight_of_node(axis, place.position, record.node);
                if weight > 0.0 {
                    let share = weight / axis.nodes[record.node].records as f64;
                    let mut itself = f.rows_mut(first_held + 6 * h, 6);
                    itself += &identified.fits[k][i].from_points * share;
                }
            }
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
    let (axis, sensitivity) = (&data[k], &identified.sensitivities[k]);
    let values = &identified.state.axes[k];
    let errors = ModelErrors {
        data,
        state: &identified.state,
    };
    let geometry = &context.machine.axes()[axis.axis];
    let reference = geometry.reference_at_home_mm(&values.location);
    let mut map = DMatrix::zeros(rows, sensitivity.width());
    for i in 0..sensitivity.location_parameters {
        map[(i, i)] = 1.0;
    }
    let mut next = sensitivity.location_parameters;
    for (r, run) in axis.runs.iter().enumerate() {
        let first = sensitivity.location_parameters + PER_RUN * r;
        for (place, &target) in run.targets.iter().enumerate() {
            // C⁻¹ (g_δ + g_ε × (C r - o) + w)
            let carrier = context.campaign.targets[target].carrier;
            let (_, inner) = around(context.machine, carrier, axis.axis);
            let positions = context.positions_of(&axis.records[run.first_record]);
            let inside = context.machine.chain_motion(&errors, inner, positions);
            let back = inside.rotation.inverse().to_rotation_matrix().into_inner();
            let lever = inside * values.targets_mm[r][place] - reference;
            map.fixed_view_mut::<3, 3>(next, first).copy_from(&back);
            map.fixed_view_mut::<3, 3>(next, first + 3)
                .copy_from(&(-back * cross_matrix(lever)));
            map.fixed_view_mut::<3, 3>(next, sensitivity.shapes[r][place])
                .copy_from(&back);
            next += 3;
        }
    }
    for place in held {
        let mut effect = Matrix6xX::zeros(sensitivity.width());
        for (node, weight) in axis.weights_at(place.position) {
            effect += &sensitivity.node_effects[node] * weight;
        }
        map.rows_mut(next, 6).copy_from(&(-effect));
        next += 6;
    }
    map
}

/// Weight of a node in the component errors at a position.
fn weight_of_node(axis: &AxisData, position: f64, node: usize) -> f64 {
    axis.weights_at(position)
        .iter()
        .filter(|&&(k, _)| k == node)
        .map(|&(_, weight)| weight)
        .sum()
}
