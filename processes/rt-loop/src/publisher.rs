//! The publisher thread: ring to shared memory, status, commands, models.
//!
//! Runs on any core but the loop's, at a real-time priority below the loop's where that is permitted. If it stalls, the
//! ring holds sixteen seconds; nothing it does can hold up the loop.

use std::sync::Arc;
use std::time::Duration;

use iceoryx2::port::update_connections::UpdateConnections as _;
use rtrb::{Consumer, Producer};
use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};
use shared_types::services::{
    self, ControlServer, LOOP_STATUS, MessagePublisher, RigNode, SAMPLES_PER_BLOCK, SamplePublisher, ServiceError,
    TextPublisher,
};
use shared_types::{CommandKind, ControlResponse, LoopState, LoopStatus, RunDescription, Sample};

use crate::admission::Admission;
use crate::control::Request;
use crate::model_exchange::ModelExchange;
use crate::realtime::{LoopPort, SharedState, TickLog};

/// Pause between two looks at the ring.
const CYCLE: Duration = Duration::from_millis(1);
/// Time between two statuses while nothing changes, ns.
const STATUS_INTERVAL_NS: u64 = 100_000_000;

/// Cycles without a tick of the loop after which it is given up: five seconds, far beyond any stall of a host that still gives
/// this thread its time.
const HUNG_CYCLES: u32 = 5_000;

/// A rig that does not come back from a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HungRig;

/// Why the stream cannot be published.
#[derive(Debug, thiserror::Error)]
pub enum PublisherError {
    /// A service is not available.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The run's description did not go out.
    #[error("the run's description could not be published ({0})")]
    Description(String),
}

/// The publisher's side of the process.
pub struct StreamPublisher {
    samples: SamplePublisher,
    status: MessagePublisher<LoopStatus>,
    description: TextPublisher,
    control: ControlServer,
    models: ModelExchange,
    incoming: Consumer<Sample>,
    requests: Producer<Request>,
    shared: Arc<SharedState>,
    current: LoopStatus,
    /// Samples that came out of the ring and could not be sent.
    unsent_samples: u64,
    has_run: bool,
    shutdown: bool,
    /// A stop that the loop was not asked for so far: one that found no room is asked for again.
    stop_waits: bool,
    tick_log: Option<TickLog>,
    // Last, since ports go before the node they belong to.
    _node: RigNode,
}

impl StreamPublisher {
    /// Opens the services and publishes the run's description. Models that are sent must pass `admission`, where one
    /// is rendered.
    ///
    /// # Errors
    /// [`PublisherError`] when shared memory is not available.
    pub fn new(
        port: LoopPort,
        description: &RunDescription,
        core: u32,
        admission: Option<Admission>,
    ) -> Result<Self, PublisherError> {
        let node = services::attach("rt-loop")?;
        let LoopPort { samples, requests, models, shared } = port;
        let publisher = Self {
            samples: services::sample_publisher(&node)?,
            status: LOOP_STATUS.publisher(&node)?,
            description: services::RUN_DESCRIPTION.publisher(&node)?,
            control: services::control_server(&node)?,
            models: ModelExchange::open(&node, models, description, admission)?,
            incoming: samples,
            requests,
            shared,
            current: LoopStatus {
                run_id: description.run_id,
                planned_ticks: description.planned_ticks,
                rate_hz: description.rate_hz,
                realtime: description.realtime,
                core,
                process_id: std::process::id(),
                ..LoopStatus::default()
            },
            unsent_samples: 0,
            has_run: false,
            shutdown: false,
            stop_waits: false,
            tick_log: None,
            _node: node,
        };
        let text =
            serde_json::to_string(description).map_err(|error| PublisherError::Description(error.to_string()))?;
        publisher
            .description
            .loan_slice_uninit(text.len())
            .map_err(|error| PublisherError::Description(format!("{error:?}")))?
            .write_from_slice(text.as_bytes())
            .send()
            .map_err(|error| PublisherError::Description(format!("{error:?}")))?;
        Ok(publisher)
    }

    /// Writes how every tick goes besides.
    pub fn log_ticks(&mut self, tick_log: TickLog) {
        self.tick_log = Some(tick_log);
    }

    /// The log of ticks, with everything in it once the loop has ended.
    pub fn into_tick_log(self) -> Option<TickLog> {
        self.tick_log
    }

    /// Publishes until the process is to end, by request or because it `must_end`, and the torque is
    /// down; or until the loop is no longer `alive`.
    ///
    /// # Errors
    /// [`HungRig`] when the loop has not come back from a call of the rig for long: its thread is lost.
    pub fn serve(&mut self, must_end: impl Fn() -> bool, alive: impl Fn() -> bool) -> Result<(), HungRig> {
        let mut next_status_ns = 0;
        let (mut served_ticks, mut idle_cycles) = (0, 0);
        let mut shown = LoopState::Idle;
        loop {
            let state = self.shared.state();
            self.publish_samples();
            if let Some(tick_log) = &mut self.tick_log {
                tick_log.write_waiting();
            }
            self.models.serve(state);
            self.answer_requests();
            if !self.shutdown && must_end() {
                self.begin_shutdown();
            }
            self.stop_waits = self.stop_waits && !self.ask(Request::Stop);
            // A run shorter than a stall of this thread is never seen running, but its samples are there.
            self.has_run |= has_run(state, self.current.published_samples);
            let at_rest = matches!(state, LoopState::Idle | LoopState::Fault);
            // `state` was read before the ring was emptied: nothing of the run can still be in it.
            let finished = self.has_run && at_rest;
            let now_ns = monotonic_time_ns();
            if now_ns >= next_status_ns || state != shown || finished != (self.current.finished == 1) {
                self.current.finished = u32::from(finished);
                // Samples still in the ring found no block to go into: they count as dropped.
                let left_in_ring = if finished { self.incoming.slots() as u64 } else { 0 };
                self.current.dropped_samples = self.shared.dropped_samples() + self.unsent_samples + left_in_ring;
                self.publish_status(state, now_ns);
                next_status_ns = now_ns + STATUS_INTERVAL_NS;
                shown = state;
            }
            if (self.shutdown && at_rest) || !alive() {
                self.publish_samples();
                self.models.close();
                return Ok(());
            }
            // Counted by this thread's own cycles: a process that was stopped as a whole has not hung.
            let now_served = self.shared.served_ticks();
            idle_cycles = if now_served == served_ticks { idle_cycles + 1 } else { 0 };
            served_ticks = now_served;
            if idle_cycles > HUNG_CYCLES {
                self.models.close();
                return Err(HungRig);
            }
            std::thread::sleep(CYCLE);
        }
    }

    fn publish_samples(&mut self) {
        loop {
            let waiting = self.incoming.slots().min(SAMPLES_PER_BLOCK);
            if waiting == 0 {
                return;
            }
            let Ok(mut block) = self.samples.loan_slice_uninit(waiting) else {
                // Out of shared memory: the samples stay in the ring until the next cycle.
                return;
            };
            block.user_header_mut().run_id = self.current.run_id;
            let mut counted = self.current;
            let block = block.write_from_fn(|_| {
                let sample = self.incoming.pop().unwrap_or_default();
                count(&mut counted, &sample);
                sample
            });
            match block.send() {
                Ok(_) => self.current = counted,
                Err(error) => {
                    self.unsent_samples += waiting as u64;
                    tracing::error!("a block of {waiting} samples could not be sent ({error:?})");
                }
            }
        }
    }

    fn answer_requests(&mut self) {
        while let Ok(Some(request)) = self.control.receive() {
            let state = self.shared.state();
            let accepted = match CommandKind::from_code(request.kind) {
                Some(CommandKind::Query) => true,
                Some(CommandKind::Start) => state == LoopState::Armed && !self.stop_waits && self.ask(Request::Start),
                Some(CommandKind::Stop) => {
                    let can_stop = matches!(state, LoopState::Armed | LoopState::Running);
                    self.stop_waits |= can_stop;
                    can_stop
                }
                Some(CommandKind::Shutdown) => {
                    self.begin_shutdown();
                    true
                }
                None => false,
            };
            let response = ControlResponse { accepted: u32::from(accepted), state: state.code() };
            if let Err(error) = request.send_copy(response) {
                tracing::warn!("a control request could not be answered ({error:?})");
            }
        }
    }

    fn begin_shutdown(&mut self) {
        self.shutdown = true;
        self.stop_waits = true;
    }

    fn ask(&mut self, request: Request) -> bool {
        self.requests.push(request).is_ok()
    }

    fn publish_status(&mut self, state: LoopState, now_ns: u64) {
        self.current.monotonic_time_ns = now_ns;
        self.current.wall_clock_time_ns = wall_clock_time_ns();
        self.current.state = state.code();
        self.current.fault = self.shared.fault_code();
        self.current.device_code = self.shared.device_code().cast_unsigned();
        self.current.missed_ticks = self.shared.missed_ticks();
        self.current.overruns = self.shared.overruns();
        self.current.angle_rad = self.shared.angle_rad();
        if let Err(error) = self.status.send_copy(self.current) {
            tracing::warn!("the status could not be sent ({error:?})");
        }
        // Consumers that come between two messages get the history now.
        let _ = self.description.update_connections();
        let _ = self.samples.update_connections();
        self.models.greet();
    }
}

/// Whether the run has begun, by what the loop does now and by what it has left in the ring.
fn has_run(state: LoopState, published_samples: u64) -> bool {
    matches!(state, LoopState::Running | LoopState::Fault) || published_samples > 0
}

/// Adds one sample to the counts of the status.
fn count(status: &mut LoopStatus, sample: &Sample) {
    status.published_samples += 1;
    status.guarded_ticks += u64::from(sample.flags & Sample::GUARDED != 0);
    (status.torque_mnm, status.flags) = (sample.torque_mnm, sample.flags);
    let lateness_ns = sample.whole_lateness_ns(status.rate_hz);
    status.max_lateness_ns = status.max_lateness_ns.max(lateness_ns);
    status.lateness_counts[LoopStatus::lateness_bin(lateness_ns)] += 1;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_came_and_went_while_the_publisher_had_no_processor_is_known_by_its_samples() {
        assert!(!has_run(LoopState::Armed, 0), "nothing has begun");
        assert!(has_run(LoopState::Running, 0));
        assert!(has_run(LoopState::Idle, 9_965), "armed when last looked at, at rest now, samples between");
    }
}
