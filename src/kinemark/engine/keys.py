"""Keys made of content: two things have one key only where they are equal in every bit that matters.

The key of a stage is a hash of its name, its method and parameters, the package's own sources and the keys of its
inputs. A change anywhere makes new keys from there on, and an update of Kinemark never serves results of another
version.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from ..data import Rig

WHOLE = 64 << 20
"""Bytes. Files up to this size are read for their key; larger ones are known by parts, size and time of change.
Chosen."""

PARTS, PART = 64, 64 << 10
"""How many parts of a larger file are read, and their bytes: 4 MiB of any video; chosen."""

SOURCES = (".py", ".c", ".h", ".toml", ".html")
PAGE = "/apps/studio/page"
"""What the studio shows in the browser: no result depends on it."""


def digest(*parts: Any) -> str:
    """A hash of plain values, arrays, records and settings, however nested; the same on every machine.

    Raises:
        TypeError: a value is of a kind whose content is not known.
    """
    h = hashlib.sha256()
    for part in parts:
        _feed(h, part)
    return h.hexdigest()[:16]


def file_key(*paths: Path) -> str:
    """A key of the files' names and contents; absent files count by their absence."""
    return digest([(path.name, _content(path)) for path in paths])


def rig_key(rig: Rig) -> str:
    """A key of all that a rig says about geometry."""
    return digest([(c.name, c.size, c.K, c.distortion, c.R, c.t, c.cov, c.common) for c in rig], rig.volume)


@lru_cache(maxsize=8)
def world_key(rig: Rig) -> str:
    """A key of the world that a rig measures in: of where its cameras are, and of their optics, and nothing else."""
    return digest("world", [(c.name, c.K, c.distortion, c.R, c.t) for c in rig])


@cache
def code_key() -> str:
    """A key of the package's sources."""
    return digest(sorted((name, text) for name, text in _sources(files(__package__.split(".")[0]), "")))


def _sources(folder: Traversable, name: str) -> list[tuple[str, bytes]]:
    """Name and content of the sources in a folder of the package."""
    found = []
    for entry in folder.iterdir():
        if entry.is_dir() and f"{name}/{entry.name}" == PAGE:
            continue
        if entry.is_dir():
            found += _sources(entry, f"{name}/{entry.name}")
        elif entry.name.endswith(SOURCES):
            found.append((f"{name}/{entry.name}", entry.read_bytes()))
    return found


def _content(path: Path) -> str | None:
    """A key of what is in a file; None where there is none."""
    if not path.is_file():
        return None
    state = path.stat()
    return _read_content(path, state.st_size, state.st_mtime_ns)


@cache
def _read_content(path: Path, size: int, changed: int) -> str:
    """The key of a file of this size and time of change, read once a process."""
    with path.open("rb") as file:
        if size <= WHOLE:
            return hashlib.sha256(file.read()).hexdigest()
        h = hashlib.sha256(f"{size} {changed}".encode())
        for at in np.linspace(0, size - PART, PARTS).astype(np.int64).tolist():
            file.seek(at)
            h.update(file.read(PART))
        return h.hexdigest()


def _feed(h: Any, value: Any) -> None:
    """A value's kind and content; what it holds follows between brackets, so that no two nestings are alike."""
    if value is None or isinstance(value, (bool, int, float, str, bytes)):
        h.update(f"{type(value).__name__}:{value!r};".encode())
    elif isinstance(value, np.ndarray) and value.dtype.kind in "OV":
        raise TypeError(f"an array of {value.dtype} has no key; wanted numbers, truth values or text")
    elif isinstance(value, (np.ndarray, np.generic)):
        h.update(f"array:{value.dtype.str}{np.shape(value)};".encode())
        h.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, Path):
        h.update(f"path:{value.as_posix()!r};".encode())
    elif isinstance(value, Enum):
        h.update(f"{type(value).__name__}.{value.name};".encode())
    else:
        h.update(f"{type(value).__name__}(".encode())
        for part in _parts(value):
            _feed(h, part)
        h.update(b")")


def _parts(value: Any) -> Sequence[Any]:
    """What a nested value holds, in an order that does not depend on the process."""
    if isinstance(value, BaseModel):
        return [(name, getattr(value, name)) for name in type(value).model_fields]
    if is_dataclass(value) and not isinstance(value, type):
        return [(f.name, getattr(value, f.name)) for f in fields(value)]
    if isinstance(value, Mapping):
        return sorted(value.items(), key=repr)
    if isinstance(value, (set, frozenset)):
        return sorted(value, key=repr)
    if isinstance(value, (list, tuple)):
        return value
    raise TypeError(f"{type(value).__name__} has no key; wanted plain values, arrays, records or settings")
