"""The one error that tells a user what to do next."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from .finding import Finding


class KinemarkError(Exception):
    """An impossible whole: no calibration, an unreadable file, a contradictory session.

    The message says what was found, what was wanted, and what to do. A caller's mistake in one
    argument raises `ValueError`, and an absent item (one marker in one frame) is NaN, never an exception.

    Attributes:
        findings: what was found on the way that may explain it.
    """

    def __init__(self, message: str = "", *, findings: Iterable[Finding] = ()) -> None:
        super().__init__(message)
        self.findings = tuple(findings)


@contextmanager
def users_mistake() -> Iterator[None]:
    """What is wrong with values in this block is the user's, not the caller's: a ValueError becomes a KinemarkError."""
    try:
        yield
    except ValueError as error:
        raise KinemarkError(f"{error}.") from error
