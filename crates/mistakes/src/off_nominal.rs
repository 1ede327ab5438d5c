//! What is known beside the lengths: where targets and stations should be. Two mistakes may explain the lengths alike,
//! as a mirror image does; then this tells them apart.
//!
//! Of an explanation with `n` coordinates that are off by `r` (rms), in normal deviations of unknown size,
//!
//! ```text
//! -2 ln L = n ln r² + constant
//! ```
//!
//! (profile likelihood), once for targets and once for stations.

/// How far from where the campaign has them a calibration finds targets and stations, mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OffNominal {
    /// Of each target on a stage from its nominal position.
    pub targets_mm: Vec<f64>,
    /// Of each station from its `approx_mm`, of those that have one.
    pub stations_mm: Vec<f64>,
}

/// An explanation with `-2 ln L` larger by this is less likely: odds of 20 to 1.
const CLEAR: f64 = 6.0;

/// Nests and stations are not set better than this, mm.
const TARGET_MM: f64 = 0.1;
const STATION_MM: f64 = 1.0;

impl OffNominal {
    /// Whether this is clear evidence against an explanation, beside another one.
    pub(crate) fn is_clearly_farther(&self, than: &Self) -> bool {
        self.misfit() > than.misfit() + CLEAR
    }

    /// `-2 ln L`. The mean shift of targets is the frame's.
    pub(crate) fn misfit(&self) -> f64 {
        let of = |off_mm: &[f64], free: usize, least_mm: f64| {
            let count = 3 * off_mm.len().saturating_sub(free);
            2.0 * count as f64 * rms(off_mm).max(least_mm).ln()
        };
        of(&self.targets_mm, 1, TARGET_MM) + of(&self.stations_mm, 0, STATION_MM)
    }

    /// `then targets 0.5 mm off nominal, stations 43.0 mm off approx_mm (rms)`; nothing if nothing is known.
    pub(crate) fn in_words(&self) -> Option<String> {
        let of = |who: &str, off_mm: &[f64], what: &str| {
            let known = !off_mm.is_empty();
            known.then(|| format!("{who} {:.1} mm off {what}", rms(off_mm)))
        };
        let targets = of("targets", &self.targets_mm, "nominal");
        let stations = of("stations", &self.stations_mm, "`approx_mm`");
        let parts: Vec<String> = [targets, stations].into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("then {} (rms)", parts.join(", ")))
    }
}

fn rms(all: &[f64]) -> f64 {
    let squares: f64 = all.iter().map(|x| x * x).sum();
    (squares / all.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three targets have six coordinates beside their mean: 1.65 times as far is 2 · 6 ln 1.65 = 6.01.
    #[test]
    fn odds_of_twenty_to_one_are_clear() {
        let off = |mm: f64| OffNominal {
            targets_mm: vec![mm; 3],
            stations_mm: Vec::new(),
        };
        assert!(off(1.65).is_clearly_farther(&off(1.0)));
        assert!(!off(1.64).is_clearly_farther(&off(1.0)));
        // Below what nests are set to.
        assert!(!off(0.09).is_clearly_farther(&off(0.001)));
        let words = off(35.0).in_words().unwrap();
        assert_eq!(words, "then targets 35.0 mm off nominal (rms)");
        assert_eq!(OffNominal::default().in_words(), None);
    }
}
