//! The rig test's figures as tables.

use maud::{Markup, html};

use super::RigTest;
use crate::numbers::{Digits, count, printed, three};

/// Original minus measured beside Table 3.
pub(super) fn differences(test: &RigTest) -> Markup {
    html! {
        div.scroll {
            table.compared {
                thead {
                    tr {
                        th { "channel" }
                        th.number { "mean" }
                        th.number { "SD" }
                        th.number { "SD, filtered" }
                        th.number.paper { "paper’s mean" }
                        th.number.paper { "paper’s SD" }
                        th { "unit" }
                    }
                }
                tbody {
                    @for row in &test.differences {
                        tr {
                            th scope="row" { code { (row.channel) } }
                            td.number { (Digits::significant(row.sd, 3).show(row.mean)) }
                            td.number.value { (three(row.sd)) }
                            td.number { (three(row.sd_filtered)) }
                            td.number.paper { (printed(row.paper_mean)) }
                            td.number.paper { (printed(row.paper_sd)) }
                            td.unit { (row.unit) }
                        }
                    }
                }
            }
        }
        p.note {
            "Over all samples of the sweep. Filtered: behind the zero-phase low-passes through which the paper takes a capture \
             before a fit, at "
            @for (index, edge) in test.filter_edges_hz.iter().enumerate() { @if index > 0 { ", " } (three(*edge)) }
            " Hz in the order of the rows: what is left there is what a fit sees. Table 3 of the paper gives its own rig’s; whether \
             those were filtered it does not say."
            @if !test.axis.is_rotary() { " Its numbers stand here as at a fingertip, 20 mm from its axis." }
        }
    }
}

/// Phase, delay and gain at one frequency.
pub(super) fn lags(test: &RigTest) -> Markup {
    html! {
        div.scroll {
            table.compared {
                thead {
                    tr {
                        th { "channel" }
                        th.number { "phase lag (rad)" }
                        th.number { "delay (ms)" }
                        th.number { "gain" }
                        th.number.paper { "paper’s phase lag (rad)" }
                    }
                }
                tbody {
                    @for lag in &test.lag_at_30_hz {
                        tr {
                            th scope="row" { code { (lag.channel) } }
                            td.number.value { (three(lag.phase_rad)) }
                            td.number { (three(lag.delay_ms)) }
                            td.number { (Digits::of_interval(lag.gain, 1e-4).show(lag.gain)) }
                            td.number.paper { "<\u{a0}" (printed(lag.paper_phase_rad_below)) }
                        }
                    }
                }
            }
        }
        p.note {
            "A measured sine against the commanded one, both by their part at " (three(test.lag_hz)) " Hz over whole periods. A negative \
             lag is a channel that is ahead; a gain of 1 is one that shows the whole amplitude."
        }
    }
}

/// The four runs.
pub(super) fn captures(test: &RigTest) -> Markup {
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th { "run" }
                        th { "file" }
                        th.number { "rate (Hz)" }
                        th.number { "duration (s)" }
                        th.number { "samples" }
                        th.number { "missed ticks" }
                    }
                }
                tbody.plain {
                    @for capture in &test.captures {
                        tr {
                            td { (capture.title) }
                            th.file scope="row" { (capture.source) }
                            td.number { (three(capture.rate_hz)) }
                            td.number { (three(capture.duration_s)) }
                            td.number { (count(capture.samples)) }
                            td.number { (capture.missed_ticks.map_or_else(|| "–".to_owned(), count)) }
                        }
                    }
                }
            }
        }
    }
}
