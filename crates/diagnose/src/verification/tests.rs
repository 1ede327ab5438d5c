//! Readings made by code that shares nothing with the diagnosis but the format: names, silence, pairs.
//!
//! Strengths are given as λ, the length of an effect's trace in standard deviations of an arrival after
//! what the base model absorbs has been taken out.

mod ball_bar;
mod calibrated;
mod clean;
mod feeds;
mod iso_run;
mod lines;
mod unknown;
mod unseen;

use trueaxis_campaign::{Campaign, Instrument, Verification};
use trueaxis_effects::Scene;
use trueaxis_kinematics::{Axis, Machine};

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::Verdict;
use crate::verification::{EntryOutcome, diagnose_verification};

/// X carries Y carries Z.
fn three_axes() -> Machine {
    let axis = |name, direction| Axis::linear(name, direction, [0.0, 400.0]).unwrap();
    let axes = vec![
        axis("X", Vector3::x()),
        axis("Y", Vector3::y()),
        axis("Z", Vector3::z()),
    ];
    Machine::new(axes, vec![0, 1, 2], vec![]).unwrap()
}

/// A campaign of verifications only.
fn campaign(verification: Vec<Verification>) -> Campaign {
    Campaign {
        name: "verification".into(),
        machine_name: "FXYZ".into(),
        machine: three_axes(),
        instrument: Instrument::default(),
        targets: Vec::new(),
        stations: Vec::new(),
        runs: Vec::new(),
        steps: Vec::new(),
        lengths: None,
        points: None,
        verification,
        notices: Vec::new(),
    }
}

fn scene(campaign: &Campaign) -> Scene {
    Scene {
        machine: campaign.machine.clone(),
        stations: Vec::new(),
        targets: Vec::new(),
        moving: Vec::new(),
    }
}

/// What is found in one verification without a calibration.
fn found(verification: Verification) -> EntryOutcome {
    let campaign = campaign(vec![verification]);
    let scene = scene(&campaign);
    let outcome = diagnose_verification(&campaign, None, &scene);
    outcome.entries.into_iter().next().unwrap()
}

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Counts of outcomes against a hidden effect.
#[derive(Debug, Default)]
struct Counts {
    named: usize,
    among: usize,
    wrong: usize,
    unknown: usize,
    missed: usize,
    /// What else was said.
    odd: Vec<String>,
}

impl Counts {
    /// `axis` is that of the hidden effect.
    fn add(&mut self, outcome: &EntryOutcome, effect: &str, axis: Option<usize>) {
        let is_it = |e: &trueaxis_effects::ResolvedEffect| {
            e.effect.id == effect && (e.subject.axis.is_none() || e.subject.axis == axis)
        };
        let first = outcome.causes.iter().find(|c| is_it(&c.effect));
        let rival = outcome
            .causes
            .iter()
            .any(|c| c.rivals.iter().any(|r| is_it(&r.effect)));
        let others = outcome
            .causes
            .iter()
            .any(|c| !is_it(&c.effect) && !c.rivals.iter().any(|r| is_it(&r.effect)));
        let before = self.right();
        match outcome.verdict {
            _ if others => self.wrong += 1,
            Verdict::Clean => self.missed += 1,
            Verdict::Unknown => self.unknown += 1,
            Verdict::Named if first.is_some() => self.named += 1,
            _ if first.is_some() || rival => self.among += 1,
            _ => self.wrong += 1,
        }
        if self.right() == before {
            self.odd.push(summary(outcome));
        }
    }

    fn right(&self) -> usize {
        self.named + self.among
    }
}

/// An outcome in short.
fn summary(outcome: &EntryOutcome) -> String {
    let causes: Vec<String> = outcome
        .causes
        .iter()
        .map(|c| {
            let (id, subject) = (c.effect.effect.id, c.effect.subject);
            format!(
                "{id} {:?} {:?} p {:.1e}",
                subject.axis, subject.component, c.p_value
            )
        })
        .collect();
    let left = outcome.unexplained.as_ref().map(|u| u.varies_with.clone());
    format!("{:?} {causes:?} {left:?}", outcome.verdict)
}

/// Length of a trace.
fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
