//! Jumps of a zero in campaigns that read each stop once, or again.

use nalgebra::{Isometry3, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::solve;
use trueaxis_screening::Screened;

use crate::gross_errors::NOISE;
use crate::world::*;

fn screened(repeats: usize) -> Screened {
    let truth = truth(50.0);
    let mut network = network(&truth, truth.points.clone(), repeats, NOISE);
    add_noise(&mut network, &truth, &mut ChaCha8Rng::seed_from_u64(1));
    Screened::plain(&tied(&network), true).unwrap()
}

/// Jumps of 5 µm in campaigns whose stops were read once left no trace, and results were 5 u off without a word. What a jump does is
/// told, and it does so: the lengths with it give a pose that is as many of its uncertainties off.
#[test]
fn what_an_unnoticed_jump_does_is_told_where_stops_were_read_once() {
    let once = screened(1);
    let worst = once.unnoticed_jump().unwrap();
    assert!(worst.in_u > 3.0, "{worst:?}");
    let mut jumped = once.network.clone();
    let visits = jumped.visits.iter();
    let after = visits.filter(|visit| visit.station == worst.station);
    for i in after.flat_map(|visit| visit.readings.clone()) {
        if i >= worst.first_reading {
            jumped.readings[i].length_mm += worst.jump_mm;
        }
    }
    let (before, after) = (&once.solution, solve(&jumped).unwrap());
    let noise = before.noise();
    let (own, coupling) = noise.block(worst.group);
    let covariance = own + &coupling * noise.shared() * coupling.transpose();
    let centre = |points: &[Point3<f64>]| {
        let own = &points[once.network.groups[worst.group].clone()];
        own.iter().map(|p| p.coords).sum::<Vector3<f64>>() / own.len() as f64
    };
    let moved = centre(&after.points_mm) - centre(&before.points_mm);
    let rotation = |poses: &[Isometry3<f64>]| poses[worst.group].rotation;
    let turned = (rotation(&after.poses) / rotation(&before.poses)).scaled_axis();
    let all = [moved, turned];
    let changes = all.iter().flat_map(|change| change.iter());
    let in_u = changes
        .enumerate()
        .map(|(k, x)| x.abs() / covariance[(k, k)].sqrt());
    let most = in_u.fold(0.0, f64::max);
    assert!((most / worst.in_u - 1.0).abs() < 0.01, "{most} {worst:?}");
    assert_eq!(screened(2).unnoticed_jump(), None);
}
