"""Captures and replays by the real programs."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Mapping

from haptic_camera._native import Capture, Error, read

#: Exit statuses with which an archive is there: done, and done but data was lost.
_WITH_ARCHIVE = (0, 3)


def capture(
    knob: int | str | os.PathLike[str] = 1,
    *,
    duration_s: float | None = None,
    sweep: str | None = None,
    rate_hz: float | None = None,
    offline: bool = False,
    rig: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] = "captures",
    arguments: list[str] | None = None,
    program: str | os.PathLike[str] | None = None,
) -> Capture:
    """Turn a knob through a sweep and read what was captured.

    Parameters
    ----------
    knob : int, str or os.PathLike
        The knob on the simulated rig: 1 to 5, or a model file; on a real rig its name.
    duration_s : float, optional
        Length of the capture, s; without it as the sweep has it.
    sweep : str, optional
        Name of the excitation, as in ``haptic-camera capture --sweep``.
    rate_hz : float, optional
        Samples per second.
    offline : bool
        Run the simulated rig as fast as the processor goes, without the real-time processes.
    rig : str or os.PathLike, optional
        The rig's file; without it the simulated rig is driven.
    out : str or os.PathLike
        Folder for the archive, and for the model and the report that are made of it.
    arguments : list of str, optional
        Further arguments of ``haptic-camera capture``.
    program : str or os.PathLike, optional
        The program ``haptic-camera``; without it the one on the PATH.

    Returns
    -------
    Capture

    Raises
    ------
    Error
        If the program is not there or fails, in its own words.
    KeyboardInterrupt
        At Ctrl-C, once the program has braked the knob and closed the archive, which stays in `out`.
    """
    options = {"--knob": knob, "--sweep": sweep, "--duration-s": duration_s, "--rate-hz": rate_hz, "--rig": rig}
    return _recorded(["capture"], options, offline, out, arguments, program)


def replay(
    model: int | str | os.PathLike[str],
    *,
    hand: str | os.PathLike[str] | None = "multisine",
    grip: float | None = None,
    duration_s: float = 10,
    rate_hz: float | None = None,
    offline: bool = False,
    rig: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] = "captures",
    arguments: list[str] | None = None,
    program: str | os.PathLike[str] | None = None,
) -> Capture:
    """Make the rig feel like a model and read what a hand felt.

    Parameters
    ----------
    model : int, str or os.PathLike
        The model to feel like: a model file, or 1 to 5 for a shipped knob.
    hand : str or os.PathLike, optional
        What the hand on the simulated rig wants: the name of an excitation, or a CSV file of angles. None on a real rig,
        where a hand of your own turns the knob.
    grip : float, optional
        Times by which that hand is stiffer and more damped than a usual pinch grip.
    duration_s : float
        Length of the replay, s.
    rate_hz : float, optional
        Samples per second.
    offline : bool
        Run the simulated rig as fast as the processor goes, without the real-time processes.
    rig : str or os.PathLike, optional
        The rig's file; without it the simulated rig is driven.
    out : str or os.PathLike
        Folder for the archive.
    arguments : list of str, optional
        Further arguments of ``haptic-camera replay``.
    program : str or os.PathLike, optional
        The program ``haptic-camera``; without it the one on the PATH.

    Returns
    -------
    Capture
        What was felt, which is fitted like any capture.

    Raises
    ------
    Error
        If the rig cannot render the model, or the program is not there or fails, in its own words.
    KeyboardInterrupt
        At Ctrl-C, once the program has let go of the knob and closed the archive, which stays in `out`.
    """
    options = {"--hand": hand, "--grip": grip, "--duration-s": duration_s, "--rate-hz": rate_hz, "--rig": rig}
    return _recorded(["replay", str(model)], options, offline, out, arguments, program)


def _recorded(
    command: list[str],
    options: Mapping[str, str | os.PathLike[str] | float | None],
    offline: bool,
    out: str | os.PathLike[str],
    arguments: list[str] | None,
    program: str | os.PathLike[str] | None,
) -> Capture:
    """Run a command that makes one archive, and read that."""
    found = shutil.which(program or "haptic-camera")
    if found is None:
        raise Error(
            f"the program {program or 'haptic-camera'} is not there; build it with `cargo build --release`, and name it "
            "by `program` or put its folder on the PATH"
        )
    given = [str(word) for name, value in options.items() if value is not None for word in (name, value)]
    given += [*(["--offline"] if offline else []), "--no-viewer", "--out", str(out), *(arguments or [])]
    status, output, errors = _run([found, *command, *given])
    archive = re.search(r"^archive +(.+) \(\d+ samples\)$", output, re.MULTILINE)
    if status not in _WITH_ARCHIVE or archive is None:
        told = [line.removeprefix("error: ") for line in errors.splitlines() if line]
        raise Error(told[-1] if told else f"{found} ended with status {status}; run it by itself to see why")
    return read(archive[1])


def _run(command: list[str]) -> tuple[int, str, str]:
    """Run a program that ends by itself at Ctrl-C: its status, standard output and standard error."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            output, errors = process.communicate()
        except KeyboardInterrupt:
            # A terminal has told the program already; a notebook has not.
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    return process.returncode, output, errors
