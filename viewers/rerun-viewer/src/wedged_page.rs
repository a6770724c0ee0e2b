//! A page that never reads, tried with more data than anyone holds back for it.
#![allow(clippy::unwrap_used, reason = "test")]

use std::io::{Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rerun::MemoryLimit;

use crate::frame::{Frame, SeriesRows};
use crate::glance::SharedGlance;
use crate::layout::Subject;
use crate::outbox::Outbox;
use crate::ports::{Ports, Taken};
use crate::screen::{Destination, Screen};

/// Frames and rows of each: 16 bytes a row, 960 MB in all.
const FRAMES: usize = 3_000;
const ROWS: usize = 20_000;
/// What may be kept for pages that come later, MiB.
const KEPT_MIB: f64 = 8.0;
/// What rerun's parts hold back at most, MiB: 128 in the server for its slowest reader, 128 on the way to the server, and 100
/// in each of the batchers of the run and of the carrier. At the rate of the live view it is a few.
const HELD_BACK_MIB: f64 = 456.0;
/// For what is on its way: buffers of connections, the frames that wait, what the allocator keeps.
const ON_ITS_WAY_MIB: f64 = 120.0;
/// When the test gives up, not a time that is asserted: without the guard the stream stands still for good.
const GIVEN_UP: Duration = Duration::from_secs(240);

/// A client that has asked for the stream, as a page does, and has read nothing yet.
fn client(ports: Ports) -> TcpStream {
    let mut connection = TcpStream::connect((Ipv4Addr::LOCALHOST, ports.stream)).unwrap();
    let request = "POST /rerun.sdk_comms.v1alpha1.MessageProxyService/ReadMessages HTTP/1.1\r\nHost: 127.0.0.1\r\n\
                   Content-Type: application/grpc-web+proto\r\nContent-Length: 5\r\n\r\n\0\0\0\0\0";
    connection.write_all(request.as_bytes()).unwrap();
    connection
}

/// A frame that no compression makes smaller.
fn frame(number: usize) -> Frame {
    let noise = |index: usize| {
        let mixed = ((number * ROWS + index) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    };
    let rows = SeriesRows {
        entity: "signals/torque_mnm".to_owned(),
        times_ns: (0..ROWS).map(|index| (noise(index) >> 20) as i64).collect(),
        values: (0..ROWS).map(|index| noise(index) as f64).collect(),
        values_per_row: 1,
    };
    let time_ns = i64::try_from(number).unwrap();
    Frame { run_id: 1, time_ns, series: vec![rows], plots: Vec::new(), lateness: None, knob: None, texts: Vec::new() }
}

fn resident_mib() -> f64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    statm.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() * 4096.0 / f64::from(1 << 20)
}

#[test]
fn a_page_that_never_reads_stops_no_other_and_costs_a_bounded_memory() {
    let bind = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let taken = Taken::first_free(bind, Ports { web: 43_000, stream: 43_020 }).unwrap();
    let ports = taken.numbers().unwrap();
    let inner_port = std::net::TcpListener::bind((bind, 0)).unwrap().local_addr().unwrap().port();
    let destination = Destination::Web {
        bind,
        ports,
        taken: Some(taken),
        inner_port,
        memory_limit: MemoryLimit::from_bytes((KEPT_MIB * f64::from(1 << 20)) as u64),
        patience: Duration::from_secs(1),
    };
    let screen = Screen::open(destination, Subject::Live, SharedGlance::default()).unwrap();
    let outbox = Arc::new(Outbox::new(4));
    let shown = screen.show_from(Arc::clone(&outbox)).unwrap();
    let deadline = Instant::now() + GIVEN_UP;
    let push = |frame| {
        while outbox.is_full() {
            assert!(Instant::now() < deadline, "the stream stands still");
            std::thread::sleep(Duration::from_millis(1));
        }
        outbox.push(frame);
    };
    push(frame(0));
    let wedged = client(ports);
    let mut reader = client(ports);
    let taken = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&taken);
    std::thread::spawn(move || {
        let mut portion = vec![0; 1 << 20];
        while let Ok(length @ 1..) = reader.read(&mut portion) {
            counter.fetch_add(length, Ordering::Relaxed);
        }
    });
    let before_mib = resident_mib();
    let mut most_mib = 0.0_f64;
    for number in 1..FRAMES {
        push(frame(number));
        most_mib = most_mib.max(resident_mib() - before_mib);
    }
    let bound_mib = KEPT_MIB + HELD_BACK_MIB + ON_ITS_WAY_MIB;
    assert!(most_mib < bound_mib, "{most_mib} MiB more, {bound_mib} MiB at most");
    // Whoever reads was given nearly all of it: what the server had still kept when it came, and all since.
    let all = FRAMES * ROWS * 16;
    while taken.load(Ordering::Relaxed) < all / 10 * 9 {
        assert!(Instant::now() < deadline, "{} of {all} bytes were given", taken.load(Ordering::Relaxed));
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(outbox.dropped(), 0);
    drop((wedged, shown));
}
