//! Where frames become visible: a web page, rerun's window, or a file.
//!
//! The screen has a thread of its own, fed from an [`Outbox`]: whatever rerun waits for, nobody
//! else waits. Each run is a recording of its own. rerun's client never connects again by itself,
//! so when its window is gone the screen looks for a new one and begins there afresh.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

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
use crate::outbox::{self, Outbox};
use crate::recording_file::RecordingFile;
use crate::{entities, layout, page, port};

/// Name under which rerun keeps the layout.
const APPLICATION: &str = "haptic-camera";
/// How often the window is asked whether it is still there.
const CONNECTION_CHECK: Duration = Duration::from_millis(500);
/// What is given to finding out whether a window listens.
const CONNECT_LIMIT: Duration = Duration::from_millis(200);

/// Where to show.
#[derive(Debug)]
pub enum Destination {
    /// A web page.
    Web {
        /// Its address and port.
        address: SocketAddr,
        /// The same port, taken, until the server is connected to it.
        taken: Option<TcpListener>,
        /// What is kept for a page opened later.
        memory_limit: ByteSize,
        /// How long a page may take nothing before it loses its connection.
        patience: Duration,
    },
    /// rerun's own window on this machine.
    Native {
        /// Port that it listens at.
        grpc_port: u16,
        /// What it may keep.
        memory_limit: ByteSize,
    },
    /// A rerun file.
    File(PathBuf),
}

impl Destination {
    /// What the command line asks for, with a port that is free.
    ///
    /// # Errors
    /// When no port is free.
    pub fn from_arguments(arguments: &Arguments) -> anyhow::Result<Self> {
        let Arguments { native, save, bind, web_port, grpc_port, memory_limit, restarts, .. } = arguments;
        let memory_limit = *memory_limit;
        if let Some(path) = save {
            return Ok(Self::File(path.clone()));
        }
        if *native {
            return Ok(Self::Native { grpc_port: *grpc_port, memory_limit });
        }
        let taken = port::take(SocketAddr::new(*bind, *web_port), *restarts)?;
        let address = taken.local_addr()?;
        Ok(Self::Web { address, taken: Some(taken), memory_limit, patience: page::server::PATIENCE })
    }

    /// Whether there is nothing left to do when the run has ended.
    pub const fn ends_with_run(&self) -> bool {
        matches!(self, Self::File(_))
    }

    /// How long closing may take.
    pub const fn exit_limit(&self) -> Duration {
        match self {
            Self::File(_) => Duration::from_secs(10),
            Self::Web { .. } | Self::Native { .. } => Duration::from_secs(1),
        }
    }
}

/// An open destination.
pub struct Screen {
    destination: Destination,
    subject: Subject,
    /// Carries every run: rerun ties windows and files to one recording.
    carrier: RecordingStream,
    /// The run that is shown and the pen that draws it.
    shown: Option<(u64, Pen)>,
    /// Where pages take from what is drawn.
    drawn: Drawn,
    /// Where what is drawn is written to, if to a file.
    file: Option<RecordingFile>,
    disconnected: Arc<AtomicBool>,
    next_check: Instant,
}

impl Screen {
    /// Opens the destination; nothing is shown yet but the layout.
    ///
    /// # Errors
    /// When a port, the `rerun` program or the file is not available.
    pub fn open(mut destination: Destination, subject: Subject, glance: SharedGlance) -> anyhow::Result<Self> {
        if let Destination::Native { grpc_port, memory_limit } = &destination {
            open_window(*grpc_port, *memory_limit)?;
        }
        let (memory_limit, file) = match &destination {
            Destination::Web { memory_limit, .. } => (memory_limit.as_u64(), None),
            Destination::Native { .. } => (0, None),
            Destination::File(path) => (0, Some(RecordingFile::create(path)?)),
        };
        let drawn = Drawn::new(memory_limit);
        let carrier = carrier(&destination, subject, &drawn, file.as_ref())?;
        if let Destination::Web { taken, patience, .. } = &mut destination
            && let Some(listener) = taken.take()
        {
            page::serve(listener, *patience, glance, drawn.clone()).context("the web page cannot be served")?;
        }
        Ok(Self {
            destination,
            subject,
            carrier,
            shown: None,
            drawn,
            file,
            disconnected: Arc::default(),
            next_check: Instant::now(),
        })
    }

    /// The port of the web page, if it is one.
    pub fn port(&self) -> Option<u16> {
        self.address().map(|address| address.port())
    }

    /// The address to show to the operator.
    pub fn place(&self) -> Option<String> {
        self.address().map(url)
    }

    const fn address(&self) -> Option<SocketAddr> {
        if let Destination::Web { address, .. } = &self.destination { Some(*address) } else { None }
    }

    /// Shows frames from `outbox` on a thread of its own until it is closed and empty.
    ///
    /// The receiver is notified once everything is written and the destination is closed, or why a file cannot be written, as
    /// soon as that is known.
    ///
    /// # Errors
    /// When no thread is to be had.
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
                outbox::Taken::Item(frame) => self.show(&frame, outbox),
                outbox::Taken::Nothing => {}
                outbox::Taken::Closed => break,
            }
            self.look_after_window();
            self.file.as_ref().map_or(Ok(()), RecordingFile::check)?;
        }
        let file = self.file.take();
        // What was drawn leaves rerun at the latest when it is dropped.
        drop(self);
        file.as_ref().map_or(Ok(()), RecordingFile::finish)
    }

    fn show(&mut self, frame: &Frame, outbox: &Outbox<Frame>) {
        if self.disconnected.load(Ordering::Relaxed) {
            outbox.count_dropped();
            return;
        }
        if let Err(error) = self.draw(frame) {
            tracing::error!("a frame of the live view could not be drawn: {error:#}");
            outbox.count_dropped();
        }
    }

    fn draw(&mut self, frame: &Frame) -> anyhow::Result<()> {
        let is_page = self.port().is_some();
        let pen = self.pen_of(frame.run_id)?;
        pen.draw(frame)?;
        if is_page {
            pen.flush()?;
            self.carrier.flush_blocking()?;
            self.drawn.seal();
        }
        Ok(())
    }

    fn pen_of(&mut self, run_id: u64) -> anyhow::Result<&mut Pen> {
        let pen = match self.shown.take() {
            Some((shown, pen)) if shown == run_id => pen,
            // A file and a window begin with the run itself.
            None if !matches!(self.destination, Destination::Web { .. }) => {
                Pen::new(self.carrier.clone(), self.subject.axis)?
            }
            _ => Pen::new(recording_of(run_id, &self.carrier)?, self.subject.axis)?,
        };
        Ok(&mut self.shown.insert((run_id, pen)).1)
    }

    /// Finds out whether rerun's window went away and, if so, looks for another one.
    fn look_after_window(&mut self) {
        let Destination::Native { grpc_port, .. } = self.destination else {
            return;
        };
        if Instant::now() < self.next_check {
            return;
        }
        self.next_check = Instant::now() + CONNECTION_CHECK;
        if !self.disconnected.load(Ordering::Relaxed) {
            let disconnected = Arc::clone(&self.disconnected);
            self.carrier.inspect_sink(move |sink| {
                let sink: &dyn std::any::Any = sink;
                let state = sink.downcast_ref::<GrpcSink>().map(GrpcSink::status);
                if matches!(state, Some(GrpcSinkConnectionState::Disconnected(_))) {
                    disconnected.store(true, Ordering::Relaxed);
                }
            });
        } else if listens(grpc_port) {
            match carrier(&self.destination, self.subject, &self.drawn, self.file.as_ref()) {
                Ok(carrier) => self.begin_afresh(carrier),
                Err(error) => tracing::error!("the new window cannot be used: {error:#}"),
            }
        }
    }

    fn begin_afresh(&mut self, carrier: RecordingStream) {
        let lost = (std::mem::replace(&mut self.carrier, carrier), self.shown.take());
        // Its end may wait without limit for a window that is gone.
        std::thread::spawn(move || drop(lost));
        self.disconnected = Arc::default();
    }
}

/// A recording that leads to the destination, with layout and styles.
fn carrier(
    destination: &Destination,
    subject: Subject,
    drawn: &Drawn,
    file: Option<&RecordingFile>,
) -> anyhow::Result<RecordingStream> {
    let builder = RecordingStreamBuilder::new(APPLICATION);
    let recording = match destination {
        Destination::Web { .. } => {
            let recording = builder.buffered()?;
            let drawn = drawn.clone();
            recording.set_sink(Box::new(CallbackSink::new(move |messages| drawn.take_in(messages))));
            recording
        }
        Destination::Native { grpc_port, .. } => {
            builder.connect_grpc_opts(format!("rerun+http://127.0.0.1:{grpc_port}/proxy"))?
        }
        Destination::File(_) => {
            let recording = builder.buffered()?;
            if let Some(file) = file {
                recording.set_sink(Box::new(file.sink()));
            }
            recording
        }
    };
    layout::send(&recording, subject)?;
    if matches!(destination, Destination::Web { .. }) {
        recording.flush_blocking()?;
        drawn.seal();
    }
    Ok(recording)
}

/// The recording of a run, which goes the carrier's way. Its name is the run's: what a viewer that was started again
/// shows joins what a page has already.
fn recording_of(run_id: u64, carrier: &RecordingStream) -> anyhow::Result<RecordingStream> {
    let recording = RecordingStreamBuilder::new(APPLICATION).recording_id(entities::recording(run_id)).buffered()?;
    let carrier = carrier.clone();
    recording.set_sink(Box::new(CallbackSink::new(move |messages| {
        messages.iter().for_each(|message| carrier.record_msg(message.clone()));
    })));
    Ok(recording)
}

/// What a browser on this machine is given.
fn url(address: SocketAddr) -> String {
    let host = if address.ip().is_unspecified() { IpAddr::V4(Ipv4Addr::LOCALHOST) } else { address.ip() };
    format!("http://{}/", SocketAddr::new(host, address.port()))
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

fn listens(port: u16) -> bool {
    TcpStream::connect_timeout(&SocketAddr::from((Ipv4Addr::LOCALHOST, port)), CONNECT_LIMIT).is_ok()
}
