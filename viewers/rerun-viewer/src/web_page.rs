//! The address of the web page, and ports that are free.

use std::fmt::Write as _;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};

use anyhow::bail;

/// Ports tried beyond the one asked for.
const PORTS_TRIED: u16 = 10;

/// The first free port from `wanted` on; `taken` is one that will be in use.
///
/// # Errors
/// When none of the ports can be had at that address.
pub fn free_port(bind: IpAddr, wanted: u16, taken: Option<u16>) -> anyhow::Result<u16> {
    let candidates = (0..PORTS_TRIED).filter_map(|further| wanted.checked_add(further));
    let mut refusal = None;
    for port in candidates.filter(|port| Some(*port) != taken) {
        // rerun's stream server only logs that its port is taken, so the port is tried here first.
        match TcpListener::bind(SocketAddr::new(bind, port)) {
            Ok(_) => return Ok(port),
            Err(error) => refusal = Some(error),
        }
    }
    let reason = refusal.map_or_else(String::new, |error| format!(" ({error})"));
    bail!(
        "no port from {wanted} to {} is free at {bind}{reason}; name another one",
        wanted.saturating_add(PORTS_TRIED - 1)
    )
}

/// What a browser on this machine is given.
pub fn address(bind: IpAddr, web_port: u16, grpc_port: u16) -> String {
    let host = if bind.is_unspecified() { IpAddr::V4(Ipv4Addr::LOCALHOST) } else { bind };
    let stream = format!("rerun+http://{}/proxy", SocketAddr::new(host, grpc_port));
    format!("http://{}/?url={}&hide_welcome_screen", SocketAddr::new(host, web_port), percent_encoded(&stream))
}

/// RFC 3986: everything but unreserved characters as `%XX`.
fn percent_encoded(text: &str) -> String {
    let mut encoded = String::new();
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            encoded.push(char::from(byte));
        } else {
            let _ = write!(encoded, "%{byte:02X}");
        }
    }
    encoded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_address_names_page_and_stream() {
        assert_eq!(
            address(Ipv4Addr::LOCALHOST.into(), 9090, 9876),
            "http://127.0.0.1:9090/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A9876%2Fproxy&hide_welcome_screen"
        );
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn a_taken_port_gives_way_to_another() {
        let holder = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let taken = holder.local_addr().unwrap().port();
        let found = free_port(Ipv4Addr::LOCALHOST.into(), taken, None);
        assert!(found.is_ok_and(|port| port != taken));
    }
}
