//! How long an exchange takes, and how many come back: a rig's file, a rate and a time, and no control loop.
//!
//! `cargo run --release -p hal --example exchange -- RIG.toml 1000 5` prints one line: frames, lost, allocations a frame,
//! p50, p99, p99.9 and longest in µs.
//! `scripts/bench-ethercat` compares it with ethercrab's own transport.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "an example may stop at a failure, and prints what it found"
)]

use std::path::Path;
use std::time::Duration;

use allocation_counter::measure;
use hal::ethercat::EthercatRig;
use hal::{Apparatus as _, RigFile};
use shared_types::rig::monotonic_time_ns;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, file, rate_hz, seconds] = &arguments[..] else { panic!("give RIG.toml, a rate in Hz and a time in s") };
    let (rate_hz, seconds): (f64, f64) = (rate_hz.parse().unwrap(), seconds.parse().unwrap());
    let mut rig = EthercatRig::new(&RigFile::load(Path::new(file)).unwrap(), rate_hz).unwrap();
    if let Err(error) = rig.prepare(&|| false) {
        panic!("{}", rig.description().explain(error));
    }
    rig.enable().unwrap();
    let period_ns = (1e9 / rate_hz) as u64;
    let spun_ns = (period_ns * 3 / 4).min(150_000);
    let mut due_ns = monotonic_time_ns() + period_ns;
    let mut took_ns = Vec::with_capacity((rate_hz * seconds) as usize);
    let mut lost = 0;
    let asked = measure(|| {
        while (took_ns.len() as f64) < rate_hz * seconds {
            // Ticks that the host let pass are passed over.
            due_ns = (due_ns + period_ns).max(monotonic_time_ns());
            // As the control loop waits: a thread that never sleeps is taken off its core by the kernel.
            std::thread::sleep(Duration::from_nanos(due_ns.saturating_sub(monotonic_time_ns() + spun_ns)));
            while monotonic_time_ns() < due_ns {
                std::hint::spin_loop();
            }
            let measured = rig.exchange(due_ns, 0.0);
            took_ns.push(monotonic_time_ns() - due_ns);
            match measured {
                Ok(measurement) => lost += u64::from(measurement.is_stale),
                Err(error) => panic!("{}", rig.description().explain(error)),
            }
        }
    });
    rig.disable();
    let allocations = asked.count_total as f64 / took_ns.len() as f64;
    took_ns.sort_unstable();
    let at = |share: f64| took_ns[((took_ns.len() - 1) as f64 * share) as usize] as f64 * 1e-3;
    println!(
        "{},{lost},{allocations:.2},{:.1},{:.1},{:.1},{:.1}",
        took_ns.len(),
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0)
    );
}
