//! The nearest model that the rig renders.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod common;

use common::Bench;
use dynamics::{Effect, Model, effects, knobs};

#[test]
fn a_model_that_the_rig_renders_is_left_as_it_is() {
    let admission = Bench::new().admission;
    for number in 1..=4 {
        let model = knobs::paper_knob(number).unwrap();
        let nearest = admission.nearest(&model).unwrap();
        assert_eq!((nearest.model, nearest.clipped), (model, Vec::<String>::new()));
    }
}

#[test]
fn of_a_light_knob_with_lost_motion_the_gap_and_what_is_behind_it_stay() {
    let model = knobs::paper_knob(5).unwrap();
    let nearest = Bench::new().admission.nearest(&model).unwrap();
    let [asked, rendered] = [&model, &nearest.model].map(|model| model.coupling().unwrap());
    assert_eq!(asked.half_gap_rad, rendered.half_gap_rad);
    let inside = rendered.inner_share * nearest.model.inertia();
    assert!((inside - asked.inner_share * model.inertia()).abs() < 1e-9, "{inside}");
    assert_eq!(model.effect("detent"), nearest.model.effect("detent"));
    assert!(rendered.stiffness_mnm_rad < asked.stiffness_mnm_rad && rendered.damping > asked.damping);
}

#[test]
fn every_part_that_passes_its_bound_comes_to_it() {
    let admission = Bench::new().admission;
    let effect = |kind, values: &[f64]| Effect::new(kind, values);
    let inertia = |value: f64| effect(&effects::inertia::KIND, &[value]);
    let beside = [
        (inertia(1e-5), None),
        (inertia(5.0), None),
        (inertia(0.05), Some(effect(&effects::friction::KIND, &[1.0, 1.0, 90.0, 0.1]))),
        (inertia(0.05), Some(effect(&effects::detent::KIND, &[200.0, 0.01, 0.3]))),
        (inertia(0.05), Some(effect(&effects::detent::KIND, &[900.0, 0.3, 0.3]))),
        (inertia(0.05), Some(effect(&effects::karnopp_stick::KIND, &[500.0, 10.0, 0.01]))),
        (inertia(0.05), Some(effect(&effects::quadratic_drag::KIND, &[100.0]))),
        (inertia(0.05), Some(effect(&effects::eddy_current_damping::KIND, &[3000.0, 3.0]))),
        (inertia(0.03), Some(effect(&effects::shaft_compliance::KIND, &[50_000.0, 0.1]))),
        (inertia(5.0), Some(effect(&effects::shaft_compliance::KIND, &[5000.0, 1.0, 0.99]))),
        (inertia(0.03), Some(effect(&effects::shaft_compliance::KIND, &[5000.0, 1.0, 1.0]))),
        (inertia(0.05), Some(effect(&effects::presliding_hysteresis::KIND, &[0.01, 0.0]))),
    ];
    for (inertia, other) in beside {
        let effects: Vec<Effect> = [Some(inertia), other].into_iter().flatten().collect();
        let model = Model { name: "tried".to_owned(), description: String::new(), effects, ..Model::default() };
        let nearest = admission.nearest(&model).unwrap();
        assert!(admission.admit(&model).is_err() && admission.admit(&nearest.model).is_ok(), "{model:?}");
        assert!(!nearest.clipped.is_empty());
    }
}
