//! Draws frames into a rerun recording.

use dynamics::Axis;
use rerun::{BarChart, RecordingStream, RecordingStreamResult, Scalars, TextDocument, TimeCell, TimeColumn};
use shared_types::LATENESS_BIN_EDGES_NS;

use crate::entities;
use crate::frame::{Frame, Points};
use crate::palette::MEASURED;
use crate::plot_drawing::DrawnAxes;
use crate::slider_drawing::Slider;
use crate::{knob_drawing, plot_drawing, series_styles};

/// Time since the start of the run: the only timeline.
pub const TIMELINE: &str = "time_s";

/// Draws one run into one recording.
pub struct Pen {
    pub recording: RecordingStream,
    axis: Axis,
    plots: DrawnAxes,
    /// What moves along a line; `None` for what turns.
    slider: Option<Slider>,
}

impl Pen {
    pub fn new(recording: RecordingStream, axis: Axis) -> RecordingStreamResult<Self> {
        recording.set_log_tick_enabled(false);
        recording.set_log_time_enabled(false);
        series_styles::draw(&recording, axis)?;
        if axis.is_rotary() {
            knob_drawing::draw_dial(&recording)?;
        }
        let slider = (!axis.is_rotary()).then(Slider::default);
        Ok(Self { recording, axis, plots: DrawnAxes::new(), slider })
    }

    pub fn draw(&mut self, frame: &Frame) -> anyhow::Result<()> {
        let Self { recording, axis, plots, slider } = self;
        for (entity, Points { times_ns, values }) in &frame.series {
            let times = TimeColumn::new_duration_nanos(TIMELINE, times_ns.iter().copied());
            let at_a_time = times_ns.iter().map(|_| values.len() / times_ns.len());
            let values = Scalars::new(values.iter().copied()).columns(at_a_time)?;
            recording.send_columns(axis.words(entity).as_ref(), [times], values)?;
        }
        recording.set_time(TIMELINE, TimeCell::from_duration_nanos(frame.time_ns));
        for plot in &frame.plots {
            plot_drawing::draw(recording, *axis, plots, plot)?;
        }
        if let Some(counts) = &frame.lateness {
            draw_histogram(recording, counts)?;
        }
        if let Some(knob) = &frame.knob {
            match slider {
                Some(slider) => slider.draw(recording, knob)?,
                None => knob_drawing::draw(recording, knob)?,
            }
        }
        for (entity, text) in &frame.texts {
            recording.log(*entity, &TextDocument::from_markdown(text.as_str()))?;
        }
        Ok(())
    }
}

fn draw_histogram(recording: &RecordingStream, counts: &[u64; 12]) -> RecordingStreamResult<()> {
    // A bar for each bin, at the middle of its edges; the outer two are half a decade wide.
    let edges: Vec<f64> = LATENESS_BIN_EDGES_NS.iter().map(|edge| (*edge as f64).log10()).collect();
    let lower = edges.first().map(|first| first - 0.5).into_iter().chain(edges.iter().copied());
    let upper = edges.iter().copied().chain(edges.last().map(|last| last + 0.5));
    let (middles, widths): (Vec<f64>, Vec<f32>) =
        lower.zip(upper).map(|(low, high)| (f64::midpoint(low, high), (high - low) as f32 * 0.92)).unzip();
    let heights: Vec<f64> = counts.iter().map(|count| (*count as f64).ln_1p() / std::f64::consts::LN_10).collect();
    recording.log(
        entities::LATENESS_HISTOGRAM,
        &BarChart::new(heights).with_abscissa(middles).with_widths(widths).with_color(MEASURED),
    )
}
