//! The web page: rerun's viewer in a frame of ours that shows large figures and fetches what was drawn.
//!
//! rerun's own server gives its stream to every user of the machine, waits for its slowest reader, and its page loses the
//! stream for good when the process dies. This page asks instead: twice a second `/status` for the figures, and `/drawn`
//! for what is new whenever its viewer has taken in what it was given. Nothing is held open for it, and when another process
//! answers than before it goes on with that one, in the same tab.

pub mod server;

use std::net::{IpAddr, TcpListener};
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use re_web_viewer_server::WebViewerData;
use serde::Serialize;

use crate::drawing::TIMELINE;
use crate::drawn::{Answer, Contents, Drawn, FrameRange};
use crate::glance::{Glance, SharedGlance};

/// The state that the page fetches twice a second.
#[derive(Serialize)]
struct Status<'a> {
    /// Another one after each start of the viewer.
    instance: &'a str,
    /// The timeline by which the page tells how far it has come.
    timeline: &'static str,
    #[serde(flatten)]
    glance: Glance,
}

/// The first line of an answer to `/drawn`, which the rerun file follows.
#[derive(Serialize)]
struct DrawnHead<'a> {
    instance: &'a str,
    #[serde(flatten)]
    contents: &'a Contents,
}

struct Pages {
    /// Whether the page is to be reached from other machines, by whatever name they know this one.
    open_to_network: bool,
    viewer: &'static WebViewerData,
    instance: String,
    glance: SharedGlance,
    drawn: Drawn,
}

/// What the page may reach: itself. rerun's program would report its use to its maker otherwise.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
                      img-src 'self' data: blob:; worker-src 'self' blob:; frame-ancestors 'self'";

/// Serves the page as long as the process lives; a client that takes nothing for `patience` loses its connection.
///
/// # Errors
/// When rerun's program for browsers or a thread is not available.
pub fn serve(listener: TcpListener, patience: Duration, glance: SharedGlance, drawn: Drawn) -> anyhow::Result<()> {
    let open_to_network = !listener.local_addr()?.ip().is_loopback();
    let instance = format!("{}-{}", std::process::id(), shared_types::rig::monotonic_time_ns());
    // Kept for as long as the process lives, so that its 40 MB are never copied for an answer.
    let viewer = Box::leak(Box::new(WebViewerData::load(None)?));
    let pages = Pages { open_to_network, viewer, instance, glance, drawn };
    Ok(server::serve(listener, pages, patience)?)
}

impl server::Answer for Pages {
    fn answer(&self, request: &Request<Incoming>) -> Response<Full<Bytes>> {
        if !self.open_to_network && !is_asked_by_address(request) {
            return empty(StatusCode::FORBIDDEN);
        }
        if *request.method() != Method::GET {
            return empty(StatusCode::METHOD_NOT_ALLOWED);
        }
        let viewer = self.viewer;
        let fixed = |bytes: &'static [u8]| Bytes::from_static(bytes);
        let (kind, body) = match request.uri().path() {
            "/" => ("text/html; charset=utf-8", fixed(include_bytes!("live-view.html"))),
            "/live-view.css" => ("text/css", fixed(include_bytes!("live-view.css"))),
            "/live-view.js" => ("text/javascript", fixed(include_bytes!("live-view.js"))),
            "/plots" => ("text/html; charset=utf-8", fixed(include_bytes!("plots.html"))),
            "/plots.js" => ("text/javascript", fixed(include_bytes!("plots.js"))),
            "/re_viewer.js" => ("text/javascript", fixed(viewer.viewer_js())),
            "/re_viewer_bg.wasm" => ("application/wasm", fixed(viewer.viewer_wasm())),
            "/favicon.ico" => ("image/x-icon", fixed(viewer.favicon())),
            "/status" => ("application/json", self.status().into()),
            "/drawn" => match self.drawn.answer(self.wanted(request.uri().query().unwrap_or_default())) {
                Ok(answer) => ("application/octet-stream", self.with_head(&answer).into()),
                Err(error) => {
                    tracing::error!("{error:#}");
                    return empty(StatusCode::INTERNAL_SERVER_ERROR);
                }
            },
            _ => return empty(StatusCode::NOT_FOUND),
        };
        let caching = if matches!(request.uri().path(), "/status" | "/drawn") { "no-store" } else { "no-cache" };
        let headers: [(HeaderName, &'static str); 4] = [
            (header::CONTENT_TYPE, kind),
            (header::CACHE_CONTROL, caching),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (header::CONTENT_SECURITY_POLICY, POLICY),
        ];
        let mut response = Response::new(Full::from(body));
        response.headers_mut().extend(headers.map(|(name, value)| (name, HeaderValue::from_static(value))));
        response
    }
}

impl Pages {
    fn status(&self) -> Vec<u8> {
        let Self { instance, glance, .. } = self;
        let status = Status { instance, timeline: TIMELINE, glance: glance.get() };
        // A struct of words and numbers always has a JSON form.
        serde_json::to_vec(&status).unwrap_or_default()
    }

    /// What `instance=I&from=N` or `instance=I&from=N&to=M` asks for. Numbers of another process mean nothing here: who has
    /// them is given all that is new, and nothing of that process's past.
    fn wanted(&self, query: &str) -> FrameRange {
        let value = |name: &str| {
            query
                .split('&')
                .filter_map(|pair| pair.split_once('='))
                .find_map(|(key, value)| (key == name).then_some(value))
        };
        let number = |name: &str| value(name).and_then(|number| number.parse().ok());
        if value("instance") != Some(self.instance.as_str()) {
            return FrameRange { from: 0, to: value("to").map(|_| 0) };
        }
        FrameRange { from: number("from").unwrap_or(0), to: number("to") }
    }

    fn with_head(&self, Answer { contents, file }: &Answer) -> Vec<u8> {
        let mut answer = serde_json::to_vec(&DrawnHead { instance: &self.instance, contents }).unwrap_or_default();
        answer.push(b'\n');
        answer.extend_from_slice(file);
        answer
    }
}

fn empty(status: StatusCode) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::default());
    *response.status_mut() = status;
    response
}

/// Whether the browser went to an address and not to a name: whoever owns a name can have it mean this machine, and so have
/// a page of his read this one.
fn is_asked_by_address(request: &Request<Incoming>) -> bool {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    host.is_some_and(|host| {
        let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
        name == "localhost" || name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok()
    })
}
