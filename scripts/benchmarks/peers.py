"""What the host itself does to a core, by tools of others: oslat and cyclictest (Debian package rt-tests)."""

import dataclasses
import json
import os
import subprocess
import time

import numpy as np

PRIORITY = 80
OSLAT_BUCKETS = 1024


@dataclasses.dataclass
class Histogram:
    """Latencies of cyclictest: values in us with their counts, and the longest."""

    value_us: np.ndarray
    count: np.ndarray
    max_us: float

    def percentile_us(self, percentile):
        if percentile == 100:
            return self.max_us
        share = np.cumsum(self.count) / self.count.sum()
        return float(self.value_us[np.searchsorted(share, percentile / 100)])


def cyclictest(core, rate_hz, seconds, folder):
    """One thread of cyclictest at this rate on this core."""
    path = folder / "cyclictest.json"
    subprocess.run(
        ["cyclictest", "--mlockall", f"--priority={PRIORITY}", f"--affinity={core}", "--threads=1", "--quiet"]
        + [f"--interval={round(1e6 / rate_hz)}", f"--duration={seconds}", "--histogram=20000", f"--json={path}"],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    (thread,) = json.loads(path.read_text())["thread"].values()
    value_us, count = np.array(sorted((int(us), n) for us, n in thread["histogram"].items())).T
    return Histogram(value_us, count, float(thread["max"]))


@dataclasses.dataclass
class Stalls:
    """What oslat saw: stalls by length, those that the scheduler caused itself taken away."""

    length_us: np.ndarray
    count: np.ndarray
    max_us: float
    duration_s: float
    # Times at which the scheduler took oslat off the core for ordinary tasks.
    taken_off: int

    def lateness_us(self, percentile, rate_hz):
        """The lateness that these stalls alone cause a loop at this rate that is otherwise never late.

        A stall of length L that a loop of period T meets anywhere makes one wake later than x with probability
        (L - x) / T, or surely once L - x exceeds T.
        """
        if percentile == 100:
            return self.max_us
        period_us = 1e6 / rate_hz
        wanted = (1 - percentile / 100) * self.duration_s * rate_hz
        low, high = 0.0, self.max_us
        for _ in range(60):
            middle = (low + high) / 2
            late = (self.count * np.clip((self.length_us - middle) / period_us, 0, 1)).sum()
            low, high = (middle, high) if late > wanted else (low, middle)
        return high


def oslat(core, seconds, folder):
    """oslat at the loop's priority.

    It never sleeps, so that the scheduler takes it off the core for up to 50 ms a second to let ordinary tasks run.
    That is no doing of the host's and does not happen to a loop that sleeps. Each time is an involuntary context switch
    of its thread, which stalls of the host are not: as many of the longest stalls are left out.
    """
    path = folder / "oslat.json"
    main_core = next(iter(sorted(os.sched_getaffinity(0) - {core})), core)
    process = subprocess.Popen(
        ["oslat", f"--cpu-list={core}", f"--cpu-main-thread={main_core}", f"--rtprio={PRIORITY}", "--quiet"]
        + [f"--duration={seconds}", f"--bucket-size={OSLAT_BUCKETS}", f"--json={path}"],
        stdout=subprocess.DEVNULL,
    )
    taken_off = 0
    while process.poll() is None:
        taken_off = max(taken_off, involuntary_switches(process.pid))
        time.sleep(0.05)
    if process.returncode:
        raise SystemExit(f"oslat ended with {process.returncode}; it needs root or an rtprio limit")
    (thread,) = json.loads(path.read_text())["thread"].values()
    length_us, count = np.array(sorted((int(us), n) for us, n in thread["histogram"].items())).T
    stalled = length_us > 1  # the first bucket is the loop of oslat itself
    length_us, count = length_us[stalled].astype(float), count[stalled]
    # What is longer than the buckets is in the last one, with its number but not its length.
    beyond = length_us == OSLAT_BUCKETS
    host = max(0, int(count[beyond].sum()) - taken_off)
    within = length_us[~beyond].max(initial=1.0)
    count = np.where(beyond, host, count)
    longest = float(thread["max"]) if host else within
    return Stalls(length_us, count, longest, float(thread["duration"]), taken_off)


def involuntary_switches(process):
    """Of the one thread of the process that measures: the sum over all threads but the first."""
    total = 0
    try:
        for thread in os.listdir(f"/proc/{process}/task"):
            if int(thread) == process:
                continue
            for line in open(f"/proc/{process}/task/{thread}/status"):
                if line.startswith("nonvoluntary_ctxt_switches"):
                    total += int(line.split()[1])
    except (FileNotFoundError, ProcessLookupError):
        pass
    return total
