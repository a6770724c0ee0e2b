//! The step of the encoder, as the angles show it.

/// The least difference of successive angles, if nearly all others are multiples of it; `None` where the encoder shows no steps.
#[must_use]
pub fn encoder_step(angle_rad: &[f64]) -> Option<f64> {
    /// Share of the differences that must be multiples, and how far from one they may be, as a share of the step.
    const MOST: f64 = 0.95;
    const NEAR: f64 = 0.05;
    /// Smaller steps than 10⁻⁶ rad do not matter.
    const LEAST_RAD: f64 = 1e-6;
    let differences: Vec<f64> =
        angle_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > LEAST_RAD).collect();
    let least = differences.iter().copied().reduce(f64::min)?;
    // Over many steps the error of the least one adds up.
    let few = differences.iter().map(|difference| difference / least).filter(|steps| *steps < 10.0);
    let (mut all, mut whole) = (0_u32, 0_u32);
    for steps in few {
        all += 1;
        whole += u32::from((steps - steps.round()).abs() < NEAR);
    }
    (all > 100 && f64::from(whole) > MOST * f64::from(all)).then_some(least)
}
