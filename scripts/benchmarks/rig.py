"""Runs of the instrument itself, left alone or disturbed, on a rig of their own."""

import contextlib
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

PROGRAMS = Path(os.environ.get("CARGO_TARGET_DIR", "target")).absolute() / "release"
CONSUMERS = ("recorder", "live-fitter", "rerun-viewer")
# A consumer that dies younger than 1 s several times in a row is started again after longer and longer pauses.
LIFE_S = 1.1


def environment(folder, timed=True):
    """The variables that give a run its own rig and, if it is timed, have its timings written."""
    timings = {"HAPTIC_CAMERA_TIMINGS": str(folder / "timings")} if timed else {}
    return os.environ | {"HAPTIC_CAMERA_RUNTIME_DIR": str(folder / "rig")} | timings


def ticks_file(folder):
    (path,) = (folder / "timings").glob("ticks-*")
    return path


def bare_loop(core, rate_hz, seconds, folder):
    """The loop's wait alone; the file of its ticks."""
    path = folder / "bare"
    arguments = [f"--core={core}", f"--rate-hz={rate_hz}", f"--duration-s={seconds}", f"--out={path}"]
    subprocess.run([PROGRAMS / "examples" / "bare_loop", *arguments], check=True)
    return path


def idle_loop(core, rate_hz, seconds, folder):
    """The control loop, armed, with nobody who asks for a run; the file of its ticks."""
    process = subprocess.Popen(
        [PROGRAMS / "rt-loop", f"--core={core}", f"--rate-hz={rate_hz}"], env=environment(folder)
    )
    time.sleep(seconds + 0.5)
    process.send_signal(signal.SIGTERM)
    if process.wait(timeout=10):
        raise SystemExit("the control loop failed; its error stands above")
    return ticks_file(folder)


def capture(rate_hz, seconds, folder, meanwhile=contextlib.nullcontext, timed=True, core=None):
    """A capture with all consumers; its ticks and arrivals lie in `folder / "timings"` if it is timed."""
    (folder / "timings").mkdir(parents=True, exist_ok=True)
    with open(folder / "said", "w+") as said:
        process = subprocess.Popen(
            [PROGRAMS / "haptic-camera", "capture", f"--duration-s={seconds}", f"--rate-hz={rate_hz}"]
            + ["--out", str(folder / "captures")]
            + ([] if core is None else [f"--core={core}"]),
            env=environment(folder, timed),
            stdout=said,
            stderr=subprocess.STDOUT,
        )
        with meanwhile(folder):
            process.wait()
        if process.returncode:
            said.seek(0)
            raise SystemExit(f"the capture ended with {process.returncode}:\n{said.read()}")


def processes(folder, names=CONSUMERS):
    """Process ids of the programs called so that belong to the rig in this folder, with their names."""
    mark = f"HAPTIC_CAMERA_RUNTIME_DIR={folder / 'rig'}".encode()
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                name = (entry / "comm").read_text().strip()
                for known in names:
                    if name == known[:15] and mark in (entry / "environ").read_bytes().split(b"\0"):
                        yield int(entry.name), known


@contextlib.contextmanager
def kills(folder, seconds):
    """Kills every consumer whenever it has lived long enough: about three kills a second in all, while the run goes on.

    Afterwards the recorder is left to close the archive, which on a loaded core takes longer than such a life.
    """
    over = threading.Event()

    def run():
        born = {}
        begun = None
        while not over.wait(0.05):
            now = time.monotonic()
            if begun and now - begun > seconds:
                return
            for process, _ in processes(folder):
                begun = begun or now
                if now - born.setdefault(process, now) > LIFE_S:
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(process, signal.SIGKILL)
                    born.pop(process)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextlib.contextmanager
def load(core, folder):
    """stress-ng on every core but one: processor, memory and disk."""
    others = sorted(cores() - {core})
    if not others:
        raise SystemExit("there is no other core to put a load on")
    count = str(len(others))
    folder.mkdir(parents=True, exist_ok=True)
    process = subprocess.Popen(
        ["stress-ng", "--quiet", "--taskset", ",".join(map(str, others)), "--temp-path", str(folder)]
        + ["--cpu", count, "--vm", count, "--vm-bytes", "128M", "--hdd", "1", "--hdd-bytes", "64M"],
    )
    try:
        time.sleep(1)
        yield
    finally:
        process.terminate()
        process.wait()


def cores():
    """The cores that may be used."""
    return os.sched_getaffinity(0)
