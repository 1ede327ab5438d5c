//! The notices about lengths that scatter more than the others.

use trueaxis_campaign::Campaign;
use trueaxis_multilateration::{Network, Noise};
use trueaxis_screening::{LessWeight, Whose};

use crate::lengths::network::{Group, target_at};

/// A notice about them and the factor on the variance of their noise, with what to look at.
pub fn uneven_in_words(
    own: &LessWeight,
    campaign: &Campaign,
    (network, groups): (&Network, &[Group]),
) -> String {
    let names = |stations: &[usize]| {
        let names = stations.iter().map(|&j| campaign.stations[j].name.as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let of_station = "see whether the tripod stood firmly and what passed through the beam";
    let of_target = "see whether its reflector is clean and whole and sits firmly in its nest";
    let (which, advice) = match &own.whose {
        Whose::Station(station) => (format!("station {}: its", names(&[*station])), of_station),
        Whose::Part(stations) => (format!("station {}: many", names(stations)), of_station),
        Whose::Target(place) => {
            let target = target_at(network, groups, *place);
            let name = target.map_or("", |target| campaign.targets[target].name.as_str());
            (format!("target {name}: its"), of_target)
        }
    };
    format!(
        "{which} lengths scatter {:.1} times as much as the others, and weigh less by that; {advice}",
        own.factor.sqrt()
    )
}

/// A notice that far lengths scatter more than near ones by this noise.
pub(super) fn growing_in_words(noise: &Noise) -> String {
    format!(
        "lengths scatter more the longer they are, and no such part of their noise is declared: it is {:.2} ppm of the \
         length, and long ones weigh less by that; declare it as length_sigma_ppm of the instrument",
        noise.length_sigma_relative * 1e6
    )
}
