"""Which of a trial's markers are the gait model's, where a laboratory calls them otherwise.

A marker's name is read without its subject, without regard to case, blanks and signs, with L or R, or left or right,
before it: "r bar 1" is the wand of the right thigh. Whoever has other names states them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..data import KinemarkError, Trajectories
from ..data.subject_measures import LETTER
from .lower_limb import MODEL_MARKERS
from .static_axes import STATIC_MARKERS

OF_A_SIDE = {
    "ASI": ("asi", "asis", "ias"),
    "PSI": ("psi", "psis", "ips"),
    "THI": ("thi", "bar1", "thighwand", "thighbar"),
    "KNE": ("kne", "knee", "knee1", "lateralknee", "latknee", "lfe", "fle"),
    "TIB": ("tib", "bar2", "shankwand", "shankbar", "tibia"),
    "ANK": ("ank", "ankle", "mall", "malleolus", "lateralankle", "latankle", "lm", "fal"),
    "HEE": ("hee", "heel", "calc", "calcaneus", "fcc"),
    "TOE": ("toe", "met", "met2", "mt2", "secondmet", "fm2"),
    "KAX": ("kax",),
    "KD1": ("kd1",),
    "KD2": ("kd2",),
    "KNM": ("knm", "medialknee", "medknee", "kneemed", "kneemedial", "knem", "mfe", "fme"),
    "MED": ("med", "medialankle", "medankle", "anklemed", "anklemedial", "ankm", "medialmalleolus", "mm", "tam"),
}
"""What laboratories call the markers of a side, most usual first; of Plug-in Gait, Helen Hayes, the Davis protocol of
BTS, CGM2 and the landmarks of ISB; conventional."""
OF_THE_MIDDLE = {"SACR": ("sacr", "sacrum", "sac")}
"""The same of the others; conventional."""

KNOWN_MARKERS = (*MODEL_MARKERS, *(letter + name for letter in LETTER.values() for name in STATIC_MARKERS))
"""All that a trial may have, standing ones with those that show axes; conventional."""


def model_names(names: Sequence[str], stated: Mapping[str, str] | None = None) -> dict[str, str]:
    """The trial's name of each of the model's markers that is there.

    Args:
        names: of the trial's markers. stated: the trial's name by the model's, for those that are called otherwise.

    Raises:
        KinemarkError: a stated name is none of the model's or of the trial's, or stands for two.
    """
    stated = dict(stated or {})
    _check(stated, names)
    by_word = {_word(name): name for name in reversed(names)}
    found = {}
    for marker in KNOWN_MARKERS:
        if marker in stated:
            found[marker] = stated[marker]
            continue
        exact = next((name for name in names if _bare(name) == marker), None)
        known = exact or next((by_word[word] for word in _words(marker) if word in by_word), None)
        if known is not None and known not in stated.values():
            found[marker] = known
    return found


def with_model_names(trajectories: Trajectories, known: Mapping[str, str]) -> Trajectories:
    """The trajectories with the model's names where they have others.

    Args:
        trajectories: of the trial. known: the trial's name by the model's.
    """
    others = {name: marker for marker, name in known.items() if _bare(name) != marker}
    if not others:
        return trajectories
    kept = [path for path in trajectories if path.name in others or _bare(path.name) not in others.values()]
    paths = tuple(replace(path, name=others.get(path.name, path.name)) for path in kept)
    return replace(trajectories, paths=paths)


def _check(stated: Mapping[str, str], names: Sequence[str]) -> None:
    for marker, name in stated.items():
        if marker not in KNOWN_MARKERS:
            raise KinemarkError(f"{marker} is none of the gait model's markers, which are {', '.join(KNOWN_MARKERS)}.")
        if name not in names:
            raise KinemarkError(f"{marker} is said to be {name!r}, which is not in the trial; there are "
                                f"{', '.join(list(names)[:40]) or 'none'}.")  # fmt: skip
    if twice := sorted({name for name in stated.values() if list(stated.values()).count(name) > 1}):
        raise KinemarkError(f"{', '.join(twice)} is said to be two markers. Give each marker a name of its own.")


def _words(marker: str) -> list[str]:
    """How a marker's name may be read."""
    if marker in OF_THE_MIDDLE:
        return list(OF_THE_MIDDLE[marker])
    side = next(side for side, letter in LETTER.items() if marker.startswith(letter))
    return [before + word for word in OF_A_SIDE[marker[1:]] for before in (LETTER[side].lower(), side)]


def _bare(name: str) -> str:
    """Without the subject's prefix."""
    return name.rsplit(":", 1)[-1]


def _word(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", _bare(name).lower())
