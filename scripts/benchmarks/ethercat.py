"""Frames around an EtherCAT bus, by the driver's transport and by ethercrab's own; called by scripts/bench-ethercat."""

import argparse
import contextlib
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks import markdown

OURS, THEIRS = "our socket", "ethercrab's `std`"
DEVICES, MASTER = "hc1", "hc0"
# What a frame costs, by its name in what the programs print.
FIGURES = ("frames", "lost", "allocations", "p50", "p99", "p99.9", "longest")
# Two lengths, s, whose calls differ by those of the frames between them, at a rate in Hz; and the time until the bus is up, s.
COUNTED_S = (4, 7)
COUNTED_HZ = 1_000
UP_AFTER_S = 2


def rig_file(folder):
    """The rig file of the driver's tests."""
    source = Path("tests/tests/ethercat/main.rs").read_text()
    path = folder / "rig.toml"
    path.write_text(re.search(r'^const RIG: &str = r#"\n(.*?)^"#;', source, re.MULTILINE | re.DOTALL)[1])
    return path


def command(transport, rig, rate_hz, seconds):
    """A program that prints one line, and the cores it may have: the segment has the first."""
    last = os.cpu_count() - 1
    # ethercrab's transport is a thread of its own, which goes where there is room.
    cores, program = {
        OURS: (last, ["target/release/examples/exchange", rig]),
        THEIRS: (f"0-{last}", ["target/ethercrab-std/release/ethercrab-std", MASTER]),
    }[transport]
    return ["chrt", "-f", "80", "taskset", "-c", str(cores)], [*map(str, program), str(rate_hz), str(seconds)]


@contextlib.contextmanager
def segment():
    """The devices, on the other end of the wire."""
    devices = subprocess.Popen(["target/release/ethercat_segment", "--interface", DEVICES], stdout=subprocess.DEVNULL)
    try:
        time.sleep(0.5)
        yield
    finally:
        devices.kill()
        devices.wait()


def measure(transport, rig, rate_hz, seconds):
    """The figures of one run."""
    placed, program = command(transport, rig, rate_hz, seconds)
    with segment():
        printed = subprocess.run([*placed, *program], check=True, capture_output=True, text=True).stdout
    return dict(zip(FIGURES, map(float, printed.split(",")), strict=True))


def calls_per_frame(transport, rig):
    """System calls of all threads for a frame: what a longer run has more of."""
    counts = []
    for seconds in COUNTED_S:
        placed, program = command(transport, rig, COUNTED_HZ, seconds)
        counting = ["perf", "stat", f"--delay={1_000 * UP_AFTER_S}", "--field-separator=,", "--event=raw_syscalls:sys_enter"]
        with segment():
            counted = subprocess.run([*counting, *placed, *program], check=True, capture_output=True, text=True).stderr
        counts.append(int(re.search(r"^(\d+),.*raw_syscalls", counted, re.MULTILINE)[1]))
    return (counts[1] - counts[0]) / (COUNTED_HZ * (COUNTED_S[1] - COUNTED_S[0]))


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench-ethercat", description=__doc__)
    parser.add_argument("--seconds", type=int, default=8, help="length of each run (default 8)")
    parser.add_argument("--rounds", type=int, default=5, help="rounds (default 5)")
    parser.add_argument("--rates", type=int, nargs="+", default=[1_000, 2_000, 4_000, 8_000], help="Hz")
    asked = parser.parse_args()
    for line in (f"link add {MASTER} type veth peer name {DEVICES}", f"link set {MASTER} up", f"link set {DEVICES} up"):
        subprocess.run(["ip", *line.split()], check=True)
    machine = markdown.machine()
    runs = {}
    with tempfile.TemporaryDirectory(prefix="haptic-camera-bench-") as name:
        folder = Path(name)
        rig = rig_file(folder)
        for number in range(asked.rounds):
            for rate_hz in asked.rates:
                for transport in (OURS, THEIRS):
                    print(f"{transport}, round {number + 1} of {asked.rounds}, {rate_hz} Hz", file=sys.stderr, flush=True)
                    runs.setdefault((rate_hz, transport), []).append(measure(transport, rig, rate_hz, asked.seconds))
        calls = {transport: calls_per_frame(transport, rig) for transport in (OURS, THEIRS)}
    rows = []
    for (rate_hz, transport), found in runs.items():
        median = {figure: statistics.median(run[figure] for run in found) for figure in FIGURES}
        jitter = statistics.median(run["p99"] - run["p50"] for run in found)
        rows.append([
            f"{transport}, {rate_hz} Hz",
            *(markdown.microseconds(median[figure]) for figure in ("p50", "p99", "p99.9", "longest")),
            markdown.microseconds(jitter),
            f"{1e3 * median['lost'] / median['frames']:.2f}",
            f"{calls[transport]:.1f}",
            f"{median['allocations']:.1f}",
        ])
    heads = ["µs", "p50", "p99", "p99.9", "longest", "jitter", "lost, ‰", "calls a frame", "allocations a frame"]
    ratios = []
    for rate_hz in asked.rates:
        pairs = list(zip(runs[rate_hz, OURS], runs[rate_hz, THEIRS], strict=True))
        of = {figure: statistics.median(ours[figure] / theirs[figure] for ours, theirs in pairs) for figure in ("p50", "p99")}
        lost = [sum(run["lost"] for run in runs[rate_hz, transport]) for transport in (OURS, THEIRS)]
        ratios.append([f"{rate_hz} Hz", f"{of['p50']:.2f}", f"{of['p99']:.2f}", f"{lost[0]:.0f} / {lost[1]:.0f}"])
    markdown.keep("ethercat", "\n\n".join([
        f"{machine}; {asked.rounds} rounds of {asked.seconds} s a row; medians over rounds.",
        markdown.table(heads, rows),
        markdown.table(["ours by theirs", "p50", "p99", "lost in all rounds"], ratios),
    ]))


if __name__ == "__main__":
    main()
