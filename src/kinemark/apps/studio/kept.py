"""What is opened once for several requests, and again when what it was made of has changed."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Generic, TypeVar

T = TypeVar("T")
MOST = 4
"""That are kept; chosen, as trials that lie open."""


class Kept(Generic[T]):
    """Values by keys, the last used ones; each with a stamp of what it was made of."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, tuple[Hashable, T]] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: str, stamp: Hashable, make: Callable[[], T]) -> T:
        """That of a key, made where it is not there or was made of something else; raises what making it does."""
        with self._lock:
            known = self._known.get(key)
            if known is None or known[0] != stamp:
                self._known[key] = known = stamp, make()
            self._known.move_to_end(key)
            while len(self._known) > MOST:
                self._known.popitem(last=False)
            return known[1]

    def forget(self, key: str) -> None:
        """It is made again when it is next asked for."""
        with self._lock:
            self._known.pop(key, None)


def stamp_of(*paths: Path) -> Hashable:
    """Changes when a file does."""
    found = []
    for path in paths:
        stat = path.stat() if path.is_file() else None
        found.append((stat.st_size, stat.st_mtime_ns, stat.st_ino) if stat else None)
    return tuple(found)
