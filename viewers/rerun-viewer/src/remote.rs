//! Seeing the page from another machine. The page has no log-in of its own, so ssh carries its port.

/// User and host by which this machine is reached, as `user@host`: the address of the ssh connection, or else the machine's name. `USER` and
/// `HOST` stand for what is unknown.
pub fn login() -> String {
    let user = ["USER", "LOGNAME"].into_iter().find_map(|variable| std::env::var(variable).ok());
    // "client address, client port, server address, server port"
    let came_by = std::env::var("SSH_CONNECTION").ok();
    let address = came_by.and_then(|came_by| Some(came_by.split_whitespace().nth(2)?.to_owned()));
    let name = || std::fs::read_to_string("/proc/sys/kernel/hostname").ok().map(|name| name.trim().to_owned());
    let host = address.or_else(name).filter(|host| !host.is_empty());
    format!("{}@{}", user.as_deref().unwrap_or("USER"), host.as_deref().unwrap_or("HOST"))
}

/// The command that brings the page's port to the machine on which it is run.
pub fn tunnel(port: u16, login: &str) -> String {
    format!("ssh -N -L 127.0.0.1:{port}:127.0.0.1:{port} {login}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_port_is_carried_between_loopback_addresses() {
        assert_eq!(tunnel(9091, "ada@bench"), "ssh -N -L 127.0.0.1:9091:127.0.0.1:9091 ada@bench");
    }
}
