//! What the name of a point says: `P_040` by the pattern `{target}_{X}`.

/// A text with fields in braces. A field takes the text up to what stands behind it in the pattern; `{}` is ignored.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    /// The text before the first field.
    start: String,
    /// Fields with the text behind each; only the last text may be empty.
    fields: Vec<(String, String)>,
}

impl Pattern {
    /// The pattern, or what is wrong with it.
    pub(crate) fn parse(text: &str) -> Result<Self, &'static str> {
        let mut parts = text.split('{');
        let start = parts.next().unwrap_or_default().to_owned();
        let mut fields = Vec::new();
        for part in parts {
            let (name, behind) = part.split_once('}').ok_or("a brace is not closed")?;
            fields.push((name.trim().to_owned(), behind.to_owned()));
        }
        let Some((_, between)) = fields.split_last() else {
            return Err("no field in braces, as {target}");
        };
        if between.iter().any(|(_, behind)| behind.is_empty()) {
            return Err("nothing stands between two fields, so that nothing tells where one ends");
        }
        Ok(Self { start, fields })
    }

    /// Names of its fields.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let names = self.fields.iter().map(|(name, _)| name.as_str());
        names.filter(|name| !name.is_empty())
    }

    /// The texts of its fields, in the order of [`Self::names`]; none if the text is not like that.
    pub(crate) fn split<'t>(&self, text: &'t str) -> Option<Vec<&'t str>> {
        let mut rest = text.strip_prefix(&self.start)?;
        let mut found = Vec::new();
        for (name, behind) in &self.fields {
            let (field, after) = match behind.as_str() {
                "" => (rest, ""),
                behind => rest.split_once(behind)?,
            };
            if !name.is_empty() {
                found.push(field.trim());
            }
            rest = after;
        }
        rest.is_empty().then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_points() {
        let split =
            |pattern: &str, text: &'static str| Pattern::parse(pattern).unwrap().split(text);
        assert_eq!(split("{target}_{X}", "P_040"), Some(vec!["P", "040"]));
        assert_eq!(
            split("A::{station}::{}-{C}deg", "A::S1::P-30deg"),
            Some(vec!["S1", "30"])
        );
        assert_eq!(split("{target}_{X}", "P-040"), None);
        assert_eq!(split("{C}deg", "30degrees"), None);
        assert!(Pattern::parse("{target}{X}").is_err());
        assert!(Pattern::parse("{target").is_err());
        assert!(Pattern::parse("target").is_err());
    }
}
