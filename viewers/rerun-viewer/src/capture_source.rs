//! A finished capture as a source: all of its samples, and the model that the whole of it gives.

use std::path::Path;

use archive::Capture;
use dynamics::{Calibration, Model};
use identification::{Fit, MeasuredCurve, statistics};
use loaded_capture::LoadedCapture;

use crate::capture_summary;
use crate::layout::Subject;
use crate::model_torque::KnobModel;
use crate::picture::Picture;
use crate::source::{Reading, Source, nanoseconds};

/// Samples handed over at once: 2 s at 10 kHz.
const SAMPLES_PER_POLL: usize = 20_000;
/// Time over which the direction of motion is determined for a table without a velocity, s.
const DIRECTION_SPAN_S: f64 = 0.01;

pub struct CaptureSource {
    pub capture: Capture,
    calibration: Option<Calibration>,
    /// The fit, or one sentence on why there is none.
    fit: Result<Fit, String>,
    next_row: usize,
}

impl CaptureSource {
    /// Reads a capture and fits it; a capture that cannot be fitted is shown without a model.
    /// An error is one sentence on what is wrong with the file.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let loaded = LoadedCapture::load(path)?;
        let fit = identification::fit(&loaded.samples(), &analysis::fit_options(&loaded));
        let fit = fit.map_err(|error| error.to_string());
        let LoadedCapture { capture, calibration, .. } = loaded;
        Ok(Self { capture, calibration, fit, next_row: 0 })
    }

    /// What is laid out: the columns that the capture has.
    pub fn subject(&self) -> Subject {
        Subject {
            is_live: false,
            axis: self.capture.axis,
            velocity: self.capture.velocity_rad_s.is_some(),
            acceleration: self.capture.acceleration_rad_s2.is_some(),
            contact: self.capture.contact.is_some(),
        }
    }

    fn reading(&self, row: usize) -> Reading {
        let Capture { t_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact, .. } = &self.capture;
        let or_nan = |column: &Option<Vec<f64>>| column.as_ref().map_or(f64::NAN, |column| column[row]);
        Reading {
            time_ns: nanoseconds(t_s[row]),
            angle_rad: angle_rad[row],
            velocity_rad_s: or_nan(velocity_rad_s),
            acceleration_rad_s2: or_nan(acceleration_rad_s2),
            torque_mnm: torque_mnm[row],
            contact: or_nan(contact),
            turning_positive: self.turning_positive(row),
            ..Reading::default()
        }
    }

    /// From the velocity, or else from the angle shortly before and shortly after.
    fn turning_positive(&self, row: usize) -> bool {
        let Capture { rate_hz, angle_rad, velocity_rad_s, .. } = &self.capture;
        if let Some(velocity_rad_s) = velocity_rad_s {
            return velocity_rad_s[row] > 0.0;
        }
        let reach = ((DIRECTION_SPAN_S / 2.0 * rate_hz) as usize).max(1);
        let last = angle_rad.len() - 1;
        angle_rad[(row + reach).min(last)] > angle_rad[row.saturating_sub(reach)]
    }
}

impl Source for CaptureSource {
    fn poll(&mut self, _samples_wanted: bool, picture: &mut Picture) -> anyhow::Result<()> {
        if picture.run.finished() {
            return Ok(());
        }
        let (start, all) = (self.next_row, self.capture.len());
        if start == 0 {
            let axis = self.capture.axis;
            let text = capture_summary::markdown(&self.capture, &self.fit);
            picture.describe_capture(axis, axis.words(&text).into_owned());
        }
        self.next_row = (start + SAMPLES_PER_POLL).min(all);
        (start..self.next_row).for_each(|row| picture.take_reading(&self.reading(row), None));
        if self.next_row == all {
            let (fit, calibration) = (self.fit.as_ref().ok(), self.calibration.as_ref());
            let model = fit.and_then(curves).map(|knob| knob.on_rig(calibration));
            picture.end_capture(model, fit.into_iter().flat_map(|fit| torque(fit, calibration)));
        }
        Ok(())
    }
}

/// The model for the curves over angle and velocity.
fn curves(fit: &Fit) -> Option<KnobModel> {
    let estimate = |name: &str| {
        let parameter = fit.parameters.get(name)?;
        Some([parameter.value?, parameter.ci95.map_or(0.0, |[low, high]| (high - low) / 2.0)])
    };
    let knob = KnobModel::from_estimates(estimate)?;
    Some(knob.with_characteristic(fit.effects(), characteristic_half_width_mnm(fit)))
}

/// RMS half width of the interval of the torque measured over the angle, both directions alike, mNm; zero without one.
fn characteristic_half_width_mnm(fit: &Fit) -> f64 {
    let mean_square = |curve: &MeasuredCurve| {
        let intervals = curve.points.iter().filter_map(|point| point.ci95);
        statistics::mean(intervals.map(|[low, high]| (0.5 * (high - low)).powi(2)))
    };
    fit.characteristics.iter().map(mean_square).sum::<f64>().sqrt()
}

/// Times, ns, with the torque of the effects as fitted at the motion that the fit made out, mNm; none where the knob may stick.
fn torque(fit: &Fit, calibration: Option<&Calibration>) -> impl Iterator<Item = (i64, f64)> {
    let zero_mnm = calibration.map_or(0.0, |known| known.torque_zero_mnm);
    let model = Model { effects: fit.effects().to_vec(), ..Model::default() };
    fit.points.iter().map(move |point| (nanoseconds(point.t_s), model.torque_mnm(&point.motion()) + zero_mnm))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An inertia, mNm s²/rad, with 4 mNm of Coulomb friction, turned to and fro at 3 rad/s: time, angle and torque.
    fn turned(inertia: f64) -> impl Fn(u32) -> (f64, f64, f64) {
        move |row| {
            let t_s = f64::from(row) / 1_000.0;
            let (sine, cosine) = (3.0 * t_s).sin_cos();
            (t_s, sine, -inertia * 9.0 * sine + 4.0 * cosine.signum())
        }
    }

    fn table(rows: impl Iterator<Item = (f64, f64, f64)>) -> tempfile::NamedTempFile {
        let file = tempfile::Builder::new().suffix(".csv").tempfile().unwrap();
        let rows: String =
            rows.map(|(t_s, angle_rad, torque_mnm)| format!("{t_s},{angle_rad},{torque_mnm}\n")).collect();
        std::fs::write(&file, format!("t_s,angle_rad,torque_mnm\n{rows}")).unwrap();
        file
    }

    #[test]
    fn a_table_is_shown_whole_with_the_torque_of_its_model() {
        let mut source = CaptureSource::open(table((0..50_000).map(turned(0.2))).path()).unwrap();
        let axis = dynamics::Axis::Rotary;
        let columns = Subject { is_live: false, axis, velocity: false, acceleration: false, contact: false };
        assert_eq!(source.subject(), columns);
        let readings: Vec<Reading> = (0..source.capture.len()).map(|row| source.reading(row)).collect();
        assert!(readings.iter().zip(0..50_000).all(|(reading, row)| reading.time_ns == row * 1_000_000));
        assert!(readings[100].turning_positive && !readings[1_000].turning_positive);
        let fit = source.fit.as_ref().unwrap();
        assert!(!fit.points.is_empty());
        for (time_ns, torque_mnm) in torque(fit, None) {
            let row = usize::try_from(time_ns).unwrap() / 1_000_000;
            assert!((torque_mnm - readings[row].torque_mnm).abs() < 0.1, "at row {row}");
        }
        let text = capture_summary::markdown(&source.capture, &source.fit);
        let inertia = text.split("| inertia | ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        assert!((inertia.parse::<f64>().unwrap() - 0.2).abs() < 1e-5, "{text}");
        // More than one poll takes.
        let mut picture = Picture::of_capture(source.capture.len());
        while !picture.run.finished() {
            source.poll(true, &mut picture).unwrap();
        }
        assert_eq!(picture.run.time_ns(), 49_999_000_000);
    }

    #[test]
    fn a_table_is_fitted_with_the_calibration_beside_it() {
        let file = table((0..20_000).map(turned(0.25)));
        let calibration =
            Calibration { gripper_inertia: 0.05, torque_zero_mnm: 0.0, ..crate::model_torque::tests::calibration() };
        let beside = loaded_capture::calibration_beside(file.path());
        let inertia = || {
            let fit = CaptureSource::open(file.path()).unwrap().fit.unwrap();
            fit.parameters.get("inertia").and_then(|inertia| inertia.value).unwrap()
        };
        assert!((inertia() - 0.25).abs() < 1e-4, "the gripper is still in it");
        std::fs::write(&beside, calibration.to_toml()).unwrap();
        let without_gripper = inertia();
        std::fs::remove_file(beside).unwrap();
        assert!((without_gripper - 0.2).abs() < 1e-4, "{without_gripper}");
    }

    #[test]
    fn a_capture_that_cannot_be_fitted_is_shown_alone_with_its_ranges_and_the_reason() {
        let still = (0..1_000).map(|row| (f64::from(row) / 1_000.0, 0.5, f64::from(row % 3) - 1.0));
        let mut source = CaptureSource::open(table(still).path()).unwrap();
        let mut picture = Picture::of_capture(source.capture.len());
        source.poll(true, &mut picture).unwrap();
        let frame = picture.next_frame(0).unwrap();
        assert!(!frame.series.contains_key("signals/model_torque_mnm") && !frame.plots.is_empty());
        let (_, text) = &frame.texts[0];
        assert!(text.contains("**No model:** the knob did not move"), "{text}");
        assert!(text.contains("| torque_mnm | \u{2212}1.00 | 1.00 |") && !text.contains("velocity_rad_s"), "{text}");
    }
}
