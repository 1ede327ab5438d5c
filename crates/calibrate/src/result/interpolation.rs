//! Which measured positions make the component errors between them.

use trueaxis_campaign::Direction;

/// A measured position.
pub(crate) trait Place {
    /// mm or rad.
    fn position(&self) -> f64;

    /// Side of approach, where kept apart.
    fn direction(&self) -> Option<Direction>;
}

/// The sides of approach that places have, backward before forward; either all keep them apart or
/// none does.
pub(crate) fn sides_of(places: &[impl Place]) -> Vec<Option<Direction>> {
    match places.first().map(Place::direction) {
        None => Vec::new(),
        Some(None) => vec![None],
        Some(Some(_)) => [Some(Direction::Backward), Some(Direction::Forward)]
            .into_iter()
            .filter(|side| places.iter().any(|place| place.direction() == *side))
            .collect(),
    }
}

/// Weights of the places whose sum is the curve at `position`: linear interpolation; the mean of
/// the sides of approach that reach the position; the nearest place if none does.
///
/// `places` are in order of position; `sides` are theirs ([`sides_of`]).
pub(crate) fn weights_at(
    places: &[impl Place],
    sides: &[Option<Direction>],
    position: f64,
) -> Vec<(usize, f64)> {
    let above = places.partition_point(|place| place.position() < position);
    let (low, high) = places.split_at(above);
    let mut inside = Vec::new();
    let mut outside: Vec<(usize, f64)> = Vec::new();
    // Places are in order of position, so the neighbours of each side are found at once.
    for &side in sides {
        let below = low.iter().rposition(|place| place.direction() == side);
        let above = high
            .iter()
            .position(|place| place.direction() == side)
            .map(|k| above + k);
        match (below, above) {
            (_, Some(at)) if places[at].position() <= position => inside.push((at, 1.0)),
            (Some(below), Some(above)) => {
                let (a, b) = (places[below].position(), places[above].position());
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
        let distance = |k: usize| (places[k].position() - position).abs();
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

    /// A place for tests.
    pub(crate) struct At(pub(crate) f64, pub(crate) Option<Direction>);

    impl Place for At {
        fn position(&self) -> f64 {
            self.0
        }

        fn direction(&self) -> Option<Direction> {
            self.1
        }
    }

    fn weights(places: &[At], position: f64) -> Vec<(usize, f64)> {
        weights_at(places, &sides_of(places), position)
    }

    #[test]
    fn sides_that_reach_a_position_share_it() {
        let places = [
            At(0.0, Some(Forward)),
            At(10.0, Some(Backward)),
            At(10.0, Some(Forward)),
            At(20.0, Some(Backward)),
            At(20.0, Some(Forward)),
        ];
        // Only forward reaches 5; both reach 15.
        assert_eq!(weights(&places, 5.0), [(0, 0.5), (2, 0.5)]);
        assert_eq!(
            weights(&places, 15.0),
            [(1, 0.25), (3, 0.25), (2, 0.25), (4, 0.25)]
        );
        assert_eq!(weights(&places, 10.0), [(1, 0.5), (2, 0.5)]);
    }

    #[test]
    fn outside_the_range_the_nearest_place_serves() {
        let places = [At(0.0, None), At(10.0, None)];
        assert_eq!(weights(&places, -3.0), [(0, 1.0)]);
        assert_eq!(weights(&places, 10.5), [(1, 1.0)]);
        assert!(weights(&[], 1.0).is_empty());
    }
}
