//! Two causes at one station with the parts of tripod and dead path exchanged.
//!
//! A tripod that jumps while the dead path drifts looks much like a dead path that jumps while the tripod drifts.
//! Both names have to change at once, which exchanging one cause at a time does not find.

use trueaxis_effects::effect;
use trueaxis_selection::Hypothesis;

use crate::engine::Suspect;
use crate::lengths::base::Base;

/// Effects on the tripod, and the same effects on the dead path.
const KIN: [[&str; 2]; 2] = [
    ["station_jump", "dead_path_jump"],
    ["station_drift", "dead_path_drift"],
];

/// The suspects with the two of one station exchanged; `None` if there are no such two.
pub(super) fn swapped(base: &Base<'_>, suspects: &[Suspect]) -> Option<Vec<Suspect>> {
    let of_dead_path = |suspect: &Suspect| {
        let place = |kin: &[&str; 2]| kin.iter().position(|id| *id == id_of(suspect));
        KIN.iter().find_map(place).map(|place| place == 1)
    };
    let pairs = (0..suspects.len()).flat_map(|i| (0..suspects.len()).map(move |j| (i, j)));
    let is_pair = |&(i, j): &(usize, usize)| {
        let station = |k: usize| suspects[k].hypothesis.subject.station;
        let kinds = [i, j].map(|k| of_dead_path(&suspects[k]));
        station(i).is_some() && station(i) == station(j) && kinds == [Some(false), Some(true)]
    };
    let (i, j) = pairs.into_iter().find(is_pair)?;
    let mut all = suspects.to_vec();
    for k in [i, j] {
        all[k] = with_other_name(base, &suspects[k])?;
    }
    Some(all)
}

fn id_of(suspect: &Suspect) -> &'static str {
    suspect.hypothesis.effect.id
}

/// The kin of a suspect at the same instant, with its parameters.
fn with_other_name(base: &Base<'_>, suspect: &Suspect) -> Option<Suspect> {
    let kin = KIN.iter().find(|kin| kin.contains(&id_of(suspect)))?;
    let other = kin.iter().find(|id| **id != id_of(suspect))?;
    let hypothesis = Hypothesis {
        effect: effect(other)?,
        ..suspect.hypothesis
    };
    let count = hypothesis.parameters(&base.scene).len();
    Some(Suspect {
        hypothesis,
        shape: suspect.shape,
        u_shape: suspect.u_shape,
        parameters: vec![0.0; count],
        covariance: vec![0.0; count * count],
        seen: vec![true; count],
    })
}
