//! Where the machine stood, stop by stop, where only the plan tells it.

use trueaxis_files::DocumentProblem;

use crate::map::Leg;

#[derive(Debug, Clone)]
pub(crate) struct PlannedStop<'m> {
    pub(crate) leg: &'m Leg,
    /// Of the axis that moves.
    pub(crate) position: f64,
    /// +1 or -1.
    pub(crate) direction: i8,
}

/// More stops than this are a step of the wrong unit.
const MOST_STOPS: f64 = 100_000.0;

/// By how much of a step the last one may miss the end.
const WHOLE_STEPS_TOL: f64 = 1e-6;

/// The stops of one round of the path.
pub(crate) fn stops(path: &[Leg]) -> Result<Vec<PlannedStop<'_>>, (usize, DocumentProblem)> {
    let mut stops = Vec::new();
    for (index, leg) in path.iter().enumerate() {
        let mut positions = positions(leg).map_err(|problem| (index, problem))?;
        if leg.back {
            positions.extend_from_within(..);
            let turn = positions.len() / 2;
            positions[turn..].reverse();
        }
        let directions = directions(&positions);
        let approached = positions.into_iter().zip(directions);
        stops.extend(approached.map(|(position, direction)| PlannedStop {
            leg,
            position,
            direction,
        }));
    }
    Ok(stops)
}

/// The side from which each of these positions is approached: that of the motion to it or, where there is none (the
/// first one, and where the axis turns), of the motion from it.
pub(crate) fn directions(positions: &[f64]) -> Vec<i8> {
    let motion = |from: Option<&f64>, to: Option<&f64>| match (from, to) {
        (Some(from), Some(to)) if to > from => Some(1),
        (Some(from), Some(to)) if to < from => Some(-1),
        _ => None,
    };
    let numbers = 0..positions.len();
    numbers
        .map(|i| {
            let here = positions.get(i);
            let before = i.checked_sub(1).and_then(|i| positions.get(i));
            let there = motion(before, here);
            there
                .or_else(|| motion(here, positions.get(i + 1)))
                .unwrap_or(1)
        })
        .collect()
}

fn positions(leg: &Leg) -> Result<Vec<f64>, DocumentProblem> {
    match (&leg.positions, leg.from, leg.to, leg.step) {
        (Some(positions), None, None, None) if !positions.is_empty() => Ok(positions.clone()),
        (None, Some(from), Some(to), Some(step)) => {
            let count = (to - from) / step;
            let whole = count.round();
            if !(0.0..MOST_STOPS).contains(&whole) || (count - whole).abs() > WHOLE_STEPS_TOL {
                return Err(DocumentProblem::value(
                    format!("from {from} to {to} are {count:.3} steps of {step}"),
                    "a whole number of steps; step is less than 0 if `to` is less than `from`",
                ));
            }
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a whole number below MOST_STOPS"
            )]
            let count = whole as u32;
            let position = |i| trueaxis_files::round(from + f64::from(i) * step, 9);
            Ok((0..=count).map(position).collect())
        }
        _ => Err(DocumentProblem::value(
            "the positions are not told",
            "either positions = [0, 20, 40], or from = 0, to = 40, step = 20",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leg(back: bool, [from, to, step]: [f64; 3]) -> Leg {
        Leg {
            run: "x".to_owned(),
            axis: "X".to_owned(),
            positions: None,
            from: Some(from),
            to: Some(to),
            step: Some(step),
            back,
            targets: Vec::new(),
            at: Default::default(),
        }
    }

    #[test]
    fn there_and_back() {
        let legs = [leg(true, [0.0, 0.3, 0.1])];
        let stops = stops(&legs).unwrap();
        let found: Vec<(f64, i8)> = stops.iter().map(|s| (s.position, s.direction)).collect();
        let there = [(0.0, 1), (0.1, 1), (0.2, 1), (0.3, 1)];
        let back = [(0.3, -1), (0.2, -1), (0.1, -1), (0.0, -1)];
        assert_eq!(found, [there, back].concat());
    }

    #[test]
    fn downward() {
        let legs = [leg(false, [20.0, 0.0, -10.0])];
        let stops = stops(&legs).unwrap();
        assert!(stops.iter().all(|stop| stop.direction == -1));
        assert_eq!(stops.len(), 3);
    }

    #[test]
    fn to_and_fro() {
        assert_eq!(directions(&[0.0, 20.0, 10.0, 10.0, 20.0]), [1, 1, -1, 1, 1]);
        assert_eq!(directions(&[5.0]), [1]);
    }

    #[test]
    fn no_whole_steps() {
        for wrong in [[0.0, 45.0, 20.0], [0.0, 40.0, -20.0], [0.0, 40.0, 0.0]] {
            assert!(stops(&[leg(false, wrong)]).is_err(), "{wrong:?}");
        }
    }
}
