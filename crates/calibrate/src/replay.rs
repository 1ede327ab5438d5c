//! The same campaign again: with other errors, or without the effects that disturbed it.

pub(crate) mod added_uncertainty;
pub(crate) mod reliability;
pub(crate) mod replay;
pub(crate) mod with_effects;
