//! Mistakes, how they are undone, and their words.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{AxisKind, Ideal};

use crate::scope::Scope;

/// Something that people do wrong, and in which part of the measurement.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mistake {
    pub(crate) what: What,
    pub(crate) scope: Scope,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum What {
    /// The names of two targets were exchanged.
    TargetsExchanged([usize; 2]),
    /// The names of two stations were exchanged.
    StationsExchanged([usize; 2]),
    /// The lengths have the other sign.
    LengthsReversed,
    /// An axis moves against its direction.
    AxisReversed(usize),
    /// Nominal positions of the targets are not those at home, but where the axes stood in a run.
    NominalsAway(Vec<f64>),
    /// The lengths to a target are too long by the same amount; zero while that is not known.
    Offset {
        target: usize,
        offset_mm: f64,
        u_mm: f64,
    },
}

impl Mistake {
    /// The campaign as it would be without it.
    pub(crate) fn undone(&self, campaign: &Campaign) -> Campaign {
        let mut changed = campaign.clone();
        match &self.what {
            What::AxisReversed(axis) => {
                for step in &mut changed.steps {
                    if self.scope.run.is_none() || self.scope.run == step.run {
                        step.positions[*axis] *= -1.0;
                    }
                }
            }
            What::NominalsAway(positions) => {
                for target in &mut changed.targets {
                    let chain = campaign.machine.chain(target.carrier);
                    let motion = campaign.machine.chain_motion(&Ideal, chain, positions);
                    target.home_mm = motion.inverse() * target.home_mm;
                }
            }
            of_lengths => {
                if let (Some(points), What::TargetsExchanged(targets)) =
                    (&mut changed.points, of_lengths)
                {
                    for stop in self.scope.stops(campaign) {
                        let readings = &mut points.readings[stop.readings.clone()];
                        readings
                            .iter_mut()
                            .for_each(|reading| exchange(&mut reading.target, targets));
                    }
                }
                let Some(lengths) = &mut changed.lengths else {
                    return changed;
                };
                let stops = lengths.stops.iter_mut();
                for stop in stops.filter(|stop| self.scope.holds(campaign, stop)) {
                    if let What::StationsExchanged(stations) = of_lengths {
                        exchange(&mut stop.station, stations);
                    }
                    for reading in &mut lengths.readings[stop.readings.clone()] {
                        match of_lengths {
                            What::TargetsExchanged(targets) => {
                                exchange(&mut reading.target, targets);
                            }
                            What::LengthsReversed => reading.length_mm = -reading.length_mm,
                            What::Offset {
                                target, offset_mm, ..
                            } if reading.target == *target => reading.length_mm -= offset_mm,
                            _ => {}
                        }
                    }
                }
            }
        }
        changed
    }

    /// What was done wrong, where, and what to change.
    pub(crate) fn in_words(&self, campaign: &Campaign) -> String {
        let place = self.scope.in_words(campaign);
        let target = |t: usize| &campaign.targets[t].name;
        let exchanged = |what: &str, [a, b]: [&String; 2]| {
            format!("{what} {a} and {b} are exchanged {place}: exchange their names there")
        };
        match &self.what {
            What::TargetsExchanged(targets) => exchanged("targets", targets.map(target)),
            What::StationsExchanged(stations) => {
                exchanged("stations", stations.map(|j| &campaign.stations[j].name))
            }
            What::LengthsReversed => format!(
                "the lengths have the other sign {place}: a length grows when the target moves away"
            ),
            What::AxisReversed(axis) => {
                let name = campaign.machine.axes()[*axis].name();
                match self.scope.run {
                    None => format!(
                        "axis {name} moves in the other direction: reverse its `direction` in the campaign, or \
                         the sign of its column"
                    ),
                    Some(run) => format!(
                        "axis {name} moves in the other direction in run {}: reverse the sign of its column there",
                        campaign.runs[run].name
                    ),
                }
            }
            What::NominalsAway(positions) => {
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
            What::Offset {
                target: t,
                offset_mm,
                u_mm,
            } => format!(
                "the lengths to target {} are all {:.3} ± {:.3} mm too {} {place}: a wrong prism constant, or another \
                 reflector; take it off there",
                target(*t),
                offset_mm.abs(),
                2.0 * u_mm,
                if *offset_mm > 0.0 { "long" } else { "short" },
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
