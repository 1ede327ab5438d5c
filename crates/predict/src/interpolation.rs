//! Which measured positions make the component errors between them.

use trueaxis_campaign::Direction;

/// A measured position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// mm or rad.
    pub position: f64,
    /// Side of approach, where kept apart.
    pub direction: Option<Direction>,
}

/// The sides of approach that nodes have, backward before forward; either all keep them apart or
/// none does.
pub(crate) fn sides_of(nodes: &[Node]) -> Vec<Option<Direction>> {
    match nodes.first().map(|node| node.direction) {
        None => Vec::new(),
        Some(None) => vec![None],
        Some(Some(_)) => [Some(Direction::Backward), Some(Direction::Forward)]
            .into_iter()
            .filter(|side| nodes.iter().any(|node| node.direction == *side))
            .collect(),
    }
}

/// Weights of the nodes, which are in order of position, whose sum is the curve at `position`: linear interpolation;
/// the mean of the sides of approach that reach the position; the nearest node if none does.
///
/// It serves the adjustment, where parked axes stand. No weight is below 0 or above 1, so that nodes which nearly coincide
/// amplify nothing here and each stays its own; predictions between nodes are those of `curve.rs`.
pub fn weights_at(nodes: &[Node], position: f64) -> Vec<(usize, f64)> {
    let above = nodes.partition_point(|node| node.position < position);
    let (low, high) = nodes.split_at(above);
    let mut inside = Vec::new();
    let mut outside: Vec<(usize, f64)> = Vec::new();
    // In order of position the neighbours of each side are found at once.
    for side in sides_of(nodes) {
        let below = low.iter().rposition(|node| node.direction == side);
        let above = high
            .iter()
            .position(|node| node.direction == side)
            .map(|k| above + k);
        match (below, above) {
            (_, Some(at)) if nodes[at].position <= position => inside.push((at, 1.0)),
            (Some(below), Some(above)) => {
                let (a, b) = (nodes[below].position, nodes[above].position);
                let weight = (position - a) / (b - a);
                inside.extend([(below, 1.0 - weight), (above, weight)]);
            }
            (Some(only), None) | (None, Some(only)) => outside.push((only, 1.0)),
            (None, None) => {}
        }
    }
    // A side that does not reach the position says nothing about it while another one does.
    let mut weights = inside;
    if weights.is_empty() {
        let distance = |k: usize| (nodes[k].position - position).abs();
        let nearest = outside
            .iter()
            .map(|&(k, _)| distance(k))
            .fold(f64::INFINITY, f64::min);
        outside.retain(|&(k, _)| distance(k) <= nearest);
        weights = outside;
    }
    let sum: f64 = weights.iter().map(|&(_, weight)| weight).sum();
    weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
    weights.retain(|&(_, weight)| weight > 0.0);
    weights
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use Direction::{Backward, Forward};

    pub(crate) fn at(position: f64, direction: Option<Direction>) -> Node {
        Node {
            position,
            direction,
        }
    }

    /// From 0 forward, from 10 on from both sides.
    pub(crate) fn both_sides() -> [Node; 5] {
        [
            at(0.0, Some(Forward)),
            at(10.0, Some(Backward)),
            at(10.0, Some(Forward)),
            at(20.0, Some(Backward)),
            at(20.0, Some(Forward)),
        ]
    }

    #[test]
    fn sides_that_reach_a_position_share_it() {
        let nodes = both_sides();
        // Only forward reaches 5; both reach 15.
        assert_eq!(weights_at(&nodes, 5.0), [(0, 0.5), (2, 0.5)]);
        assert_eq!(
            weights_at(&nodes, 15.0),
            [(1, 0.25), (3, 0.25), (2, 0.25), (4, 0.25)]
        );
        assert_eq!(weights_at(&nodes, 10.0), [(1, 0.5), (2, 0.5)]);
    }

    #[test]
    fn outside_the_range_the_nearest_node_serves() {
        let nodes = [at(0.0, None), at(10.0, None)];
        assert_eq!(weights_at(&nodes, -3.0), [(0, 1.0)]);
        assert_eq!(weights_at(&nodes, 10.5), [(1, 1.0)]);
        assert!(weights_at(&[], 1.0).is_empty());
    }
}
