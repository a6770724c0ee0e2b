#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]
use hal::Apparatus as _;
use hal::simulated::{RigParameters, SimulatedRig};
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::*;
fn main() {
    let nothing = dynamics::knobs::Fixture::None.model().unwrap();
    let rig = SimulatedRig::new(RigParameters::default(), nothing, 1).unwrap();
    let d = rig.description();
    for rate in [20_000.0,10_000.0, 5_000.0] {
    let gains = RenderGains::at_rate(rate).unwrap();
    let b = Bounds::of(&gains, &d.calibration, &d.limits, rate);
    for inertia in [0.02085, 0.05, 0.1] {
    let mut m = dynamics::knobs::paper_knob(5).unwrap();
    m.effects[0].values_mut()[0]=inertia;
    m.effects.last_mut().unwrap().values_mut()[1]=0.00095/inertia;
    let t=std::time::Instant::now();
    println!("{rate} {inertia} {:?} {:?}", b.check(&m), t.elapsed());
    let t=std::time::Instant::now();
    println!("{:?} {:?}", b.nearest_contact(&m), t.elapsed());
    }}
}
