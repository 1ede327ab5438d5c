//! The axes of a campaign, some of which may return to their steps worse than others ([`Axes`]).

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_kinematics::{AxisKind, Ideal};
use trueaxis_multilateration::{Network, Return};
use trueaxis_screening::{Axes, Sweep};

use crate::lengths::circumstances::sweep_of;
use crate::lengths::network::Group;
use crate::settings::Settings;
use crate::words::stop_of;

/// The axes that the runs of the groups of a network move.
pub(crate) fn axes_of<'n>(
    (campaign, lengths): (&Campaign, &Lengths),
    (network, groups): (&'n Network, &[Group]),
    settings: &Settings,
) -> Axes<'n> {
    let machine = &campaign.machine;
    let axis = |group: &Group| {
        let run = campaign.steps[group.step].run?;
        group.moved.then(|| campaign.runs[run].axis)
    };
    let line = |group: &Group| {
        let (step, axis) = (&campaign.steps[group.step], axis(group)?);
        let moving = &machine.axes()[axis];
        if moving.kind() != AxisKind::Rotary {
            return None;
        }
        let before = machine.chain(axis).iter().rev().nth(1).copied();
        let base = machine.motion(&Ideal, before, &step.positions);
        Some(Return {
            variance_ratio: 1.0,
            point_mm: base * moving.point_mm(),
            rad_per_mm: base * moving.direction().into_inner(),
        })
    };
    let (mut sweeps, mut last): (Vec<Sweep>, _) = (Vec::new(), None);
    for (number, visit) in network.visits.iter().enumerate() {
        let Some(axis) = axis(&groups[visit.group]) else {
            continue;
        };
        let own = Some(sweep_of(campaign, stop_of(lengths, visit.readings.start)));
        match sweeps.last_mut().filter(|_| last == own) {
            Some(sweep) => sweep.visits.push(number),
            None => sweeps.push(Sweep {
                axis,
                visits: vec![number],
            }),
        }
        last = own;
    }
    Axes {
        network,
        declared: campaign.instrument.declares_noise(),
        most_removed: settings.most_removed,
        count: machine.axes().len(),
        of_groups: groups.iter().map(axis).collect(),
        lines: groups.iter().map(line).collect(),
        sweeps,
    }
}
