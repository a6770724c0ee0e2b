//! A diagnosis as text for a terminal.

use comfy_table::Table;
use dynamics::effects;
use identification::diagnosis::{
    Characteristic, Diagnosis, FLOOR_IS_DOUBTFUL, FORWARD_WINDOW_S, Location, Step, Value, Verdict,
};

use crate::terminal::{digits, interval, paragraphs, table};

/// Coordinates that are named.
const NAMED: usize = 3;

/// The diagnosis line by line, none wider than 80 columns.
pub fn lines(found: &Diagnosis) -> Vec<String> {
    let mut lines = vec![found.summary.clone()];
    if found.is_floor_doubtful() {
        lines.push(FLOOR_IS_DOUBTFUL.to_owned());
    }
    let first = goes_with(&found.locations);
    lines.extend(first.map(|words| format!("The first model's residual depends on {words}.")));
    let decimals = found.decimals();
    if !found.steps.is_empty() {
        lines.push(String::new());
        lines.push(format!(
            "RMS residual of the held-out capture, mNm; noise alone leaves {:.decimals$}. Null: an effect without meaning \
             and with as many parameters.",
            found.noise_floor_rms
        ));
        lines.extend([steps(&found.steps, decimals).to_string(), String::new(), parameters(&found.steps).to_string()]);
        let detented = found.steps.iter().filter(|step| !step.detents.is_empty());
        lines.extend(detented.map(|step| detents(step).to_string()));
        let tied = found.steps.iter().filter(|step| !step.ties.is_empty());
        lines.extend(tied.map(|step| {
            let rivals = step.ties.join(" or ");
            format!("A tie: the captures cannot discriminate between {} and {rivals}.", step.effect)
        }));
    }
    let measured = found.characteristics.iter().map(|characteristic| measured(characteristic, decimals));
    lines.extend(measured.chain(forward(found)));
    match (found.verdict, goes_with(&found.where_after)) {
        (Verdict::None, _) | (Verdict::Effects, None) => {}
        (Verdict::OutsideLibrary, None) => {
            lines.push("The residual depends on no single quantity beyond chance.".to_owned());
        }
        (_, Some(words)) => lines.push(format!("The remaining residual depends on {words}.")),
    }
    if !found.partial.is_empty() {
        lines.push(found.partial_heading().to_owned());
        for partial in &found.partial {
            let why_not = partial.disqualified.as_ref().map_or_else(String::new, |reason| format!(" ({reason})"));
            lines.push(format!("- {} {:.0} %{why_not}", partial.effect, partial.explains_percent));
        }
    }
    if let Some(next) = &found.next_experiment {
        let [one, other] = &next.tells_apart;
        lines.push(format!("To discriminate between {one} and {other}: {}.", next.reason));
    }
    lines.extend(found.notes.iter().map(|note| format!("- {note}")));
    paragraphs(&lines)
}

/// The torque that was measured over a coordinate and that no effect matches.
fn measured(characteristic: &Characteristic, decimals: usize) -> String {
    let unit = if characteristic.coordinate == "velocity" { "rad/s" } else { "rad" };
    let points = &characteristic.points;
    let [first, last] = [points.first(), points.last()].map(|point| point.map_or(0.0, |end| end.at));
    let largest = points.iter().max_by(|a, b| a.torque_mnm.abs().total_cmp(&b.torque_mnm.abs()));
    let largest = largest.map_or_else(String::new, |point| {
        format!(", largest at {:.3} {unit} with {:.decimals$} mNm", point.at, point.torque_mnm)
    });
    format!(
        "{} is measured at {} points from {first:.3} to {last:.3} {unit}{largest}; no effect matches it.",
        characteristic.effect,
        points.len()
    )
}

/// How well motion follows from torque, measured and commanded.
fn forward(found: &Diagnosis) -> Option<String> {
    let from_sensor = found.forward_angle_rms_rad.map(|[before, after]| {
        let after = if found.steps.is_empty() { String::new() } else { format!(", then {after:.2e} rad") };
        format!("from the measured torque {before:.2e} rad{after}")
    });
    let from_command = found.forward_from_command.as_ref().map(|forward| {
        let mut each = forward.angle_rms_rad.iter();
        let first = each.next().map_or_else(String::new, |error| format!("{error:.2e} rad"));
        let then = each.zip(&found.steps).map(|(error, step)| format!(", with {} {error:.2e} rad", step.effect));
        format!("from the commanded torque {first}{}", then.collect::<String>())
    });
    let errors: Vec<String> = from_sensor.into_iter().chain(from_command).collect();
    let words = format!("RMS error of the held-out angle predicted over {FORWARD_WINDOW_S} s: {}.", errors.join("; "));
    (!errors.is_empty()).then_some(words)
}

fn goes_with(locations: &[Location]) -> Option<String> {
    let significant = locations.iter().filter(|location| location.significant).take(NAMED);
    let named = |location: &Location| format!("{} ({:.0} %)", location.coordinate, location.explained_percent);
    let significant: Vec<String> = significant.map(named).collect();
    (!significant.is_empty()).then(|| significant.join(", "))
}

fn steps(steps: &[Step], decimals: usize) -> Table {
    let row = |step: &Step| {
        let rival = step.rivals.iter().find(|rival| rival.disqualified.is_none());
        let rms_mnm = |value: f64| format!("{value:.decimals$}");
        [
            step.effect.to_owned(),
            rms_mnm(step.heldout_rms_before),
            rms_mnm(step.heldout_rms_after),
            rms_mnm(step.placebo_rms),
            rival.map_or_else(|| "none".to_owned(), |one| format!("{} {}", one.effect, rms_mnm(one.heldout_rms_after))),
        ]
    };
    table(["added", "before", "after", "null", "closest rival"], 1..4, steps.iter().map(row))
}

/// The parameters of what was added, each effect's in the order of its law.
fn parameters(steps: &[Step]) -> Table {
    let rows = steps.iter().flat_map(|step| {
        let kind = effects::by_name(step.effect);
        let place = |name: &str| kind.and_then(|kind| kind.parameters.iter().position(|other| other.name == name));
        let mut ordered: Vec<_> = step.parameters.iter().collect();
        ordered.sort_by_key(|(name, _)| place(name));
        ordered.into_iter().map(|(name, value)| {
            let digits = digits(value.ci95.map_or(0.01 * value.value.abs(), |[low, high]| high - low));
            let unit = dynamics::printed_unit(value.unit);
            [*name, &format!("{:.digits$}", value.value), &interval(value.ci95, digits), unit].map(str::to_owned)
        })
    });
    table(["parameter", "value", "95 % interval", "unit"], 1..3, rows)
}

fn detents(step: &Step) -> Table {
    let cell = |value: &Value, factor: f64| {
        let half = value.ci95.map(|[low, high]| 0.5 * factor * (high - low));
        let digits = digits(half.unwrap_or(0.01));
        let interval = half.map_or_else(String::new, |half| format!(" ± {half:.digits$}"));
        format!("{:.digits$}{interval}", factor * value.value)
    };
    let degrees = 1.0_f64.to_degrees();
    let rows = step.detents.iter().map(|detent| {
        [cell(&detent.rest, degrees), cell(&detent.pitch, degrees), cell(&detent.peak, 1.0), cell(&detent.trough, 1.0)]
    });
    table(["rest, °", "pitch, °", "peak, mNm", "trough, mNm"], 0..4, rows)
}
