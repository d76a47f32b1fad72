"""Whose turn it is on one interpreter: first what somebody waits for, last what is done for nobody in particular."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum


class Rank(IntEnum):
    """Of work: what has a lesser rank goes first."""

    ASKED = 0
    """Somebody waits for the answer."""
    LOOKED_AT = 1
    """Somebody looks at what it is about."""
    BEHIND = 2
    """It is done for whoever looks later."""


class Turns:
    """Work of all ranks that goes on now."""

    def __init__(self) -> None:
        self._going = [0] * len(Rank)
        self._hurried = 0
        self._ended = threading.Condition()

    @contextmanager
    def taken(self, rank: Rank) -> Iterator[None]:
        """Work of this rank goes on in this block: others of a greater rank stand still when they give way."""
        with self._ended:
            self._going[rank] += 1
        try:
            yield
        finally:
            with self._ended:
                self._going[rank] -= 1
                self._ended.notify_all()

    @contextmanager
    def hurried(self) -> Iterator[None]:
        """In this block somebody waits for what may stand still already: where it can be hurried, it goes on."""
        with self._ended:
            self._hurried += 1
            self._ended.notify_all()
        try:
            yield
        finally:
            with self._ended:
                self._hurried -= 1

    def give_way(self, rank: Rank, *, unhurried: bool = False) -> None:
        """Stand still while work of a lesser rank goes on; `unhurried` work only while nobody waits for it."""

        def free() -> bool:
            return not any(self._going[:rank]) or (unhurried and self._hurried > 0)

        if not free():
            with self._ended:
                self._ended.wait_for(free)
