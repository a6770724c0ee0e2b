//! The captures of a mean, a row each.

use maud::{Markup, html};

use crate::AveragePage;
use crate::numbers::{count, three, two};

/// File, time and length of each capture, and how well its own fit follows it.
pub(super) fn table(page: &AveragePage<'_>) -> Markup {
    let timed = page.captures.iter().any(|capture| !capture.captured_at.is_empty());
    let ticked = page.captures.iter().any(|capture| capture.missed_ticks.is_some());
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th { "" }
                        th { "file" }
                        @if timed { th { "captured" } }
                        th.number { "rate (Hz)" }
                        th.number { "duration (s)" }
                        th.number { "samples" }
                        @if ticked { th.number { "missed ticks" } }
                        th.number { "residual RMS (mNm)" }
                        th.number { "of the torque (%)" }
                        th.number { "model's interval (mNm)" }
                    }
                }
                tbody.plain {
                    @for (index, (capture, fit)) in page.captures.iter().zip(page.fits).enumerate() {
                        tr {
                            td { (index + 1) }
                            th.file scope="row" { (capture.source) }
                            @if timed { td { (capture.captured_at) } }
                            td.number { (three(capture.rate_hz)) }
                            td.number { (three(capture.duration_s)) }
                            td.number { (count(capture.samples)) }
                            @if ticked { td.number { (capture.missed_ticks.map_or_else(|| "–".to_owned(), count)) } }
                            td.number { (two(fit.residual_rms_mnm)) }
                            td.number { (two(fit.relative_error_percent)) }
                            td.number { "±\u{a0}" (two(fit.mean_ci95_mnm)) }
                        }
                    }
                    tr.mean {
                        td { "" }
                        th scope="row" { "mean" }
                        @if timed { td {} }
                        td {} td {}
                        td.number { (count(page.average.fit.samples as u64)) }
                        @if ticked { td {} }
                        td.number { (two(page.average.fit.residual_rms_mnm)) }
                        td.number { (two(page.average.fit.relative_error_percent)) }
                        td.number { "±\u{a0}" (two(page.average.fit.mean_ci95_mnm)) }
                    }
                }
            }
        }
        p.note {
            "The residuals are those of each capture's own fit, in the last row of all together; the model's interval is the mean \
             half width of its torque's 95 % interval."
        }
    }
}
