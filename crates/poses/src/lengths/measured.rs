//! What an adjustment of lengths measured: the poses of the stages under test or, free of each other, the points on
//! them, with their noise; the scale, the stations and the targets on the bed.

use nalgebra::{DVector, Matrix6, Point3};
use rayon::prelude::*;
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{BlockNoise, Network, Solution, Station};
use trueaxis_screening::solve_as_a_set;

use crate::Error;
use crate::lengths::adjustment::LengthsAdjustment;
use crate::lengths::network::{Group, target_at};
use crate::lengths::refused::adjustment_error;
use crate::lengths::scale::{Scale, ScaleResult, at_scale};
use crate::lengths::shared_sources::SharedSources;
use crate::points::{MeasuredPoints, PointGroup, PointNoise};
use crate::poses::{PoseNoise, PoseObservation, Poses, TargetBody};
use crate::words::{MIN_TARGETS, step_in_words, target_names, too_few_targets};

/// Groups that one thread takes at a time.
const CHUNK: usize = 32;

impl LengthsAdjustment<'_> {
    /// The groups of the targets that move with the axes under test, in order.
    pub(crate) fn moved(&self) -> Vec<usize> {
        let groups = 0..self.groups.len();
        groups.filter(|&g| self.groups[g].moved).collect()
    }

    /// The poses of the stages under test in an adjustment with rigid stages.
    pub(crate) fn poses(&self) -> Result<Poses, Error> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        let moved = self.moved();
        let scale = self.scale.as_ref();
        let value = self.scale_value();
        let centres: Vec<Point3<f64>> = solution.shapes_mm.iter().map(|s| centroid(s)).collect();
        let body = |g: usize| {
            let group = &self.groups[g];
            group.body.ok_or_else(|| self.without_body(group))
        };
        let observation = |&g: &usize| {
            let (group, body) = (&self.groups[g], body(g)?);
            Ok(PoseObservation {
                step: group.step,
                direction: group.direction,
                body,
                datum_from_home: at_scale(&solution.poses[g], &centres[body], value),
                pivot_mm: self.place(centroid(&solution.points_mm[network.groups[g].clone()])),
            })
        };
        let shapes = solution.shapes_mm.iter().zip(&centres).enumerate();
        let bodies = shapes.map(|(body, (home_mm, centre))| TargetBody {
            targets: (0..home_mm.len())
                .map(|place| target_at(network, &self.groups, (body, place)).unwrap_or(0))
                .collect(),
            home_mm: home_mm
                .iter()
                .map(|h| centre + (h - centre) / (1.0 + value))
                .collect(),
        });
        // What the scale moves: the centre of the body.
        let place = |&g: &usize| {
            let moved_mm = solution.poses[g] * centres[body(g)?];
            let place = [moved_mm.x, moved_mm.y, moved_mm.z, 0.0, 0.0, 0.0];
            Ok(DVector::from_column_slice(&place))
        };
        let places: Vec<DVector<f64>> = moved.iter().map(place).collect::<Result<_, Error>>()?;
        let noise_of = |noise: &BlockNoise<'_>, sources: SharedSources<'_>| {
            pose_noise(noise, sources, (&moved, &places))
        };
        // What only the instrument's part needs is the largest, and gone before the rest is made.
        let of_lengths = solution.length_noise(network);
        let sources = SharedSources::new(&of_lengths, None, solution, scale);
        let instrument = noise_of(&of_lengths, sources);
        drop(of_lengths);
        let whole = solution.noise();
        let sources = SharedSources::new(&whole, Some(network), solution, scale);
        Ok(Poses {
            observations: moved.iter().map(observation).collect::<Result<_, _>>()?,
            bodies: bodies.collect(),
            noise: noise_of(&whole, sources),
            instrument,
            relative_covariance: self.screened.noise.relative_covariance,
        })
    }

    /// Why a group that the axis under test moves has no body.
    fn without_body(&self, group: &Group) -> Error {
        if group.targets.len() < MIN_TARGETS {
            return too_few_targets(self.campaign, group.step, group.targets.len());
        }
        Error::not_identifiable(
            format!(
                "{}: targets {} are on one line: no rotation about it is seen",
                step_in_words(self.campaign, group.step),
                target_names(self.campaign, &group.targets)
            ),
            "place one target well away from the line through the others",
        )
    }

    /// The points of the stages under test, free of each other, where the same lengths have them. Those of
    /// an adjustment with rigid stages follow from its solution in an iteration or two; they come without the
    /// instrument's own part of the noise.
    pub(crate) fn points(&self) -> Result<MeasuredPoints, Error> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        if network.bodies.is_none() {
            let scale = self.scale.as_ref();
            let mut points = self.measured_points((network, solution), scale);
            let of_lengths = solution.length_noise(network);
            let sources = SharedSources::new(&of_lengths, None, solution, scale);
            points.instrument = self.point_noise(&of_lengths, sources, (network, solution));
            return Ok(points);
        }
        let mut network = Network {
            bodies: None,
            ..network.clone()
        };
        let words = |error| adjustment_error(self.campaign, self.lengths, &self.groups, error);
        let free = solve_as_a_set(&mut network, Some(solution)).map_err(words)?;
        let scale = self.scale.as_ref().map(Scale::of_another);
        Ok(self.measured_points((&network, &free), scale.as_ref()))
    }

    fn measured_points(
        &self,
        (network, solution): (&Network, &Solution),
        scale: Option<&Scale>,
    ) -> MeasuredPoints {
        let group = |g: usize| {
            let measured_mm = solution.points_mm[network.groups[g].clone()].iter();
            PointGroup {
                step: self.groups[g].step,
                direction: self.groups[g].direction,
                targets: self.groups[g].targets.clone(),
                points_mm: measured_mm.map(|p| self.place(*p)).collect(),
            }
        };
        let whole = solution.noise();
        let sources = SharedSources::new(&whole, Some(network), solution, scale);
        MeasuredPoints {
            groups: self.moved().into_iter().map(group).collect(),
            noise: self.point_noise(&whole, sources, (network, solution)),
            instrument: PointNoise::default(),
            relative_covariance: self.screened.noise.relative_covariance,
            readings: Vec::new(),
            repeatability_variance_mm2: 0.0,
        }
    }

    fn point_noise(
        &self,
        noise: &BlockNoise<'_>,
        sources: SharedSources<'_>,
        (network, solution): (&Network, &Solution),
    ) -> PointNoise {
        let moved = self.moved();
        let place = |&g: &usize| {
            let points = &solution.points_mm[network.groups[g].clone()];
            let coordinates = points.iter().flat_map(|p| [p.x, p.y, p.z]);
            DVector::from_iterator(3 * points.len(), coordinates)
        };
        let places: Vec<DVector<f64>> = moved.iter().map(place).collect();
        let groups = moved.par_iter().zip(&places).with_min_len(CHUNK);
        let block = |(&g, place): (&usize, &DVector<f64>)| {
            let (own, coupling) = noise.block(g);
            (own, sources.coupling(coupling, place))
        };
        let (own, coupling) = groups.map(block).unzip();
        PointNoise {
            own,
            coupling,
            shared: sources.shared,
            declared: sources.declared,
            stations: sources.stations,
        }
    }

    /// The scale, if it is an unknown.
    pub fn scale(&self) -> Option<ScaleResult> {
        self.scale.as_ref().map(|scale| scale.result)
    }

    fn scale_value(&self) -> f64 {
        self.scale.as_ref().map_or(0.0, |scale| scale.result.value)
    }

    /// Where something measured is.
    fn place(&self, measured_mm: Point3<f64>) -> Point3<f64> {
        measured_mm / (1.0 + self.scale_value())
    }

    /// Where the targets on the bed stand, mm, with their numbers.
    pub fn targets_on_bed(&self) -> Vec<(usize, Point3<f64>)> {
        let (network, solution) = (&self.screened.network, &self.screened.solution);
        let Some(bed) = network.bed else {
            return Vec::new();
        };
        let points = solution.points_mm[network.groups[bed].clone()].iter();
        let targets = self.groups[bed].targets.iter();
        targets
            .zip(points)
            .map(|(&t, p)| (t, self.place(*p)))
            .collect()
    }

    /// The stations as they stand, with their dead paths.
    pub fn stations(&self) -> Vec<Station> {
        let solution = &self.screened.solution;
        let mean_mm = solution.mean_constant_mm.unwrap_or_default();
        let stations = solution.stations.iter();
        let station = |station: &Station| Station {
            position_mm: self.place(station.position_mm),
            dead_path_mm: station.dead_path_mm + mean_mm,
        };
        stations.map(station).collect()
    }
}

fn pose_noise(
    noise: &BlockNoise<'_>,
    sources: SharedSources<'_>,
    groups: (&[usize], &[DVector<f64>]),
) -> PoseNoise {
    let (groups, places) = groups;
    let size = 6 * sources.shared.nrows();
    let mut own = vec![Matrix6::zeros(); groups.len()];
    let mut couplings = vec![0.0; groups.len() * size];
    let of_poses = own.par_iter_mut().zip(couplings.par_chunks_exact_mut(size));
    let of_poses = of_poses.zip(groups).zip(places).with_min_len(CHUNK);
    of_poses.for_each(|(((own, of_pose), &g), place)| {
        let (block, coupling) = noise.block(g);
        own.copy_from(&block);
        of_pose.copy_from_slice(sources.coupling(coupling, place).as_slice());
    });
    PoseNoise {
        own,
        couplings,
        of_stations: sources.shared.nrows(),
        shared: sources.shared,
        declared: sources.declared,
        stations: sources.stations,
    }
}
