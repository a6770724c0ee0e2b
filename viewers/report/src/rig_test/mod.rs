//! The page of a rig test: the rig's measurement compared with its command.

mod figures;
mod input;
mod table;

use maud::{Markup, html};

pub use input::{ChannelDifference, ChannelLag, ChannelTrace, RigTest};

use crate::numbers::{printed, three, two};
use crate::page::{document, footer};

pub(crate) fn rig_test_page(test: &RigTest) -> Markup {
    let rig = test.captures.first().map_or("", |capture| capture.rig.as_str());
    let title = if rig.is_empty() { "Rig test".to_owned() } else { format!("Rig test: {rig}") };
    let version = test.captures.first().map_or("", |capture| capture.software_version.as_str());
    let sources: Vec<&str> = test.captures.iter().map(|capture| capture.source.as_str()).collect();
    let paper_lag = test.lag_at_30_hz.first().map_or_else(String::new, |lag| printed(lag.paper_phase_rad_below));
    let content = html! {
        header {
            p.kind { "A rig without a knob, beside the paper’s" }
            h1 { (title) }
            p.verdict { (verdict(test)) }
            p.completeness {
                "The sweep is " code { (test.sweep) } " at " (three(test.rate_hz)) " Hz: the gripper alone for position, velocity and \
                 acceleration, the locked gripper under a torque for the torque."
            }
        }
        section {
            h2 { "Original minus measured" }
            (table::differences(test))
        }
        section {
            h2 { "Lag at " (two(test.lag_hz)) " Hz" }
            (table::lags(test))
        }
        section {
            h2 { "The signals" }
            (figures::sweep(test, 1))
            (figures::tone(test, 2))
        }
        section {
            h2 { "The runs" }
            (table::captures(test))
        }
        section {
            h2 { "How the numbers were made" }
            p {
                "After section 4.1 of Swindells and MacLean 2007: the motor follows the paper’s sweep, and what the sensors read is taken \
                 from what was commanded, sample by sample, with the rig’s zeros and the weight of the accelerometer taken out and \
                 nothing else. Velocity is the encoder’s, differentiated and low-passed as in a capture. So the difference holds the \
                 servo’s error, the sensors’ noise and their delays together."
            }
            p {
                "The paper speaks of a phase lag below " (paper_lag) " rad at " (two(test.lag_hz)) " Hz, a frequency that its printed \
                 constants do not reach; hence a run of its own at that frequency."
            }
        }
        (footer(version, &sources.join(", ")))
    };
    document(&title, &content)
}

/// Which channels come closer to what was commanded than the paper's, and the largest lag.
fn verdict(test: &RigTest) -> String {
    let (closer, farther): (Vec<_>, Vec<_>) = test.differences.iter().partition(|row| row.sd <= row.paper_sd);
    let names = |rows: &[&ChannelDifference]| rows.iter().map(|row| row.channel).collect::<Vec<_>>().join(", ");
    let spread = match (closer.is_empty(), farther.is_empty()) {
        (false, true) => "Every channel scatters less about what was commanded than the paper’s.".to_owned(),
        (true, false) => "Every channel scatters more about what was commanded than the paper’s.".to_owned(),
        _ => format!(
            "Beside the paper’s rig, less scatter about what was commanded in {}; more in {}.",
            names(&closer),
            names(&farther)
        ),
    };
    let latest = test.lag_at_30_hz.iter().max_by(|a, b| a.phase_rad.abs().total_cmp(&b.phase_rad.abs()));
    let Some(latest) = latest else { return spread };
    let beside = if latest.phase_rad.abs() < latest.paper_phase_rad_below { "below" } else { "beyond" };
    format!(
        "{spread} The largest phase lag at {}\u{a0}Hz is that of {}, {}\u{a0}rad: {beside} the paper’s {}.",
        two(test.lag_hz),
        latest.channel,
        three(latest.phase_rad),
        printed(latest.paper_phase_rad_below)
    )
}
