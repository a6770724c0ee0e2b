//! Which process gets which fault at which moment.

use nix::sys::signal::Signal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};
use shared_types::fault_injection;

/// The process that gets the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Victim {
    /// Writes the archive.
    Recorder,
    /// Fits the model.
    LiveFitter,
    /// Shows the streams.
    Viewer,
    /// Drives the rig.
    ControlLoop,
    /// Starts and watches the others: the program that the operator started.
    Supervisor,
}

impl Victim {
    /// Name of its program.
    #[must_use]
    pub const fn program(self) -> &'static str {
        match self {
            Self::Recorder => "recorder",
            Self::LiveFitter => "live-fitter",
            Self::Viewer => "rerun-viewer",
            Self::ControlLoop => "rt-loop",
            Self::Supervisor => "haptic-camera",
        }
    }

    /// Whether the supervisor brings it back.
    #[must_use]
    pub const fn is_consumer(self) -> bool {
        matches!(self, Self::Recorder | Self::LiveFitter | Self::Viewer)
    }
}

/// What happens to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// SIGKILL: gone at once, as for want of memory.
    Killed,
    /// SIGKILL within the first moments of the program that starts the others, several times over.
    KilledEarly,
    /// SIGSTOP, and SIGCONT five seconds later.
    Stopped,
    /// SIGTERM: somebody asks it to end, as at the end of a session.
    Terminated,
    /// SIGHUP: the terminal is closed.
    HungUp,
    /// A panic on the thread that serves the others.
    Panic,
    /// A panic on the control loop's real-time thread.
    PanicInRealTime,
}

impl Fault {
    /// The signal that causes it, in a process started for fault injection.
    ///
    /// # Panics
    /// Never: the signals exist.
    #[must_use]
    #[allow(clippy::expect_used, reason = "constants of the operating system")]
    pub fn signal(self) -> Signal {
        match self {
            Self::Killed | Self::KilledEarly => Signal::SIGKILL,
            Self::Stopped => Signal::SIGSTOP,
            Self::Terminated => Signal::SIGTERM,
            Self::HungUp => Signal::SIGHUP,
            Self::Panic => Signal::try_from(fault_injection::SERVING_THREAD).expect("a signal"),
            Self::PanicInRealTime => Signal::try_from(fault_injection::REAL_TIME_THREAD).expect("a signal"),
        }
    }
}

/// One fault in one capture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Who gets it.
    pub victim: Victim,
    /// What.
    pub fault: Fault,
    /// When, s after the recorder was first seen.
    pub moment_s: f64,
    /// Planned length of the capture, s.
    pub duration_s: f64,
    /// Draws what else there is to draw.
    pub seed: u64,
}

impl Trial {
    /// Every pair of process and fault.
    pub const KINDS: [(Victim, Fault); 27] = [
        (Victim::Recorder, Fault::Killed),
        (Victim::Recorder, Fault::Stopped),
        (Victim::Recorder, Fault::Terminated),
        (Victim::Recorder, Fault::HungUp),
        (Victim::Recorder, Fault::Panic),
        (Victim::LiveFitter, Fault::Killed),
        (Victim::LiveFitter, Fault::Stopped),
        (Victim::LiveFitter, Fault::Terminated),
        (Victim::LiveFitter, Fault::HungUp),
        (Victim::LiveFitter, Fault::Panic),
        (Victim::Viewer, Fault::Killed),
        (Victim::Viewer, Fault::Stopped),
        (Victim::Viewer, Fault::Terminated),
        (Victim::Viewer, Fault::HungUp),
        (Victim::Viewer, Fault::Panic),
        (Victim::ControlLoop, Fault::Killed),
        (Victim::ControlLoop, Fault::Stopped),
        (Victim::ControlLoop, Fault::Terminated),
        (Victim::ControlLoop, Fault::HungUp),
        (Victim::ControlLoop, Fault::Panic),
        (Victim::ControlLoop, Fault::PanicInRealTime),
        (Victim::Supervisor, Fault::Killed),
        (Victim::Supervisor, Fault::KilledEarly),
        (Victim::Supervisor, Fault::Stopped),
        (Victim::Supervisor, Fault::Terminated),
        (Victim::Supervisor, Fault::HungUp),
        (Victim::Supervisor, Fault::Panic),
    ];

    /// Trial `number` of the study with this seed: the kinds in turn, the moment at random.
    #[must_use]
    pub fn draw(seed: u64, number: u64) -> Self {
        let kinds = Self::KINDS.len() as u64;
        let (victim, fault) = Self::KINDS[(number % kinds) as usize];
        Self::of_kind(victim, fault, seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number))
    }

    /// A trial of this kind, its moment drawn from `seed`: from the start of the processes on for a consumer, in the
    /// middle of the run for those without which there is no capture.
    #[must_use]
    pub fn of_kind(victim: Victim, fault: Fault, seed: u64) -> Self {
        let share = Xoshiro256PlusPlus::seed_from_u64(seed).next_u64() as f64 / u64::MAX as f64;
        let earliest_s = if victim.is_consumer() { 0.0 } else { 1.5 };
        let duration_s = if fault == Fault::Stopped { 10.0 } else { 6.0 };
        Self { victim, fault, moment_s: earliest_s + 2.5 * share, duration_s, seed }
    }
}
