//! Standard uncertainties of all results, with their budget and degrees of freedom.
//!
//! Every result is a linear function of the poses' errors, propagated twice: for the whole noise and for the
//! instrument's own part of it. Each variance has a part with the stations known and a part that comes through them.
//!
//! Component errors do not depend on the reference frame, because the gauge removes a rigid motion of the whole.
//! Location errors and stations do ([`crate::propagate::dependence`]).

use nalgebra::{DMatrix, DVector, Matrix2, Matrix6};
use trueaxis_kinematics::LocationComponent;
use trueaxis_poses::{PoseNoise, Poses, ThroughSources};

use crate::in_order;
use crate::propagate::axis_noise::AxisNoise;
use crate::propagate::dependence::Dependence;
use crate::propagate::sources::SourceNoise;
use crate::propagate::variance::Variance;
use crate::result::budget::Budget;

/// How the results depend on the poses, and the poses' errors.
pub(crate) struct Propagation<'a, 'i> {
    pub(crate) dependence: &'a Dependence<'a>,
    pub(crate) whole: Noise<'a>,
    /// The instrument's own part of the noise.
    instrument: Noise<'i>,
    /// Relative covariance of the variance factors of the two parts.
    relative_covariance: Matrix2<f64>,
}

/// The errors of the quantities from which the results follow, for one source of noise.
pub(crate) struct Noise<'a> {
    pub(crate) dependence: &'a Dependence<'a>,
    pub(crate) axes: Vec<AxisNoise<'a>>,
    pub(crate) sources: SourceNoise,
    pub(crate) poses: &'a PoseNoise,
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

/// Index of a location error among shift and tilt.
pub(crate) fn place_of(component: LocationComponent) -> usize {
    match component {
        LocationComponent::Offset(i) => i,
        LocationComponent::Tilt(i) => 3 + i,
    }
}

impl<'a: 'i, 'i> Propagation<'a, 'i> {
    pub(crate) fn new(
        dependence: &'a Dependence<'a>,
        poses: &'a Poses,
        instrument: &'i PoseNoise,
    ) -> Self {
        Self {
            dependence,
            whole: Noise::new(dependence, &poses.noise),
            instrument: Noise::new(dependence, instrument),
            relative_covariance: poses.relative_covariance,
        }
    }

    /// Gives the location parameters of axis `k` independent errors beside the noise, with these standard deviations,
    /// mm and rad.
    pub(crate) fn add_to_location(&mut self, k: usize, errors: &[DVector<f64>]) {
        let sources = &self.dependence.sources;
        let of_sources = errors.iter().map(|error| {
            let mut all = DVector::zeros(sources.count);
            let mut own = all.rows_mut(sources.location[k], error.len());
            own.copy_from(error);
            all
        });
        self.whole.sources.scatter.extend(of_sources);
    }

    /// Multiplies the joint covariance of the location parameters of all axes by `ratio`.
    pub(crate) fn widen_locations(&mut self, ratio: f64) {
        let (sources, noise) = (&self.dependence.sources, &self.whole.sources);
        let all = &noise.own + &noise.shared * &self.whole.poses.shared * noise.shared.transpose();
        let mut own = DVector::zeros(sources.count);
        let gauges = &self.dependence.parts().1.gauges;
        for (first, gauge) in sources.location.iter().zip(gauges) {
            own.rows_mut(*first, gauge.location_parameters).fill(1.0);
        }
        let parts = all
            .component_mul(&(&own * own.transpose()))
            .symmetric_eigen();
        let parts = parts
            .eigenvalues
            .iter()
            .zip(parts.eigenvectors.column_iter());
        let parts = parts.filter(|(value, _)| **value > 0.0);
        let errors = parts.map(|(value, part)| part * ((ratio - 1.0) * value).sqrt());
        self.whole.sources.scatter.extend(errors);
    }

    /// Uncertainties of the component errors of axis `k`: δ and ε for each node.
    pub(crate) fn components(&self, k: usize) -> Vec<[Uncertainty; 6]> {
        let [whole, instrument] = [&self.whole, &self.instrument].map(|noise| noise.components(k));
        in_order::map(whole.len(), |node| {
            let (whole, instrument) = (&whole[node], &instrument[node]);
            std::array::from_fn(|c| self.stated(&whole[c], &instrument[c], 0.0))
        })
    }

    /// Uncertainties of the location errors of axis `k`: shift and tilt.
    pub(crate) fn location(&self, k: usize) -> [Uncertainty; 6] {
        self.of_sources(&self.dependence.locations[k])
    }

    /// Uncertainties of a station: x y z and dead path.
    pub(crate) fn station(&self, j: usize) -> [Uncertainty; 4] {
        self.of_sources(&self.dependence.stations[j])
    }

    /// Uncertainties of functions of the sources, one for each row.
    pub(crate) fn of_sources<const N: usize>(&self, rows: &DMatrix<f64>) -> [Uncertainty; N] {
        let whole = self.whole.of_sources(rows);
        let instrument = self.instrument.of_sources(rows);
        std::array::from_fn(|i| {
            let of_nests = self.dependence.variance_of_nests(&rows.row(i).into_owned());
            let [whole, instrument] = [&whole[i], &instrument[i]].map(|all| Variance {
                own: all.own - of_nests,
                uncancelled: all.uncancelled - of_nests,
                ..*all
            });
            self.stated(&whole, &instrument, of_nests)
        })
    }

    /// An uncertainty from these variances, to which `known` adds that of the nests.
    fn stated(&self, whole: &Variance, instrument: &Variance, known: f64) -> Uncertainty {
        let mut budget = if whole.is_defined_away() {
            Budget::default()
        } else {
            let all = (whole.own + whole.through).max(0.0);
            Budget::new(
                [instrument.own, whole.own],
                [instrument.own + instrument.through, all],
                whole.declared,
            )
        };
        budget.systematic += known;
        Uncertainty {
            u: budget.variance().max(0.0).sqrt(),
            dof: budget.degrees_of_freedom(&self.relative_covariance),
            budget,
        }
    }
}

impl<'a> Noise<'a> {
    pub(crate) fn new(dependence: &'a Dependence<'a>, noise: &'a PoseNoise) -> Self {
        let (context, identified) = dependence.parts();
        let axes = 0..context.data.len();
        let axes = axes.map(|k| AxisNoise::new(noise, context, identified, k));
        let axes: Vec<AxisNoise<'_>> = axes.collect();
        Self {
            dependence,
            sources: dependence.sources.noise(&axes, noise),
            axes,
            poses: noise,
        }
    }

    /// `A D Aᵀ`: covariance of the pose error of axis `k` with all sources known.
    pub(crate) fn own_of_pose(&self, k: usize, i: usize) -> Matrix6<f64> {
        let (context, identified) = self.dependence.parts();
        let map = identified.sensitivities[k].poses[i];
        let pose = context.data[k].poses[i].index;
        map * self.poses.own[pose] * map.transpose()
    }

    /// `C`: coefficients of the same pose error for the sources of the bases, and for those that all poses share.
    pub(crate) fn sources_of_pose(&self, k: usize, i: usize) -> [DMatrix<f64>; 2] {
        let (context, identified) = self.dependence.parts();
        let pose = context.data[k].poses[i].index;
        let coupling = identified.sensitivities[k].poses[i] * self.poses.coupling(pose);
        let coupling = DMatrix::from_column_slice(6, coupling.ncols(), coupling.as_slice());
        let response = self.dependence.response_to_base(k, i);
        let through = -(coupling + &response * &self.sources.shared);
        [-response, through]
    }

    /// Variances of functions of the sources, one for each row.
    fn of_sources(&self, rows: &DMatrix<f64>) -> Vec<Variance> {
        let own = rows * &self.sources.own * rows.transpose();
        let scatter = self.sources.scatter_of(rows);
        let uncancelled = rows.component_mul(rows) * self.sources.own.diagonal() + &scatter;
        let through = self.poses.through_sources(&(rows * &self.sources.shared));
        let variance = |(i, through): (usize, &ThroughSources)| {
            Variance::new(own[(i, i)] + scatter[i], uncancelled[i], through)
        };
        through.iter().enumerate().map(variance).collect()
    }
}
