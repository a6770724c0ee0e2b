//! Where frames become visible: a web page, rerun's window, or a file.
//!
//! The screen has a thread of its own, fed from an [`Outbox`]: whatever rerun waits for, nobody else waits. Each run is a
//! recording of its own. rerun's client never connects again by itself: when its window is gone, the screen looks for another.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use anyhow::{Context as _, bail};
use bytesize::ByteSize;
use rerun::sink::{CallbackSink, GrpcSink, GrpcSinkConnectionState};
use rerun::{RecordingStream, RecordingStreamBuilder, SpawnError, SpawnOptions};

use crate::cli::Arguments;
use crate::drawing::Pen;
use crate::drawn::Drawn;
use crate::frame::Frame;
use crate::glance::SharedGlance;
use crate::layout::Subject;
use crate::outbox::Outbox;
use crate::recording_file::RecordingFile;
use crate::timer::Timer;
use crate::{entities, layout, page, port};

/// Name under which rerun keeps the layout.
const APPLICATION: &str = "haptic-camera";
/// How often the window is asked whether it is still there.
const CONNECTION_CHECK: Duration = Duration::from_millis(500);
/// Time limit for finding out whether a window listens.
const CONNECT_LIMIT: Duration = Duration::from_millis(200);

enum Place {
    /// The page served at that address, and the picture that it shows.
    Page(SocketAddr, Drawn),
    /// rerun's own window on this machine, which listens at that port.
    Window(u16),
    File(RecordingFile),
}

pub struct Screen {
    place: Place,
    subject: Subject,
    /// Carries every run: rerun ties windows and files to one recording.
    carrier: RecordingStream,
    /// The run that is shown and the pen that draws it.
    shown: Option<(u64, Pen)>,
    disconnected: Arc<AtomicBool>,
    checks: Timer,
}

impl Screen {
    /// Opens what the command line asks for; nothing is shown yet but the layout.
    /// Fails when a port, the `rerun` program or the file is not available.
    pub fn open(arguments: &Arguments, subject: Subject, glance: SharedGlance) -> anyhow::Result<Self> {
        let Arguments { native, save, bind, web_port, grpc_port, memory_limit, restarts, .. } = arguments;
        let place = if let Some(path) = save {
            Place::File(RecordingFile::create(path)?)
        } else if *native {
            open_window(*grpc_port, *memory_limit)?;
            Place::Window(*grpc_port)
        } else {
            let listener = port::take(SocketAddr::new(*bind, *web_port), *restarts)?;
            let (address, drawn) = (listener.local_addr()?, Drawn::new(memory_limit.as_u64()));
            page::serve(listener, glance, drawn.clone()).context("the web page cannot be served")?;
            Place::Page(address, drawn)
        };
        let carrier = place.carrier(subject)?;
        Ok(Self { place, subject, carrier, shown: None, disconnected: Arc::default(), checks: Timer::default() })
    }

    /// Where a browser on this machine finds the web page, if it is one.
    pub fn page(&self) -> Option<SocketAddr> {
        let Place::Page(address, _) = &self.place else { return None };
        let host = if address.ip().is_unspecified() { IpAddr::V4(Ipv4Addr::LOCALHOST) } else { address.ip() };
        Some(SocketAddr::new(host, address.port()))
    }

    /// Shows frames from `outbox` on a thread of its own until it is closed and empty.
    /// The receiver hears when all is written and closed, or why a file cannot be written as soon as that is known.
    pub fn show_from(self, outbox: Arc<Outbox<Frame>>) -> anyhow::Result<mpsc::Receiver<anyhow::Result<()>>> {
        let (closed, is_closed) = mpsc::channel();
        let show = move || {
            let shown = self.show_all(&outbox);
            // Nobody need fill it any more.
            outbox.close();
            // Nobody listens any more when the time for closing has passed.
            let _ = closed.send(shown);
        };
        std::thread::Builder::new().name("screen".to_owned()).spawn(show).context("no thread for the screen")?;
        Ok(is_closed)
    }

    fn show_all(mut self, outbox: &Outbox<Frame>) -> anyhow::Result<()> {
        loop {
            match outbox.take(CONNECTION_CHECK) {
                Ok(_) if self.disconnected.load(Ordering::Relaxed) => outbox.count_dropped(),
                Ok(frame) => {
                    if let Err(error) = self.draw(&frame) {
                        tracing::error!("a frame of the live view could not be drawn: {error:#}");
                        outbox.count_dropped();
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            match &self.place {
                Place::Page(..) => {}
                Place::Window(port) => self.look_after_window(*port),
                Place::File(file) => file.check()?,
            }
        }
        let Self { place, carrier, shown, .. } = self;
        // What was drawn leaves rerun at the latest when it is dropped.
        drop((shown, carrier));
        if let Place::File(file) = place { file.finish() } else { Ok(()) }
    }

    fn draw(&mut self, frame: &Frame) -> anyhow::Result<()> {
        let pen = match self.shown.take() {
            Some((shown, pen)) if shown == frame.run_id => pen,
            // A file and a window begin with the run itself.
            None if !matches!(self.place, Place::Page(..)) => Pen::new(self.carrier.clone(), self.subject.axis)?,
            _ => Pen::new(recording_of(frame.run_id, &self.carrier)?, self.subject.axis)?,
        };
        let (_, pen) = self.shown.insert((frame.run_id, pen));
        pen.draw(frame)?;
        if let Place::Page(_, drawn) = &self.place {
            pen.recording.flush_blocking()?;
            self.carrier.flush_blocking()?;
            drawn.seal();
        }
        Ok(())
    }

    /// Finds out whether rerun's window went away and, if so, looks for another one.
    fn look_after_window(&mut self, port: u16) {
        if !self.checks.is_due(CONNECTION_CHECK) {
            return;
        }
        if !self.disconnected.load(Ordering::Relaxed) {
            let disconnected = Arc::clone(&self.disconnected);
            self.carrier.inspect_sink(move |sink| {
                let sink: &dyn std::any::Any = sink;
                let state = sink.downcast_ref::<GrpcSink>().map(GrpcSink::status);
                if matches!(state, Some(GrpcSinkConnectionState::Disconnected(_))) {
                    disconnected.store(true, Ordering::Relaxed);
                }
            });
        } else if TcpStream::connect_timeout(&SocketAddr::from((Ipv4Addr::LOCALHOST, port)), CONNECT_LIMIT).is_ok() {
            match self.place.carrier(self.subject) {
                Ok(carrier) => {
                    let lost = (std::mem::replace(&mut self.carrier, carrier), self.shown.take());
                    // Its end may wait without limit for a window that is gone.
                    std::thread::spawn(move || drop(lost));
                    self.disconnected = Arc::default();
                }
                Err(error) => tracing::error!("the new window cannot be used: {error:#}"),
            }
        }
    }
}

impl Place {
    /// A recording that leads here, with the layout.
    fn carrier(&self, subject: Subject) -> anyhow::Result<RecordingStream> {
        let builder = RecordingStreamBuilder::new(APPLICATION);
        let recording = match self {
            Self::Page(_, drawn) => sent_to(drawn.sink(), builder)?,
            Self::Window(port) => builder.connect_grpc_opts(format!("rerun+http://127.0.0.1:{port}/proxy"))?,
            Self::File(file) => sent_to(file.sink(), builder)?,
        };
        layout::send(&recording, subject)?;
        if let Self::Page(_, drawn) = self {
            recording.flush_blocking()?;
            drawn.seal();
        }
        Ok(recording)
    }
}

/// The recording of a run, which goes the carrier's way. It is named after the run, so that what a restarted viewer shows joins
/// what a page already has.
fn recording_of(run_id: u64, carrier: &RecordingStream) -> anyhow::Result<RecordingStream> {
    let carrier = carrier.clone();
    let onwards =
        CallbackSink::new(move |messages| messages.iter().for_each(|message| carrier.record_msg(message.clone())));
    sent_to(onwards, RecordingStreamBuilder::new(APPLICATION).recording_id(entities::recording(run_id)))
}

/// A recording that goes there.
pub fn sent_to(sink: CallbackSink, recording: RecordingStreamBuilder) -> anyhow::Result<RecordingStream> {
    let recording = recording.buffered()?;
    recording.set_sink(Box::new(sink));
    Ok(recording)
}

fn open_window(port: u16, memory_limit: ByteSize) -> anyhow::Result<()> {
    let options = SpawnOptions {
        port,
        memory_limit: format!("{}B", memory_limit.as_u64()),
        hide_welcome_screen: true,
        ..SpawnOptions::default()
    };
    match rerun::spawn(&options) {
        Ok(_) => Ok(()),
        Err(SpawnError::ExecutableNotFoundInPath { executable_name, .. }) => bail!(
            "the program '{executable_name}' that shows rerun's window is not installed; \
             'cargo install rerun-cli --version 0.36.3 --locked' does it, or leave out --native for the web page"
        ),
        Err(error) => Err(error).context("rerun's window cannot be opened; leave out --native for the web page"),
    }
}
