//! The calibration file: values, and in comments how well each is known and from where.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::whole_file::Replace;
use dynamics::Calibration;
use identification::calibration::Calibrated;
use loaded_capture::CALIBRATION_MARK;

use super::cogging_lines;
use crate::outputs;
use crate::terminal::digits;

/// Writes the known calibration with the newly found values, and with the comments of the previous file on the others;
/// `replaced` is what it may replace.
pub fn write(
    path: &Path,
    replaced: Replace,
    calibrated: &Calibrated,
    known: &Calibration,
    previous: Option<&Path>,
    captures: &[PathBuf],
) -> anyhow::Result<()> {
    let before = previous.map(foreign_files::read_text).transpose()?.unwrap_or_default();
    let learnt = |comment: &&str| {
        calibrated
            .estimates
            .iter()
            .any(|estimate| comment.starts_with(&format!("# {}:", known.axis.words(estimate.quantity))))
            || (calibrated.cogging.is_some() && comment.starts_with("# motor_cogging"))
    };
    let mut text = CALIBRATION_MARK.to_owned();
    for comment in before.lines().filter(|line| line.starts_with("# ") && !learnt(line)) {
        let _ = writeln!(text, "{comment}");
    }
    let date = jiff::Zoned::now().strftime("%Y-%m-%d %H:%M:%S %Z");
    let sources: Vec<String> = captures.iter().map(|capture| capture.display().to_string()).collect();
    for estimate in &calibrated.estimates {
        let digits = digits(estimate.half_width);
        let _ = writeln!(
            text,
            "# {}: {:.digits$} ± {:.digits$} {}, 95 %, {date} from {}",
            known.axis.words(estimate.quantity),
            estimate.value,
            estimate.half_width,
            known.axis.words(estimate.unit),
            sources.join(", ")
        );
    }
    for line in calibrated.cogging.iter().flat_map(|cogging| cogging_lines(cogging)) {
        let _ = writeln!(text, "# motor_cogging: {line}, 95 %, {date} from {}", sources.join(", "));
    }
    let learnt = calibrated.applied_to(known);
    learnt.check().with_context(|| {
        format!("{} is not written: the captures give a calibration that no rig can have", path.display())
    })?;
    text += &learnt.to_toml();
    outputs::write(path, replaced, &text)
}
