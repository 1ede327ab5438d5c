//! Named parts of the mean curve of a positioning line without a calibration to compare it with.
//!
//! The curve contradicts nothing: it is the machine as far as known. But periodic parts, or one proportional to
//! position, have a name, and are found as in the curves of a calibration: on a smooth background.

use trueaxis_kinematics::{ARCSEC, AxisKind, Ideal, MICROMETRE};

use crate::Cause;
use crate::components::curve_set::{CurveSet, FEWEST_STEPS};
use crate::components::scene_of;
use crate::components::search::Search;
use crate::numbers::mean;
use crate::verification::base::{count, lines, places};
use crate::verification::comparison::{Comparison, along_itself};

/// Standard deviation assumed for readings without repeats, µm: next to nothing, so that the rough rest of the curve
/// replaces it.
const NO_REPEATS_UM: f64 = 1e-3;

/// Largest gap of a line that is read in steps, relative to the median gap.
const MOST_STEPS_APART: f64 = 3.0;

/// Named parts of the mean curve; `None` without a suitable curve: for a ball bar, several lines, few positions, or
/// groups of positions with gaps between them.
pub(crate) fn diagnose_line_curve(
    comparison: &Comparison<'_>,
    noise_um: Option<f64>,
    notices: &mut Vec<String>,
) -> Option<Vec<Cause>> {
    let axis = comparison.line()?;
    if count(&lines(comparison)) > 1 {
        return None;
    }
    let machine = comparison.machine;
    let content = &machine.axes()[axis];
    let component = along_itself(content);
    let places = places(comparison);
    let count = count(&places);
    if count < FEWEST_STEPS {
        return None;
    }
    let (mut nodes, mut values, mut variances) = (Vec::new(), Vec::new(), Vec::new());
    for place in 0..count {
        let own = || (0..places.len()).filter(|&row| places[row] == place);
        let first = own().next()?;
        // Size in µm of the readings of one unit of the curve.
        let unit_um = match content.kind() {
            AxisKind::Linear => 1.0,
            AxisKind::Rotary => {
                let chain = machine.chain(axis);
                let positions = &comparison.arrivals[first].positions;
                let before = machine.chain_motion(&Ideal, &chain[..chain.len() - 1], positions);
                let direction = before.rotation * content.direction().into_inner();
                let from_axis = comparison.points[first].point_mm - before * content.reference_mm();
                direction.cross(&from_axis).norm() * ARCSEC / MICROMETRE
            }
        };
        let of_side = |sign: f64| {
            let rows = own().filter(|&row| comparison.arrivals[row].direction * sign > 0.0);
            let rows: Vec<f64> = rows.map(|row| comparison.difference_um[row]).collect();
            (!rows.is_empty()).then(|| mean(&rows))
        };
        // The mean of the two sides is free of lost motion.
        let sides: Vec<f64> = [1.0, -1.0].into_iter().filter_map(of_side).collect();
        let readings = own().count() as f64;
        let sigma = noise_um.unwrap_or(NO_REPEATS_UM) / unit_um;
        nodes.push(comparison.arrivals[first].positions[axis]);
        values.push(mean(&sides) / unit_um);
        variances.push(sigma * sigma / readings);
    }
    if values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    // Waves of any length fit between groups of neighbouring stops.
    let largest = nodes.windows(2).map(|pair| pair[1] - pair[0]);
    let largest = largest.fold(0.0, f64::max);
    let set = CurveSet::of_line(axis, content, component, nodes, values, variances);
    if largest > MOST_STEPS_APART * set.measured_step() {
        return None;
    }
    notices.extend(set.notice(comparison.name));
    let mut causes = Search::new(&scene_of(machine, vec![axis]), vec![set]).causes();
    for cause in &mut causes {
        cause.data = vec![format!("mean curve of {}", comparison.name)];
    }
    Some(causes)
}
