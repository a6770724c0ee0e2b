//! The residual over what it might go with, and effects beside their rivals, as bars.

use rerun::datatypes::Rgba32;
use rerun::{BarChart, RecordingStream, RecordingStreamResult};

use super::input::{DiagnosisInput, Location, Rival, Step};
use crate::palette::{MEASURED, MODEL, NEGATIVE, NEUTRAL, translucent};

/// Where the maps lie, each `where/<coordinate>/before` and `…/after`.
pub fn map_entity(coordinate: &str) -> String {
    format!("where/{coordinate}")
}

/// Where a step's bars lie: `steps/<number>-<effect>`.
pub fn step_entity(index: usize, step: &Step) -> String {
    format!("steps/{}-{}", index + 1, step.effect)
}

/// Where the gap's bars lie: before and after each step, and the floor.
pub const GAP: &str = "gap/heldout_rms_mnm";
/// Where the errors of the motion from the command lie: before and after each step.
pub const FORWARD: &str = "gap/forward_from_command_rad";

/// Draws all bars.
pub fn draw(recording: &RecordingStream, input: &DiagnosisInput) -> RecordingStreamResult<()> {
    let found = &input.diagnosis;
    for (locations, name, color) in [(&found.locations, "before", NEUTRAL), (&found.where_after, "after", MODEL)] {
        for location in locations {
            map(recording, &format!("{}/{name}", map_entity(&location.coordinate)), location, color)?;
        }
    }
    let after = found.steps.iter().map(|step| (step.effect.as_str(), step.heldout_rms_after, MODEL));
    let gap = [("without", found.heldout_rms_before, NEUTRAL)].into_iter().chain(after);
    bars(recording, GAP, gap.chain([("noise", found.noise_floor_rms, MEASURED)]))?;
    if let Some(forward) = &found.forward_from_command {
        let names = ["without"].into_iter().chain(found.steps.iter().map(|step| step.effect.as_str()));
        bars(recording, FORWARD, names.zip(&forward.angle_rms_rad).map(|(name, error)| (name, *error, MODEL)))?;
    }
    for (index, step) in found.steps.iter().enumerate() {
        let entity = step_entity(index, step);
        let contenders = step.contenders();
        let bars_of = |value: fn(&Rival) -> f64| {
            contenders.iter().enumerate().map(move |(place, rival)| {
                let of_rival = if rival.disqualified.is_some() { NEGATIVE } else { NEUTRAL };
                (rival.effect.as_str(), value(rival), if place == 0 { MODEL } else { of_rival })
            })
        };
        let placebo = [("placebo", step.placebo_rms, MEASURED), ("without", step.heldout_rms_before, MEASURED)];
        let rms = bars_of(|rival| rival.heldout_rms_after).chain(placebo);
        bars(recording, &format!("{entity}/heldout_rms_mnm"), rms)?;
        bars(recording, &format!("{entity}/evidence_nats"), bars_of(|rival| rival.evidence))?;
    }
    Ok(())
}

/// A residual's map: a bar for each bin, at its middle and as wide as the way to its neighbours.
fn map(recording: &RecordingStream, entity: &str, location: &Location, color: Rgba32) -> RecordingStreamResult<()> {
    let mut points = location.map.clone();
    points.retain(|[at, value]| at.is_finite() && value.is_finite());
    points.sort_by(|one, other| one[0].total_cmp(&other[0]));
    points.dedup_by(|one, other| one[0] == other[0]);
    let (middles, heights): (Vec<f64>, Vec<f64>) = points.iter().map(|[at, value]| (*at, *value)).unzip();
    let edges: Vec<f64> = middles.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
    let edge = |index: Option<usize>| edges.get(index?).copied();
    let width = |(index, middle): (usize, &f64)| {
        let high = edge(Some(index));
        let low = edge(index.checked_sub(1)).or(high.map(|high| 2.0 * middle - high)).unwrap_or(middle - 0.5);
        (high.unwrap_or(2.0 * middle - low) - low) as f32
    };
    let widths: Vec<f32> = middles.iter().enumerate().map(width).collect();
    let chart = BarChart::new(heights).with_abscissa(middles).with_widths(widths).with_color(translucent(color, 190));
    recording.log_static(entity, &chart)
}

/// Bars side by side, each an entity of its own, so that the legend names it.
fn bars<'a>(
    recording: &RecordingStream,
    entity: &str,
    values: impl Iterator<Item = (&'a str, f64, Rgba32)>,
) -> RecordingStreamResult<()> {
    for (place, (name, value, color)) in (1_u32..).zip(values) {
        let chart =
            BarChart::new(vec![value]).with_abscissa(vec![f64::from(place)]).with_widths([0.9_f32]).with_color(color);
        recording.log_static(format!("{entity}/{place:02}-{name}"), &chart)?;
    }
    Ok(())
}
