//! The instrument's viewer: it shows the measured signals, the fitted model and the state of the processes.
//!
//! The viewer is last in line. It reads the sample stream, the fitter's updates and the health reports from shared memory,
//! reduces them to what a screen can show and hands them to [rerun](https://rerun.io). It publishes its own health and
//! nothing else. `docs/live-view.md` says what is to be seen.
//!
//! ```text
//! rig ──► source ──► picture ──► outbox ──► screen ──► web page | window | file
//!         20 ms      250 ms      drops      a thread of its own,
//!         polls      frames      oldest     may stall as it likes
//! ```
//!
//! - **When it stalls or dies** nobody notices: shared memory drops its oldest blocks, the control loop never waits. A viewer
//!   started again receives the last seconds first, at the port that it had ([`port`]), and the page goes on with it.
//! - **When rerun stalls** the outbox drops the oldest frames and counts them; polling goes on.
//! - **When the run ends** the page stays up until SIGTERM, so that one can look; a file is closed.
//! - **SIGINT** is the supervisor's business and ignored, unless the operator has the viewer itself in the foreground; SIGTERM
//!   and the parent's death end it.
//!
//! A finished capture is another source for the same picture. It is shown whole: a file waits while the outbox is full, so no
//! frame is dropped, and the model is the one that the whole capture gives. A [`diagnosis`] becomes a file at once.

mod capture_source;
mod capture_summary;
mod cli;
mod decimation;
mod diagnosis;
mod drawing;
mod drawn;
mod entities;
mod extent;
mod frame;
mod glance;
mod knob_drawing;
mod knob_track;
mod layout;
mod layout_properties;
mod model_curves;
mod model_torque;
mod numbers;
mod outbox;
mod page;
mod palette;
mod peer;
mod picture;
mod plot_axes;
mod plot_drawing;
mod port;
mod processes;
mod recording_file;
mod remote;
mod rendered;
mod rig_source;
mod run;
mod scatter;
mod screen;
mod series_styles;
mod signals;
mod slider_drawing;
mod source;
mod strokes;
mod summary;
mod timer;
#[cfg(test)]
mod wedged_page;

use std::io::Write as _;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use consumer::Stop;

use crate::capture_source::CaptureSource;
use crate::cli::{Arguments, Command};
use crate::glance::SharedGlance;
use crate::layout::Subject;
use crate::outbox::Outbox;
use crate::picture::Picture;
use crate::rig_source::RigSource;
use crate::screen::Screen;
use crate::source::Source;
use crate::timer::Timer;

/// How long a run's description is waited for before the view is laid out.
const DESCRIPTION_PATIENCE: Duration = Duration::from_secs(1);
/// How often shared memory is looked at.
const POLL_PERIOD: Duration = Duration::from_millis(20);
const FRAME_PERIOD: Duration = Duration::from_millis(250);
/// Exit status when a file was written but lacks something.
const EXIT_DATA_LOST: i32 = 3;
/// Frames that may wait for a stalled screen: 10 s.
const OUTBOX_FRAMES: usize = 40;

fn main() -> ExitCode {
    let arguments: Arguments = match operator::parse() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    let done = match &arguments.command {
        Some(Command::Diagnosis { json, out }) => diagnosis::record(json, out).map(|()| false),
        None => show(&arguments),
    };
    match done {
        // Threads that wait for rerun are left behind.
        Ok(data_was_lost) => std::process::exit(if data_was_lost { EXIT_DATA_LOST } else { 0 }),
        Err(error) => {
            operator::tell_error(&error);
            ExitCode::FAILURE
        }
    }
}

/// Shows a run or a capture until it is stopped; whether a file that was asked for lacks something.
fn show(arguments: &Arguments) -> anyhow::Result<bool> {
    operator::start_log(operator::LevelFilter::WARN);
    // The note of the port, and a file that is asked for.
    shared_types::rig::keep_files_private();
    let in_foreground = arguments.foreground || arguments.capture.is_some();
    let stop = if in_foreground { Stop::listen_in_foreground()? } else { Stop::listen()? };

    let (mut source, mut picture, subject) = open(arguments)?;
    // A file has nothing left to do then.
    let ends_with_run = arguments.save.is_some();
    let exit_limit_s = if ends_with_run { 10 } else { 1 };
    let glance = SharedGlance::new(glance::of(&picture.run).into());
    let screen = Screen::open(arguments, subject, glance.clone())?;
    if let Some(page) = screen.page() {
        announce(page, subject, in_foreground, arguments.remote);
        if !in_foreground && let Err(error) = port::note(page.port()) {
            tracing::warn!("after a restart the live view may have another address: {error:#}");
        }
    }

    let outbox = Arc::new(Outbox::new(OUTBOX_FRAMES));
    let shown = screen.show_from(Arc::clone(&outbox))?;
    let mut frames = Timer::default();
    while !(stop.is_asked() || outbox.is_closed() || (ends_with_run && picture.ended)) {
        // A file waits for a slow screen; a rig would lose what is not taken in.
        if subject.is_live || !outbox.is_full() {
            let samples_wanted = picture.run.rate_hz().is_some();
            source.poll(samples_wanted, &mut picture)?;
            if frames.is_due(FRAME_PERIOD) {
                *glance.lock() = glance::of(&picture.run);
                if let Some(frame) = picture.next_frame(outbox.dropped()) {
                    outbox.push(frame);
                }
            }
        }
        std::thread::sleep(POLL_PERIOD);
    }
    drop(source);
    // There is no supervisor to do it.
    let cleared = (in_foreground && subject.is_live).then(shared_types::clean_up::clear_shared_memory).transpose();

    // rerun waits without limit when it is dropped, so it is given a time and then left behind.
    outbox.close();
    let closed = shown.recv_timeout(Duration::from_secs(exit_limit_s));
    let closed_in_time = closed.is_ok();
    closed.unwrap_or(Ok(()))?;
    if !closed_in_time && ends_with_run {
        tracing::error!(
            "the file was not closed within {exit_limit_s} s and may lack its end; free space on its disk and capture again"
        );
    }
    if outbox.dropped() > 0 {
        tracing::warn!("{} frames were not shown because the screen was not fast enough", outbox.dropped());
    }
    cleared?;
    Ok(ends_with_run && (!closed_in_time || outbox.dropped() > 0))
}

/// Where the samples come from, and the empty picture of them.
fn open(arguments: &Arguments) -> anyhow::Result<(Box<dyn Source>, Picture, Subject)> {
    let Some(path) = &arguments.capture else {
        let mut source = RigSource::attach(arguments.restarts)?;
        let mut picture = Picture::default();
        // Names and units are the run's; where none is under way, those of what turns.
        let until = Instant::now() + DESCRIPTION_PATIENCE;
        while picture.run.axis.is_none() && Instant::now() < until {
            source.poll(false, &mut picture)?;
            std::thread::sleep(POLL_PERIOD);
        }
        let subject = Subject::live(&picture.run);
        return Ok((Box::new(source), picture, subject));
    };
    let same =
        |file: &&PathBuf| matches!((file.canonicalize(), path.canonicalize()), (Ok(file), Ok(path)) if file == path);
    if let Some(file) = arguments.save.as_ref().filter(same) {
        anyhow::bail!("{} is the capture itself; give --save another name", file.display());
    }
    let source = CaptureSource::open(path)?;
    let (picture, subject) = (Picture::of_capture(source.capture.len()), source.subject());
    Ok((Box::new(source), picture, subject))
}

/// Tells the operator where to look, and how from elsewhere if that is asked for; nothing else is written to standard output.
fn announce(page: SocketAddr, subject: Subject, in_foreground: bool, remote: bool) {
    let what = if subject.is_live { "live view" } else { "view of the capture" };
    let how_to_end = if in_foreground { " (Ctrl-C ends it)" } else { "" };
    let mut text = format!("{what}: http://{page}/{how_to_end}\n");
    if remote {
        let port = page.port();
        let tunnel = remote::tunnel(port, &remote::login());
        text += &format!("on the other machine: {tunnel}\nthen open there:      http://127.0.0.1:{port}/\n");
    }
    // Whoever closed the output does not want to know.
    let _ = std::io::stdout().write_all(text.as_bytes());
}
