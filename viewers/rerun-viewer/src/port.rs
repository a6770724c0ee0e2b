//! The port of the live view, and the same one again after a restart: a page in a browser knows its address only. The first
//! viewer of a run notes its port in the rig's folder, the ones after it take that.

use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};

/// Ports tried beyond the one asked for.
const PORTS_TRIED: u16 = 10;
/// How long a viewer that was started again waits for its port.
const RETAKE_LIMIT: Duration = Duration::from_secs(2);

/// Takes the port for a viewer that was restarted so many times in its run: the one that it had, else the first that is
/// free from the wanted one on. Fails when no port is free.
pub fn take(wanted: SocketAddr, restarts: u32) -> anyhow::Result<TcpListener> {
    let noted = || serde_json::from_slice(&std::fs::read(note_path()).ok()?).ok();
    let port: Option<u16> = (restarts > 0).then(noted).flatten();
    port.and_then(|port| take_again(SocketAddr::new(wanted.ip(), port))).map_or_else(|| first_free(wanted), Ok)
}

/// Notes the port for a viewer that is started again. Fails when the rig's folder cannot be written.
pub fn note(port: u16) -> anyhow::Result<()> {
    shared_types::rig::create_runtime_dir()?;
    let path = note_path();
    std::fs::write(&path, serde_json::to_vec(&port)?).with_context(|| format!("{} cannot be written", path.display()))
}

fn note_path() -> PathBuf {
    shared_types::rig::runtime_dir().join("live-view-port.json")
}

/// Takes exactly this port, which a viewer that died had a moment ago.
fn take_again(address: SocketAddr) -> Option<TcpListener> {
    let deadline = Instant::now() + RETAKE_LIMIT;
    loop {
        match TcpListener::bind(address) {
            Ok(listener) => return Some(listener),
            Err(_) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(50)),
            Err(_) => return None,
        }
    }
}

/// Takes the first free port from the wanted one on, if one of them can be had at that address.
fn first_free(wanted: SocketAddr) -> anyhow::Result<TcpListener> {
    let (bind, first) = (wanted.ip(), wanted.port());
    let last = first.saturating_add(PORTS_TRIED - 1);
    let addresses: Vec<_> = (first..=last).map(|port| SocketAddr::new(bind, port)).collect();
    let bound = TcpListener::bind(addresses.as_slice());
    bound.map_err(|error| anyhow!("no port from {first} to {last} is free at {bind} ({error}); name another one"))
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn a_taken_port_gives_way_to_another() {
        let holder = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let taken = holder.local_addr().unwrap();
        let found = first_free(taken).unwrap();
        assert_ne!(found.local_addr().unwrap().port(), taken.port());
    }

    #[test]
    fn a_port_that_becomes_free_a_moment_later_is_taken_again() {
        let holder = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = holder.local_addr().unwrap();
        let holder = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(200));
            drop(holder);
        });
        assert_eq!(take_again(address).unwrap().local_addr().unwrap(), address);
        holder.join().unwrap();
    }
}
