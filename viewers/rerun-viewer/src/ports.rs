//! The ports of the live view, and the same ones again after a restart.
//!
//! A page in a browser knows its address only. A viewer that was killed and started again must therefore be found
//! where it was: the first one of a run notes its ports in the rig's folder, the ones after it take those.

use std::net::{IpAddr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use serde::{Deserialize, Serialize};

/// Ports tried beyond the one asked for.
const PORTS_TRIED: u16 = 10;
/// How long a viewer that was started again waits for its ports.
const RETAKE_LIMIT: Duration = Duration::from_secs(2);

/// Port numbers of the page and of the stream that it reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ports {
    /// Of the page.
    pub web: u16,
    /// Of the stream.
    pub stream: u16,
}

/// Both ports, taken: nobody else can have them any more.
#[derive(Debug)]
pub struct Taken {
    /// Of the page.
    pub web: TcpListener,
    /// Of the stream.
    pub stream: TcpListener,
}

impl Taken {
    /// Takes the first free ports from those wanted on.
    ///
    /// # Errors
    /// When none of them can be had at that address.
    pub fn first_free(bind: IpAddr, wanted: Ports) -> anyhow::Result<Self> {
        let stream = first_free(bind, wanted.stream)?;
        Ok(Self { web: first_free(bind, wanted.web)?, stream })
    }

    /// Takes exactly these ports, which a viewer that died had a moment ago.
    fn again(bind: IpAddr, ports: Ports) -> Option<Self> {
        let deadline = Instant::now() + RETAKE_LIMIT;
        let take = |port| {
            loop {
                match TcpListener::bind(SocketAddr::new(bind, port)) {
                    Ok(listener) => return Some(listener),
                    Err(_) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(50)),
                    Err(_) => return None,
                }
            }
        };
        Some(Self { stream: take(ports.stream)?, web: take(ports.web)? })
    }

    /// Which ports they are.
    ///
    /// # Errors
    /// When the system does not tell.
    pub fn numbers(&self) -> std::io::Result<Ports> {
        Ok(Ports { web: self.web.local_addr()?.port(), stream: self.stream.local_addr()?.port() })
    }
}

/// Takes the ports for a viewer that was restarted so many times in its run.
///
/// # Errors
/// When no port is free.
pub fn take(bind: IpAddr, wanted: Ports, restarts: u32) -> anyhow::Result<Taken> {
    let noted = (restarts > 0).then(noted).flatten();
    if let Some(taken) = noted.and_then(|ports| Taken::again(bind, ports)) {
        return Ok(taken);
    }
    Taken::first_free(bind, wanted)
}

/// Notes the ports for a viewer that is started again.
///
/// # Errors
/// When the rig's folder cannot be written.
pub fn note(ports: Ports) -> anyhow::Result<()> {
    shared_types::rig::create_runtime_dir()?;
    let path = note_path();
    std::fs::write(&path, serde_json::to_vec(&ports)?).with_context(|| format!("{} cannot be written", path.display()))
}

fn noted() -> Option<Ports> {
    serde_json::from_slice(&std::fs::read(note_path()).ok()?).ok()
}

fn note_path() -> PathBuf {
    shared_types::rig::runtime_dir().join("live-view-ports.json")
}

fn first_free(bind: IpAddr, wanted: u16) -> anyhow::Result<TcpListener> {
    let mut refusal = None;
    for port in (0..PORTS_TRIED).filter_map(|further| wanted.checked_add(further)) {
        match TcpListener::bind(SocketAddr::new(bind, port)) {
            Ok(listener) => return Ok(listener),
            Err(error) => refusal = Some(error),
        }
    }
    let reason = refusal.map_or_else(String::new, |error| format!(" ({error})"));
    bail!(
        "no port from {wanted} to {} is free at {bind}{reason}; name another one",
        wanted.saturating_add(PORTS_TRIED - 1)
    )
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    #[test]
    fn a_taken_port_gives_way_to_another() {
        let holder = TcpListener::bind((LOOPBACK, 0)).unwrap();
        let port = holder.local_addr().unwrap().port();
        let found = first_free(LOOPBACK, port).unwrap();
        assert_ne!(found.local_addr().unwrap().port(), port);
    }

    #[test]
    fn page_and_stream_never_get_the_same_port() {
        let holder = TcpListener::bind((LOOPBACK, 0)).unwrap();
        let port = holder.local_addr().unwrap().port();
        drop(holder);
        let ports = Taken::first_free(LOOPBACK, Ports { web: port, stream: port }).unwrap().numbers().unwrap();
        assert_ne!(ports.web, ports.stream);
    }

    #[test]
    fn ports_that_become_free_a_moment_later_are_taken_again() {
        let taken = Taken::first_free(LOOPBACK, Ports { web: 42_000, stream: 42_010 }).unwrap();
        let ports = taken.numbers().unwrap();
        let holder = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(200));
            drop(taken);
        });
        assert_eq!(Taken::again(LOOPBACK, ports).unwrap().numbers().unwrap(), ports);
        holder.join().unwrap();
    }
}
