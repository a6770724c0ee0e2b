//! The web page: rerun's viewer in a frame of ours that shows large figures and heals its connection.
//!
//! rerun's own page loses its stream for good when the viewer's process dies, and its server hands out one file at a
//! time, so that a browser which stops halfway through the 40 MB of the viewer keeps every other from loading it.
//! This page asks `/status` twice a second: when another process answers than before, or when the stream stands
//! still while the run goes on, it loads itself again, in the same tab.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context as _, anyhow};
use re_web_viewer_server::WebViewerData;
use serde::Serialize;
use tiny_http::{Header, Method, Request, Response, Server};

use crate::drawing::TIMELINE;
use crate::glance::{Glance, SharedGlance};

/// Answers that may be on their way at once; the largest is the viewer's program of 40 MB.
const MOST_ANSWERS: usize = 32;

/// What the page is told twice a second.
#[derive(Serialize)]
struct Status<'a> {
    /// Another one after each start of the viewer.
    instance: &'a str,
    /// Where the stream is to be had, on the host that the page comes from.
    stream_port: u16,
    /// The timeline by which the page tells whether the stream goes on.
    timeline: &'static str,
    #[serde(flatten)]
    glance: Glance,
}

struct Pages {
    viewer: WebViewerData,
    instance: String,
    stream_port: u16,
    glance: SharedGlance,
    answers: AtomicUsize,
}

/// Serves the page at a port of this machine's loopback address as long as the process lives; gives that address.
///
/// # Errors
/// When no port is to be had.
pub fn serve(stream_port: u16, glance: SharedGlance) -> anyhow::Result<SocketAddr> {
    let server = Server::http((Ipv4Addr::LOCALHOST, 0)).map_err(|error| anyhow!("{error}"))?;
    let address = server.server_addr().to_ip().context("the page's server has no address")?;
    let instance = format!("{}-{}", std::process::id(), shared_types::rig::monotonic_time_ns());
    let viewer = WebViewerData::load(None)?;
    let pages = Arc::new(Pages { viewer, instance, stream_port, glance, answers: AtomicUsize::new(0) });
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
        let path = request.url().split('?').next().unwrap_or_default().to_owned();
        if *request.method() != Method::Get {
            return request.respond(Response::empty(405));
        }
        let (kind, body): (&str, std::borrow::Cow<'_, [u8]>) = match path.as_str() {
            "/" => ("text/html; charset=utf-8", include_bytes!("live-view.html").into()),
            "/live-view.css" => ("text/css", include_bytes!("live-view.css").into()),
            "/live-view.js" => ("text/javascript", include_bytes!("live-view.js").into()),
            "/re_viewer.js" => ("text/javascript", self.viewer.viewer_js().into()),
            "/re_viewer_bg.wasm" => ("application/wasm", self.viewer.viewer_wasm().into()),
            "/favicon.ico" => ("image/x-icon", self.viewer.favicon().into()),
            "/status" => ("application/json", self.status().into()),
            _ => return request.respond(Response::empty(404)),
        };
        let length = body.len();
        let caching = if kind == "application/json" { "no-store" } else { "no-cache" };
        let policy = self.policy();
        let headers = [
            ("Content-Type", kind),
            ("Cache-Control", caching),
            ("X-Content-Type-Options", "nosniff"),
            ("Content-Security-Policy", policy.as_str()),
        ];
        let headers = headers.into_iter().filter_map(|(name, value)| Header::from_bytes(name, value).ok()).collect();
        // Without a length the page could not tell how far loading is.
        let response = Response::new(tiny_http::StatusCode(200), headers, &*body, Some(length), None)
            .with_chunked_threshold(usize::MAX);
        request.respond(response)
    }

    /// What the page may reach: itself and the stream. rerun's program would report its use to its maker otherwise.
    fn policy(&self) -> String {
        format!(
            "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
             img-src 'self' data: blob:; worker-src 'self' blob:; connect-src 'self' http://*:{}; frame-ancestors 'none'",
            self.stream_port
        )
    }

    fn status(&self) -> Vec<u8> {
        let Self { instance, stream_port, glance, .. } = self;
        let status = Status { instance, stream_port: *stream_port, timeline: TIMELINE, glance: glance.get() };
        // A struct of words and numbers always has a JSON form.
        serde_json::to_vec(&status).unwrap_or_default()
    }
}
