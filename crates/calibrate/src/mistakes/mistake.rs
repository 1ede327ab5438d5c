//! Mistakes, how they are undone, and their words.

use nalgebra::Isometry3;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{AxisKind, Ideal};

use crate::mistakes::scope::Scope;

/// Something that people do wrong.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Mistake {
    /// The names of two targets were exchanged.
    TargetsExchanged { targets: [usize; 2], scope: Scope },
    /// The names of two stations were exchanged.
    StationsExchanged { stations: [usize; 2], scope: Scope },
    /// The lengths have the other sign.
    LengthsReversed { scope: Scope },
    /// An axis moves against its direction.
    AxisReversed { axis: usize, run: Option<usize> },
    /// Nominal positions of the targets are not those at home, but where the axes stood in a run.
    NominalsAway { positions: Vec<f64> },
    /// The lengths to a target are too long by the same amount.
    Offset {
        target: usize,
        scope: Scope,
        offset_mm: f64,
        u_mm: f64,
    },
}

impl Mistake {
    /// Into how many kinds of parts the place is divided where it was made; 0 is everywhere.
    pub(crate) fn parts(&self) -> usize {
        match self {
            Self::TargetsExchanged { scope, .. }
            | Self::StationsExchanged { scope, .. }
            | Self::LengthsReversed { scope }
            | Self::Offset { scope, .. } => scope.parts(),
            Self::AxisReversed { run, .. } => usize::from(run.is_some()),
            Self::NominalsAway { .. } => 0,
        }
    }

    /// The campaign as it would be without it.
    pub(crate) fn undone(&self, campaign: &Campaign) -> Campaign {
        match self {
            Self::TargetsExchanged { targets, scope } => scope.changed(campaign, |_, readings| {
                readings
                    .iter_mut()
                    .for_each(|reading| exchange(&mut reading.target, targets));
            }),
            Self::StationsExchanged { stations, scope } => {
                scope.changed(campaign, |stop, _| exchange(&mut stop.station, stations))
            }
            Self::LengthsReversed { scope } => scope.changed(campaign, |_, readings| {
                let lengths = readings.iter_mut().map(|reading| &mut reading.length_mm);
                lengths.for_each(|length_mm| *length_mm = -*length_mm);
            }),
            Self::AxisReversed { axis, run } => {
                let mut changed = campaign.clone();
                let steps = changed.steps.iter_mut();
                for step in steps.filter(|step| run.is_none() || *run == step.run) {
                    step.positions[*axis] *= -1.0;
                }
                changed
            }
            Self::NominalsAway { positions } => {
                let mut changed = campaign.clone();
                for target in &mut changed.targets {
                    let chain = campaign.machine.chain(target.carrier);
                    let motion: Isometry3<f64> =
                        campaign.machine.chain_motion(&Ideal, chain, positions);
                    target.home_mm = motion.inverse() * target.home_mm;
                }
                changed
            }
            Self::Offset {
                target,
                scope,
                offset_mm,
                ..
            } => scope.changed(campaign, |_, readings| {
                let of_target = readings.iter_mut().filter(|r| r.target == *target);
                of_target.for_each(|reading| reading.length_mm -= offset_mm);
            }),
        }
    }

    /// What was done wrong, where, and what to change.
    pub(crate) fn in_words(&self, campaign: &Campaign) -> String {
        let target = |&t: &usize| campaign.targets[t].name.clone();
        match self {
            Self::TargetsExchanged { targets, scope } => {
                let [a, b] = targets.each_ref().map(target);
                format!(
                    "targets {a} and {b} are exchanged {}: exchange their names there",
                    scope.in_words(campaign)
                )
            }
            Self::StationsExchanged { stations, scope } => {
                let [a, b] = stations.map(|j| campaign.stations[j].name.clone());
                format!(
                    "stations {a} and {b} are exchanged {}: exchange their names there",
                    scope.in_words(campaign)
                )
            }
            Self::LengthsReversed { scope } => format!(
                "the lengths have the other sign {}: a length grows when the target moves away",
                scope.in_words(campaign)
            ),
            Self::AxisReversed { axis, run } => {
                let name = campaign.machine.axes()[*axis].name();
                match run {
                    None => format!(
                        "axis {name} moves in the other direction: reverse its `direction` in the campaign, or \
                         the sign of its column"
                    ),
                    Some(run) => format!(
                        "axis {name} moves in the other direction in run {}: reverse the sign of its column there",
                        campaign.runs[*run].name
                    ),
                }
            }
            Self::NominalsAway { positions } => {
                let axes = campaign.machine.axes().iter().zip(positions);
                let away = axes.filter(|(_, position)| position.abs() > 0.0);
                let stand = away.map(|(axis, &position)| match axis.kind() {
                    AxisKind::Linear => format!("{} at {position} mm", axis.name()),
                    AxisKind::Rotary => format!("{} at {:.3}°", axis.name(), position.to_degrees()),
                });
                format!(
                    "`position_mm` of the targets are where they are with {}, not at home: give their \
                     positions with all axes at 0",
                    stand.collect::<Vec<_>>().join(", ")
                )
            }
            Self::Offset {
                target: t,
                scope,
                offset_mm,
                u_mm,
            } => format!(
                "the lengths to target {} are all {:.3} ± {:.3} mm too {} {}: a wrong prism constant, or another \
                 reflector; take it off there",
                target(t),
                offset_mm.abs(),
                2.0 * u_mm,
                if *offset_mm > 0.0 { "long" } else { "short" },
                scope.in_words(campaign)
            ),
        }
    }
}

fn exchange(name: &mut usize, [a, b]: &[usize; 2]) {
    if *name == *a {
        *name = *b;
    } else if *name == *b {
        *name = *a;
    }
}
