//! The constants of the reflectors: what the lengths to each are longer by than those to all in the mean.
//!
//! Reflectors of one set differ by some micrometres along the beam. A constant that all have in common is dead
//! path; the differences are unknowns of the adjustment ([`trueaxis_multilateration::Reflectors`]), and so is, where
//! dead paths are known, what they have in common.

use trueaxis_kinematics::MICROMETRE;
use trueaxis_screening::USUAL_DIFFERENCE_MM;

use crate::lengths::LengthsAdjustment;

/// The constant of a reflector, relative to the mean of all where no dead path is known.
#[derive(Debug, Clone, PartialEq)]
pub struct ReflectorConstant {
    /// Name of the reflector.
    pub name: String,
    /// By how much lengths to it are too long, mm.
    pub constant_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_mm: f64,
    /// Correlation with the constants of all, in their order.
    pub correlation: Vec<f64>,
}

/// A constant that exceeds what is declared by this many standard uncertainties is worth a notice.
const SIGNIFICANT: f64 = 3.0;

impl LengthsAdjustment<'_> {
    /// The constants of the reflectors that were measured, as the adjustment has them; none where there is but
    /// one reflector, or the lengths do not determine them.
    pub fn reflectors(&self) -> Vec<ReflectorConstant> {
        let solution = &self.screened.solution;
        let (constants_mm, covariance) = solution.reflector_constants();
        let (names, _) = self.campaign.reflectors();
        let u_mm = |i: usize| covariance[(i, i)].max(0.0).sqrt();
        let constants = constants_mm.iter().enumerate();
        constants
            .map(|(i, &constant_mm)| ReflectorConstant {
                name: names[self.reflectors[i]].clone(),
                constant_mm,
                u_mm: u_mm(i),
                correlation: (0..constants_mm.len())
                    .map(|j| covariance[(i, j)] / (u_mm(i) * u_mm(j)))
                    .collect(),
            })
            .collect()
    }

    /// What a user must know of them.
    pub(crate) fn reflector_notices(&self) -> Vec<String> {
        let declared_um = self.campaign.instrument.reflector_sigma_um;
        let of_network = self.screened.network.reflectors.as_deref();
        let taken_mm = of_network.and_then(|reflectors| reflectors.sigma_mm);
        if let (None, Some(sigma_mm)) = (declared_um, taken_mm) {
            return vec![format!(
                "the lengths do not determine how the constants of the reflectors differ: they are taken to differ \
                 by {} µm (standard deviation), as those of a set, and U contains that; declare \
                 `reflector_sigma_um` of the instrument, move one reflector from nest to nest (the same \
                 `reflector` for all targets), or let the stations see the stage from more sides",
                sigma_mm / MICROMETRE
            )];
        }
        let declared_mm = declared_um.map(|sigma_um| sigma_um * MICROMETRE);
        let limit_mm = declared_mm.unwrap_or(USUAL_DIFFERENCE_MM);
        let exceeds = |constant: &&ReflectorConstant| {
            constant.constant_mm.abs() > limit_mm + SIGNIFICANT * constant.u_mm
        };
        // What they have in common is not what a set differs by.
        let mut constants = self.reflectors();
        let mean_mm = self.screened.solution.mean_constant_mm.unwrap_or_default();
        constants
            .iter_mut()
            .for_each(|constant| constant.constant_mm -= mean_mm);
        let notice = |constant: &ReflectorConstant| {
            let (value_um, expanded_um) = (
                constant.constant_mm / MICROMETRE,
                2.0 * constant.u_mm / MICROMETRE,
            );
            let than = match declared_um {
                Some(sigma_um) => format!("`reflector_sigma_um` = {sigma_um}"),
                None => format!("the {} µm that are usual in a set", limit_mm / MICROMETRE),
            };
            format!(
                "lengths to reflector {} are longer by {value_um:+.2} µm (U {expanded_um:.2} µm) than to all in the \
                 mean, more than {than}: the results are free of it, if it was so all the time; a reflector may be \
                 damaged, or of another kind, or this target moved",
                constant.name
            )
        };
        constants.iter().filter(exceeds).map(notice).collect()
    }
}
