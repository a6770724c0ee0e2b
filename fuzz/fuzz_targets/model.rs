//! Model files: what is read is written and read again as the same, and admitted to a rendering or refused.
#![no_main]

use std::sync::OnceLock;

use dynamics::{Model, Motion};
use libfuzzer_sys::fuzz_target;
use rt_loop::admission::Admission;
use rt_loop::plan::{Options, Plan};

fn admission() -> &'static Admission {
    static ADMISSION: OnceLock<Admission> = OnceLock::new();
    ADMISSION.get_or_init(|| {
        let options = <Options as clap::Parser>::try_parse_from(["rt-loop", "--render=3", "--duration-s=1"]);
        let plan = Plan::new(&options.expect("options")).expect("a plan");
        plan.rendering.expect("a rendering").admission
    })
}

fuzz_target!(|text: &str| {
    let Ok(model) = Model::from_toml(text, "the model") else { return };
    let again = Model::from_toml(&model.to_toml(), "the model written again").expect("what was written is read");
    assert_eq!(model, again);
    let motion = Motion { angle_rad: 0.3, velocity_rad_s: -2.0, acceleration_rad_s2: 5.0, ..Motion::default() };
    let _ = model.torque_mnm(&motion);
    if let Err(error) = admission().admit(&model) {
        assert!(!error.to_string().is_empty());
    }
});
