//! Standard uncertainties of all results, with their budget and degrees of freedom.
//!
//! Every result is a linear function of the points' errors, propagated twice: for the whole noise
//! and for the instrument's own part of it. Each variance has a part with the stations known and
//! one that comes through them.
//!
//! Component errors do not depend on the reference frame: the gauge removes a rigid motion of the
//! whole. Location errors and stations do ([`crate::frame_forms`]).

use nalgebra::{DMatrix, Matrix2, Matrix6xX, Point3};
use trueaxis_multilateration::GroupNoise;

use crate::axis_data::AxisData;
use crate::axis_noise::{AxisForm, AxisNoise, ComponentNoise};
use crate::budget::Budget;
use crate::frame_forms::FrameForms;
use crate::identify_axes::Identified;
use crate::in_order;
use crate::matrix_products::add_product;
use crate::point_noise::PointNoise;
use crate::records::Context;
use crate::sources::{OwnSources, SourceNoise, Sources};

/// How the results depend on the points, and the points' errors.
pub(crate) struct Propagation<'a> {
    pub(crate) identified: &'a Identified,
    pub(crate) sources: Sources,
    pub(crate) forms: FrameForms,
    pub(crate) whole: Noise<'a>,
    /// The instrument's own part of it.
    instrument: Noise<'a>,
    /// Of the variance factors of the two parts.
    relative_covariance: Matrix2<f64>,
}

/// The errors of what the results follow from, for one origin of noise.
pub(crate) struct Noise<'a> {
    pub(crate) axes: Vec<AxisNoise<'a>>,
    pub(crate) sources: SourceNoise,
    /// `Σ`.
    pub(crate) shared: DMatrix<f64>,
}

/// A standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Uncertainty {
    /// mm or rad.
    pub(crate) u: f64,
    /// Degrees of freedom.
    pub(crate) dof: f64,
    pub(crate) budget: Budget,
}

impl<'a> Propagation<'a> {
    /// `instrument` is the instrument's own part of the noise of the points.
    pub(crate) fn new(
        context: &Context<'a>,
        data: &'a [AxisData],
        identified: &'a Identified,
        instrument: &'a PointNoise<'a>,
        stations_in_ref: &[Point3<f64>],
    ) -> Self {
        let sources = Sources::new(context, data, identified, stations_in_ref.len());
        let measured = context.measured;
        Self {
            identified,
            forms: FrameForms::new(context, data, identified, &sources, stations_in_ref),
            whole: Noise::new(&measured.noise, data, identified, &sources),
            instrument: Noise::new(instrument, data, identified, &sources),
            sources,
            relative_covariance: measured.relative_covariance,
        }
    }

    /// Of the component errors of axis `k`: for each node δ and ε.
    pub(crate) fn components(&self, k: usize) -> Vec<[Uncertainty; 6]> {
        let sensitivity = &self.identified.sensitivities[k];
        in_order::map_with(sensitivity.node_effects.len(), |errors, node| {
            // Most axes have one run, during which their base stands still.
            let form = || AxisForm::component_errors(sensitivity, node..node + 1);
            let through_base = self.forms.has_moving_base(k).then(form);
            let through_base = through_base.and_then(|form| {
                let rows = self.forms.through_base(k, &form)?;
                Some((form, rows))
            });
            let mut of_node = |noise: &Noise<'_>| {
                let through_base = through_base.as_ref();
                noise.of_node(k, node, &self.sources.axes[k], through_base, errors)
            };
            let (whole, instrument) = (of_node(&self.whole), of_node(&self.instrument));
            std::array::from_fn(|c| self.stated(&whole[c], &instrument[c]))
        })
    }

    /// Of the location errors of axis `k`: shift and tilt.
    pub(crate) fn location(&self, k: usize) -> [Uncertainty; 6] {
        self.of_sources(&self.forms.locations[k])
    }

    /// Of a station: x y z and dead path.
    pub(crate) fn station(&self, j: usize) -> [Uncertainty; 4] {
        self.of_sources(&self.forms.stations[j])
    }

    fn of_sources<const N: usize>(&self, rows: &DMatrix<f64>) -> [Uncertainty; N] {
        let whole = self.whole.of_sources(rows);
        let instrument = self.instrument.of_sources(rows);
        std::array::from_fn(|i| self.stated(&whole[i], &instrument[i]))
    }

    fn stated(&self, whole: &Variance, instrument: &Variance) -> Uncertainty {
        let budget = if whole.is_none() {
            Budget::default()
        } else {
            let all = (whole.own + whole.through).max(0.0);
            Budget::new(
                [instrument.own, whole.own],
                [instrument.own + instrument.through, all],
            )
        };
        Uncertainty {
            u: budget.variance().max(0.0).sqrt(),
            dof: budget.degrees_of_freedom(&self.relative_covariance),
            budget,
        }
    }
}

impl<'a> Noise<'a> {
    fn new(
        noise: &'a PointNoise<'a>,
        data: &'a [AxisData],
        identified: &'a Identified,
        sources: &Sources,
    ) -> Self {
        let shared = noise.shared();
        let axes: Vec<AxisNoise> = data
            .iter()
            .zip(&identified.fits)
            .zip(&identified.sensitivities)
            .map(|((axis, fits), sensitivity)| {
                AxisNoise::new(noise, shared.nrows(), axis, fits, sensitivity)
            })
            .collect();
        Self {
            sources: sources.noise(&axes, shared.nrows()),
            axes,
            shared,
        }
    }

    /// Variances of the component errors of a node of axis `k`, whose sources are `sources`; with
    /// what they (a form of its parameters and mean pose errors) owe to all sources through its
    /// base. `errors` is memory to work in.
    fn of_node(
        &self,
        k: usize,
        node: usize,
        sources: &OwnSources,
        through_base: Option<&(AxisForm, DMatrix<f64>)>,
        errors: &mut GroupNoise,
    ) -> Vec<Variance> {
        let noise = &self.axes[k];
        let ComponentNoise {
            mut own,
            uncancelled,
            shared: mut coefficients,
        } = noise.component_errors(node, errors);
        if let Some((form, rows)) = through_base {
            let of_own_sources = rows.select_columns(&sources.places);
            let cross = noise.own(form, &sources.form) * of_own_sources.transpose();
            own += &cross + cross.transpose() + rows * &self.sources.own * rows.transpose();
            coefficients += rows * &self.sources.shared;
        }
        let mut times_shared = Matrix6xX::zeros(coefficients.ncols());
        add_product(&mut times_shared, &coefficients, &self.shared);
        let variance = |c: usize| Variance {
            own: own[(c, c)],
            through: times_shared.row(c).dot(&coefficients.row(c)),
            uncancelled: uncancelled[c],
        };
        (0..6).map(variance).collect()
    }

    /// Variances of functions of the sources, one for each row.
    fn of_sources(&self, rows: &DMatrix<f64>) -> Vec<Variance> {
        let own = rows * &self.sources.own * rows.transpose();
        let variances = self.sources.own.diagonal();
        let uncancelled: Vec<f64> = rows
            .row_iter()
            .map(|row| row.iter().zip(&variances).map(|(f, v)| f * f * v).sum())
            .collect();
        let coefficients = rows * &self.sources.shared;
        let times_shared = &coefficients * &self.shared;
        let through = |i: usize| times_shared.row(i).dot(&coefficients.row(i));
        uncancelled
            .iter()
            .enumerate()
            .map(|(i, &uncancelled)| Variance {
                own: own[(i, i)],
                through: through(i),
                uncancelled,
            })
            .collect()
    }
}

/// The variance of a linear function of the points' errors.
struct Variance {
    /// With the stations known.
    own: f64,
    /// What comes through the stations.
    through: f64,
    /// Sum of the variances whose combination `own` is.
    uncancelled: f64,
}

/// Variance with the stations known, relative to the variances that cancel in it, below which it is
/// rounding.
const CANCELLED: f64 = 1e-12;

impl Variance {
    /// Whether gauge or frame define the function, so that it does not depend on the points: every
    /// point has noise of its own, so nothing else has no variance with the stations known.
    fn is_none(&self) -> bool {
        self.own < CANCELLED * self.uncancelled
    }
}
