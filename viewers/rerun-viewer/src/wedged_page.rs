//! Pages that never read, tried with more data than is kept for anyone.

use std::io::Read as _;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Parser as _;
use serde_json::Value;
use shared_types::{ProcessHealth, ProcessKind};

use crate::cli::Arguments;
use crate::frame::{Frame, Points};
use crate::glance::SharedGlance;
use crate::layout::Subject;
use crate::outbox::Outbox;
use crate::page::server::tests::ask;
use crate::run::Run;
use crate::screen::Screen;

/// Frames and rows of each: 16 bytes a row, 320 MB in all.
const FRAMES: usize = 1_000;
const ROWS: usize = 20_000;
/// What may be kept for pages that come later, MiB.
const KEPT_MIB: f64 = 8.0;
/// Pages that never read, and what one answer may hold, MiB.
const WEDGED: usize = 20;
const ANSWER_MIB: f64 = 3.0;
/// For what is on its way: buffers of connections, the frames that wait, what the allocator keeps.
const ON_ITS_WAY_MIB: f64 = 120.0;
/// When the test gives up, not a time that is asserted.
const GIVEN_UP: Duration = Duration::from_secs(240);

/// Sends a page's request; returns the answer's metadata, and how many bytes of rerun files came.
fn fetch(address: SocketAddr, query: &str) -> (Value, usize) {
    let mut answer = Vec::new();
    ask(address, &format!("/drawn?{query}")).read_to_end(&mut answer).unwrap();
    let body = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap() + 4;
    let line = body + answer[body..].iter().position(|byte| *byte == b'\n').unwrap();
    let head: Value = serde_json::from_slice(&answer[body..line]).unwrap();
    (head, answer.len() - line - 1)
}

/// A frame that no compression makes smaller.
fn frame(number: usize) -> Frame {
    let noise = |index: usize| {
        let mixed = ((number * ROWS + index) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    };
    let points = Points {
        times_ns: (0..ROWS).map(|index| (noise(index) >> 20) as i64).collect(),
        values: (0..ROWS).map(|index| noise(index) as f64).collect(),
    };
    let series = [("signals/torque_mnm".to_owned(), points)].into();
    Frame { run_id: 1, time_ns: i64::try_from(number).unwrap(), series, ..Frame::default() }
}

pub(crate) fn resident_mib() -> f64 {
    ProcessHealth::of_this_process(ProcessKind::Viewer, 0).resident_bytes as f64 / f64::from(1 << 20)
}

#[test]
fn pages_that_never_read_stop_no_other_and_cost_a_bounded_memory() {
    let arguments = ["rerun-viewer", "--web-port", "43000", "--memory-limit", &format!("{KEPT_MIB}MiB")];
    let arguments = Arguments::parse_from(arguments);
    let screen = Screen::open(&arguments, Subject::live(&Run::default()), SharedGlance::default()).unwrap();
    let address = screen.page().unwrap();
    let outbox = Arc::new(Outbox::new(4));
    let shown = screen.show_from(Arc::clone(&outbox)).unwrap();
    let deadline = Instant::now() + GIVEN_UP;
    let before_mib = resident_mib();
    let mut most_mib = 0.0_f64;
    let mut wedged = Vec::new();
    let (mut standing, mut taken) = fetch(address, "");
    for number in 0..FRAMES {
        while outbox.is_full() {
            assert!(Instant::now() < deadline, "nothing is drawn any more");
            std::thread::sleep(Duration::from_millis(1));
        }
        outbox.push(frame(number));
        most_mib = most_mib.max(resident_mib() - before_mib);
        if number % (FRAMES / WEDGED) == 0 {
            wedged.push(ask(address, "/drawn?"));
        }
        let (instance, next) = (standing["instance"].as_str().unwrap(), &standing["next"]);
        let (head, bytes) = fetch(address, &format!("instance={instance}&from={next}"));
        (standing, taken) = (head, taken + bytes);
    }
    let bound_mib = KEPT_MIB + WEDGED as f64 * ANSWER_MIB + ON_ITS_WAY_MIB;
    assert!(most_mib < bound_mib, "{most_mib} MiB more, {bound_mib} MiB at most");
    // Whoever reads and keeps pace was given all but the last few frames.
    let all = FRAMES * ROWS * 16;
    assert!(taken > all / 10 * 9, "{taken} of {all} bytes were given");
    assert_eq!(outbox.dropped(), 0);
    drop((wedged, shown));
}
