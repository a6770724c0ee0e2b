"""Reads the timings that the control loop and its consumers leave in $HAPTIC_CAMERA_TIMINGS."""

import dataclasses
from pathlib import Path

import numpy as np

# As TickRecord in processes/rt-loop/src/realtime/tick_record.rs writes it.
TICK = np.dtype(
    [
        ("due_ns", "<u8"),
        ("begun_ns", "<u8"),
        ("missed_ticks", "<u4"),
        ("sensor_read_ns", "<u4"),
        ("control_ns", "<u4"),
        ("push_ns", "<u4"),
        ("state", "<u4"),
    ]
)
# As processes/consumer/src/arrivals.rs writes it.
ARRIVAL = np.dtype([("due_ns", "<u8"), ("arrived_ns", "<u8")])
ARMED, RUNNING = 1, 2
PERCENTILES = (50, 99, 99.9, 99.99, 100)


@dataclasses.dataclass
class Ticks:
    """The ticks of one run of a loop; all times in ns."""

    rate_hz: float
    lateness_ns: np.ndarray
    variation_ns: np.ndarray
    missed_ticks: int
    overruns: int
    second: np.ndarray
    sensor_read_ns: np.ndarray | None = None
    control_ns: np.ndarray | None = None
    push_ns: np.ndarray | None = None

    def per_second(self, percentile):
        """The percentile of the lateness in each whole second."""
        whole = [self.lateness_ns[self.second == second] for second in range(int(self.second.max(initial=0)))]
        return np.array([np.percentile(lateness, percentile) for lateness in whole if len(lateness)])


def read_ticks(path, rate_hz, state=None):
    """The ticks of a file of records, those in one state of the loop alone if it is given.

    Lateness counts from the first tick that a wake was due for, missed ones included, as cyclictest counts it.
    Variation is how far the time between two wakes is from a period.
    """
    records = np.fromfile(path, TICK)
    kept = records if state is None else records[records["state"] == state]
    if len(kept) < 2:
        raise SystemExit(f"{path}: {len(kept)} ticks recorded: the loop did not get that far")
    period_ns = 1e9 / rate_hz
    late_ns = kept["begun_ns"].astype(np.int64) - kept["due_ns"].astype(np.int64)
    lateness_ns = late_ns + kept["missed_ticks"] * period_ns
    variation_ns = np.abs(np.diff(kept["begun_ns"].astype(np.int64)) - period_ns)
    since_ns = kept["due_ns"] - kept["due_ns"][0]
    durations = {name: kept[name] for name in ("sensor_read_ns", "control_ns", "push_ns")}
    return Ticks(
        rate_hz,
        lateness_ns,
        variation_ns,
        int(kept["missed_ticks"].sum()),
        int((kept["missed_ticks"] > 0).sum()),
        (since_ns // 10**9).astype(np.int64),
        **(durations if kept["control_ns"].any() else {}),
    )


def read_arrivals(folder, consumer):
    """Time from the tick to the consumer for each sample that it received alive, ns; `None` when there are none.

    The first second is left out: a consumer that comes in the middle is handed the past of some seconds first.
    """
    ages_ns = []
    for path in sorted(Path(folder).glob(f"arrivals-{consumer}-*")):
        size = path.stat().st_size // ARRIVAL.itemsize
        arrivals = np.fromfile(path, ARRIVAL, count=size)
        if len(arrivals):
            settled = arrivals[arrivals["arrived_ns"] > arrivals["arrived_ns"][0] + 10**9]
            ages_ns.append(settled["arrived_ns"].astype(np.int64) - settled["due_ns"].astype(np.int64))
    return np.concatenate(ages_ns) if any(map(len, ages_ns)) else None
