//! Draws the knob in space: a dial, a body with a pointer that turns, the ring of detents around it.
//!
//! Lengths are in radii of the dial. Angle zero points away from the onlooker; positive angles turn
//! counter-clockwise, seen from above.

use rerun::components::{FillMode, RotationAxisAngle};
use rerun::{
    Angle, Boxes3D, Cylinders3D, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult, TimeColumn,
    Transform3D,
};

use crate::drawing::TIMELINE;
use crate::entities::KNOB;
use crate::knob_track::{DetentRing, KnobUpdate, Motion};
use crate::palette::{MODEL, NEGATIVE, NEUTRAL, POSITIVE, Rgb, STICKING, WHITE};
use crate::plot_axes::round_step;
use crate::summary::three_digits;

/// Radius of the knob's body.
const BODY_RADIUS: f64 = 0.5;
/// Height of the knob's body over the dial.
const BODY_HEIGHT: f64 = 0.34;
/// Radius of the ring of detents where the detent torque is nothing.
const RING_RADIUS: f64 = 0.8;
/// Depth of a detent whose torque is a whole step of its scale.
pub(crate) const FULL_DEPTH: f64 = 0.13;
/// Largest angle that the dial has a label for, rad.
const LAST_LABEL_HALF_RAD: i32 = 6;

/// Draws what never changes.
///
/// # Errors
/// When rerun refuses a part of it.
pub fn draw_dial(recording: &RecordingStream) -> RecordingStreamResult<()> {
    let rim: Vec<[f32; 3]> = (0..=180).map(|step| place(f64::from(step).to_radians() * 2.0, 1.0, 0.0)).collect();
    let tenths = (-31..=31).map(|tenth| {
        let length = if tenth % 5 == 0 { 0.09 } else { 0.04 };
        let angle = f64::from(tenth) / 10.0;
        vec![place(angle, 1.0, 0.0), place(angle, 1.0 + length, 0.0)]
    });
    recording.log_static(
        format!("{KNOB}/dial"),
        &LineStrips3D::new(std::iter::once(rim).chain(tenths))
            .with_colors([NEUTRAL.opaque()])
            .with_radii([Radius::new_ui_points(0.9)]),
    )?;
    let labelled = (-LAST_LABEL_HALF_RAD..=LAST_LABEL_HALF_RAD).filter(|half| half % 2 == 0);
    let (places, labels): (Vec<_>, Vec<_>) = labelled
        .map(|half| (place(f64::from(half) / 2.0, 1.2, 0.0), format!("{} rad", half / 2).replace('-', "\u{2212}")))
        .unzip();
    recording.log_static(
        format!("{KNOB}/dial/labels"),
        &Points3D::new(places)
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([WHITE.opaque()])
            .with_radii([Radius::new_ui_points(0.0)]),
    )?;
    recording.log_static(
        format!("{KNOB}/turning/pointer"),
        &Boxes3D::from_centers_and_half_sizes(
            [
                [0.0, single(0.55 * BODY_RADIUS), single(BODY_HEIGHT)],
                [0.0, single(0.5 * (BODY_RADIUS + RING_RADIUS)), 0.02],
            ],
            [[0.045, single(0.45 * BODY_RADIUS), 0.03], [0.012, single(0.5 * (RING_RADIUS - BODY_RADIUS)), 0.012]],
        )
        .with_colors([WHITE.opaque()])
        .with_fill_mode(FillMode::Solid),
    )?;
    let circle: Vec<[f32; 3]> =
        (0..=180).map(|step| place(f64::from(step).to_radians() * 2.0, RING_RADIUS, 0.0)).collect();
    recording.log_static(
        format!("{KNOB}/no_detents"),
        &LineStrips3D::new([circle]).with_colors([NEUTRAL.opaque()]).with_radii([Radius::new_ui_points(0.6)]),
    )
}

/// Draws what is new at the recording's current time; angles have times of their own.
///
/// # Errors
/// When rerun refuses a part of it.
pub fn draw(recording: &RecordingStream, update: &KnobUpdate) -> anyhow::Result<()> {
    if !update.turns.times_ns.is_empty() {
        let times = TimeColumn::new_duration_nanos(TIMELINE, update.turns.times_ns.iter().copied());
        #[allow(clippy::cast_possible_truncation, reason = "rerun draws in single precision")]
        let turns = update.turns.values.iter().map(|angle| {
            let within_a_turn = angle.rem_euclid(std::f64::consts::TAU);
            RotationAxisAngle::new([0.0, 0.0, 1.0], Angle::from_radians(within_a_turn as f32))
        });
        let turned = Transform3D::update_fields().with_many_rotation_axis_angle(turns);
        recording.send_columns(format!("{KNOB}/turning"), [times], turned.columns_of_unit_batches()?)?;
    }
    if let Some(motion) = update.motion {
        draw_body(recording, motion)?;
    }
    if let Some(ring) = &update.detents {
        draw_detents(recording, ring)?;
    }
    Ok(())
}

/// The body in the colour of its motion, which is also written over it.
fn draw_body(recording: &RecordingStream, motion: Motion) -> RecordingStreamResult<()> {
    let body = Cylinders3D::from_lengths_and_radii([single(BODY_HEIGHT)], [single(BODY_RADIUS)])
        .with_centers([[0.0, 0.0, single(BODY_HEIGHT / 2.0)]])
        .with_colors([color(motion).opaque()])
        .with_fill_mode(FillMode::Solid);
    recording.log(format!("{KNOB}/turning/body"), &body)?;
    recording.log(format!("{KNOB}/motion"), &label([0.0, 1.55, 0.0], motion.word().to_owned()))
}

pub(crate) const fn color(motion: Motion) -> Rgb {
    match motion {
        Motion::Sticking => STICKING,
        Motion::SlippingPositive => POSITIVE,
        Motion::SlippingNegative => NEGATIVE,
    }
}

/// Like the plots' axes they belong to no time, so that a page that is opened late has them first.
fn draw_detents(recording: &RecordingStream, ring: &DetentRing) -> RecordingStreamResult<()> {
    let DetentRing { depths, stable_rad, amplitude_mnm, .. } = ring;
    let scale_mnm = round_step(*amplitude_mnm);
    let depth = FULL_DEPTH * amplitude_mnm / scale_mnm;
    let outline: Vec<[f32; 3]> =
        depths.iter().map(|[angle, share]| place(*angle, RING_RADIUS - depth * share, 0.0)).collect();
    recording.log_static(
        format!("{KNOB}/detents/ring"),
        &LineStrips3D::new([outline]).with_colors([MODEL.opaque()]).with_radii([Radius::new_ui_points(1.8)]),
    )?;
    recording.log_static(
        format!("{KNOB}/detents/stable"),
        &Points3D::new(stable_rad.iter().map(|angle| place(*angle, RING_RADIUS - depth, 0.0)))
            .with_colors([MODEL.opaque()])
            .with_radii([Radius::new_ui_points(3.5)]),
    )?;
    recording.log_static(format!("{KNOB}/detents/label"), &label([0.0, -1.5, 0.0], detents_in_words(ring)))
}

/// How deep the detents are and how far apart.
pub(crate) fn detents_in_words(ring: &DetentRing) -> String {
    let [deep, apart] = [ring.amplitude_mnm, ring.spacing_rad].map(three_digits);
    format!("detents: {deep} mNm deep, {apart} rad apart")
}

/// A text at a place; its ground is between light and dark in either theme.
pub(crate) fn label(place: [f64; 3], text: String) -> Points3D {
    Points3D::new([place.map(single)])
        .with_labels([text])
        .with_show_labels(true)
        .with_colors([WHITE.opaque()])
        .with_radii([Radius::new_ui_points(0.0)])
}

/// Where an angle lies at some radius and height.
fn place(angle_rad: f64, radius: f64, height: f64) -> [f32; 3] {
    let (sine, cosine) = angle_rad.sin_cos();
    [single(-radius * sine), single(radius * cosine), single(height)]
}

/// rerun draws in single precision.
#[allow(clippy::cast_possible_truncation, reason = "the screen has fewer digits than an f32")]
pub(crate) const fn single(value: f64) -> f32 {
    value as f32
}
