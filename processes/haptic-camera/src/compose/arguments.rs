//! Options of `compose` and `tune` that have two halves.

/// A parameter and its value.
pub fn name_and_number(text: &str) -> Result<(String, f64), String> {
    let example = "it must be a parameter and a number, as in detent_amplitude=1.5";
    let (name, value) = halves(text.split_once('=')).ok_or(example)?;
    let value = value.parse().map_err(|_| format!("'{value}' is not a number; {example}"))?;
    Ok((name, value))
}

/// A parameter and the source of its value.
pub fn name_and_knob(text: &str) -> Result<(String, String), &'static str> {
    halves(text.split_once('='))
        .ok_or("it must be a parameter and a shipped knob or model file, as in detent_amplitude=4")
}

/// A shipped knob's number or a model file, and an effect to take from it.
pub fn knob_and_effect(text: &str) -> Result<(String, String), &'static str> {
    halves(text.rsplit_once(':')).ok_or("it must be a shipped knob or model file and an effect, as in 5:backlash")
}

fn halves(halves: Option<(&str, &str)>) -> Option<(String, String)> {
    let (one, other) = halves.map(|(one, other)| (one.trim(), other.trim()))?;
    (!one.is_empty() && !other.is_empty()).then(|| (one.to_owned(), other.to_owned()))
}
