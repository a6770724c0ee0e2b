//! The live view of a capture, as its clients see it.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use nix::unistd::Pid;
use serde_json::Value;

/// How long the view may take to answer.
const PATIENCE: Duration = Duration::from_secs(30);

/// Where a capture's live view is to be had.
#[derive(Clone, Debug)]
pub struct LiveView {
    port: u16,
}

impl LiveView {
    /// The one that notes its port in the rig's folder.
    ///
    /// # Errors
    /// When none does so in time.
    pub fn of_rig(rig: &Path) -> anyhow::Result<Self> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let noted = std::fs::read(rig.join("live-view-port.json")).ok();
            if let Some(port) = noted.and_then(|json| serde_json::from_slice(&json).ok()) {
                return Ok(Self { port });
            }
            ensure!(Instant::now() < deadline, "the live view has noted no port");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// What a browser is given.
    #[must_use]
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// The state that the page fetches twice a second.
    ///
    /// # Errors
    /// When nothing answers.
    pub fn status(&self) -> anyhow::Result<Value> {
        Ok(serde_json::from_slice(&self.answer("status")?)?)
    }

    /// The metadata of the answer to this query for drawn frames, and its size in bytes.
    ///
    /// # Errors
    /// When nothing answers.
    pub fn drawn(&self, query: &str) -> anyhow::Result<(Value, usize)> {
        let answer = self.answer(&format!("drawn?{query}"))?;
        let head = answer.iter().position(|byte| *byte == b'\n').context("an answer without a line")?;
        Ok((serde_json::from_slice(&answer[..head])?, answer.len() - head - 1))
    }

    fn answer(&self, path: &str) -> anyhow::Result<Vec<u8>> {
        let mut answer = Vec::new();
        self.ask(path)?.read_to_end(&mut answer)?;
        let body = answer.windows(4).position(|four| four == b"\r\n\r\n").context("an answer without a body")?;
        Ok(answer.split_off(body + 4))
    }

    /// Waits until the status is as wanted; gives it.
    ///
    /// # Errors
    /// When it never is.
    pub fn wait_for(&self, wanted: impl Fn(&Value) -> bool) -> anyhow::Result<Value> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.status() {
                Ok(status) if wanted(&status) => return Ok(status),
                other => ensure!(Instant::now() < deadline, "the live view's status was last {other:?}"),
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// A client that has asked and has read nothing yet.
    ///
    /// # Errors
    /// When the page cannot be reached.
    pub fn ask(&self, path: &str) -> anyhow::Result<TcpStream> {
        let mut connection = TcpStream::connect(("127.0.0.1", self.port))?;
        connection.set_read_timeout(Some(PATIENCE))?;
        write!(connection, "GET /{path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n\r\n", self.port)?;
        Ok(connection)
    }
}

/// Resident memory of a process, MiB.
///
/// # Errors
/// When it is gone.
pub fn resident_mib(process: Pid) -> anyhow::Result<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status"))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).context("no resident memory")?;
    let kibibytes: f64 = line.trim().trim_end_matches("kB").trim().parse()?;
    Ok(kibibytes / 1024.0)
}

/// The addresses at which a process listens, as the kernel writes them: hexadecimal address and port.
///
/// # Errors
/// When it is gone.
pub fn listening_addresses(process: Pid) -> anyhow::Result<Vec<String>> {
    const LISTEN: &str = "0A";
    let sockets: Vec<String> = std::fs::read_dir(format!("/proc/{process}/fd"))?
        .flatten()
        .filter_map(|entry| std::fs::read_link(entry.path()).ok())
        .filter_map(|link| Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_owned()))
        .collect();
    let mut addresses = Vec::new();
    for table in ["tcp", "tcp6"] {
        // A kernel without IPv6 has no second table.
        let text = std::fs::read_to_string(format!("/proc/{process}/net/{table}")).unwrap_or_default();
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split_whitespace().collect();
            if let [_, local, _, LISTEN, _, _, _, _, _, inode, ..] = fields[..]
                && sockets.iter().any(|socket| socket == inode)
            {
                addresses.push(local.to_owned());
            }
        }
    }
    Ok(addresses)
}
