"""TDF files built block by block."""

import struct

import numpy as np

SIGNATURE = bytes.fromhex("824b6041d31184ca6000b6ac16680c08")


def label(text):
    return text.encode().ljust(256, b"\0")


def floats(values, dtype="<f4"):
    return np.asarray(values, dtype).tobytes()


def segments(values):
    """A signal (n, width) with NaN rows as BTS stores it by track."""
    seen = np.flatnonzero(np.isfinite(values).all(1))
    runs = np.split(seen, np.flatnonzero(np.diff(seen) > 1) + 1) if len(seen) else []
    head = struct.pack("<ii", len(runs), 0) + b"".join(struct.pack("<ii", run[0], len(run)) for run in runs)
    return head + b"".join(floats(values[run]) for run in runs)


def tracks_block(form, xyz, names, start=0.0):
    head = struct.pack("<iifi", xyz.shape[1], 100, start, len(xyz)) + floats(np.zeros(15)) + struct.pack("<I", 0)
    links = struct.pack("<iiii", 1, 0, 0, 1) if form in (1, 3) else b""
    if form < 3:
        return head + links + b"".join(label(n) + segments(x) for n, x in zip(names, xyz, strict=True))
    stored = np.nan_to_num(xyz).transpose(1, 0, 2)
    return head + links + b"".join(map(label, names)) + floats(stored)


def write(path, *blocks, spare=2):
    """A TDF of (type, format, bytes) blocks with some empty entries."""
    offset = 64 + 288 * (len(blocks) + spare)
    head = SIGNATURE + struct.pack("<ii", 1, len(blocks) + spare) + bytes(40)
    for kind, form, data in blocks:
        head += struct.pack("<8i", kind, form, offset, len(data), 0, 0, 0, 0) + bytes(256)
        offset += len(data)
    path.write_bytes(head + bytes(288 * spare) + b"".join(data for *_, data in blocks))
    return path
