"""A moteus controller on a pty that speaks by the vendor's own codec (PyPI `moteus`); its plant goes by the clock.

    moteus_server.py LINK [--id ID] [--uart]
"""

import argparse
import io
import math
import os
import select
import time
import tty

from moteus import Mode, Register, multiplex
from moteus.fdcanusb_device import _append_checksum, _strip_and_validate_checksum

# Rotor and knob as one body: mNm s^2/rad, mNm, mNm s/rad, mNm, detents a turn.
INERTIA, COULOMB, VISCOUS, DETENT, DETENTS = 0.08, 3.0, 0.25, 4.0, 24.0
SUBSTEP_S = 1e-4


class Plant:
    """The body, carried on by the clock."""

    def __init__(self):
        self.angle = self.velocity = self.motor_mnm = 0.0
        self.time = time.monotonic()

    def turn_to(self, now):
        while self.time < now:
            step = min(SUBSTEP_S, max(now - self.time, 1e-9))
            before = self.velocity
            smooth = self.motor_mnm - VISCOUS * before - DETENT * math.sin(DETENTS * self.angle)
            kicked = before + step * smooth / INERTIA
            brake = step * COULOMB / INERTIA
            self.velocity = 0.0 if abs(kicked) <= brake else kicked - math.copysign(brake, kicked)
            self.angle += step * (before + self.velocity) / 2
            self.time += step


class Controller:
    """Modes, a watchdog, and the registers that a driver may want."""

    def __init__(self):
        self.plant = Plant()
        self.mode, self.commanded, self.watchdog_s = Mode.STOPPED, time.monotonic(), 0.1
        self.began = time.monotonic()

    def serve(self, data):
        now = time.monotonic()
        if self.mode == Mode.POSITION and now - self.commanded > self.watchdog_s:
            self.plant.turn_to(self.commanded + self.watchdog_s)
            self.plant.motor_mnm, self.mode = 0.0, Mode.TIMEOUT
        self.plant.turn_to(now)
        frames = list(multiplex.parse_frame(data))
        measured_nm = self.plant.motor_mnm / 1e3
        written = {frame.register: frame.value for frame in frames
                   if isinstance(frame, multiplex.RegisterSubframe) and frame.type == multiplex.SubframeType.WRITE}
        self.command(written, now)
        reply = io.BytesIO()
        writer = multiplex.WriteFrame(reply)
        for frame in frames:
            if isinstance(frame, multiplex.RegisterSubframe) and frame.type == multiplex.SubframeType.READ:
                value = self.told(frame.register, measured_nm, now)
                writer.write_int8(multiplex.REPLY_BASE | frame.resolution << 2 | 1)
                writer.write_varuint(frame.register)
                writer.write(value if frame.resolution == multiplex.F32 else int(value), frame.resolution)
        return reply.getvalue()

    def command(self, written, now):
        mode = written.get(Register.MODE)
        if mode == Mode.STOPPED:
            self.mode, self.plant.motor_mnm = Mode.STOPPED, 0.0
        elif mode == Mode.POSITION and self.mode in (Mode.STOPPED, Mode.POSITION):
            self.mode, self.commanded = Mode.POSITION, now
            self.watchdog_s = written.get(Register.COMMAND_TIMEOUT, 0.1)
            most_nm = written.get(Register.COMMAND_POSITION_MAX_TORQUE, math.inf)
            asked_nm = written.get(Register.COMMAND_FEEDFORWARD_TORQUE, 0.0)
            self.plant.motor_mnm = 1e3 * max(-most_nm, min(most_nm, asked_nm))

    def told(self, register, measured_nm, now):
        return {
            Register.MODE: self.mode,
            Register.POSITION: self.plant.angle / (2 * math.pi),
            Register.VELOCITY: self.plant.velocity / (2 * math.pi),
            Register.TORQUE: measured_nm,
            Register.FAULT: 0,
            Register.MILLISECOND_COUNTER: 1e3 * (now - self.began),
            Register.REGISTER_MAP_VERSION: 5,
        }.get(register, 0)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("link")
    parser.add_argument("--id", type=int, default=1)
    parser.add_argument("--uart", action="store_true")
    options = parser.parse_args()
    port, other_end = os.openpty()
    tty.setraw(other_end)
    os.symlink(os.ttyname(other_end), options.link)
    print("ready", flush=True)
    controller = Controller()
    waiting = b""

    def say(line):
        os.write(port, (_append_checksum(line) if options.uart else line) + b"\r\n")

    while True:
        select.select([port], [], [])
        waiting += os.read(port, 4096)
        *lines, waiting = waiting.split(b"\n")
        for line in lines:
            content, has_checksum, is_right = _strip_and_validate_checksum(line.strip())
            words = content.split(b" ")
            if words[:2] != [b"can", b"send"] or (has_checksum and not is_right):
                say(b"ERR checksum mismatch" if has_checksum else b"ERR unknown command")
                continue
            say(b"OK")
            identifier = int(words[2], 16)
            if identifier & 0x7F != options.id:
                continue
            reply = controller.serve(bytes.fromhex(words[3].decode()))
            if identifier & 0x8000:
                say(b"rcv %x %s E B F" % (options.id << 8 | identifier >> 8 & 0x7F, reply.hex().encode()))


main()
