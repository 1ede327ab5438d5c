//! What may have been meant by a name that is not known.

/// The known name that is closest to `name`, if it is close at all.
///
/// Close means that at most half of the letters differ (case and swaps of neighbours count for
/// little): `S9` suggests `S1`, `Z` does not suggest `X`.
pub(crate) fn nearest_name<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let name = name.to_lowercase();
    known
        .into_iter()
        .map(|other| {
            let edits = strsim::damerau_levenshtein(&name, &other.to_lowercase());
            (
                edits,
                name.chars().count().max(other.chars().count()),
                other,
            )
        })
        .filter(|&(edits, letters, _)| 2 * edits <= letters)
        .min_by_key(|&(edits, ..)| edits)
        .map(|(.., other)| other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_what_is_close() {
        let known = ["targets", "stations", "runs", "repeats"];
        assert_eq!(nearest_name("station", known), Some("stations"));
        assert_eq!(nearest_name("repaets", known), Some("repeats"));
        assert_eq!(nearest_name("x", ["Y", "X"]), Some("X"));
    }

    #[test]
    fn suggests_nothing_when_nothing_is_close() {
        assert_eq!(nearest_name("Z", ["X", "Y"]), None);
        assert_eq!(nearest_name("anything", []), None);
    }
}
