//! The list as a table for an 80-column terminal.

use operator::one_line;

use super::entry::{Entry, Health};
use crate::terminal;

const NAME_LETTERS: usize = 27;
const KNOB_LETTERS: usize = 7;

/// The table, and a sentence on each file that is no whole capture.
pub(super) fn lines(entries: &[Entry]) -> Vec<String> {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let rows = entries.iter().map(|entry| {
        [
            shortened(&one_line(&entry.file), NAME_LETTERS),
            shortened(&one_line(entry.knob.as_deref().unwrap_or("-")), KNOB_LETTERS),
            or_dash(entry.captured_at.as_deref().and_then(minutes)),
            or_dash(entry.duration_s.map(|duration_s| format!("{duration_s:.1}"))),
            or_dash(entry.quality.relative_error_percent.map(|error| format!("{error:.1} %"))),
            or_dash(entry.quality.mean_ci95_mnm.map(|half_width| format!("{half_width:.3}"))),
            word(entry).to_owned(),
        ]
    });
    let mut table = terminal::table(["file", "knob", "captured", "s", "error", "95 %", "health"], 3..6, rows);
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
    let mut lines = terminal::lines(&table);
    lines.push("s: length; error: residual, share of torque; 95 %: mean half width, mNm or N".to_owned());
    lines.extend(entries.iter().filter_map(remark));
    lines
}

fn minutes(date: &str) -> Option<String> {
    Some(format!("{} {}", date.get(..10)?, date.get(11..16)?))
}

/// A name that fits; its end tells more than its middle.
fn shortened(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let end = most / 2;
    let (first, last) = (&letters[..most - end - 1], &letters[letters.len() - end..]);
    first.iter().chain(&['…']).chain(last).collect()
}

fn word(entry: &Entry) -> &'static str {
    match entry.health {
        Health::Whole if entry.missed_ticks.is_some_and(|ticks| ticks > 0) => "late",
        Health::Whole => "whole",
        Health::SamplesLost => "lost",
        Health::Fault => "fault",
        Health::Truncated => "truncated",
        Health::Damaged => "damaged",
        Health::Foreign => "foreign",
        Health::Unreadable => "unreadable",
    }
}

fn remark(entry: &Entry) -> Option<String> {
    // What is no capture needs no advice.
    if entry.health == Health::Foreign {
        return None;
    }
    if let Some(problem) = &entry.problem {
        return Some(format!("- {problem}"));
    }
    let some = |count: Option<u64>| count.filter(|&count| count > 0);
    let words: Vec<String> = [
        some(entry.lost_samples).zip(entry.gaps).map(|(lost, gaps)| format!("{lost} samples lost in {gaps} gaps")),
        some(entry.missed_ticks).map(|ticks| format!("{ticks} ticks missed")),
        some(entry.stale_ticks).map(|ticks| format!("{ticks} ticks without new data")),
        entry.clock_drift_ppm.map(|drift_ppm| format!("the rig's clock drifted by {drift_ppm:+.1} ppm")),
        (entry.health == Health::Fault).then(|| "the run ended in a fault".to_owned()),
        entry.recovered.then(|| "recovered from a broken archive".to_owned()),
    ]
    .into_iter()
    .flatten()
    .collect();
    (!words.is_empty()).then(|| format!("- {}: {}", one_line(&entry.file), words.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn a_long_name_keeps_its_beginning_and_its_end() {
        assert_eq!(shortened("20261121-101500-knob-3.mcap", 27), "20261121-101500-knob-3.mcap");
        let long = shortened("20261121-101500-a-knob-with-a-long-name.mcap", 27);
        assert!(long.starts_with("20261121-1") && long.ends_with("name.mcap"), "{long}");
        assert!(long.chars().count() <= 27);
    }
}
