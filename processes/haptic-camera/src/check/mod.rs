//! `check`: what captures show without a fit, beside a fitted model.

mod breakaway;
mod table;

use dynamics::Model;
use identification::checks::{DetentCount, breakaways, count_detents};
use serde::Serialize;

use crate::command_line::CheckOptions;
use crate::fit::{to_output, write_json};
use crate::load::LoadedCapture;
use crate::outcome::{Outcome, say};
use breakaway::Threshold;

/// What one capture shows.
#[derive(Debug, Serialize)]
struct Shown {
    capture: String,
    /// Detents counted, if the capture turns far enough both ways.
    detents: Option<DetentCount>,
    /// Why no detents were counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_detents: Option<String>,
    /// Torque at which the knob broke away in the negative direction, a magnitude.
    static_negative: Option<Threshold>,
    static_positive: Option<Threshold>,
}

/// A quantity by its check and by the model.
#[derive(Debug, Serialize)]
struct Agreement {
    quantity: &'static str,
    unit: &'static str,
    checked: f64,
    ci95: Option<[f64; 2]>,
    model: Option<f64>,
    difference_percent: Option<f64>,
}

/// What `check --json` writes.
#[derive(Debug, Serialize)]
struct Check {
    captures: Vec<Shown>,
    agreement: Vec<Agreement>,
}

/// Looks at the captures and compares.
///
/// # Errors
/// One sentence on what is wrong with a capture or the model.
pub fn run(options: &CheckOptions) -> anyhow::Result<Outcome> {
    let model = options.model.as_deref().map(Model::load).transpose()?;
    let mut captures = Vec::new();
    for path in &options.captures {
        let loaded = LoadedCapture::load(path)?;
        captures.push(look(&loaded, model.as_ref())?);
    }
    let check = Check { agreement: agreement(&captures, model.as_ref()), captures };
    if !to_output(options.json.as_deref()) {
        if check.agreement.is_empty() {
            say("neither detents nor breakaways to be seen");
        } else {
            say(table::table(&check.agreement));
        }
        for shown in &check.captures {
            say(format!("- {}: {}", shown.capture, shown.in_words()));
        }
    }
    write_json(options.json.as_deref(), &check)?;
    Ok(Outcome::Done)
}

fn look(loaded: &LoadedCapture, model: Option<&Model>) -> anyhow::Result<Shown> {
    let samples = loaded.samples();
    let (detents, no_detents) = match count_detents(&samples) {
        Ok(count) => (Some(count), None),
        Err(error) => (None, Some(error.to_string())),
    };
    let seen = breakaways(&samples, loaded.calibration.as_ref())?;
    let [static_negative, static_positive] = Threshold::of(&seen, model);
    let capture = loaded.title();
    Ok(Shown { capture, detents, no_detents, static_negative, static_positive })
}

impl Shown {
    fn in_words(&self) -> String {
        let mut words = Vec::new();
        match (&self.detents, &self.no_detents) {
            (Some(count), _) => {
                words.push(format!("{} detents in {:.0}°", count.detents, count.turned_rad.to_degrees()));
            }
            (None, Some(reason)) => words.push(reason.clone()),
            (None, None) => {}
        }
        for (threshold, direction) in [(&self.static_negative, "negative"), (&self.static_positive, "positive")] {
            if let Some(threshold) = threshold {
                let times = if threshold.times == 1 { "once".to_owned() } else { format!("{} times", threshold.times) };
                words.push(format!("broke away {times} in the {direction} direction"));
            }
        }
        words.join("; ")
    }
}

/// The best word of all captures on each quantity, beside the model's.
fn agreement(captures: &[Shown], model: Option<&Model>) -> Vec<Agreement> {
    let mut agreement = Vec::new();
    let mut add = |quantity, unit, checked: f64, ci95, model: Option<f64>| {
        agreement.push(Agreement {
            quantity,
            unit,
            checked,
            ci95,
            model,
            difference_percent: model.map(|model| 100.0 * (checked / model - 1.0)),
        });
    };
    let counted = captures.iter().filter_map(|shown| shown.detents.as_ref());
    if let Some(count) = counted.max_by(|a, b| a.turned_rad.total_cmp(&b.turned_rad)) {
        let period = model.and_then(|model| model.parameter("detent_period"));
        let per_turn_ci95 = [1.0 / count.period_ci95_rad[1], 1.0 / count.period_ci95_rad[0]];
        add("detents per turn", "", count.per_turn, Some(per_turn_ci95), period.map(|period| 1.0 / period));
        add("detent_period", "rad", count.period_rad, Some(count.period_ci95_rad), period);
    }
    let negative = captures.iter().filter_map(|shown| shown.static_negative.as_ref());
    let positive = captures.iter().filter_map(|shown| shown.static_positive.as_ref());
    let thresholds = [
        ("static_negative", negative.max_by_key(|threshold| threshold.times)),
        ("static_positive", positive.max_by_key(|threshold| threshold.times)),
    ];
    for (quantity, threshold) in thresholds {
        if let Some(threshold) = threshold {
            let fitted = model.and_then(|model| model.parameter(quantity));
            add(quantity, "mNm", threshold.torque_mnm, threshold.ci95_mnm, fitted);
        }
    }
    agreement
}
