//! Who is at the other end of a connection within this machine.
//!
//! A port at the loopback address is open to every user of the machine; the kernel's tables of connections say whose socket
//! is at the other end.

use std::net::{IpAddr, SocketAddr};

use nix::unistd::{Uid, geteuid};

/// The kernel's word for a connection that both ends hold open.
const ESTABLISHED: &str = "01";

/// Whether what is captured may be shown at `peer`, which is connected to us at `here`.
/// From this machine: to our own user, to root, and to the user who became root by `sudo` to capture. From another one:
/// to anybody, since the page is reached from there only where the operator has bound it to a network.
pub fn may_look(peer: SocketAddr, here: SocketAddr) -> bool {
    let before_sudo = || std::env::var("SUDO_UID").ok().filter(|_| geteuid().is_root())?.parse().ok();
    match owner(peer, here) {
        Some(user) => user == geteuid() || user.is_root() || before_sudo() == Some(user.as_raw()),
        None => !peer.ip().to_canonical().is_loopback() && peer.ip() != here.ip(),
    }
}

/// Whose socket on this machine is at `peer` and connected to `here`.
fn owner(peer: SocketAddr, here: SocketAddr) -> Option<Uid> {
    // A kernel without IPv6 has no second table.
    let table = |path| std::fs::read_to_string(path).unwrap_or_default();
    owner_in(&["/proc/self/net/tcp", "/proc/self/net/tcp6"].map(table).concat(), peer, here)
}

/// The owner by a table of the form that proc_pid_net(5) gives: local address, remote address, state, …, user.
fn owner_in(table: &str, peer: SocketAddr, here: SocketAddr) -> Option<Uid> {
    // An IPv4 address is the same in its IPv6 form.
    let canonical = |address: SocketAddr| (address.ip().to_canonical(), address.port());
    let wanted = [peer, here].map(canonical);
    table.lines().find_map(|line| {
        let mut fields = line.split_whitespace().skip(1);
        let (local, remote, state) = (address(fields.next()?)?, address(fields.next()?)?, fields.next()?);
        let user = fields.nth(3)?.parse().ok()?;
        (state == ESTABLISHED && [local, remote].map(canonical) == wanted).then(|| Uid::from_raw(user))
    })
}

/// An address as the kernel writes it: hexadecimal words of the machine's byte order, a colon, the port.
fn address(text: &str) -> Option<SocketAddr> {
    let (ip, port) = text.split_once(':')?;
    let word = |digits: &[u8]| Some(u32::from_str_radix(str::from_utf8(digits).ok()?, 16).ok()?.to_ne_bytes());
    let bytes = ip.as_bytes().chunks(8).map(word).collect::<Option<Vec<_>>>()?.concat();
    let v4 = <[u8; 4]>::try_from(bytes.as_slice()).map(IpAddr::from);
    let ip = v4.or_else(|_| <[u8; 16]>::try_from(bytes).map(IpAddr::from)).ok()?;
    Some(SocketAddr::new(ip, u16::from_str_radix(port, 16).ok()?))
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener, TcpStream};

    use super::*;

    #[test]
    fn a_connection_of_ones_own_is_known_as_such() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let here = listener.local_addr().unwrap();
        let client = TcpStream::connect(here).unwrap();
        let peer = client.local_addr().unwrap();
        assert_eq!(owner(peer, here), Some(geteuid()));
        assert!(may_look(peer, here));
        drop(client);
        assert!(!may_look(peer, here), "nobody is there any more");
    }

    #[test]
    fn both_tables_are_understood_and_only_open_connections_count() {
        let peer: SocketAddr = "127.0.0.1:36618".parse().unwrap();
        let here: SocketAddr = "127.0.0.1:9090".parse().unwrap();
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n\
            \x20  0: 0100007F:8F0A 0100007F:2382 STATE 00000000:00000000 00:00000000 00000000  1001        0 20541 1\n";
        assert_eq!(owner_in(&table.replace("STATE", "01"), peer, here), Some(Uid::from_raw(1001)));
        assert_eq!(owner_in(&table.replace("STATE", "06"), peer, here), None);
        assert_eq!(owner_in(&table.replace("STATE", "01"), here, peer), None);
        let mapped = table.replace("0100007F", "0000000000000000FFFF00000100007F").replace("STATE", "01");
        assert_eq!(owner_in(&mapped, peer, here), Some(Uid::from_raw(1001)));
        assert_eq!(owner_in("", peer, here), None);
    }

    #[test]
    fn who_comes_from_elsewhere_may_look_where_the_page_is_bound_to_a_network() {
        assert!(may_look("192.0.2.1:4000".parse().unwrap(), "192.0.2.2:9090".parse().unwrap()));
        assert!(
            !may_look("192.0.2.2:1".parse().unwrap(), "192.0.2.2:2".parse().unwrap()),
            "from here, by whom is not known"
        );
    }
}
