//! Round numbers along an axis.

/// The range of an axis with its ticks.
#[derive(Debug, Clone)]
pub(crate) struct Ruler {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) ticks: Vec<(f64, String)>,
}

/// Multiples of ten that a step may have: full and quarter turns look better in degrees.
const DECIMAL: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
const DEGREES: [f64; 9] = [5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0];

impl Ruler {
    /// From about `low` to `high`, with at most `most` ticks.
    pub(crate) fn new(low: f64, high: f64, most: usize) -> Self {
        Self::with_step(low, high, |span| {
            let least = span / most.max(1) as f64;
            let power = 10_f64.powf(least.log10().floor());
            let mut steps = DECIMAL.iter().map(|step| step * power);
            steps
                .find(|step| *step >= least * (1.0 - 1e-9))
                .unwrap_or(10.0 * power)
        })
    }

    /// The same for angles in degrees.
    pub(crate) fn degrees(low: f64, high: f64, most: usize) -> Self {
        let least = (high - low) / most.max(1) as f64;
        match DEGREES.iter().find(|step| **step >= least) {
            Some(step) if high - low >= DEGREES[1] => Self::with_step(low, high, |_| *step),
            _ => Self::new(low, high, most),
        }
    }

    /// Of an axis that moves in mm, or turns in degrees.
    pub(crate) fn positions(is_rotary: bool, low: f64, high: f64, most: usize) -> Self {
        match is_rotary {
            true => Self::degrees(low, high, most),
            false => Self::new(low, high, most),
        }
    }

    fn with_step(low: f64, high: f64, step: impl Fn(f64) -> f64) -> Self {
        // What is not finite or has no width gets a width: an axis must be drawn.
        let finite = |x: f64| {
            if x.is_finite() {
                x.clamp(-1e15, 1e15)
            } else {
                0.0
            }
        };
        let (low, high) = (finite(low), finite(high));
        let (mut low, mut high) = (low.min(high), low.max(high));
        let least = 1e-9_f64.max(1e-9 * low.abs().max(high.abs()));
        if high - low < least {
            let half = 0.5_f64.max(0.1 * low.abs());
            (low, high) = (low - half, high + half);
        }
        let step = step(high - low);
        let first = (low / step - 1e-6).ceil();
        let count = ((high / step + 1e-6).floor() - first).max(0.0);
        let (mut decimals, mut of_step) = (0_usize, step);
        while of_step < 1.0 - 1e-9 && decimals < 9 {
            (decimals, of_step) = (decimals + 1, 10.0 * of_step);
        }
        let tick = |k: f64| {
            let value = (first + k) * step;
            let text = if !(1e-8..1e6).contains(&step) {
                format!("{value:.0e}")
            } else {
                format!("{:.*}", decimals, value + 0.0)
            };
            (value, text.replace('-', "\u{2212}"))
        };
        let ticks = (0..=64).map(f64::from).take_while(|k| *k <= count);
        Self {
            low,
            high,
            ticks: ticks.map(tick).collect(),
        }
    }

    /// From 0 at the low end to 1 at the high one.
    pub(crate) fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// The least and greatest finite value; infinite and the wrong way round if there is none.
pub(crate) fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|x| x.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

/// The same with a margin of 6 % on both sides; `[0, 0]` if there is none.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = bounds(values);
    if low > high {
        return [0.0, 0.0];
    }
    let margin = 0.06 * (high - low);
    [low - margin, high + margin]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ruler: &Ruler) -> Vec<&str> {
        ruler.ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(
            labels(&Ruler::new(0.0, 440.0, 5)),
            ["0", "100", "200", "300", "400"]
        );
        assert_eq!(
            labels(&Ruler::new(-0.31, 0.28, 4)),
            ["\u{2212}0.2", "0.0", "0.2"]
        );
        assert_eq!(
            labels(&Ruler::degrees(0.0, 360.0, 5)),
            ["0", "90", "180", "270", "360"]
        );
    }

    #[test]
    fn an_axis_can_be_drawn_of_anything() {
        let odd = [
            0.0,
            f64::NAN,
            f64::INFINITY,
            f64::MAX,
            -f64::MAX,
            1e-300,
            5.0,
        ];
        for low in odd {
            for high in odd {
                for ruler in [Ruler::new(low, high, 5), Ruler::degrees(low, high, 5)] {
                    assert!(ruler.high > ruler.low, "{low} {high}");
                    assert!(ruler.ticks.len() <= 65);
                    assert!(ruler.ticks.iter().all(|(value, _)| value.is_finite()));
                }
            }
        }
    }
}
