//! Frames on an Ethernet interface: sent by one system call each, received without any.
//!
//! The kernel puts what arrives into a ring of memory that it shares with this process (packet(7), PACKET_RX_RING,
//! `Documentation/networking/packet_mmap.rst`), so that waiting for a frame is looking at a word of memory.

#![allow(unsafe_code, reason = "packet sockets and their rings have no safe interface in a crate in use here")]

use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd as _, FromRawFd as _, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};

/// EtherCAT's EtherType (ETG.1000.3, 4.1).
const ETHERTYPE: u16 = 0x88a4;
/// Size of a slot of the ring, bytes: a frame of 1514 with the kernel's header before it.
const SLOT: usize = 2048;
/// Slots, some of which an earlier tick's late frames may take.
const SLOTS: usize = 64;
/// A block of memory holds whole slots and, of whatever size, whole pages.
const BLOCK: usize = 65_536;
/// Longest frame without its checksum, bytes.
pub(super) const LONGEST: usize = 1514;

/// An interface on which EtherCAT frames go out and come back.
#[derive(Debug)]
pub(super) struct Socket {
    descriptor: OwnedFd,
    ring: NonNull<u8>,
    next: usize,
}

// SAFETY: the ring is this socket's alone, and is used through `&mut self`.
unsafe impl Send for Socket {}

impl Socket {
    /// Opens a network interface, by its name.
    ///
    /// # Errors
    /// The system's: the interface is not there, or raw sockets are not permitted.
    pub(super) fn open(interface: &str) -> io::Result<Self> {
        let name = CString::new(interface).map_err(|_| io::Error::from_raw_os_error(libc::ENODEV))?;
        // SAFETY: the name ends with a zero and lives beyond the call.
        let index = unsafe { libc::if_nametoindex(name.as_ptr()) };
        if index == 0 {
            return Err(io::Error::last_os_error());
        }
        let protocol = ETHERTYPE.to_be();
        let kind = libc::SOCK_RAW | libc::SOCK_NONBLOCK | libc::SOCK_CLOEXEC;
        // SAFETY: the call takes plain numbers.
        let descriptor = unsafe { libc::socket(libc::AF_PACKET, kind, i32::from(protocol)) };
        if descriptor < 0 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: the descriptor was just made and is nobody else's.
        let descriptor = unsafe { OwnedFd::from_raw_fd(descriptor) };
        set(&descriptor, libc::PACKET_VERSION, &(libc::tpacket_versions::TPACKET_V2 as i32))?;
        // What this socket sends is not to come back to it.
        set(&descriptor, libc::PACKET_IGNORE_OUTGOING, &1_i32)?;
        let ring = libc::tpacket_req {
            tp_block_size: BLOCK as u32,
            tp_block_nr: (SLOT * SLOTS / BLOCK) as u32,
            tp_frame_size: SLOT as u32,
            tp_frame_nr: SLOTS as u32,
        };
        set(&descriptor, libc::PACKET_RX_RING, &ring)?;
        // SAFETY: all zeros is a valid address of this kind.
        let mut address: libc::sockaddr_ll = unsafe { std::mem::zeroed() };
        address.sll_family = libc::AF_PACKET as u16;
        address.sll_protocol = protocol;
        address.sll_ifindex = index.cast_signed();
        let length = size_of::<libc::sockaddr_ll>() as libc::socklen_t;
        // SAFETY: the address is of the given length, and lives beyond the call.
        if unsafe { libc::bind(descriptor.as_raw_fd(), (&raw const address).cast(), length) } != 0 {
            return Err(io::Error::last_os_error());
        }
        let access = libc::PROT_READ | libc::PROT_WRITE;
        // SAFETY: the kernel chooses the place, and the length is that of the ring that was just asked for.
        let memory = unsafe {
            libc::mmap(std::ptr::null_mut(), SLOT * SLOTS, access, libc::MAP_SHARED, descriptor.as_raw_fd(), 0)
        };
        match NonNull::new(memory.cast()) {
            Some(ring) if memory != libc::MAP_FAILED => Ok(Self { descriptor, ring, next: 0 }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// Sends a frame: one `sendto`.
    ///
    /// # Errors
    /// The system's, also where it would have to wait.
    pub(super) fn send(&mut self, frame: &[u8]) -> io::Result<usize> {
        // SAFETY: the frame is as long as given, and lives beyond the call.
        let sent =
            unsafe { libc::send(self.descriptor.as_raw_fd(), frame.as_ptr().cast(), frame.len(), libc::MSG_DONTWAIT) };
        usize::try_from(sent).map_err(|_| io::Error::last_os_error())
    }

    /// Copies the next frame that came in to `into`, and gives its length; `None` where none has come. No system call.
    pub(super) fn receive(&mut self, into: &mut [u8; LONGEST]) -> Option<usize> {
        // SAFETY: there are `SLOTS` slots of `SLOT` bytes in the mapping, and `next` is one of them.
        let slot = unsafe { self.ring.add(self.next * SLOT) };
        // SAFETY: a slot begins with this word, which the kernel changes from another core: it is used as an atomic alone.
        let status = unsafe { slot.cast::<AtomicU32>().as_ref() };
        if status.load(Ordering::Acquire) & libc::TP_STATUS_USER == 0 {
            return None;
        }
        // SAFETY: the slot is this process's until its status is given back; a header of this version lies at its beginning.
        let header = unsafe { slot.cast::<libc::tpacket2_hdr>().read() };
        let start = usize::from(header.tp_mac).min(SLOT);
        let length = (header.tp_snaplen as usize).min(LONGEST).min(SLOT - start);
        // SAFETY: `length` bytes from `start` lie within the slot, as was just made sure of.
        let frame = unsafe { std::slice::from_raw_parts(slot.add(start).as_ptr(), length) };
        into[..length].copy_from_slice(frame);
        status.store(libc::TP_STATUS_KERNEL, Ordering::Release);
        self.next = (self.next + 1) % SLOTS;
        Some(length)
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        // SAFETY: the mapping is this socket's, of this length, and nothing refers to it any more.
        unsafe { libc::munmap(self.ring.as_ptr().cast(), SLOT * SLOTS) };
    }
}

fn set<Value>(descriptor: &OwnedFd, option: i32, value: &Value) -> io::Result<()> {
    let length = size_of::<Value>() as libc::socklen_t;
    // SAFETY: the value is of the given length, lives beyond the call, and is of the type that each option here takes.
    let code = unsafe {
        libc::setsockopt(descriptor.as_raw_fd(), libc::SOL_PACKET, option, std::ptr::from_ref(value).cast(), length)
    };
    if code == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}
