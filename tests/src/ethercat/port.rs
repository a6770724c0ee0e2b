//! An Ethernet interface that EtherCAT frames come in by and go out of.
#![allow(unsafe_code, reason = "packet sockets have no safe interface in a crate in use here")]

use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd as _, FromRawFd as _, OwnedFd};

use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};

/// Asks when the frame that was read last came in, by the system clock (socket(7)); the first time, that frames be stamped from now on.
const SIOCGSTAMPNS: libc::Ioctl = 0x8907;
/// A process that reads a frame this much later was stopped, and its devices with it, ns.
const STOPPED_NS: u64 = 10_000_000;

/// A socket on the interface.
#[derive(Debug)]
pub struct Port(OwnedFd);

impl Port {
    /// Opens the interface of that name.
    ///
    /// # Errors
    /// The system's.
    pub fn open(interface: &str) -> io::Result<Self> {
        let name = CString::new(interface)?;
        let protocol = 0x88a4_u16.to_be();
        // SAFETY: the name ends with a zero; the other calls take plain numbers and structs that live beyond them.
        unsafe {
            let index = libc::if_nametoindex(name.as_ptr());
            let descriptor = libc::socket(libc::AF_PACKET, libc::SOCK_RAW | libc::SOCK_CLOEXEC, i32::from(protocol));
            if index == 0 || descriptor < 0 {
                return Err(io::Error::last_os_error());
            }
            let port = Self(OwnedFd::from_raw_fd(descriptor));
            let mut address: libc::sockaddr_ll = std::mem::zeroed();
            address.sll_family = libc::AF_PACKET as u16;
            address.sll_protocol = protocol;
            address.sll_ifindex = index.cast_signed();
            let on = 1_i32;
            let length = size_of::<libc::sockaddr_ll>() as u32;
            let ignored = libc::setsockopt(
                descriptor,
                libc::SOL_PACKET,
                libc::PACKET_IGNORE_OUTGOING,
                (&raw const on).cast(),
                size_of::<i32>() as u32,
            );
            if ignored != 0 || libc::bind(descriptor, (&raw const address).cast(), length) != 0 {
                return Err(io::Error::last_os_error());
            }
            port.age_ns();
            Ok(port)
        }
    }

    /// Waits for a frame, up to a millisecond; its length and when it came in (CLOCK_MONOTONIC, ns), or `None`.
    ///
    /// A device has a frame when it is on the wire, which is sooner than a process is woken for it.
    pub fn receive(&self, frame: &mut [u8; 1514]) -> Option<(usize, u64)> {
        let mut entry = libc::pollfd { fd: self.0.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        // SAFETY: one live entry, and a buffer of the length told.
        let received = unsafe {
            if libc::poll(&raw mut entry, 1, 1) <= 0 {
                return None;
            }
            libc::recv(self.0.as_raw_fd(), frame.as_mut_ptr().cast(), frame.len(), libc::MSG_DONTWAIT)
        };
        let length = usize::try_from(received).ok()?;
        Some((length, monotonic_time_ns().saturating_sub(self.age_ns())))
    }

    /// How long ago the frame that was read last came in, ns; 0 if the kernel does not say, or after a stop of this process.
    fn age_ns(&self) -> u64 {
        let mut stamp = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: the request writes one struct, which lives beyond the call.
        let is_stamped = unsafe { libc::ioctl(self.0.as_raw_fd(), SIOCGSTAMPNS, &raw mut stamp) } == 0;
        let stamp_ns = (stamp.tv_sec * 1_000_000_000 + stamp.tv_nsec).cast_unsigned();
        let age_ns = wall_clock_time_ns().saturating_sub(stamp_ns);
        if is_stamped && age_ns < STOPPED_NS { age_ns } else { 0 }
    }

    /// Sends a frame; one that cannot be sent is lost, as on a cable.
    pub fn send(&self, frame: &[u8]) {
        // SAFETY: a buffer of the length told.
        unsafe { libc::send(self.0.as_raw_fd(), frame.as_ptr().cast(), frame.len(), libc::MSG_DONTWAIT) };
    }

    /// Reads a register of the first device on the wire, as another master would; `None` where nothing answers for a second.
    #[must_use]
    pub fn read_register(&self, address: u16) -> Option<u16> {
        let mut frame = [0_u8; 60];
        frame[..6].fill(0xff);
        frame[6..12].copy_from_slice(&[0x02, 0, 0, 0, 0, 0x77]);
        frame[12..16].copy_from_slice(&[0x88, 0xa4, 14, 0x10]);
        // APRD of two bytes at position 0.
        frame[16..28].copy_from_slice(&[1, 0x77, 0, 0, address as u8, (address >> 8) as u8, 2, 0, 0, 0, 0, 0]);
        let mut answer = [0; 1514];
        for _ in 0..20 {
            self.send(&frame);
            for _ in 0..50 {
                if self.receive(&mut answer).is_some_and(|(length, _)| length >= 30) && answer[16..18] == [1, 0x77] {
                    return (answer[28] == 1).then(|| u16::from_le_bytes([answer[26], answer[27]]));
                }
            }
        }
        None
    }
}
