//! The web page: rerun's viewer in a frame of ours that shows large figures and fetches what was drawn.
//!
//! rerun's own server gives its stream to every user of the machine, waits for its slowest reader, and its page loses the
//! stream for good when the process dies. This page asks instead: twice a second `/status` for the figures, and `/drawn`
//! for new frames once its viewer has taken in the last ones. No connection stays open.

pub mod server;

use std::net::{IpAddr, TcpListener};
use std::sync::Arc;

use hyper::body::{Bytes, Incoming};
use hyper::header;
use hyper::{Method, Request, StatusCode};
use re_web_viewer_server::WebViewerData;

use crate::drawing::TIMELINE;
use crate::drawn::Drawn;
use crate::glance::SharedGlance;
use crate::page::server::Reply;

struct Pages {
    /// Whether the page is to be reached from other machines, by whatever name they know this one.
    open_to_network: bool,
    viewer: &'static WebViewerData,
    /// Another one after each start of the viewer.
    instance: String,
    glance: SharedGlance,
    drawn: Drawn,
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript";
/// What the page may reach: itself. rerun's program would report its use to its maker otherwise.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
                      img-src 'self' data: blob:; worker-src 'self' blob:; frame-ancestors 'self'";

/// Serves the page as long as the process lives. Fails when rerun's program for browsers or a thread is not available.
pub fn serve(listener: TcpListener, glance: SharedGlance, drawn: Drawn) -> anyhow::Result<()> {
    let open_to_network = !listener.local_addr()?.ip().is_loopback();
    let instance = format!("{}-{}", std::process::id(), shared_types::rig::monotonic_time_ns());
    // Kept for as long as the process lives, so that its 40 MB are never copied for an answer.
    let viewer = Box::leak(Box::new(WebViewerData::load(None)?));
    let pages = Pages { open_to_network, viewer, instance, glance, drawn };
    Ok(server::serve(listener, Arc::new(move |request: &_| pages.answer(request)), server::PATIENCE)?)
}

impl Pages {
    fn answer(&self, request: &Request<Incoming>) -> Reply {
        if !self.open_to_network && !is_asked_by_address(request) {
            return empty(StatusCode::FORBIDDEN);
        }
        if *request.method() != Method::GET {
            return empty(StatusCode::METHOD_NOT_ALLOWED);
        }
        let viewer = self.viewer;
        let (kind, body): (_, Bytes) = match request.uri().path() {
            "/" => (HTML, include_str!("live-view.html").into()),
            "/live-view.css" => ("text/css", include_str!("live-view.css").into()),
            "/live-view.js" => (SCRIPT, include_str!("live-view.js").into()),
            "/plots" => (HTML, include_str!("plots.html").into()),
            "/plots.js" => (SCRIPT, include_str!("plots.js").into()),
            "/re_viewer.js" => (SCRIPT, viewer.viewer_js().into()),
            "/re_viewer_bg.wasm" => ("application/wasm", viewer.viewer_wasm().into()),
            "/favicon.ico" => ("image/x-icon", viewer.favicon().into()),
            "/status" => ("application/json", self.status().into()),
            "/drawn" => match self.drawn(request.uri().query().unwrap_or_default()) {
                Ok(answer) => ("application/octet-stream", answer.into()),
                Err(error) => {
                    tracing::error!("{error:#}");
                    return empty(StatusCode::INTERNAL_SERVER_ERROR);
                }
            },
            _ => return empty(StatusCode::NOT_FOUND),
        };
        let caching = if matches!(request.uri().path(), "/status" | "/drawn") { "no-store" } else { "no-cache" };
        let headers = [
            (header::CONTENT_TYPE, kind),
            (header::CACHE_CONTROL, caching),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (header::CONTENT_SECURITY_POLICY, POLICY),
        ];
        server::response(StatusCode::OK, body, headers)
    }

    /// The figures, with the identity of this process, and the timeline by which the page tells how far it has come.
    fn status(&self) -> String {
        let mut status = self.glance.lock().clone();
        status["instance"] = self.instance.as_str().into();
        status["timeline"] = TIMELINE.into();
        status.to_string()
    }

    /// The answer to `instance=I&from=N` or `instance=I&from=N&to=M`: a line of JSON on the contents of a rerun file, then that file.
    /// Frame numbers of another process mean nothing here: a page that has them gets everything that is new, but nothing for a
    /// request with `to`, which asks for that process's past.
    fn drawn(&self, query: &str) -> anyhow::Result<Vec<u8>> {
        let value = |name: &str| query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='));
        let number = |name: &str| value(name).and_then(|number| number.parse().ok());
        let (from, to) = if value("instance") == Some(&self.instance) {
            (number("from").unwrap_or(0), number("to"))
        } else {
            (0, value("to").map(|_| 0))
        };
        let (contents, file) = self.drawn.answer(from, to)?;
        let mut head = serde_json::to_value(contents)?;
        head["instance"] = self.instance.as_str().into();
        let mut answer = format!("{head}\n").into_bytes();
        answer.extend(file);
        Ok(answer)
    }
}

fn empty(status: StatusCode) -> Reply {
    server::response(status, Bytes::new(), [])
}

/// Whether the browser asked for an address and not for a name: the owner of a name can point it at this machine, and so let a
/// page of his read this one.
fn is_asked_by_address(request: &Request<Incoming>) -> bool {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    host.is_some_and(|host| {
        let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
        name == "localhost" || name.trim_matches(['[', ']']).parse::<IpAddr>().is_ok()
    })
}
