//! The live view beside a running capture: what an operator sees, and whom it must not disturb.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stderr, reason = "a test that fails prints what its run had to say")]

use std::process::Child;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tests::browser::{Browser, Look, Page, SIZE};
use tests::live_view::{LiveView, listening_addresses, resident_mib};
use tests::{Bench, printed};

/// What a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shows {
    /// Lines, points or bodies in colours; axes and grids are grey.
    Colours,
    /// Text, whose edges have many greys.
    Text,
}

/// A tab's name for its picture, its place in the row of tabs, pixels, and its views.
type Tab = (&'static str, u32, &'static [(Shows, [f64; 4])]);

/// The tabs with their places on the page, and each view in them: x, y, width and height as shares of the room below the
/// tabs.
const TABS: [Tab; 4] = [
    (
        "knob",
        40,
        &[
            (Shows::Colours, [0.02, 0.06, 0.36, 0.9]),
            (Shows::Colours, [0.45, 0.06, 0.24, 0.4]),
            (Shows::Colours, [0.45, 0.56, 0.24, 0.4]),
            (Shows::Text, [0.74, 0.08, 0.2, 0.3]),
        ],
    ),
    (
        "signals-and-model",
        140,
        &[
            (Shows::Colours, [0.05, 0.06, 0.33, 0.16]),
            (Shows::Colours, [0.05, 0.28, 0.33, 0.16]),
            (Shows::Colours, [0.05, 0.51, 0.33, 0.16]),
            (Shows::Colours, [0.05, 0.75, 0.33, 0.22]),
            (Shows::Colours, [0.46, 0.08, 0.28, 0.4]),
            (Shows::Colours, [0.46, 0.58, 0.28, 0.4]),
            (Shows::Text, [0.78, 0.08, 0.18, 0.3]),
        ],
    ),
    (
        "parameters",
        250,
        &[
            (Shows::Colours, [0.03, 0.06, 0.18, 0.4]),
            (Shows::Colours, [0.27, 0.06, 0.18, 0.4]),
            (Shows::Colours, [0.50, 0.06, 0.18, 0.4]),
            (Shows::Colours, [0.03, 0.56, 0.18, 0.4]),
            (Shows::Colours, [0.27, 0.56, 0.18, 0.4]),
            (Shows::Colours, [0.50, 0.56, 0.18, 0.4]),
            (Shows::Text, [0.72, 0.08, 0.22, 0.3]),
        ],
    ),
    (
        "timing-and-processes",
        380,
        &[
            (Shows::Colours, [0.05, 0.06, 0.5, 0.3]),
            (Shows::Colours, [0.65, 0.06, 0.3, 0.3]),
            (Shows::Colours, [0.04, 0.45, 0.24, 0.23]),
            (Shows::Colours, [0.35, 0.45, 0.22, 0.23]),
            (Shows::Colours, [0.04, 0.75, 0.24, 0.22]),
            (Shows::Colours, [0.35, 0.75, 0.22, 0.22]),
            (Shows::Text, [0.62, 0.46, 0.3, 0.2]),
        ],
    ),
];
impl Shows {
    fn is_in(self, look: Look) -> bool {
        match self {
            Self::Colours => look.coloured > 1e-4,
            Self::Text => look.shades > 40,
        }
    }
}

/// Heights of the row of tabs and of the time bar, pixels.
const TABS_HEIGHT: f64 = 25.0;
const TIME_BAR_HEIGHT: f64 = 30.0;

/// One capture at a time: a viewer that starts may take the port of one that was killed a moment before, and a browser
/// without a graphics card takes all of the processor.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// A capture that goes on until it is ended, also by a test that fails.
struct Running {
    child: Option<Child>,
    _alone: MutexGuard<'static, ()>,
}

impl Running {
    /// Starts it with its view.
    fn start(bench: &Bench) -> (Self, LiveView) {
        let alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        // The slower the loop, the more of the processor is left to a browser that has no graphics card.
        let child = bench.start(&["capture", "--duration-s", "1200", "--rate-hz", "5000", "--out", "out"]).unwrap();
        let running = Self { child: Some(child), _alone: alone };
        let view = LiveView::of_rig(&bench.path("rig")).unwrap();
        (running, view)
    }

    /// Ends it in order and checks that no sample is missing that was published.
    fn ends_whole(mut self, bench: &Bench) {
        let child = self.child.take().unwrap();
        kill(pid(&child), Signal::SIGINT).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
        assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
        assert_eq!(bench.leftovers(), Vec::<String>::new());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = self.child.take() {
            let _ = kill(pid(&child), Signal::SIGTERM);
            // Of a test that fails: what the run had to say.
            eprintln!("{}", child.wait_with_output().map_or_else(|error| error.to_string(), |output| printed(&output)));
        }
    }
}

fn pid(child: &Child) -> Pid {
    Pid::from_raw(i32::try_from(child.id()).unwrap())
}

/// Waits until the viewer in the page holds more of the run than when it is asked.
fn data_arrives(browser: &mut Browser, page: Page) {
    browser.wait_until(page, "(window.before ??= document.body.dataset.newest, true)").unwrap();
    let more = "Number(document.body.dataset.newest) > (Number(window.before) || 0)";
    browser.wait_until(page, more).unwrap();
    browser.evaluate(page, "delete window.before").unwrap();
}

/// Clicks on a tab and waits until each of its views shows something.
fn shows_all(browser: &mut Browser, page: Page, (name, x, views): Tab) {
    let mut number = |expression: &str| browser.evaluate(page, expression).unwrap().as_f64().unwrap();
    let top = number("document.getElementById('viewer').getBoundingClientRect().top");
    // Without a graphics card the viewer draws fewer pixels than it covers.
    let scale = number(
        "document.getElementById('viewer').getBoundingClientRect().height / document.getElementById('viewer').offsetHeight",
    );
    let [width, height] = SIZE.map(f64::from);
    let (tabs_height, time_bar_height) = (scale * TABS_HEIGHT, scale * TIME_BAR_HEIGHT);
    browser.click(page, (scale * f64::from(x)) as u32, (top + tabs_height / 2.0) as u32).unwrap();
    for &(shows, [left, above, wide, high]) in views {
        let room = height - top - tabs_height - time_bar_height;
        let down = top + tabs_height + above * room;
        let part = [left * width, down, wide * width, high * room].map(|pixels| pixels as u32);
        let mut look = browser.look(page, part).unwrap();
        // What has arrived a moment ago may not be drawn yet, by a browser that has no graphics card.
        for _ in 0..180 {
            if shows.is_in(look) {
                break;
            }
            std::thread::sleep(Duration::from_secs(1));
            look = browser.look(page, part).unwrap();
        }
        if !shows.is_in(look) {
            browser.picture(page, name).unwrap();
            panic!("{name}, {part:?} shows nothing: {look:?}");
        }
    }
}

#[test]
fn every_view_shows_its_data_and_a_killed_viewer_comes_back_to_the_same_tab() {
    let bench = Bench::new().unwrap();
    let (running, view) = Running::start(&bench);
    let mut browser = Browser::start().unwrap();
    let page = browser.open(&view.url()).unwrap();
    data_arrives(&mut browser, page);
    for tab in TABS {
        shows_all(&mut browser, page, tab);
        browser.picture(page, tab.0).unwrap();
    }

    browser.close(page).unwrap();
    let page = browser.open(&view.url()).unwrap();
    data_arrives(&mut browser, page);
    shows_all(&mut browser, page, TABS[1]);
    browser.picture(page, "opened-again").unwrap();
    // All of the past comes while the run goes on, up to its first second.
    let recording = &view.status().unwrap()["recording"];
    let past = format!("window.viewer.get_timeline_time_range({recording}, 'time_s').min < 1e9");
    browser.wait_until(page, &past).unwrap();

    let before = view.status().unwrap()["instance"].clone();
    bench.kill("rerun-viewer").unwrap();
    view.wait_for(|status| status["instance"] != before && !status["recording"].is_null()).unwrap();
    let after = format!("document.body.dataset.instance === {}", view.status().unwrap()["instance"]);
    browser.wait_until(page, &after).unwrap();
    data_arrives(&mut browser, page);
    shows_all(&mut browser, page, TABS[0]);
    browser.picture(page, "after-a-kill").unwrap();

    // A browser that the system has suspended: the run goes on, and so does the view for others.
    browser.signal(Signal::SIGSTOP).unwrap();
    let then = view.status().unwrap()["time_s"].as_f64().unwrap();
    view.wait_for(|status| status["time_s"].as_f64() > Some(then + 3.0)).unwrap();
    running.ends_whole(&bench);
}

#[test]
fn a_client_that_never_reads_disturbs_nobody() {
    let bench = Bench::new().unwrap();
    let (running, view) = Running::start(&bench);
    view.wait_for(|status| status["time_s"].as_f64() > Some(0.5)).unwrap();
    let viewer = bench.wait_for_process("rerun-viewer").unwrap();
    // Each asks for more than any buffer takes.
    let wedged: Vec<_> = (0..40).map(|_| view.ask("re_viewer_bg.wasm").unwrap()).collect();
    view.wait_for(|status| status["time_s"].as_f64() > Some(6.0)).unwrap();
    let (head, _) = view.drawn("").unwrap();
    let (instance, next) = (head["instance"].as_str().unwrap(), &head["next"]);
    view.wait_for(|status| status["time_s"].as_f64() > Some(9.0)).unwrap();
    let (_, more) = view.drawn(&format!("instance={instance}&from={next}")).unwrap();
    assert!(more > 0, "the one that reads is given more");
    assert_eq!(bench.wait_for_process("rerun-viewer").unwrap(), viewer, "the viewer was never restarted");
    // The page's program alone, which is a part of the viewer's, is 40 MiB.
    let resident = resident_mib(viewer).unwrap();
    assert!(resident < 256.0, "{resident} MiB");
    let status = view.status().unwrap();
    let recorder = status["processes"].as_array().unwrap().iter().find(|process| process["name"] == "recorder");
    assert_eq!(recorder.unwrap()["condition"], "alive", "{status}");
    running.ends_whole(&bench);
    drop(wedged);
}

#[test]
fn nothing_listens_beyond_this_machine() {
    let bench = Bench::new().unwrap();
    let (running, view) = Running::start(&bench);
    view.status().unwrap();
    let mut listening = Vec::new();
    for program in ["haptic-camera", "rt-loop", "recorder", "live-fitter", "rerun-viewer"] {
        for process in bench.processes(program) {
            listening.extend(listening_addresses(process).unwrap());
        }
    }
    assert_eq!(listening.len(), 1, "the page and nothing else: {listening:?}");
    // 127.0.0.1 as the kernel writes it.
    let beyond: Vec<_> = listening.iter().filter(|address| !address.starts_with("0100007F:")).collect();
    assert!(beyond.is_empty(), "{beyond:?}");
    running.ends_whole(&bench);
}
