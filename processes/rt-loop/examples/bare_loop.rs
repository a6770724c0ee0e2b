//! The wait of the control loop and nothing else: what the host permits a loop that sleeps and spins as ours does.
//!
//! Same permissions, same schedule, same wait as the control loop; no rig, no ring, no other thread. The ticks go to a
//! file of records, as the control loop's do.
#![allow(clippy::print_stderr, reason = "a measurement says what it was refused")]

use std::io::Write as _;
use std::path::PathBuf;

use clap::Parser;
use rt_loop::realtime::{Permission, Schedule, TickRecord, WakefulProcessors, block_signals, last_core};

/// Runs the wait of the control loop alone.
#[derive(Parser)]
struct Options {
    /// Ticks per second.
    #[arg(long, default_value_t = 10_000.0)]
    rate_hz: f64,
    /// Length, s.
    #[arg(long, default_value_t = 10.0)]
    duration_s: f64,
    /// Core to run on [default: the last one].
    #[arg(long)]
    core: Option<usize>,
    /// How long before each tick it stops sleeping, us [default: as the control loop].
    #[arg(long)]
    spin_us: Option<u64>,
    /// Where the records go.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let ticks = (options.rate_hz * options.duration_s) as usize;
    // Written once here, so that no page of it is met for the first time in the loop.
    let mut records = vec![TickRecord { missed_ticks: 1, ..TickRecord::default() }; ticks];
    let _wakeful = WakefulProcessors::request();
    block_signals();
    if let Some(refused) = Permission::acquire(options.core.unwrap_or_else(last_core)).refused() {
        eprintln!("running without {refused}");
    }
    let schedule = Schedule::starting_now(options.rate_hz);
    let mut schedule = options.spin_us.map_or(schedule, |spin_us| schedule.spinning(spin_us * 1_000));
    let mut taken = 0;
    while taken < ticks {
        let tick = schedule.wait();
        records[taken] = TickRecord::of(tick);
        taken += 1;
        if tick.number + 1 >= ticks as u64 {
            break;
        }
    }
    let mut file = std::io::BufWriter::new(std::fs::File::create(&options.out)?);
    for record in &records[..taken] {
        file.write_all(&record.to_bytes())?;
    }
    Ok(file.flush()?)
}
