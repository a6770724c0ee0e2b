"""MCAP archives that no recorder writes (https://mcap.dev/spec), and good ones broken."""

import json
import math
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, METADATA, DATA_END = 1, 2, 3, 4, 5, 6, 9, 12, 15
FIELDS = "uint64 seq\nuint64 tick\nfloat64 angle_rad\nfloat64 torque_mnm\n"


def u16(value):
    return struct.pack("<H", value)


def u32(value):
    return struct.pack("<I", value)


def u64(value):
    return struct.pack("<Q", value)


def text(words):
    words = words.encode() if isinstance(words, str) else words
    return u32(len(words)) + words


def record(opcode, body, length=None):
    return bytes([opcode]) + u64(len(body) if length is None else length) + body


def entries(pairs):
    body = b"".join(text(key) + text(value) for key, value in pairs.items())
    return u32(len(body)) + body


def schema(words=FIELDS, number=1):
    return record(SCHEMA, u16(number) + text("sample") + text("ros2msg") + text(words))


def channel(topic="/sample", number=1, schema_number=1):
    return record(CHANNEL, u16(number) + u16(schema_number) + text(topic) + text("cdr") + entries({}))


def message(body, number=1, time_ns=0):
    return record(MESSAGE, u16(number) + u32(0) + u64(time_ns) * 2 + b"\0\1\0\0" + body)


def sample(seq, tick, angle_rad, torque_mnm):
    return message(struct.pack("<QQdd", seq % 2**64, tick % 2**64, angle_rad, torque_mnm), time_ns=seq % 2**63)


def chunk(records, compression="", stored=None, unpacked=None, checksum=None):
    stored = records if stored is None else stored
    checksum = zlib.crc32(records) if checksum is None else checksum
    unpacked = len(records) if unpacked is None else unpacked
    return record(CHUNK, u64(0) * 2 + u64(unpacked) + u32(checksum) + text(compression) + u64(len(stored)) + stored)


def attachment(name, content):
    body = u64(0) * 2 + text(name) + text("text/plain") + u64(len(content)) + content
    return record(ATTACHMENT, body + u32(zlib.crc32(body)))


def metadata(name, pairs):
    return record(METADATA, text(name) + entries(pairs))


def whole(*records, rate_hz="10000"):
    rate = metadata("capture", {"rate_hz": str(rate_hz)})
    end = record(DATA_END, u32(0)) + record(FOOTER, u64(0) * 2 + u32(0)) + MAGIC
    return MAGIC + record(HEADER, text("") * 2) + b"".join(records) + rate + end


def runs_of_bytes(*parts):
    """A zstd frame (RFC 8878) whose blocks each repeat one byte, or hold their bytes as they are."""
    blocks = []
    for part in parts:
        byte, count = part if isinstance(part, tuple) else (None, len(part))
        while count > 0:
            size = min(count, 128 * 1024)
            if byte is None:
                blocks.append((0, size, part[len(part) - count:][:size]))
            else:
                blocks.append((1, size, byte))
            count -= size
    length = sum(size for _, size, _ in blocks)
    frame = b"\x28\xb5\x2f\xfd\xe0" + u64(length)
    for index, (kind, size, content) in enumerate(blocks):
        last = index + 1 == len(blocks)
        frame += struct.pack("<I", last | kind << 1 | size << 3)[:3] + content
    return frame


def packed(*parts):
    """A chunk of such a frame, and its records unpacked."""
    records = b"".join(part[0] * part[1] if isinstance(part, tuple) else part for part in parts)
    return chunk(records, "zstd", runs_of_bytes(*parts))


def motion(rows, rate_hz):
    """Rows of a knob with detents, turned to and fro: angle in rad and torque in mNm."""
    for row in range(rows):
        t_s = row / rate_hz
        angle_rad = 2.0 * math.sin(5.0 * t_s + 3.0 * t_s * t_s)
        yield row, angle_rad, 3.0 * math.sin(24.0 * angle_rad) + math.copysign(2.0, math.cos(5.0 * t_s))


def samples(rows=3000, change=lambda row: row):
    made = (change((row, row, angle_rad, torque_mnm)) for row, angle_rad, torque_mnm in motion(rows, 10_000))
    return b"".join(sample(*row) for row in made)


def capture(*more, rows=3000, change=lambda row: row, rate_hz="10000"):
    return whole(*more, chunk(schema() + channel() + samples(rows, change)), rate_hz=rate_hz)


def with_value(place, value, at=None):
    """Changes one column: everywhere, or in the row `at`."""
    def change(row):
        row = list(row)
        if at is None or row[0] == at:
            row[place] = value
        return row
    return change


def schema_of_names(length, count):
    """A schema in which `count` fields have names of `length` letters, in few bytes of file."""
    before = b"p/T[%d] " % count
    after = b"\n===\nMSG: p/T\nuint64 x\n"
    words = len(before) + length + len(after)
    head = u16(1) + text("sample") + text("ros2msg") + u32(words)
    start = bytes([SCHEMA]) + u64(len(head) + words) + head + before
    return whole(packed(start, (b"a", length), after, channel()))


def run_json(**changed):
    run = {
        "run_id": 7, "software_version": "0.1.0", "apparatus": "sim", "knob": "3", "rate_hz": 10000.0,
        "planned_ticks": 3000, "clock": {"monotonic_time_ns": 0, "wall_clock_time_ns": 1_700_000_000_000_000_000},
        "realtime": 0, "excitation_toml": "", "calibration_toml": "", "simulated_knob_toml": None,
        "rendered_model_toml": None, "control_toml": None, "notes": [],
    }
    return attachment("run.json", json.dumps(run | changed).encode())


def broken(good, share=None, flip=None, hole=None):
    """A good archive cut off, with a bit flipped, or with a hole of zeros."""
    if share is not None:
        return good[: int(share * len(good))]
    content = bytearray(good)
    if flip is not None:
        content[int(flip * len(good))] ^= 16
    if hole is not None:
        start = int(hole * len(good))
        content[start : start + 4096] = bytes(len(content[start : start + 4096]))
    return bytes(content)


def nested_chunks(count, kind):
    """Headers of chunks or attachments, each of which claims all that follows."""
    size = 65 if kind == CHUNK else 80
    content = b""
    for index in range(count):
        rest = (count - index - 1) * size
        if kind == CHUNK:
            head = u64(0) * 2 + u64(rest + 8) + u32(1) + text("") + u64(rest + 8)
            content += record(CHUNK, head, len(head) + rest + 8) + bytes(size - 9 - len(head))
        else:
            head = u64(0) * 2 + text("a") + text("b") + u64(rest + 8)
            content += record(ATTACHMENT, head, len(head) + rest + 12) + bytes(size - 9 - len(head))
    return MAGIC + content + b"\1" * 12


def archives(good):
    """Every archive by its name."""
    sound = schema() + channel() + samples(500)
    tower = "".join(f"===\nMSG: p/L{level}\np/L{level + 1}[99] x\n" for level in range(10))
    made = {
        "empty.mcap": b"",
        "magic.mcap": MAGIC,
        "magic-cut.mcap": MAGIC[:5],
        "magic-twice.mcap": MAGIC * 2,
        "text.mcap": b"hello\n",
        "doubled.mcap": good + good,
        "reversed.mcap": good[::-1],
        "with-garbage-behind.mcap": good + b"\xff" * 5000,
        "with-garbage-before.mcap": b"\xff" * 5000 + good,
        "nothing-in-it.mcap": whole(),
        "no-samples.mcap": whole(chunk(schema() + channel())),
        "no-schema.mcap": whole(chunk(channel() + samples(9))),
        "no-channel.mcap": whole(chunk(samples(9))),
        "one-sample.mcap": capture(rows=1),
        "short.mcap": capture(rows=150),
        "sound.mcap": capture(),
        "no-fields.mcap": whole(chunk(schema("") + channel() + samples(9))),
        "no-torque.mcap": whole(chunk(schema(FIELDS.replace("torque_mnm", "tork")) + channel() + samples(9))),
        "fields-beyond-body.mcap": whole(chunk(schema("uint64[99] pad\n" + FIELDS) + channel() + samples(9))),
        "fields-far-beyond.mcap": whole(chunk(schema(f"uint64[{2**60}] pad\n" + FIELDS) + channel() + samples(9))),
        "schema-of-text.mcap": whole(chunk(schema("string seq\n") + channel() + samples(9))),
        "schema-no-sense.mcap": whole(chunk(schema("\x1b[31m what is this\n\n\n") + channel())),
        "schema-towering.mcap": whole(chunk(schema(f"p/L0 x\n{tower}===\nMSG: p/L10\n") + channel())),
        "schema-recursive.mcap": whole(chunk(schema("p/A x\n===\nMSG: p/A\np/A x\n") + channel())),
        "schema-many-fields.mcap": whole(chunk(schema(f"p/A[{10**9}] x\n===\nMSG: p/A\nuint8 x\n") + channel())),
        "schema-empty-fields.mcap": whole(chunk(schema(f"p/A[{10**18}] x\n===\nMSG: p/A\n# no\n") + channel())),
        "schema-long-names.mcap": schema_of_names(60_000, 99_000),
        "schema-longer-names.mcap": schema_of_names(200_000, 99_000),
        "schema-one-long-name.mcap": schema_of_names(60_000_000, 1),
        "many-schemas.mcap": whole(packed(*[p for n in range(400) for p in (
            bytes([SCHEMA]) + u64(30 + 100_000) + u16(n + 1) + text("sample") + text("ros2msg") + u32(100_000 + 5)
            + b"\n\n\n\n\n", (b"#", 100_000))])),
        "many-channels.mcap": whole(chunk(schema() + b"".join(channel(number=n) for n in range(60_000)))),
        "channel-repeated.mcap": whole(chunk(schema() + channel() * 100_000 + samples(500))),
        "channels-with-tower.mcap": whole(chunk(
            schema(FIELDS + f"p/A[{10**9}] x\n===\nMSG: p/A\n# no\n")
            + b"".join(channel(number=n) for n in range(20_000)))),
        "chunk-claims-more.mcap": whole(chunk(sound, unpacked=2**40)),
        "chunk-claims-most.mcap": whole(chunk(sound, unpacked=2**64 - 1)),
        "chunk-claims-256-mib.mcap": whole(chunk(sound, unpacked=2**28)),
        "chunk-claims-less.mcap": whole(chunk(sound, unpacked=9)),
        "chunk-wrong-checksum.mcap": whole(chunk(sound, checksum=1)),
        "chunk-no-checksum.mcap": whole(chunk(sound, checksum=0)),
        "chunk-unknown-compression.mcap": whole(chunk(sound, compression="brotli")),
        "chunk-no-zstd.mcap": whole(chunk(sound, compression="zstd")),
        "chunk-no-lz4.mcap": whole(chunk(sound, compression="lz4")),
        "chunk-in-chunk.mcap": whole(chunk(chunk(sound))),
        "chunks-of-one.mcap": whole(chunk(schema() + channel()), *[
            chunk(sample(*row[:1], *row)) for row in motion(3000, 10_000)]),
        "record-of-2-to-40.mcap": whole(record(CHUNK, b"abc", 2**40)),
        "record-of-2-to-63.mcap": whole(record(CHUNK, b"abc", 2**63)),
        "record-of-255-mib.mcap": whole(record(METADATA, b"abc", 255 << 20)),
        "record-longer-than-chunk.mcap": whole(chunk(schema() + record(MESSAGE, b"abc", 2**40))),
        "attachment-of-2-to-40.mcap": whole(record(ATTACHMENT, u64(0) * 2 + text("a") + text("b") + u64(2**40))),
        "attachment-lengths.mcap": whole(record(ATTACHMENT, u64(0) * 2 + u32(2**32 - 1) * 3)),
        "zeros-256-mib.mcap": whole(packed((b"\0", 255 << 20))),
        "zeros-64-mib-8-times.mcap": whole(*[packed((b"\0", 63 << 20))] * 8),
        "zeros-in-attachment.mcap": whole(attachment("run.json", bytes(1 << 20)), chunk(sound)),
        "nested-chunks.mcap": nested_chunks(20_000, CHUNK),
        "nested-attachments.mcap": nested_chunks(20_000, ATTACHMENT),
        "rate-0.mcap": capture(rate_hz="0"),
        "rate-nan.mcap": capture(rate_hz="nan"),
        "rate-negative.mcap": capture(rate_hz="-1"),
        "rate-1e300.mcap": capture(rate_hz="1e300"),
        "rate-1e-300.mcap": capture(rate_hz="1e-300"),
        "rate-1e12.mcap": capture(rate_hz="1e12"),
        "rate-3.mcap": capture(rate_hz="3"),
        "seq-largest.mcap": capture(change=with_value(0, 2**64 - 1, at=1500)),
        "tick-largest.mcap": capture(change=with_value(1, 2**64 - 1, at=2999)),
        "tick-apart.mcap": capture(change=lambda row: (row[0], row[1] * 10**9, *row[2:])),
        "tick-still.mcap": capture(change=with_value(1, 5)),
        "seq-gaps.mcap": capture(change=lambda row: (row[0] * 7, *row[1:])),
        "angle-nan.mcap": capture(change=with_value(2, math.nan, at=100)),
        "angle-inf.mcap": capture(change=with_value(2, math.inf, at=100)),
        "angle-1e308.mcap": capture(change=with_value(2, 1e308, at=100)),
        "angle-still.mcap": capture(change=with_value(2, 0.5)),
        "torque-nan.mcap": capture(change=with_value(3, math.nan)),
        "torque-1e308.mcap": capture(change=with_value(3, -1e308, at=100)),
        "torque-constant.mcap": capture(change=with_value(3, 7.0)),
        "gaps-of-2-to-64.mcap": capture(metadata("gaps", {"gaps": json.dumps([
            {"first_missing_seq": 0, "last_missing_seq": 2**64 - 1, "count": 2**64 - 1}] * 3)})),
        "gaps-no-json.mcap": capture(metadata("gaps", {"gaps": "[" * 100_000})),
        "run-no-json.mcap": capture(attachment("run.json", b"{" * 100_000)),
        "run-of-escapes.mcap": capture(run_json(
            knob="\x1b]0;owned\x07\x1b[2J\u202e3", apparatus="\x9b31m", software_version="\r\n\x1b[1A",
            notes=[["\x1b[31m", "\x1b[5m"]])),
        "run-rate-1e300.mcap": capture(run_json(rate_hz=1e300)),
        "run-time-largest.mcap": capture(run_json(
            clock={"monotonic_time_ns": 2**64 - 1, "wall_clock_time_ns": 2**64 - 1}, planned_ticks=2**64 - 1)),
        "run-knob-of-megabytes.mcap": capture(run_json(knob="x" * 5_000_000)),
        "calibration-nan.mcap": capture(attachment("calibration.toml", b"gripper_inertia = nan\n")),
        "calibration-of-escapes.mcap": capture(attachment("calibration.toml", b"\x1b[31m = 3\n")),
        "model-of-escapes.mcap": capture(attachment("model.toml", b"[[effects]]\neffect = '\xc2\x9b31m'\n")),
        "model-of-megabytes.mcap": capture(attachment("model.toml", b"x" * 5_000_000)),
        "replay-no-control.mcap": capture(run_json(rendered_model_toml="", control_toml="")),
    }
    for share in (0.001, 0.01, 0.1, 0.5, 0.9, 0.999):
        made[f"cut-at-{share}.mcap"] = broken(good, share=share)
    for flip in (0.0005, 0.002, 0.005, 0.03, 0.2, 0.5, 0.8, 0.97, 0.995, 0.9995):
        made[f"flip-at-{flip}.mcap"] = broken(good, flip=flip)
    for hole in (0.0, 0.3, 0.7, 0.99):
        made[f"hole-at-{hole}.mcap"] = broken(good, hole=hole)
    return made
