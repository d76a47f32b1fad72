"""What passes between stages, as HDF5: one file a record, flat columns and offsets, units in the attributes.

The root has the attributes `format` = "kinemark", `version` and `record`; a column is a dataset with its `unit`;
names, rates and counts are attributes; the cloud of `Tracks` is a group. Reading gives back the same record.

The HDF5 library can crash or hang on a damaged file. So the first 512 bytes, HDF5's user block, hold a checksum of all
the rest, and nothing but a file whose checksum is right is given to the library. Other programs skip the user block.
"""

from __future__ import annotations

import hashlib
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..data import Cloud, Detections, Fills, KinemarkError, Matches, Tracks
from .files import replacing

FORMAT, VERSION = "kinemark", 1
SEAL, SEAL_SIZE = b"kinemark record, sha256 ", 512
Record = Detections | Matches | Cloud | Tracks | Fills
RECORDS: dict[str, type[Record]] = {kind.__name__: kind for kind in (Detections, Matches, Cloud, Tracks, Fills)}
TYPES: dict[type[Record], dict[str, str]] = {
    Detections: {"start": "i8", "validity": "u1", "merged": "b1"},
    Matches: {"frame": "i8", "view": "i8"},
    Cloud: {"start": "i8", "view": "i8"},
    Tracks: {"id": "i8"},
    Fills: {"marker": "i8", "frame": "i8", "cameras": "u4"},
}
UNITS: dict[type[Record], dict[str, str]] = {
    Detections: {"uv": "px", "cov": "px2", "area": "px2", "width": "px", "height": "px", "rate": "Hz"},
    Matches: {"cost": "px"},
    Cloud: {"xyz": "mm", "cov": "mm2", "residual": "px", "rate": "Hz"},
    Tracks: {},
    Fills: {"xyz": "mm", "cov": "mm2"},
}
TEXTS = {(Detections, "cameras"), (Fills, "told")}
REALS, INTEGERS = ("rate",), ("n_frames",)


def save(path: Path | str, record: Record) -> None:
    """Write a record as HDF5.

    Raises:
        ValueError: it is none of `RECORDS`.
        KinemarkError: the file cannot be written.
    """
    if type(record) not in TYPES:
        raise ValueError(f"record is a {type(record).__name__}, wanted one of {', '.join(RECORDS)}")
    with replacing(path) as beside:
        with h5py.File(beside, "w", userblock_size=SEAL_SIZE) as file:
            file.attrs.update({"format": FORMAT, "version": VERSION, "record": type(record).__name__})
            put(file, record)
        seal(beside)


def seal(path: Path) -> None:
    """Write the checksum of a file into its user block."""
    digest = checksum(path)
    with path.open("r+b") as file:
        file.write((SEAL + digest + b"\n").ljust(SEAL_SIZE, b"\0"))


def checksum(path: Path) -> bytes:
    """SHA-256 of all that follows the user block, in hexadecimal."""
    with path.open("rb") as file:
        file.seek(SEAL_SIZE)
        return hashlib.file_digest(file, "sha256").hexdigest().encode()


def sealed(path: Path) -> bool:
    """Whether a file has a seal, and is what was sealed.

    Raises:
        KinemarkError: it has none, so it is not one of ours.
    """
    with path.open("rb") as file:
        start = file.read(SEAL_SIZE)
    if start and not start.startswith(SEAL):
        raise KinemarkError(f"{path} is not a file that Kinemark wrote. Check the path.")
    return start[len(SEAL) :].rstrip(b"\n\0") == checksum(path)


def put(group: h5py.Group, record: Record) -> None:
    """The fields of a record, into a group."""
    for name in (f.name for f in fields(record)):
        value = getattr(record, name)
        unit = UNITS[type(record)].get(name)
        if isinstance(value, Cloud):
            put(group.create_group(name), value)
        elif isinstance(value, tuple):
            group.attrs[name] = np.array(value, dtype=h5py.string_dtype())
        elif name in REALS + INTEGERS:
            group.attrs[name if unit is None else f"{name}_{unit}"] = value
        else:
            group.create_dataset(name, data=value).attrs["unit"] = unit or "1"


def load(path: Path | str) -> Record:
    """Read a record that `save` wrote.

    Raises:
        KinemarkError: the file is absent, truncated, not ours, of a later version, or contradicts itself.
    """
    path = Path(path)
    if not path.is_file():
        raise KinemarkError(f"{path} is not a file. Check the path.")
    try:
        if not sealed(path):
            raise ValueError("it is truncated or damaged")
        with h5py.File(path, "r") as file:
            return whole_record(path, file)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, IndexError, OverflowError) as error:
        raise KinemarkError(
            f"{path} is not a whole Kinemark record ({error}). Delete it and run the stage that writes it again."
        ) from error


def whole_record(path: Path, file: h5py.File) -> Record:
    """The record in an open file."""
    stated, version, kind = (file.attrs.get(name) for name in ("format", "version", "record"))
    if not isinstance(stated, str) or stated != FORMAT or kind not in RECORDS:
        raise KinemarkError(f"{path} is an HDF5 file but not of Kinemark. Check the path.")
    if int(version) != VERSION:
        raise KinemarkError(f"{path} has version {version}, wanted {VERSION}. Use the Kinemark that wrote it.")
    return get(file, RECORDS[str(kind)])


def get(group: h5py.Group, kind: type[Record]) -> Record:
    """A record of this kind from a group."""
    values: dict[str, Any] = {}
    for name in (f.name for f in fields(kind)):
        unit = UNITS[kind].get(name)
        if name == "cloud":
            values[name] = get(inside(group, name, h5py.Group), Cloud)
        elif (kind, name) in TEXTS:
            values[name] = tuple(str(text) for text in group.attrs[name])
        elif name in REALS:
            values[name] = float(group.attrs[f"{name}_{unit}"])
        elif name in INTEGERS:
            values[name] = int(group.attrs[name])
        else:
            values[name] = column(group, name, TYPES[kind].get(name, "f8"))
    return kind(**values)


def column(group: h5py.Group, name: str, dtype: str) -> np.ndarray[Any, Any]:
    """One dataset that lies in this file as a whole, so that a small file cannot unfold to a large array."""
    data = inside(group, name, h5py.Dataset)
    if data.dtype != np.dtype(dtype) or data.is_virtual or data.external or data.compression or data.chunks:
        raise ValueError(f"{name} is stored in another way than Kinemark stores it")
    if data.id.get_storage_size() != data.size * data.dtype.itemsize:
        raise ValueError(f"{name} is not complete")
    return np.asarray(data[()])


def inside(group: h5py.Group, name: str, kind: type) -> Any:
    """A member that lies in this file itself, not behind a link to another."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink) or not isinstance(group[name], kind):
        raise KeyError(f"no {name}")
    return group[name]
