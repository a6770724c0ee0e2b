//! A model as a C header for firmware that renders detents, SmartKnob's for one.
//!
//! SmartKnob (<https://github.com/scottbez1/smartknob>, `firmware/src/motor_task.cpp` and `proto/smartknob.proto`) has no table
//! of its own: it draws the knob to the middle of the nearest position by a voltage of 4 · `detent_strength_unit` per radian, and
//! changes over to the next position at `snap_point` · `position_width_radians`. The header gives these figures, and the table
//! for firmware that takes one.

use std::borrow::Cow;
use std::fmt::Write as _;

use dynamics::effects::end_stop;
use dynamics::{Axis, Model, ParameterKind};

use crate::TorqueOverAngle;

const PER_LINE: usize = 6;
/// Pieces of C, with names between `@` for what is filled in.
const SMARTKNOB: &str = include_str!("firmware/smartknob.h.in");
const TABLE: &str = include_str!("firmware/table.h.in");
const ENDS_ROTARY: &str = include_str!("firmware/table_ends_rotary.h.in");
const ENDS_LINEAR: &str = include_str!("firmware/table_ends_linear.h.in");

/// The header of a model from `source`, with its table if it has one; all names in it begin with `name`.
#[must_use]
pub fn c_header(model: &Model, table: Option<&TorqueOverAngle>, source: &str, name: &str) -> String {
    let upper = identifier(name).to_uppercase();
    let mut text = String::new();
    let axis = model.axis;
    let signs = axis.words(
        " * Torque is that of the hand on the knob: positive at an angle from which the knob pulls back towards\n * \
         smaller angles. A motor that renders the knob applies the opposite.\n * Angles count from the knob's zero. \
         Units are in the names: mNm, rad, s.\n",
    );
    let signs = signs.replace("whoever moves it", "whoever presses or slides it");
    let _ = write!(
        text,
        "/* {} as numbers, made by haptic-camera {} from {}.\n *\n{signs} */\n#ifndef {upper}_H\n#define {upper}_H\n",
        comment(&model.name),
        env!("CARGO_PKG_VERSION"),
        comment(source),
    );
    constants(model, &upper, &mut text);
    if let Some(table) = table {
        text += &smart_knob(model, table, &upper);
        text += &tabulated(table, &upper);
    }
    let _ = writeln!(text, "\n#endif");
    text
}

/// Every parameter of the model, with its meaning.
fn constants(model: &Model, upper: &str, text: &mut String) {
    for effect in &model.effects {
        let words = |text: &str| comment(&model.axis.words(text));
        let _ = writeln!(text, "\n/* {}: {} */", words(effect.kind().name), words(effect.kind().description));
        for (kind, value) in effect.parameters() {
            let _ = writeln!(
                text,
                "#define {upper}_{} {}  /* {}, {} */",
                macro_name(model.axis, kind),
                float(value),
                words(kind.description),
                unit(model.axis, kind)
            );
        }
    }
}

/// What SmartKnob's configuration takes.
fn smart_knob(model: &Model, table: &TorqueOverAngle, upper: &str) -> String {
    let Some(rest) = table.rest.filter(|_| table.is_period) else { return String::new() };
    let mut text = SMARTKNOB.to_owned();
    if let Some(stiffest) = stiffest_end_stop_mnm_rad(model) {
        let _ = write!(
            text,
            "#define {upper}_SMARTKNOB_ENDSTOP_STRENGTH_UNIT(MOTOR_MNM_PER_V) \\\n    ({} / (4.0f * (MOTOR_MNM_PER_V)))\n",
            float(stiffest)
        );
    }
    let (width, stiffness) = (float(table.span_rad), float(rest.stiffness_mnm_rad));
    filled(&text, &[("@UPPER@", upper), ("@WIDTH@", &width), ("@STIFFNESS@", &stiffness)])
}

/// Stiffness of the stiffer end stop, mNm/rad, where the model has them.
pub(crate) fn stiffest_end_stop_mnm_rad(model: &Model) -> Option<f64> {
    model.effect(end_stop::KIND.name).map(|stop| stop.values()[2].max(stop.values()[3]))
}

fn tabulated(table: &TorqueOverAngle, upper: &str) -> String {
    let axis = table.axis;
    let over = match (axis, table.is_period) {
        (Axis::Linear, _) => "the travel",
        (Axis::Rotary, true) => "one period of the detents",
        (Axis::Rotary, false) => "one turn",
    };
    // What turns comes round again; what is pressed does not.
    let (beyond, ends) = match axis {
        Axis::Rotary => ("it repeats after SPAN", ENDS_ROTARY),
        Axis::Linear => ("beyond its ends it stays as it is there", ENDS_LINEAR),
    };
    let line = |line: &[f64]| line.iter().map(|&torque| float(torque)).collect::<Vec<_>>().join(", ");
    let lines: Vec<String> =
        table.torque_mnm.chunks(PER_LINE).map(|torques| format!("    {},\n", line(torques))).collect();
    let given = [
        ("@EFFECTS@", comment(&table.effects.join(" + "))),
        ("@OVER@", over.to_owned()),
        ("@BEYOND@", beyond.to_owned()),
        ("@ENDS@", ends.to_owned()),
        ("@NUMBERS@", lines.concat()),
        ("@POINTS@", table.torque_mnm.len().to_string()),
        ("@SPAN@", float(table.span_rad)),
        ("@UNIT@", axis.position_unit().to_uppercase()),
        ("@ARRAY@", axis.words("torque_mnm").into_owned()),
        ("@AT@", axis.words("torque_at_mnm").into_owned()),
        ("@TORQUE@", axis.words("Torque").into_owned()),
        ("@ANGLE@", axis.words("angle").into_owned()),
        ("@PLACE@", axis.words("angle_rad").into_owned()),
        ("@LOWER@", upper.to_lowercase()),
        ("@UPPER@", upper.to_owned()),
    ];
    filled(TABLE, &given.each_ref().map(|(name, text)| (*name, text.as_str())))
}

/// A piece of C with its places filled.
fn filled(template: &str, given: &[(&str, &str)]) -> String {
    given.iter().fold(template.to_owned(), |text, (place, given)| text.replace(place, given))
}

/// The parameter's unit; that of a phase is no travel.
fn unit(axis: Axis, kind: &ParameterKind) -> Cow<'static, str> {
    if kind.name.ends_with("_phase") { kind.unit.into() } else { axis.words(kind.unit) }
}

/// The parameter's name with its unit: `COULOMB_POSITIVE_MNM`, `VISCOUS_POSITIVE_MNM_S_PER_RAD`.
fn macro_name(axis: Axis, kind: &ParameterKind) -> String {
    let unit = unit(axis, kind).replace('²', "2").replace('/', "_per_").replace([' ', '·'], "_");
    let unit = if unit == "1" { String::new() } else { format!("_{unit}") };
    format!("{}{unit}", axis.words(kind.name)).to_uppercase()
}

/// The shortest literal that is the same single-precision number.
fn float(value: f64) -> String {
    format!("{:?}f", value as f32)
}

/// What may stand in a comment.
fn comment(text: &str) -> String {
    text.replace("*/", "* /").replace('\n', " ")
}

/// What C takes for a name.
fn identifier(name: &str) -> String {
    let letters: String =
        name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect();
    if letters.starts_with(|first: char| first.is_ascii_digit()) || letters.is_empty() {
        format!("knob_{letters}")
    } else {
        letters
    }
}

#[cfg(test)]
mod tests {
    use super::macro_name;

    #[test]
    fn names_carry_the_unit() {
        let kinds = dynamics::effects::ALL.iter().flat_map(|kind| kind.parameters);
        let names: Vec<String> = kinds.map(|kind| macro_name(dynamics::Axis::Rotary, kind)).collect();
        for name in ["INERTIA_MNM_S2_PER_RAD", "COULOMB_NEGATIVE_MNM", "VISCOUS_POSITIVE_MNM_S_PER_RAD", "TABLE_SCALE"]
        {
            assert!(names.iter().any(|known| known == name), "{name} is not in {names:?}");
        }
        assert!(names.iter().all(|name| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')), "{names:?}");
    }
}
