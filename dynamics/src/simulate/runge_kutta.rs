//! One step of the fifth-order method of Dormand and Prince, with its error.
//!
//! Source: J. R. Dormand, P. J. Prince, *A family of embedded Runge–Kutta formulae*, Journal of Computational and
//! Applied Mathematics 6 (1980) 19–26.

/// Angle and velocity of what friction acts on, then of the cap before it; rad and rad/s.
pub(super) type Place = [f64; 4];

/// Error of a step that is permitted in an angle, rad: far below any encoder's step.
const TOLERANCE_RAD: f64 = 1e-10;
/// Error of a step that is permitted in a velocity up to 1 rad/s, rad/s, and relative beyond.
const TOLERANCE_RAD_S: f64 = 1e-8;

const NODES: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Difference of the weights of fifth and fourth order.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Where a step leads.
pub(super) struct Step {
    /// The place at its end.
    pub(super) end: Place,
    /// Its error as a multiple of the tolerance.
    pub(super) error: f64,
}

impl Step {
    /// Factor by which the next step may be longer, or must be shorter.
    pub(super) fn growth(&self) -> f64 {
        if self.error.is_finite() { (0.9 * self.error.max(1e-10).powf(-0.2)).clamp(0.1, 5.0) } else { 0.1 }
    }
}

/// One step from `start_s` on, `rates` being the derivatives of the place at a time.
pub(super) fn dormand_prince(start_s: f64, step_s: f64, from: &Place, rates: impl Fn(f64, &Place) -> Place) -> Step {
    let mut slopes = [[0.0; 4]; 7];
    slopes[0] = rates(start_s, from);
    let mut end = *from;
    for (stage, (node, weights)) in NODES.iter().zip(STAGES).enumerate() {
        end = moved(from, step_s, weights, &slopes);
        slopes[stage + 1] = rates(start_s + node * step_s, &end);
    }
    let off = moved(&[0.0; 4], step_s, &ERROR, &slopes);
    let tolerance = |index: usize| {
        if index.is_multiple_of(2) { TOLERANCE_RAD } else { TOLERANCE_RAD_S * (1.0 + from[index].abs()) }
    };
    let error = (0..4).map(|index| off[index].abs() / tolerance(index)).fold(0.0, |most: f64, each| {
        // f64::max would lose a NaN.
        if each > most || each.is_nan() { each } else { most }
    });
    Step { end, error }
}

fn moved(from: &Place, step_s: f64, weights: &[f64], slopes: &[Place; 7]) -> Place {
    std::array::from_fn(|index| {
        let slope: f64 = weights.iter().zip(slopes).map(|(weight, slope)| weight * slope[index]).sum();
        from[index] + step_s * slope
    })
}
