//! The captures that a diagnosis rests on, and how further ones join them.

use archive::Capture;
use dynamics::effects;
use identification::diagnosis::Diagnosis;
use loaded_capture::LoadedCapture;

use super::CaptureOptions;
use crate::diagnose::with_progress;
use crate::outcome::say;

/// Rest put between two captures that are made into one, s: longer than any gap that is filled in.
const PAUSE_S: f64 = 1.0;

/// Diagnoses all captures so far, two at least; `before` is the diagnosis of all but the last.
///
/// The second capture is held out; the first and the further ones are fitted together: what tells rivals apart then also
/// tells their parameters, and the sweep goes on telling the rest. Effects that depend on the time of a capture do not
/// go on over several: for these the last capture is held out instead.
pub(super) fn diagnosed(
    options: &CaptureOptions,
    mut fitted: Vec<&LoadedCapture>,
    before: Option<&Diagnosis>,
) -> anyhow::Result<Diagnosis> {
    let held_out = if before.is_some_and(depends_on_time) {
        let last = fitted.split_off(fitted.len() - 1);
        fitted.truncate(1);
        last
    } else {
        vec![fitted.remove(1)]
    };
    let (train, heldout) = (joined(&fitted), joined(&held_out));
    let found = with_progress(|progress| {
        Ok(analysis::diagnose_within(options.reach, &train, Some(&heldout), None, Some(progress))?)
    })?;
    say(format!("\n{}", found.summary));
    Ok(found)
}

/// Whether a name or a rival is an effect of the time since a capture began.
fn depends_on_time(found: &Diagnosis) -> bool {
    let of_time = [effects::friction_drift::KIND.name, effects::mains_hum::KIND.name];
    let names = found.steps.iter().flat_map(|step| step.ties.iter().chain([&step.effect]));
    names.into_iter().any(|name| of_time.contains(name))
}

/// The samples of several captures in one, and the description of the first one's rig. Columns that one of them lacks are left out.
///
/// Between two captures lies a gap, as if samples had been lost: what spans it is left out of every comparison.
fn joined(captures: &[&LoadedCapture]) -> LoadedCapture {
    let mut t_s: Vec<f64> = Vec::new();
    for one in captures {
        let first = one.capture.t_s.first().copied().unwrap_or(0.0);
        let start = t_s.last().map_or(first, |last| last + PAUSE_S);
        t_s.extend(one.capture.t_s.iter().map(|time| time - first + start));
    }
    let all = |column: fn(&Capture) -> Option<&Vec<f64>>| -> Option<Vec<f64>> {
        let columns: Option<Vec<&Vec<f64>>> = captures.iter().map(|one| column(&one.capture)).collect();
        Some(columns?.into_iter().flatten().copied().collect())
    };
    let capture = Capture {
        axis: captures[0].capture.axis,
        t_s,
        angle_rad: all(|one| Some(&one.angle_rad)).unwrap_or_default(),
        velocity_rad_s: all(|one| one.velocity_rad_s.as_ref()),
        acceleration_rad_s2: all(|one| one.acceleration_rad_s2.as_ref()),
        torque_mnm: all(|one| Some(&one.torque_mnm)).unwrap_or_default(),
        commanded_torque_mnm: all(|one| one.commanded_torque_mnm.as_ref()),
        ..Capture::default()
    };
    LoadedCapture { capture, calibration: captures[0].calibration.clone(), ..LoadedCapture::default() }
}

#[cfg(test)]
mod tests {
    use archive::Capture;
    use loaded_capture::LoadedCapture;

    use super::joined;

    fn loaded(samples: usize, accelerated: bool) -> LoadedCapture {
        let angle: Vec<f64> = (0..samples).map(|index| index as f64).collect();
        let capture = Capture {
            acceleration_rad_s2: accelerated.then(|| vec![0.5; samples]),
            ..Capture::from_columns(100.0, angle, vec![1.0; samples])
        };
        LoadedCapture { capture, ..LoadedCapture::default() }
    }

    #[test]
    fn captures_follow_each_other_with_a_gap_in_between() {
        let (one, other) = (loaded(3, true), loaded(4, true));
        let joined = joined(&[&one, &other]);
        let samples = joined.samples();
        assert_eq!(samples.angle_rad, [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(samples.acceleration_rad_s2.map(<[f64]>::len), Some(7));
        let steps: Vec<f64> = samples.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| *step > 0.0) && steps[2] > 0.5, "{steps:?}");
    }

    #[test]
    fn a_column_that_one_capture_lacks_is_left_out() {
        let (one, other) = (loaded(3, true), loaded(4, false));
        let joined = joined(&[&one, &other]);
        assert!(joined.samples().acceleration_rad_s2.is_none());
        assert!(joined.commanded_torque_mnm().is_none());
    }
}
