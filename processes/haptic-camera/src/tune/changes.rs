//! What differs between two models, in lines for the operator.

use dynamics::{Model, ParameterKind};

pub(super) fn line(parameter: &ParameterKind, value: f64) -> String {
    format!("  {:<22} {value} {}", parameter.name, parameter.unit)
}

/// Every parameter whose value changes, old to new; a dash where a model does not have it.
pub(super) fn lines(old: &Model, new: &Model) -> Vec<String> {
    let mut lines = Vec::new();
    if old.name != new.name {
        lines.push(format!("{} → {}", old.name, new.name));
    }
    let gone = old.parameters().filter(|(parameter, _)| new.parameter(parameter.name).is_none());
    for (parameter, _) in new.parameters().chain(gone) {
        let (before, after) = (old.parameter(parameter.name), new.parameter(parameter.name));
        if before != after {
            let value = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| value.to_string());
            lines.push(format!("  {:<22} {} → {} {}", parameter.name, value(before), value(after), parameter.unit));
        }
    }
    if lines.is_empty() {
        lines.push("nothing changes: the model is as it was".to_owned());
    }
    lines
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use dynamics::knobs;

    use super::lines;

    #[test]
    fn a_change_is_listed_from_old_to_new_and_what_stays_is_not() {
        let old = knobs::paper_knob(3).unwrap();
        let mut new = old.clone();
        assert_eq!(lines(&old, &new), ["nothing changes: the model is as it was"]);
        new.effects[0].values_mut()[0] = 0.05;
        assert_eq!(lines(&old, &new), ["  inertia                0.035 → 0.05 mNm s²/rad"]);
        let gone = new.effects.pop().unwrap();
        let listed = lines(&old, &new);
        assert!(
            listed[1..].iter().all(|line| line.contains("→ –")) && listed.len() == 1 + gone.values().len(),
            "{listed:?}"
        );
    }
}
