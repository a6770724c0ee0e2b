"""Captures and replays by the real programs."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from tempfile import TemporaryDirectory

from haptic_camera._native import Capture, Error, Model, read

#: What an option may be given as.
_Option = str | os.PathLike[str] | float | None
#: Exit statuses with which an archive is there: done, and done but data was lost.
_WITH_ARCHIVE = (0, 3)


def capture(
    knob: Model | int | str | os.PathLike[str] | None = None,
    *,
    duration_s: float | None = None,
    sweep: str | None = None,
    rate_hz: float | None = None,
    offline: bool = False,
    rig: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] = "captures",
    arguments: Sequence[str] = (),
    program: str | os.PathLike[str] | None = None,
) -> Capture:
    """Turn a knob through a sweep and read what was captured.

    Whatever is left out is as ``haptic-camera capture`` has it.

    Parameters
    ----------
    knob : Model, int, str or os.PathLike, optional
        The knob on the simulated rig: a model, 1 to 5 for a shipped knob, or a model file; on a real rig its name.
    duration_s : float, optional
        Length of the capture, s.
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
    arguments : sequence of str, optional
        Further arguments of the command.
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

    Warns
    -----
    UserWarning
        What the program remarks, samples that were lost among it.
    """
    options: dict[str, _Option] = {"sweep": sweep, "duration-s": duration_s, "rate-hz": rate_hz, "rig": rig}
    words = _given(options, offline, out, arguments)
    if knob is None:
        return _recorded(["capture", *words], program)
    with _named(knob) as (word, name):
        return _recorded(["capture", f"--knob={word}", *name, *words], program)


def replay(
    model: Model | int | str | os.PathLike[str],
    *,
    hand: str | os.PathLike[str] | None = "multisine",
    grip: float | None = None,
    duration_s: float = 10,
    rate_hz: float | None = None,
    offline: bool = False,
    rig: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] = "captures",
    arguments: Sequence[str] = (),
    program: str | os.PathLike[str] | None = None,
) -> Capture:
    """Make the rig feel like a model and read what a hand felt.

    Parameters
    ----------
    model : Model, int, str or os.PathLike
        The model to feel like: a model, a model file, or 1 to 5 for a shipped knob.
    hand : str or os.PathLike, optional
        What the hand on the simulated rig wants: the name of an excitation, or a CSV file of angles. None on a real rig,
        where a hand of your own turns the knob.
    grip : float, optional
        Times by which that hand is stiffer and more damped than a usual pinch grip.
    duration_s : float
        Length of the replay, s.
    rate_hz, offline, rig, out, arguments, program
        As for `capture`.

    Returns
    -------
    Capture
        What was felt, which is fitted like any capture.

    Raises
    ------
    Error
        If the rig cannot render the model; otherwise as `capture`, which warns alike.
    """
    options: dict[str, _Option] = {"hand": hand, "grip": grip, "duration-s": duration_s, "rate-hz": rate_hz, "rig": rig}
    words = _given(options, offline, out, arguments)
    with _named(model) as (word, name):
        return _recorded(["replay", *name, *words, "--", word], program)


@contextmanager
def _named(model: Model | int | str | os.PathLike[str]) -> Iterator[tuple[str, list[str]]]:
    """The word that names a model to a program, and the option that says what to call it, if that is something else."""
    if isinstance(model, Model):
        with TemporaryDirectory(prefix="haptic-camera-") as folder:
            path = os.path.join(folder, "model.toml")
            model.save(path)
            yield path, [f"--name={model.name or 'model'}"]
    elif isinstance(model, str | os.PathLike):
        yield os.fspath(model), []
    elif hasattr(model, "__index__"):
        yield str(int(model)), []
    else:
        wanted = "a Model, the path of one or the number of a shipped knob"
        raise TypeError(f"expected {wanted}, not {type(model).__name__}")


def _given(
    options: Mapping[str, _Option], offline: bool, out: str | os.PathLike[str], arguments: Sequence[str]
) -> list[str]:
    """The options of a run as words."""
    if isinstance(arguments, str):
        raise TypeError("expected a list of words as arguments, not str")
    words = [f"--{name}={value}" for name, value in options.items() if value is not None]
    return [*words, *(["--offline"] if offline else []), "--no-viewer", f"--out={os.fspath(out)}", *arguments]


def _recorded(words: list[str], program: str | os.PathLike[str] | None) -> Capture:
    """Run a command that makes one archive, and read that."""
    found = shutil.which(program or "haptic-camera")
    if found is None:
        raise Error(
            f"the program {program or 'haptic-camera'} is not there; build it with `cargo build --release`, and name it "
            "by `program` or put its folder on the PATH"
        )
    status, output, errors = _run([found, *words])
    archive = re.search(r"^archive +(.+) \(\d+ samples\)$", output, re.MULTILINE)
    lines = [line for line in errors.splitlines() if line]
    if status not in _WITH_ARCHIVE or archive is None:
        wrong = [line.removeprefix("error: ") for line in lines if line.startswith("error: ")] or lines
        raise Error(wrong[-1] if wrong else f"{found} ended with status {status}; run it by itself to see why")
    for remark in lines:
        # As if whoever called `capture` or `replay` had said so.
        warnings.warn(remark, stacklevel=3)
    return read(archive[1])


def _run(command: list[str]) -> tuple[int, str, str]:
    """Run a program that ends by itself at Ctrl-C: its status, standard output and standard error."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            output, errors = process.communicate()
        except KeyboardInterrupt:
            # A terminal has signalled the program already; a notebook has not.
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
    return process.returncode, output, errors
