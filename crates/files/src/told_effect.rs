//! Effects of the catalogue as people are told of them.

/// The name of an effect with its subject, of which `part` gives the fields by their names in the files.
///
/// ```
/// use trueaxis_files::told_effect;
///
/// let of_axis = |field: &str| (field == "axis").then_some("C");
/// assert_eq!(told_effect("backlash", of_axis), "backlash of axis C");
/// assert_eq!(told_effect("machine_shift", |_| None), "machine shift");
/// ```
pub fn told_effect<'a>(effect: &str, part: impl Fn(&str) -> Option<&'a str>) -> String {
    let name = effect.replace('_', " ");
    // A component names its axis.
    let axis = match part("component") {
        Some(_) => ("component", ""),
        None => ("axis", "axis "),
    };
    let parts = [
        ("station", "station "),
        ("target", "target "),
        axis,
        ("other_axis", "with axis "),
        ("carrier", "carrier "),
        ("column", "with "),
    ];
    let given = parts.map(|(field, before)| Some(format!("{before}{}", part(field)?)));
    let given: Vec<String> = given.into_iter().flatten().collect();
    match given.is_empty() {
        true => name,
        false => format!("{name} of {}", given.join(", ")),
    }
}
