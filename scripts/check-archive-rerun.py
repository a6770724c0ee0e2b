#!/usr/bin/env python3
"""Reads a capture through rerun's own MCAP importer and writes its columns for a comparison to the last bit.

    check-archive-rerun.py CAPTURE.mcap COLUMNS.bin

Written are six little-endian doubles a sample in the order of `seq`: angle, velocity, acceleration, torque,
commanded angle, commanded torque. Needs the package rerun-sdk[datafusion].
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyarrow as pa
from rerun.server import Server

COLUMNS = (
    "angle_rad",
    "velocity_rad_s",
    "acceleration_rad_s2",
    "torque_mnm",
    "commanded_angle_rad",
    "commanded_torque_mnm",
)


def main(capture, columns):
    with tempfile.TemporaryDirectory() as folder:
        recording = os.path.join(folder, "capture.rrd")
        rerun = Path(sys.executable).with_name("rerun")
        subprocess.run([rerun, "mcap", "convert", capture, "-o", recording], check=True, capture_output=True)
        with Server(datasets={"capture": [recording]}) as server:
            client = server.client()
            dataset = client.get_dataset("capture")
            table = dataset.reader(index="message_log_time").to_arrow_table()
    messages = table.column("/sample:haptic_camera.msg.Sample:message").combine_chunks()
    while pa.types.is_list(messages.type):
        messages = messages.drop_null().flatten()
    values = np.stack([messages.field(name).to_numpy() for name in COLUMNS], axis=1)
    order = np.argsort(messages.field("seq").to_numpy(), kind="stable")
    values[order].astype("<f8").tofile(columns)
    print(f"count {len(values)}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
