//! The real-time thread, whole and alive: it touches neither heap nor kernel but for its sleep, and what would is caught.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure, and says when it skips")]
#![allow(clippy::disallowed_types, reason = "a lock is planted, to be caught")]

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use allocation_counter::{AllocationInfo, measure};
use clap::Parser as _;
use dynamics::{Model, knobs};
use hal::{Apparatus, ApparatusError, Measurement, RigDescription};
use rt_loop::admission::Admission;
use rt_loop::control::{ControlState, Request};
use rt_loop::plan::Plan;
use rt_loop::realtime::{CallWatch, CallWatchError, DeclaredCallsMade, LoopPort, ModelEvent, PermittedCalls, TickLoop};
use rt_loop::request::Options;
use shared_types::{LoopState, Sample};

/// A rig at which something else is done once in the run, while the sensors are read.
struct Distracted {
    rig: Box<dyn Apparatus>,
    reads_left: u32,
    deed: Box<dyn FnMut() + Send>,
    done: Arc<AtomicBool>,
}

impl Apparatus for Distracted {
    fn description(&self) -> &RigDescription {
        self.rig.description()
    }
    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.rig.enable()
    }
    fn disable(&mut self) {
        self.rig.disable();
    }
    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        self.reads_left = self.reads_left.wrapping_sub(1);
        if self.reads_left == 0 {
            (self.deed)();
            self.done.store(true, Ordering::Release);
        }
        self.rig.exchange(due_ns, torque_mnm)
    }
    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.rig.write_torque(torque_mnm)
    }
}

/// What a run of the loop came to.
struct Outcome {
    heap: AllocationInfo,
    calls: Result<DeclaredCallsMade, CallWatchError>,
    samples: Vec<Sample>,
    /// Whether the run came to its planned end, the deed done: a long stall of the host lets the rig's watchdog end it before.
    whole: bool,
}

/// Attempts at a run that no stall of the host ends too early.
const ATTEMPTS: usize = 5;

/// Runs the loop on a thread of its own, armed, through a run of 1.2 s and to rest again; `meanwhile` has the port while it
/// runs. `deed` is done once on the way.
fn live_run(
    arguments: &[&str],
    deed: impl FnMut() + Send + 'static,
    mut meanwhile: impl FnMut(&mut LoopPort, Option<&Admission>, usize),
) -> Outcome {
    let arguments = ["rt-loop", "--duration-s=1.2"].iter().chain(arguments);
    let plan = Plan::new(&Options::try_parse_from(arguments).unwrap().into()).unwrap();
    let control = ControlState::new(plan.control, &plan.rig.calibration).unwrap();
    let (control, admission) = match plan.rendering {
        Some(rendering) => (control.with_renderer(rendering.renderer), Some(rendering.admission)),
        None => (control, None),
    };
    let done = Arc::new(AtomicBool::new(false));
    let rig = Distracted { rig: plan.apparatus, reads_left: 1_000, deed: Box::new(deed), done: Arc::clone(&done) };
    let (mut tick_loop, mut port) = TickLoop::new(Box::new(rig), control, plan.control.rate_hz);
    let (watch, watched) = CallWatch::start(PermittedCalls::default()).unwrap();
    tick_loop.watch_calls(watched);
    let thread = std::thread::spawn(move || {
        let mut outcome = None;
        let heap = measure(|| outcome = Some(tick_loop.run()));
        outcome.unwrap().unwrap();
        heap
    });
    while port.shared.state() != LoopState::Armed {
        std::thread::sleep(Duration::from_millis(1));
    }
    port.requests.push(Request::Start).unwrap();
    let mut samples = Vec::new();
    while !matches!(port.shared.state(), LoopState::Idle | LoopState::Fault) {
        std::thread::sleep(Duration::from_millis(1));
        while let Ok(sample) = port.samples.pop() {
            samples.push(sample);
        }
        meanwhile(&mut port, admission.as_ref(), samples.len());
    }
    let whole = port.shared.state() == LoopState::Idle && done.load(Ordering::Acquire);
    port.shared.quit();
    let heap = thread.join().unwrap();
    Outcome { heap, calls: watch.finish(), samples, whole }
}

/// `None`, which is said, where calls cannot be watched.
fn made(calls: Result<DeclaredCallsMade, CallWatchError>) -> Option<String> {
    match calls {
        Ok(_) => Some(String::new()),
        Err(CallWatchError::CallsMade(calls)) => Some(calls),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

#[test]
fn a_capture_touches_neither_heap_nor_kernel_but_for_its_sleep() {
    let mut runs = (0..ATTEMPTS).map(|_| live_run(&["--knob=3"], || (), |_, _, _| ()));
    let Outcome { heap, calls, .. } = runs.find(|run| run.whole).unwrap();
    assert_eq!(heap, AllocationInfo::default());
    assert!(made(calls).is_none_or(|calls| calls.is_empty() || panic!("{calls}")));
}

/// A rig whose amplifier takes no torque from some tick on, though its sensors can be read.
struct Refusing {
    rig: Box<dyn Apparatus>,
    writes_left: u32,
}

impl Apparatus for Refusing {
    fn description(&self) -> &RigDescription {
        self.rig.description()
    }
    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.rig.enable()
    }
    fn disable(&mut self) {
        self.rig.disable();
    }
    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        self.rig.exchange(due_ns, torque_mnm)
    }
    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.writes_left = self.writes_left.saturating_sub(1);
        if self.writes_left == 0 { Err(ApparatusError::Device(-7)) } else { self.rig.write_torque(torque_mnm) }
    }
}

#[test]
fn a_torque_that_the_rig_refuses_ends_the_run() {
    let plan = Plan::new(&Options::try_parse_from(["rt-loop", "--knob=3"]).unwrap().into()).unwrap();
    let control = ControlState::new(plan.control, &plan.rig.calibration).unwrap();
    let rig = Refusing { rig: plan.apparatus, writes_left: 1_000 };
    let (mut tick_loop, port) = TickLoop::new(Box::new(rig), control, plan.control.rate_hz);
    let thread = std::thread::spawn(move || tick_loop.run());
    while port.shared.state() != LoopState::Fault {
        std::thread::sleep(Duration::from_millis(1));
    }
    port.shared.quit();
    thread.join().unwrap().unwrap();
    assert_eq!(port.shared.device_code(), -7);
}

#[test]
fn nor_does_a_rendering_whose_model_changes_on_the_way() {
    let mut runs = (0..ATTEMPTS).map(|_| {
        let (mut sent, mut retired) = (0, 0);
        let run = live_run(
            &["--render=3", "--hand=multisine"],
            || (),
            |port, admission, samples| {
                if samples > 100 && sent == 0 {
                    let model: Model = knobs::paper_knob(2).unwrap();
                    port.models.models.push(admission.unwrap().admit(&model).unwrap().rendered).unwrap();
                    sent += 1;
                }
                while let Ok(event) = port.models.events.pop() {
                    retired += usize::from(matches!(event, ModelEvent::Retired(_)));
                }
            },
        );
        (run, sent, retired)
    });
    let (Outcome { heap, calls, samples, .. }, sent, retired) = runs.find(|(run, _, _)| run.whole).unwrap();
    assert!(samples.iter().any(|sample| sample.flags & Sample::MODEL_TAKEN != 0), "the other model is felt");
    assert_eq!((sent, retired), (1, 1));
    assert_eq!(heap, AllocationInfo::default());
    assert!(made(calls).is_none_or(|calls| calls.is_empty() || panic!("{calls}")));
}

#[test]
fn an_allocation_on_the_way_is_caught() {
    let outcome = live_run(&[], || drop(std::hint::black_box(Box::new(1_u32))), |_, _, _| ());
    assert_eq!(outcome.heap.count_total, 1);
}

#[test]
fn memory_that_is_only_freed_is_caught_too() {
    let mut given = Some(Box::new(1_u32));
    let outcome = live_run(&[], move || drop(std::hint::black_box(given.take())), |_, _, _| ());
    assert_eq!(outcome.heap.count_current, -1);
}

#[test]
fn a_system_call_on_the_way_is_caught() {
    let outcome = live_run(&[], || assert!(nix::unistd::getppid().as_raw() >= 0), |_, _, _| ());
    assert!(made(outcome.calls).is_none_or(|calls| calls == format!("number {} (1 times)", libc::SYS_getppid)));
}

#[test]
fn a_lock_that_must_be_waited_for_is_caught() {
    let lock = Arc::new(Mutex::new(0));
    let wanted = Arc::clone(&lock);
    let (taken, is_taken) = std::sync::mpsc::channel();
    let holder = std::thread::spawn(move || {
        let held = lock.lock().unwrap();
        taken.send(()).unwrap();
        // Longer than the loop needs to get there.
        std::thread::sleep(Duration::from_millis(1_200));
        drop(held);
    });
    is_taken.recv().unwrap();
    let outcome = live_run(&[], move || *wanted.lock().unwrap() += 1, |_, _, _| ());
    holder.join().unwrap();
    assert!(made(outcome.calls).is_none_or(|calls| calls.starts_with("futex")));
}
