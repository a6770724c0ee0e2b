//! The estimate from one capture: a vector of parameters with its covariance.
//!
//! A capture determines a detent's argument θ/P + S best at its mean angle. Where that angle is not zero, the errors of the phase S
//! at angle zero and of the period P are correlated. So phases are compared and combined at the mean angle of all captures, on the
//! circle, and taken back to angle zero with the combined period.

use nalgebra::DMatrix;

use super::scalar::Estimated;
use crate::estimate::{Fit, Parameter};
use crate::numerics::statistics::{NORMAL_95, mean_angle, nearest_turn};

pub(super) const PHASE: &str = "detent_phase";
pub(super) const PERIOD: &str = "detent_period";

/// Index of a name in a list of names; `None` if it is not there.
pub(super) fn position(names: &[&'static str], name: &str) -> Option<usize> {
    names.iter().position(|known| *known == name)
}

/// The parameters estimated from a capture, in the order of its fit.
#[derive(Clone, Debug)]
pub(super) struct Observation {
    pub(super) names: Vec<&'static str>,
    pub(super) values: Vec<f64>,
    /// Covariance, enlarged so that 1.96 standard deviations are the fit's own half widths.
    pub(super) covariance: DMatrix<f64>,
    /// Whether each parameter's covariance comes from the fit; otherwise its variance comes from its interval alone.
    pub(super) joint: Vec<bool>,
    /// Degrees of freedom with which the variances are known.
    pub(super) degrees_of_freedom: f64,
}

impl Observation {
    /// All estimates of a fit. A parameter outside its covariance (held at zero, or read off the capture) counts as uncorrelated.
    pub(super) fn of(fit: &Fit) -> Self {
        let estimated: Vec<(&Parameter, f64)> =
            fit.parameters.0.iter().filter_map(|parameter| Some((parameter, parameter.value?))).collect();
        let half_width = |parameter: &Parameter| parameter.half_width().unwrap_or(0.0);
        let known = &fit.covariance;
        let places: Vec<Option<usize>> = estimated
            .iter()
            .map(|(parameter, _)| position(&known.order, parameter.name).filter(|at| known.rows[*at][*at] > 0.0))
            .collect();
        // Student's quantile differs from parameter to parameter.
        let scales: Vec<f64> = estimated
            .iter()
            .zip(&places)
            .map(|((parameter, _), place)| {
                place.map_or(1.0, |at| half_width(parameter) / NORMAL_95 / known.rows[at][at].sqrt())
            })
            .collect();
        let covariance =
            DMatrix::from_fn(estimated.len(), estimated.len(), |row, column| match (places[row], places[column]) {
                (Some(a), Some(b)) => scales[row] * scales[column] * known.rows[a][b],
                _ if row == column => (half_width(estimated[row].0) / NORMAL_95).powi(2),
                _ => 0.0,
            });
        Self {
            names: estimated.iter().map(|(parameter, _)| parameter.name).collect(),
            values: estimated.iter().map(|(_, value)| *value).collect(),
            covariance,
            joint: places.iter().map(Option::is_some).collect(),
            degrees_of_freedom: known.degrees_of_freedom,
        }
    }

    /// Moves by `by_rad` the angle at which the detents' phase is given; returns the new phase and its weight, one over its variance.
    ///
    /// S + θ/P has the derivative −θ/P² by P, by which the covariance is transformed.
    fn move_phase(&mut self, by_rad: f64) -> Option<(f64, f64)> {
        let phase = position(&self.names, PHASE)?;
        if let Some(period) = position(&self.names, PERIOD) {
            let period_rad = self.values[period];
            self.values[phase] += by_rad / period_rad;
            let mut turn = DMatrix::identity(self.names.len(), self.names.len());
            turn[(phase, period)] = -by_rad / (period_rad * period_rad);
            self.covariance = &turn * &self.covariance * turn.transpose();
        }
        Some((self.values[phase], 1.0 / self.covariance[(phase, phase)].max(1e-18)))
    }

    /// Converts the phase from angle `angle_rad` to angle zero and wraps it into (−π, π].
    pub(super) fn back_to_zero(&mut self, angle_rad: f64) {
        self.move_phase(-angle_rad);
        if let Some(at) = position(&self.names, PHASE) {
            self.values[at] = nearest_turn(self.values[at], 0.0);
        }
    }

    /// A parameter's value with the half width of its interval; `None` if the capture did not estimate it.
    pub(super) fn estimate(&self, name: &str) -> Option<Estimated> {
        let at = position(&self.names, name)?;
        let half_width = NORMAL_95 * self.covariance[(at, at)].max(0.0).sqrt();
        Some(Estimated { value: self.values[at], half_width })
    }
}

/// Converts every capture's phase from angle zero to `angle_rad`, and puts all phases within half a turn of their mean.
pub(super) fn to_angle(observations: &mut [Observation], angle_rad: f64) {
    let centre_rad = mean_angle(observations.iter_mut().filter_map(|observation| observation.move_phase(angle_rad)));
    for observation in observations {
        let Some(at) = position(&observation.names, PHASE) else { continue };
        observation.values[at] = nearest_turn(observation.values[at], centre_rad);
    }
}
