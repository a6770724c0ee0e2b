//! Draws what is pressed or slid in space: a rail with a scale in mm, a body that moves along it, the detents beside it.
//!
//! The travel's range is fitted to the rail, and changes as a plot's axis does.

use dynamics::Axis as MotionAxis;
use rerun::components::FillMode;
use rerun::{Boxes3D, RecordingStream, RecordingStreamResult, TimeColumn, Transform3D};

use crate::drawing::TIMELINE;
use crate::entities::KNOB;
use crate::extent;
use crate::knob_drawing::{color, draw_detents, label};
use crate::knob_track::{DetentRing, KnobUpdate, Motion};
use crate::palette::NEUTRAL;
use crate::plot_axes::Axis;
use crate::strokes::{labels, lines, scaled, single};

const HALF_RAIL: f64 = 1.2;
/// Where the line of detents lies where their force is nothing.
const DETENTS_Y: f64 = 0.45;

/// A slider, and what of it was drawn.
#[derive(Debug, Default)]
pub struct Slider {
    /// The travel that the rail shows, mm.
    scale: Option<Axis>,
    motion: Option<Motion>,
    detents: Option<DetentRing>,
}

impl Slider {
    /// Draws what is new at the recording's current time; travels have times of their own.
    pub fn draw(&mut self, recording: &RecordingStream, update: &KnobUpdate) -> anyhow::Result<()> {
        let travels = &update.turns.values;
        let shown = self.scale.into_iter().flat_map(|scale| [scale.low, scale.high]);
        let Some(range) = extent::of(travels.iter().copied().chain(shown)) else { return Ok(()) };
        let scale = Axis::following(self.scale, range);
        let rescaled = self.scale != Some(scale);
        let redrawn = rescaled || update.motion.is_some() || update.detents.is_some();
        self.motion = update.motion.or(self.motion);
        self.detents = update.detents.clone().or_else(|| self.detents.take());
        if rescaled {
            draw_rail(recording, &scale)?;
        }
        if redrawn && let Some(motion) = self.motion {
            // The body in the colour of its motion, which is also written over it.
            let half_mm = single(0.13 / units_in_mm(&scale));
            let body = Boxes3D::from_centers_and_half_sizes([[0.0, 0.0, 0.15]], [[half_mm, 0.24, 0.15]])
                .with_colors([color(motion)])
                .with_fill_mode(FillMode::Solid);
            recording.log(format!("{KNOB}/travel/moving/body"), &body)?;
            recording.log(format!("{KNOB}/motion"), &label([0.0, 1.0, 0.0], motion.word().to_owned()))?;
        }
        if redrawn && let Some(ring) = &self.detents {
            let at = |travel, depth| {
                let is_on_rail = (scale.low..=scale.high).contains(&travel);
                is_on_rail.then(|| [single(place(&scale, travel)), single(DETENTS_Y - depth), 0.0])
            };
            draw_detents(recording, MotionAxis::Linear, ring, at)?;
        }
        self.scale = Some(scale);
        if !travels.is_empty() {
            let times = TimeColumn::new_duration_nanos(TIMELINE, update.turns.times_ns.iter().copied());
            let places = travels.iter().map(|travel| [single(*travel), 0.0, 0.0]);
            let moved = Transform3D::update_fields().with_many_translation(places);
            recording.send_columns(format!("{KNOB}/travel/moving"), [times], moved.columns_of_unit_batches()?)?;
        }
        Ok(())
    }
}

fn units_in_mm(scale: &Axis) -> f64 {
    2.0 * HALF_RAIL / scale.span()
}

/// Where a travel lies on the rail.
fn place(scale: &Axis, travel_mm: f64) -> f64 {
    (travel_mm - scale.low) * units_in_mm(scale) - HALF_RAIL
}

/// Like the plots' axes the rail belongs to no time, and what moves on it stays in mm: when the range changes, only this does.
fn draw_rail(recording: &RecordingStream, scale: &Axis) -> RecordingStreamResult<()> {
    let at = |travel_mm: f64, y: f64| [single(place(scale, travel_mm)), single(y), 0.0];
    let ticks = scale.ticks();
    let rail = vec![at(scale.low, 0.0), at(scale.high, 0.0)];
    let strips = ticks.iter().map(|(travel_mm, _)| vec![at(*travel_mm, -0.3), at(*travel_mm, -0.36)]);
    recording.log_static(format!("{KNOB}/rail"), &lines(std::iter::once(rail).chain(strips), NEUTRAL, 0.9))?;
    let (places, texts): (Vec<_>, Vec<_>) =
        ticks.into_iter().map(|(travel_mm, label)| (at(travel_mm, -0.5), format!("{label} mm"))).unzip();
    recording.log_static(format!("{KNOB}/rail/labels"), &labels(places, texts))?;
    let in_mm = scaled([units_in_mm(scale), 1.0], [place(scale, 0.0), 0.0]);
    recording.log_static(format!("{KNOB}/travel"), &in_mm)
}
