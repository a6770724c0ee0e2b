//! What the control's inertia does to a slow turn: between detents its speed swings, and the torque has inertia times acceleration in it.

use archive::testers::Curve;

/// Share of a pitch over which the acceleration is taken.
const WINDOW: f64 = 1.0 / 24.0;
/// Share of what differs between the directions that the inertia must explain to be believed.
const EXPLAINED: f64 = 0.25;
/// Fewest cells that both directions pass.
const FEWEST_CELLS: usize = 100;

/// The curve without inertia times acceleration; as it is where time, or what the directions differ by, tells no inertia.
///
/// The torque of the detents is the same in both directions, and friction differs from it by a constant; the accelerations differ, and what
/// goes with them is the inertia, by least squares over cells of the angle.
pub(super) fn without_inertia(curve: &Curve, directions: &[i8], pitch: f64, cell: f64) -> Curve {
    let taken = || {
        let acceleration = accelerations(curve, pitch)?;
        let inertia = inertia(curve, directions, &acceleration, cell)?;
        let load = curve.load.iter().zip(&acceleration).map(|(load, acceleration)| load - inertia * acceleration);
        Some(Curve { load: load.collect(), ..curve.clone() })
    };
    taken().unwrap_or_else(|| curve.clone())
}

/// Second derivative of the angle at every row, by a parabola through the rows about it, rad/s².
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number of rows"
)]
fn accelerations(curve: &Curve, pitch: f64) -> Option<Vec<f64>> {
    let t_s = curve.t_s.as_ref()?;
    let rows = curve.len();
    let duration_s = t_s.last()? - t_s.first()?;
    let way: f64 = curve.position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
    let step_s = duration_s / (rows - 1) as f64;
    let half = (0.5 * WINDOW * pitch / way * rows as f64).round() as usize;
    if !(step_s > 0.0 && half >= 2 && 4 * half < rows) {
        return None;
    }
    // The parabola's weights: orthogonal to constant and slope.
    let places = (0..=2 * half).map(|place| place as f64 - half as f64);
    let mean_square = places.clone().map(|place| place * place).sum::<f64>() / (2 * half + 1) as f64;
    let weights: Vec<f64> = places.clone().map(|place| place * place - mean_square).collect();
    let scale: f64 = weights.iter().zip(places).map(|(weight, place)| weight * place * place).sum::<f64>() * 0.5;
    let mut accelerations = vec![0.0; rows];
    for (row, window) in curve.position.windows(2 * half + 1).enumerate() {
        let sum: f64 = window.iter().zip(&weights).map(|(angle, weight)| weight * (angle - window[half])).sum();
        accelerations[row + half] = sum / (scale * step_s * step_s);
    }
    Some(accelerations)
}

/// Torque over acceleration, as what differs between the directions has it.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "a number of cells")]
fn inertia(curve: &Curve, directions: &[i8], accelerations: &[f64], cell: f64) -> Option<f64> {
    let mut cells: std::collections::BTreeMap<i64, [[f64; 3]; 2]> = std::collections::BTreeMap::new();
    let rows = curve.position.iter().zip(&curve.load).zip(accelerations).zip(directions);
    for (((angle, load), acceleration), direction) in rows.filter(|(_, direction)| **direction != 0) {
        let [loads, sums, count] =
            &mut cells.entry((angle / cell).floor() as i64).or_default()[usize::from(*direction > 0)];
        (*loads, *sums, *count) = (*loads + load, *sums + acceleration, *count + 1.0);
    }
    let differences: Vec<[f64; 2]> = cells
        .values()
        .filter(|sides| sides.iter().all(|[.., count]| *count > 0.0))
        .map(|[back, there]| [0, 1].map(|column| there[column] / there[2] - back[column] / back[2]))
        .collect();
    if differences.len() < FEWEST_CELLS {
        return None;
    }
    let count = differences.len() as f64;
    let mean = [0, 1].map(|column| differences.iter().map(|pair| pair[column]).sum::<f64>() / count);
    let product = |one: usize, other: usize| {
        differences.iter().map(|pair| (pair[one] - mean[one]) * (pair[other] - mean[other])).sum::<f64>()
    };
    let (loads, both, accelerations) = (product(0, 0), product(0, 1), product(1, 1));
    let inertia = both / accelerations;
    (inertia > 0.0 && inertia * both > EXPLAINED * loads).then_some(inertia)
}
