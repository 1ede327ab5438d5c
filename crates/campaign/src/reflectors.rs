//! Which targets share a reflector.

use crate::{Campaign, Target};

impl Campaign {
    /// [`reflectors`] of its targets.
    pub fn reflectors(&self) -> (Vec<String>, Vec<usize>) {
        reflectors(&self.targets)
    }
}

/// The names of all reflectors, and for each target the index of its own among them.
///
/// Targets that name the same reflector share it and its constant: one reflector is moved from nest to nest. A target that names
/// none has one of its own, with the target's name. Reflectors are numbered as they first appear.
pub fn reflectors(targets: &[Target]) -> (Vec<String>, Vec<usize>) {
    let mut names: Vec<String> = Vec::new();
    let of_targets = targets.iter().map(|target| {
        let name = target.reflector.as_ref().unwrap_or(&target.name);
        let known = names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            names.push(name.clone());
            names.len() - 1
        })
    });
    let of_targets = of_targets.collect();
    (names, of_targets)
}
