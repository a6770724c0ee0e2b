//! Models that are sent to a running replay: admitted or refused, within the bounds of what the rig can render.
#![no_main]

use std::sync::OnceLock;

use dynamics::Model;
use libfuzzer_sys::fuzz_target;
use rt_loop::admission::Admission;
use rt_loop::plan::Plan;
use rt_loop::request::Options;

fn admission() -> &'static Admission {
    static ADMISSION: OnceLock<Admission> = OnceLock::new();
    ADMISSION.get_or_init(|| {
        let options = <Options as clap::Parser>::try_parse_from(["rt-loop", "--render=3", "--duration-s=1"]);
        let plan = Plan::new(&options.expect("options").into()).expect("a plan");
        plan.rendering.expect("a rendering").admission
    })
}

fuzz_target!(|text: &str| fuzz::bounded(text.len(), || {
    let Ok(model) = Model::from_toml(text, "the model") else { return };
    if let Err(error) = admission().admit(&model) {
        assert!(!error.to_string().is_empty());
    }
}));
