//! A short piece of the capture, measured against model.

use identification::{Fit, Point};

use super::{Figure, Mark, Numbers, TIME, TORQUE, WIDE, longest_step_s, rms};
use crate::numbers::{three, two};
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Length of the excerpt, s.
const EXCERPT_S: f64 = 1.5;
/// Distance from one candidate to the next, s.
const STRIDE_S: f64 = 0.25;
/// Share of the best-covered excerpt's rows that a candidate needs.
const COVERAGE: f64 = 0.8;

/// Torque over time in the excerpt whose residual is most like that of the whole capture.
pub(crate) fn excerpt_figure(fit: &Fit, points: &[Point]) -> (Figure, Numbers) {
    let excerpt = typical_excerpt(points, |point| point.t_s, |point| point.residual_mnm);
    let mut layers = vec![Layer::Level(Ink::Zero, 0.0)];
    let longest_s = longest_step_s(points, |point| point.t_s);
    let runs = || excerpt.chunk_by(|a, b| b.t_s - a.t_s <= longest_s);
    for run in runs() {
        layers.push(Layer::Line(Ink::Measured, run.iter().map(|point| (point.t_s, point.torque_mnm)).collect()));
    }
    for run in runs() {
        let edges = |point: &Point| {
            let (torque, half) = (point.torque_model_mnm, point.torque_model_ci95_mnm);
            (point.t_s, torque - half, torque + half)
        };
        layers.push(Layer::Band(Ink::Model, run.iter().map(edges).collect()));
        layers.push(Layer::Line(Ink::Model, run.iter().map(|point| (point.t_s, point.torque_model_mnm)).collect()));
    }
    let both = excerpt.iter().flat_map(|point| [point.torque_mnm, point.torque_model_mnm]);
    let plot = Plot {
        size: WIDE,
        x: Axis::around(TIME, excerpt.iter().map(|p| p.t_s)),
        y: Axis::around(TORQUE, both),
        layers,
    };
    let (start, end) = (excerpt.first().map_or(0.0, |p| p.t_s), excerpt.last().map_or(0.0, |p| p.t_s));
    let residual_rms_mnm = rms(excerpt.iter().map(|point| point.residual_mnm));
    let figure = Figure {
        title: "Torque over time".to_owned(),
        legend: vec![(Mark::Line, Ink::Measured, "measured"), (Mark::Line, Ink::Model, "model")],
        plot: plot.svg("Torque over time, measured and model"),
        caption: format!(
            "{} s from t = {} s, chosen because its residual ({} mNm RMS) is most like that of the whole capture ({} mNm). \
             Gaps are where the knob was too slow to be surely sliding.",
            two(end - start),
            three(start),
            three(residual_rms_mnm),
            three(fit.residual_rms_mnm)
        ),
    };
    (figure, [("start_s", start), ("duration_s", end - start), ("residual_rms_mnm", residual_rms_mnm)].into())
}

/// The excerpt whose residual is most like that of all rows; the rows follow each other in time.
pub(crate) fn typical_excerpt<T>(
    rows: &[T],
    time_s: impl Fn(&T) -> f64,
    residual_mnm: impl Fn(&T) -> f64 + Copy,
) -> &[T] {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return rows };
    let overall = rms(rows.iter().map(residual_mnm));
    let mut candidates = Vec::new();
    let mut start_s = time_s(first);
    while start_s + EXCERPT_S <= time_s(last) {
        let from = rows.partition_point(|row| time_s(row) < start_s);
        let to = rows.partition_point(|row| time_s(row) < start_s + EXCERPT_S);
        candidates.push(&rows[from..to]);
        start_s += STRIDE_S;
    }
    let most = candidates.iter().map(|some| some.len()).max().unwrap_or(0);
    let unlike = |some: &[T]| (rms(some.iter().map(residual_mnm)) - overall).abs();
    candidates
        .into_iter()
        .filter(|some| super::real(some.len()) >= COVERAGE * super::real(most) && !some.is_empty())
        .min_by(|a, b| unlike(a).total_cmp(&unlike(b)))
        .unwrap_or(rows)
}
