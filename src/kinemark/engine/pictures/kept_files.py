"""Files that can be made again, kept in a folder up to so many bytes: those that were not used for longest go."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from ...data import KinemarkError
from ...io.files import replacing

Name = TypeVar("Name")


class KeptFiles:
    """Contents by name; in memory where the folder cannot be written. For any number of threads."""

    def __init__(self, folder: Path, *, most: int, most_in_memory: int) -> None:
        """Nothing is read yet; `most` and `most_in_memory` in bytes."""
        self.folder, self.most, self.most_in_memory = folder, most, most_in_memory
        self._lock = threading.Lock()
        self._sizes: dict[Path, int] | None = None  # of the files, the longest unused first
        self._memory: dict[str, bytes] = {}

    def get(self, name: str) -> bytes | None:
        """What is kept by this name; None where nothing is."""
        with self._lock:
            if name in self._memory:
                self._memory[name] = self._memory.pop(name)
                return self._memory[name]
            try:
                found = (self.folder / name).read_bytes()
            except OSError:
                return None
            self._used(self.folder / name, len(found))
            return found

    def put(self, name: str, content: bytes) -> None:
        """Keep it, and let go of what is too much."""
        file = self.folder / name
        with self._lock:
            try:
                file.parent.mkdir(parents=True, exist_ok=True)
                with replacing(file) as beside:
                    beside.write_bytes(content)
            except (KinemarkError, OSError):
                self._memory[name] = content
                for old in _too_many({one: len(held) for one, held in self._memory.items()}, self.most_in_memory):
                    del self._memory[old]
                return
            sizes = self._used(file, len(content))
            for unused in _too_many(sizes, self.most):
                del sizes[unused]
                with suppress(OSError):
                    unused.unlink()

    def _used(self, file: Path, size: int) -> dict[Path, int]:
        """The sizes, with this one last."""
        if self._sizes is None:
            there = sorted((found.stat().st_mtime_ns, found, found.stat().st_size) for found in self._files())
            self._sizes = {found: length for _, found, length in there}
        self._sizes.pop(file, None)
        self._sizes[file] = size
        return self._sizes

    def _files(self) -> Iterator[Path]:
        """Those that are there from before."""
        return (found for found in self.folder.rglob("*") if found.is_file())


def _too_many(sizes: dict[Name, int], most: int) -> list[Name]:
    """The first of them that must go for the rest to be as small; never the last."""
    total, names = sum(sizes.values()), list[Name]()
    for name, size in list(sizes.items())[:-1]:
        if total <= most:
            break
        total, names = total - size, [*names, name]
    return names
