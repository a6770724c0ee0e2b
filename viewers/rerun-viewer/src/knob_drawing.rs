//! Draws the knob in space: a dial, a body with a pointer that turns, the ring of detents around it.
//!
//! Lengths are in radii of the dial. Angle zero points away from the onlooker; positive angles turn
//! counter-clockwise, seen from above.

use dynamics::Axis;
use rerun::components::{FillMode, RotationAxisAngle};
use rerun::datatypes::Rgba32;
use rerun::{Angle, Boxes3D, Cylinders3D, Points3D, RecordingStream, RecordingStreamResult, TimeColumn, Transform3D};

use crate::drawing::TIMELINE;
use crate::entities::KNOB;
use crate::knob_track::{DetentRing, KnobUpdate, Motion};
use crate::numbers::three_figures;
use crate::palette::{MODEL, NEGATIVE, NEUTRAL, POSITIVE, STICKING, WHITE};
use crate::plot_axes::round_step;
use crate::strokes::{dots, labels, lines, single};

const BODY_RADIUS: f64 = 0.5;
/// Height of the knob's body over the dial.
const BODY_HEIGHT: f64 = 0.34;
/// Radius of the ring of detents where the detent torque is nothing.
const RING_RADIUS: f64 = 0.8;
/// Depth of a detent whose torque is a whole step of its scale.
const FULL_DEPTH: f64 = 0.13;

/// Draws what never changes.
pub fn draw_dial(recording: &RecordingStream) -> RecordingStreamResult<()> {
    let circle = |radius: f64| -> Vec<[f32; 3]> {
        (0..=180).map(|step| place(f64::from(step).to_radians() * 2.0, radius, 0.0)).collect()
    };
    let tenths = (-31..=31).map(|tenth| {
        let length = if tenth % 5 == 0 { 0.09 } else { 0.04 };
        let angle = f64::from(tenth) / 10.0;
        vec![place(angle, 1.0, 0.0), place(angle, 1.0 + length, 0.0)]
    });
    let dial = std::iter::once(circle(1.0)).chain(tenths);
    recording.log_static(format!("{KNOB}/dial"), &lines(dial, NEUTRAL, 0.9))?;
    let label = |rad: i32| (place(f64::from(rad), 1.2, 0.0), format!("{rad} rad").replace('-', "\u{2212}"));
    let (places, texts): (Vec<_>, Vec<_>) = (-3..=3).map(label).unzip();
    recording.log_static(format!("{KNOB}/dial/labels"), &labels(places, texts))?;
    // The pointer: one part on the body, one from the body to the ring.
    let (middle, half) = (0.5 * (BODY_RADIUS + RING_RADIUS), 0.5 * (RING_RADIUS - BODY_RADIUS));
    let centers = [[0.0, 0.55 * BODY_RADIUS, BODY_HEIGHT], [0.0, middle, 0.02]].map(|center| center.map(single));
    let half_sizes = [[0.045, 0.45 * BODY_RADIUS, 0.03], [0.012, half, 0.012]].map(|size| size.map(single));
    let pointer = Boxes3D::from_centers_and_half_sizes(centers, half_sizes);
    let pointer = pointer.with_colors([WHITE]).with_fill_mode(FillMode::Solid);
    recording.log_static(format!("{KNOB}/turning/pointer"), &pointer)?;
    recording.log_static(format!("{KNOB}/no_detents"), &lines([circle(RING_RADIUS)], NEUTRAL, 0.6))
}

/// Draws what is new at the recording's current time; angles have times of their own.
pub fn draw(recording: &RecordingStream, update: &KnobUpdate) -> anyhow::Result<()> {
    if !update.turns.times_ns.is_empty() {
        let times = TimeColumn::new_duration_nanos(TIMELINE, update.turns.times_ns.iter().copied());
        let turns = update.turns.values.iter().map(|angle| {
            let within_a_turn = angle.rem_euclid(std::f64::consts::TAU);
            RotationAxisAngle::new([0.0, 0.0, 1.0], Angle::from_radians(single(within_a_turn)))
        });
        let turned = Transform3D::update_fields().with_many_rotation_axis_angle(turns);
        recording.send_columns(format!("{KNOB}/turning"), [times], turned.columns_of_unit_batches()?)?;
    }
    if let Some(motion) = update.motion {
        // The body in the colour of its motion, which is also written over it.
        let body = Cylinders3D::from_lengths_and_radii([single(BODY_HEIGHT)], [single(BODY_RADIUS)])
            .with_centers([[0.0, 0.0, single(BODY_HEIGHT / 2.0)]])
            .with_colors([color(motion)])
            .with_fill_mode(FillMode::Solid);
        recording.log(format!("{KNOB}/turning/body"), &body)?;
        recording.log(format!("{KNOB}/motion"), &label([0.0, 1.55, 0.0], motion.word().to_owned()))?;
    }
    if let Some(ring) = &update.detents {
        let at = |angle, depth| Some(place(angle, RING_RADIUS - depth, 0.0));
        draw_detents(recording, Axis::Rotary, ring, at)?;
    }
    Ok(())
}

pub(crate) const fn color(motion: Motion) -> Rgba32 {
    match motion {
        Motion::Sticking => STICKING,
        Motion::SlippingPositive => POSITIVE,
        Motion::SlippingNegative => NEGATIVE,
    }
}

/// Draws the line of the detents, their places of rest, and a label with their depth and spacing. `at` maps an angle and a depth to
/// a place; what it maps to `None` is not drawn. Like the plots' axes, the detents belong to no time, so that a page that is opened
/// late has them first.
pub(crate) fn draw_detents(
    recording: &RecordingStream,
    axis: Axis,
    ring: &DetentRing,
    at: impl Fn(f64, f64) -> Option<[f32; 3]>,
) -> RecordingStreamResult<()> {
    let deepest = FULL_DEPTH * ring.amplitude_mnm / round_step(ring.amplitude_mnm);
    let (line, label_y) = if axis.is_rotary() { ("ring", -1.5) } else { ("line", -0.9) };
    let outline: Vec<_> = ring.depths.iter().filter_map(|[angle, share]| at(*angle, deepest * share)).collect();
    recording.log_static(format!("{KNOB}/detents/{line}"), &lines([outline], MODEL, 1.8))?;
    let rests = ring.stable_rad.iter().filter_map(|angle| at(*angle, deepest));
    recording.log_static(format!("{KNOB}/detents/stable"), &dots(rests, MODEL, 3.5))?;
    let [deep, apart] = [ring.amplitude_mnm, ring.spacing_rad].map(three_figures);
    let words = format!("detents: {deep} mNm deep, {apart} rad apart");
    let text = label([0.0, label_y, 0.0], axis.words(&words).into_owned());
    recording.log_static(format!("{KNOB}/detents/label"), &text)
}

pub(crate) fn label(place: [f64; 3], text: String) -> Points3D {
    labels([place.map(single)], [text])
}

/// Where an angle lies at some radius and height.
fn place(angle_rad: f64, radius: f64, height: f64) -> [f32; 3] {
    let (sine, cosine) = angle_rad.sin_cos();
    [single(-radius * sine), single(radius * cosine), single(height)]
}
