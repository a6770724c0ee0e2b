//! The web page: rerun's viewer in a frame of ours that shows large figures and fetches what was drawn.
//!
//! rerun's own server gives its stream to every user of the machine, waits for its slowest reader, and its page loses the
//! stream for good when the process dies. This page asks instead: twice a second `/status` for the figures, four times
//! a second `/drawn` for what is new. Nothing is held open for it, and when another process answers than before it
//! goes on with that one, in the same tab.

pub mod socket;

use std::borrow::Cow;
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::anyhow;
use re_web_viewer_server::WebViewerData;
use serde::Serialize;
use tiny_http::{Header, Method, Request, Response, Server};

use crate::drawing::TIMELINE;
use crate::drawn::{Drawn, Given, Standing, Wish};
use crate::glance::{Glance, SharedGlance};
use crate::guard::{Counted, MOST_CONNECTIONS};

/// What the page is told twice a second.
#[derive(Serialize)]
struct Status<'a> {
    /// Another one after each start of the viewer.
    instance: &'a str,
    /// The timeline by which the page tells how far it has come.
    timeline: &'static str,
    #[serde(flatten)]
    glance: Glance,
}

/// The first line of an answer to `/drawn`; the files follow it without a gap, which rerun reads like one.
#[derive(Serialize)]
struct DrawnHead<'a> {
    instance: &'a str,
    #[serde(flatten)]
    standing: Standing,
}

struct Pages {
    /// Whether the page is to be reached from other machines, by whatever name they know this one.
    open_to_network: bool,
    viewer: WebViewerData,
    instance: String,
    glance: SharedGlance,
    drawn: Drawn,
}

/// What the page may reach: itself. rerun's program would report its use to its maker otherwise.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
                      img-src 'self' data: blob:; worker-src 'self' blob:; frame-ancestors 'none'";

/// Serves the page at a socket in the rig's folder as long as the process lives; gives its path.
///
/// # Errors
/// When it cannot be made.
pub fn serve(open_to_network: bool, glance: SharedGlance, drawn: Drawn) -> anyhow::Result<PathBuf> {
    let path = socket::place()?;
    let server = Server::http_unix(&path).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    let instance = format!("{}-{}", std::process::id(), shared_types::rig::monotonic_time_ns());
    let viewer = WebViewerData::load(None)?;
    let pages = Arc::new(Pages { open_to_network, viewer, instance, glance, drawn });
    let answers = Arc::new(AtomicUsize::new(0));
    let answer_all = move || {
        for request in server.incoming_requests() {
            // A browser that stops halfway holds up nobody but itself, and the guard ends that.
            if answers.load(Ordering::Relaxed) >= MOST_CONNECTIONS {
                continue;
            }
            let (pages, counted) = (Arc::clone(&pages), Counted::new(&answers));
            let answer = std::thread::Builder::new().name("page".to_owned()).spawn(move || {
                // That a browser went away meanwhile is no news.
                let _ = pages.answer(request);
                drop(counted);
            });
            if let Err(error) = answer {
                tracing::error!("no thread for the web page: {error}");
            }
        }
    };
    std::thread::Builder::new().name("pages".to_owned()).spawn(answer_all)?;
    Ok(path)
}

impl Pages {
    fn answer(&self, request: Request) -> std::io::Result<()> {
        if !self.open_to_network && !is_asked_by_address(&request) {
            return request.respond(Response::empty(403));
        }
        let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
        if *request.method() != Method::Get {
            return request.respond(Response::empty(405));
        }
        let (kind, body): (&str, Cow<'_, [u8]>) = match path {
            "/" => ("text/html; charset=utf-8", include_bytes!("live-view.html").into()),
            "/live-view.css" => ("text/css", include_bytes!("live-view.css").into()),
            "/live-view.js" => ("text/javascript", include_bytes!("live-view.js").into()),
            "/re_viewer.js" => ("text/javascript", self.viewer.viewer_js().into()),
            "/re_viewer_bg.wasm" => ("application/wasm", self.viewer.viewer_wasm().into()),
            "/favicon.ico" => ("image/x-icon", self.viewer.favicon().into()),
            "/status" => ("application/json", self.status().into()),
            "/drawn" => match self.drawn.give(self.wish(query)) {
                Ok(given) => ("application/octet-stream", self.drawn_answer(&given).into()),
                Err(error) => {
                    tracing::error!("{error:#}");
                    return request.respond(Response::empty(500));
                }
            },
            _ => return request.respond(Response::empty(404)),
        };
        let length = body.len();
        let caching = if matches!(path, "/status" | "/drawn") { "no-store" } else { "no-cache" };
        let headers = [
            ("Content-Type", kind),
            ("Cache-Control", caching),
            ("X-Content-Type-Options", "nosniff"),
            ("Content-Security-Policy", POLICY),
        ];
        let headers = headers.into_iter().filter_map(|(name, value)| Header::from_bytes(name, value).ok()).collect();
        // Without a length the page could not tell how far loading is.
        let response = Response::new(tiny_http::StatusCode(200), headers, &*body, Some(length), None)
            .with_chunked_threshold(usize::MAX);
        request.respond(response)
    }

    fn status(&self) -> Vec<u8> {
        let Self { instance, glance, .. } = self;
        let status = Status { instance, timeline: TIMELINE, glance: glance.get() };
        // A struct of words and numbers always has a JSON form.
        serde_json::to_vec(&status).unwrap_or_default()
    }

    /// What `instance=I&since=N` or `instance=I&before=N` asks for. Numbers of another process mean nothing here.
    fn wish(&self, query: &str) -> Wish {
        let value = |name: &str| {
            query
                .split('&')
                .filter_map(|pair| pair.split_once('='))
                .find_map(|(key, value)| (key == name).then_some(value))
        };
        let number = |name: &str| value(name).and_then(|number| number.parse().ok());
        if value("instance") != Some(self.instance.as_str()) {
            return Wish::Beginning;
        }
        let since = number("since").map(Wish::Since);
        since.or_else(|| number("before").map(Wish::Before)).unwrap_or(Wish::Beginning)
    }

    fn drawn_answer(&self, given: &Given) -> Vec<u8> {
        let Given { standing, files } = given;
        let head = DrawnHead { instance: &self.instance, standing: *standing };
        let mut answer = serde_json::to_vec(&head).unwrap_or_default();
        answer.push(b'\n');
        files.iter().for_each(|file| answer.extend_from_slice(file));
        answer
    }
}

/// Whether the browser went to an address and not to a name: whoever owns a name can have it mean this machine, and so have
/// a page of his read this one.
fn is_asked_by_address(request: &Request) -> bool {
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    host.is_some_and(|host| {
        let host = host.value.as_str();
        let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
        name == "localhost" || name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok()
    })
}
