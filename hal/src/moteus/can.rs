//! SocketCAN: CAN FD frames over a raw socket.
//!
//! <https://docs.kernel.org/networking/can.html>

#![allow(unsafe_code, reason = "a CAN address is none that the standard library knows")]

use std::fs::File;
use std::io;
use std::mem::{size_of, size_of_val};
use std::os::fd::{AsRawFd as _, OwnedFd};

use moteus_protocol::CanFdFrame;
use socket2::{Domain, Protocol, SockAddr, Socket, Type};

/// Bytes of the kernel's `struct canfd_frame`: identifier, length, flags, two reserved, data.
pub(super) const WIRE_BYTES: usize = 72;
/// The second half of the frame goes at the faster bit rate.
const BIT_RATE_SWITCH: u8 = 0x01;
/// Identifiers beyond 11 bits are extended ones.
const LONGEST_STANDARD_ID: u32 = 0x7ff;

/// Whether this is the name of a CAN interface of this machine.
pub(super) fn is_interface(name: &str) -> bool {
    /// ARPHRD_CAN of `linux/if_arp.h`.
    const TYPE: &str = "280";
    !name.contains('/') && interface(name, "type").is_some_and(|found| found == TYPE)
}

fn interface(name: &str, attribute: &str) -> Option<String> {
    let text = std::fs::read_to_string(format!("/sys/class/net/{name}/{attribute}")).ok()?;
    Some(text.trim().to_owned())
}

/// Opens a socket on a CAN interface that hears the controller `id` alone, or every one, and never waits.
pub(super) fn open(name: &str, id: Option<i8>) -> io::Result<File> {
    let index = interface(name, "ifindex").and_then(|text| text.parse().ok());
    let index: i32 = index.ok_or(io::ErrorKind::NotFound)?;
    let socket = Socket::new(Domain::from(libc::AF_CAN), Type::RAW, Some(Protocol::from(libc::CAN_RAW)))?;
    set_option(&socket, libc::CAN_RAW_FD_FRAMES, &1_i32)?;
    if let Some(id) = id {
        // Bits 8 to 14 of an identifier say who sent the frame.
        let filter = libc::can_filter { can_id: u32::from(id.cast_unsigned()) << 8, can_mask: 0x7f00 };
        set_option(&socket, libc::CAN_RAW_FILTER, &filter)?;
    }
    // SAFETY: every bit pattern of the address is one, and its first `size_of::<sockaddr_can>` bytes are filled in.
    let ((), address) = unsafe {
        SockAddr::try_init(|storage, length| {
            let address = storage.cast::<libc::sockaddr_can>();
            (*address).can_family = u16::try_from(libc::AF_CAN).unwrap_or_default();
            (*address).can_ifindex = index;
            *length = u32::try_from(size_of::<libc::sockaddr_can>()).unwrap_or_default();
            Ok(())
        })
    }?;
    socket.bind(&address)?;
    socket.set_nonblocking(true)?;
    Ok(File::from(OwnedFd::from(socket)))
}

fn set_option<Value>(socket: &Socket, name: i32, value: &Value) -> io::Result<()> {
    let length = u32::try_from(size_of_val(value)).unwrap_or_default();
    // SAFETY: the option's value lives beyond the call, and its length is told.
    match unsafe { libc::setsockopt(socket.as_raw_fd(), libc::SOL_CAN_RAW, name, (&raw const *value).cast(), length) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// A frame as the socket takes it.
pub(super) fn encode(frame: &CanFdFrame) -> [u8; WIRE_BYTES] {
    let mut padded = frame.clone();
    padded.pad_to_dlc();
    let extended = if frame.arbitration_id > LONGEST_STANDARD_ID { libc::CAN_EFF_FLAG } else { 0 };
    let mut wire = [0; WIRE_BYTES];
    wire[..4].copy_from_slice(&(frame.arbitration_id | extended).to_ne_bytes());
    wire[4] = padded.size;
    wire[5] = BIT_RATE_SWITCH;
    wire[8..].copy_from_slice(&padded.data);
    wire
}

/// A frame as the socket gives it; `None` for an error frame and for what is no CAN FD frame.
pub(super) fn decode(wire: &[u8]) -> Option<CanFdFrame> {
    let identifier = u32::from_ne_bytes(wire.get(..4)?.try_into().ok()?);
    let size = *wire.get(4)?;
    if identifier & libc::CAN_ERR_FLAG != 0 || usize::from(size) > wire.len().saturating_sub(8).min(64) {
        return None;
    }
    let mut frame = CanFdFrame::new();
    frame.arbitration_id = identifier & libc::CAN_EFF_MASK;
    frame.size = size;
    frame.data[..usize::from(size)].copy_from_slice(&wire[8..8 + usize::from(size)]);
    Some(frame)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use super::*;

    #[test]
    fn a_frame_goes_to_the_socket_and_comes_back() {
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = 0x8001;
        frame.data[..9].copy_from_slice(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
        frame.size = 9;
        let wire = encode(&frame);
        assert_eq!(u32::from_ne_bytes(wire[..4].try_into().unwrap()), 0x8000_8001, "extended, beyond 11 bits");
        let back = decode(&wire).unwrap();
        assert_eq!((back.arbitration_id, back.size), (0x8001, 12), "padded to a length that CAN FD has");
        assert_eq!(back.payload(), [1, 2, 3, 4, 5, 6, 7, 8, 9, 0x50, 0x50, 0x50]);
    }

    #[test]
    fn error_frames_and_lengths_beyond_the_data_are_no_frames() {
        let mut wire = [0; WIRE_BYTES];
        wire[4] = 65;
        assert!(decode(&wire).is_none());
        wire[4] = 8;
        wire[..4].copy_from_slice(&libc::CAN_ERR_FLAG.to_ne_bytes());
        assert!(decode(&wire).is_none());
        assert!(decode(&wire[..6]).is_none());
    }
}
