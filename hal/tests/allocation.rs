//! Reading and writing the simulated rig allocates nothing.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on shall stop")]

use allocation_counter::{AllocationInfo, measure};
use dynamics::{Model, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

#[test]
fn a_tick_of_the_rig_never_touches_the_heap() {
    for knob in (1..=5).map(|number| knobs::paper_knob(number).unwrap()).chain([drawn()]) {
        let name = knob.name.clone();
        let mut rig = SimulatedRig::new(RigParameters::default(), knob, 1).unwrap();
        rig.enable().unwrap();
        let (mut sum, mut late) = (0.0, false);
        let heap = measure(|| {
            for tick in 0..5000_u32 {
                let measurement = rig.read(u64::from(tick) * 100_000).unwrap();
                sum += measurement.torque_mnm;
                rig.write_torque(200.0 * (f64::from(tick) * 1e-3).sin()).unwrap();
            }
            // A stall, the watchdog, and back.
            late = rig.read(2_000_000_000).is_err();
            rig.enable().unwrap();
        });
        assert_eq!(heap, AllocationInfo::default(), "{name}");
        assert!(late && sum.is_finite());
    }
}

/// Knob 3 with waveforms of every kind on top.
fn drawn() -> Model {
    let mut knob = knobs::paper_knob(3).unwrap();
    let more = Model::from_toml(
        "[[effects]]\neffect = \"torque-table\"\norigin = \"drawn.csv\"\nperiod_rad = 0.2\n\
         angle_rad = [0, 0.03, 0.1, 0.13]\ntorque_mnm = [0, 9, 5, -9]\n\
         [[effects]]\neffect = \"detent-triangle\"\ntriangle_amplitude = 1\ntriangle_period = 0.1\n\
         triangle_phase = 0\n\
         [[effects]]\neffect = \"detent-sawtooth\"\nsawtooth_amplitude = 1\nsawtooth_period = 0.1\n\
         sawtooth_phase = 0\nsawtooth_rising_share = 0.9\n\
         [[effects]]\neffect = \"torque-ramp\"\nramp_torque = 1\nramp_start = 0\nramp_width = 1\n",
        "waveforms",
    );
    knob.effects.extend(more.unwrap().effects);
    knob.name = "waveforms".to_owned();
    knob
}

#[test]
fn effects_are_copied_changed_and_dropped_without_the_heap() {
    let knob = drawn();
    let heap = measure(|| {
        for original in &knob.effects {
            let mut effect = *original;
            effect.values_mut().iter_mut().for_each(|value| *value *= 1.1);
            assert!(effect.free_torque_mnm(&dynamics::Motion::default()).is_finite());
        }
    });
    assert_eq!(heap, AllocationInfo::default());
}
