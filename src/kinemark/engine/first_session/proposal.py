"""What a folder's recordings propose for a first `session.toml`: guesses with their reasons, and what must be asked."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, NamedTuple


class Role(StrEnum):
    """What a recording is for."""

    TRIAL = "trial"
    STATIC = "static"
    WAND = "wand"
    L_FRAME = "l_frame"
    CONTROL_FRAME = "control_frame"
    CONTROL_POINTS = "control_points"
    SINGLE_MARKER = "single_marker"
    GRID = "linearisation"
    EMPTY = "empty"
    CALIBRATION = "calibration"  # of which way it is nothing says
    RIG = "file"
    TEMPLATE = "template"
    STATIC_TEMPLATE = "static_template"
    UNUSED = "unused"


TRIALS = (Role.TRIAL, Role.STATIC)
"""What becomes a table of `[[trials]]`."""
NAMING = {"trajectories": (Role.TEMPLATE, Role.STATIC_TEMPLATE), "template": (Role.TEMPLATE,)}
"""Content → what in `[label]` it may be; nothing else may."""

DATE = re.compile(r"(?<!\d)(20\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])(?!\d)")


class Reason(NamedTuple):
    """Why something was guessed: a kind, which `report.words.first_session` puts into words, and its values."""

    kind: str
    values: Mapping[str, Any] = {}


NO_CAMERAS, NO_RATE, NO_IMAGES = Reason("no_cameras"), Reason("no_rate"), Reason("no_images")


@dataclass(frozen=True, slots=True)
class FoundRecording:
    """One recording: images of all cameras, 2D points, or a file that belongs to a calibration.

    Attributes:
        path: relative to the folder, with `{camera}` where each camera's name stands.
        content: what it consists of.
        cameras: (C) names of those that have it; empty where one file is of all and does not name them.
        role: what it is for; why: the reason.
        name: of the trial that it would be.
        frames: images of one camera as stored, None where unknown; the fewest, where cameras differ.
        rate: Hz as its files say it, None where they do not.
        size: width and height, px; None where unknown.
        unequal: whether cameras have different numbers of frames.
        damaged: paths of cameras' images that cannot be opened.
    """

    path: str
    content: Literal["images", "detections", "rods", "points", "rig", "trajectories", "template", "other"]
    cameras: tuple[str, ...]
    role: Role
    why: Reason
    name: str = ""
    frames: int | None = None
    rate: float | None = None
    size: tuple[int, int] | None = None
    unequal: bool = False
    damaged: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Question:
    """What no file tells.

    Attributes:
        key: where the answer goes in `session.toml`, as "calibration.wand.lengths_mm".
        least, most: how many numbers are wanted; both 0 where one of `choices` is.
        choices: the words that may be answered.
        whole: whether the numbers are counts.
        about: the recording that the question is about, by its path.
        optional: whether a session works without the answer, so that nobody is stopped for it.
    """

    key: str
    least: int = 1
    most: int = 1
    choices: tuple[str, ...] = ()
    whole: bool = False
    about: str = ""
    optional: bool = False


Answer = tuple[float, ...] | str
"""Numbers, or one of a question's choices."""


@dataclass(frozen=True, slots=True)
class SessionProposal:
    """What a folder's recordings propose.

    Attributes:
        folder: that was looked at.
        name: of the session; date: of the recording as names say it, YYYY-MM-DD, empty where they do not.
        cameras: (C) names in order; cameras_why: how they were found.
        rate: Hz of frames, of fields where interlaced; None where no file says it. rate_why: the reason.
        interlaced: "top" or "bottom", the field taken first; False for whole frames. interlaced_why: the reason.
        inverted_why: the reason where markers are darker than their ground; None where they are brighter.
        recordings: all that was found, in order of path.
        way: the recording that calibrates; None where there is none, or more is needed to say.
        beside: recordings that go beside the way, as an L-frame or a grid.
        questions: what no file tells; answers: what was answered, by key.
        notes: what contradicts itself or was left out.
    """

    folder: Path
    name: str
    date: str = ""
    cameras: tuple[str, ...] = ()
    cameras_why: Reason = NO_CAMERAS
    rate: float | None = None
    rate_why: Reason = NO_RATE
    interlaced: Literal[False, "top", "bottom"] = False
    interlaced_why: Reason = NO_IMAGES
    inverted_why: Reason | None = None
    recordings: tuple[FoundRecording, ...] = ()
    way: FoundRecording | None = None
    beside: tuple[FoundRecording, ...] = ()
    questions: tuple[Question, ...] = ()
    answers: Mapping[str, Answer] = field(default_factory=dict)
    notes: tuple[Reason, ...] = ()

    @property
    def open(self) -> tuple[Question, ...]:
        """The questions that were not answered yet and want to be."""
        return tuple(one for one in self.questions if one.key not in self.answers and not one.optional)

    @property
    def trials(self) -> tuple[FoundRecording, ...]:
        """The recordings that become `[[trials]]`."""
        return tuple(one for one in self.recordings if one.role in TRIALS)

    def figures(self) -> dict[str, Any]:
        """Everything as plain data."""
        facts: dict[str, Any] = json.loads(json.dumps(asdict(self), default=str))
        return facts


def day_in(path: str) -> str:
    """The day that a name says, YYYY-MM-DD; empty where it says none."""
    match = DATE.search(path)
    return "-".join(match.groups()) if match else ""


def parsed(question: Question, text: str) -> Answer:
    """What was typed, as numbers or one of the choices.

    Raises:
        ValueError: it is neither.
    """
    words = text.strip().strip("[]").replace(",", " ").split()
    if question.choices:
        if len(words) != 1 or words[0] not in question.choices:
            raise ValueError(f"{text.strip()!r} is none of {', '.join(question.choices)}")
        return words[0]
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError:
        raise ValueError(f"{text.strip()!r} is not made of numbers, as 120 280") from None
    if not question.least <= len(numbers) <= question.most:
        wanted = question.least if question.least == question.most else f"{question.least} to {question.most}"
        raise ValueError(f"{text.strip()!r} has {len(numbers)} numbers, wanted {wanted}")
    if not all(0 < number < float("inf") for number in numbers) or (question.whole and any(n % 1 for n in numbers)):
        raise ValueError(f"{text.strip()!r} wants {'whole ' if question.whole else ''}numbers above 0")
    return numbers
