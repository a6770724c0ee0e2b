//! Whether a part is as it must be: pass, fail, or undecided where the interval straddles a limit.

use identification::statistics::{digits, range, student_95};
use serde::Serialize;
use shared_types::Axis;

use crate::figure::{Figure, FigureKind};
use crate::perception::{PerceivedDifference, perceived_figure};
use crate::quantiles::student_quantile;
use crate::repeats::Sheet;
use crate::specification::{Envelope, Limits, Specification};

/// How far a branch may end before its envelope does, as a share of the envelope's length.
const NEAR_AN_END: f64 = 0.01;

/// What is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within all limits.
    Pass,
    /// The data do not tell.
    Undecided,
    /// Beyond a limit.
    Fail,
}

impl Verdict {
    /// The verdict in a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Undecided => "undecided",
            Self::Fail => "fail",
        }
    }
}

/// The verdict on a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// The verdict on the part: the worst of all.
    pub verdict: Verdict,
    /// The verdict on each figure that has limits.
    pub figures: Vec<FigureVerdict>,
    /// The verdict on each branch that has an envelope.
    pub envelope: Vec<EnvelopeVerdict>,
    /// Why the part does not pass, a sentence each.
    pub reasons: Vec<String>,
}

/// The verdict on a figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FigureVerdict {
    /// Its name.
    pub figure: &'static str,
    /// Its value; `None` where the curve does not determine it.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Its unit.
    pub unit: &'static str,
    /// What it must lie between.
    #[serde(flatten)]
    pub limits: Limits,
    /// The verdict.
    pub verdict: Verdict,
    /// By how much it lies beyond a limit, in thresholds of perception; `None` within its limits, and of a figure that is no load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond_limit: Option<PerceivedDifference>,
}

/// The verdict on a branch of the curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnvelopeVerdict {
    /// The branch.
    pub branch: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Where it leaves the envelope farthest, or comes nearest to that: position in rad or mm.
    pub worst_position: Option<f64>,
}

/// By how much a value must clear a limit, in standard errors, for it to be passed and to be failed.
///
/// To pass a part, every figure must clear its limits: a figure outside them passes with the stated risk at most. To fail a part,
/// one figure is enough, so each figure may fail wrongly only with its share of the risk (Bonferroni). These are the guard bands
/// of ISO 14253-1 and JCGM 106 at a stated risk.
#[derive(Clone, Copy)]
struct Guard {
    risk: f64,
    limits: usize,
}

impl Guard {
    fn bands(self, degrees_of_freedom: f64) -> [f64; 2] {
        let share = self.risk / self.limits as f64;
        [self.risk, share].map(|risk| student_quantile(1.0 - risk, degrees_of_freedom))
    }

    /// The verdict on a value with its error.
    fn verdict(self, value: f64, standard_error: f64, degrees_of_freedom: f64, limits: Limits) -> Verdict {
        let [pass, fail] = self.bands(degrees_of_freedom).map(|band| band * standard_error);
        let (min, max) = (limits.min.unwrap_or(f64::NEG_INFINITY), limits.max.unwrap_or(f64::INFINITY));
        if value + fail < min || value - fail > max {
            Verdict::Fail
        } else if value - pass >= min && value + pass <= max {
            Verdict::Pass
        } else {
            Verdict::Undecided
        }
    }
}

impl Specification {
    /// The verdict on a part.
    #[must_use]
    pub fn judge(&self, sheet: &Sheet) -> Judgement {
        let guard = Guard { risk: self.risk, limits: (self.limits().len() + self.envelopes.len()).max(1) };
        let mut reasons = Vec::new();
        let figures: Vec<FigureVerdict> = self
            .limits()
            .iter()
            .map(|(kind, limits)| {
                let figure = sheet.figure(kind);
                let (verdict, reason) = of_figure(guard, kind, figure, *limits);
                let beyond_limit = beyond(sheet, figure, *limits);
                let felt = beyond_limit.map(|felt| format!("; {}", in_words(&felt))).unwrap_or_default();
                reasons.extend(reason.map(|reason| reason + &felt));
                let value = figure.and_then(|figure| figure.value);
                let ci95 = figure.and_then(|figure| figure.ci95);
                FigureVerdict {
                    figure: kind.name,
                    value,
                    ci95,
                    unit: kind.unit,
                    limits: *limits,
                    verdict,
                    beyond_limit,
                }
            })
            .collect();
        let envelope: Vec<EnvelopeVerdict> = self
            .envelopes
            .iter()
            .map(|envelope| {
                let (verdict, reason) = of_branch(guard, envelope, sheet);
                reasons.extend(reason);
                verdict
            })
            .collect();
        let all = figures.iter().map(|figure| figure.verdict).chain(envelope.iter().map(|branch| branch.verdict));
        Judgement { verdict: all.max().unwrap_or(Verdict::Pass), figures, envelope, reasons }
    }
}

/// By how much a figure lies beyond its limits, beside the largest load of the control.
fn beyond(sheet: &Sheet, figure: Option<&Figure>, limits: Limits) -> Option<PerceivedDifference> {
    let figure = figure?;
    let value = figure.value?;
    let beyond = limits.min.map_or(0.0, |min| min - value).max(limits.max.map_or(0.0, |max| value - max));
    let loads = sheet.curve.values().flat_map(|branch| &branch.load);
    let largest = match sheet.axis {
        // A press is felt by the force of its collapse; a larger load at its bottom is felt as an end stop.
        Axis::Linear => sheet.figures.get("collapse_force").and_then(|collapse| collapse.value),
        Axis::Rotary => None,
    };
    let largest = largest.unwrap_or_else(|| loads.fold(0.0, |most, load| load.abs().max(most)));
    (beyond > 0.0).then(|| perceived_figure(figure.kind.name, sheet.axis, beyond, largest)).flatten()
}

fn in_words(felt: &PerceivedDifference) -> String {
    let sense = if felt.thresholds < 1.0 { "which is imperceptible" } else { "a hand would feel that" };
    format!("{:.1} perception thresholds beyond it: {sense}", felt.thresholds)
}

fn of_figure(guard: Guard, kind: &FigureKind, figure: Option<&Figure>, limits: Limits) -> (Verdict, Option<String>) {
    let name = kind.name;
    let Some(figure) = figure else {
        return (Verdict::Undecided, Some(format!("{name}: controls of this axis have no such figure")));
    };
    let (Some(value), Some([low, high])) = (figure.value, figure.ci95) else {
        let reason = figure.reason.clone().unwrap_or_default();
        return (Verdict::Undecided, Some(format!("{name}: {reason}")));
    };
    let verdict = guard.verdict(value, figure.standard_error, figure.degrees_of_freedom, limits);
    let unit = if kind.unit.is_empty() { String::new() } else { format!(" {}", kind.unit) };
    let [value, low, high] = [value, low, high].map(|number| rounded(number, high - low));
    let seen = format!("{name} {value}{unit} ({low} to {high})");
    let bounds = match (limits.min, limits.max) {
        (Some(min), Some(max)) => format!("{} to {}{unit}", short(min), short(max)),
        (Some(min), None) => format!("at least {}{unit}", short(min)),
        (None, Some(max)) => format!("at most {}{unit}", short(max)),
        (None, None) => String::new(),
    };
    let reason = match verdict {
        Verdict::Pass => None,
        Verdict::Fail => Some(format!("{seen} is outside {bounds}")),
        Verdict::Undecided => Some(format!("{seen} is too uncertain to compare with {bounds}")),
    };
    (verdict, reason)
}

/// Positions of a branch within its envelope: position, load, half width, least and largest load.
fn rows(envelope: &Envelope, sheet: &Sheet) -> Vec<[f64; 5]> {
    let Some(branch) = sheet.curve.get(envelope.branch.as_str()) else { return Vec::new() };
    let between = |position: f64| {
        envelope.points.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&position)).map(|pair| {
            let share = (position - pair[0][0]) / (pair[1][0] - pair[0][0]);
            [1, 2].map(|column| pair[0][column] + share * (pair[1][column] - pair[0][column]))
        })
    };
    let row = |index: usize| {
        let position = branch.position(index);
        let [low, high] = between(position)?;
        Some([position, branch.load[index], branch.load_ci95_half_width[index], low, high])
    };
    (0..branch.len()).filter_map(row).collect()
}

fn of_branch(guard: Guard, envelope: &Envelope, sheet: &Sheet) -> (EnvelopeVerdict, Option<String>) {
    let rows = rows(envelope, sheet);
    // A branch has its share of the risk for all of its rows.
    let guard = Guard { limits: guard.limits * rows.len().max(1), ..guard };
    let freedom = if sheet.runs > 1 { sheet.runs as f64 - 1.0 } else { f64::INFINITY };
    let width_95 = student_95(freedom);
    let judged = rows.iter().map(|[position, load, half, low, high]| {
        let limits = Limits { min: Some(*low), max: Some(*high) };
        (guard.verdict(*load, half / width_95, freedom, limits), (low - load).max(load - high), *position, *load)
    });
    let worst = judged.max_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let branch = envelope.branch.clone();
    let Some((verdict, _, position, load)) = worst else {
        let reason = format!("the curve has no {branch} branch where the envelope lies");
        return (EnvelopeVerdict { branch, verdict: Verdict::Undecided, worst_position: None }, Some(reason));
    };
    let (at, unit) = (short(position), sheet.axis.position_unit());
    let seen = format!("the {branch} branch at {at} {unit}, {} {}", short(load), sheet.axis.load_unit());
    let reason = match verdict {
        Verdict::Pass => None,
        Verdict::Fail => Some(format!("{seen}, is outside its envelope")),
        Verdict::Undecided => Some(format!("{seen}, is too uncertain to compare with its envelope")),
    };
    let (verdict, reason) = match uncovered(envelope, sheet) {
        Some(uncovered) if verdict == Verdict::Pass => (Verdict::Undecided, Some(uncovered)),
        _ => (verdict, reason),
    };
    (EnvelopeVerdict { branch, verdict, worst_position: Some(position) }, reason)
}

/// What to do where a branch does not reach both ends of its envelope.
fn uncovered(envelope: &Envelope, sheet: &Sheet) -> Option<String> {
    let (curve, name) = (sheet.curve.get(envelope.branch.as_str())?, &envelope.branch);
    let [first, last] = [curve.position(0), curve.position(curve.len().saturating_sub(1))];
    let [from, to] = range(envelope.points.iter().map(|[position, ..]| position));
    let near = curve.step.max(NEAR_AN_END * (to - from));
    let is_covered = first <= from + near && last >= to - near;
    (!is_covered).then(|| {
        let [first, last, from, to] = [first, last, from, to].map(short);
        let unit = sheet.axis.position_unit();
        format!("the {name} branch reaches from {first} to {last} {unit}, its envelope from {from} to {to}; capture all of it")
    })
}

/// A number with the decimals that an interval of that width supports.
fn rounded(value: f64, width: f64) -> String {
    format!("{value:.*}", digits(width))
}

/// A number with four digits.
fn short(value: f64) -> String {
    let size = value.abs().max(1e-12).log10().floor();
    let width = 10_f64.powf(size - 2.0);
    let text = rounded(value, width);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
