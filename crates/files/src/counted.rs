//! Numbers of things in a message.

/// A number of things: `1 reading`, `2 readings`. Of nouns whose plural ends in s.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
