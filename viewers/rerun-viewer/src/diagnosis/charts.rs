//! The residual over what it might go with, and effects beside their rivals, as bars.

use identification::diagnosis::{Diagnosis, Location, Rival};
use rerun::datatypes::Rgba32;
use rerun::{BarChart, RecordingStream, RecordingStreamResult};

use super::contenders;
use crate::palette::{MEASURED, MODEL, NEGATIVE, NEUTRAL, translucent};

/// Where the maps lie, each `where/<coordinate>/before` and `…/after`.
pub fn map_entity(coordinate: &str) -> String {
    format!("where/{coordinate}")
}

/// Bars side by side with their names.
pub struct Comparison {
    pub entity: String,
    /// What they are, with their unit.
    pub title: String,
    bars: Vec<(&'static str, f64, Rgba32)>,
}

/// The gap step by step, and each effect beside its rivals.
pub fn comparisons(found: &Diagnosis) -> Vec<Comparison> {
    const LEFT: &str = "left of the held-out capture, mNm RMS";
    let without = ("without", found.heldout_rms_before, NEUTRAL);
    let after = found.steps.iter().map(|step| (step.effect, step.heldout_rms_after, MODEL));
    let gap = std::iter::once(without).chain(after).chain([("noise", found.noise_floor_rms, MEASURED)]);
    let comparison = |entity: String, title, bars| Comparison { entity, title, bars };
    let mut all = vec![comparison("gap/heldout_rms_mnm".to_owned(), LEFT.to_owned(), gap.collect())];
    if let Some(forward) = &found.forward_from_command {
        let names = std::iter::once("without").chain(found.steps.iter().map(|step| step.effect));
        let bars = names.zip(&forward.angle_rms_rad).map(|(name, error)| (name, *error, MODEL)).collect();
        let title = "error of the motion from the command, rad RMS".to_owned();
        all.push(comparison("gap/forward_from_command_rad".to_owned(), title, bars));
    }
    for (number, step) in (1..).zip(&found.steps) {
        let bars = |value: fn(&Rival) -> f64| {
            let color = |place, rival: &Rival| match (place, &rival.disqualified) {
                (0, _) => MODEL,
                (_, Some(_)) => NEGATIVE,
                (_, None) => NEUTRAL,
            };
            let all = contenders(step).into_iter().enumerate();
            all.map(|(place, rival)| (rival.effect, value(&rival), color(place, &rival))).collect::<Vec<_>>()
        };
        let mut rms = bars(|rival| rival.heldout_rms_after);
        rms.extend([("null-effect", step.placebo_rms, MEASURED), ("without", step.heldout_rms_before, MEASURED)]);
        let evidence = bars(|rival| rival.evidence);
        for (part, what, bars) in [("heldout_rms_mnm", LEFT, rms), ("evidence_nats", "evidence, nats", evidence)] {
            let entity = format!("steps/{number}-{}/{part}", step.effect);
            all.push(comparison(entity, format!("{} and its rivals: {what}", step.effect), bars));
        }
    }
    all
}

/// Draws all bars, each an entity of its own where they are compared, so that the legend names it.
pub fn draw(recording: &RecordingStream, found: &Diagnosis) -> RecordingStreamResult<()> {
    for (locations, name, color) in [(&found.locations, "before", NEUTRAL), (&found.where_after, "after", MODEL)] {
        for location in locations {
            map(recording, &format!("{}/{name}", map_entity(location.coordinate)), location, color)?;
        }
    }
    for Comparison { entity, bars, .. } in comparisons(found) {
        for (place, (name, value, color)) in (1_u32..).zip(bars) {
            let chart = BarChart::new(vec![value]).with_abscissa(vec![f64::from(place)]).with_widths([0.9_f32]);
            recording.log_static(format!("{entity}/{place:02}-{name}"), &chart.with_color(color))?;
        }
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
