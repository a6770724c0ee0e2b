"""Fit a folder of captures on a Ray cluster: the rows of ``haptic-camera table``, in the same order.

    ray start --head                                # on one machine
    ray start --address=HEAD:6379                   # on each other one; all of them have the wheel and see the folder
    python ray_table.py /shared/captures table.parquet

Ray schedules the tasks, moves their rows, and does again what a machine that dies was doing.
"""

import sys
from pathlib import Path

import pyarrow
import pyarrow.parquet as parquet
import ray

import haptic_camera as hc

#: Captures that a task fits: enough that Ray's own work on it is small beside them, few enough to be done again.
CAPTURES_A_TASK = 8

ARROW = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}
SCHEMA = pyarrow.schema([(name, ARROW[kind]) for name, kind in hc.table_columns().items()])


def rows(files: list[str]) -> pyarrow.Table:
    """The rows of some captures; a file that cannot be read or fitted is a row that says why."""
    return pyarrow.Table.from_pylist([hc.table_row(file) for file in files], schema=SCHEMA)


# A machine that dies is no fault of the task: it is done again however often that happens.
remote_rows = ray.remote(num_cpus=1, max_retries=-1)(rows)


def table(folder: Path, out: Path) -> int:
    """Write the table of a folder; gives the number of its rows."""
    files = sorted(str(file) for file in folder.rglob("*") if file.suffix in (".mcap", ".csv"))
    chunks = [files[first : first + CAPTURES_A_TASK] for first in range(0, len(files), CAPTURES_A_TASK)]
    made = [remote_rows.remote(chunk) for chunk in chunks]
    with parquet.ParquetWriter(out, SCHEMA) as writer:
        while made:
            writer.write_table(ray.get(made.pop(0)))
    return len(files)


if __name__ == "__main__":
    ray.init(address="auto")
    print(table(Path(sys.argv[1]), Path(sys.argv[2])), "captures")
