//! What a network interface is, and what of its settings delays frames (netdevice(7), ethtool(8)).

#![allow(unsafe_code, reason = "requests about interfaces have no safe interface in a crate in use here")]

use std::net::{Ipv4Addr, UdpSocket};
use std::os::fd::AsRawFd as _;

use super::socket::Socket;

/// `struct ethtool_coalesce` (linux/ethtool.h): the command, then 22 numbers.
type Coalescing = [u32; 23];
const GET_COALESCING: u32 = 0x0e;
const RECEIVE_US: usize = 1;
const SEND_US: usize = 5;

/// Asks the kernel about an interface; `None` where it does not answer.
fn ask(interface: &str, about: libc::Ioctl, data: Option<&mut Coalescing>) -> Option<libc::ifreq> {
    // SAFETY: all zeros is a valid request.
    let mut request: libc::ifreq = unsafe { std::mem::zeroed() };
    if interface.is_empty() || interface.len() >= request.ifr_name.len() {
        return None;
    }
    for (place, byte) in request.ifr_name.iter_mut().zip(interface.bytes()) {
        *place = byte.cast_signed();
    }
    if let Some(data) = data {
        request.ifr_ifru.ifru_data = data.as_mut_ptr().cast();
    }
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    // SAFETY: the kernel fills a live request of the type that these calls are defined with, and data that outlive it.
    let code = unsafe { libc::ioctl(socket.as_raw_fd(), about, &raw mut request) };
    (code == 0).then_some(request)
}

/// Whether this machine has an Ethernet interface of that name.
pub(super) fn is_ethernet(interface: &str) -> bool {
    // SAFETY: after this call it is the address that the union holds.
    ask(interface, libc::SIOCGIFHWADDR, None)
        .is_some_and(|request| unsafe { request.ifr_ifru.ifru_hwaddr.sa_family } == libc::ARPHRD_ETHER)
}

/// What on this machine stands in the way of frames on an interface, in sentences that say what to do.
pub(super) fn obstacles(interface: &str) -> Vec<String> {
    let mut found = Vec::new();
    // SAFETY: after this call it is the flags that the union holds.
    let flags =
        ask(interface, libc::SIOCGIFFLAGS, None).map(|request| i32::from(unsafe { request.ifr_ifru.ifru_flags }));
    match flags {
        None => found.push(format!("there is no interface {interface}; `ip link` lists those that there are")),
        Some(flags) if flags & libc::IFF_UP == 0 => {
            found.push(format!("{interface} is down; `ip link set {interface} up`"));
        }
        Some(flags) if flags & libc::IFF_RUNNING == 0 => {
            found.push(format!("{interface} has no link; check its cable"));
        }
        Some(_) => {}
    }
    if let Err(error) = Socket::open(interface)
        && matches!(error.raw_os_error(), Some(libc::EPERM | libc::EACCES))
    {
        found.push(format!("raw frames are not permitted ({error}); run as root, or give rt-loop cap_net_raw"));
    }
    let mut coalescing: Coalescing = [0; 23];
    coalescing[0] = GET_COALESCING;
    if ask(interface, libc::SIOCETHTOOL, Some(&mut coalescing)).is_some()
        && (coalescing[RECEIVE_US] > 0 || coalescing[SEND_US] > 0)
    {
        let (receive_us, send_us) = (coalescing[RECEIVE_US], coalescing[SEND_US]);
        found.push(format!(
            "{interface} keeps frames back for up to {receive_us} µs as they come and {send_us} µs as they go; `ethtool -C \
             {interface} rx-usecs 0 tx-usecs 0`"
        ));
    }
    if std::fs::OpenOptions::new().write(true).open("/dev/cpu_dma_latency").is_err() {
        found.push("processors may sleep deeply between frames; permit writing to /dev/cpu_dma_latency".to_owned());
    }
    found
}
