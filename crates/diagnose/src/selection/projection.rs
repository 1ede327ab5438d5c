//! What is left of observations after the base model has absorbed what it can.
//!
//! `M = I - O Oᵀ [same group] - T Σ Tᵀ`; the parts of an arrowhead system, or, without groups, the
//! orthonormal columns `T` of a small dense one (`Σ = I`).

use trueaxis_multilateration::Whitened;

/// Whitened residuals and the projection that made them.
#[derive(Debug, Clone)]
pub(crate) struct Projection {
    /// `e = M y`.
    pub(crate) residuals: Vec<f64>,
    /// Trace of `M`.
    pub(crate) degrees_of_freedom: f64,
    group_of_row: Vec<usize>,
    groups: usize,
    /// `O`, row after row.
    own: Vec<f64>,
    own_width: usize,
    /// `T`, row after row.
    shared: Vec<f64>,
    shared_width: usize,
    /// `Σ`, row after row.
    sigma: Vec<f64>,
}

/// The parts of a projection whose shared columns are orthonormal, and orthogonal to those of all groups.
pub(crate) struct Arrowhead {
    /// `e = M y`.
    pub(crate) residuals: Vec<f64>,
    /// Trace of `M`.
    pub(crate) degrees_of_freedom: f64,
    pub(crate) group_of_row: Vec<usize>,
    pub(crate) groups: usize,
    /// `O`, row after row.
    pub(crate) own: Vec<f64>,
    pub(crate) own_width: usize,
    /// `T`, row after row.
    pub(crate) shared: Vec<f64>,
    pub(crate) shared_width: usize,
}

/// What must be left of a column, relative to its length, for it to count as something new.
const NEW_TOL: f64 = 1e-6;

impl Projection {
    /// That of an adjusted network.
    pub(crate) fn of_network(whitened: &Whitened) -> Self {
        Self {
            residuals: whitened.residuals.clone(),
            degrees_of_freedom: whitened.degrees_of_freedom as f64,
            group_of_row: whitened.group_of_row.clone(),
            groups: whitened.groups,
            own: whitened.own.clone(),
            own_width: whitened.own_width,
            shared: whitened.shared.clone(),
            shared_width: whitened.shared_width,
            sigma: whitened.reduced_inverse.clone(),
        }
    }

    /// That of whitened observations `y` and the columns of a base model.
    pub(crate) fn dense(observations: Vec<f64>, base: &[Vec<f64>]) -> Self {
        let rows = observations.len();
        let bare = Self {
            degrees_of_freedom: rows as f64,
            residuals: observations,
            group_of_row: vec![0; rows],
            groups: 1,
            own: Vec::new(),
            own_width: 0,
            shared: Vec::new(),
            shared_width: 0,
            sigma: Vec::new(),
        };
        bare.extended(base)
    }

    /// That of an eliminated system: `Σ = I`.
    pub(crate) fn arrowhead(parts: Arrowhead) -> Self {
        let width = parts.shared_width;
        let mut sigma = vec![0.0; width * width];
        (0..width).for_each(|k| sigma[k * width + k] = 1.0);
        Self {
            residuals: parts.residuals,
            degrees_of_freedom: parts.degrees_of_freedom,
            group_of_row: parts.group_of_row,
            groups: parts.groups,
            own: parts.own,
            own_width: parts.own_width,
            shared: parts.shared,
            shared_width: width,
            sigma,
        }
    }

    /// Number of observations.
    pub(crate) fn rows(&self) -> usize {
        self.residuals.len()
    }

    /// `Σ e²`.
    pub(crate) fn squares(&self) -> f64 {
        self.residuals.iter().map(|e| e * e).sum()
    }

    /// `x <- M x`.
    pub(crate) fn project(&self, x: &mut [f64]) {
        let (own_width, width) = (self.own_width, self.shared_width);
        let mut of_groups = vec![0.0; self.groups * own_width];
        let mut t = vec![0.0; width];
        for (i, &value) in x.iter().enumerate() {
            if value == 0.0 {
                continue;
            }
            let group = &mut of_groups[self.group_of_row[i] * own_width..][..own_width];
            add(group, self.own_row(i), value);
            add(&mut t, self.shared_row(i), value);
        }
        let through: Vec<f64> = (0..width)
            .map(|k| dot(&self.sigma[k * width..(k + 1) * width], &t))
            .collect();
        for (i, value) in x.iter_mut().enumerate() {
            let group = &of_groups[self.group_of_row[i] * own_width..][..own_width];
            *value -= dot(self.own_row(i), group) + dot(self.shared_row(i), &through);
        }
    }

    /// The projection after columns have joined the base model.
    pub(crate) fn extended(&self, columns: &[Vec<f64>]) -> Self {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in columns {
            let length = dot(column, column).sqrt();
            let mut left = column.clone();
            // Twice, so that rounding does not stay.
            for _ in 0..2 {
                self.project(&mut left);
                for unit in &basis {
                    let along = dot(unit, &left);
                    add(&mut left, unit, -along);
                }
            }
            let norm = dot(&left, &left).sqrt();
            if norm > NEW_TOL * length {
                left.iter_mut().for_each(|x| *x /= norm);
                basis.push(left);
            }
        }
        let (old, width) = (self.shared_width, self.shared_width + basis.len());
        let mut shared = Vec::with_capacity(self.rows() * width);
        for i in 0..self.rows() {
            shared.extend_from_slice(self.shared_row(i));
            shared.extend(basis.iter().map(|unit| unit[i]));
        }
        let mut sigma = vec![0.0; width * width];
        for k in 0..width {
            if k < old {
                sigma[k * width..k * width + old]
                    .copy_from_slice(&self.sigma[k * old..(k + 1) * old]);
            } else {
                sigma[k * width + k] = 1.0;
            }
        }
        let mut residuals = self.residuals.clone();
        for unit in &basis {
            let along = dot(unit, &residuals);
            add(&mut residuals, unit, -along);
        }
        Self {
            residuals,
            degrees_of_freedom: self.degrees_of_freedom - basis.len() as f64,
            group_of_row: self.group_of_row.clone(),
            groups: self.groups,
            own: self.own.clone(),
            own_width: self.own_width,
            shared,
            shared_width: width,
            sigma,
        }
    }

    pub(crate) fn groups(&self) -> usize {
        self.groups
    }

    pub(crate) fn group_of_row(&self, row: usize) -> usize {
        self.group_of_row[row]
    }

    /// Row of `O`.
    pub(crate) fn own_row(&self, row: usize) -> &[f64] {
        &self.own[row * self.own_width..(row + 1) * self.own_width]
    }

    /// Row of `T`.
    pub(crate) fn shared_row(&self, row: usize) -> &[f64] {
        &self.shared[row * self.shared_width..(row + 1) * self.shared_width]
    }

    /// Row of `Σ`.
    pub(crate) fn sigma_row(&self, row: usize) -> &[f64] {
        &self.sigma[row * self.shared_width..(row + 1) * self.shared_width]
    }

    /// Columns of `O` and `T`.
    pub(crate) fn widths(&self) -> (usize, usize) {
        (self.own_width, self.shared_width)
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `sum += factor · x`.
pub(crate) fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += factor * x;
    }
}
