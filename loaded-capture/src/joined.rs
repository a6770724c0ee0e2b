//! Several captures in one.

use archive::Capture;

use crate::LoadedCapture;

/// Rest put between two captures that are made into one, s: longer than any gap that is filled in.
const PAUSE_S: f64 = 1.0;

impl LoadedCapture {
    /// The samples of several captures, one at least, in one that is of the first one's rig. Columns that one of them lacks are left out.
    ///
    /// Between two captures lies a gap, as if samples had been lost: what spans it is left out of every comparison.
    #[must_use]
    pub fn joined(captures: &[&Self]) -> Self {
        let mut t_s: Vec<f64> = Vec::new();
        for one in captures {
            let first = one.capture.t_s.first().copied().unwrap_or(0.0);
            let start = t_s.last().map_or(first, |last| last + PAUSE_S);
            t_s.extend(one.capture.t_s.iter().map(|time| time - first + start));
        }
        let all = |column: fn(&Self) -> Option<&[f64]>| -> Option<Vec<f64>> {
            let columns: Option<Vec<&[f64]>> = captures.iter().map(|one| column(one)).collect();
            Some(columns?.concat())
        };
        let capture = Capture {
            axis: captures[0].capture.axis,
            t_s,
            angle_rad: all(|one| Some(one.capture.angle_rad.as_slice())).unwrap_or_default(),
            velocity_rad_s: all(|one| one.capture.velocity_rad_s.as_deref()),
            acceleration_rad_s2: all(|one| one.capture.acceleration_rad_s2.as_deref()),
            torque_mnm: all(|one| Some(one.capture.torque_mnm.as_slice())).unwrap_or_default(),
            commanded_torque_mnm: all(Self::commanded_torque_mnm),
            ..Capture::default()
        };
        Self { capture, calibration: captures[0].calibration.clone(), ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::{Capture, LoadedCapture};

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
        let joined = LoadedCapture::joined(&[&one, &other]);
        let samples = joined.samples();
        assert_eq!(samples.angle_rad, [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!(samples.acceleration_rad_s2.map(<[f64]>::len), Some(7));
        let steps: Vec<f64> = samples.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| *step > 0.0) && steps[2] > 0.5, "{steps:?}");
    }

    #[test]
    fn a_column_that_one_capture_lacks_is_left_out() {
        let (one, other) = (loaded(3, true), loaded(4, false));
        let joined = LoadedCapture::joined(&[&one, &other]);
        assert!(joined.samples().acceleration_rad_s2.is_none());
        assert!(joined.commanded_torque_mnm().is_none());
    }
}
