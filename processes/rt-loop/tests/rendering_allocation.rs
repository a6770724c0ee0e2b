//! Rendering, and changing over to another model, allocates and frees nothing in the real-time thread.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod common;

use allocation_counter::{AllocationInfo, measure};
use common::Bench;
use dynamics::CoggingHarmonic;
use shared_types::Sample;

#[test]
fn a_tick_of_a_rendering_never_touches_the_heap_nor_does_a_change_of_model() {
    // A motor that cogs, so that its compensation has its part.
    let mut bench = Bench::on_rig(&["--hand=multisine", "--duration-s=3", "--motor-cogging=48:1.5"], |known| {
        known.motor_cogging = Some(vec![CoggingHarmonic { per_turn: 48, torque_mnm: 1.5, phase_rad: 0.0 }]);
    });
    let mut waiting = vec![bench.tuned("friction", 1, 6.0), bench.two_bodies()];
    // More than can wait at once: it comes back to whoever sent it.
    let mut too_many = Some(bench.tuned("inertia", 0, 0.05));
    let mut retired = Vec::with_capacity(4);
    bench.start();
    let mut felt = 0;
    for tick in 0..12_000 {
        let elapsed_ticks = if tick % 1_000 == 999 { 3 } else { 1 };
        let measurement = bench.read(elapsed_ticks);
        let model = (tick == 2_000 || tick == 3_000).then(|| waiting.pop().unwrap());
        let refused = (tick == 3_100).then(|| too_many.take().unwrap());

        let mut outcome = None;
        let heap = measure(|| {
            if let Some(model) = model {
                assert!(bench.control.take_model(model).is_ok());
            }
            let refused = refused.map(|model| bench.control.take_model(model));
            let output = bench.step(elapsed_ticks, measurement);
            if let Some(model) = bench.control.retired_model() {
                retired.push(model);
            }
            outcome = Some((refused, output));
        });
        assert_eq!(heap, AllocationInfo::default(), "tick {tick}");
        let (refused, output) = outcome.unwrap();

        if let Some(refused) = refused {
            assert!(refused.is_err(), "one model waits already");
        }
        felt += u32::from(output.sample.unwrap().flags & Sample::MODEL_TAKEN != 0);
        bench.write(&output);
    }
    assert_eq!((felt, retired.len()), (2, 2), "both models were felt, and the two before them given back");
}
