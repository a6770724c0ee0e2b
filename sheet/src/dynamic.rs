//! The figures of a control in motion, which a slow turn does not show: from a fit of captures at speed.

use identification::statistics::NORMAL_95;
use identification::{Fit, Parameter};
use shared_types::Axis;

use crate::figure::{Estimate, Figure, FigureKind};
use crate::repeats::{Sheet, SheetError};

const KARNOPP: &str = "D. Karnopp, J. Dyn. Sys., Meas., Control 107, 1985";

/// The dynamic figures of what turns.
mod turned {
    use super::KARNOPP;
    use crate::figure::{FigureKind, define_figures};

    const PAPER: &str = "equation 1 of Swindells and MacLean 2007";

    define_figures! {
        INERTIA "inertia" "mNm s²/rad" PAPER "Torque per angular acceleration."
        VISCOUS_NEGATIVE "viscous_negative" "mNm s/rad" PAPER "Rise of friction with speed, turning in the negative direction."
        VISCOUS_POSITIVE "viscous_positive" "mNm s/rad" PAPER "Rise of friction with speed, turning in the positive direction."
        STATIC_NEGATIVE "static_negative" "mNm" KARNOPP "Torque at which the control breaks away from rest in the negative direction."
        STATIC_POSITIVE "static_positive" "mNm" KARNOPP "Torque at which the control breaks away from rest in the positive direction."
    }
}

/// The dynamic figures of what is pressed or slid.
mod pressed {
    use super::KARNOPP;
    use crate::figure::{FigureKind, define_figures};

    const PAPER: &str = "equation 1 of Swindells and MacLean 2007, along a line";

    define_figures! {
        INERTIA "inertia" "N s²/mm" PAPER "Force per acceleration: the moving mass."
        VISCOUS_NEGATIVE "viscous_negative" "N s/mm" PAPER "Rise of friction with speed on the way back."
        VISCOUS_POSITIVE "viscous_positive" "N s/mm" PAPER "Rise of friction with speed on the way in."
        STATIC_NEGATIVE "static_negative" "N" KARNOPP "Force at which the control breaks away from rest on the way back."
        STATIC_POSITIVE "static_positive" "N" KARNOPP "Force at which the control breaks away from rest on the way in."
    }
}

/// The dynamic figures of an axis, in the order of the sheet.
pub(crate) fn kinds_of(axis: Axis) -> &'static [&'static FigureKind] {
    match axis {
        Axis::Rotary => turned::KINDS,
        Axis::Linear => pressed::KINDS,
    }
}

impl Sheet {
    /// The sheet with the dynamic figures of the same part, from the fit of one capture of it at speed or the mean of several.
    ///
    /// # Errors
    /// [`SheetError::TwoAxes`] for a fit of the other axis.
    pub fn with_dynamics(mut self, fit: &Fit) -> Result<Self, SheetError> {
        if fit.axis != self.axis {
            return Err(SheetError::TwoAxes);
        }
        let figures = kinds_of(self.axis).iter().map(|kind| (kind.name, dynamic(kind, fit.parameters.get(kind.name))));
        self.figures.extend(figures);
        Ok(self)
    }
}

fn dynamic(kind: &'static FigureKind, parameter: Option<&Parameter>) -> Figure {
    let reason =
        || parameter.and_then(|parameter| parameter.reason.clone()).unwrap_or_else(|| "it was not fitted".to_owned());
    let Some((value, [low, high])) = parameter.and_then(|parameter| parameter.value.zip(parameter.ci95)) else {
        return Figure::undetermined(kind, reason());
    };
    let estimate = Estimate { value, standard_error: 0.5 * (high - low) / NORMAL_95 };
    // The fit's own interval, which need not lie evenly about the value.
    Figure { ci95: Some([low, high]), ..Figure::estimated(kind, estimate, f64::INFINITY) }
}
