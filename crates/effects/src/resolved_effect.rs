//! One effect with its values in a scene, ready to displace readings.

use crate::catalogue::{FEW_WAVES, MOST_OF_FEW, OVER_COMPENSATED};
use crate::shape::{shape_parameter, to_file};
use crate::{
    Circumstances, Displaced, Effect, Explanation, GivenEffect, GivenParameter, GivenSubject,
    Parameter, Scene, Subject,
};

/// An effect with its values; names are indices of the scene in which it was resolved.
#[derive(Debug, Clone)]
pub struct ResolvedEffect {
    /// Which.
    pub effect: &'static Effect,
    /// What it happens to.
    pub subject: Subject,
    /// Values of its linear parameters, in the order and units of [`Effect::parameters`].
    pub parameters: Vec<f64>,
    /// Its shape: s, mm, rad or a number of waves; 0 if it has none.
    pub shape: f64,
}

impl ResolvedEffect {
    /// Whether it is the same effect on the same subject, whatever the values.
    pub fn is(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id && self.subject == other.subject
    }

    /// What it does to a reading.
    pub fn displaced(&self, at: &Circumstances<'_>) -> Displaced {
        self.effect
            .displacement(&self.subject, &self.parameters, self.shape, at)
    }

    /// What to tell a calibration engineer about an effect of these values: lost motion below zero is
    /// over-compensation, and no wear.
    pub fn explanation(&self) -> Explanation {
        self.explanation_at(self.parameters.first().copied().unwrap_or_default())
    }

    /// The same if its first parameter has this value.
    pub fn explanation_at(&self, value: f64) -> Explanation {
        if self.effect.is_lost_motion() && value < 0.0 {
            OVER_COMPENSATED
        } else if self.effect.id == "worm_gear" && self.shape <= MOST_OF_FEW {
            FEW_WAVES
        } else {
            self.effect.explanation
        }
    }

    /// The effect by names: the linear parameters in the order of the catalogue, then the shape.
    ///
    /// Values without uncertainties. All come back as they are when resolved in the same scene, save a
    /// period in degrees, which may be rounded in its last bit.
    pub fn to_given(&self, scene: &Scene) -> GivenEffect {
        let given = |parameter: Parameter, value: f64| GivenParameter {
            name: parameter.name,
            value,
            u: None,
            unit: parameter.unit.to_owned(),
        };
        let linear = self.effect.parameters(scene, &self.subject).into_iter();
        let mut parameters: Vec<GivenParameter> = linear
            .zip(&self.parameters)
            .map(|(parameter, value)| given(parameter, *value))
            .collect();
        if let Some(parameter) = shape_parameter(self.effect, scene, &self.subject) {
            let value = to_file(&parameter, self.shape);
            parameters.push(given(parameter, value));
        }
        GivenEffect {
            effect: self.effect.id.to_owned(),
            subject: GivenSubject::new(&self.subject, scene),
            parameters,
        }
    }
}
