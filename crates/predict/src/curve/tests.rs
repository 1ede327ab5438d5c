//! Interpolation against functions that it holds exactly, and its noise.

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use trueaxis_montecarlo::ChaCha8Rng;

use super::*;
use crate::interpolation::tests::{at, both_sides};

fn places(positions: impl IntoIterator<Item = f64>) -> Vec<Node> {
    positions.into_iter().map(|q| at(q, None)).collect()
}

/// Steps at 0 and at 360° have noise of their own: the curve goes on at both without a jump.
#[test]
fn a_full_turn_does_not_jump_at_its_ends() {
    let nodes = places((0..=18).map(|k| (20.0 * f64::from(k)).to_radians()));
    let curve = Curve::new(AxisKind::Rotary, &nodes);
    let at = |q: f64| {
        let weights = curve.at(q).weights.into_iter();
        // 1 at the last step, 0 at all others.
        weights
            .filter(|(node, _)| *node == 18)
            .map(|(_, weight)| weight)
            .sum::<f64>()
    };
    for (end, expected) in [(TAU, 1.0), (0.0, 0.0)] {
        for q in [end - 1e-6, end, end + 1e-6] {
            assert!((at(q) - expected).abs() < 1e-5, "{q}: {}", at(q));
        }
    }
    // Elsewhere a turn more is no matter.
    assert!((at(TAU + 2.0) - at(2.0)).abs() < 1e-12);
}

fn value(curve: &Curve, nodes: &[Node], f: impl Fn(f64) -> f64, q: f64) -> f64 {
    let weights = curve.at(q).weights;
    weights
        .iter()
        .map(|&(n, weight)| weight * f(nodes[n].position))
        .sum()
}

#[test]
fn cubics_come_back_and_quartics_differ_by_the_remainder() {
    let nodes = places([0.0, 10.0, 30.0, 38.0, 50.0, 80.0]);
    let curve = Curve::new(AxisKind::Linear, &nodes);
    let cubic = |q: f64| 3.0 - 0.2 * q + 0.01 * q * q - 2e-4 * q.powi(3);
    let quartic = |q: f64| cubic(q) + 7e-6 * q.powi(4);
    for difference in curve.divided_differences(None) {
        let found: f64 = difference
            .iter()
            .map(|&(n, w)| w * quartic(nodes[n].position))
            .sum();
        assert!((found - 7e-6).abs() < 1e-15, "{found}");
    }
    for i in 0..=160 {
        let q = 0.5 * f64::from(i);
        assert!((value(&curve, &nodes, cubic, q) - cubic(q)).abs() < 1e-12);
        let off = value(&curve, &nodes, quartic, q) - quartic(q);
        let expected = 7e-6 * curve.at(q).remainder;
        assert!(
            (off.abs() - expected).abs() < 1e-12,
            "{q}: {off} {expected}"
        );
    }
}

#[test]
fn a_turn_has_no_ends() {
    let f = |q: f64| (2.0 * q).sin() + 0.3 * q.cos();
    for last in [17, 18] {
        let nodes = places((0..=last).map(|i| f64::from(20 * i).to_radians()));
        let curve = Curve::new(AxisKind::Rotary, &nodes);
        for degrees in [-5.0_f64, 3.0, 345.0, 352.0, 359.0, 367.0] {
            let q = degrees.to_radians();
            let off = value(&curve, &nodes, f, q) - f(q);
            assert!(off.abs() < 0.01, "{degrees}: {off}");
            assert!(curve.at(q).beyond < f64::MIN_POSITIVE);
        }
    }
    // Half a turn has.
    let nodes = places((0..=9).map(|i| f64::from(20 * i).to_radians()));
    let outside = Curve::new(AxisKind::Rotary, &nodes).at(190_f64.to_radians());
    assert_eq!(outside.weights, [(9, 1.0)]);
    assert!((outside.beyond - 10_f64.to_radians()).abs() < 1e-12);
}

#[test]
fn few_steps_make_lines_and_parabolas() {
    for (steps, powers) in [(1, 1), (2, 2), (3, 2), (4, 3), (5, 4)] {
        let nodes = places((0..steps).map(|i| f64::from(i * 10)));
        let curve = Curve::new(AxisKind::Linear, &nodes);
        let f = |q: f64| (0..powers).map(|p| (0.1 * q - 0.3).powi(p)).sum::<f64>();
        let q = 4.0_f64.min(f64::from(steps - 1) * 10.0);
        assert!(
            (value(&curve, &nodes, f, q) - f(q)).abs() < 1e-12,
            "{steps}"
        );
    }
}

/// Standard uncertainty where each step has that of 1, all independent.
fn u(sample: &Sample) -> f64 {
    let squares = sample.weights.iter().map(|(_, weight)| weight * weight);
    squares.sum::<f64>().sqrt()
}

#[test]
fn steps_that_nearly_coincide_do_not_amplify_noise() {
    let wave_um = |q: f64| 5.0 * (TAU * q / 200.0).sin();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for gap in [0.0001, 0.5, 3.0] {
        let nodes = places((0..20).flat_map(|k| [0.0, gap].map(|by| 20.0 * f64::from(k) + by)));
        let curve = Curve::new(AxisKind::Linear, &nodes);
        // Between steps, at them, within pairs and beyond the ends.
        let between = (-4..=1544).map(|k| 0.25 * f64::from(k));
        let places: Vec<f64> = between.chain(nodes.iter().map(|n| n.position)).collect();
        let samples: Vec<Sample> = places.iter().map(|&q| curve.at(q)).collect();
        for _ in 0..20 {
            let noise = || random.sample::<f64, _>(StandardNormal);
            let noise: Vec<f64> = std::iter::repeat_with(noise).take(nodes.len()).collect();
            for (q, sample) in places.iter().zip(&samples) {
                let weights = sample.weights.iter();
                let found = weights.map(|&(n, w)| w * (wave_um(nodes[n].position) + noise[n]));
                let off = found.sum::<f64>() - wave_um(q.clamp(0.0, 380.0 + gap));
                assert!(off.abs() < 4.5 * u(sample) + 0.1, "{gap} {q}: {off}");
            }
        }
        let largest = samples.iter().map(u).fold(0.0, f64::max);
        assert!(largest < 1.1, "{gap}: {largest}");
        // The mean of the pair half way, each of them where it is, and no jump anywhere.
        for (node, weight) in curve.at(40.0 + 0.5 * gap).weights {
            let expected = if [4, 5].contains(&node) { 0.5 } else { 0.0 };
            assert!((weight - expected).abs() < 0.03, "{gap} {node}: {weight}");
        }
        // Those half a millimetre apart are one: their noise is no slope.
        match gap < 0.02 * 20.0 {
            true => assert!(
                (curve
                    .at(40.0 + gap)
                    .weights
                    .iter()
                    .find(|w| w.0 == 5)
                    .unwrap()
                    .1
                    - 0.5)
                    .abs()
                    < 0.05
            ),
            false => assert_eq!(curve.at(40.0 + gap).weights, [(5, 1.0)]),
        }
        assert_eq!(curve.steps().len(), nodes.len());
        for q in nodes.iter().map(|node| node.position) {
            let [below, above] = [q - 1e-9, q + 1e-9].map(|q| value(&curve, &nodes, wave_um, q));
            assert!((below - above).abs() < 1e-6, "{gap} {q}: {below} {above}");
        }
    }
}

/// 10 mm beside gaps of 100 and more: as mean values of both the step at 200 was off by half of what they differ.
#[test]
fn every_step_has_its_own_error() {
    let nodes = places([0.0, 100.0, 200.0, 210.0, 380.0, 500.0]);
    let curve = Curve::new(AxisKind::Linear, &nodes);
    for (k, node) in nodes.iter().enumerate() {
        let sample = curve.at(node.position);
        assert_eq!(sample.weights, [(k, 1.0)]);
        assert!(sample.remainder.abs() < f64::MIN_POSITIVE);
    }
}

#[test]
fn no_grid_amplifies_noise_more_than_fivefold() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..200 {
        let gap = || 10_f64.powf(random.random_range(-3.0..2.0));
        let gaps = std::iter::repeat_with(gap).take(30);
        let positions = gaps.scan(0.0, |q, gap| {
            *q += gap;
            Some(*q)
        });
        let nodes = places(positions);
        let curve = Curve::new(AxisKind::Linear, &nodes);
        let [first, last] = [nodes[0].position, nodes[29].position];
        for k in 0..=1000 {
            let q = first + (last - first) * f64::from(k) / 1000.0;
            assert!(u(&curve.at(q)) < 5.0, "{q} of {nodes:?}");
        }
    }
}

/// The ends of a turn, too: 359.99° is 0°.
#[test]
fn ends_of_a_turn_that_nearly_coincide_do_not_amplify_noise() {
    let degrees = (0..18).map(|k| 20.0 * f64::from(k)).chain([359.99]);
    let nodes = places(degrees.map(f64::to_radians));
    let curve = Curve::new(AxisKind::Rotary, &nodes);
    for k in -300..=4000 {
        let q = (0.1 * f64::from(k)).to_radians();
        assert!(u(&curve.at(q)) < 1.1, "{k}: {}", u(&curve.at(q)));
    }
}

#[test]
fn steps_of_like_distances_are_knots_of_their_own() {
    for positions in [
        vec![0.0, 10.0, 20.0, 30.0, 40.0],
        vec![0.0, 5.0, 25.0, 40.0, 45.0, 65.0],
    ] {
        let curve = Curve::new(AxisKind::Linear, &places(positions.iter().copied()));
        let knots = curve.sides[0].knots.iter();
        let own = knots.map(|knot| (knot.position, knot.steps.len()));
        let expected = positions.iter().map(|&q| (q, 1));
        assert!(own.eq(expected));
    }
    let equal = Curve::new(AxisKind::Linear, &places([0.0, 10.0, 20.0, 30.0, 40.0]));
    let expected = [(1, -0.0625), (2, 0.5625), (3, 0.5625), (4, -0.0625)];
    assert_eq!(equal.at(25.0).weights, expected);
}

#[test]
fn sides_that_reach_a_position_share_it() {
    let nodes = both_sides();
    let curve = Curve::new(AxisKind::Linear, &nodes);
    assert_eq!(curve.at(5.0).weights, [(0, 0.5), (2, 0.5)]);
    assert_eq!(curve.at(10.0).weights, [(1, 0.5), (2, 0.5)]);
    let sum: f64 = curve
        .at(15.0)
        .weights
        .iter()
        .map(|(_, weight)| weight)
        .sum();
    assert!((sum - 1.0).abs() < 1e-15);
    assert!((curve.at(-3.0).beyond - 3.0).abs() < 1e-15);
}
