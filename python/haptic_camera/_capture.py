"""Captures by the real programs."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess

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
    out: str | os.PathLike[str] = "captures",
    arguments: list[str] | None = None,
    program: str | os.PathLike[str] | None = None,
) -> Capture:
    """Turn a knob through a sweep and read what was captured.

    Parameters
    ----------
    knob : int, str or os.PathLike
        The knob on the simulated rig: 1 to 5, or a model file.
    duration_s : float, optional
        Length of the capture, s; without it as the sweep has it.
    sweep : str, optional
        Name of the excitation, as in ``haptic-camera capture --sweep``.
    rate_hz : float, optional
        Samples per second.
    offline : bool
        Run the simulated rig as fast as the processor goes, without the real-time processes.
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
    found = shutil.which(program or "haptic-camera")
    if found is None:
        raise Error(
            f"the program {program or 'haptic-camera'} is not there; build it with `cargo build --release`, and name it "
            "by `program` or put its folder on the PATH"
        )
    options = {"--duration-s": duration_s, "--sweep": sweep, "--rate-hz": rate_hz}
    given = [str(word) for name, value in options.items() if value is not None for word in (name, value)]
    command = [found, "capture", "--knob", os.fspath(knob) if not isinstance(knob, int) else str(knob), "--no-viewer"]
    command += [*given, *(["--offline"] if offline else []), *(arguments or [])]
    status, output, errors = _run([*command, "--out", os.fspath(out)])
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
