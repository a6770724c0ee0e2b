//! The fit in two sentences.

use identification::{Fit, Parameter};

use crate::numbers::{Digits, three, two};
use identification::statistics::half_width;

/// Space at which no line ends.
const NO_BREAK: &str = "\u{a0}";

/// Residual over expected noise up to which the model counts as complete.
pub(crate) const LIKE_NOISE: f64 = 1.5;

/// The parameters that were found, and how well the model follows the torque.
pub(crate) fn findings(fit: &Fit) -> String {
    let mut phrases: Vec<String> = Vec::new();
    let mut seen: Vec<&str> = Vec::new();
    for parameter in fit.parameters.0.iter().filter(|parameter| parameter.value.is_some()) {
        let stem = stem(parameter.name);
        if seen.contains(&stem) {
            continue;
        }
        seen.push(stem);
        phrases.push(phrase(fit, stem, parameter));
    }
    phrases.retain(|words| !words.is_empty());
    let found = if phrases.is_empty() { "no parameter is identifiable".to_owned() } else { phrases.join(", ") };
    format!(
        "{found}; residual {}\u{a0}mNm\u{a0}RMS, {}\u{a0}% of the torque.",
        two(fit.residual_rms_mnm),
        two(fit.relative_error_percent)
    )
}

/// Whether the residual is what the torque sensor's noise leaves; `None` if the noise is not known.
pub(crate) fn completeness(fit: &Fit) -> Option<String> {
    let noise = noise_in_band_mnm(fit)?;
    let ratio = fit.residual_rms_mnm / noise;
    let words = if ratio <= LIKE_NOISE {
        format!(
            "That is about what the torque sensor's noise leaves in the fit's band ({}\u{a0}mNm): the model explains this capture.",
            two(noise)
        )
    } else {
        format!(
            "The torque sensor's noise alone would leave {}\u{a0}mNm, {} times less: something in this knob or rig is not in \
             the model.",
            two(noise),
            two(ratio)
        )
    };
    ratio.is_finite().then_some(words)
}

/// Noise of the torque within the fit's band, mNm.
pub(crate) fn noise_in_band_mnm(fit: &Fit) -> Option<f64> {
    let noise =
        fit.preparation.torque_noise_mnm * (2.0 * fit.preparation.band_hz / fit.preparation.rate_hz).min(1.0).sqrt();
    (noise > 0.0 && noise.is_finite()).then_some(noise)
}

/// Angle from one detent to the next, degrees.
pub(crate) fn detent_spacing_deg(period_rad: f64) -> f64 {
    (std::f64::consts::TAU * period_rad).to_degrees()
}

/// A parameter's value with the half width of its interval.
pub(crate) fn plus_minus(parameter: &Parameter) -> Option<String> {
    let value = parameter.value?;
    Some(match parameter.ci95 {
        // A value that the fit holds at its bound is the lower end of its interval.
        Some([low, high]) if value <= low && high > low => {
            format!("at most {}", Digits::of_interval(high, high - low).show(high))
        }
        Some(ci95) => {
            let half = half_width(value, ci95);
            Digits::of_interval(value, half).plus_minus(value, half)
        }
        None => three(value),
    })
}

fn stem(name: &str) -> &str {
    name.strip_suffix("_negative").or_else(|| name.strip_suffix("_positive")).unwrap_or(name)
}

fn phrase(fit: &Fit, stem: &str, parameter: &Parameter) -> String {
    let directions = ["negative", "positive"].map(|direction| {
        let name = format!("{stem}_{direction}");
        fit.parameters.get(&name).and_then(|found| Some((direction, plus_minus(found)?)))
    });
    let of = |name: &str| fit.parameters.get(name).and_then(|found| found.value);
    let words = plus_minus(parameter).unwrap_or_default();
    let unit = parameter.unit.replace(' ', NO_BREAK);
    match (stem, directions) {
        ("coulomb" | "viscous" | "static", [Some((_, negative)), Some((_, positive))]) => {
            format!(
                "{} friction {negative}\u{a0}{unit} turning negatively and {positive}\u{a0}{unit} positively",
                title(stem)
            )
        }
        ("coulomb" | "viscous" | "static", [Some((direction, one)), None] | [None, Some((direction, one))]) => {
            format!("{} friction {one}\u{a0}{unit} turning {direction}ly only", title(stem))
        }
        ("detent_amplitude", _) => match of("detent_period") {
            Some(period) => {
                format!("detents of {words}\u{a0}{unit} every {}°", three(detent_spacing_deg(period)))
            }
            None => format!("detents of {words}\u{a0}{unit}"),
        },
        ("detent_period" | "detent_phase", _) => String::new(),
        _ => format!("{} {words}\u{a0}{unit}", stem.replace('_', " ")),
    }
}

/// Coulomb is a person, viscous is not.
fn title(stem: &str) -> &str {
    if stem == "coulomb" { "Coulomb" } else { stem }
}
