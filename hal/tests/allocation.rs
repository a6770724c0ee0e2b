//! Reading and writing the simulated rig allocates nothing.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall stop")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use dynamics::knobs;
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig};

/// Counts, thread by thread, what it hands on to the system's allocator.
struct Counting;

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // A thread that is ending has no counter left, and no test either.
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
}

#[allow(unsafe_code, reason = "an allocator is an unsafe trait")]
// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps `alloc`'s contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller keeps `dealloc`'s contract, and `pointer` came from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_tick_of_the_rig_never_touches_the_heap() {
    for number in 1..=5 {
        let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(number).unwrap(), 1).unwrap();
        rig.enable().unwrap();
        let before = CALLS.get();
        let mut sum = 0.0;
        for tick in 0..5000_u32 {
            let measurement = rig.read(u64::from(tick) * 100_000).unwrap();
            sum += measurement.torque_mnm;
            rig.write_torque(200.0 * (f64::from(tick) * 1e-3).sin()).unwrap();
        }
        // A stall, the watchdog, and back.
        let late = rig.read(2_000_000_000).is_err();
        rig.enable().unwrap();
        let after = CALLS.get();
        assert_eq!(after, before, "knob {number}");
        assert!(late && sum.is_finite());
    }
}
