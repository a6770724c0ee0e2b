//! The page's server: one thread, hyper, and bounds for whatever is at the other end.
//!
//! Users other than our own ([`peer`]) are refused. A client that sends no request, or takes no answer, costs its connection
//! and nobody else's: the header of a request has a size and a deadline, the kernel ends a connection of which nothing was
//! taken for [`PATIENCE`], and when all are in use the next one takes the place of the one that was idle for longest.

use std::convert::Infallible;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::{Duration, Instant};

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONNECTION, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use parking_lot::Mutex;
use tokio::net::TcpStream;
use tokio::task::AbortHandle;

use crate::peer;

/// How long a client may take nothing of what waits for it, and how long it may take to send a request.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Connections at once; a page needs up to six.
const MOST_CONNECTIONS: usize = 64;
/// Most other users who are refused at a time.
const MOST_REFUSALS: usize = 8;
/// Size of a request's header, bytes.
const MOST_HEADER: usize = 16 << 10;
const REFUSAL: &str = "This live view belongs to another user of this machine. Start the capture as the user of this \
                       browser, or with sudo from him, or reach the page through ssh as the user who captures.\n";

/// What a client is given.
pub type Reply = Response<Full<Bytes>>;
pub type Answers = Arc<dyn Fn(&Request<Incoming>) -> Reply + Send + Sync>;

pub fn response<const N: usize>(status: StatusCode, body: Bytes, headers: [(HeaderName, &'static str); N]) -> Reply {
    let mut response = Response::new(Full::from(body));
    *response.status_mut() = status;
    response.headers_mut().extend(headers.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response
}

/// Serves everyone who connects to `listener`, on a thread of its own, as long as the process lives.
/// Fails when there is no thread or no file descriptor for it.
pub fn serve(listener: TcpListener, answers: Answers, patience: Duration) -> std::io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let inside = runtime.enter();
    let listener = tokio::net::TcpListener::from_std(listener)?;
    drop(inside);
    let accept = move || runtime.block_on(accept(listener, answers, patience));
    std::thread::Builder::new().name("page".to_owned()).spawn(accept).map(drop)
}

async fn accept(listener: tokio::net::TcpListener, answers: Answers, patience: Duration) {
    let (mut ours, mut others) = (Connections::new(), Connections::new());
    loop {
        let Ok((client, peer)) = listener.accept().await else {
            // Out of file descriptors: some may be free again soon.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let may_look = client.local_addr().is_ok_and(|here| peer::may_look(peer, here));
        let (connections, most, answers) = if may_look {
            (&mut ours, MOST_CONNECTIONS, Some(Arc::clone(&answers)))
        } else {
            (&mut others, MOST_REFUSALS, None)
        };
        make_room(connections, most);
        let asked = LastRequest::default();
        let task = tokio::spawn(attend(client, answers, asked.clone(), patience));
        connections.push((task.abort_handle(), asked));
    }
}

/// Serves one connection to its end; without `answers` whoever is there is sent away.
async fn attend(client: TcpStream, answers: Option<Answers>, asked: LastRequest, patience: Duration) {
    let socket = socket2::SockRef::from(&client);
    if socket.set_tcp_nodelay(true).and_then(|()| socket.set_tcp_user_timeout(Some(patience))).is_err() {
        return;
    }
    let refusal = || {
        let headers = [(CONTENT_TYPE, "text/plain; charset=utf-8"), (CONNECTION, "close")];
        response(StatusCode::FORBIDDEN, REFUSAL.into(), headers)
    };
    let answer = |request: Request<Incoming>| {
        *asked.lock() = Some(Instant::now());
        let answer = answers.as_ref().map_or_else(refusal, |answers| answers(&request));
        std::future::ready(Ok::<_, Infallible>(answer))
    };
    // That a browser goes away is no news.
    let _ = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(patience)
        .max_buf_size(MOST_HEADER)
        .serve_connection(TokioIo::new(client), service_fn(answer))
        .await;
}

/// When a connection sent its last request, if it has sent any.
type LastRequest = Arc<Mutex<Option<Instant>>>;

/// The open connections, in the order in which they came.
type Connections = Vec<(AbortHandle, LastRequest)>;

/// Ends connections until there are fewer than `most`: those first that never asked, then those that asked long ago.
fn make_room(open: &mut Connections, most: usize) {
    open.retain(|(task, _)| !task.is_finished());
    let asked = |(_, asked): &(_, LastRequest)| *asked.lock();
    while open.len() >= most
        && let Some(idlest) = (0..open.len()).min_by_key(|place| asked(&open[*place]))
    {
        open.remove(idlest).0.abort();
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::{Ipv4Addr, SocketAddr, TcpStream};
    use std::sync::mpsc;

    use super::*;
    use crate::wedged_page::resident_mib;

    const PATIENCE: Duration = Duration::from_millis(300);

    /// A server that answers everything with these bytes.
    fn serving(body: impl Fn() -> Bytes + Send + Sync + 'static, patience: Duration) -> SocketAddr {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        serve(listener, Arc::new(move |_: &_| Response::new(Full::from(body()))), patience).unwrap();
        address
    }

    const PAGE: fn() -> Bytes = || Bytes::from_static(b"the page");
    const LARGE: fn() -> Bytes = || Bytes::from(vec![7; 30 << 20]);
    const FOR_EVER: Duration = Duration::from_secs(3600);

    /// Sends a request, or the beginning of one.
    fn send(address: SocketAddr, request: &str) -> TcpStream {
        let mut client = TcpStream::connect(address).unwrap();
        client.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        client.write_all(request.as_bytes()).unwrap();
        client
    }

    /// Asks as a page does, and has read nothing yet.
    pub(crate) fn ask(address: SocketAddr, path: &str) -> TcpStream {
        send(address, &format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"))
    }

    fn answer(address: SocketAddr) -> String {
        let mut text = String::new();
        ask(address, "/").read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn idle_connections_never_lock_the_page_out() {
        let address = serving(PAGE, FOR_EVER);
        let many = |begun| (0..3 * MOST_CONNECTIONS).map(move |_| send(address, begun));
        let idle: Vec<_> = many("").chain(many("GET / HTTP/1.1\r\nHost: ")).collect();
        assert!(answer(address).ends_with("the page"));
        drop(idle);
    }

    #[test]
    fn an_answer_on_its_way_outlives_connections_that_ask_nothing() {
        let address = serving(LARGE, FOR_EVER);
        let mut loading = ask(address, "/");
        loading.read_exact(&mut [0; 1000]).unwrap();
        let idle: Vec<_> = (0..2 * MOST_CONNECTIONS).map(|_| send(address, "")).collect();
        let mut rest = Vec::new();
        loading.read_to_end(&mut rest).unwrap();
        assert!(rest.len() > (30 << 20) - 1000, "{} bytes", rest.len());
        drop(idle);
    }

    #[test]
    fn a_header_without_an_end_is_cut_off_and_costs_no_memory() {
        let address = serving(PAGE, FOR_EVER);
        let before = resident_mib();
        let mut client = send(address, "GET / HTTP/1.1\r\nX-Long: ");
        let portion = vec![b'x'; 1 << 20];
        let taken = (0..512).take_while(|_| client.write_all(&portion).is_ok()).count();
        assert!(taken < 64, "{taken} MiB of a header were taken");
        assert!(resident_mib() - before < 64.0, "{} MiB more", resident_mib() - before);
        assert!(answer(address).ends_with("the page"));
    }

    #[test]
    fn a_request_that_never_comes_loses_its_connection() {
        let address = serving(PAGE, PATIENCE);
        // Closed, with a word or without one.
        send(address, "GET / HT").read_to_end(&mut Vec::new()).unwrap();
    }

    #[test]
    fn whoever_takes_nothing_is_let_go_and_what_waits_for_him_is_freed() {
        let (given, is_given) = mpsc::channel();
        let body = move || {
            let body: Arc<[u8]> = vec![0; 100 << 20].into();
            given.send(Arc::downgrade(&body)).unwrap();
            Bytes::from_owner(body)
        };
        let wedged = ask(serving(body, PATIENCE), "/");
        let deadline = Instant::now() + Duration::from_secs(60);
        let body = is_given.recv_timeout(Duration::from_secs(60)).unwrap();
        while body.strong_count() > 0 {
            assert!(Instant::now() < deadline, "the answer is kept");
            std::thread::sleep(Duration::from_millis(10));
        }
        drop(wedged);
    }

    #[test]
    fn a_slow_reader_keeps_its_connection() {
        let address = serving(LARGE, PATIENCE);
        let mut client = ask(address, "/");
        let (mut portion, mut taken) = (vec![0; 3 << 20], 0);
        while let more @ 1.. = client.read(&mut portion).unwrap() {
            std::thread::sleep(Duration::from_millis(20));
            taken += more;
        }
        assert!(taken > 30 << 20, "{taken} bytes");
    }
}
