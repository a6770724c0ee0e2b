"""A table by Ray on two nodes, one of which is killed half way, beside `haptic-camera table` of the same folder.

Started by scripts/study-ray. Prints rows that differ, throughput, overhead and memory, and what a million captures cost.
"""

import resource
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pyarrow.parquet as parquet
import ray
from ray.cluster_utils import Cluster

import haptic_camera as hc
import ray_table

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/haptic-camera"

#: Length and rate of an archive, s and Hz, and the noise of its torque, mNm.
LENGTH_S, RATE_HZ, NOISE_MNM = 10.0, 5000.0, 0.2
MILLION = 1_000_000


def make(folder: Path, count: int) -> None:
    """Captures of knobs that all differ, and three damaged files among them."""
    motion = hc.capture(3, duration_s=LENGTH_S, rate_hz=RATE_HZ, offline=True, out=folder / "motion", program=PROGRAM)
    chance = np.random.default_rng(1)
    knobs = folder / "knobs"
    knobs.mkdir()
    for number in range(count - 3):
        knob = hc.Model.load(1 + number % 4)
        knob = knob.change(**{name: value * chance.uniform(0.8, 1.2) for name, value in knob.parameters.items()})
        made = hc.simulate(knob, motion)
        noisy = made.torque_mnm + chance.normal(0, NOISE_MNM, len(made))
        own = hc.Capture.from_columns(made.t_s, made.angle_rad, noisy, acceleration_rad_s2=made.acceleration_rad_s2)
        own.save(knobs / f"{number:05}.mcap")
    whole = (knobs / "00000.mcap").read_bytes()
    (knobs / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    (knobs / "empty.mcap").write_bytes(b"")
    (knobs / "foreign.csv").write_text("a,b\n1,2\n")


def by_table(folder: Path, out: Path) -> tuple[float, float]:
    """Seconds that the single machine's table took, and those that its processors worked on it."""
    start, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([PROGRAM, "table", folder, "--out", out], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seconds, now = time.monotonic() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime


def kill_when(condition: threading.Event, cluster: Cluster, node: object) -> None:
    """SIGKILL a node's raylet, and with it its workers, once it is time."""
    condition.wait()
    raylet = psutil.Process(node.all_processes["raylet"][0].process.pid)
    workers = raylet.children(recursive=True)
    raylet.kill()
    for worker in workers:
        worker.kill()
    print(f"killed the second node's raylet and its {len(workers)} processes")


def by_ray(folder: Path, out: Path, kill: bool) -> tuple[float, float, int]:
    """Seconds that the table took, head memory in MiB, and rows."""
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 200_000_000})
    second = cluster.add_node(num_cpus=1, object_store_memory=200_000_000)
    ray.init(address=cluster.address, log_to_driver=False)
    cluster.wait_for_nodes()
    half = threading.Event()
    killer = threading.Thread(target=kill_when, args=(half, cluster, second), daemon=True)
    killer.start()
    # Half way by the rows that are written: the writer is looked at from beside.
    real, written = ray_table.parquet.ParquetWriter.write_table, [0]
    total = sum(1 for file in folder.rglob("*") if file.suffix in (".mcap", ".csv"))

    def counted(writer: parquet.ParquetWriter, table: object) -> None:
        real(writer, table)
        written[0] += table.num_rows
        if kill and written[0] >= total / 2:
            half.set()

    ray_table.parquet.ParquetWriter.write_table = counted
    # The first tasks of a cluster wait for their workers to start, which is no part of a long run.
    ray.get([ray_table.remote_rows.remote([]) for _ in range(4)])
    start = time.monotonic()
    rows = ray_table.table(folder, out)
    seconds = time.monotonic() - start
    ray_table.parquet.ParquetWriter.write_table = real
    head = [process.process.pid for kind in ("gcs_server", "raylet") for process in cluster.head_node.all_processes[kind]]
    memory = sum(psutil.Process(pid).memory_info().rss for pid in head) / 2**20
    alive = sum(node["Alive"] for node in ray.nodes())
    print(f"nodes alive at the end: {alive}")
    ray.shutdown()
    cluster.shutdown()
    return seconds, memory, rows


def main(count: int) -> None:
    with tempfile.TemporaryDirectory(prefix="study-ray-", dir=ROOT / "target") as place:
        folder = Path(place)
        make(folder, count)
        knobs = folder / "knobs"
        size = sum(file.stat().st_size for file in knobs.iterdir())
        # Before and after Ray's, since a machine is seldom equally busy for long.
        before_s, worked_s = by_table(knobs, folder / "ours.parquet")
        undisturbed_s, memory, rows = by_ray(knobs, folder / "ray.parquet", kill=False)
        killed_s, _, _ = by_ray(knobs, folder / "killed.parquet", kill=True)
        after_s, _ = by_table(knobs, folder / "again.parquet")
        ours_s = (before_s + after_s) / 2
        ours = parquet.read_table(folder / "ours.parquet")
        for name in ("again.parquet", "ray.parquet", "killed.parquet"):
            theirs = parquet.read_table(folder / name)
            pairs = zip(ours.to_pylist(), theirs.to_pylist(), strict=True)
            different = sum(one != other for one, other in pairs)
            print(f"{name}: {theirs.num_rows} rows, {different} differ from the first table's")
        wrong = sum(error is not None for error in ours["error"].to_pylist())
        print(f"{rows} archives of {LENGTH_S:g} s at {RATE_HZ:g} Hz, {size / 1e6:.0f} MB; {wrong} with an error")
        for name, seconds in (("table", ours_s), ("Ray", undisturbed_s), ("Ray, a node killed", killed_s)):
            print(f"{name}: {seconds:.1f} s, {rows / seconds:.1f} captures a second")
        print(f"overhead of Ray: {100 * (undisturbed_s / ours_s - 1):.0f} %; head: {memory:.0f} MiB")
        row_bytes = (folder / "ours.parquet").stat().st_size / rows
        print(f"processors at work: {1e3 * worked_s / rows:.0f} ms a capture")
        print(
            f"a million such captures, from these figures: {size / rows * MILLION / 1e9:.0f} GB read, "
            f"{worked_s / rows * MILLION / 3600:.1f} core hours, a table of {row_bytes * MILLION / 1e6:.0f} MB; "
            f"{MILLION / ray_table.CAPTURES_A_TASK:.0f} tasks of Ray's"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]))
