//! The `$AN_CEC` tables of a file with their numbers: sums, and products of two.

use crate::Error;
use crate::export::Request;
use crate::export::sinumerik::table::{Kind, Table};

/// Tables of the control: two for each of at most 31 axes. A 828D has eight.
const MOST_TABLES: usize = 62;

/// Axes of the control, `AX1` and so on.
const MOST_AXES: usize = 31;

/// Values that are the same, mm.
const SAME: f64 = 1e-6;

/// A product that is less along the lines that are measured did nothing there, mm.
const UNSEEN_MM: f64 = 1e-4;

/// Two tables whose values are multiplied: an angle by the position of its axis, and a lever by that of another one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Product {
    /// It names the other one in `$AN_CEC_MULT_BY_TABLE`.
    pub(crate) factor: Table,
    pub(crate) lever: Table,
}

impl Product {
    /// The largest value while one of its axes moves and the other is at home.
    fn along_lines_mm(&self) -> f64 {
        let at_home = |one: &Table, other: &Table| (one.at(0.0) * other.largest()).abs();
        at_home(&self.factor, &self.lever).max(at_home(&self.lever, &self.factor))
    }
}

/// A table of a file, by its place there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed<'a> {
    pub(crate) table: &'a Table,
    /// The place, from 0, of the one that it is multiplied by.
    pub(crate) multiplied_by: Option<usize>,
}

impl<'a> Placed<'a> {
    fn alone(table: &'a Table) -> Self {
        Self {
            table,
            multiplied_by: None,
        }
    }
}

/// All of them, and those of `$AA_ENC_COMP` among the tables.
#[derive(Debug, Default, Clone)]
pub(crate) struct Sag {
    pub(crate) tables: Vec<Table>,
    pub(crate) products: Vec<Product>,
}

impl Sag {
    /// Takes in an old table: added to the one for the same axes, if there is one.
    pub(crate) fn add(&mut self, old: Table, request: &Request<'_>) -> Result<(), Error> {
        match self.tables.iter_mut().find(|new| new.is_like(&old)) {
            Some(new) => *new = new.with(&old, request)?,
            None => self.tables.push(old),
        }
        Ok(())
    }

    /// Whether one of these new tables takes away all that an old one does, of which no target saw anything.
    pub(crate) fn replaces(&self, old: &Table, request: &Request<'_>) -> bool {
        !request.is_seen(old.input, old.output) && self.tables.iter().any(|new| new.is_like(old))
    }

    /// The same of an old product: along the line of each axis the angle or the lever is zero.
    ///
    /// # Errors
    /// Where it is not zero there.
    pub(crate) fn replaces_product(
        &self,
        old: &Product,
        request: &Request<'_>,
    ) -> Result<bool, Error> {
        let is_like =
            |new: &Product| new.factor.is_like(&old.factor) && new.lever.is_like(&old.lever);
        if !self.products.iter().any(is_like) {
            return Ok(false);
        }
        let seen_mm = old.along_lines_mm();
        match seen_mm < UNSEEN_MM {
            true => Ok(true),
            false => Err(request.unsuitable(
                "old products that are zero while one axis moves alone",
                format!("one reaches {seen_mm:.4} mm: measure the machine with it off"),
            )),
        }
    }

    /// `$AA_ENC_COMP`, and `$AN_CEC` in the order of their numbers: sums, factors, levers, of which several factors may have
    /// one.
    ///
    /// # Errors
    /// More tables, points or axes than a control has.
    pub(crate) fn numbered(&self, request: &Request<'_>) -> Result<[Vec<Placed<'_>>; 2], Error> {
        let mut levers: Vec<&Table> = Vec::new();
        let mut multiplied_by = Vec::new();
        for Product { lever, .. } in &self.products {
            let place = levers.iter().position(|other| is_same(other, lever));
            multiplied_by.push(place.unwrap_or(levers.len()));
            if place.is_none() {
                levers.push(lever);
            }
        }
        let is_encoder = |table: &&Table| table.kind == Kind::Encoder;
        let encoders = self.tables.iter().filter(is_encoder);
        let encoders: Vec<_> = encoders.map(Placed::alone).collect();
        let first_lever = self.tables.len() - encoders.len() + self.products.len();
        let sums = self.tables.iter().filter(|table| !is_encoder(table));
        let sums = sums.map(Placed::alone);
        let factors = self.products.iter().zip(multiplied_by);
        let factors = factors.map(|(product, place)| Placed {
            table: &product.factor,
            multiplied_by: Some(first_lever + place),
        });
        let levers = levers.into_iter().map(Placed::alone);
        let cross: Vec<_> = sums.chain(factors).chain(levers).collect();

        let count = cross.len();
        let axes = request.machine.machine().axes().len();
        if count > MOST_TABLES {
            let takes = "at most 62 sag compensation tables";
            return Err(request.unsuitable(takes, format!("these are {count}")));
        }
        if axes > MOST_AXES {
            let lacks = format!("the machine has {axes}");
            return Err(request.unsuitable("at most 31 axes", lacks));
        }
        for Placed { table, .. } in encoders.iter().chain(&cross) {
            table.check(request)?;
        }
        Ok([encoders, cross])
    }
}

fn is_same(one: &Table, other: &Table) -> bool {
    let mut pairs = one.values.iter().zip(&other.values);
    one.is_like(other)
        && one.values.len() == other.values.len()
        && (one.min - other.min).abs() < SAME
        && (one.step - other.step).abs() < SAME
        && pairs.all(|(a, b)| (a - b).abs() < SAME)
}
