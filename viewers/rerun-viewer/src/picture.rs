//! What is known of the run, reduced to what a screen can show.

use std::collections::BTreeMap;
use std::time::Duration;

use dynamics::Axis;
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample, rig};

use crate::entities::{self, HEALTH, PARAMETERS_TEXT, PROCESSES_TEXT, SUMMARY};
use crate::frame::{Frame, Points, Series};
use crate::knob_track::{KnobTrack, Motion};
use crate::model_torque::{KnobModel, finite_value};
use crate::rendered::RenderedModel;
use crate::run::Run;
use crate::scatter::Scatters;
use crate::signals::Signals;
use crate::source::Reading;
use crate::timer::Timer;
use crate::{numbers, processes, summary};

/// How often the x-y plots get their new points: a browser pays for each message, not for each point.
const PLOT_PERIOD: Duration = Duration::from_millis(500);
/// How often the curves and the texts are renewed.
const SLOW_PERIOD: Duration = Duration::from_millis(2_500);
/// How often an unchanged knob, its texts and the histogram are sent again, for pages that are opened late.
const REDRAW_PERIOD: Duration = Duration::from_secs(20);
/// How often the other tabs are sent their points.
const TABS_PERIOD: Duration = Duration::from_millis(5_000);

/// Gathers what a source tells and gives frames.
#[derive(Debug, Default)]
pub struct Picture {
    pub run: Run,
    /// Identity of the run that was shown before.
    left: Option<u64>,
    fit_is_new: bool,
    model: Option<KnobModel>,
    signals: Signals,
    scatters: Scatters,
    knob: KnobTrack,
    /// Health and parameters that wait to be sent.
    waiting: Series,
    /// The text of a finished capture.
    capture_text: Option<String>,
    texts_shown: BTreeMap<&'static str, String>,
    histogram_shown: Option<[u64; 12]>,
    redraw: Timer,
    plot: Timer,
    slow: Timer,
    tabs: Timer,
    /// Whether the last frame of the run was given.
    pub ended: bool,
}

impl Picture {
    /// A picture of a finished capture of so many samples: all of it stays in view.
    pub fn of_capture(samples: usize) -> Self {
        Self { scatters: Scatters::of_capture(samples), ..Self::default() }
    }

    pub fn describe(&mut self, description: &RunDescription) {
        if !self.turn_to_run(description.run_id) {
            return;
        }
        let calibration = description.calibration_at_knob();
        let told = calibration.inspect_err(|error| tracing::error!("the model is drawn as for an ideal rig: {error}"));
        self.run.calibration = told.ok().flatten();
        self.run.axis = Some(description.axis);
        self.run.description = Some(description.clone());
    }

    pub fn take_status(&mut self, status: &LoopStatus) {
        if !self.turn_to_run(status.run_id) {
            return;
        }
        self.run.status = Some(*status);
        self.run.source_gone = false;
    }

    /// Takes in the model fitted so far; one of another run is not shown.
    pub fn take_fit(&mut self, fit: &FitUpdate) {
        if self.run.id == Some(fit.run_id) {
            self.model = KnobModel::from_fit(fit).map(|knob| knob.on_rig(self.run.calibration.as_ref()));
            self.run.fit = Some(*fit);
            self.fit_is_new = true;
        }
    }

    /// Takes in the model that a replay renders from some tick on; what cannot be read is not shown.
    pub fn take_rendered(&mut self, change: &ModelChange) {
        if !self.turn_to_run(change.run_id) {
            return;
        }
        let Some(rate_hz) = self.run.rate_hz() else { return };
        match RenderedModel::new(change, self.run.rendered.take(), rate_hz) {
            Ok(rendered) => self.run.rendered = Some(rendered),
            Err(error) => tracing::error!("a rendered model is not shown: {error}"),
        }
    }

    pub fn take_health(&mut self, health: &ProcessHealth) {
        let finished = self.run.finished();
        // After the run its time stands still; a report would have no place on its axis.
        let process = self.run.processes.take_in(health).filter(|_| !finished);
        let (Some(process), Some(newest)) = (process, self.run.newest) else { return };
        let since_ns = health.monotonic_time_ns.checked_signed_diff(newest.monotonic_time_ns).unwrap_or(0);
        let time_ns = newest.time_ns + since_ns;
        for (quantity, value) in HEALTH.into_iter().zip(process.quantities()).filter(|(_, value)| value.is_finite()) {
            let entity = entities::health(quantity, process.kind.name());
            self.waiting.entry(entity).or_default().push(time_ns, &[value]);
        }
    }

    /// Takes in consecutive samples of a run. They are not shown before the run's rate is known, by which their ticks become times.
    pub fn take_samples(&mut self, run_id: u64, samples: &[Sample]) {
        if !self.turn_to_run(run_id) {
            return;
        }
        let Some(rate_hz) = self.run.rate_hz() else { return };
        let is_rendered = self.run.description.as_ref().is_some_and(RunDescription::is_rendered);
        for sample in samples {
            let reading = Reading::of(sample, rate_hz, is_rendered);
            self.take_reading(&reading, Some(rate_hz));
            let Reading { time_ns, angle_rad, velocity_rad_s, acceleration_rad_s2, .. } = reading;
            if let Some(model) = &self.model {
                let known = self.run.calibration.as_ref();
                let not_motion =
                    known.map_or(0.0, |known| known.acceleration_zero_rad_s2 + known.gravity_rad_s2(angle_rad));
                let torque_mnm = model.torque_mnm(angle_rad, velocity_rad_s, acceleration_rad_s2 - not_motion);
                self.signals.push_model_torque(time_ns, torque_mnm);
            }
            self.signals.lateness.push(time_ns, (sample.whole_lateness_ns(rate_hz).max(1) as f64).log10());
        }
    }

    /// Takes in whether a finished capture turns, and the text next to its plots, as Markdown.
    pub fn describe_capture(&mut self, axis: Axis, text: String) {
        // Another one each time that a capture is shown: a page may still show the one before.
        self.turn_to_run(rig::monotonic_time_ns());
        self.run.axis = Some(axis);
        self.capture_text = Some(text);
    }

    /// Ends a capture, which has no more readings. Takes in the model for the curves, if a parameter is identified, and the model's
    /// torque as the torque sensor would read it, mNm, with times in the capture, ns.
    pub fn end_capture(&mut self, model: Option<KnobModel>, torque: impl Iterator<Item = (i64, f64)>) {
        self.model = model;
        self.fit_is_new = true;
        torque.for_each(|(time_ns, torque_mnm)| self.signals.push_model_torque(time_ns, torque_mnm));
        self.run.capture_ended = true;
    }

    /// Takes in what follows on the reading before, in a run of that rate or in a finished capture.
    pub fn take_reading(&mut self, reading: &Reading, rate_hz: Option<f64>) {
        self.signals.push(reading);
        self.knob.push(reading);
        self.scatters.push(reading, rate_hz);
        self.run.motion = Motion::of(reading, self.run.axis.unwrap_or_default()).or(self.run.motion);
        self.run.newest = Some(*reading);
    }

    /// Whether what belongs to this run is shown. A run of another identity begins with an empty picture; late messages of the run that was
    /// left are not shown.
    fn turn_to_run(&mut self, run_id: u64) -> bool {
        if self.left == Some(run_id) {
            return false;
        }
        if self.run.id.is_some_and(|shown| shown != run_id) {
            let processes = std::mem::take(&mut self.run.processes);
            *self = Self { left: self.run.id, run: Run { processes, ..Run::default() }, ..Self::default() };
        }
        self.run.id = Some(run_id);
        true
    }

    /// What is new since the last frame; `None` before a run is known and once all of it was shown. What has not changed is
    /// not sent again: it would push the run's beginning out of the memory that is kept for pages opened later.
    pub fn next_frame(&mut self, frames_dropped: u64) -> Option<Frame> {
        let run_id = self.run.id?;
        let finished = self.run.finished();
        if finished && std::mem::replace(&mut self.ended, true) {
            return None;
        }
        if finished {
            self.signals.close_bins();
        }
        let slow = self.slow.is_due(SLOW_PERIOD) || finished;
        let mut frame = Frame { run_id, time_ns: self.run.time_ns(), series: self.signals.take(), ..Frame::default() };
        if self.redraw.is_due(REDRAW_PERIOD) {
            self.knob.show_again();
            self.texts_shown.clear();
            self.histogram_shown = None;
        }
        let fresh_model = self.model.as_ref().filter(|_| slow && self.fit_is_new);
        frame.knob = self.knob.update(self.run.motion, fresh_model);
        if self.plot.is_due(PLOT_PERIOD) || slow {
            frame.plots = self.scatters.update(fresh_model);
        }
        if slow {
            self.keep_parameters();
            frame.texts = self.fresh_texts(frames_dropped);
            self.signals.step_extremes();
        }
        if self.tabs.is_due(TABS_PERIOD) || finished {
            frame.series.append(&mut self.waiting);
            frame.series.extend(self.timing());
            let histogram = self.run.status.map(|status| status.lateness_counts);
            if histogram != std::mem::replace(&mut self.histogram_shown, histogram) {
                frame.lateness = histogram;
            }
        }
        Some(frame)
    }

    /// The lateness, and the tick's length beside it.
    fn timing(&mut self) -> Series {
        let lateness = self.signals.lateness.take();
        let (Some(first), Some(last)) = (lateness.times_ns.first(), lateness.times_ns.last()) else {
            return Series::new();
        };
        let log10_period_ns = self.run.rate_hz().map_or(f64::NAN, |rate_hz| (1e9 / rate_hz).log10());
        let period = Points { times_ns: vec![*first, *last], values: vec![log10_period_ns; 2] };
        [(entities::TICK_PERIOD.to_owned(), period), (entities::LATENESS.to_owned(), lateness)].into()
    }

    /// Value and interval of each parameter that is identified.
    fn keep_parameters(&mut self) {
        let (Some(fit), Some(newest), true) = (self.run.fit, self.run.newest, self.fit_is_new) else { return };
        self.fit_is_new = false;
        let age_ns = newest.monotonic_time_ns.checked_signed_diff(fit.monotonic_time_ns).unwrap_or(0);
        let time_ns = newest.time_ns - age_ns;
        for (name, estimate) in fit.estimates().into_iter().filter(|(_, estimate)| finite_value(estimate).is_some()) {
            let values = [estimate.value, estimate.ci95_low, estimate.ci95_high];
            self.waiting.entry(entities::parameter(name)).or_default().push(time_ns, &values);
        }
    }

    /// The texts that have changed since they were shown.
    fn fresh_texts(&mut self, frames_dropped: u64) -> Vec<(&'static str, String)> {
        let run = &self.run;
        let mut texts = match &self.capture_text {
            Some(text) => vec![(SUMMARY, text.clone())],
            None => {
                let summary = summary::markdown(run) + &numbers::ranges("last 10 s", self.signals.ranges());
                let processes = processes::markdown(run, rig::monotonic_time_ns(), frames_dropped);
                let axis = run.axis.unwrap_or_default();
                [(SUMMARY, summary), (PARAMETERS_TEXT, summary::parameters(run)), (PROCESSES_TEXT, processes)]
                    .map(|(entity, text)| (entity, axis.words(&text).into_owned()))
                    .into()
            }
        };
        texts.retain(|(entity, text)| self.texts_shown.insert(entity, text.clone()).as_ref() != Some(text));
        texts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(run_id: u64) -> LoopStatus {
        LoopStatus { run_id, rate_hz: 10_000.0, ..LoopStatus::default() }
    }

    /// A picture of the first second of run 7, of which one tick has a torque of 99 mNm.
    fn second_of_run() -> Picture {
        let sample = |tick: u64| Sample {
            seq: tick,
            tick,
            monotonic_time_ns: tick * 100_000,
            angle_rad: tick as f64 * 1e-3,
            torque_mnm: if tick == 5_432 { 99.0 } else { 1.0 },
            ..Sample::default()
        };
        let samples: Vec<Sample> = (0..10_000).map(sample).collect();
        let mut picture = Picture::default();
        picture.take_status(&status(7));
        picture.take_fit(&FitUpdate { run_id: 6, ..FitUpdate::default() });
        assert!(picture.run.fit.is_none(), "that is of another run");
        picture.take_fit(&FitUpdate { run_id: 7, ..FitUpdate::default() });
        picture.take_samples(7, &samples);
        picture
    }

    #[test]
    fn a_second_of_the_run_is_shown_with_at_most_200_points_and_every_spike() {
        let series = second_of_run().next_frame(0).unwrap().series;
        let torque = &series["signals/torque_mnm"];
        assert!(torque.values.len() <= 200);
        let spike = torque.values.iter().position(|&value| value == 99.0).unwrap();
        assert_eq!(torque.times_ns[spike], 543_200_000);
        // Before a parameter is identified.
        assert!(!series.contains_key(&entities::signal(entities::MODEL_TORQUE)) && !series.contains_key("fit/inertia"));
    }

    #[test]
    fn a_new_run_begins_with_an_empty_picture() {
        let mut picture = second_of_run();
        picture.take_status(&status(8));
        let frame = picture.next_frame(0).unwrap();
        assert_eq!((frame.run_id, frame.time_ns, frame.series.len()), (8, 0, 0));
        // A late message of the run that was left.
        picture.take_status(&status(7));
        assert_eq!(picture.run.id, Some(8));
    }

    #[test]
    fn after_the_run_a_last_frame_comes_and_then_nothing_until_the_next_run() {
        let mut picture = second_of_run();
        picture.take_status(&LoopStatus { finished: 1, ..status(7) });
        let last = picture.next_frame(0).unwrap();
        assert_eq!(last.series["signals/angle_rad"].times_ns.last(), Some(&999_900_000));
        assert_eq!(last.texts.len(), 3);
        assert!(picture.next_frame(0).is_none());
        picture.take_status(&status(8));
        assert!(picture.next_frame(0).is_some());
    }

    #[test]
    fn a_finished_capture_is_shown_from_its_first_sample_to_its_last() {
        let reading = |index: i64| Reading {
            time_ns: index * 1_000_000,
            angle_rad: if index == 0 || index == 59_999 { 7.0 } else { 0.1 },
            velocity_rad_s: f64::NAN,
            torque_mnm: 1.0,
            ..Reading::default()
        };
        let readings: Vec<Reading> = (0..60_000).map(reading).collect();
        let mut picture = Picture::of_capture(readings.len());
        picture.describe_capture(Axis::Rotary, "# a capture".to_owned());
        readings.iter().for_each(|reading| picture.take_reading(reading, None));
        picture.end_capture(KnobModel::from_estimates(|_| Some([1.0; 2])), std::iter::empty());
        let frame = picture.next_frame(0).unwrap();
        let angle = &frame.series["signals/angle_rad"];
        assert_eq!((angle.times_ns.first(), angle.times_ns.last()), (Some(&0), Some(&59_999_000_000)));
        assert_eq!(angle.values.iter().filter(|value| **value == 7.0).count(), 2);
        assert!(!frame.series.contains_key("signals/velocity_rad_s"));
        assert!((7_200..=8_000).contains(&frame.plots[0].points.len()));
        assert!(frame.plots[0].model.is_some());
        assert!(frame.knob.is_some());
        assert_eq!(frame.texts, [(SUMMARY, "# a capture".to_owned())]);
        assert!(picture.run.finished() && picture.next_frame(0).is_none());
    }
}
