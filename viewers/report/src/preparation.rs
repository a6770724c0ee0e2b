//! Which parameters are not identifiable, how the data were prepared, and how the numbers were computed.

use identification::Fit;
use maud::{Markup, html};

use crate::numbers::{count, three, two};
use crate::page::sentence;
use crate::verdict::noise_in_band_mnm;

/// The parameters that are not identifiable, with the reasons, and other remarks.
pub(crate) fn not_identifiable(fit: &Fit) -> Markup {
    let not_identifiable: Vec<_> = fit.parameters.0.iter().filter(|parameter| parameter.value.is_none()).collect();
    let nothing = not_identifiable.is_empty()
        && fit.notes.is_empty()
        && fit.detent_aliases_rad.is_empty()
        && fit.detent_harmonics.is_empty();
    html! {
        @if nothing {
            p { "Every parameter is identifiable, and there are no warnings." }
        } @else {
            ul {
                @for group in not_identifiable.chunk_by(|one, next| one.reason == next.reason) {
                    li {
                        @for (index, parameter) in group.iter().enumerate() {
                            @if index > 0 { ", " }
                            code { (parameter.name) }
                        }
                        @if let Some(reason) = group.first().and_then(|parameter| parameter.reason.as_ref()) {
                            ": " (reason) "."
                        }
                    }
                }
                @if !fit.detent_aliases_rad.is_empty() {
                    li {
                        "Other detent periods explain the data nearly as well: "
                        @for (index, alias) in fit.detent_aliases_rad.iter().enumerate() {
                            @if index > 0 { ", " }
                            (three(*alias))
                        }
                        " rad."
                    }
                }
                @if !is_map(fit) {
                    @for harmonic in &fit.detent_harmonics {
                        li {
                            "The residual holds harmonic " (harmonic.order.unwrap_or(0)) " of the detents: "
                            (three(harmonic.amplitude_mnm)) " mNm, " (two(harmonic.explains_percent))
                            " % of its sum of squares. The detents are no pure sine."
                        }
                    }
                }
                @for note in &fit.notes { li { (sentence(note)) } }
            }
        }
    }
}

/// The choices that the fit made by itself.
pub(crate) fn preparation(fit: &Fit) -> Markup {
    let chosen = &fit.preparation;
    let is_map = is_map(fit);
    let motion = if is_map {
        "the direction of each pass and the mean speed; acceleration was not estimated".to_owned()
    } else if chosen.exact_motion {
        "taken as given: velocity and acceleration are the angle's exact derivatives".to_owned()
    } else {
        let source = if chosen.accelerometer {
            "from the encoder, at high frequencies from the accelerometer"
        } else {
            "from the encoder alone"
        };
        format!("{source}; the encoder low-passed at {} Hz", three(chosen.angle_cutoff_hz))
    };
    let rows = [
        ("Samples", format!("{} at {} Hz", count(fit.samples as u64), three(chosen.rate_hz))),
        ("Lost in gaps", count(chosen.lost_samples as u64)),
        (
            "Used",
            if is_map {
                let used = three(chosen.sliding_percent);
                format!(
                    "{used} % of the samples: those of whole passes, away from turning points and the ends of the torque sensor's range"
                )
            } else {
                format!(
                    "{} % of the samples, where the knob moved faster than {} rad/s and surely slid; {} rows after decimation",
                    three(chosen.sliding_percent),
                    two(chosen.stick_threshold_rad_s),
                    count(fit.rows as u64)
                )
            },
        ),
        ("Motion", motion),
        (
            "Band of the fit",
            if is_map {
                "all of it: torque and model were not filtered".to_owned()
            } else {
                format!("0 to {} Hz, zero-phase low-pass on torque and model alike", three(chosen.band_hz))
            },
        ),
        (
            "Torque noise",
            format!(
                "{} mNm at full rate{}",
                two(chosen.torque_noise_mnm),
                noise_in_band_mnm(fit).map_or_else(String::new, |noise| format!(", {} mNm in the band", two(noise)))
            ),
        ),
        ("Encoder noise", format!("{} rad", two(chosen.angle_noise_rad))),
        (
            "Torque delay",
            if fit.torque_delay_s == 0.0 {
                "none seen".to_owned()
            } else {
                format!("{} s behind the motion, allowed for", two(fit.torque_delay_s))
            },
        ),
        (
            "Model's interval",
            format!(
                "± {} mNm on average (95 %); ± {} mNm by the textbook",
                two(fit.mean_ci95_mnm),
                two(fit.mean_ci95_textbook_mnm)
            ),
        ),
    ];
    html! {
        dl.preparation {
            @for (name, words) in rows { dt { (name) } dd { (words) } }
        }
    }
}

/// Whether torque was fitted against angle and direction alone.
pub(crate) fn is_map(fit: &Fit) -> bool {
    fit.preparation.method == "quasi-static"
}

/// How the numbers were made, of maps of torque over the angle or of motion.
pub(crate) fn method(of_maps: bool) -> Markup {
    if of_maps {
        return html! {
            p {
                "Torque was fitted against angle and direction alone: Coulomb friction in each direction, and sinusoids of the angle, the \
                 strongest first, as long as they predict stretches that they were not fitted to. Nothing was filtered. The 95 % intervals \
                 come from the scatter of the stretches. The relative error is 100·‖measured − model‖ / ‖measured‖ over the rows used."
            }
        };
    }
    html! {
        p {
            "The model is a sum of effects, and every effect a sum of columns with linear coefficients. Where the knob may \
             stick, the torque and every column are set to zero; then all of them pass one zero-phase low-pass and are \
             decimated, which leaves the relation between them exact. Linear least squares gives the coefficients, with \
             Coulomb friction at or above zero. Only the period of the detents is searched, by a scan over everything that \
             the travel supports and then Gauss–Newton, so no starting values are needed. The 95 % intervals use a \
             covariance that allows for residuals correlated in time, of varying size, and smaller than the errors by what \
             the fit took from them, with Student's critical values after Bell and McCaffrey (2002). The relative \
             error is 100·‖measured − model‖ / ‖measured‖ over the rows used."
        }
        p.equation {
            i { "τ" } " = " i { "M" } "·θ̈ + [θ̇<0]·(−" i { "C" } "₋ + " i { "B" } "₋·θ̇) + [θ̇>0]·(" i { "C" } "₊ + " i { "B" }
            "₊·θ̇) + " i { "A" } "·sin(θ/" i { "P" } " + " i { "S" } ")"
        }
    }
}
