//! Seeing the page from another machine.
//!
//! The page asks nobody from another machine who he is, so it is not opened to a network. ssh carries its port instead:
//! it knows who may log in, and encrypts.

/// How this machine is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Host {
    /// Who logs in.
    pub user: String,
    /// Name or address.
    pub name: String,
}

impl Host {
    /// As whoever is logged in came here, or else by the machine's name; what is unknown is left to fill in.
    pub fn of_this_machine() -> Self {
        let user = ["USER", "LOGNAME"].into_iter().find_map(|variable| std::env::var(variable).ok());
        // "client address, client port, server address, server port"
        let came_by = std::env::var("SSH_CONNECTION").ok();
        let address = came_by.and_then(|came_by| Some(came_by.split_whitespace().nth(2)?.to_owned()));
        let name = || std::fs::read_to_string("/proc/sys/kernel/hostname").ok().map(|name| name.trim().to_owned());
        Self {
            user: user.unwrap_or_else(|| "USER".to_owned()),
            name: address.or_else(name).filter(|name| !name.is_empty()).unwrap_or_else(|| "HOST".to_owned()),
        }
    }
}

/// The command that brings the page's port to the machine on which it is run.
pub fn tunnel(port: u16, host: &Host) -> String {
    let Host { user, name } = host;
    format!("ssh -N -L 127.0.0.1:{port}:127.0.0.1:{port} {user}@{name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_port_is_carried_between_loopback_addresses() {
        let host = Host { user: "ada".to_owned(), name: "bench".to_owned() };
        assert_eq!(tunnel(9091, &host), "ssh -N -L 127.0.0.1:9091:127.0.0.1:9091 ada@bench");
    }
}
