"""Words by which a path says what a recording is for: a wand, a floor, a standing trial."""

from __future__ import annotations

import re
from typing import NamedTuple

from .proposal import Reason, Role


class Words(NamedTuple):
    """Words that a part of a path has, and what it then is."""

    role: Role
    form: re.Pattern[str]


def _words(role: Role, form: str) -> Words:
    return Words(role, re.compile(rf"\b(?:{form})"))


SPECIFIC = (
    _words(Role.EMPTY, r"empty|background|no subject|blank|leer"),
    _words(Role.L_FRAME, r"l ?frame|l shape|origin|floor|ground|axes\b"),
    _words(Role.GRID, r"grid|che(?:ss|cker)|lens(?:es)?\b|lineari|intrinsic|distortion"),
    _words(Role.WAND, r"wand|stick\b|t ?wand"),
    _words(Role.SINGLE_MARKER, r"led\b|laser|self ?cal|single marker|single led"),
    _words(Role.CONTROL_FRAME, r"rods?\b|control frame|cal(?:ib(?:ration)?)? ?frame|cube\b|control"),
    _words(Role.STATIC, r"static|stand(?:ing)?\b|neutral|[tna] ?pose|anatomical"),
)
"""Words that leave no doubt, the first that matches counts."""
VAGUE = _words(Role.CALIBRATION, r"cal(?:ib|\b)|kalib")


def role_of(path: str) -> tuple[Role, Reason]:
    """What a recording is for, by the words of its path, the nearest to the file's own name first; else a trial."""
    parts = [spoken(part) for part in reversed(path.rsplit(".", 1)[0].split("/"))]
    for words in (SPECIFIC, (VAGUE,)):
        for part in parts:
            for role, form in words:
                if found := form.search(part):
                    return role, Reason("named", {"word": found[0].strip(), "role": str(role)})
    return Role.TRIAL, Reason("no_word")


def spoken(part: str) -> str:
    """A part of a path as words: letters alone, apart where the case changes; without the camera."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", part.replace("{camera}", " "))
    return " ".join(re.sub(r"[^a-zA-Z]+", " ", apart).lower().split())


def says_role(name: str) -> bool:
    """Whether a name leaves no doubt that it is that of a recording, and so of no camera."""
    return any(form.search(spoken(name)) for _, form in SPECIFIC)
