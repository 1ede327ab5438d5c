//! The course of a disturbance in time.

use std::f64::consts::TAU;

/// How large a disturbance is at an instant, as a part of its full size.
///
/// The shape parameters (`spread_s`, `bend`, `exponent`) are 0, 0 and 1 for the ideal forms of the
/// catalogue; [`super::misshapen`] sets others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// Always there: 1.
    Constant,
    /// There after an instant, 0 before; in between a ramp of `spread_s` with the instant in its
    /// middle.
    Jump {
        /// The instant, s.
        instant_s: f64,
        /// Duration of the ramp, s.
        spread_s: f64,
    },
    /// `w + bend w (1 - w)`, w the progress within the occupation of the station.
    Occupation {
        /// Largest deviation from the straight line is a quarter of it.
        bend: f64,
    },
    /// `τ + bend τ (1 - τ)`, τ the progress of the campaign.
    Campaign {
        /// Largest deviation from the straight line is a quarter of it.
        bend: f64,
    },
    /// `1 - exp(-(t/T)^exponent)`.
    WarmUp {
        /// T, s.
        time_constant_s: f64,
        /// 1 for a single time constant.
        exponent: f64,
    },
    /// `exp(-(t/T)^exponent)`, t since the start of the occupation of the station.
    Settling {
        /// T, s.
        time_constant_s: f64,
        /// 1 for a single time constant.
        exponent: f64,
    },
    /// `(1 - exp(-t/T1)) - ratio (1 - exp(-t/T2))`: two parts of the machine pull against each other.
    OpposedWarmUps {
        /// T1, s.
        fast_s: f64,
        /// T2, s.
        slow_s: f64,
        /// The slow part's size.
        ratio: f64,
    },
    /// `sin(2π t/T + φ)`.
    Wave {
        /// T, s.
        period_s: f64,
        /// φ, rad.
        phase_rad: f64,
    },
}

/// An instant of the campaign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Instant {
    /// Since the start of the campaign, s.
    pub(super) time_s: f64,
    /// 0 at the first and 1 at the last reading.
    pub(super) progress: f64,
    /// The same within the occupation of the station.
    pub(super) occupation_progress: f64,
    /// Since the first reading of the occupation, s.
    pub(super) occupation_elapsed_s: f64,
}

impl Course {
    /// The part of the full size at an instant.
    pub(super) fn at(&self, now: &Instant) -> f64 {
        let bent = |x: f64, bend: f64| x + bend * x * (1.0 - x);
        let saturating = |t_s: f64| 1.0 - (-now.time_s / t_s).exp();
        match *self {
            Self::Constant => 1.0,
            Self::Jump {
                instant_s,
                spread_s,
            } if spread_s > 0.0 => ((now.time_s - instant_s) / spread_s + 0.5).clamp(0.0, 1.0),
            Self::Jump { instant_s, .. } => f64::from(u8::from(now.time_s > instant_s)),
            Self::Occupation { bend } => bent(now.occupation_progress, bend),
            Self::Campaign { bend } => bent(now.progress, bend),
            Self::WarmUp {
                time_constant_s,
                exponent,
            } => 1.0 - (-(now.time_s / time_constant_s).powf(exponent)).exp(),
            Self::Settling {
                time_constant_s,
                exponent,
            } => (-(now.occupation_elapsed_s / time_constant_s).powf(exponent)).exp(),
            Self::OpposedWarmUps {
                fast_s,
                slow_s,
                ratio,
            } => saturating(fast_s) - ratio * saturating(slow_s),
            Self::Wave {
                period_s,
                phase_rad,
            } => (TAU * now.time_s / period_s + phase_rad).sin(),
        }
    }

    /// The same course in another shape, by `part` of the usual imperfection (1: a jump takes ten
    /// seconds, a drift is bent by 15 %, the exponent of a warm-up is 15 % larger). What has no ideal
    /// shape stays.
    pub(super) fn misshapen(self, part: f64) -> Self {
        match self {
            Self::Jump { instant_s, .. } => Self::Jump {
                instant_s,
                spread_s: 10.0 * part.abs(),
            },
            Self::Occupation { .. } => Self::Occupation { bend: 0.15 * part },
            Self::Campaign { .. } => Self::Campaign { bend: 0.15 * part },
            Self::WarmUp {
                time_constant_s, ..
            } => Self::WarmUp {
                time_constant_s,
                exponent: 1.0 + 0.15 * part,
            },
            Self::Settling {
                time_constant_s, ..
            } => Self::Settling {
                time_constant_s,
                exponent: 1.0 + 0.15 * part,
            },
            Self::Constant | Self::OpposedWarmUps { .. } | Self::Wave { .. } => self,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time_s: f64) -> Instant {
        Instant {
            time_s,
            progress: time_s / 1000.0,
            occupation_progress: time_s / 500.0,
            occupation_elapsed_s: time_s,
        }
    }

    fn assert_course(course: Course, values: &[(f64, f64)]) {
        for &(time_s, value) in values {
            let found = course.at(&at(time_s));
            assert!(
                (found - value).abs() < 4.0 * f64::EPSILON,
                "at {time_s} s: {found}"
            );
        }
    }

    #[test]
    fn a_jump_is_half_done_at_its_instant_and_done_after_its_spread() {
        let jump = |spread_s| Course::Jump {
            instant_s: 100.0,
            spread_s,
        };
        let ramp = [(94.0, 0.0), (97.5, 0.25), (100.0, 0.5), (106.0, 1.0)];
        assert_course(jump(10.0), &ramp);
        assert_course(jump(0.0), &[(99.9, 0.0), (100.1, 1.0)]);
    }

    #[test]
    fn a_bend_leaves_both_ends_where_they_are() {
        let values = [(0.0, 0.0), (500.0, 0.5375), (1000.0, 1.0)];
        assert_course(Course::Campaign { bend: 0.15 }, &values);
    }
}
