//! Mistakes, how they are undone, and their words.

use trueaxis_campaign::Campaign;

use crate::scope::Scope;
use crate::setups::Setup;

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
    /// An axis moves this many times as far as commanded; -1: against its direction.
    AxisScaled(usize, f64),
    /// Machine or targets are not as the campaign has them.
    Setup(Box<Setup>),
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
            What::AxisScaled(axis, factor) => {
                for step in &mut changed.steps {
                    if self.scope.run.is_none() || self.scope.run == step.run {
                        step.positions[*axis] *= factor;
                    }
                }
            }
            What::Setup(setup) => {
                changed.machine = setup.machine.clone();
                changed.targets.clone_from(&setup.targets);
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
            What::AxisScaled(axis, factor) => {
                let name = campaign.machine.axes()[*axis].name();
                match self.scope.run {
                    Some(run) => format!(
                        "axis {name} moves in the other direction in run {}: reverse the sign of its column there",
                        campaign.runs[run].name
                    ),
                    None if *factor < 0.0 => format!(
                        "axis {name} moves in the other direction: reverse its `direction` in the campaign, or \
                         the sign of its column"
                    ),
                    None => format!(
                        "axis {name} moves {factor:.4} times as far as its column says (diameters, inches, radians?): multiply the column by {factor}"
                    ),
                }
            }
            What::Setup(setup) => setup.words.clone(),
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
