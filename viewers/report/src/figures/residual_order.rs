//! The residual by its order: how much of it repeats so many times per turn.

use std::f64::consts::TAU;

use dynamics::effects;
use identification::{Fit, Point};

use super::{Figure, HALF, Mark, Numbers, real, thinned, travel_rad};
use crate::numbers::{three, two};
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Rows from which the spectrum is made.
const MOST_ROWS: usize = 8000;
/// Orders that are tried.
const MOST_ORDERS: usize = 1200;
/// Orders tried per resolution of the travel.
const OVERSAMPLING: f64 = 4.0;
/// Resolutions that the spectrum spans if there are no detents to set its end.
const RESOLUTIONS: f64 = 60.0;
/// Harmonics of the detents that the spectrum reaches.
const HARMONICS: u32 = 3;

/// Amplitude of the residual against its order, with the detents' orders marked.
pub(crate) fn order_figure(fit: &Fit, points: &[Point]) -> (Figure, Numbers) {
    let rows = thinned(points.iter(), MOST_ROWS);
    let travel = travel_rad(points).max(f64::MIN_POSITIVE);
    let resolution = TAU / travel;
    let detents_per_turn = fit
        .parameters
        .get(effects::detent::KIND.parameters[1].name)
        .and_then(|period| period.value)
        .map(|period_rad| 1.0 / period_rad.abs());
    let highest = detents_per_turn.map_or(RESOLUTIONS * resolution, |detents| (f64::from(HARMONICS) + 0.4) * detents);
    let step = (resolution / OVERSAMPLING).max(highest / real(MOST_ORDERS));
    // Below one cycle within the travel, an order is a trend.
    let orders =
        (0..=MOST_ORDERS).map(|index| 0.5 * resolution + real(index) * step).take_while(|order| *order <= highest);
    let spectrum: Vec<(f64, f64)> = orders.map(|order| (order, amplitude_mnm(&rows, order))).collect();
    let tallest = spectrum.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    let mut layers = Vec::new();
    if let Some(detents) = detents_per_turn {
        layers.extend((1..=HARMONICS).map(|harmonic| {
            let word = if harmonic == 1 { "detents".to_owned() } else { format!("{harmonic}×") };
            Layer::Place(Ink::Reference, f64::from(harmonic) * detents, word)
        }));
    }
    layers.push(Layer::Line(Ink::Residual, spectrum));
    let plot = Plot {
        size: HALF,
        x: Axis::exactly("order (cycles per turn)", 0.0, highest),
        y: Axis::exactly("amplitude (mNm)", 0.0, 1.08 * tallest.1.max(1e-9)),
        layers,
    };
    let figure = Figure {
        title: "Residual by order".to_owned(),
        legend: vec![(Mark::Line, Ink::Residual, "amplitude of the residual")],
        plot: plot.svg("Amplitude of the residual against its order"),
        caption: format!(
            "A peak is a torque that repeats with the angle and is not in the model: an off-centre mass at one per turn, \
             cogging, or detents that are no sine. The tallest has {} mNm at {} per turn; orders closer than {} cannot be \
             resolved over this travel.",
            two(tallest.1),
            three(tallest.0),
            two(resolution)
        ),
    };
    let numbers =
        [("tallest_amplitude_mnm", tallest.1), ("tallest_per_turn", tallest.0), ("resolution_per_turn", resolution)];
    (figure, numbers.into())
}

fn amplitude_mnm(rows: &[&Point], order: f64) -> f64 {
    let (sine, cosine) = rows.iter().fold((0.0, 0.0), |(sine, cosine), point| {
        let (s, c) = (order * point.angle_rad).sin_cos();
        (sine + s * point.residual_mnm, cosine + c * point.residual_mnm)
    });
    2.0 * f64::hypot(sine, cosine) / real(rows.len().max(1))
}
