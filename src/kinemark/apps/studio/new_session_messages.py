"""What the server and the page say of a session that is still to be made from recordings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...engine.first_session import Role
from .messages import Message

Text = Annotated[str, Field(max_length=300)]
Field_ = Literal["whole", "top", "bottom"]
"""Whole frames, or the field that was taken first."""


class NewFolder(Message):
    """A folder that holds recordings and no session; `folder` is its place below the roots, to be read."""

    id: str
    title: str
    folder: str
    words: str


class NewFolders(Message):
    """All of them."""

    folders: list[NewFolder]


class RoleRow(Message):
    """What a recording may be for."""

    key: Role
    words: str


class RecordingRow(Message):
    """A recording that was found; `file` is its place in the folder, to be read; `why` says why it has its role."""

    id: str
    file: str
    content: str
    cameras: list[str]
    role: Role
    why: str
    name: str
    frames: int | None
    rate: float | None
    size: tuple[int, int] | None
    unequal: bool


class Asked(Message):
    """What no file tells. Numbers from `least` to `most`, or one of `choices`; `wrong` says why an answer is none."""

    key: str
    words: str
    least: int
    most: int
    choices: list[str]
    optional: bool
    answer: str
    wrong: str


class ProposedSession(Message):
    """What a folder's recordings propose, with what the person said of them.

    `way` is the recording that calibrates, by its id; `text` the session.toml that would be written; `lacking` why it
    cannot be yet, empty where it can.
    """

    id: str
    folder: str
    name: str
    date: str
    cameras: list[str]
    cameras_why: str
    rate: float | None
    rate_why: str
    fields: Field_
    fields_why: str
    recordings: list[RecordingRow]
    roles: list[RoleRow]
    way: str
    questions: list[Asked]
    notes: list[str]
    text: str
    lacking: str


class SaidOfRecordings(Message):
    """What the person says instead of the proposal: recordings by their ids, answers by the keys of questions."""

    name: Annotated[str, Field(max_length=100)] | None = None
    date: Annotated[str, Field(pattern=r"^(\d{4}-\d{2}-\d{2})?$")] | None = None
    rate: Annotated[float, Field(gt=0, le=1e6)] | None = None
    fields: Field_ | None = None
    roles: dict[str, Role] = Field(default_factory=dict)
    names: dict[str, Annotated[str, Field(max_length=100)]] = Field(default_factory=dict)
    answers: dict[str, Text] = Field(default_factory=dict)


class MadeSession(Message):
    """The session that was made, and its trials."""

    session: str
    trials: list[str]
