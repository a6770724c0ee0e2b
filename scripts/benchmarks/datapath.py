"""The way of a sample: tick to consumer, peak rate of the recorder, a long run; called by scripts/bench-datapath."""

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from scipy.stats import linregress

from benchmarks import markdown, rig
from benchmarks.timings import read_arrivals

PERCENTILES = (50, 99, 99.9, 100)
LATENCY_BAR_US = 2_000
RATE_BAR_HZ = 2_000_000
VIEWER_MEMORY_BAR_MIB = 2_048
VIEWER_CPU_BAR_PERCENT = 25
# A process that grows by less than this over an hour is taken for constant: the resolution of pages and heaps.
GROWTH_BAR_MIB_H = 16
PROCESSES = ("rt-loop", *rig.CONSUMERS)


def latency(seconds, rates_hz, rounds, folder):
    """Rows and goals of the way from the tick to each consumer."""
    figures = {}
    for number in range(rounds):
        for rate_hz in rates_hz:
            print(f"tick to consumer, round {number + 1} of {rounds}, {rate_hz} Hz", file=sys.stderr, flush=True)
            place = folder / f"latency-{rate_hz}-{number}"
            rig.capture(rate_hz, seconds, place)
            for consumer in rig.CONSUMERS:
                ages_ns = read_arrivals(place / "timings", consumer)
                if ages_ns is None:
                    raise SystemExit(f"{consumer} noted no arrivals")
                figures.setdefault((consumer, rate_hz), []).append(np.percentile(ages_ns, PERCENTILES) / 1e3)
    rows, goals = [], []
    for (consumer, rate_hz), values in figures.items():
        median = np.median(values, axis=0)
        rows.append([f"tick to {consumer}, {rate_hz // 1000} kHz", *map(markdown.microseconds, median)])
        # The viewer draws four times a second and looks as seldom as that permits.
        if consumer == "rerun-viewer":
            continue
        name = f"tick to {consumer} at {rate_hz // 1000} kHz, p99"
        goals.append(markdown.goal(name, f"{median[1]:.0f} us", f"{LATENCY_BAR_US} us", median[1] < LATENCY_BAR_US))
    heads = ["us", *(f"p{p}".replace("p100", "max") for p in PERCENTILES)]
    return markdown.table(heads, rows), goals


def keeps_up(rate_hz, seconds, place):
    """Whether the recorder loses nothing at this rate; the rate really sent, and its CPU time per sample in ns."""
    place.mkdir(parents=True)
    environment = os.environ | {"HAPTIC_CAMERA_RUNTIME_DIR": str(place / "rig"), "RUST_LOG": "off"}
    out = place / "flood.mcap"
    recorder = subprocess.Popen([rig.PROGRAMS / "recorder", "--out", str(out)], env=environment)
    flood = subprocess.run(
        [rig.PROGRAMS / "examples" / "flood", f"--rate-hz={rate_hz}", f"--duration-s={seconds}"],
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    sent_hz = float(flood.stdout)
    _, status, usage = os.wait4(recorder.pid, 0)
    recorder.returncode = os.waitstatus_to_exitcode(status)
    if recorder.returncode not in (0, 3):
        raise SystemExit(f"the recorder ended with {recorder.returncode}")
    out.unlink(missing_ok=True)
    cpu_ns = (usage.ru_utime + usage.ru_stime) * 1e9 / (sent_hz * seconds)
    return recorder.returncode == 0, sent_hz, cpu_ns


def peak_rate(seconds, folder):
    """The fastest rate that the recorder keeps up with, samples per second, by steps of an eighth, and its CPU time."""
    best_hz, best_cpu_ns, rate_hz = 0.0, 0.0, 250_000
    while True:
        kept, sent_hz, cpu_ns = keeps_up(rate_hz, seconds, folder / f"flood-{rate_hz}")
        print(f"recorder at {sent_hz:.0f}/s: {'kept up' if kept else 'lost samples'}", file=sys.stderr, flush=True)
        # A sender that does not reach the rate says nothing about the recorder.
        if not kept or sent_hz < 0.97 * rate_hz:
            if not best_hz:
                raise SystemExit(f"the recorder, or its sender, does not reach {rate_hz} samples a second on this machine")
            return best_hz, best_cpu_ns
        best_hz, best_cpu_ns = sent_hz, cpu_ns
        rate_hz = int(rate_hz * (1.5 if rate_hz < 1_000_000 else 1.125))


def recording(seconds, rounds, folder):
    """Rows and goals of how fast samples are written."""
    peaks, writes = [], []
    for number in range(rounds):
        print(f"recorder's rate, round {number + 1} of {rounds}", file=sys.stderr, flush=True)
        said = subprocess.run(
            [rig.PROGRAMS / "examples" / "write_rate", str(folder)], check=True, capture_output=True, text=True
        )
        writes.append(json.loads(said.stdout))
        peaks.append(peak_rate(seconds, folder / f"peak-{number}"))
    write = {name: float(np.median([figures[name] for figures in writes])) for name in writes[0]}
    peak_hz, cpu_ns = np.median(peaks, axis=0)
    rows = [
        ["MCAP's Rust library, 100-byte messages, chunks and CRC, uncompressed", f"{write['mcap_uncompressed'] / 1e6:.2f}"],
        ["the same, zstd at its default level", f"{write['mcap_zstd'] / 1e6:.2f}"],
        ["our archive writer, 112-byte samples, chunks and CRC, zstd level 1", f"{write['archive'] / 1e6:.2f}"],
        [f"recorder as a process, nothing lost for {seconds} s ({cpu_ns:.0f} ns of CPU a sample)", f"{peak_hz / 1e6:.2f}"],
    ]
    goals = [
        markdown.goal("peak sustained rate of the recorder", f"{peak_hz / 1e6:.2f} M/s", "2 M/s", peak_hz >= RATE_BAR_HZ)
    ]
    return markdown.table(["million messages a second", ""], rows), goals


@contextlib.contextmanager
def watch(folder, readings):
    """Notes resident memory and CPU time of every process of the rig once a second."""
    over = threading.Event()
    page, tick = os.sysconf("SC_PAGE_SIZE"), os.sysconf("SC_CLK_TCK")

    def run():
        while not over.wait(1):
            for process, name in rig.processes(folder, PROCESSES):
                with contextlib.suppress(OSError):
                    resident = int(Path(f"/proc/{process}/statm").read_text().split()[1]) * page
                    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
                    cpu_s = (int(fields[11]) + int(fields[12])) / tick
                    readings.setdefault(name, []).append((time.monotonic(), resident / 2**20, cpu_s, process))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def slope_per_hour(time_s, resident_mib):
    """Growth per hour and twice its standard error, MiB."""
    if np.ptp(resident_mib) == 0:
        return 0.0, 0.0
    line = linregress(time_s, resident_mib)
    return line.slope * 3600, 2 * line.stderr * 3600


def cpu_of_all(cpu_s, process):
    """CPU time used between the first and the last reading, by every process that bore the name in turn, s."""
    of_one = [cpu_s[process == each] for each in np.unique(process)]
    before = cpu_s[0]
    return sum(readings[-1] for readings in of_one) - before


def long_run(minutes, folder, core):
    """Rows and goals of a long capture: memory over time, CPU, size of the archive."""
    print(f"a capture of {minutes:g} minutes", file=sys.stderr, flush=True)
    readings, place = {}, folder / "long"
    rig.capture(10_000, minutes * 60, place, lambda rig_folder: watch(rig_folder, readings), timed=False, core=core)
    (archive,) = (place / "captures").glob("*.mcap")
    rows, goals = [], []
    for name, values in readings.items():
        time_s, resident_mib, cpu_s, process = np.array(values).T
        # The first half belongs to buffers that fill once: history, bins of the fit, the view's memory limit.
        late = (time_s > (time_s[0] + time_s[-1]) / 2) & (process == process[-1])
        growth, error = slope_per_hour(time_s[late], resident_mib[late])
        cpu_percent = 100 * cpu_of_all(cpu_s, process) / (time_s[-1] - time_s[0])
        restarts = len(np.unique(process)) - 1
        rows.append(
            [name, f"{resident_mib[0]:.1f}", f"{resident_mib.max():.1f}", f"{resident_mib[-1]:.1f}"]
            + [f"{growth:+.1f} ± {error:.1f}", f"{cpu_percent:.2f}", str(restarts)]
        )
        if restarts:
            goals.append(markdown.goal(f"restarts of {name}", str(restarts), "0", False))
        if name != "rerun-viewer":
            figure = f"{growth:+.1f} ± {error:.1f} MiB/h"
            bar = f"{GROWTH_BAR_MIB_H} MiB/h"
            goals.append(markdown.goal(f"memory of {name} constant", figure, bar, growth < GROWTH_BAR_MIB_H))
        else:
            # It keeps what it has shown for a page that is opened later, up to a limit that an hour need not reach.
            peak = resident_mib.max()
            goals.append(markdown.goal("viewer's memory", f"{peak:.0f} MiB", "2 GiB", peak < VIEWER_MEMORY_BAR_MIB))
            goals.append(markdown.goal("viewer's CPU", f"{cpu_percent:.1f} % of a core", "25 %", cpu_percent < VIEWER_CPU_BAR_PERCENT))
    heads = ["process", "MiB first", "MiB most", "MiB last", "MiB per hour, second half", "CPU, % of a core", "restarts"]
    size = archive.stat().st_size
    samples = minutes * 60 * 10_000
    text = f"Archive of {minutes:g} minutes at 10 kHz: {size / 1e6:.0f} MB, {size / samples:.1f} bytes a sample, "
    return markdown.table(heads, rows) + f"\n\n{text}{size / minutes * 60 / 1e9:.2f} GB an hour.", goals


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench-datapath", description=__doc__)
    parser.add_argument("--seconds", type=int, default=10, help="length of each capture and flood (default 10)")
    parser.add_argument("--rounds", type=int, default=3, help="rounds (default 3; 0 leaves them out)")
    parser.add_argument("--minutes", type=float, default=3, help="length of the long run (default 3; 0 leaves it out)")
    parser.add_argument("--hours", type=float, help="length of the long run in hours instead")
    parser.add_argument("--core", type=int, help="core of the loop in the long run (default: the last)")
    asked = parser.parse_args()
    minutes = asked.hours * 60 if asked.hours else asked.minutes
    rounds = f"medians of {asked.rounds} rounds of {asked.seconds} s" if asked.rounds else "the long run alone"
    parts, goals = [f"{markdown.machine()}; {rounds}."], []
    with tempfile.TemporaryDirectory(prefix="haptic-camera-bench-") as name:
        folder = Path(name)
        measured = []
        if asked.rounds:
            measured.append(latency(asked.seconds, (5_000, 10_000, 20_000), asked.rounds, folder))
            measured.append(recording(asked.seconds, asked.rounds, folder))
        if minutes:
            measured.append(long_run(minutes, folder, asked.core))
        for text, reached in measured:
            parts.append(text)
            goals += reached
    markdown.keep("datapath", "\n\n".join([*parts, markdown.goals_table(goals)]))


if __name__ == "__main__":
    main()
