//! The five knobs of Swindells and MacLean 2007, with the values of their Tables 5 and 6.

use crate::{Model, ModelError};

const FILES: [&str; 5] = [
    include_str!("../knobs/knob-1.toml"),
    include_str!("../knobs/knob-2.toml"),
    include_str!("../knobs/knob-3.toml"),
    include_str!("../knobs/knob-4.toml"),
    include_str!("../knobs/knob-5.toml"),
];

/// The paper's knob with the given number, 1 to 5.
///
/// Table 5 gives C₋ as a signed torque; here it is a magnitude. Amplitudes keep the table's sign.
/// Knob 5 is its Table 5 fit alone, without the backlash and the shape of its detents.
///
/// # Errors
/// [`ModelError::UnknownKnob`] for another number.
pub fn paper_knob(number: u32) -> Result<Model, ModelError> {
    let text = (1..=5).contains(&number).then(|| FILES[number as usize - 1]);
    let text = text.ok_or(ModelError::UnknownKnob { number })?;
    Model::from_toml(text, &format!("knob {number}"))
}
