//! What could have been meant by a name that does not exist.

use std::fmt;

use strsim::damerau_levenshtein;

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
            .map(|name| (damerau_levenshtein(&found, &name.to_lowercase()), name))
            .filter(|&(edits, name)| {
                // Half of the letters may differ: `S9` suggests `S1`, `Z` does not suggest `X`.
                2 * edits <= found.chars().count().max(name.chars().count())
            })
            .min_by_key(|&(edits, _)| edits)
            .map(|(_, name)| name.clone());
        Self { nearest, known }
    }
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
    fn the_nearest_name_has_the_fewest_edits_if_one_is_similar() {
        const FIELDS: &[&str] = &["targets", "stations", "runs", "repeats"];
        for (found, known, nearest) in [
            (
                "carryed_by",
                &["name", "carried_by"][..],
                Some("carried_by"),
            ),
            ("station", FIELDS, Some("stations")),
            // A swap of two neighbours is one edit, another case none.
            ("repaets", FIELDS, Some("repeats")),
            ("x", &["Y", "X"], Some("X")),
            ("Z", &["X", "Y"], None),
            ("anything", &[], None),
        ] {
            let found = Alternatives::new(found, known);
            assert_eq!(found.nearest.as_deref(), nearest);
            let listed = match known {
                [] => "none is known".to_owned(),
                _ => format!("known: {}", known.join(", ")),
            };
            let meant = nearest.map(|name| format!("did you mean `{name}`? "));
            assert_eq!(found.to_string(), meant.unwrap_or_default() + &listed);
        }
    }
}
