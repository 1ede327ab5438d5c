//! The reference frame: which motion of the whole is taken out of the results.
//!
//! With two linear axes of different direction the first average line gives its nominal direction
//! and the second one lies in the nominal plane of the two. What lines leave open, the targets
//! decide: the origin always, the rotation about the line with one linear axis, the whole rotation
//! with none. The targets are then where a best fit to their nominal positions at home puts them.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{AxisKind, Machine};

use crate::axis_data::AxisData;
use crate::rigid_fit::centroid;

/// The rule that fixes the frame of a campaign.
pub(crate) struct FrameRule {
    /// Up to two linear axes (indices of the axis data) with their nominal directions.
    pub(crate) lines: Vec<(usize, Vector3<f64>)>,
    /// The targets that decide the rest.
    pub(crate) anchors: Vec<Anchor>,
    /// The axes that move the anchors.
    anchored: Vec<usize>,
    pivot: Point3<f64>,
}

/// A target in a run, whose position at home enters the frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    /// Index of the axis data.
    pub(crate) data: usize,
    /// Its run.
    pub(crate) run: usize,
    /// Place of the target among the run's targets.
    pub(crate) place: usize,
    pub(crate) nominal_mm: Point3<f64>,
}

/// A small rigid motion `v + ρ × (p - pivot)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SmallMotion {
    pub(crate) rotation: Vector3<f64>,
    pub(crate) translation: Vector3<f64>,
    pub(crate) pivot: Point3<f64>,
}

/// Directions closer than this (sine of the angle) do not span a plane.
const PARALLEL_TOL: f64 = 0.1;

impl FrameRule {
    pub(crate) fn new(campaign: &Campaign, machine: &Machine, data: &[AxisData]) -> Self {
        let mut linear: Vec<usize> = (0..data.len())
            .filter(|&k| machine.axes()[data[k].axis].kind() == AxisKind::Linear)
            .collect();
        linear.sort_by_key(|&k| machine.axes()[data[k].axis].principal());
        let direction = |k: usize| machine.axes()[data[k].axis].direction().into_inner();
        let mut lines = Vec::new();
        if let Some(&first) = linear.first() {
            lines.push((first, direction(first)));
            let second = linear
                .iter()
                .find(|&&k| direction(first).cross(&direction(k)).norm() > PARALLEL_TOL);
            lines.extend(second.map(|&k| (k, direction(k))));
        }
        let carrier = linear.first().map(|&k| {
            let target = data[k].runs.first().and_then(|run| run.targets.first());
            target.map(|&target| campaign.targets[target].carrier)
        });
        let mut anchors = Vec::new();
        for (k, axis) in data.iter().enumerate() {
            if !linear.is_empty() && !linear.contains(&k) {
                continue;
            }
            for (run, content) in axis.runs.iter().enumerate() {
                for (place, &target) in content.targets.iter().enumerate() {
                    let target = &campaign.targets[target];
                    if carrier.is_none_or(|c| c == Some(target.carrier)) {
                        let nominal_mm = target.home_mm;
                        anchors.push(Anchor {
                            data: k,
                            run,
                            place,
                            nominal_mm,
                        });
                    }
                }
            }
        }
        let nominal: Vec<_> = anchors.iter().map(|anchor| anchor.nominal_mm).collect();
        let anchored = match carrier {
            Some(Some(carrier)) => machine.chain(carrier).to_vec(),
            _ => Vec::new(),
        };
        Self {
            lines,
            anchors,
            anchored,
            pivot: centroid(&nominal),
        }
    }

    /// Whether a rotary axis has a place along itself. It is where its targets are; if these are
    /// the anchors of the frame, that is their nominal place by definition.
    pub(crate) fn places_along_itself(&self, axis: usize) -> bool {
        !self.lines.is_empty() && !self.anchored.contains(&axis)
    }

    /// The motion that is to be taken out: from the tilts of the lines (rotation vectors in the
    /// reference frame) and the shifts of the anchors. It is linear in both.
    pub(crate) fn motion(&self, tilts: &[Vector3<f64>], shifts: &[Vector3<f64>]) -> SmallMotion {
        let count = shifts.len().max(1) as f64;
        let translation = shifts.iter().sum::<Vector3<f64>>() / count;
        // Moment of the shifts and moment of inertia of the anchors: ρ = J⁻¹ m is the best fit.
        let mut moment = Vector3::zeros();
        let mut inertia = Matrix3::zeros();
        for (anchor, shift) in self.anchors.iter().zip(shifts) {
            let r = anchor.nominal_mm - self.pivot;
            moment += r.cross(shift);
            inertia += Matrix3::identity() * r.norm_squared() - r * r.transpose();
        }
        let across = |v: Vector3<f64>, d: Vector3<f64>| v - d * d.dot(&v);
        let rotation = match (self.lines.as_slice(), tilts) {
            ([(_, d1), (_, d2)], [t1, t2]) => {
                let first = across(*t1, *d1);
                let in_plane = d2.cross(&d1.cross(d2));
                first + d1 * ((t2 - first).dot(&in_plane) / d1.dot(&in_plane))
            }
            ([(_, d1)], [t1]) => {
                let first = across(*t1, *d1);
                first + d1 * (d1.dot(&(moment - inertia * first)) / d1.dot(&(inertia * d1)))
            }
            _ => inertia
                .try_inverse()
                .map_or_else(Vector3::zeros, |inverse| inverse * moment),
        };
        SmallMotion {
            rotation,
            translation,
            pivot: self.pivot,
        }
    }
}

impl SmallMotion {
    /// The exact motion that takes it out.
    pub(crate) fn removal(&self) -> Isometry3<f64> {
        Translation3::from(self.pivot.coords)
            * UnitQuaternion::from_scaled_axis(-self.rotation)
            * Translation3::from(-self.pivot.coords - self.translation)
    }
}
