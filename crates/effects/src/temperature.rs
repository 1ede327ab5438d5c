//! Logged temperatures, and what follows them with a lag.
//!
//! A part of a machine that takes its heat from where the temperature ϑ is logged follows it as a first-order
//! lag, `T y' = ϑ - y`, and stands in equilibrium with it at the start. Between the nodes of the history ϑ runs
//! straight; there the lag has the closed form
//!
//! ```text
//! y(t + h) = ϑ(t + h) - s T + (y(t) - ϑ(t) + s T) exp(-h/T)        s = ϑ'
//! ```

/// A logged temperature that effects may go with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneTemperature {
    /// Its column, such as `machine_temp_spindle_c`.
    pub column: String,
    /// Of what.
    pub medium: Medium,
}

/// What a temperature is that of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Medium {
    /// The air that the beam goes through, not compensated by the instrument.
    Air,
    /// Some place of the machine.
    Machine,
}

/// The course of a temperature, at nodes in equal steps of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TemperatureHistory {
    start_s: f64,
    spacing_s: f64,
    values_c: Vec<f64>,
}

/// Nodes of a history of logged values: what is between them in time is averaged.
const NODES: usize = 256;

impl TemperatureHistory {
    /// The temperature at `start_s`, `start_s + spacing_s` and so on, °C; it is constant before the first and after
    /// the last. Without values it never changes.
    pub fn new(start_s: f64, spacing_s: f64, values_c: Vec<f64>) -> Self {
        Self {
            start_s,
            spacing_s,
            values_c,
        }
    }

    /// From values (°C) at times (s) in any order.
    pub fn from_logged(logged: &[(f64, f64)]) -> Self {
        let times = || logged.iter().map(|(time_s, _)| *time_s);
        let start_s = times().fold(f64::INFINITY, f64::min);
        let end_s = times().fold(f64::NEG_INFINITY, f64::max);
        let count = NODES.min(logged.len());
        if count < 2 || end_s <= start_s {
            return Self::default();
        }
        let spacing_s = (end_s - start_s) / (count - 1) as f64;
        let mut sums = vec![(0.0, 0.0); count];
        for &(time_s, value_c) in logged {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to the number of nodes"
            )]
            let node = ((time_s - start_s) / spacing_s).round() as usize;
            let (sum, weight) = &mut sums[node.min(count - 1)];
            *sum += value_c;
            *weight += 1.0;
        }
        // While nothing is logged, straight from the last value to the next.
        let filled = sums.iter().enumerate().filter(|(_, (_, n))| *n > 0.0);
        let means: Vec<(usize, f64)> = filled.map(|(k, (sum, n))| (k, sum / n)).collect();
        let mut values_c = Vec::with_capacity(count);
        values_c.push(means[0].1);
        for pair in means.windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            let part = |k: usize| (k - from) as f64 / (to - from) as f64;
            values_c.extend((from + 1..=to).map(|k| a + (b - a) * part(k)));
        }
        Self::new(start_s, spacing_s, values_c)
    }

    /// Times, s, and temperatures, °C, between which it runs straight.
    pub fn nodes(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let numbered = self.values_c.iter().enumerate();
        numbered.map(|(k, &value_c)| (self.start_s + self.spacing_s * k as f64, value_c))
    }

    /// By how much what follows the temperature with the lag is warmer than at the start of the history, K.
    pub fn warmer_k(&self, time_s: f64, lag_s: f64) -> f64 {
        let [first_c, ..] = self.values_c[..] else {
            return 0.0;
        };
        let mut left_s = (time_s - self.start_s).max(0.0);
        let (mut at_c, mut follows_c) = (first_c, first_c);
        let whole = (-self.spacing_s / lag_s).exp();
        for pair in self.values_c.windows(2) {
            let h = left_s.min(self.spacing_s);
            let slope = (pair[1] - pair[0]) / self.spacing_s;
            let next_c = at_c + slope * h;
            let is_last = left_s <= self.spacing_s;
            let decay = if is_last { (-h / lag_s).exp() } else { whole };
            if lag_s > 0.0 {
                let behind_c = slope * lag_s;
                follows_c = next_c - behind_c + (follows_c - at_c + behind_c) * decay;
            } else {
                follows_c = next_c;
            }
            at_c = pair[1];
            left_s -= h;
            if is_last {
                return follows_c - first_c;
            }
        }
        // Constant behind the last node.
        let decay = match lag_s > 0.0 {
            true => (-left_s / lag_s).exp(),
            false => 0.0,
        };
        at_c + (follows_c - at_c) * decay - first_c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of 2 K in 1000 s, then constant: `s (t - T + T exp(-t/T))`, then back to it.
    #[test]
    fn a_lag_follows_a_ramp_in_closed_form() {
        let values = (0..=10).map(|k| 20.0 + 0.2 * f64::from(k));
        let history = TemperatureHistory::new(50.0, 100.0, values.collect());
        let (slope, lag): (f64, f64) = (2e-3, 340.0);
        let ramp = |t: f64| slope * (t - lag + lag * (-t / lag).exp());
        for t in [0.0, 13.0, 100.0, 555.5, 1000.0] {
            assert!(
                (history.warmer_k(50.0 + t, lag) - ramp(t)).abs() < 1e-12,
                "{t}"
            );
            assert!((history.warmer_k(50.0 + t, 0.0) - slope * t).abs() < 1e-12);
        }
        let later = 2.0 + (ramp(1000.0) - 2.0) * (-700.0 / lag).exp();
        assert!((history.warmer_k(1750.0, lag) - later).abs() < 1e-12);
        assert!((history.warmer_k(1750.0, 0.0) - 2.0).abs() < 1e-12);
        assert!(history.warmer_k(-100.0, lag).abs() < 1e-12);
    }

    #[test]
    fn what_is_logged_is_averaged_and_gaps_are_bridged() {
        let logged: Vec<(f64, f64)> = (0..2000)
            .filter(|k| !(600..900).contains(k))
            .map(|k| (f64::from(k), 18.0 + 1e-3 * f64::from(k)))
            .collect();
        let history = TemperatureHistory::from_logged(&logged);
        for t in [100.0, 700.0, 1500.0] {
            // The ends of the history are means of half a step.
            assert!((history.warmer_k(t, 0.0) - 1e-3 * t).abs() < 8e-3, "{t}");
        }
        assert_eq!(
            TemperatureHistory::from_logged(&[(1.0, 20.0)]),
            TemperatureHistory::default()
        );
    }
}
