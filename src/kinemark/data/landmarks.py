"""Which landmark of the body a marker shows, where laboratories call it each in their own way.

A name is read without its subject, without regard to case, blanks and signs. Its side is what tells it from its
partner, wherever that stands ("ASIS_L" beside "ASIS_R", "WaistLFront"), else L or R, or left or right, before it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from .marker_sides import LISTS, paired, without_subject
from .subject_measures import LETTER, SIDES, Side

OF_A_SIDE = {
    "ASI": ("asi", "asis", "ias", "sias", "fwt", "waistfront", "frontwaist"),
    "PSI": ("psi", "psis", "ips", "sips", "bwt", "waistback", "backwaist"),
    "THI": ("thi", "bar1", "thighwand", "thighbar", "thigh"),
    "KNE": ("kne", "knee", "knee1", "lateralknee", "latknee", "kneelat", "kneeout", "lfe", "fle", "le"),
    "TIB": ("tib", "bar2", "shankwand", "shankbar", "tibia", "shank"),
    "ANK": ("ank", "ankle", "mall", "malleolus", "lateralankle", "latankle", "anklelat", "ankleout", "lm", "fal"),
    "HEE": ("hee", "heel", "heelback", "calc", "calcaneus", "fcc", "cal", "ca"),
    "TOE": ("toe", "met", "met2", "mt2", "secondmet", "fm2", "sm", "forefoot2"),
    "KAX": ("kax",),
    "KD1": ("kd1",),
    "KD2": ("kd2",),
    "KNM": ("knm", "medialknee", "medknee", "kneemed", "kneemedial", "kneein", "knem", "mfe", "fme", "me"),
    "MED": ("med", "medialankle", "medankle", "anklemed", "anklemedial", "anklein", "ankm", "medialmalleolus", "mm",
            "tam"),
}  # fmt: skip
"""What laboratories call the markers of a side, most usual first; of Plug-in Gait, Helen Hayes, the Davis protocol of
BTS, CGM2, the landmarks of ISB, the Rizzoli foot and gait sets, and the sets of animation; conventional."""
OF_THE_MIDDLE = {"SACR": ("sacr", "sacrum", "sac", "vsacral", "vsacr", "sacral", "waistback", "backwaist")}
"""The same of the others; conventional."""
FOREFOOT = (
    *OF_A_SIDE["TOE"], "mt1", "mt5", "met1", "met5", "fm1", "fm5", "fm", "vm", "fmh", "smh", "vmh", "toetip", "toein",
    "toeout", "toelat", "toemed", "bigtoe", "hallux", "forefootin", "forefootout", "forefoot5", "forefoot1",
)  # fmt: skip
"""What lies in front of the heel, if not where the model has its marker; conventional."""


class Landmark(NamedTuple):
    """What a name says: of which subject, on which side, None in the middle, and the word for the landmark."""

    subject: str
    side: Side | None
    word: str


def landmarks(names: Sequence[str]) -> dict[str, tuple[Landmark, ...]]:
    """How each of the names may be read, what is surest first."""
    return dict(_landmarks(tuple(names)))


@lru_cache(LISTS)
def _landmarks(names: tuple[str, ...]) -> dict[str, tuple[Landmark, ...]]:
    """See `landmarks`."""
    left, right = SIDES
    sided = {}
    for pair in paired(names):
        for name, side in ((pair.left, left), (pair.right, right)):
            sided[name] = Landmark(_subject(name), side, _letters(pair.landmark))
    return {name: (*([sided[name]] if name in sided else []), *_by_beginning(name)) for name in names}


def _by_beginning(name: str) -> tuple[Landmark, ...]:
    """With the side before it, as a marker without a partner has it, and without any."""
    word, subject = _letters(without_subject(name)), _subject(name)
    begun = [
        Landmark(subject, side, word[len(before) :])
        for side in SIDES
        for before in (side, LETTER[side].lower())
        if word.startswith(before)
    ]
    return (*begun, Landmark(subject, None, word))


def _subject(name: str) -> str:
    return name[: len(name) - len(without_subject(name))]


def _letters(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())
