"""Progress of long work, and how it is stopped, without knowing who listens.

A stage calls `tell(done, total)` now and then. Outside `listening` that does nothing. Whoever runs a stage listens,
shows the progress, and may raise `Cancelled` to stop the stage at that moment: a stage is a pure function, so
nothing of it is left behind.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[int, int], None]
"""Called with how much is done and how much there is."""

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


class Cancelled(Exception):
    """Work was stopped because somebody asked for it; nothing half-written is left."""


def tell(done: int, total: int) -> None:
    """Say how far the work at hand is; raises what the listener raises, such as `Cancelled`."""
    listener = _listener.get()
    if listener is not None:
        listener(done, total)


@contextmanager
def listening(listener: Listener) -> Iterator[None]:
    """Receive the progress of this block, in this thread; the listener of a block around it receives none meanwhile."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)
