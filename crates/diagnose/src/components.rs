//! The level of the error curves: named effects in the curves of a calibration.
//!
//! A curve of a machine is never noise: it is smooth on a large scale, rough on a small one, and only a part of it
//! may be an effect of the catalogue. So an effect must stand out from the *rest of the curve*, not only from the
//! measuring noise. The model of a curve over the positions q of its axis is
//!
//! ```text
//! y = B b + X θ + g + h + e
//! ```
//!
//! - `B b`: what the least-squares gauge takes out. It is free, so that the choice of gauge does not matter;
//! - `X θ`: the effect, linear once its shape (period, waves) is given;
//! - `g ~ N(0, s² K)`: the smooth rest, a Gauss-Markov process of second order ([`background`]);
//! - `h ~ N(0, w² I)`: the rough rest, independent from step to step;
//! - `e ~ N(0, C)`: the noise of the measurement, C from the calibration.
//!
//! s and w are not known. They are integrated out over a grid, weighted by the restricted likelihood *with the effect
//! in the model* ([`judgement`]): a large effect then does not hide in a rest that it has inflated itself, and few
//! degrees of freedom of the rest give broad tails as in Student's test. Curves of different components have rests of
//! their own, but the two curves across a rotary axis share theirs; the other curves of the machine show how likely
//! each s is ([`smooth_prior`]).
//!
//! The p-value counts everything that was tested: each effect gets the same share of the 1 %, shared by all its axes,
//! components and shapes ([`family`]). Effects join one at a time, each with the earlier ones in the model, and are
//! judged again with all others in it ([`crate::engine::Forward`]).
//!
//! C is singular in the directions that the gauge fixes. As B is free these directions carry no information, and the
//! rough rest, which is never quite zero, makes the sum regular: no limit of rank is needed.
//!
//! A translation carries the noise of the angles times the distance of its reference point from the targets: with
//! [`trueaxis_calibrate::ReferencePoint::Centroid`] smaller effects are found. The uncertainty of a slope, a bow or
//! one wave per turn depends on the assumed K: for much smoother curves, such as polynomials of low degree, it is too
//! small. That of bows and scales takes the other guideways of the machine into account ([`bow`]).

mod aliases;
mod background;
mod bow;
mod candidates;
mod curve_set;
mod estimate;
mod family;
mod judgement;
mod line_curve;
mod report;
mod search;
mod smooth_prior;
mod unseen;

use trueaxis_calibrate::Calibration;
use trueaxis_effects::Scene;
use trueaxis_kinematics::Machine;

pub(crate) use crate::components::line_curve::diagnose_line_curve;

use crate::components::curve_set::curve_sets;
use crate::components::search::Search;
use crate::said::Said;

/// Looks for effects in the curves of a calibration.
pub(crate) fn diagnose_components(calibration: &Calibration, machine: &Machine) -> Said {
    let mut notices = Vec::new();
    let sets = curve_sets(calibration, machine, &mut notices);
    let axes = calibration.axes.iter();
    let scene = scene_of(machine, axes.clone().map(|axis| axis.axis).collect());
    Said {
        curves: Search::new(&scene, sets).causes(),
        not_observable: axes.filter_map(unseen::periods_of_the_step).collect(),
        notices,
        ..Said::default()
    }
}

/// A scene of a machine of which some axes move.
fn scene_of(machine: &Machine, moving: Vec<usize>) -> Scene {
    Scene {
        machine: machine.clone(),
        stations: Vec::new(),
        targets: Vec::new(),
        moving,
        temperatures: Vec::new(),
    }
}
