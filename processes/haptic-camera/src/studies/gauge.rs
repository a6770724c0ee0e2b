//! `gauge`: whether a tester is good enough to tell the units apart.

use std::collections::BTreeMap;
use std::path::PathBuf;

use analysis::load_specification;
use anyhow::{Context as _, bail};
use clap::Args;
use dynamics::Axis;
use sheet::{Design, Gauge};

use super::values::{StudyOptions, Unit, columns, studied, units};
use crate::outcome::{Outcome, show};
use crate::outputs::write_json;

#[derive(Debug, Args)]
pub struct GaugeOptions {
    #[command(flatten)]
    pub study: StudyOptions,
    /// Limits on the figures, for %GRR of the tolerance
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Every operator measured different parts
    #[arg(long)]
    pub nested: bool,
}

/// %GRR up to which a gauge is good, and up to which it may do (AIAG, Measurement Systems Analysis, 4th edition).
const GOOD_PERCENT: f64 = 10.0;
const MAY_DO_PERCENT: f64 = 30.0;
/// Fewest categories of parts that a gauge should tell apart (AIAG).
const CATEGORIES: u64 = 5;

pub fn run(options: &GaugeOptions) -> anyhow::Result<Outcome> {
    let specification = options.spec.as_deref().map(load_specification).transpose()?;
    let studied = studied(&options.study, specification.as_ref())?;
    let units = units(&options.study, &studied)?;
    let design = if options.nested { Design::Nested } else { Design::Crossed };
    let mut results = BTreeMap::new();
    for ((kind, limits), values) in columns(&units, &studied)? {
        let values = by_operator(&units, &values, design)?;
        let tolerance = limits.min.zip(limits.max).map(|(min, max)| max - min);
        results.insert(kind.name, Gauge::of(&values, design, tolerance).context(kind.name)?);
    }
    show(results.iter().map(|(name, gauge)| words(name, gauge)));
    write_json(Axis::default(), &options.study.json, &results)?;
    Ok(Outcome::Done)
}

fn by_operator(units: &[Unit], values: &[f64], design: Design) -> anyhow::Result<Vec<Vec<Vec<f64>>>> {
    if units.iter().any(|unit| unit.part.is_empty() || unit.operator.is_empty()) {
        bail!(
            "a gauge study needs the part and operator of each value: captures in folders PART/OPERATOR/, or a table \
             with both columns"
        );
    }
    let mut sorted: BTreeMap<&str, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
    for (unit, value) in units.iter().zip(values) {
        sorted.entry(&unit.operator).or_default().entry(&unit.part).or_default().push(*value);
    }
    let mut parts = sorted.values().map(|parts| parts.keys().collect::<Vec<_>>());
    let first = parts.next();
    if design == Design::Crossed && parts.any(|parts| Some(parts) != first) {
        bail!("the operators did not measure the same parts; give --nested if each measured different parts");
    }
    Ok(sorted.into_values().map(|parts| parts.into_values().collect()).collect())
}

fn words(name: &str, gauge: &Gauge) -> String {
    let Gauge { parts, operators, trials, grr_percent, grr_tolerance_percent, ndc, .. } = gauge;
    let deviation = |variance: f64| format!("{:.3e}", variance.sqrt());
    let band = match grr_percent {
        percent if *percent <= GOOD_PERCENT => "good",
        percent if *percent <= MAY_DO_PERCENT => "may do",
        _ => "not good enough",
    };
    let categories = match ndc {
        Some(ndc) if *ndc < CATEGORIES => format!("ndc {ndc}, fewer than the {CATEGORIES} required"),
        Some(ndc) => format!("ndc {ndc}"),
        None => "ndc is undefined: the gauge has no variance".to_owned(),
    };
    let tolerance =
        grr_tolerance_percent.map_or_else(String::new, |percent| format!(", {percent:.1} % of the tolerance"));
    format!(
        "{name}: %GRR {grr_percent:.1} %{tolerance}: {band}; {categories}\n  \
         {operators} operators, {parts} parts, {trials} trials; deviations: repeatability {}, operators {}, interaction {}, parts {}",
        deviation(gauge.repeatability_variance),
        deviation(gauge.operator_variance),
        deviation(gauge.interaction_variance),
        deviation(gauge.part_variance)
    )
}
