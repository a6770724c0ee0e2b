//! A tick asks nothing of the heap.

use allocation_counter::measure;
use hal::ethercat::EthercatRig;
use hal::{Apparatus as _, RigFile};
use shared_types::rig::monotonic_time_ns;

use super::{RIG, Wired};

const RATE_HZ: f64 = 1_000.0;
const TICKS: u64 = 1_000;

#[test]
fn a_tick_allocates_nothing_with_distributed_clocks_or_without() {
    let Some(wired) = Wired::new(&[]) else { return };
    // One process drives one bus, once: the clocks are what costs more.
    let text = RIG.replace("[settings]\n", "[settings]\ndistributed_clocks = true\n");
    let file = RigFile::parse(&text, &wired.bench.path("rig.toml")).unwrap();
    let mut rig = EthercatRig::new(&file, RATE_HZ).unwrap();
    let prepared = rig.prepare(&|| false);
    assert_eq!(prepared, Ok(()), "{:?}", rig.description().codes.last());
    rig.enable().unwrap();
    let mut exchanged = 0;
    let mut due_ns = monotonic_time_ns();
    for _ in 0..TICKS {
        due_ns = due_ns.saturating_add_signed(rig.shift_ns()) + 1_000_000;
        std::thread::sleep(std::time::Duration::from_nanos(due_ns.saturating_sub(monotonic_time_ns())));
        let mut measured = None;
        let asked = measure(|| {
            measured = Some(rig.exchange(due_ns, 0.1));
            rig.write_torque(0.1).unwrap();
        });
        assert_eq!((asked.count_total, asked.bytes_total), (0, 0), "in a tick");
        exchanged += u64::from(!measured.unwrap().unwrap().is_stale);
    }
    assert!(exchanged > TICKS / 2, "{exchanged} of {TICKS} frames came back");
    let asked = measure(|| rig.disable());
    assert_eq!((asked.count_total, asked.bytes_total), (0, 0), "as it switches off");
}
