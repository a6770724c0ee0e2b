"""How far what the live view draws lies behind the run; called by scripts/bench-live-view."""

import argparse
import bisect
import contextlib
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

from benchmarks import markdown, rig

# The place of each tab in the row of tabs, pixels.
TABS = {"knob": 40, "signals": 140, "parameters": 250, "timing": 380}
TABS_HEIGHT = 25
# Goals for the lag, s: median and largest.
BARS_S = {"alone": (1, 2), "loaded": (2, 4)}
# How often the lag is looked at, s.
STEP_S = 0.1
MEMORY_EVERY_S = 5
PATIENCE_S = 300
# Where the viewer begins, and by what it is enlarged.
PLACE = """(() => {
  const viewer = document.getElementById("viewer");
  const { top, height } = viewer.getBoundingClientRect();
  return [top, height / viewer.offsetHeight];
})()"""
# Notes when the time that the viewer shows, and the newest that it holds, have changed.
WATCH = """
window.seen = [];
setInterval(() => {
  const recording = viewer.get_active_recording_id();
  const shown = recording && viewer.get_time_for_timeline(recording, "time_s");
  const held = recording && viewer.get_timeline_time_range(recording, "time_s")?.max;
  const last = window.seen.at(-1);
  if (last?.[1] !== shown || last?.[2] !== held) window.seen.push([Date.now(), shown, held]);
}, 20);
"""


class Browser:
    """A browser that obeys lines of JSON; see scripts/browser.js."""

    def __init__(self):
        pipe = subprocess.PIPE
        self.driver = subprocess.Popen(["scripts/browser"], stdin=pipe, stdout=pipe, text=True)

    def ask(self, **command):
        self.driver.stdin.write(json.dumps(command) + "\n")
        self.driver.stdin.flush()
        answer = json.loads(self.driver.stdout.readline() or '{"error": "the browser has ended"}')
        if "error" in answer:
            raise SystemExit(f"the browser: {answer['error']}")
        return answer

    def wait_until(self, page, expression):
        deadline = time.monotonic() + PATIENCE_S
        while not self.ask(page=page, evaluate=f"Boolean({expression})")["value"]:
            if time.monotonic() > deadline:
                raise SystemExit(f"never came true: {expression}")
            time.sleep(0.1)

    def close(self):
        self.driver.stdin.close()
        self.driver.wait()


def children(process):
    """The process and all that it started."""
    yield process
    for task in Path(f"/proc/{process}/task").iterdir():
        for child in (task / "children").read_text().split():
            yield from children(int(child))


class Usage:
    """Processor time and memory of the processes that draw a browser's pages."""

    def __init__(self, browser):
        self.processes = []
        for process in children(browser):
            command = Path(f"/proc/{process}/cmdline").read_bytes()
            if b"--type=renderer" in command or b"--type=gpu-process" in command:
                self.processes.append(process)

    def processor_s(self):
        ticks = 0
        for process in self.processes:
            fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
            ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    def memory_mib(self):
        kibibytes = 0
        for process in self.processes:
            lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
            kibibytes += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
        return kibibytes / 1024


def status(url):
    """The newest word of the run, and when it was heard, s."""
    with urllib.request.urlopen(f"{url}status", timeout=PATIENCE_S) as answer:
        return json.load(answer), time.time()


@contextlib.contextmanager
def capture(folder, rate_hz):
    """A capture that goes on until it is left; gives the address of its view."""
    with open(folder / "said", "w+") as said:
        process = subprocess.Popen(
            [rig.PROGRAMS / "haptic-camera", "capture", "--knob=3", "--duration-s=7200", f"--rate-hz={rate_hz}"]
            + ["--out", folder / "captures"],
            env=rig.environment(folder, timed=False),
            stdout=said,
            stderr=subprocess.STDOUT,
        )
        port = folder / "rig" / "live-view-port.json"
        while not port.exists() or not port.read_text():
            if process.poll() is not None:
                said.seek(0)
                raise SystemExit(f"the capture ended at once:\n{said.read()}")
            time.sleep(0.05)
        try:
            yield f"http://127.0.0.1:{port.read_text()}/"
        finally:
            process.send_signal(2)
            process.wait()


def lags_s(seen, heard, begin, end):
    """How far what was shown lay behind the run at each step, by the run's own clock."""
    # When the run was at its zero: a status may have waited, but never came too early.
    zero = min(at - said["time_s"] for said, at in heard)
    times = [at / 1e3 for at, *_ in seen]
    for step in range(int((end - begin) / STEP_S)):
        moment = begin + step * STEP_S
        last = bisect.bisect_right(times, moment) - 1
        _, shown, held = seen[max(last, 0)]
        yield tuple(moment - zero - (value or 0) / 1e9 for value in (shown, held))


def measure(tab, asked, folder):
    """One tab followed for a while."""
    with capture(folder, asked.rate_hz) as url, contextlib.closing(Browser()) as browser:
        opened = time.monotonic()
        page = browser.ask(open=f"{url}?renderer=webgl", size=asked.size)
        number = page["page"]
        browser.wait_until(number, "document.body.dataset.newest > 0")
        loading_s = time.monotonic() - opened
        top, scale = browser.ask(page=number, evaluate=PLACE)["value"]
        browser.ask(page=number, click=[scale * TABS[tab], top + scale * TABS_HEIGHT / 2])
        browser.ask(page=number, evaluate=f"void (() => {{{WATCH}}})()")
        time.sleep(2)
        usage = Usage(page["process"])
        heard, memory_mib = [], []
        begin, processor_s = time.time(), usage.processor_s()
        while time.time() < begin + asked.seconds:
            heard.append(status(url))
            if len(heard) % MEMORY_EVERY_S == 1:
                memory_mib.append(usage.memory_mib())
            time.sleep(1)
        end = time.time()
        processor_s = usage.processor_s() - processor_s
        seen = browser.ask(page=number, evaluate="window.seen")["value"]
        if asked.pictures:
            browser.ask(page=number, picture=f"{asked.pictures}/{tab}.png")
    shown, held = zip(*lags_s(seen, heard, begin, end))
    within = [1 for at, *_ in seen if begin <= at / 1e3 < end]
    return {
        "loading_s": loading_s,
        "updates_hz": len(within) / (end - begin),
        "processors": processor_s / (end - begin),
        "median_s": statistics.median(shown),
        "p99_s": statistics.quantiles(shown, n=100)[-1],
        "largest_s": max(shown),
        "held_median_s": statistics.median(held),
        "held_largest_s": max(held),
        "memory_mib": memory_mib,
    }


HEADS = ["tab", "other cores", "loaded after, s", "updates a second", "processors used"]
HEADS += ["lag shown: median, s", "99 %, s", "largest, s", "lag held: median, s", "largest, s"]
HEADS += ["memory, MiB: first", "half way", "last"]


def line(tab, load, measured):
    memory = measured["memory_mib"]
    figures = [measured["loading_s"], measured["updates_hz"], measured["processors"]]
    figures += [measured[name] for name in ("median_s", "p99_s", "largest_s", "held_median_s", "held_largest_s")]
    return [tab, load, *(f"{figure:.2f}" for figure in figures)] + [
        f"{mib:.0f}" for mib in (memory[0], memory[len(memory) // 2], memory[-1])
    ]


def goals(tab, load, measured):
    for name, figure, bar in zip(("median", "largest"), (measured["median_s"], measured["largest_s"]), BARS_S[load]):
        yield markdown.goal(f"{name} lag of *{tab}*, {load}", f"{figure:.2f} s", f"{bar} s", figure <= bar)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench-live-view", description=__doc__)
    parser.add_argument("--seconds", type=int, default=60, help="for how long each tab is followed (default 60)")
    parser.add_argument("--tab", choices=TABS, action="append", help="a tab to follow; several times for several (default all)")
    parser.add_argument("--only", choices=BARS_S, help="with the other cores left alone, or loaded (default both)")
    parser.add_argument("--rate-hz", type=int, default=10_000, help="rate of the capture (default 10000)")
    parser.add_argument("--size", type=int, nargs=2, default=[1600, 950], help="of the page, pixels (default 1600 950)")
    parser.add_argument("--pictures", help="folder for a picture of each tab at the end")
    asked = parser.parse_args()
    head = f"{markdown.machine()}; {asked.seconds} s a row at {asked.rate_hz} Hz, page of {asked.size[0]} by {asked.size[1]} pixels."
    lines, met = [], []
    for load in [asked.only] if asked.only else BARS_S:
        for tab in asked.tab or TABS:
            print(f"{tab}, other cores {load}", file=sys.stderr, flush=True)
            folder = Path(tempfile.mkdtemp(prefix="haptic-camera-bench-"))
            try:
                loaded = rig.load(max(rig.cores()), folder / "load") if load == "loaded" else contextlib.nullcontext()
                with loaded:
                    measured = measure(tab, asked, folder)
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            lines.append(line(tab, load, measured))
            met.extend(goals(tab, load, measured))
    markdown.keep("live-view", "\n\n".join([head, markdown.table(HEADS, lines), markdown.goals_table(met)]))


if __name__ == "__main__":
    main()
