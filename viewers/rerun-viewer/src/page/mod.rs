//! The web page: rerun's viewer in a frame of ours that shows large figures and fetches what was drawn.
//!
//! rerun's own server gives its stream to every user of the machine, waits for its slowest reader, and its page loses the
//! stream for good when the process dies. This page asks instead: twice a second `/status` for the figures, four times
//! a second `/drawn` for what is new. Nothing is held open for it, and when another process answers than before it
//! goes on with that one, in the same tab.

use std::borrow::Cow;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context as _, anyhow};
use re_web_viewer_server::WebViewerData;
use serde::Serialize;
use tiny_http::{Header, Method, Request, Response, Server};

use crate::drawing::TIMELINE;
use crate::drawn::{Drawn, Given, Standing, Wish};
use crate::glance::{Glance, SharedGlance};
use crate::peer;

/// Answers that may be on their way at once; the largest is the viewer's program of 40 MB.
const MOST_ANSWERS: usize = 32;

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
    here: SocketAddr,
    viewer: WebViewerData,
    instance: String,
    glance: SharedGlance,
    drawn: Drawn,
    answers: AtomicUsize,
}

/// What the page may reach: itself. rerun's program would report its use to its maker otherwise.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
                      img-src 'self' data: blob:; worker-src 'self' blob:; frame-ancestors 'none'";

/// Serves the page at a port of this machine's loopback address as long as the process lives; gives that address.
///
/// # Errors
/// When no port is to be had.
pub fn serve(glance: SharedGlance, drawn: Drawn) -> anyhow::Result<SocketAddr> {
    let server = Server::http((Ipv4Addr::LOCALHOST, 0)).map_err(|error| anyhow!("{error}"))?;
    let address = server.server_addr().to_ip().context("the page's server has no address")?;
    let instance = format!("{}-{}", std::process::id(), shared_types::rig::monotonic_time_ns());
    let viewer = WebViewerData::load(None)?;
    let pages = Arc::new(Pages { here: address, viewer, instance, glance, drawn, answers: AtomicUsize::new(0) });
    let answer_all = move || {
        for request in server.incoming_requests() {
            let pages = Arc::clone(&pages);
            if pages.answers.fetch_add(1, Ordering::Relaxed) >= MOST_ANSWERS {
                pages.answers.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            // A browser that stops halfway holds up nobody but itself, and the guard ends that.
            let answer = std::thread::Builder::new().name("page".to_owned()).spawn(move || {
                // That a browser went away meanwhile is no news.
                let _ = pages.answer(request);
                pages.answers.fetch_sub(1, Ordering::Relaxed);
            });
            if let Err(error) = answer {
                tracing::error!("no thread for the web page: {error}");
            }
        }
    };
    std::thread::Builder::new().name("pages".to_owned()).spawn(answer_all)?;
    Ok(address)
}

impl Pages {
    fn answer(&self, request: Request) -> std::io::Result<()> {
        // Others of this machine may find this port, too; the guard before it connects as our own user.
        if !request.remote_addr().is_some_and(|peer| peer::may_look(*peer, self.here)) {
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
