//! Machine and targets as they may be in truth, where the campaign has them otherwise.

use std::collections::BTreeSet;

use nalgebra::Point3;
use trueaxis_campaign::{Campaign, Target};
use trueaxis_kinematics::{AxisKind, Branch, Ideal, Machine};

use crate::elsewhere::elsewhere;

/// Another machine and other targets, and what to correct in the campaign.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Setup {
    pub(crate) machine: Machine,
    pub(crate) targets: Vec<Target>,
    pub(crate) words: String,
    /// Whether several entries of the campaign are wrong at once.
    pub(crate) is_rebuilt: bool,
}

/// Places of targets that differ by less than this are the same, mm.
const SAME_MM: f64 = 1.0;

/// All that would put targets elsewhere than the campaign says: each motion of them once.
pub(crate) fn setups(campaign: &Campaign) -> Vec<Setup> {
    let mut all = vec![changed(campaign, String::new(), |_| {})];
    let mut known = vec![all[0].places_mm(campaign)];
    let others = [in_units(campaign), away(campaign), single(campaign)];
    let rebuilt = [on_other_axes(campaign), branches(campaign)];
    for setup in others.into_iter().chain(rebuilt).flatten() {
        let places = setup.places_mm(campaign);
        let is_same = |other: &Vec<Point3<f64>>| {
            let mut pairs = other.iter().zip(&places);
            pairs.all(|(a, b)| (a - b).norm() < SAME_MM)
        };
        if !known.iter().any(is_same) {
            known.push(places);
            all.push(setup);
        }
    }
    all.split_off(1)
}

impl Setup {
    /// Where all targets are nominally when they are read, mm.
    fn places_mm(&self, campaign: &Campaign) -> Vec<Point3<f64>> {
        let mut places = Vec::new();
        for stop in campaign.stops() {
            let positions = &campaign.steps[stop.step].positions;
            let targets = campaign.sightings(stop);
            let targets = targets.map(|seen| &self.targets[seen.target]);
            let place = |t: &Target| {
                self.machine
                    .position(&Ideal, t.carrier, positions, t.home_mm)
            };
            places.extend(targets.map(place));
        }
        places
    }
}

fn changed(campaign: &Campaign, words: String, change: impl FnOnce(&mut [Target])) -> Setup {
    let mut targets = campaign.targets.clone();
    change(&mut targets);
    Setup {
        machine: campaign.machine.clone(),
        targets,
        words,
        is_rebuilt: false,
    }
}

/// Nominal positions in another unit.
fn in_units(campaign: &Campaign) -> Vec<Setup> {
    let setup = |(unit, factor): (&str, f64)| {
        let words =
            format!("`position_mm` of the targets look like {unit}: multiply them by {factor}");
        let scale = |target: &mut Target| target.home_mm.coords *= factor;
        changed(campaign, words, |targets| {
            targets.iter_mut().for_each(scale);
        })
    };
    [("metres", 1e3), ("inches", 25.4)].map(setup).to_vec()
}

/// Nominal positions where the axes stood at the beginning of runs, not at home.
fn away(campaign: &Campaign) -> Vec<Setup> {
    let mut all = Vec::new();
    for (number, run) in campaign.runs.iter().enumerate() {
        let mut steps = campaign.steps.iter();
        let Some(first) = steps.find(|step| step.run == Some(number)) else {
            continue;
        };
        let mut parked = first.positions.clone();
        parked[run.axis] = 0.0;
        for place in [first.positions.clone(), parked] {
            let axes = campaign.machine.axes().iter().zip(&place);
            let away = axes.filter(|(_, position)| position.abs() > 0.0);
            let stand = away.map(|(axis, &position)| match axis.kind() {
                AxisKind::Linear => format!("{} at {position} mm", axis.name()),
                AxisKind::Rotary => format!("{} at {:.3}°", axis.name(), position.to_degrees()),
            });
            let words = format!(
                "`position_mm` of the targets are where they are with {}, not at home: give their \
                 positions with all axes at 0",
                stand.collect::<Vec<_>>().join(", ")
            );
            let home = |target: &mut Target| {
                let motion = campaign.machine.motion(&Ideal, target.carrier, &place);
                target.home_mm = motion.inverse() * target.home_mm;
            };
            all.push(changed(campaign, words, |t| t.iter_mut().for_each(home)));
        }
    }
    all
}

/// One target elsewhere or on another axis, where its lengths say so.
fn single(campaign: &Campaign) -> Vec<Setup> {
    let mut all = Vec::new();
    for (number, given) in campaign.targets.iter().enumerate() {
        for (carrier, home_mm) in elsewhere(campaign, number) {
            let mut words = format!("target {} is", given.name);
            let mut fields = Vec::new();
            if given.carrier != Some(carrier) {
                words += &format!(" carried by {}", campaign.machine.axes()[carrier].name());
                fields.push("`carried_by`");
            }
            if given.home_mm != home_mm {
                let [x, y, z] = [0, 1, 2].map(|i| home_mm[i].round() + 0.0);
                words += &format!(" at about [{x}, {y}, {z}] mm at home");
                fields.push("`position_mm`");
            }
            words += &format!(": correct its {}", fields.join(" and "));
            all.push(changed(campaign, words, |targets| {
                targets[number].carrier = Some(carrier);
                targets[number].home_mm = home_mm;
            }));
        }
    }
    all
}

/// All targets of an axis on another one.
fn on_other_axes(campaign: &Campaign) -> Vec<Setup> {
    let carriers: BTreeSet<usize> = campaign.targets.iter().filter_map(|t| t.carrier).collect();
    let mut all = Vec::new();
    for &from in &carriers {
        for (to, axis) in campaign.machine.axes().iter().enumerate() {
            let of_axis = |target: &Target| target.carrier == Some(from);
            let targets = campaign.targets.iter().filter(|t| of_axis(t));
            let names: Vec<&str> = targets.map(|t| t.name.as_str()).collect();
            let words = format!(
                "the targets on {} ({}) are carried by {}, or these axes in another order: correct `carried_by`, or `kinematics`",
                campaign.machine.axes()[from].name(),
                names.join(", "),
                axis.name()
            );
            let mut setup = changed(campaign, words, |targets| {
                let moved = targets.iter_mut().filter(|t| of_axis(t));
                moved.for_each(|target| target.carrier = Some(to));
            });
            setup.is_rebuilt = true;
            all.push(setup);
        }
    }
    all
}

/// One axis at another place in its branch or in the other one; targets stay on their axis, or at the end of their branch.
fn branches(campaign: &Campaign) -> Vec<Setup> {
    let given = [Branch::Tool, Branch::Workpiece].map(|b| campaign.machine.branch(b));
    let axes = campaign.machine.axes();
    let mut all = Vec::new();
    for axis in 0..axes.len() {
        let rest = given.map(|b| b.iter().copied().filter(|&a| a != axis).collect::<Vec<_>>());
        for to in 0..2 {
            for place in 0..=rest[to].len() {
                let mut branches = rest.clone();
                branches[to].insert(place, axis);
                let written = branches.each_ref().map(|branch| {
                    let names: Vec<&str> = branch.iter().map(|&a| axes[a].name()).collect();
                    names.join(", ")
                });
                let ends = [0, 1].map(|b| (given[b].last().copied(), branches[b].last().copied()));
                let [tool, workpiece] = branches;
                let Ok(machine) = Machine::new(axes.to_vec(), tool, workpiece) else {
                    continue;
                };
                for (at_end, carried) in
                    [(false, ""), (true, ", all targets at the end of a branch")]
                {
                    let words = format!(
                        "axes carry each other otherwise, as with tool [{}], workpiece [{}]{carried}: correct `kinematics`",
                        written[0], written[1]
                    );
                    let setup = changed(campaign, words, |targets| {
                        for target in targets.iter_mut().filter(|_| at_end) {
                            let mut ends = ends.iter().filter(|end| end.1.is_some());
                            let end = ends
                                .find(|end| target.carrier.is_some() && end.0 == target.carrier);
                            target.carrier = end.map_or(target.carrier, |end| end.1);
                        }
                    });
                    let machine = machine.clone();
                    all.push(Setup {
                        machine,
                        is_rebuilt: true,
                        ..setup
                    });
                }
            }
        }
    }
    all
}
