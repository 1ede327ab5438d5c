//! What could have been meant by a name that does not exist.

use std::fmt;

/// The names that exist, and the one most like the name found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alternatives {
    /// The most similar known name, if one is similar at all.
    pub nearest: Option<String>,
    /// Every known name in the order of the file or format.
    pub known: Vec<String>,
}

/// Names listed in a message; a machine has few axes, but a campaign may have many targets.
const LISTED_AT_MOST: usize = 30;

impl Alternatives {
    /// The alternatives to `found` among the names in `known`.
    ///
    /// A name is similar if at most half of the letters differ; case and swaps of neighbours count
    /// for little.
    pub fn new<S: AsRef<str>>(found: &str, known: impl IntoIterator<Item = S>) -> Self {
        let known: Vec<String> = known.into_iter().map(|n| n.as_ref().to_owned()).collect();
        let found = found.to_lowercase();
        let nearest = known
            .iter()
            .map(|name| (distance(&found, &name.to_lowercase()), name))
            .filter(|&(edits, name)| {
                // Half of the letters may differ: `S9` suggests `S1`, `Z` does not suggest `X`.
                2 * edits <= found.chars().count().max(name.chars().count())
            })
            .min_by_key(|&(edits, _)| edits)
            .map(|(_, name)| name.clone());
        Self { nearest, known }
    }
}

/// Edits from one name to the other; a swap of two neighbours is one.
fn distance(a: &str, b: &str) -> usize {
    strsim::damerau_levenshtein(a, b)
}

impl fmt::Display for Alternatives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(nearest) = &self.nearest {
            write!(f, "did you mean `{nearest}`? ")?;
        }
        match self.known.len() {
            0 => write!(f, "none is known"),
            n if n <= LISTED_AT_MOST => write!(f, "known: {}", self.known.join(", ")),
            n => write!(
                f,
                "known: {}, ... ({n} in all)",
                self.known[..LISTED_AT_MOST].join(", ")
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_the_one_with_the_fewest_edits() {
        let known = ["name", "position_mm", "carried_by"];
        let found = Alternatives::new("carryed_by", known);
        assert_eq!(found.nearest.as_deref(), Some("carried_by"));
        assert_eq!(
            found.to_string(),
            "did you mean `carried_by`? known: name, position_mm, carried_by"
        );
    }

    #[test]
    fn suggests_what_is_close() {
        let nearest = |found: &str| {
            Alternatives::new(found, ["targets", "stations", "runs", "repeats"]).nearest
        };
        assert_eq!(nearest("station").as_deref(), Some("stations"));
        assert_eq!(nearest("repaets").as_deref(), Some("repeats"));
    }

    #[test]
    fn suggests_nothing_where_nothing_is_known() {
        let none: [&str; 0] = [];
        assert_eq!(Alternatives::new("anything", none).nearest, None);
    }

    #[test]
    fn case_is_the_least_difference() {
        assert_eq!(
            Alternatives::new("x", ["Y", "X"]).nearest.as_deref(),
            Some("X")
        );
    }

    #[test]
    fn nothing_is_suggested_for_a_name_unlike_all() {
        let found = Alternatives::new("Z", ["X", "Y"]);
        assert_eq!(found.nearest, None);
        assert_eq!(found.to_string(), "known: X, Y");
    }
}
