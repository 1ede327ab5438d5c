//! The network of a measuring campaign.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use trueaxis_campaign::{Campaign, Direction, Lengths, Step, Target};
use trueaxis_kinematics::{Ideal, MICROMETRE};
use trueaxis_multilateration::{
    Bodies, Body, Network, Noise, Placed, Reading, Reflectors, Visit, are_in_line,
};

/// A campaign's network and what its groups are.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignNetwork {
    /// The network; its readings are the campaign's, in the same order.
    pub network: Network,
    /// What each group of the network stands for.
    pub groups: Vec<Group>,
    /// The number in the campaign ([`Campaign::reflectors`]) of each reflector of the network: those that were
    /// measured.
    pub reflectors: Vec<usize>,
}

/// Targets that move together, at one step; or those on the bed, whenever they were read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The campaign's step; of targets on the bed the first at which they were read.
    pub step: usize,
    /// Side of approach, where directions are kept apart.
    pub direction: Option<Direction>,
    /// The targets that its points are, in the order of the campaign.
    pub targets: Vec<usize>,
    /// Whether the axis of the run moves them.
    pub moved: bool,
    /// The body of the network that they are tied to; none if the step saw too few of them: they are free.
    pub body: Option<usize>,
}

/// The campaign's target at a place of a body of a network made of the campaign.
pub(crate) fn target_at(
    network: &Network,
    groups: &[Group],
    (body, place): (usize, usize),
) -> Option<usize> {
    let bodies = network.bodies.as_deref()?;
    let mut placed = bodies.of_groups.iter().zip(groups);
    placed.find_map(|(placed, group)| {
        let point = placed.places.iter().position(|own| *own == place);
        let point = point.filter(|_| placed.body == Some(body))?;
        group.targets.get(point).copied()
    })
}

/// Which targets of a step move together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Together {
    /// Those that stand on one stage, whichever axis moves it: their distances never change.
    OnCarrier(usize),
    /// Those on the bed, which stand still.
    OnBed,
    /// Those that the axis of a run moves, on several stages: these stand still against each other only
    /// during the run.
    InRun(usize),
}

/// Noise where none is declared: the weights then say that all lengths are equally good.
const UNDECLARED_LENGTH_SIGMA_UM: f64 = 1.0;

/// Makes the network of a campaign's lengths, with bodies: one group for each step (with `by_direction` each
/// step and side of approach) and for the targets that move together in its run, and one of free points for the
/// targets on the bed. The noise is the declared
/// one; 1 µm for each length where none is declared.
///
/// A stop that sees two groups becomes a visit of each; what the machine's repeatability has in common for them is
/// not kept.
pub fn network_from_campaign(
    campaign: &Campaign,
    lengths: &Lengths,
    by_direction: bool,
) -> CampaignNetwork {
    let together = together(campaign, &moved_in_runs(campaign, lengths));
    let mut groups: Vec<Group> = Vec::new();
    let mut kinds: Vec<Together> = Vec::new();
    // The groups of each step, or of each side of approach to it.
    let mut of_step = vec![[Vec::new(), Vec::new()]; campaign.steps.len()];
    let mut of_bed = Vec::new();
    let mut group_of_reading = Vec::with_capacity(lengths.readings.len());
    for stop in &lengths.stops {
        let run = campaign.steps[stop.step].run;
        let side = usize::from(by_direction && stop.direction == Direction::Backward);
        for reading in &lengths.readings[stop.readings.clone()] {
            let (moved, kind) = run.map_or((false, Together::OnBed), |run| {
                together[run][reading.target]
            });
            let known: &mut Vec<usize> = match run {
                None => &mut of_bed,
                Some(_) => &mut of_step[stop.step][side],
            };
            let number = known.iter().copied().find(|&g| kinds[g] == kind);
            let number = number.unwrap_or_else(|| {
                known.push(groups.len());
                kinds.push(kind);
                groups.push(Group {
                    step: stop.step,
                    direction: (by_direction && run.is_some()).then_some(stop.direction),
                    targets: Vec::new(),
                    moved,
                    body: None,
                });
                groups.len() - 1
            });
            let targets = &mut groups[number].targets;
            if let Err(place) = targets.binary_search(&reading.target) {
                targets.insert(place, reading.target);
            }
            group_of_reading.push(number);
        }
    }
    let (targets_of_bodies, of_groups) = shapes(campaign, &groups, &kinds);
    for (group, body) in groups.iter_mut().zip(of_groups) {
        group.body = body;
    }
    // Groups of a body follow each other: they are worked on side by side.
    let mut order: Vec<(usize, Group)> = groups.into_iter().enumerate().collect();
    order.sort_by_key(|(_, group)| group.body.unwrap_or(usize::MAX));
    let mut place_of = vec![0; order.len()];
    for (place, (g, _)) in order.iter().enumerate() {
        place_of[*g] = place;
    }
    let groups: Vec<Group> = order.into_iter().map(|(_, group)| group).collect();
    for number in &mut group_of_reading {
        *number = place_of[*number];
    }
    let bodies = bodies(campaign, &groups, targets_of_bodies);
    let mut network = network(campaign, lengths, &groups, &group_of_reading, bodies);
    let is_bed = |group: &Group| campaign.steps[group.step].run.is_none();
    network.bed = groups.iter().position(is_bed);
    let (_, of_targets) = campaign.reflectors();
    let of_points: Vec<usize> = groups
        .iter()
        .flat_map(|group| group.targets.iter().map(|&target| of_targets[target]))
        .collect();
    let mut reflectors = of_points.clone();
    reflectors.sort_unstable();
    reflectors.dedup();
    // The constant of a single reflector is dead path.
    network.reflectors = (reflectors.len() > 1).then(|| {
        Arc::new(Reflectors {
            count: reflectors.len(),
            sigma_mm: campaign
                .instrument
                .reflector_sigma_um
                .map(|sigma_um| sigma_um * MICROMETRE),
            of_points: of_points
                .iter()
                .map(|r| reflectors.partition_point(|known| known < r))
                .collect(),
        })
    });
    CampaignNetwork {
        network,
        groups,
        reflectors,
    }
}

fn network(
    campaign: &Campaign,
    lengths: &Lengths,
    groups: &[Group],
    group_of_reading: &[usize],
    bodies: Bodies,
) -> Network {
    let mut network = Network {
        stations: campaign.stations.iter().map(|s| s.approx_mm).collect(),
        noise: declared_noise(campaign),
        readings: Vec::with_capacity(lengths.readings.len()),
        visits: Vec::with_capacity(lengths.stops.len()),
        bodies: Some(Arc::new(bodies)),
        ..Network::default()
    };
    for group in groups {
        let first = network.nominal_mm.len();
        network.nominal_mm.extend(nominal(campaign, group));
        network.groups.push(first..network.nominal_mm.len());
    }
    for stop in &lengths.stops {
        let mut last = None;
        for i in stop.readings.clone() {
            let (reading, group) = (&lengths.readings[i], group_of_reading[i]);
            let targets = &groups[group].targets;
            network.readings.push(Reading {
                point: targets.partition_point(|&t| t < reading.target),
                length_mm: reading.length_mm,
            });
            match network.visits.last_mut() {
                Some(visit) if last == Some(group) => visit.readings.end = i + 1,
                _ => network.visits.push(Visit {
                    station: stop.station,
                    group,
                    readings: i..i + 1,
                }),
            }
            last = Some(group);
        }
    }
    network
}

/// For each run the stages whose targets its axis moves, of those that were measured in it.
fn moved_in_runs(campaign: &Campaign, lengths: &Lengths) -> Vec<Vec<usize>> {
    let mut carriers = vec![Vec::new(); campaign.runs.len()];
    for stop in &lengths.stops {
        let Some(run) = campaign.steps[stop.step].run else {
            continue;
        };
        for reading in &lengths.readings[stop.readings.clone()] {
            let Some(carrier) = campaign.targets[reading.target].carrier else {
                continue;
            };
            if !carriers[run].contains(&carrier) && is_moved(campaign, run, carrier) {
                carriers[run].push(carrier);
            }
        }
    }
    carriers
}

fn is_moved(campaign: &Campaign, run: usize, carrier: usize) -> bool {
    let axis = campaign.runs[run].axis;
    campaign.machine.chain(carrier).contains(&axis)
}

/// Whether each run moves each target, and with which others.
fn together(campaign: &Campaign, moved_in_runs: &[Vec<usize>]) -> Vec<Vec<(bool, Together)>> {
    let of_target = |run: usize, target: &Target| {
        let Some(carrier) = target.carrier else {
            return (false, Together::OnBed);
        };
        let moved = is_moved(campaign, run, carrier);
        match moved && moved_in_runs[run].len() > 1 {
            true => (moved, Together::InRun(run)),
            false => (moved, Together::OnCarrier(carrier)),
        }
    };
    let of_run = |run: usize| {
        let targets = campaign.targets.iter();
        targets.map(|target| of_target(run, target)).collect()
    };
    (0..campaign.runs.len()).map(of_run).collect()
}

/// Finds the bodies: targets that move together and whose shape the groups show. Groups that have three
/// targets in common that are not in line show one shape; groups with fewer than that of their own show none.
/// The targets of each body, ascending, and the body of each group.
fn shapes(
    campaign: &Campaign,
    groups: &[Group],
    kinds: &[Together],
) -> (Vec<Vec<usize>>, Vec<Option<usize>>) {
    let are_rigid = |targets: &[usize]| !are_in_line(&home_mm(campaign, targets));
    let common = |a: &[usize], b: &[usize]| -> Vec<usize> {
        a.iter().filter(|t| b.contains(t)).copied().collect()
    };
    let mut shapes: Vec<(Together, Vec<usize>)> = Vec::new();
    // Most groups have the targets of the one before.
    let as_before =
        |g: usize| g > 0 && kinds[g] == kinds[g - 1] && groups[g].targets == groups[g - 1].targets;
    for (g, (group, &kind)) in groups.iter().zip(kinds).enumerate() {
        if as_before(g) {
            continue;
        }
        let mut targets = group.targets.clone();
        let is_known = |shape: &(Together, Vec<usize>)| {
            shape.0 == kind && common(&targets, &shape.1) == targets
        };
        let is_free = kind == Together::OnBed;
        if is_free || !are_rigid(&targets) || shapes.iter().any(is_known) {
            continue;
        }
        // It may tie several that were apart; what they have together ties further ones.
        let mut first = None;
        while let Some(next) = shapes
            .iter()
            .position(|(k, other)| *k == kind && are_rigid(&common(&targets, other)))
        {
            first.get_or_insert(next);
            targets.extend(shapes.remove(next).1);
            targets.sort_unstable();
            targets.dedup();
        }
        let place = first.unwrap_or(shapes.len()).min(shapes.len());
        shapes.insert(place, (kind, targets));
    }
    let mut of_groups: Vec<Option<usize>> = Vec::with_capacity(groups.len());
    for (g, (group, kind)) in groups.iter().zip(kinds).enumerate() {
        let holds = |(k, targets): &(Together, Vec<usize>)| {
            k == kind && common(&group.targets, targets) == group.targets
        };
        of_groups.push(match as_before(g) {
            true => of_groups[g - 1],
            false if are_rigid(&group.targets) => shapes.iter().position(holds),
            false => None,
        });
    }
    let targets = shapes.into_iter().map(|(_, targets)| targets);
    (targets.collect(), of_groups)
}

fn home_mm(campaign: &Campaign, targets: &[usize]) -> Vec<Point3<f64>> {
    let home = targets.iter().map(|&t| campaign.targets[t].home_mm);
    home.collect()
}

/// The bodies with their nominal shapes and poses.
fn bodies(campaign: &Campaign, groups: &[Group], targets: Vec<Vec<usize>>) -> Bodies {
    let mut bodies = Bodies {
        bodies: targets
            .iter()
            .map(|targets| Body {
                home_mm: home_mm(campaign, targets),
            })
            .collect(),
        of_groups: Vec::with_capacity(groups.len()),
    };
    let mut is_placed: Vec<Vec<bool>> = targets.iter().map(|t| vec![false; t.len()]).collect();
    for group in groups {
        let step = &campaign.steps[group.step];
        let ref_from_home = motion(campaign, step, &group.targets);
        let mut places = Vec::new();
        if let Some(body) = group.body {
            let place = |target: &usize| targets[body].partition_point(|t| t < target);
            places.extend(group.targets.iter().map(place));
            let is_placed = &mut is_placed[body];
            if !places.iter().all(|&place| is_placed[place]) {
                // On a lower stage that is not at home a target is not at home in the body's frame.
                for (&place, nominal_mm) in places.iter().zip(nominal(campaign, group)) {
                    if !std::mem::replace(&mut is_placed[place], true) {
                        bodies.bodies[body].home_mm[place] = ref_from_home.inverse() * nominal_mm;
                    }
                }
            }
        }
        bodies.of_groups.push(Placed {
            body: group.body,
            places,
            ref_from_home,
        });
    }
    bodies
}

/// The rigid motion of the outermost stage that carries some targets.
fn motion(campaign: &Campaign, step: &Step, targets: &[usize]) -> Isometry3<f64> {
    let carriers = targets.iter().map(|&t| campaign.targets[t].carrier);
    let outermost = carriers.max_by_key(|&carrier| campaign.machine.chain(carrier).len());
    outermost.map_or_else(Isometry3::identity, |carrier| {
        campaign.machine.motion(&Ideal, carrier, &step.positions)
    })
}

/// Where the targets of a group are nominally, mm.
fn nominal(campaign: &Campaign, group: &Group) -> impl Iterator<Item = Point3<f64>> {
    let step = &campaign.steps[group.step];
    let targets = group.targets.iter().map(|&t| &campaign.targets[t]);
    // Most of them stand on one stage.
    let mut last = None;
    targets.map(move |target| {
        let motion = match last {
            Some((carrier, motion)) if carrier == target.carrier => motion,
            _ => campaign
                .machine
                .motion(&Ideal, target.carrier, &step.positions),
        };
        last = Some((target.carrier, motion));
        motion * target.home_mm
    })
}

fn declared_noise(campaign: &Campaign) -> Noise {
    let instrument = &campaign.instrument;
    let length_sigma_um = instrument
        .length_sigma_um
        .unwrap_or(UNDECLARED_LENGTH_SIGMA_UM);
    Noise {
        length_sigma_mm: length_sigma_um * MICROMETRE,
        // µm per m and mm per mm differ by a million.
        length_sigma_relative: instrument.length_sigma_ppm.unwrap_or(0.0) * 1e-6,
        repeatability_mm: instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE,
    }
}
