"""Writing so that nothing half-written is ever left, and reading so that the limits are known."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..data import KinemarkError

ADVICE = {
    errno.ENOSPC: "The disk is full: make room and do it again. What was finished before is kept.",
    errno.EDQUOT: "Your share of the disk is used up: make room and do it again. What was finished before is kept.",
    errno.EROFS: "The folder is read-only: choose one that you may write to.",
}
OTHERWISE = "Choose a folder that you may write to."
"""What to do when a file cannot be written."""


@contextmanager
def replacing(path: Path | str) -> Iterator[Path]:
    """A temporary path beside `path`, renamed to it when the block ends well and removed when it does not.

    Raises:
        KinemarkError: the folder cannot be written.
    """
    path = Path(path)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield beside
        beside.replace(path)
    except OSError as error:
        raise KinemarkError(f"{path} cannot be written: {error}. {ADVICE.get(error.errno or 0, OTHERWISE)}") from error
    finally:
        with suppress(OSError):  # such as a parent that is a file, which the error above has stated already
            beside.unlink(missing_ok=True)


def write_text(path: Path | str, text: str) -> None:
    """Write a file in UTF-8, whole or not at all; lines end as in the text.

    Raises:
        KinemarkError: the file cannot be written.
    """
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path | str, value: Mapping[str, Any]) -> None:
    """The same of figures as indented JSON; raises as `write_text`."""
    write_text(path, json.dumps(value, indent=1) + "\n")


def read_json(path: Path) -> dict[str, Any]:
    """The figures of a file; none where it is absent, damaged, or holds something else."""
    try:
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def check_new(path: Path) -> None:
    """Raises KinemarkError where the file is there already: nothing is overwritten."""
    if path.exists():
        raise KinemarkError(f"{path} exists, and nothing is overwritten. Name another file or remove it.")


def read_bytes(path: Path | str, *, most: int = 2 << 30) -> bytes:
    """The whole of a file.

    Raises:
        KinemarkError: it is absent, a folder, empty, unreadable or larger than `most` bytes.
    """
    path = Path(path)
    if not path.is_file():
        raise KinemarkError(f"{path} is not a file. Check the path.")
    size = path.stat().st_size
    if size == 0:
        raise KinemarkError(f"{path} is empty. Export or copy it again.")
    if size > most:
        raise KinemarkError(f"{path} has {size} bytes; the most that is read is {most}. Split the recording.")
    try:
        return path.read_bytes()
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error}") from error
