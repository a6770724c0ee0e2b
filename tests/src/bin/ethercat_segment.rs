//! An EtherCAT segment on a network interface, until it is killed; see `tests::ethercat`.

use clap::Parser;
use nix::sched::{CpuSet, sched_setaffinity};
use nix::unistd::Pid;
use shared_types::rig::monotonic_time_ns;
use tests::ethercat::{Options, Port, Segment};

/// An EtherCAT drive and terminal that are numbers
#[derive(Debug, Parser)]
struct Arguments {
    /// The network interface
    #[arg(long)]
    interface: String,
    #[command(flatten)]
    options: Options,
}

fn main() -> anyhow::Result<()> {
    let Arguments { interface, options } = Arguments::parse();
    run_at_once();
    let port = Port::open(&interface)?;
    let mut now_ns = monotonic_time_ns();
    let mut segment = Segment::new(options, now_ns);
    let mut frame = [0; 1514];
    loop {
        let Some((length, came_in_ns)) = port.receive(&mut frame) else {
            now_ns = monotonic_time_ns();
            segment.pass(now_ns);
            continue;
        };
        now_ns = came_in_ns.max(now_ns);
        if segment.process(&mut frame[..length], now_ns) {
            if !segment.keeps_source() {
                frame[6] |= 2;
            }
            port.send(&frame[..length]);
        }
    }
}

/// Hardware does not wait for a scheduler: real-time priority, where it is permitted, off the control loop's core.
#[allow(unsafe_code, reason = "priorities have no safe interface in a crate in use here")]
fn run_at_once() {
    let mut first = CpuSet::new();
    let _ = first.set(0);
    let _ = sched_setaffinity(Pid::from_raw(0), &first);
    let priority = libc::sched_param { sched_priority: 70 };
    // SAFETY: the struct lives beyond the call. Refused, it stays an ordinary process.
    unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const priority) };
}
