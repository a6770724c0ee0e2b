//! Many trials as one table.

use std::fmt::Write as _;

use statrs::distribution::{ContinuousCDF as _, Normal};

use super::{Outcome, Trial};

/// The trials of a study by kind, as Markdown, and what they say together.
#[must_use]
pub fn markdown(trials: &[(Trial, Outcome)]) -> String {
    let mut text = String::from(
        "| process | fault | trials | promises broken | later than promised | samples lost | lost unsaid | orphans | back after, s (median, longest) | source reported gone after, s (longest) |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (victim, fault) in Trial::KINDS {
        let of_kind: Vec<&Outcome> =
            trials.iter().filter(|(trial, _)| (trial.victim, trial.fault) == (victim, fault)).map(|(_, o)| o).collect();
        let broken: usize = of_kind.iter().map(|outcome| outcome.broken.len()).sum();
        let late: usize = of_kind.iter().map(|outcome| outcome.late.len()).sum();
        let lost: u64 = of_kind.iter().map(|outcome| outcome.lost_samples).sum();
        let unsaid: u64 = of_kind.iter().map(|outcome| outcome.lost_unsaid).sum();
        let orphans: usize = of_kind.iter().map(|outcome| outcome.orphans).sum();
        let back = sorted(of_kind.iter().filter_map(|outcome| outcome.back_after_s).collect());
        let reported = sorted(of_kind.iter().filter_map(|outcome| outcome.reported_after_s).collect());
        let back = match (back.get(back.len() / 2), back.last()) {
            (Some(median), Some(longest)) => format!("{median:.2}, {longest:.2}"),
            _ => "–".to_owned(),
        };
        let reported = reported.last().map_or_else(|| "–".to_owned(), |longest| format!("{longest:.2}"));
        let program = victim.program();
        let trials = of_kind.len();
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "| {program} | {fault:?} | {trials} | {broken} | {late} | {lost} | {unsaid} | {orphans} | {back} | {reported} |"
        );
    }
    let _ = writeln!(text, "\n{}", disturbance(trials));
    let measured = trials.iter().map(|(_, outcome)| outcome.shared_memory_bytes).filter(|&bytes| bytes > 0);
    let memory = sorted(measured.map(|bytes| bytes as f64 / 1e6).collect());
    if let (Some(least), Some(most)) = (memory.first(), memory.last()) {
        let _ = writeln!(text, "Shared memory of the rig shortly before the end: {least:.1} to {most:.1} MB.");
    }
    text
}

/// Whether the loop noticed the faults of the other processes.
fn disturbance(trials: &[(Trial, Outcome)]) -> String {
    let others: Vec<&(Trial, Outcome)> = trials.iter().filter(|(trial, _)| trial.victim.is_consumer()).collect();
    let ranks: Vec<f64> = others.iter().filter_map(|(_, outcome)| outcome.lateness_rank).collect();
    if ranks.is_empty() {
        return "No trial with a fault within the run of another process than the loop.".to_owned();
    }
    let count = ranks.len() as f64;
    let mean = ranks.iter().sum::<f64>() / count;
    // Uniform ranks have the mean 1/2 and the variance 1/12.
    let z = (mean - 0.5) * (12.0 * count).sqrt();
    let p = Normal::standard().sf(z);
    let within: u64 = others.iter().map(|(_, outcome)| outcome.missed_after_fault).sum();
    let all: u64 = others.iter().map(|(_, outcome)| outcome.missed_in_run).sum();
    let run_s: f64 = others.iter().map(|(trial, _)| trial.duration_s).sum();
    format!(
        "Loop: rank of the half second after a consumer's fault among those of its run by the 99th percentile of \
         lateness, mean {mean:.3} over {} trials (0.5 if unnoticed; one-sided z test p = {p:.2}). Ticks missed: {:.1} \
         a second after a fault, {:.1} a second over the whole runs.",
        ranks.len(),
        within as f64 / (0.5 * others.len() as f64),
        all as f64 / run_s
    )
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}
