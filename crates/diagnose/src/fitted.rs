//! The misfit without a cause, and what the fitted cause explains of it, in the readings that show it most.
//!
//! Both are residuals of the adjustment, without what stations, poses and other unknowns absorb of the cause. Their
//! difference is what is left with the cause in the model.

use trueaxis_effects::Scene;
use trueaxis_kinematics::AxisKind;

use crate::numbers::distinct;

/// Data for a figure of a cause.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The readings, such as `station S2, target P`.
    pub of: String,
    /// The abscissa.
    pub against: Against,
    /// Whether misfit and effect are in arcsec, otherwise in µm.
    pub is_angular: bool,
    /// The readings in the order of the abscissa; over positions the forward side comes first.
    pub points: Vec<FittedPoint>,
    /// The other coordinates of the same readings, as far as the cause shows in them.
    pub beside: Vec<Self>,
}

/// The abscissa of misfit and effect.
#[derive(Debug, Clone, PartialEq)]
pub enum Against {
    /// Time, s.
    Time,
    /// The number of the reading, where a table has no clock.
    Order,
    /// Position of an axis, with its name and unit, `mm` or `deg`.
    Position(String, &'static str),
}

/// A reading, or the mean of several consecutive ones.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedPoint {
    /// Time or position.
    pub at: f64,
    /// Side of approach, +1 or -1.
    pub direction: i8,
    /// Residual of the model without the cause.
    pub misfit: f64,
    /// The part that the fitted cause explains.
    pub fitted: f64,
    /// Standard deviation of the misfit by noise alone.
    pub u: f64,
}

/// A reading with its residual without a cause, and the part that the fitted cause explains.
pub(crate) struct Row {
    /// Readings of one group are drawn together.
    pub(crate) group: usize,
    pub(crate) time_s: f64,
    /// The axes that move, with their positions, mm or rad.
    pub(crate) moving: Vec<(usize, f64)>,
    /// Side of approach, +1 or -1.
    pub(crate) direction: f64,
    pub(crate) misfit: f64,
    pub(crate) fitted: f64,
    /// Standard deviation of the misfit by noise alone.
    pub(crate) u: f64,
}

/// Most points that a figure can show: means of neighbours replace more of them.
const MOST_POINTS: usize = 240;

/// Least share of the squares of an effect that the drawn readings show.
const ENOUGH: f64 = 0.5;

/// Coordinates with less than this share of the squares of the one that shows an effect most are not drawn.
const TRACE: f64 = 1e-3;

impl Fitted {
    /// The group with the largest effect, over the quantity of which the effect is the smoothest function; `None` if
    /// the readings do not show it.
    /// Each of several coordinates of readings is a group; those of one set of readings are consecutive.
    pub(crate) fn new(
        rows: &[Row],
        coordinates: usize,
        name: impl Fn(usize) -> String,
        scene: &Scene,
    ) -> Option<Self> {
        let groups = rows.iter().map(|row| row.group).max()?;
        let mut of_group = vec![0.0; groups + 1];
        for row in rows {
            of_group[row.group] += row.fitted * row.fitted;
        }
        let group = (0..=groups).rev();
        let group = group.max_by(|&a, &b| of_group[a].total_cmp(&of_group[b]))?;
        let all = of_group[group];
        if !(all > 0.0 && all.is_finite()) {
            return None;
        }
        let own = |group: usize| rows.iter().filter(move |row| row.group == group);
        let axes = distinct(own(group).flat_map(|r| &r.moving).map(|m| m.0));
        let over = std::iter::once(None).chain(axes.into_iter().map(Some));
        let drawn_over = over.map(|over| (over, drawn(own(group), over, 1.0)));
        let drawn_over =
            drawn_over.filter(|(_, points)| varies(points) && squares(points) >= ENOUGH * all);
        let smoothest = drawn_over.min_by(|a, b| roughness(&a.1).total_cmp(&roughness(&b.1)));
        let (over, _) = smoothest?;
        let (against, size) = against(over, scene);
        let panel = |group: usize| Self {
            of: name(group),
            against: against.clone(),
            is_angular: false,
            points: thinned(&drawn(own(group), over, size)),
            beside: Vec::new(),
        };
        let first = group - group % coordinates;
        let others = (first..first + coordinates).filter(|&k| k != group && k <= groups);
        let others = others.filter(|&k| of_group[k] > TRACE * all);
        Some(Self {
            beside: others.map(panel).collect(),
            ..panel(group)
        })
    }

    /// The same figure with the kind of its values.
    pub(crate) fn of_angles(mut self, is_angular: bool) -> Self {
        self.is_angular = is_angular;
        for panel in &mut self.beside {
            panel.is_angular = is_angular;
        }
        self
    }
}

/// The most that a group shows of the effect, in squares of the noise of its readings.
pub(crate) fn most_shown(rows: &[Row]) -> f64 {
    let groups = rows.iter().map(|row| row.group + 1).max().unwrap_or(0);
    let mut of_group = vec![0.0; groups];
    for row in rows {
        of_group[row.group] += (row.fitted / row.u).powi(2);
    }
    of_group.into_iter().fold(0.0, f64::max)
}

/// Time, or the position of an axis, with the size of its unit.
fn against(over: Option<usize>, scene: &Scene) -> (Against, f64) {
    let Some(axis) = over.map(|axis| &scene.machine.axes()[axis]) else {
        return (Against::Time, 1.0);
    };
    let (unit, size) = match axis.kind() {
        AxisKind::Linear => ("mm", 1.0),
        AxisKind::Rotary => ("deg", 1_f64.to_radians()),
    };
    (Against::Position(axis.name().to_owned(), unit), size)
}

/// Rows over time or over the positions of an axis, by sides, in order.
fn drawn<'r>(
    rows: impl Iterator<Item = &'r Row>,
    over: Option<usize>,
    size: f64,
) -> Vec<(FittedPoint, i8)> {
    let point = |row: &Row| {
        let at = match over {
            None => row.time_s,
            Some(axis) => row.moving.iter().find(|m| m.0 == axis)?.1 / size,
        };
        let point = FittedPoint {
            at,
            direction: if row.direction < 0.0 { -1 } else { 1 },
            misfit: row.misfit,
            fitted: row.fitted,
            u: row.u,
        };
        let side = i8::from(over.is_some() && row.direction < 0.0);
        Some((point, side))
    };
    let mut points: Vec<(FittedPoint, i8)> = rows.filter_map(point).collect();
    points.sort_by(|(a, of_a), (b, of_b)| of_a.cmp(of_b).then(a.at.total_cmp(&b.at)));
    points
}

fn varies(points: &[(FittedPoint, i8)]) -> bool {
    points
        .windows(2)
        .any(|pair| pair[0].0.at.total_cmp(&pair[1].0.at).is_ne())
}

fn squares(points: &[(FittedPoint, i8)]) -> f64 {
    points.iter().map(|(point, _)| point.fitted.powi(2)).sum()
}

/// Squares of the steps between consecutive points of a side relative to the squares (J. von Neumann, 1941).
fn roughness(points: &[(FittedPoint, i8)]) -> f64 {
    let same_side = points.windows(2).filter(|pair| pair[0].1 == pair[1].1);
    let steps = same_side.map(|pair| (pair[1].0.fitted - pair[0].0.fitted).powi(2));
    steps.sum::<f64>() / squares(points)
}

/// Means of neighbours of a side, if there are more points than can be drawn.
fn thinned(points: &[(FittedPoint, i8)]) -> Vec<FittedPoint> {
    let every = points.len().div_ceil(MOST_POINTS).max(1);
    let sides = points.chunk_by(|a, b| a.1 == b.1);
    let parts = sides.flat_map(|side| side.chunks(every));
    let mean = |part: &[(FittedPoint, i8)]| {
        let mean_of = |f: fn(&FittedPoint) -> f64| {
            part.iter().map(|(point, _)| f(point)).sum::<f64>() / part.len() as f64
        };
        FittedPoint {
            at: mean_of(|point| point.at),
            direction: part[0].0.direction,
            misfit: mean_of(|point| point.misfit),
            fitted: mean_of(|point| point.fitted),
            u: (mean_of(|point| point.u * point.u) / part.len() as f64).sqrt(),
        }
    };
    parts.map(mean).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use trueaxis_kinematics::{Axis, Machine};

    use super::*;

    fn scene() -> Scene {
        let axis = |name, direction| Axis::linear(name, direction, [0.0, 400.0]).unwrap();
        let axes = vec![axis("X", Vector3::x()), axis("Y", Vector3::y())];
        Scene {
            machine: Machine::new(axes, vec![0, 1], vec![]).unwrap(),
            stations: Vec::new(),
            targets: Vec::new(),
            temperatures: Vec::new(),
            moving: vec![0, 1],
        }
    }

    /// A sweep there and back along X with the values of `effect(time, q, direction)`; group 0 sees a tenth of it.
    fn sweep(effect: impl Fn(f64, f64, f64) -> f64) -> Vec<Row> {
        let stop = |k: u32| {
            let time_s = f64::from(k);
            let (q, direction) = match k < 20 {
                true => (20.0 * time_s, 1.0),
                false => (20.0 * (39.0 - time_s), -1.0),
            };
            let row = move |group: usize, fitted: f64| Row {
                group,
                time_s,
                moving: vec![(0, q)],
                direction,
                misfit: fitted + 0.1,
                fitted,
                u: 0.2,
            };
            let whole = effect(time_s, q, direction);
            [row(0, 0.1 * whole), row(1, whole)]
        };
        (0..40).flat_map(stop).collect()
    }

    fn drawn(effect: impl Fn(f64, f64, f64) -> f64) -> Fitted {
        Fitted::new(
            &sweep(effect),
            1,
            |group| format!("group {group}"),
            &scene(),
        )
        .unwrap()
    }

    #[test]
    fn an_effect_is_drawn_over_what_it_follows() {
        let lost_motion = drawn(|_, _, direction| 2.0 * direction);
        assert_eq!(lost_motion.against, Against::Position("X".to_owned(), "mm"));
        assert_eq!(lost_motion.of, "group 1");
        let sides: Vec<i8> = lost_motion.points.iter().map(|p| p.direction).collect();
        assert_eq!(sides, [[1; 20], [-1; 20]].concat());

        let jump = drawn(|time_s, _, _| if time_s < 27.5 { -1.0 } else { 1.0 });
        assert_eq!(jump.against, Against::Time);
        assert!(jump.points.is_sorted_by(|a, b| a.at < b.at));
        assert!(
            jump.points
                .iter()
                .all(|p| (p.misfit - p.fitted - 0.1).abs() < 1e-12)
        );

        let nothing = sweep(|_, _, _| 0.0);
        assert_eq!(Fitted::new(&nothing, 1, |_| String::new(), &scene()), None);
    }

    #[test]
    fn neighbours_of_a_side_are_averaged() {
        let rows = (0..10_000_u32).map(|k| Row {
            group: 0,
            time_s: f64::from(k),
            moving: Vec::new(),
            direction: 1.0,
            misfit: f64::from(k),
            fitted: 1.0,
            u: 2.0,
        });
        let rows: Vec<Row> = rows.collect();
        let fitted = Fitted::new(&rows, 1, |_| String::new(), &scene()).unwrap();
        assert!(fitted.points.len() <= MOST_POINTS);
        assert!(fitted.points.iter().all(|p| (p.at - p.misfit).abs() < 1e-9));
        // 42 readings each, but for the last.
        let u = 2.0 / 42_f64.sqrt();
        assert!(fitted.points[..238].iter().all(|p| (p.u - u).abs() < 1e-9));
    }

    #[test]
    fn coordinates_that_show_an_effect_stand_beside_the_largest() {
        let rows = (0..60_u32).map(|k| Row {
            group: k as usize % 3,
            time_s: f64::from(k / 3),
            moving: Vec::new(),
            direction: 1.0,
            misfit: 0.0,
            // Along z the effect is ten times that along x; along y there is none.
            fitted: f64::from(k / 3) * [0.1, 0.0, 1.0][k as usize % 3],
            u: 1.0,
        });
        let rows: Vec<Row> = rows.collect();
        let name = |k: usize| ["x", "y", "z"][k].to_owned();
        let fitted = Fitted::new(&rows, 3, name, &scene()).unwrap();
        assert_eq!(fitted.of, "z");
        let [x] = fitted.beside.as_slice() else {
            panic!("{:?}", fitted.beside);
        };
        assert_eq!((x.of.as_str(), x.points.len()), ("x", 20));
        assert!((x.points[19].fitted - 1.9).abs() < 1e-12);
    }
}
