//! Original and measured signals, and what lies between them.

use maud::{Markup, html};

use super::input::{ChannelDifference, ChannelTrace, RigTest};
use crate::figures::{HALF, TIME, real};
use crate::numbers::two;
use crate::page::uppercase_first;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Length of the sweep's end that is shown, s: where it is fastest in every reading of it.
const EXCERPT_S: f64 = 0.5;
/// Periods of the tone that are shown.
const PERIODS: f64 = 2.0;
/// Points of a line, and columns of a strip.
const POINTS: usize = 900;
const COLUMNS: usize = 400;

/// Each channel over the end of the sweep, beside the difference over all of it.
pub(super) fn sweep(test: &RigTest, number: usize) -> Markup {
    let shown = test.traces.iter().zip(&test.differences);
    html! {
        figure.pairs {
            h3 { span.number { "Figure " (number) " " } "Original and measured signals under the sweep" }
            (legend(&[("line measured", "measured"), ("line model", "original"), ("band residual", "original minus measured"),
                ("line reference", "mean ± SD")]))
            @for (trace, difference) in shown {
                div.halves {
                    (overlay(trace, &trace.sweep, EXCERPT_S, "at the sweep’s end"))
                    (strip(trace, difference))
                }
            }
            figcaption {
                "Left: the last " (two(EXCERPT_S)) " s. The thin line is the command, the thick pale one behind it the measurement; \
                 where they part the rig is late or falls short. Right: the range of their difference over the whole sweep. A strip \
                 that widens as the sweep gets faster is lag; one of even width is noise; one that lies off zero is a wrong zero; levels that \
                 change sign as the signal turns are friction between motor and sensor."
            }
        }
    }
}

/// Each channel over two periods of the tone.
pub(super) fn tone(test: &RigTest, number: usize) -> Markup {
    html! {
        figure.pairs {
            h3 { span.number { "Figure " (number) " " } "The same at " (two(test.lag_hz)) " Hz" }
            (legend(&[("line measured", "measured"), ("line model", "original")]))
            div.halves {
                @for trace in &test.traces {
                    (overlay(trace, &trace.tone, PERIODS / test.lag_hz, "at one frequency"))
                }
            }
            figcaption {
                "Two periods. The distance along the time axis is the lag of the table, the height of the thick line \
                 beside that of the thin one the gain; what roughens the thick line is the channel’s noise."
            }
        }
    }
}

fn legend(entries: &[(&str, &str)]) -> Markup {
    html! {
        ul.legend { @for (class, words) in entries { li { span class={"key " (class)} {} (words) } } }
    }
}

/// Original upon measured over the last `length_s`.
fn overlay(trace: &ChannelTrace, rows: &[[f64; 3]], length_s: f64, place: &str) -> Markup {
    let end_s = rows.last().map_or(0.0, |row| row[0]);
    let from = rows.partition_point(|row| row[0] < end_s - length_s);
    let shown: Vec<[f64; 3]> =
        rows[from..].iter().step_by((rows.len() - from).div_ceil(POINTS).max(1)).copied().collect();
    let line =
        |column: usize| shown.iter().map(move |row| (row[0], row[column])).filter(|(_, value)| value.is_finite());
    let plot = Plot {
        size: (HALF.0, 210),
        x: Axis::around(TIME, shown.iter().map(|row| row[0])),
        y: Axis::around(&title(trace), line(1).chain(line(2)).map(|(_, value)| value)),
        layers: vec![
            Layer::Level(Ink::Zero, 0.0),
            Layer::Line(Ink::Measured, line(2).collect()),
            Layer::Line(Ink::Model, line(1).collect()),
        ],
    };
    plot.svg(&format!("{} {place}, original and measured", uppercase_first(trace.channel)))
}

/// The range of original minus measured over the whole sweep.
fn strip(trace: &ChannelTrace, difference: &ChannelDifference) -> Markup {
    let rows: Vec<(f64, f64)> =
        trace.sweep.iter().map(|row| (row[0], row[1] - row[2])).filter(|(_, value)| value.is_finite()).collect();
    let columns: Vec<(f64, f64, f64)> = rows
        .chunks(rows.len().div_ceil(COLUMNS).max(1))
        .map(|some| {
            let ends = some.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, value)| {
                (low.min(*value), high.max(*value))
            });
            (some.iter().map(|(at, _)| at).sum::<f64>() / real(some.len()), ends.0, ends.1)
        })
        .collect();
    let ChannelDifference { mean, sd, .. } = difference;
    let plot = Plot {
        size: (HALF.0, 210),
        x: Axis::around(TIME, columns.iter().map(|column| column.0)),
        y: Axis::around(
            &format!("difference ({})", trace.unit),
            columns.iter().flat_map(|(_, low, high)| [*low, *high]).chain([mean - sd, mean + sd]),
        ),
        layers: vec![
            Layer::Level(Ink::Zero, 0.0),
            Layer::Band(Ink::Residual, columns.clone()),
            Layer::Level(Ink::Reference, mean - sd),
            Layer::Level(Ink::Reference, mean + sd),
        ],
    };
    plot.svg(&format!("{}, original minus measured", uppercase_first(trace.channel)))
}

fn title(trace: &ChannelTrace) -> String {
    format!("{} ({})", trace.channel, trace.unit)
}
