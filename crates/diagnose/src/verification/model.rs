//! A model of readings: causes, and disturbances beside them.

use trueaxis_effects::CROSS_COUPLING;

use crate::engine::linear::Chosen;
use crate::engine::{JudgedDisturbance, beside_all, price, together, without};
use crate::verification::omnibus::omnibus;
use crate::verification::problem::Problem;

/// Causes, and disturbances beside them.
pub(crate) struct Model<'a> {
    /// The readings, with the disturbances in their covariance.
    pub(crate) problem: Problem<'a>,
    pub(crate) wandering: Vec<JudgedDisturbance>,
    pub(crate) causes: Vec<Chosen>,
    /// Other causes that explain everything with nearly as large a 2 ln B.
    pub(crate) as_good: Vec<Vec<Chosen>>,
}

pub(crate) fn only<'a>(plain: &Problem<'a>, wandering: Vec<JudgedDisturbance>) -> Model<'a> {
    Model {
        problem: plain.beside(&wandering),
        wandering,
        causes: Vec::new(),
        as_good: Vec::new(),
    }
}

/// Only causes.
pub(crate) fn of_causes<'a>(plain: &Problem<'a>, causes: Vec<Chosen>) -> Model<'a> {
    Model {
        causes,
        ..only(plain, Vec::new())
    }
}

/// Whether a cause is among some, whatever its shape.
pub(crate) fn has(causes: &[Chosen], own: &Chosen) -> bool {
    causes.iter().any(|cause| cause.candidate == own.candidate)
}

/// Whether two models have the same causes.
pub(crate) fn have_same(first: &[Chosen], second: &[Chosen]) -> bool {
    first.len() == second.len() && first.iter().all(|own| has(second, own))
}

/// Whether a test finds anything that the model leaves.
pub(crate) fn is_left(model: &Model<'_>) -> bool {
    let projection = model.problem.listed.with(&model.causes);
    let tests = omnibus(&model.problem, &projection);
    tests.iter().any(|t| t.test.p_value < model.problem.level)
}

/// 2 ln B against the model without anything, less the price of names.
pub(crate) fn two_ln_b(plain: &Problem<'_>, model: &Model<'_>) -> f64 {
    let processes = model.wandering.iter();
    let processes = processes.map(|own| (own.columns(plain), own.tried(plain)));
    let (of_wandering, base) = beside_all(&plain.listed.base, processes);
    let listed = match model.wandering.is_empty() {
        // With the comparisons that were made.
        true => plain.listed.clone(),
        false => plain.listed.on(base),
    };
    let causes = &model.causes;
    let scores = (0..causes.len()).map(|k| {
        let beside = listed.beside(&without(causes, k));
        let score = beside.score_of(&causes[k])?;
        Some((score.rank, score.price(&beside.model)))
    });
    let scores: Vec<Option<(usize, f64)>> = scores.collect();
    let names = causes
        .iter()
        .zip(&scores)
        .map(|(cause, score)| match score {
            // Each direction is an error of its own.
            Some((rank, _)) if is_coupling(plain, cause.candidate) => *rank,
            _ => 1,
        });
    let prices = scores.iter().flatten().map(|(_, price)| *price);
    of_wandering + together([&listed.base, &listed.with(causes)], prices)
        - price(names.sum(), &model.wandering)
}

pub(crate) fn is_coupling(plain: &Problem<'_>, candidate: usize) -> bool {
    plain.listed.candidates[candidate].hypothesis.effect == CROSS_COUPLING
}
