//! The loop on the real-time thread: wait, read, step, write, push.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};

use hal::{Apparatus, ApparatusError, Measurement};
use rtrb::{Consumer, Producer, RingBuffer};
use shared_types::rig::monotonic_time_ns;
use shared_types::{LoopState, Sample};

use super::call_watch::CallWatched;
use super::model_rings::{ModelEnds, ModelPort};
use super::schedule::Schedule;
use super::tick_record::{self, TickRecord};
use crate::control::{ControlState, Reading, Request};

/// Seconds that a ring to the publisher holds: as long as a consumer's queue.
const RING_S: f64 = 16.0;
/// Requests that may wait for the loop.
const REQUESTS: usize = 8;

/// What the loop shows of itself besides samples.
#[derive(Debug, Default)]
pub struct SharedState {
    state: AtomicU32,
    fault: AtomicU32,
    device_code: AtomicI32,
    /// Ticks that the loop has served, in a run or not.
    served_ticks: AtomicU64,
    angle_bits: AtomicU64,
    missed_ticks: AtomicU64,
    overruns: AtomicU64,
    dropped_samples: AtomicU64,
    quit: AtomicBool,
}

impl SharedState {
    /// State of the loop.
    #[must_use]
    pub fn state(&self) -> LoopState {
        LoopState::from_code(self.state.load(Ordering::Acquire)).unwrap_or(LoopState::Idle)
    }

    /// Code of the fault, 0 for none.
    #[must_use]
    pub fn fault_code(&self) -> u32 {
        self.fault.load(Ordering::Acquire)
    }

    /// The rig's own code for the fault, 0 for none.
    #[must_use]
    pub fn device_code(&self) -> i32 {
        self.device_code.load(Ordering::Acquire)
    }

    /// Ticks that the loop has served, in a run or not.
    #[must_use]
    pub fn served_ticks(&self) -> u64 {
        self.served_ticks.load(Ordering::Relaxed)
    }

    /// Angle at the newest tick, rad.
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        f64::from_bits(self.angle_bits.load(Ordering::Relaxed))
    }

    /// Ticks that the run has missed so far, also before samples that were dropped.
    #[must_use]
    pub fn missed_ticks(&self) -> u64 {
        self.missed_ticks.load(Ordering::Relaxed)
    }

    /// Times at which one or more ticks were missed.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.overruns.load(Ordering::Relaxed)
    }

    /// Samples so far that found the ring to the publisher full.
    #[must_use]
    pub fn dropped_samples(&self) -> u64 {
        self.dropped_samples.load(Ordering::Relaxed)
    }

    fn count(&self, sample: &Sample, is_dropped: bool) {
        self.missed_ticks.fetch_add(u64::from(sample.missed_ticks), Ordering::Relaxed);
        self.overruns.fetch_add(u64::from(sample.missed_ticks > 0), Ordering::Relaxed);
        self.dropped_samples.fetch_add(u64::from(is_dropped), Ordering::Relaxed);
    }

    /// Ends the loop after its next tick; the amplifier is switched off.
    pub fn quit(&self) {
        self.quit.store(true, Ordering::Release);
    }
}

/// The loop's ends of the rings.
#[derive(Debug)]
struct LoopEnds {
    samples: Producer<Sample>,
    requests: Consumer<Request>,
    models: ModelEnds,
    /// How ticks went, where somebody wants to know.
    records: Option<Producer<TickRecord>>,
}

/// The publisher's ends of the rings.
#[derive(Debug)]
pub struct LoopPort {
    /// Samples from the loop.
    pub samples: Consumer<Sample>,
    /// Requests to the loop.
    pub requests: Producer<Request>,
    /// Models to be rendered.
    pub models: ModelPort,
    /// State of the loop.
    pub shared: Arc<SharedState>,
}

/// The real-time loop, before it is moved to its thread.
pub struct TickLoop {
    apparatus: Box<dyn Apparatus>,
    control: ControlState,
    rate_hz: f64,
    ends: LoopEnds,
    shared: Arc<SharedState>,
    watched: Option<CallWatched>,
    /// Whether the amplifier was switched on and not off again.
    is_on: bool,
}

impl TickLoop {
    /// A loop over `apparatus` at `rate_hz`, and the port through which it is reached.
    ///
    /// Everything that the loop will touch is allocated here.
    #[must_use]
    pub fn new(apparatus: Box<dyn Apparatus>, control: ControlState, rate_hz: f64) -> (Self, LoopPort) {
        let (mut sample_producer, mut sample_consumer) = RingBuffer::new(ring_capacity(rate_hz));
        let (request_producer, request_consumer) = RingBuffer::new(REQUESTS);
        // Touch every page of the ring now, so that the loop does not fault them in one by one.
        while sample_producer.push(Sample::default()).is_ok() {}
        while sample_consumer.pop().is_ok() {}
        let shared = Arc::new(SharedState { angle_bits: AtomicU64::new(f64::NAN.to_bits()), ..SharedState::default() });
        let (models, model_port) = ModelEnds::new();
        let ends = LoopEnds { samples: sample_producer, requests: request_consumer, models, records: None };
        let port = LoopPort {
            samples: sample_consumer,
            requests: request_producer,
            models: model_port,
            shared: Arc::clone(&shared),
        };
        (Self { apparatus, control, rate_hz, ends, shared, watched: None, is_on: false }, port)
    }

    /// Records how every tick goes, from the first to the last, captured or not; the records come out here.
    #[must_use]
    pub fn record_ticks(&mut self) -> Consumer<TickRecord> {
        let (producer, consumer) = tick_record::ring(ring_capacity(self.rate_hz));
        self.ends.records = Some(producer);
        consumer
    }

    /// Has the system calls of the loop watched.
    pub fn watch_calls(&mut self, watched: CallWatched) {
        self.watched = Some(watched);
    }

    /// Runs until a request to quit. The rig is prepared. Its amplifier is on from here to the end of the run, which others may still
    /// be recording then, and is off when this returns or panics.
    ///
    /// Nothing in here allocates, frees, locks, logs or makes a system call but the sleep in the wait.
    ///
    /// # Errors
    /// The apparatus's error when the amplifier does not come on.
    pub fn run(&mut self) -> Result<(), ApparatusError> {
        self.is_on = true;
        self.apparatus.enable()?;
        self.control.arm();
        if let Some(watched) = &self.watched {
            watched.begin();
        }
        self.tick_until_quit();
        self.switch_off();
        Ok(())
    }

    /// Switches the amplifier off, once. The calls of that are not those of a tick.
    fn switch_off(&mut self) {
        if std::mem::take(&mut self.is_on) {
            if let Some(watched) = &self.watched {
                watched.end();
            }
            self.apparatus.disable();
        }
    }

    /// Torque and measurement of a tick; none from a rig that is switched off.
    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        match self.is_on {
            true => self.apparatus.exchange(due_ns, torque_mnm),
            false => Err(ApparatusError::Amplifier),
        }
    }

    fn tick_until_quit(&mut self) {
        let mut schedule = Schedule::starting_now(self.rate_hz);
        let mut push_ns = 0;
        let mut torque_mnm = 0.0;
        let mut refused = None;
        let mut dropped_samples = 0;
        while !self.shared.quit.load(Ordering::Acquire) {
            let tick = schedule.wait();
            if let Some(watched) = &self.watched {
                watched.tick(tick.number);
            }
            let measurement = self.exchange(tick.due_ns, torque_mnm);
            // A torque that the rig did not take ends the run, even if its sensors can still be read.
            let measurement = refused.take().map_or(measurement, Err);
            if self.is_on {
                schedule.shift(self.apparatus.shift_ns());
            }
            let read_ns = monotonic_time_ns();
            while let Ok(request) = self.ends.requests.pop() {
                self.control.request(request);
            }
            self.ends.models.offer(&mut self.control);
            let output = self.control.step(&Reading { elapsed_ticks: tick.elapsed, measurement });
            let stepped_ns = monotonic_time_ns();
            torque_mnm = output.torque_mnm;
            if self.is_on {
                refused = self.apparatus.write_torque(torque_mnm).err();
            }
            let (sensor_read_ns, control_ns) =
                (saturating_u32(read_ns - tick.begun_ns), saturating_u32(stepped_ns - read_ns));
            if let Some(sample) = output.sample {
                let sample = Sample {
                    monotonic_time_ns: tick.due_ns,
                    lateness_ns: tick.begun_ns.saturating_sub(tick.due_ns),
                    sensor_read_ns,
                    control_ns,
                    push_ns,
                    dropped_samples,
                    ..sample
                };
                if sample.flags & Sample::MODEL_TAKEN != 0 {
                    self.ends.models.announce_rendered(sample.tick, tick.due_ns);
                }
                let is_dropped = self.ends.samples.push(sample).is_err();
                dropped_samples = if is_dropped { dropped_samples + 1 } else { 0 };
                self.shared.count(&sample, is_dropped);
            }
            self.ends.models.give_back(&mut self.control);
            self.show(measurement.ok());
            push_ns = saturating_u32(monotonic_time_ns() - stepped_ns);
            if let Some(records) = &mut self.ends.records {
                // A ring that is full for want of a reader must not hold up the loop: the file shows the gap.
                let state = self.control.state().code();
                let _ = records.push(TickRecord { sensor_read_ns, control_ns, push_ns, state, ..TickRecord::of(tick) });
            }
            // Last, so that a driver that does not come back from this keeps nothing of the run from being published.
            if matches!(self.control.state(), LoopState::Idle | LoopState::Fault) {
                self.switch_off();
            }
        }
    }

    fn show(&self, measurement: Option<Measurement>) {
        // Without new data the angle is that of the newest.
        if let Some(measurement) = measurement.filter(|measurement| !measurement.is_stale) {
            self.shared.angle_bits.store(measurement.angle_rad.to_bits(), Ordering::Relaxed);
        }
        self.shared.served_ticks.fetch_add(1, Ordering::Relaxed);
        self.shared.device_code.store(self.control.device_code(), Ordering::Release);
        self.shared.fault.store(self.control.fault().map_or(0, shared_types::Fault::code), Ordering::Release);
        // Armed is what one waits for to begin a run. How long the first reading may take is for the limit of ticks without new data.
        let state = if self.control.awaits_reading() { LoopState::Idle } else { self.control.state() };
        self.shared.state.store(state.code(), Ordering::Release);
    }
}

/// Ticks that a ring to the publisher holds.
fn ring_capacity(rate_hz: f64) -> usize {
    (RING_S * rate_hz) as usize
}

impl Drop for TickLoop {
    /// However the loop ends, the amplifier is off.
    fn drop(&mut self) {
        self.switch_off();
    }
}

fn saturating_u32(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}
