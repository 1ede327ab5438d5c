//! A table of equal spacing, and the sum of two.

use std::fmt::Write;

use trueaxis_files::round;

use crate::Error;
use crate::export::line::interpolate;
use crate::export::{Request, check_points};

/// Decimals of mm and degrees.
const DECIMALS: i32 = 7;

/// Decimals of factors: an angle of 1e-11 rad on 1 m is far below a nanometre.
const DECIMALS_OF_FACTORS: i32 = 11;

/// Distances below this are none, mm or degrees.
const NONE: f64 = 1e-6;

/// More points than any control has memory for.
const MOST_POINTS: usize = 5000;

/// What a table is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `$AA_ENC_COMP`: the axis by its own position.
    Encoder,
    /// `$AN_CEC`.
    Sag,
    /// `$AN_CEC` that multiplies another one or is multiplied with it.
    Factor,
}

/// Values by the position of one axis for an axis; mm and degrees.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    pub(crate) kind: Kind,
    pub(crate) input: usize,
    pub(crate) output: usize,
    pub(crate) min: f64,
    pub(crate) step: f64,
    pub(crate) values: Vec<f64>,
}

impl Table {
    /// Whether two are for the same axes.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let of = |table: &Self| (table.kind, table.input, table.output);
        of(self) == of(other)
    }

    pub(crate) fn max(&self) -> f64 {
        self.min + self.step * (self.values.len() - 1) as f64
    }

    /// Linear between the points, the first and the last value beyond them.
    pub(crate) fn at(&self, position: f64) -> f64 {
        let positions = (0..self.values.len()).map(|k| self.min + self.step * k as f64);
        let positions: Vec<f64> = positions.collect();
        interpolate(&positions, |k| self.values[k], position)
    }

    /// The sum, at the widest spacing that has the points of both.
    pub(crate) fn with(&self, other: &Self, request: &Request<'_>) -> Result<Self, Error> {
        let step = common(common(self.step, other.step), (self.min - other.min).abs());
        let min = self.min.min(other.min);
        let intervals = ((self.max().max(other.max()) - min) / step).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole and positive; what is too large is too many points"
        )]
        let points = intervals.min(1e9) as usize + 1;
        let both = || {
            let name = request.name(self.input);
            format!("axis {name}, the old and the new table in one")
        };
        check_points(request, both, points, MOST_POINTS)?;
        let at = |k: usize| {
            let position = min + step * k as f64;
            self.at(position) + other.at(position)
        };
        Ok(Self {
            min,
            step,
            values: (0..points).map(at).collect(),
            ..self.clone()
        })
    }

    /// Whether a control has room for it.
    pub(crate) fn check(&self, request: &Request<'_>) -> Result<(), Error> {
        let what = || format!("axis {}", request.name(self.input));
        check_points(request, what, self.values.len(), MOST_POINTS)
    }

    /// The largest value, either sign.
    pub(crate) fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |most, x| x.abs().max(most))
    }

    /// Its assignments; `number` is that of a `$AN_CEC` table from 0, `multiplied_by` that of the table behind
    /// `$AN_CEC_MULT_BY_TABLE`.
    pub(crate) fn write(&self, text: &mut String, number: usize, multiplied_by: Option<usize>) {
        let is_encoder = self.kind == Kind::Encoder;
        let decimals = match self.kind {
            Kind::Factor => DECIMALS_OF_FACTORS,
            _ => DECIMALS,
        };
        // The control counts from 1 here, and 0 is none.
        let multiply = multiplied_by.map_or(0, |number| number + 1);
        let (input, output) = (self.input + 1, self.output + 1);
        let [min, max, step] = [self.min, self.max(), self.step].map(|x| round(x, 9));
        for (k, value) in self.values.iter().enumerate() {
            let value = round(*value, decimals);
            // Writing to a String cannot fail.
            let _ = match is_encoder {
                true => writeln!(text, "$AA_ENC_COMP[0,{k},AX{input}]={value}"),
                false => writeln!(text, "$AN_CEC[{number},{k}]={value}"),
            };
        }
        let _ = match is_encoder {
            true => write!(
                text,
                "$AA_ENC_COMP_STEP[0,AX{input}]={step}\n$AA_ENC_COMP_MIN[0,AX{input}]={min}\n\
                 $AA_ENC_COMP_MAX[0,AX{input}]={max}\n$AA_ENC_COMP_IS_MODULO[0,AX{input}]=0\n"
            ),
            false => write!(
                text,
                "$AN_CEC_INPUT_AXIS[{number}]=(AX{input})\n$AN_CEC_OUTPUT_AXIS[{number}]=(AX{output})\n\
                 $AN_CEC_STEP[{number}]={step}\n$AN_CEC_MIN[{number}]={min}\n$AN_CEC_MAX[{number}]={max}\n\
                 $AN_CEC_DIRECTION[{number}]=0\n$AN_CEC_MULT_BY_TABLE[{number}]={multiply}\n$AN_CEC_IS_MODULO[{number}]=0\n"
            ),
        };
    }
}

/// The largest distance of which both are multiples.
fn common(a: f64, b: f64) -> f64 {
    let (mut a, mut b) = (a.max(b), a.min(b));
    while b > NONE {
        (a, b) = (b, (a - b * (a / b).round()).abs());
    }
    a
}
