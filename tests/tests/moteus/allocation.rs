//! A tick of the driver never touches the heap.

use allocation_counter::{AllocationInfo, measure};
use hal::moteus::MoteusRig;
use hal::{Apparatus as _, RigFile};
use tests::Bench;

use super::{Server, rig};

#[test]
fn a_tick_of_the_driver_never_touches_the_heap() {
    for way in [&[][..], &["--uart"]] {
        let bench = Bench::new().unwrap();
        let _server = Server::start(&bench, way);
        let file = RigFile::load(&bench.path(&rig(&bench, |text| text))).unwrap();
        let mut moteus = MoteusRig::new(&file, 1_000.0).unwrap();
        moteus.prepare(&|| false).unwrap();
        moteus.enable().unwrap();
        let mut answers = 0;
        let heap = measure(|| {
            for tick in 0..1_000_u32 {
                let read = moteus.exchange(u64::from(tick) * 1_000_000, 5.0 * (f64::from(tick) * 1e-2).sin()).unwrap();
                answers += u32::from(!read.is_stale);
            }
        });
        moteus.disable();
        assert_eq!(heap, AllocationInfo::default());
        // How many of them come in time is the machine's.
        assert!(answers > 0);
    }
}
