//! A comparison for an 80-column terminal.

use comfy_table::Table;
use identification::statistics::half_width;
use report::{ComparedKnob, ComparedQuality, ComparedValue, Comparison};
use sheet::perception::PerceivedDifference;

use crate::fit::agreement_line;
use crate::terminal::{self, WIDTH, by_reason, decimals, digits, paragraphs};

/// Digits of a value without an interval, and of one that the paper prints.
const DIGITS: f64 = 4.0;
const PAPER_DIGITS: f64 = 2.0;
/// Rows on the fits themselves, as the JSON names them.
type Quality = (&'static str, &'static str, fn(&ComparedQuality) -> String);
const QUALITIES: [Quality; 4] = [
    ("residual_rms_mnm", "mNm", |of| significant(of.residual_rms_mnm, PAPER_DIGITS)),
    ("relative_error_percent", "%", |of| significant(of.relative_error_percent, PAPER_DIGITS)),
    ("mean_ci95_mnm", "mNm", |of| significant(of.mean_ci95_mnm, PAPER_DIGITS)),
    ("samples", "", |of| of.samples.to_string()),
];

/// The comparison line by line: as many tables as it takes, then where the columns are from.
pub fn lines(compared: &Comparison) -> Vec<String> {
    let mut lines = Vec::new();
    let mut rest = compared.knobs.as_slice();
    while !rest.is_empty() {
        let fitting =
            (1..=rest.len()).rev().find(|count| terminal::width(&table(&rest[..*count])) <= WIDTH).unwrap_or(1);
        let (shown, later) = rest.split_at(fitting);
        lines.extend([table(shown).to_string(), String::new()]);
        rest = later;
    }
    lines.push("± is half the 95 % interval".to_owned());
    lines.extend(compared.knobs.iter().flat_map(origins));
    if let Some(first) = compared.knobs.first() {
        let felt = compared.knobs.iter().filter_map(|knob| felt(knob, &first.name));
        lines.extend(felt.map(|sentence| format!("  - {sentence}")));
    }
    paragraphs(&lines)
}

/// What a hand would feel of the difference to the first knob, strongest first.
fn felt(knob: &ComparedKnob, first: &str) -> Option<String> {
    let mut felt: Vec<_> = knob.felt.iter().collect();
    felt.sort_by(|one, other| other.1.thresholds.total_cmp(&one.1.thresholds));
    let (felt, hardly): (Vec<_>, Vec<_>) = felt.into_iter().partition(|(_, felt)| felt.thresholds >= 1.0);
    let named = |of: Vec<(&&str, &PerceivedDifference)>| {
        of.iter().map(|(name, felt)| format!("{name} {:.1}", felt.thresholds)).collect::<Vec<_>>().join(", ")
    };
    let list = match (felt.is_empty(), hardly.is_empty()) {
        (true, true) => return None,
        (true, false) => format!("nothing perceptible ({})", named(hardly)),
        (false, true) => named(felt),
        (false, false) => format!("{}; imperceptible {}", named(felt), named(hardly)),
    };
    Some(format!("{} compared with {first}, in perception thresholds of a model of people: {list}", knob.name))
}

fn table(knobs: &[ComparedKnob]) -> Table {
    let header = row("parameter", knobs.iter().map(|knob| Some(knob.name.clone())), "unit");
    let mut rows = Vec::new();
    for kind in dynamics::effects::ALL.iter().flat_map(|effect| effect.parameters) {
        let own = knobs.iter().map(|knob| knob.parameters.get(kind.name));
        // Models list every parameter of their effects, many of them zero.
        if own.clone().flatten().any(|own| own.value != Some(0.0)) {
            rows.push(row(kind.name, own.map(|own| own.map(cell)), kind.unit));
        }
        let printed = knobs.iter().map(|knob| knob.paper.as_ref()?.parameters.get(kind.name));
        if printed.clone().any(|printed| printed.is_some()) {
            let is_above = knobs.iter().any(|knob| knob.parameters.contains_key(kind.name));
            let name = if is_above { "  paper".to_owned() } else { format!("{}, paper", kind.name) };
            let cells = printed.map(|printed| printed.map(|printed| significant(printed.value, PAPER_DIGITS)));
            rows.push(row(&name, cells, kind.unit));
        }
    }
    for (name, unit, show) in QUALITIES.into_iter().filter(|_| knobs.iter().any(|knob| knob.quality.is_some())) {
        rows.push(row(name, knobs.iter().map(|knob| knob.quality.as_ref().map(show)), unit));
        if name == "mean_ci95_mnm" && knobs.iter().any(|knob| knob.paper.is_some()) {
            let printed = |knob: &ComparedKnob| Some(significant(knob.paper.as_ref()?.mean_ci95_mnm, PAPER_DIGITS));
            rows.push(row("  paper", knobs.iter().map(printed), unit));
        }
    }
    terminal::table(header, 1..=knobs.len(), rows)
}

fn row(name: &str, cells: impl Iterator<Item = Option<String>>, unit: &str) -> Vec<String> {
    let cells = cells.map(|cell| cell.unwrap_or_else(|| "-".to_owned()));
    [name.to_owned()].into_iter().chain(cells).chain([dynamics::printed_unit(unit).to_owned()]).collect()
}

fn cell(own: &ComparedValue) -> String {
    match (own.value, own.ci95) {
        (Some(value), Some(ci95)) => {
            let half = half_width(value, ci95);
            // One digit of the half width, or two if the first is a 1.
            let leading = half / 10_f64.powf(half.log10().floor());
            let digits = if leading < 1.95 { digits(half) } else { digits(half).saturating_sub(1) };
            format!("{value:.digits$}±{half:.digits$}")
        }
        (Some(value), None) => significant(value, DIGITS),
        (None, _) => "-".to_owned(),
    }
}

fn significant(value: f64, digits: f64) -> String {
    format!("{value:.*}", decimals(value, digits, [0.0, 9.0]))
}

/// The captures or the model file of a column, and what a reader should know of it.
fn origins(knob: &ComparedKnob) -> Vec<String> {
    let captures = knob.captures.iter().map(|capture| format!("    {}  {}", capture.number, capture.facts.source));
    let from = knob.model_file.as_ref().map_or_else(|| captures.collect(), |file| vec![format!("    {file}")]);
    let agreement = knob.agreement.map(|agreement| format!("    {}", agreement_line(agreement)));
    let reasons = by_reason(knob.parameters.iter().filter_map(|(name, own)| Some((*name, own.reason.as_deref()?))));
    let notes = reasons.iter().chain(&knob.notes).map(|note| format!("  - {note}"));
    [knob.name.clone()].into_iter().chain(from).chain(agreement).chain(notes).collect()
}
