//! Stands between browsers and the page's server: sends others away and lets go of whoever takes nothing.
//!
//! The page shows what is captured to our own user only ([`peer`]). And its server waits for its readers: one
//! that stops reading (a browser that the system has suspended, a connection that is open and forgotten) would keep
//! an answer for good, and enough of them the page from everyone. So browsers are connected to this forwarder
//! instead. Whoever has not taken a single byte for [`PATIENCE`] while something waits for him loses his connection and
//! nobody else does; his page asks again when it wakes up.
//!
//! Only this is reached from outside; the server inside listens at a socket in the rig's folder, which others may not enter.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use crate::peer;

/// How long a client may take nothing.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Connections at once; a page needs up to three.
pub const MOST_CONNECTIONS: usize = 64;
/// Other users who are told at once that this is not theirs; more are cut off without a word.
const MOST_REFUSALS: usize = 8;
/// What is carried at once, bytes.
const PORTION: usize = 64 << 10;

/// What another user is told.
const REFUSAL: &str = "HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: close\r\n\r\n\
    This live view belongs to another user of this machine. Start the capture as the user of this browser, or with sudo \
    from him, or reach the page through ssh as the user who captures.\n";

/// Forwards every connection that `listener` accepts to `inside`, as long as the process lives.
///
/// # Errors
/// When no thread is to be had.
pub fn forward(listener: TcpListener, inside: PathBuf, patience: Duration) -> io::Result<()> {
    let open = Arc::new(AtomicUsize::new(0));
    let refused = Arc::new(AtomicUsize::new(0));
    let accept = move || {
        for client in listener.incoming() {
            let Ok(client) = client else {
                // Out of file descriptors: some may be free again soon.
                std::thread::sleep(Duration::from_millis(100));
                continue;
            };
            let ours = is_ours(&client);
            let (alike, most) = if ours { (&open, MOST_CONNECTIONS) } else { (&refused, MOST_REFUSALS) };
            if alike.load(Ordering::Relaxed) >= most {
                continue;
            }
            let counted = Counted::new(alike);
            let served =
                if ours { carry(client, &inside, patience, counted) } else { refuse(client, patience, counted) };
            if let Err(error) = served {
                tracing::debug!("a connection could not be served: {error}");
            }
        }
    };
    std::thread::Builder::new().name("guard".to_owned()).spawn(accept).map(drop)
}

/// Whether what is captured may be shown at the other end.
fn is_ours(client: &TcpStream) -> bool {
    matches!((client.peer_addr(), client.local_addr()), (Ok(peer), Ok(here)) if peer::may_look(peer, here))
}

/// Tells another user why nothing is shown, on a thread of its own.
fn refuse(mut client: TcpStream, patience: Duration, counted: Counted) -> io::Result<()> {
    client.set_read_timeout(Some(patience))?;
    client.set_write_timeout(Some(patience))?;
    let tell = move || {
        // An answer before the question would be lost with the connection.
        let _ = client.read(&mut [0; 4096]).and_then(|_| client.write_all(REFUSAL.as_bytes()));
        drop(counted);
    };
    std::thread::Builder::new().name("refusal".to_owned()).spawn(tell).map(drop)
}

/// Carries one connection both ways, each on a thread of its own.
fn carry(client: TcpStream, inside: &Path, patience: Duration, counted: Counted) -> io::Result<()> {
    let server = UnixStream::connect(inside)?;
    client.set_nodelay(true)?;
    client.set_write_timeout(Some(patience))?;
    server.set_write_timeout(Some(patience))?;
    let ends = Arc::new((client, server, counted));
    for (name, pass) in [("guard up", up as fn(&Ends) -> io::Result<()>), ("guard down", down)] {
        let ends = Arc::clone(&ends);
        std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            // However it ends, the other end is to know: neither a browser nor the server goes on with half a connection.
            let _ = pass(&ends);
            let (client, server, _) = &*ends;
            let _ = client.shutdown(Shutdown::Both);
            let _ = server.shutdown(Shutdown::Both);
        })?;
    }
    Ok(())
}

/// Browser and server of one connection.
type Ends = (TcpStream, UnixStream, Counted);

fn up((client, server, _): &Ends) -> io::Result<()> {
    pass(client, server)
}

fn down((client, server, _): &Ends) -> io::Result<()> {
    pass(server, client)
}

/// Passes on what comes until either end closes or takes nothing for too long.
fn pass(mut from: impl Read, mut to: impl Write) -> io::Result<()> {
    let mut portion = vec![0; PORTION];
    loop {
        match from.read(&mut portion)? {
            0 => return Ok(()),
            taken => to.write_all(&portion[..taken])?,
        }
    }
}

/// One of several things of which there may be so many at once, counted as long as it lives.
pub(crate) struct Counted(Arc<AtomicUsize>);

impl Counted {
    pub(crate) fn new(open: &Arc<AtomicUsize>) -> Self {
        open.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(open))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use std::net::{Ipv4Addr, SocketAddr};
    use std::os::unix::net::UnixListener;
    use std::sync::mpsc;

    use super::*;

    /// A guard before a server that answers each connection with `answer`, which gets the server's end.
    fn guarded(answer: impl Fn(UnixStream) + Send + 'static) -> SocketAddr {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("inside");
        let server = UnixListener::bind(&inside).unwrap();
        std::thread::spawn(move || {
            let _folder = folder;
            server.incoming().for_each(|stream| answer(stream.unwrap()));
        });
        let outside = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = outside.local_addr().unwrap();
        forward(outside, inside, Duration::from_millis(200)).unwrap();
        address
    }

    #[test]
    fn what_is_asked_and_answered_passes_unchanged() {
        let address = guarded(|mut server| {
            let mut asked = [0; 4];
            server.read_exact(&mut asked).unwrap();
            asked.reverse();
            server.write_all(&asked.repeat(100_000)).unwrap();
        });
        let mut client = TcpStream::connect(address).unwrap();
        client.write_all(b"knob").unwrap();
        let mut answer = Vec::new();
        client.read_to_end(&mut answer).unwrap();
        assert_eq!(answer, b"bonk".repeat(100_000));
    }

    #[test]
    fn whoever_takes_nothing_is_let_go_and_the_server_is_free_again() {
        let (told, heard) = mpsc::channel();
        let address = guarded(move |mut server| {
            // More than the system's buffers hold; ends when the guard closes the connection.
            let refused = (0..10_000).any(|_| server.write_all(&[0; 1 << 16]).is_err());
            told.send(refused).unwrap();
        });
        let wedged = TcpStream::connect(address).unwrap();
        assert_eq!(heard.recv_timeout(Duration::from_secs(60)), Ok(true));
        drop(wedged);
    }

    #[test]
    fn a_slow_reader_keeps_its_connection() {
        let address = guarded(|mut server| server.write_all(&[7; 30 << 20]).unwrap());
        let mut client = TcpStream::connect(address).unwrap();
        let (mut portion, mut taken) = (vec![0; 3 << 20], 0);
        loop {
            std::thread::sleep(Duration::from_millis(20));
            match client.read(&mut portion).unwrap() {
                0 => break,
                more => taken += more,
            }
        }
        assert_eq!(taken, 30 << 20);
    }
}
