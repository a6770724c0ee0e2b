//! Intended and captured torque, as plots.

use identification::Point;
use maud::{Markup, html};

use super::RenderingPage;
use crate::figures::{Figure, Mark, angle_plot, finite_points, residual_plot, velocity_plot};
use crate::page::FEWEST_ROWS;
use crate::plot::ink::Ink;

const LEGEND: [(Mark, Ink, &str); 4] = [
    (Mark::Dots, Ink::MeasuredPositive, "captured turning positively"),
    (Mark::Line, Ink::ModelPositive, "intended"),
    (Mark::Dots, Ink::MeasuredNegative, "captured turning negatively"),
    (Mark::Line, Ink::ModelNegative, "intended"),
];
const ERROR: &str = "torque error (mNm)";

pub(super) fn section(page: &RenderingPage<'_>) -> Markup {
    let points = points(page);
    if points.len() < FEWEST_ROWS {
        return html! { p { "Too few rows of sliding motion for plots." } };
    }
    let has_detents = page.rendering.parameters.iter().any(|parameter| parameter.name == "detent_period");
    let angle = Figure {
        title: "Torque against angle".to_owned(),
        legend: LEGEND.to_vec(),
        plot: angle_plot(&points, has_detents),
        caption: "Dots: what the hand felt, filtered to the fit’s band. Lines: what the intended model asks for in the same motion, \
                  averaged at each angle. From both is taken what the intended inertia asks for, so that detents and friction \
                  show; an inertia of another size would spread the dots. They spread a little because viscous friction asks for \
                  different torques at one angle."
            .to_owned(),
    };
    let velocity = Figure {
        title: "Torque against velocity".to_owned(),
        legend: LEGEND.to_vec(),
        plot: velocity_plot(&points),
        caption: "The same over the velocity: the step at zero is Coulomb friction, the slope viscous friction; the detents spread \
                  the dots."
            .to_owned(),
    };
    let error = Figure {
        title: "Torque error over time".to_owned(),
        legend: vec![(Mark::Band, Ink::Residual, "captured minus intended"), (Mark::Line, Ink::Reference, "± RMS")],
        plot: residual_plot(&points, page.rendering.torque_error_rms_mnm, ERROR).svg("Torque error over time"),
        caption: "An even strip is noise. What comes back with certain angles or speeds is the rendering’s.".to_owned(),
    };
    html! {
        (angle.numbered(1))
        (velocity.numbered(2))
        (error.numbered(3))
    }
}

/// The rows of the capture with the intended model in place of the fitted one.
///
/// Both torques are without that of the intended inertia. The captured torque of a row, a mean over samples, is the fitted model's plus the residual.
fn points(page: &RenderingPage<'_>) -> Vec<Point> {
    let fitted = page.fit.model(&page.intended.name);
    finite_points(page.fit)
        .into_iter()
        .map(|point| {
            let motion = point.motion();
            let inertial_mnm = page.intended.inertia() * motion.acceleration_rad_s2;
            let captured_mnm = fitted.torque_mnm(&motion) + point.residual_mnm - inertial_mnm;
            let intended_mnm = page.intended.torque_mnm(&motion) - inertial_mnm;
            Point {
                torque_mnm: captured_mnm,
                torque_model_mnm: intended_mnm,
                torque_model_ci95_mnm: 0.0,
                residual_mnm: captured_mnm - intended_mnm,
                ..point
            }
        })
        .filter(|point| point.residual_mnm.is_finite())
        .collect()
}
