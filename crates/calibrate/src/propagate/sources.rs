//! The quantities of each axis on which location errors and stations depend.
//!
//! Each axis contributes its location parameters, the placements of its bodies on the stage, and its component errors
//! at positions where it stands while others are measured: linear functions of its parameters and mean pose errors
//! ([`crate::propagate::axis_noise`]). The stations are functions of the shared sources alone. What the frame takes
//! from the nominal positions of the targets depends on how well their nests were set.

use nalgebra::{DMatrix, DVector};
use trueaxis_poses::PoseNoise;

use crate::identify::context::Context;
use crate::identify::gauge::PER_RUN;
use crate::identify::identify_axes::Identified;
use crate::propagate::axis_noise::{AxisForm, AxisNoise, PosePart};

/// All quantities and their indices.
pub(crate) struct Sources {
    /// Number of quantities.
    pub(crate) count: usize,
    /// First location parameter of each axis.
    pub(crate) location: Vec<usize>,
    /// For each axis and run the first of the six quantities of the body's twist on the stage: translation of the
    /// axis' reference point (mm), then rotation (rad), seen from the base.
    pub(crate) placements: Vec<Vec<usize>>,
    /// Positions where axes stand while others are measured.
    held: Vec<Held>,
    /// First unknown of the first station (x y z L each); they are the last.
    pub(crate) stations: usize,
    /// First coordinate of the first target's nest: its distance from nominal, mm.
    pub(crate) nests: usize,
    /// Declared variance of each coordinate of each nest, mm²; zero where none is declared.
    pub(crate) nest_variances_mm2: Vec<f64>,
    /// What each axis contributes.
    pub(crate) axes: Vec<OwnSources>,
}

/// The quantities of one axis.
pub(crate) struct OwnSources {
    /// Their indices among all: location parameters, placements, held component errors.
    pub(crate) places: Vec<usize>,
    /// How they follow from the axis' parameters and mean pose errors.
    pub(crate) form: AxisForm,
}

/// Component errors of an axis at a position where it stands while another one is measured.
#[derive(Debug, Clone, Copy)]
struct Held {
    /// Index of the axis data.
    data: usize,
    /// Position, mm or rad.
    position: f64,
    /// First of its six indices.
    first: usize,
}

/// The errors of all quantities.
pub(crate) struct SourceNoise {
    /// Covariance with the stations known.
    pub(crate) own: DMatrix<f64>,
    /// Coefficients of the shared sources.
    pub(crate) shared: DMatrix<f64>,
    /// Errors beside the noise, independent of it and of each other: the standard deviation of each in all
    /// quantities. They do not enter an axis' component errors through its own parameters.
    pub(crate) scatter: Vec<DVector<f64>>,
}

impl SourceNoise {
    /// The variances that these errors cause in functions of the quantities, one for each row.
    pub(crate) fn scatter_of(&self, rows: &DMatrix<f64>) -> DVector<f64> {
        let none = DVector::zeros(rows.nrows());
        let squares = self
            .scatter
            .iter()
            .map(|error| (rows * error).map(|x| x * x));
        squares.fold(none, |sum, squares| sum + squares)
    }
}

impl Sources {
    pub(crate) fn new(context: &Context<'_>, identified: &Identified, stations: usize) -> Self {
        let mut sources = Self::layout(context, identified, stations);
        sources.axes = (0..context.data.len())
            .map(|k| sources.own(context, identified, k))
            .collect();
        sources
    }

    /// The errors of all quantities from those of the axes.
    pub(crate) fn noise(&self, axes: &[AxisNoise<'_>], noise: &PoseNoise) -> SourceNoise {
        let mut own = DMatrix::zeros(self.count, self.count);
        let mut shared = DMatrix::zeros(self.count, noise.width());
        for (sources, noise) in self.axes.iter().zip(axes) {
            let covariance = noise.own(&sources.form);
            let coefficients = noise.shared(&sources.form);
            for (i, &row) in sources.places.iter().enumerate() {
                for (j, &column) in sources.places.iter().enumerate() {
                    own[(row, column)] = covariance[(i, j)];
                }
                shared.row_mut(row).copy_from(&coefficients.row(i));
            }
        }
        let mut stations = shared.rows_range_mut(self.stations..);
        if noise.stations.nrows() == stations.nrows() {
            stations.copy_from(&noise.stations);
        }
        for (i, &variance_mm2) in self.nest_variances_mm2.iter().enumerate() {
            own[(self.nests + i, self.nests + i)] = variance_mm2;
        }
        SourceNoise {
            own,
            shared,
            scatter: Vec::new(),
        }
    }

    fn layout(context: &Context<'_>, identified: &Identified, stations: usize) -> Self {
        let mut next = 0;
        let mut take = |rows: usize| {
            next += rows;
            next - rows
        };
        let location = identified
            .gauges
            .iter()
            .map(|gauge| take(gauge.location_parameters))
            .collect();
        let placements = context
            .data
            .iter()
            .map(|axis| axis.runs.iter().map(|_| take(PER_RUN)).collect())
            .collect();
        let mut held: Vec<Held> = Vec::new();
        for axis in context.data {
            for run in &axis.runs {
                for &other in run.outer.iter().chain(&run.inner) {
                    let Some(k) = context.place_of(other) else {
                        continue;
                    };
                    let position = run.positions[other];
                    if find(&held, k, position).is_none() {
                        held.push(Held {
                            data: k,
                            position,
                            first: take(6),
                        });
                    }
                }
            }
        }
        let targets = &context.campaign.targets;
        let variances = targets.iter().flat_map(|target| {
            let sigma_mm = target.position_sigma_mm.unwrap_or(0.0);
            [sigma_mm * sigma_mm; 3]
        });
        let nests = take(3 * targets.len());
        // Last, because stations depend on the shared sources alone.
        let stations = take(4 * stations);
        Self {
            count: next,
            location,
            placements,
            held,
            stations,
            nests,
            nest_variances_mm2: variances.collect(),
            axes: Vec::new(),
        }
    }

    /// The first index of a held axis' component errors.
    pub(crate) fn held_at(&self, data: usize, position: f64) -> Option<usize> {
        find(&self.held, data, position)
    }

    fn own(&self, context: &Context<'_>, identified: &Identified, k: usize) -> OwnSources {
        let (axis, gauge) = (&context.data[k], &identified.gauges[k]);
        let first = self.location[k];
        let mut places: Vec<usize> = (first..first + gauge.location_parameters).collect();
        let placements = self.placements[k].iter();
        places.extend(placements.flat_map(|&first| first..first + PER_RUN));
        let held: Vec<Held> = self.held.iter().copied().filter(|h| h.data == k).collect();
        let mut poses = Vec::new();
        for place in &held {
            for (node, weight) in axis.weights_at(place.position) {
                poses.push(PosePart {
                    row: places.len(),
                    node,
                    weight,
                });
            }
            places.extend(place.first..place.first + 6);
        }
        // Location parameters and placements are parameters of the axis.
        let mut parameters = DMatrix::zeros(places.len(), gauge.parameters());
        parameters.fill_diagonal(1.0);
        for (i, place) in held.iter().enumerate() {
            let first = gauge.parameters() + 6 * i;
            let mut rows = parameters.rows_mut(first, 6);
            for (node, weight) in axis.weights_at(place.position) {
                rows -= &gauge.node_effects[node] * weight;
            }
        }
        OwnSources {
            places,
            form: AxisForm { parameters, poses },
        }
    }
}

fn find(held: &[Held], data: usize, position: f64) -> Option<usize> {
    let same = |h: &&Held| h.data == data && h.position.total_cmp(&position).is_eq();
    held.iter().find(same).map(|h| h.first)
}
