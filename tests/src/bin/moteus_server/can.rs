//! CAN FD frames over a raw socket of a CAN interface, as `linux/can.h` has them.

#![allow(unsafe_code, reason = "CAN addresses are known to the C library alone")]

use std::ffi::CString;
use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::mem::{size_of, size_of_val, zeroed};
use std::os::fd::{AsRawFd as _, FromRawFd as _};

/// Lengths that a CAN FD frame can have beyond eight bytes.
const LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// A socket that hears every frame on the interface.
pub fn open(interface: &str) -> anyhow::Result<File> {
    let name = CString::new(interface)?;
    let checked = |result: i32| if result < 0 { Err(io::Error::last_os_error()) } else { Ok(result) };
    let on = 1_i32;
    // SAFETY: the socket belongs to the file from here on; option and address live beyond their calls, and their lengths are told.
    unsafe {
        let socket = File::from_raw_fd(checked(libc::socket(libc::AF_CAN, libc::SOCK_RAW, libc::CAN_RAW))?);
        let descriptor = socket.as_raw_fd();
        let length = size_of_val(&on) as u32;
        checked(libc::setsockopt(
            descriptor,
            libc::SOL_CAN_RAW,
            libc::CAN_RAW_FD_FRAMES,
            (&raw const on).cast(),
            length,
        ))?;
        let mut address: libc::sockaddr_can = zeroed();
        address.can_family = libc::AF_CAN as u16;
        address.can_ifindex = libc::if_nametoindex(name.as_ptr()) as i32;
        anyhow::ensure!(address.can_ifindex > 0, "there is no interface {interface}");
        let length = size_of::<libc::sockaddr_can>() as u32;
        checked(libc::bind(descriptor, (&raw const address).cast(), length))?;
        Ok(socket)
    }
}

/// The next frame, as identifier and data.
pub fn receive(socket: &mut File) -> io::Result<(u32, Vec<u8>)> {
    let mut wire = [0; size_of::<libc::canfd_frame>()];
    let length = socket.read(&mut wire)?;
    let identifier = u32::from_ne_bytes([wire[0], wire[1], wire[2], wire[3]]) & libc::CAN_EFF_MASK;
    let data = 8..(8 + usize::from(wire[4])).min(length).max(8);
    Ok((identifier, wire[data].to_vec()))
}

/// Sends a frame, filled up to a length that frames have.
pub fn send(socket: &mut File, identifier: u32, data: &[u8]) -> io::Result<()> {
    let length = if data.len() <= 8 {
        data.len()
    } else {
        LENGTHS.into_iter().find(|length| *length >= data.len()).unwrap_or(64)
    };
    let mut wire = [0; size_of::<libc::canfd_frame>()];
    let extended = if identifier > libc::CAN_SFF_MASK { libc::CAN_EFF_FLAG } else { 0 };
    wire[..4].copy_from_slice(&(identifier | extended).to_ne_bytes());
    wire[4] = length as u8;
    wire[8..8 + data.len().min(64)].copy_from_slice(&data[..data.len().min(64)]);
    wire[8 + data.len()..8 + length].fill(0x50);
    socket.write_all(&wire)
}
