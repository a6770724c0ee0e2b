#!/usr/bin/env python3
"""Reads a capture with the ROS 2 tools' own decoder and prints what it holds.

    check-archive.py CAPTURE.mcap [COLUMNS.bin]

Nothing of the haptic camera is used: the messages are decoded by mcap-ros2-support from the
schemas in the file. Printed is one `key value` per line: `count`, `first_seq`, `last_seq`,
`missing` (samples absent between 0 and the last), `other_messages`, and `sha256`, the digest of all
samples' real columns in the order angle, velocity, acceleration, torque, commanded angle, commanded
torque, each sample packed as six little-endian doubles. With COLUMNS.bin those doubles are also
written there, for a comparison to the last bit. Exit status: 0 whole, 3 samples missing or
repeated, 1 not readable.

Needs the packages mcap and mcap-ros2-support.
"""

import hashlib
import struct
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

COLUMNS = (
    "angle_rad",
    "velocity_rad_s",
    "acceleration_rad_s2",
    "torque_mnm",
    "commanded_angle_rad",
    "commanded_torque_mnm",
)


def main(path: str, columns_path: str | None) -> int:
    packed = bytearray()
    seqs = []
    others = 0
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()], validate_crcs=True)
        summary = reader.get_summary()
        for _schema, channel, _message, decoded in reader.iter_decoded_messages():
            if channel.topic != "/sample":
                others += 1
                continue
            seqs.append(decoded.seq)
            packed += struct.pack("<6d", *(getattr(decoded, column) for column in COLUMNS))
        names = [attachment.name for attachment in reader.iter_attachments()]
        records = [metadata.name for metadata in reader.iter_metadata()]
    rising = all(later > earlier for earlier, later in zip(seqs, seqs[1:]))
    missing = seqs[-1] + 1 - len(set(seqs)) if seqs else 0
    print("count", len(seqs))
    print("first_seq", seqs[0] if seqs else "none")
    print("last_seq", seqs[-1] if seqs else "none")
    print("missing", missing)
    print("in_order", "yes" if rising else "no")
    print("other_messages", others)
    print("indexed_messages", summary.statistics.message_count if summary and summary.statistics else "none")
    print("attachments", ",".join(names))
    print("metadata", ",".join(records))
    print("sha256", hashlib.sha256(packed).hexdigest())
    if columns_path:
        with open(columns_path, "wb") as stream:
            stream.write(packed)
    return 0 if rising and missing == 0 else 3


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    try:
        sys.exit(main(sys.argv[1], sys.argv[2] if len(sys.argv) == 3 else None))
    except (OSError, ValueError, KeyError) as error:
        print(f"{sys.argv[1]}: {error!r}", file=sys.stderr)
        sys.exit(1)
