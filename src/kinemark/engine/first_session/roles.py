"""What a recording is for, by the words in its name; the nearest to the file's own name counts most."""

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
ANY_IMAGE = re.compile(r"(?:im|img|image|frame|fr|pic|picture|photo|shot|snap|capture|grab)s?", re.IGNORECASE)
"""Words that any image has before its number, and that name no trial; chosen."""
VAGUE = _words(Role.CALIBRATION, r"cal(?:ib|\b)|kalib")


def role_of(path: str) -> tuple[Role, Reason]:
    """What a recording of this path is for; a trial where no word says another."""
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


def trial_name(path: str) -> str:
    """A short name of a trial, from its pattern: what the path says besides camera, number of the image and ending."""
    stem = path.rsplit(".", 1)[0]
    parts = [tidied(part) for part in stem.split("/")]
    named = [part for part in parts if part]
    said = [part for part in named if not ANY_IMAGE.fullmatch(part)] or named
    return said[-1] if said else ""


def tidied(part: str) -> str:
    """A part of a path without camera and number of the image, and without separators at its ends."""
    bare = re.sub(r"\{camera\}|%(0\d+)?d|\*|#", "", part)
    return re.sub(r"([ _.-])[ _.-]+", r"\1", bare).strip(" _.-")
