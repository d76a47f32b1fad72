"""Whose recording it is, and of which day."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Identity:
    """What a recording says of itself, or the user of it; empty where nobody says it.

    Attributes:
        subject: who was recorded, as a name or a code.
        date: of the recording, YYYY-MM-DD.
        file_date: when its file was last changed, YYYY-MM-DD, which copying may alter.
    """

    subject: str = ""
    date: str = ""
    file_date: str = ""
