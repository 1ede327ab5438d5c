//! More points far off than mistakes explain: none of them was left out, and least squares takes them for noise.
//!
//! Wrong points do not move the median length of the points' whitened residuals; by noise alone no residual is five
//! times as long. Of a stop only the point that is farthest off counts, since the others share its pose.

use trueaxis_effects::Level;
use trueaxis_leastsquares::median;

use crate::Unexplained;
use crate::engine::{ACCIDENTS, first_lines, most};
use crate::numbers::squares;
use crate::points::base::Base;
use crate::points::model::Model;

/// Median length of three coordinates of variance one.
const MEDIAN: f64 = 1.54;

/// Standard deviations from which a point is far off.
const FAR: f64 = 8.0;

/// Lengths of the whitened residuals of all points.
fn lengths(base: &Base<'_>, model: &Model) -> Vec<f64> {
    let residuals = model.projection.residuals.chunks_exact(3);
    let lengths = residuals.map(|row| squares(row).sqrt());
    lengths.take(base.readings.all.len()).collect()
}

/// Standard deviation of the whitened residuals by their median length, which wrong points do not move.
pub(super) fn robust_sigma(base: &Base<'_>, model: &Model) -> f64 {
    sigma_of(lengths(base, model))
}

fn sigma_of(mut lengths: Vec<f64>) -> f64 {
    median(&mut lengths).map_or(1.0, |median| median / MEDIAN)
}

/// The points far off in what a model leaves, if they are more than mistakes explain, or any if gross errors stayed
/// (`are_many`). `noise_um` is the standard deviation of a coordinate.
pub(crate) fn doubted(
    base: &Base<'_>,
    model: &Model,
    noise_um: f64,
    are_many: bool,
) -> Option<Unexplained> {
    let all = &base.readings.all;
    let lengths = lengths(base, model);
    let limit = FAR * sigma_of(lengths.clone());
    let stops = base.readings.stops.iter();
    let largest = stops.filter_map(|stop| {
        stop.clone()
            .max_by(|a, b| lengths[*a].total_cmp(&lengths[*b]))
    });
    let far: Vec<usize> = largest.filter(|point| lengths[*point] > limit).collect();
    let too_many = match are_many {
        true => 0,
        false => most(ACCIDENTS, all.len()),
    };
    if far.len() <= too_many {
        return None;
    }
    let lines = far.iter().map(|point| all[*point].line);
    let squares: f64 = far.iter().map(|point| lengths[*point].powi(2)).sum();
    let rms_um = noise_um * (squares / (3 * all.len()) as f64).sqrt();
    let note = format!(
        "in {} of {} stops a point is far off, too many or too close together to leave out: {}",
        far.len(),
        base.readings.stops.len(),
        first_lines(lines)
    );
    let left = Unexplained::new(Level::Points, rms_um, vec!["reading"], note);
    Some(left)
}
