"""Versions of a trial that were replayed already: undo, redo and preview come back to them at once.

They share all markers that an edit does not touch, so several cost little more than one.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from threading import Lock

from ...data.edits import Entry
from ...edit import Edited

MOST = 16
"""Versions that are kept; chosen: as far as people undo and redo while they look."""


class Replays:
    """Versions by their entries; these are known by identity, as a journal gives the same record for the same line."""

    def __init__(self) -> None:
        self._known: OrderedDict[tuple[int, ...], tuple[Sequence[Entry], Edited]] = OrderedDict()
        self._lock = Lock()

    def of(self, entries: Sequence[Entry], replay: Callable[[Sequence[Entry]], Edited]) -> Edited:
        """The version with these entries, replayed where it is not known."""
        key = tuple(map(id, entries))
        with self._lock:
            found = self._known.get(key)
        if found is None:
            found = entries, replay(entries)  # the entries are kept, so that their ids stay their own
        with self._lock:
            self._known[key] = found
            self._known.move_to_end(key)
            while len(self._known) > MOST:
                self._known.popitem(last=False)
        return found[1]
