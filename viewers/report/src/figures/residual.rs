//! What the model leaves over: in time and in size.

use std::f64::consts::TAU;

use identification::{Fit, Point};

use super::{Figure, HALF, Mark, Numbers, RESIDUAL, TIME, WIDE, longest_step_s, real};
use crate::numbers::{Digits, three};
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Columns across the plot over time.
const COLUMNS: f64 = 800.0;
/// Bars of the histogram.
const BARS: usize = 41;
/// Share of its room that a bar leaves free at either side.
const BAR_GAP: f64 = 0.06;
/// Half the width of the histogram, in residual RMS.
const REACH: f64 = 4.0;

/// Residual over the whole capture, as the range that it fills.
pub(crate) fn residual_figure(fit: &Fit, points: &[Point]) -> Figure {
    Figure {
        title: "Residual over time".to_owned(),
        legend: vec![(Mark::Band, Ink::Residual, "measured minus model"), (Mark::Line, Ink::Reference, "± RMS")],
        plot: residual_plot(points, fit.residual_rms_mnm, RESIDUAL).svg("Residual over time"),
        caption:
            "An even strip is noise. Bulges that come with certain angles or speeds, or a width that changes over the \
                  capture, are something that the model does not have."
                .to_owned(),
    }
}

/// The range that the residual fills over time, under the name `title`, with ± `level_mnm`.
pub(crate) fn residual_plot(points: &[Point], level_mnm: f64, title: &str) -> Plot {
    let (start_s, end_s) = (points.first().map_or(0.0, |p| p.t_s), points.last().map_or(1.0, |p| p.t_s));
    let column_s = ((end_s - start_s) / COLUMNS).max(longest_step_s(points, |point| point.t_s));
    let mut columns: Vec<(f64, f64, f64)> = Vec::new();
    for point in points {
        let at = start_s + ((point.t_s - start_s) / column_s).floor() * column_s;
        match columns.last_mut() {
            Some((last, low, high)) if (*last - at).abs() < 0.5 * column_s => {
                *low = low.min(point.residual_mnm);
                *high = high.max(point.residual_mnm);
            }
            _ => columns.push((at, point.residual_mnm, point.residual_mnm)),
        }
    }
    let mut layers: Vec<Layer> = columns
        .chunk_by(|a, b| b.0 - a.0 < 1.5 * column_s)
        .map(|run| Layer::Band(Ink::Residual, run.to_vec()))
        .collect();
    layers.extend([Layer::Level(Ink::Reference, level_mnm), Layer::Level(Ink::Reference, -level_mnm)]);
    Plot {
        size: (WIDE.0, 250),
        x: Axis::around(TIME, [start_s, end_s]),
        y: Axis::around(title, columns.iter().flat_map(|(_, low, high)| [*low, *high])),
        layers,
    }
}

/// How often residuals of each size occur, beside the normal distribution of the same RMS.
pub(crate) fn histogram_figure(fit: &Fit, points: &[Point]) -> (Figure, Numbers) {
    let reach = REACH * fit.residual_rms_mnm;
    let width = 2.0 * reach / real(BARS);
    let mut counts = [0_usize; BARS];
    for point in points {
        let place = (point.residual_mnm + reach) / width;
        if (0.0..real(BARS)).contains(&place) {
            counts[place as usize] += 1;
        }
    }
    let percent = |count: usize| 100.0 * real(count) / real(points.len().max(1));
    let left = |bar: usize| -reach + real(bar) * width;
    let bars: Vec<_> = counts
        .iter()
        .enumerate()
        .map(|(bar, count)| (left(bar) + BAR_GAP * width, left(bar + 1) - BAR_GAP * width, percent(*count)))
        .collect();
    let normal = |at: f64| {
        let deviations = at / fit.residual_rms_mnm;
        100.0 * width / (fit.residual_rms_mnm * TAU.sqrt()) * (-0.5 * deviations * deviations).exp()
    };
    let curve: Vec<_> =
        (0..=160).map(|step| -reach + reach * f64::from(step) / 80.0).map(|at| (at, normal(at))).collect();
    let highest =
        bars.iter().map(|bar| bar.2).chain([normal(0.0)]).filter(|level| level.is_finite()).fold(0.0, f64::max);
    let beyond = percent(points.len() - counts.iter().sum::<usize>());
    let plot = Plot {
        size: HALF,
        x: Axis::exactly(RESIDUAL, -1.01 * reach, 1.01 * reach),
        y: Axis::exactly("share of rows (%)", 0.0, 1.06 * highest.max(1e-6)),
        layers: vec![Layer::Bars(Ink::Residual, bars), Layer::Line(Ink::Reference, curve)],
    };
    let figure = Figure {
        title: "Residual by size".to_owned(),
        legend: vec![
            (Mark::Band, Ink::Residual, "residual"),
            (Mark::Line, Ink::Reference, "normal distribution of the same RMS"),
        ],
        plot: plot.svg("Histogram of the residual"),
        caption: format!(
            "Pure sensor noise follows the curve; heavy tails or two humps do not. {} % of the rows lie beyond ± {} mNm.",
            Digits::significant(beyond, 2).show(beyond),
            three(reach)
        ),
    };
    (figure, [("reach_mnm", reach), ("beyond_percent", beyond)].into())
}
