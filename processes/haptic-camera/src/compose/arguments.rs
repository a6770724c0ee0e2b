//! Options of `compose` that have two halves.

use std::str::FromStr;

/// A parameter and what it is to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment<Value> {
    /// The parameter.
    pub name: String,
    /// Its value, or the source of its value.
    pub value: Value,
}

impl FromStr for Assignment<f64> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let example = "it must be a parameter and a number, as in detent_amplitude=1.5";
        let (name, value) = halves(text, '=').ok_or(example)?;
        let value = value.parse().map_err(|_| format!("'{value}' is not a number; {example}"))?;
        Ok(Self { name, value })
    }
}

impl FromStr for Assignment<String> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = halves(text, '=')
            .ok_or("it must be a parameter and a shipped knob or model file, as in detent_amplitude=4")?;
        Ok(Self { name, value })
    }
}

/// An effect and the model to take it from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extra {
    /// A shipped knob's number or a model file.
    pub source: String,
    /// The effect's name.
    pub effect: String,
}

impl FromStr for Extra {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let halves = text.rsplit_once(':').filter(|(source, effect)| !source.is_empty() && !effect.is_empty());
        let (source, effect) =
            halves.ok_or("it must be a shipped knob or model file and an effect, as in 5:backlash")?;
        Ok(Self { source: source.trim().to_owned(), effect: effect.trim().to_owned() })
    }
}

fn halves(text: &str, between: char) -> Option<(String, String)> {
    let (name, value) = text.split_once(between)?;
    let (name, value) = (name.trim(), value.trim());
    (!name.is_empty() && !value.is_empty()).then(|| (name.to_owned(), value.to_owned()))
}
