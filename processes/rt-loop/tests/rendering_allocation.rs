//! Rendering, and changing over to another model, allocates and frees nothing in the real-time thread.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::Bench;
use shared_types::Sample;

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
fn a_tick_of_a_rendering_never_touches_the_heap_nor_does_a_change_of_model() {
    let mut bench = Bench::new();
    let mut waiting = vec![bench.tuned("friction", 1, 6.0), bench.two_bodies()];
    // More than can wait at once: it comes back to whoever sent it.
    let mut too_many = Some(bench.tuned("inertia", 0, 0.05));
    let mut retired = Vec::with_capacity(4);
    bench.start();
    let mut felt = 0;
    let mut calls = 0;
    for tick in 0..12_000 {
        let elapsed_ticks = if tick % 1_000 == 999 { 3 } else { 1 };
        let measurement = bench.read(elapsed_ticks);
        let model = (tick == 2_000 || tick == 3_000).then(|| waiting.pop().unwrap());
        let refused = (tick == 3_100).then(|| too_many.take().unwrap());

        let before = CALLS.get();
        if let Some(model) = model {
            assert!(bench.control.take_model(model).is_ok());
        }
        let refused = refused.map(|model| bench.control.take_model(model));
        let output = bench.step(elapsed_ticks, measurement);
        if let Some(model) = bench.control.retired_model() {
            retired.push(model);
        }
        calls += CALLS.get() - before;

        if let Some(refused) = refused {
            assert!(refused.is_err(), "one model waits already");
        }
        felt += u32::from(output.sample.unwrap().flags & Sample::MODEL_TAKEN != 0);
        bench.write(&output);
    }
    assert_eq!((felt, retired.len()), (2, 2), "both models were felt, and the two before them given back");
    assert_eq!(calls, 0);
}
