//! The known name that was probably meant.

/// The known name most like `found`, if at most half of the letters differ; case does not count, and a
/// swap of two neighbours is one difference.
pub(crate) fn nearest<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let found = found.to_lowercase();
    let edits = |name: &str| strsim::damerau_levenshtein(&found, &name.to_lowercase());
    let rated = known.into_iter().map(|name| (edits(name), name));
    rated
        .filter(|&(edits, name)| 2 * edits <= found.chars().count().max(name.chars().count()))
        .min_by_key(|&(edits, _)| edits)
        .map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_has_the_fewest_edits() {
        let known = ["machine_shift", "machine_drift", "station_jump"];
        let meant = |found| nearest(found, known);
        assert_eq!(meant("machine_shfit").as_deref(), Some("machine_shift"));
        assert_eq!(meant("Machine_Drift").as_deref(), Some("machine_drift"));
        assert_eq!(meant("x"), None);
        assert_eq!(nearest("x", []), None);
    }
}
