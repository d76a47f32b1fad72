"""Records as HDF5: one file a record, flat columns and offsets, units in the attributes.

The root has the attributes `format` = "kinemark", `version` and `record`. What a field is follows from its type in the
record: an array is a dataset with its `unit`; texts and numbers are attributes; a record within is a group, and several
are groups 0, 1, … in one that says their `count`. Reading gives back the same record. A trial's C3D document
(`Trial.source`) is kept as the bytes of its file, so that a trial can go back into the format that it came from.

The HDF5 library can crash or hang on a damaged file. So the first 512 bytes, HDF5's user block, hold a checksum of all
the rest, and nothing but a file whose checksum is right is given to the library. Other programs skip the user block.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from ..data import (
    Analog,
    Cloud,
    Detections,
    Fills,
    ForcePlate,
    KinemarkError,
    MarkerTrajectory,
    Matches,
    Poses,
    Signal,
    Signals,
    Tracks,
    Trajectories,
    Trial,
)
from .c3d.document import C3D
from .c3d.reading import decode_document
from .c3d.writing import encode_document
from .files import replacing

FORMAT, VERSION = "kinemark", 1
SEAL, SEAL_SIZE = b"kinemark record, sha256 ", 512
"""First bytes of a record, and how many they are; of the format, ours."""
Record = Detections | Matches | Cloud | Tracks | Fills | Trajectories | Signals | Trial
RECORDS: dict[str, type[Record]] = {kind.__name__: kind for kind in get_args(Record)}
UNITS: dict[type, dict[str, str]] = {
    Detections: {"uv": "px", "cov": "px2", "area": "px2", "width": "px", "height": "px", "rate": "Hz"},
    Matches: {"cost": "px"},
    Cloud: {"xyz": "mm", "cov": "mm2", "residual": "px", "rate": "Hz"},
    Fills: {"xyz": "mm", "cov": "mm2"},
    Trajectories: {"rate": "Hz"},
    MarkerTrajectory: {"xyz": "mm", "cov": "mm2", "residual": "mm"},
    Signal: {"rate": "Hz", "start": "s"},
    Analog: {"rate": "Hz", "start": "s"},
    Poses: {"rate": "Hz", "start": "s"},
    ForcePlate: {"corners": "mm", "origin": "mm"},
}
"""Units of fields; the others have none, or say it beside them."""
SOURCE = "source_c3d"
"""Dataset of the bytes of a trial's C3D document."""
NOT_STORED = {(Trial, "source")}
ADDED = ("notes", "about", "ground_subtracted")
"""Fields that files of the first version lack."""
FORMER = {"detection": "view", "gaps": "told"}
"""Names that fields have in earlier files."""


def save(path: Path | str, record: Record) -> None:
    """Write a record as HDF5.

    Raises:
        ValueError: it is none of `RECORDS`.
        KinemarkError: the file cannot be written.
    """
    if type(record).__name__ not in RECORDS:
        raise ValueError(f"record is a {type(record).__name__}, wanted one of {', '.join(RECORDS)}")
    save_any(path, record)


def save_any(path: Path | str, record: object) -> None:
    """Write a record of any kind, of which a stage is the owner, as HDF5.

    Raises:
        KinemarkError: the file cannot be written.
    """
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


@cache
def fields_of(kind: Any) -> Mapping[str, Any]:
    """The fields of a record that are stored, with their types."""
    return {name: hint for name, hint in get_type_hints(kind).items() if (kind, name) not in NOT_STORED}


def named(kind: type, name: str) -> tuple[str, str]:
    """How an attribute is called, with its unit, and the unit of a dataset, "1" for none."""
    unit = UNITS.get(kind, {}).get(name)
    return (name, "1") if unit is None else (f"{name}_{unit}", unit)


def put(group: h5py.Group, record: object) -> None:
    """The fields of a record, into a group."""
    kind: Any = type(record)
    for name in fields_of(kind):
        value = getattr(record, name)
        attribute, unit = named(kind, name)
        if is_dataclass(value):
            put(group.create_group(name), value)
        elif isinstance(value, np.ndarray):
            group.create_dataset(name, data=value).attrs["unit"] = unit
        elif isinstance(value, tuple) and value and is_dataclass(value[0]):
            inner = group.create_group(name)
            inner.attrs["count"] = len(value)
            for i, one in enumerate(value):
                put(inner.create_group(str(i)), one)
        elif isinstance(value, tuple):
            group.attrs[name] = np.array(value, dtype=h5py.string_dtype())
        elif value is not None:
            group.attrs[attribute] = json.dumps(dict(value), default=plain) if isinstance(value, Mapping) else value
    if isinstance(record, Trial) and isinstance(record.source, C3D):
        group.create_dataset(SOURCE, data=np.frombuffer(encode_document(record.source), np.uint8)).attrs["unit"] = "1"


def plain(value: object) -> Any:
    """An array or record among a method's parameters, as JSON can hold it."""
    return value.tolist() if isinstance(value, np.ndarray) else repr(value)


def load(path: Path | str) -> Record:
    """Read a record that `save` wrote.

    Raises:
        KinemarkError: the file is absent, truncated, not ours, of a later version, or contradicts itself.
    """
    found: Record = load_any(path, RECORDS)
    return found


def load_any(path: Path | str, kinds: Mapping[str, type]) -> Any:
    """Read a record that `save_any` wrote and that is one of these kinds, by the name of its class.

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
            return whole_record(path, file, kinds)
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, IndexError, OverflowError) as error:
        raise KinemarkError(
            f"{path} is not a whole Kinemark record ({error}). Copy or export it again; if a run wrote it, delete it "
            "and run again."
        ) from error


def whole_record(path: Path, file: h5py.File, kinds: Mapping[str, type]) -> Any:
    """The record in an open file."""
    stated, version, kind = (file.attrs.get(name) for name in ("format", "version", "record"))
    if not isinstance(stated, str) or stated != FORMAT:
        raise KinemarkError(f"{path} is an HDF5 file but not of Kinemark. Check the path.")
    if kind not in kinds:
        raise KinemarkError(f"{path} holds {kind}, wanted {' or '.join(kinds)}. Check the path.")
    if int(version) != VERSION:
        raise KinemarkError(f"{path} has version {version}, wanted {VERSION}. Use the Kinemark that wrote it.")
    return get(file, kinds[str(kind)])


def get(group: h5py.Group, kind: type) -> Any:
    """A record of this kind from a group."""
    stored = {name: field(group, kind, name_in(group, name), hint) for name, hint in fields_of(kind).items()}
    if kind is Trial and SOURCE in group:
        stored["source"] = decode_document(
            column(group, SOURCE, np.dtype(np.uint8)).tobytes(), name=group.file.filename
        )
    return kind(**stored)


def name_in(group: h5py.Group, name: str) -> str:
    """What a field is called in this group, which may be of an earlier file."""
    former = FORMER.get(name, name)
    return former if former in group or former in group.attrs else name


def field(group: h5py.Group, kind: type, name: str, hint: Any) -> Any:
    """One field, as its type says."""
    attribute, _ = named(kind, name)
    options = [option for option in get_args(hint) if option is not NoneType]
    if get_origin(hint) is UnionType:
        return field(group, kind, name, options[0]) if name in group else None
    if get_origin(hint) is np.ndarray:
        return column(group, name, np.dtype(get_args(options[1])[0]))
    if get_origin(hint) is tuple:
        return tuple(rows(group, name, options[0]))
    if get_origin(hint) in (dict, Mapping):
        return json.loads(group.attrs.get(attribute, "{}") if name in ADDED else group.attrs[attribute])
    if fields_of(hint):
        return get(inside(group, name, h5py.Group), hint)
    return hint(group.attrs[attribute])


def rows(group: h5py.Group, name: str, kind: type) -> Iterator[Any]:
    """The texts or records of a field that has several."""
    if not is_dataclass(kind):
        texts = group.attrs.get(name, ()) if name in ADDED else group.attrs[name]
        yield from (str(text) for text in texts)
    elif name in group:
        inner = inside(group, name, h5py.Group)
        yield from (get(inside(inner, str(i), h5py.Group), kind) for i in range(int(inner.attrs["count"])))


def column(group: h5py.Group, name: str, dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
    """One dataset that lies in this file as a whole, so that a small file cannot unfold to a large array."""
    data = inside(group, name, h5py.Dataset)
    if data.dtype != dtype or data.is_virtual or data.external or data.compression or data.chunks:
        raise ValueError(f"{name} is stored in another way than Kinemark stores it")
    if data.id.get_storage_size() != data.size * data.dtype.itemsize:
        raise ValueError(f"{name} is not complete")
    return np.asarray(data[()])


def inside(group: h5py.Group, name: str, kind: type) -> Any:
    """A member that lies in this file itself, not behind a link to another."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink) or not isinstance(group[name], kind):
        raise KeyError(f"no {name}")
    return group[name]
