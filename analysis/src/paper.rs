//! What Swindells and MacLean print of their five knobs.

use dynamics::{Effect, Model, effects, knobs};
use report::{PaperKnob, PaperValue, true_value};

/// Descriptions of Table 4 and mean sizes of the fits' 95 % intervals in Table 5, mNm.
const PRINTED: [(&str, f64); 5] = [
    ("Uniform position; moderate friction; low inertia", 0.30),
    ("Uniform position; low friction; high inertia", 0.19),
    ("Subtle detents; low friction; low inertia", 0.091),
    ("Moderate detents; moderate friction; low inertia", 0.073),
    (
        "Wide detents with backlash; moderate friction; low inertia (i.e., nonlinearities known to be inconsistent with \
         Equation 1 – very difficult to fit)",
        4.2,
    ),
];

/// Effects whose parameters are in Tables 5 and 6; what else a shipped knob has is this project's choice.
const OF_THE_TABLES: [&str; 4] = [
    effects::inertia::KIND.name,
    effects::friction::KIND.name,
    effects::karnopp_stick::KIND.name,
    effects::detent::KIND.name,
];

/// What the paper prints of the knob called `name`; `None` for a name that is none of its numbers.
pub(crate) fn knob(name: &str) -> Option<PaperKnob> {
    let number: u32 = name.parse().ok()?;
    let shipped = knobs::paper_knob(number).ok()?;
    let (description, mean_ci95_mnm) = PRINTED[number as usize - 1];
    let printed = shipped.effects.iter().filter(|effect| OF_THE_TABLES.contains(&effect.kind().name));
    let parameters = printed.flat_map(Effect::parameters).map(|(kind, value)| {
        let printed = PaperValue {
            value: true_value(Some(&shipped), kind.name, None).unwrap_or(value),
            // The tables give what resists turning negatively as a signed torque; a shipped knob keeps every other sign.
            printed: if matches!(kind.name, "coulomb_negative" | "static_negative") { -value } else { value },
            unit: kind.unit,
        };
        (kind.name, printed)
    });
    Some(PaperKnob { number, description, parameters: parameters.collect(), mean_ci95_mnm })
}

/// The paper's knob that a model is, value by value.
pub(crate) fn knob_of(model: &Model) -> Option<PaperKnob> {
    let same = |number: &u32| knobs::paper_knob(*number).is_ok_and(|shipped| shipped.effects == model.effects);
    (1..=5).find(same).and_then(|number| knob(&number.to_string()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn table_5_is_as_printed_and_in_this_projects_signs() {
        let knob = knob("4").unwrap();
        let of = |name: &str| (knob.parameters[name].printed, knob.parameters[name].value);
        assert_eq!(of("inertia"), (0.049, 0.049));
        assert_eq!(of("coulomb_negative"), (-0.61, 0.61));
        assert_eq!(of("detent_amplitude"), (-11.0, 11.0));
        assert_eq!(of("detent_phase").0, -0.2);
        assert!((of("detent_phase").1 - (std::f64::consts::PI - 0.2)).abs() < 1e-12);
        assert_eq!(of("static_negative"), (-20.0, 20.0));
        assert_eq!(knob.mean_ci95_mnm, 0.073);
    }

    #[test]
    fn what_this_project_chose_of_knob_5_is_not_called_the_papers() {
        let knob = knob("5").unwrap();
        assert!(knob.parameters.keys().all(|name| !name.starts_with("harmonic") && !name.starts_with("backlash")));
        assert_eq!(knob.parameters.len(), 11);
    }
}
