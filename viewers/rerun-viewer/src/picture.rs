//! What is known of the run, reduced to what a screen can show.

use std::time::{Duration, Instant};

use dynamics::{Axis, Calibration};
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::consumers::Consumers;
use crate::decimation::{Decimator, Keep};
use crate::entities::{self, HEALTH};
use crate::frame::{Frame, SeriesRows};
use crate::glance::Glance;
use crate::knob_track::KnobTrack;
use crate::model_torque::{KnobModel, finite_value};
use crate::rendered::RenderedModel;
use crate::scatter::{Abscissa, Scatter, ScatterPoint};
use crate::signals::Signals;
use crate::source::{Event, Reading};
use crate::waiting_rows::WaitingRows;
use crate::{process_conditions, summary};

/// Bin of the lateness, of which only the largest stays.
const LATENESS_BIN_NS: i64 = 20_000_000;
/// Points a second of the x-y plots: more in 10 s would lie over each other.
const SCATTER_RATE_HZ: f64 = 200.0;
/// Points of the x-y plots whose range the axes show: 10 s.
const SCATTER_POINTS: usize = 2_000;
/// Points of the x-y plots for the whole of a finished capture.
const WHOLE_SCATTER_POINTS: usize = 8_000;
/// How often the x-y plots get their new points. A browser pays for each message, not for each point, and without a
/// graphics card falls behind if more come than it takes in.
const PLOT_PERIOD: Duration = Duration::from_millis(500);
/// How often the curves and the texts are renewed.
const SLOW_PERIOD: Duration = Duration::from_millis(2_500);
/// Slow periods that the extremes in the text look back: 10 s, as the plots do.
const EXTREMES_KEPT: usize = 4;
/// How often what has not changed is shown again: what is kept for a page that is opened late may begin later than the
/// last change.
const REDRAW_PERIOD: Duration = Duration::from_secs(20);
/// How often the other tabs are sent their points.
const TABS_PERIOD: Duration = Duration::from_millis(5_000);

/// Gathers events and gives frames.
#[derive(Debug)]
pub struct Picture {
    run_id: Option<u64>,
    description: Option<RunDescription>,
    /// Whether what is shown turns, once that is known.
    axis: Option<Axis>,
    status: Option<LoopStatus>,
    fit: Option<FitUpdate>,
    fit_is_new: bool,
    model: Option<KnobModel>,
    calibration: Option<Calibration>,
    rendered: Option<RenderedModel>,
    consumers: Consumers,
    signals: Signals,
    lateness: Decimator,
    /// Rows of health and parameters that wait to be sent.
    waiting: WaitingRows,
    scatters: [Scatter; 2],
    scatter_phase: f64,
    /// Share of a finished capture's samples that the x-y plots show.
    whole_scatter_share: Option<f64>,
    newest: Option<Newest>,
    histogram_shown: Option<[u64; 12]>,
    text: Option<String>,
    texts_shown: [String; 3],
    knob: KnobTrack,
    newest_reading: Option<Reading>,
    next_redraw: Instant,
    next_plot: Instant,
    next_slow: Instant,
    next_tabs: Instant,
    source_ended: bool,
    source_gone: bool,
    ended: bool,
}

/// Ties the clock to the run's time.
#[derive(Clone, Copy, Debug)]
struct Newest {
    time_ns: i64,
    monotonic_time_ns: u64,
}

impl Default for Picture {
    fn default() -> Self {
        Self {
            run_id: None,
            description: None,
            axis: None,
            rendered: None,
            status: None,
            fit: None,
            fit_is_new: false,
            model: None,
            calibration: None,
            consumers: Consumers::default(),
            signals: Signals::new(EXTREMES_KEPT),
            lateness: Decimator::new(Keep::Max, LATENESS_BIN_NS),
            waiting: WaitingRows::default(),
            scatters: [Abscissa::Angle, Abscissa::Velocity].map(|abscissa| Scatter::new(abscissa, SCATTER_POINTS)),
            scatter_phase: 0.0,
            whole_scatter_share: None,
            newest: None,
            histogram_shown: None,
            text: None,
            texts_shown: Default::default(),
            knob: KnobTrack::default(),
            newest_reading: None,
            next_redraw: Instant::now(),
            next_plot: Instant::now(),
            next_slow: Instant::now(),
            next_tabs: Instant::now(),
            source_ended: false,
            source_gone: false,
            ended: false,
        }
    }
}

impl Picture {
    /// A picture of a finished capture of so many samples: all of it stays in view.
    #[allow(clippy::cast_precision_loss, reason = "a share")]
    pub fn of_capture(samples: usize) -> Self {
        Self {
            scatters: [Abscissa::Angle, Abscissa::Velocity]
                .map(|abscissa| Scatter::new(abscissa, WHOLE_SCATTER_POINTS)),
            whole_scatter_share: Some((WHOLE_SCATTER_POINTS as f64 / samples.max(1) as f64).min(1.0)),
            ..Self::default()
        }
    }

    /// The sample rate, once the run or the loop has published it, Hz.
    pub fn rate_hz(&self) -> Option<f64> {
        let described = self.description.as_ref().map(|description| description.rate_hz);
        described.or(self.status.map(|status| status.rate_hz)).filter(|rate_hz| *rate_hz > 0.0)
    }

    /// Whether the rig turns, once the run or the capture is known.
    pub fn axis(&self) -> Option<Axis> {
        self.axis
    }

    /// Whether the run watches a contact.
    pub fn has_contact(&self) -> bool {
        self.description.as_ref().is_some_and(|run| run.contact)
    }

    /// Whether the run has ended and all of it was taken in.
    pub fn finished(&self) -> bool {
        self.source_ended || self.status.is_some_and(|status| status.finished != 0)
    }

    /// Takes in what a source has to tell.
    pub fn take_in(&mut self, event: Event<'_>) {
        match event {
            Event::Description(description) => {
                self.turn_to_run(description.run_id);
                self.calibration = calibration(description);
                self.axis = Some(description.axis);
                self.description = Some(description.clone());
            }
            Event::Axis(axis) => self.axis = Some(axis),
            Event::Status(status) => {
                self.turn_to_run(status.run_id);
                self.status = Some(*status);
                self.source_gone = false;
            }
            Event::SourceGone => self.source_gone = true,
            Event::Fit(fit) if self.run_id == Some(fit.run_id) => {
                let knob = KnobModel::from_fit(fit);
                self.model = knob.map(|knob| self.calibration.as_ref().map_or(knob, |known| knob.on_rig(known)));
                self.fit = Some(*fit);
                self.fit_is_new = true;
            }
            Event::Fit(_) => {}
            Event::ModelChange(change) => self.take_in_model(change),
            Event::Health(health) => self.take_in_health(health),
            Event::Samples { run_id, samples } => {
                self.turn_to_run(run_id);
                if let Some(rate_hz) = self.rate_hz() {
                    samples.iter().for_each(|sample| self.take_in_sample(sample, rate_hz));
                }
            }
            Event::Readings(readings) => {
                // Another one each time that a capture is shown: a page may still show the one before.
                self.turn_to_run(self.run_id.unwrap_or_else(shared_types::rig::monotonic_time_ns));
                let share = self.whole_scatter_share.unwrap_or(1.0);
                readings.iter().for_each(|reading| self.take_in_reading(reading, share));
                if let Some(reading) = readings.last() {
                    self.newest = Some(Newest { time_ns: reading.time_ns, monotonic_time_ns: 0 });
                }
            }
            Event::Model { model, torque } => {
                self.model = model.copied();
                self.fit_is_new = true;
                torque.iter().for_each(|moment| self.signals.push_model_torque(moment.time_ns, moment.torque_mnm));
            }
            Event::Text(text) => self.text = Some(text.to_owned()),
            Event::End => self.source_ended = true,
        }
    }

    /// The model that is felt from now on; what cannot be read is not shown.
    fn take_in_model(&mut self, change: &ModelChange) {
        self.turn_to_run(change.run_id);
        let Some(rate_hz) = self.rate_hz() else { return };
        match RenderedModel::new(change, self.rendered.take(), rate_hz) {
            Ok(rendered) => self.rendered = Some(rendered),
            Err(error) => tracing::error!("a rendered model is not shown: {error}"),
        }
    }

    /// A run of another identity begins with an empty picture.
    fn turn_to_run(&mut self, run_id: u64) {
        if self.run_id.is_some_and(|shown| shown != run_id) {
            let consumers = std::mem::take(&mut self.consumers);
            *self = Self { consumers, ..Self::default() };
        }
        self.run_id = Some(run_id);
    }

    #[allow(clippy::cast_precision_loss, reason = "lateness is shown with a few digits")]
    fn take_in_sample(&mut self, sample: &Sample, rate_hz: f64) {
        let time_ns = nanoseconds(sample.time_s(rate_hz));
        let Sample { angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm, contact, .. } = *sample;
        // Of a rendered knob the sensor reads minus what it takes from the hand.
        let is_rendered = self.description.as_ref().is_some_and(RunDescription::is_rendered);
        let torque_mnm = if is_rendered { -torque_mnm } else { torque_mnm };
        let turning_positive = velocity_rad_s > 0.0;
        let stuck = is_rendered.then_some(sample.flags & Sample::STUCK != 0);
        let reading = Reading {
            time_ns,
            angle_rad,
            velocity_rad_s,
            acceleration_rad_s2,
            torque_mnm,
            contact,
            turning_positive,
            stuck,
        };
        self.take_in_reading(&reading, SCATTER_RATE_HZ / rate_hz);
        if let Some(model) = self.model {
            let known = self.calibration.as_ref();
            let not_motion =
                known.map_or(0.0, |known| known.acceleration_zero_rad_s2 + known.gravity_rad_s2(angle_rad));
            let torque_mnm = model.torque_mnm(angle_rad, velocity_rad_s, acceleration_rad_s2 - not_motion);
            self.signals.push_model_torque(time_ns, torque_mnm);
        }
        self.lateness.push(time_ns, (sample.lateness_ns.max(1) as f64).log10());
        self.newest = Some(Newest { time_ns, monotonic_time_ns: sample.monotonic_time_ns });
    }

    fn take_in_reading(&mut self, reading: &Reading, scatter_share: f64) {
        self.signals.push(reading);
        self.knob.push(reading);
        self.newest_reading = Some(*reading);
        self.scatter_phase += scatter_share;
        if self.scatter_phase >= 1.0 {
            self.scatter_phase = self.scatter_phase.fract();
            let Reading { angle_rad, velocity_rad_s, torque_mnm, turning_positive, .. } = *reading;
            let [over_angle, over_velocity] = &mut self.scatters;
            over_angle.push(ScatterPoint { x: angle_rad, torque_mnm, turning_positive });
            over_velocity.push(ScatterPoint { x: velocity_rad_s, torque_mnm, turning_positive });
        }
    }

    #[allow(clippy::cast_precision_loss, reason = "counts are shown with a few digits")]
    fn take_in_health(&mut self, health: &ProcessHealth) {
        let Some(condition) = self.consumers.take_in(health) else {
            return;
        };
        // After the run its time stands still; a report would have no place on its axis.
        let (Some(newest), false) = (self.newest, self.finished()) else {
            return;
        };
        let values =
            [condition.cpu_share_percent, condition.resident_mib, condition.lost_samples as f64, condition.latency_ms];
        let time_ns = newest.time_ns + since(newest.monotonic_time_ns, condition.monotonic_time_ns);
        for (quantity, value) in HEALTH.into_iter().zip(values).filter(|(_, value)| value.is_finite()) {
            self.waiting.push(entities::health(quantity, condition.kind.name()), time_ns, &[value]);
        }
    }

    /// What is new since the last frame; `None` before a run is known and once all of it was shown.
    ///
    /// What has not changed is not sent again: it would push the run's beginning out of the
    /// memory that is kept for pages opened later. `frames_dropped` is what the screen has missed.
    pub fn next_frame(&mut self, frames_dropped: u64) -> Option<Frame> {
        let run_id = self.run_id?;
        let finished = self.finished();
        if finished && std::mem::replace(&mut self.ended, true) {
            return None;
        }
        if finished {
            self.signals.close_bins();
            self.lateness.close_bin();
        }
        let now = Instant::now();
        let slow = is_due(&mut self.next_slow, now, SLOW_PERIOD) || finished;
        let mut frame = Frame {
            run_id,
            time_ns: self.newest.map_or(0, |newest| newest.time_ns),
            series: self.signals.take_rows(),
            plots: Vec::new(),
            lateness: None,
            knob: None,
            texts: Vec::new(),
        };
        if is_due(&mut self.next_redraw, now, REDRAW_PERIOD) {
            self.knob.show_again();
            self.texts_shown = Default::default();
            self.histogram_shown = None;
        }
        let fresh_model = self.model.filter(|_| slow && self.fit_is_new);
        frame.knob = self.knob.update(fresh_model.as_ref());
        if is_due(&mut self.next_plot, now, PLOT_PERIOD) || finished {
            frame.plots = self.scatters.iter_mut().filter_map(|plot| plot.update(fresh_model.as_ref())).collect();
        }
        if slow {
            self.keep_parameters();
            frame.texts = self.fresh_texts(frames_dropped);
            self.signals.step_extremes();
        }
        if is_due(&mut self.next_tabs, now, TABS_PERIOD) || finished {
            frame.series.extend(self.waiting.take());
            frame.series.extend(self.timing_rows());
            let histogram = self.status.map(|status| status.lateness_counts);
            if histogram != std::mem::replace(&mut self.histogram_shown, histogram) {
                frame.lateness = histogram;
            }
        }
        Some(frame)
    }

    fn timing_rows(&mut self) -> Vec<SeriesRows> {
        let Some(lateness) = SeriesRows::of_points(entities::LATENESS.to_owned(), self.lateness.take()) else {
            return Vec::new();
        };
        let log10_period_ns = self.rate_hz().map_or(f64::NAN, |rate_hz| (1e9 / rate_hz).log10());
        let times_ns: Vec<i64> =
            lateness.times_ns.first().into_iter().chain(lateness.times_ns.last()).copied().collect();
        let values = vec![log10_period_ns; times_ns.len()];
        let period = SeriesRows { entity: entities::TICK_PERIOD.to_owned(), times_ns, values, values_per_row: 1 };
        vec![lateness, period]
    }

    /// Value and interval of each parameter that is identified.
    fn keep_parameters(&mut self) {
        let (Some(fit), Some(newest), true) = (self.fit, self.newest, self.fit_is_new) else {
            return;
        };
        self.fit_is_new = false;
        let time_ns = newest.time_ns - since(fit.monotonic_time_ns, newest.monotonic_time_ns);
        for (name, estimate) in fit.estimates().into_iter().filter(|(_, estimate)| finite_value(estimate).is_some()) {
            let values = [estimate.value, estimate.ci95_low, estimate.ci95_high];
            self.waiting.push(entities::parameter(name), time_ns, &values);
        }
    }

    /// The texts that have changed since they were shown.
    fn fresh_texts(&mut self, frames_dropped: u64) -> Vec<(&'static str, String)> {
        let texts = match &self.text {
            Some(text) => [text.clone(), String::new(), String::new()],
            None => {
                let facts = self.facts(frames_dropped);
                let axis = self.axis().unwrap_or_default();
                [summary::markdown(&facts), summary::parameters(&facts), process_conditions::markdown(&facts)]
                    .map(|text| axis.words(&text).into_owned())
            }
        };
        let entities = [entities::SUMMARY, entities::PARAMETERS_TEXT, entities::PROCESSES_TEXT];
        let mut fresh = Vec::new();
        for ((entity, text), shown) in entities.into_iter().zip(texts).zip(&mut self.texts_shown) {
            if text != *shown {
                shown.clone_from(&text);
                fresh.push((entity, text));
            }
        }
        fresh
    }

    /// What is to be read from two metres.
    pub fn glance(&self, frames_dropped: u64) -> Glance {
        let recording = self.run_id.map(entities::recording);
        Glance::of(&self.facts(frames_dropped), self.axis.unwrap_or_default(), recording, self.finished())
    }

    fn facts(&self, frames_dropped: u64) -> summary::Facts<'_> {
        summary::Facts {
            description: self.description.as_ref(),
            status: self.status.as_ref(),
            source_gone: self.source_gone,
            fit: self.fit.as_ref(),
            rendered: self.rendered.as_ref(),
            ranges: self.signals.ranges(),
            consumers: &self.consumers,
            time_s: self.newest.map(|newest| seconds(newest.time_ns)),
            frames_dropped,
            newest: self.newest_reading,
            motion: self.knob.motion(),
            now_ns: shared_types::rig::monotonic_time_ns(),
        }
    }
}

/// The rig's calibration; without it the model's torque is drawn as if the rig were ideal.
fn calibration(description: &RunDescription) -> Option<Calibration> {
    let known = description.calibration_at_knob();
    known.inspect_err(|error| tracing::error!("the model is drawn as for an ideal rig: {error}")).ok()?
}

/// Whether it is time, and if so when it is next.
fn is_due(next: &mut Instant, now: Instant, period: Duration) -> bool {
    let due = now >= *next;
    if due {
        *next = now + period;
    }
    due
}

/// From one monotonic time to another, ns, negative when `later` is the earlier one.
fn since(earlier: u64, later: u64) -> i64 {
    i64::try_from(i128::from(later) - i128::from(earlier)).unwrap_or(0)
}

#[allow(clippy::cast_possible_truncation, reason = "a run would have to last 292 years")]
fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

#[allow(clippy::cast_precision_loss, reason = "shown with a few digits")]
fn seconds(nanoseconds: i64) -> f64 {
    nanoseconds as f64 / 1e9
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use super::*;

    fn status(run_id: u64) -> LoopStatus {
        LoopStatus { run_id, rate_hz: 10_000.0, ..LoopStatus::default() }
    }

    fn second_of_samples() -> Vec<Sample> {
        let sample = |tick: u64| Sample {
            seq: tick,
            tick,
            monotonic_time_ns: tick * 100_000,
            angle_rad: tick as f64 * 1e-3,
            torque_mnm: if tick == 5_432 { 99.0 } else { 1.0 },
            ..Sample::default()
        };
        (0..10_000).map(sample).collect()
    }

    fn rows<'a>(frame: &'a Frame, entity: &str) -> Option<&'a SeriesRows> {
        frame.series.iter().find(|rows| rows.entity == entity)
    }

    #[test]
    fn a_second_of_the_run_is_shown_with_at_most_200_points_and_every_spike() {
        let mut picture = Picture::default();
        picture.take_in(Event::Status(&status(7)));
        picture.take_in(Event::Samples { run_id: 7, samples: &second_of_samples() });
        let frame = picture.next_frame(0).unwrap();
        let torque = rows(&frame, "signals/torque_mnm").unwrap();
        assert!(torque.values.len() <= 200);
        let spike = torque.values.iter().position(|&value| value == 99.0).unwrap();
        assert_eq!(torque.times_ns[spike], 543_200_000);
    }

    #[test]
    fn there_is_no_model_torque_before_a_parameter_is_identified() {
        let mut picture = Picture::default();
        picture.take_in(Event::Status(&status(7)));
        picture.take_in(Event::Fit(&FitUpdate { run_id: 7, ..FitUpdate::default() }));
        picture.take_in(Event::Samples { run_id: 7, samples: &second_of_samples() });
        let frame = picture.next_frame(0).unwrap();
        assert!(rows(&frame, &entities::signal(entities::MODEL_TORQUE)).is_none());
        assert!(rows(&frame, "fit/inertia").is_none());
    }

    #[test]
    fn a_new_run_begins_with_an_empty_picture() {
        let mut picture = Picture::default();
        picture.take_in(Event::Status(&status(7)));
        picture.take_in(Event::Samples { run_id: 7, samples: &second_of_samples() });
        picture.take_in(Event::Status(&status(8)));
        let frame = picture.next_frame(0).unwrap();
        assert_eq!((frame.run_id, frame.time_ns, frame.series.len()), (8, 0, 0));
    }

    #[test]
    fn after_the_run_a_last_frame_comes_and_then_nothing_until_the_next_run() {
        let mut picture = Picture::default();
        picture.take_in(Event::Status(&status(7)));
        picture.take_in(Event::Samples { run_id: 7, samples: &second_of_samples() });
        picture.take_in(Event::Status(&LoopStatus { finished: 1, ..status(7) }));
        let last = picture.next_frame(0).unwrap();
        assert_eq!(rows(&last, "signals/angle_rad").unwrap().times_ns.last(), Some(&999_900_000));
        assert_eq!(last.texts.len(), 3);
        assert!(picture.next_frame(0).is_none());
        picture.take_in(Event::Status(&status(8)));
        assert!(picture.next_frame(0).is_some());
    }

    #[test]
    fn a_finished_capture_is_shown_from_its_first_sample_to_its_last() {
        let readings: Vec<Reading> = (0..60_000)
            .map(|index| Reading {
                time_ns: index * 1_000_000,
                angle_rad: if index == 0 || index == 59_999 { 7.0 } else { 0.1 },
                velocity_rad_s: f64::NAN,
                acceleration_rad_s2: f64::NAN,
                torque_mnm: 1.0,
                contact: f64::NAN,
                turning_positive: true,
                stuck: None,
            })
            .collect();
        let mut picture = Picture::of_capture(readings.len());
        picture.take_in(Event::Readings(&readings));
        picture.take_in(Event::Model { model: KnobModel::from_values(|_| Some(1.0)).as_ref(), torque: &[] });
        picture.take_in(Event::Text("# a capture"));
        picture.take_in(Event::End);
        let frame = picture.next_frame(0).unwrap();
        let angle = rows(&frame, "signals/angle_rad").unwrap();
        assert_eq!((angle.times_ns.first(), angle.times_ns.last()), (Some(&0), Some(&59_999_000_000)));
        assert_eq!(angle.values.iter().filter(|value| **value == 7.0).count(), 2);
        assert!(rows(&frame, "signals/velocity_rad_s").is_none());
        assert!(frame.plots[0].points.len() > WHOLE_SCATTER_POINTS * 9 / 10);
        assert!(frame.plots[0].model.is_some());
        assert!(frame.knob.is_some());
        assert_eq!(frame.texts, [(entities::SUMMARY, "# a capture".to_owned())]);
        assert!(picture.finished() && picture.next_frame(0).is_none());
    }

    #[test]
    fn a_fit_of_another_run_is_not_shown() {
        let mut picture = Picture::default();
        picture.take_in(Event::Status(&status(7)));
        picture.take_in(Event::Fit(&FitUpdate { run_id: 6, ..FitUpdate::default() }));
        assert!(picture.fit.is_none());
    }
}
