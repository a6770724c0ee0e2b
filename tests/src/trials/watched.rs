//! A program whose lines are read as they come, each with the time at which it came.

use std::io::{BufRead as _, BufReader, Read};
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::ensure;
use shared_types::rig::monotonic_time_ns;

/// A line and when it came, ns of CLOCK_MONOTONIC.
type Line = (u64, String);

/// A running program, read so that it never waits for its reader.
pub(super) struct Watched {
    pub(super) child: Child,
    lines: Arc<Mutex<Vec<Line>>>,
    readers: Vec<JoinHandle<()>>,
}

impl Watched {
    /// Starts `command`, whose two outputs are pipes.
    pub(super) fn start(mut command: Command) -> anyhow::Result<Self> {
        let mut child = command.spawn()?;
        let lines = Arc::default();
        let outputs = [
            child.stdout.take().map(|pipe| Box::new(pipe) as Box<dyn Read + Send>),
            child.stderr.take().map(|pipe| Box::new(pipe) as Box<dyn Read + Send>),
        ];
        let readers = outputs.into_iter().flatten().map(|pipe| read(pipe, Arc::clone(&lines))).collect();
        Ok(Self { child, lines, readers })
    }

    /// Waits for the program's end, and for that of all that share its outputs.
    pub(super) fn wait(mut self, patience: Duration) -> anyhow::Result<(ExitStatus, Vec<Line>)> {
        let deadline = Instant::now() + patience;
        let status = loop {
            if let Some(status) = self.child.try_wait()? {
                break status;
            }
            if Instant::now() > deadline {
                let _ = self.child.kill();
                let _ = self.child.wait();
                anyhow::bail!("the program had not ended after {} s: {:?}", patience.as_secs(), self.said());
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        while !self.readers.iter().all(JoinHandle::is_finished) {
            ensure!(Instant::now() < deadline, "a process that shares the program's outputs does not end");
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok((status, self.said()))
    }

    fn said(&self) -> Vec<Line> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn read(pipe: Box<dyn Read + Send>, lines: Arc<Mutex<Vec<Line>>>) -> JoinHandle<()> {
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).lines().map_while(Result::ok) {
            lines.lock().unwrap_or_else(PoisonError::into_inner).push((monotonic_time_ns(), line));
        }
    })
}
