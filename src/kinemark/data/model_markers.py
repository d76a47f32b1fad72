"""Which of a trial's markers are the gait model's, where a laboratory calls them otherwise.

Names are read as `data.landmarks` reads them: "r bar 1" is the wand of the right thigh. Whoever has other names states
them.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from .errors import KinemarkError
from .landmarks import OF_A_SIDE, OF_THE_MIDDLE, landmarks
from .marker_sides import without_subject
from .nearest_word import some_names
from .subject_measures import LETTER, SIDES, Side
from .trajectories import Trajectories

LEG_MARKERS = ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")
"""Of each leg, after L or R; conventional."""
MODEL_MARKERS = (
    "LASI", "RASI", "SACR", "LPSI", "RPSI", *(letter + name for letter in LETTER.values() for name in LEG_MARKERS)
)  # fmt: skip
"""All that the model looks at; conventional."""
DEVICE = ("KAX", "KD1", "KD2")
"""Of a knee alignment device, after L or R; conventional (Plug-in Gait)."""
INSIDE = ("KNM", "MED")
"""Inside of knee and ankle, after L or R; conventional (CGM2)."""
STATIC_MARKERS = (*DEVICE, *INSIDE)
"""That only the standing trial needs; conventional."""
THORAX_MARKERS = ("CLAV", "STRN", "C7", "T10")
HEAD_MARKERS = ("LFHD", "RFHD", "LBHD", "RBHD")
ARM_MARKERS = ("SHO", "ELB", "WRA", "WRB", "FIN")
"""Of each arm, after L or R; conventional."""
UPPER_BODY_MARKERS = (
    *THORAX_MARKERS, *HEAD_MARKERS, *(letter + name for letter in LETTER.values() for name in ARM_MARKERS)
)  # fmt: skip
"""Of trunk, head and arms, which a trial may have; conventional (Plug-in Gait)."""
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
    called = _called(names)
    found = {}
    for marker in KNOWN_MARKERS:
        if marker in stated:
            found[marker] = stated[marker]
            continue
        exact = next((name for name in names if without_subject(name) == marker), None)
        known = exact or next((called[one] for one in _words(marker) if one in called), None)
        if known is not None and known not in stated.values():
            found[marker] = known
    return found


def upper_body_names(names: Sequence[str], taken: Collection[str]) -> dict[str, str]:
    """The trial's name of each marker of the upper body that differs from it in case, or by what stands between its
    letters, alone.

    Args:
        names: of the trial's markers. taken: of these, that are others.
    """
    own = {without_subject(name) for name in names}
    bare = {re.sub("[^A-Z0-9]", "", without_subject(name).upper()): name for name in names if name not in taken}
    return {marker: bare[marker] for marker in UPPER_BODY_MARKERS if marker not in own and marker in bare}


def with_model_names(trajectories: Trajectories, known: Mapping[str, str]) -> Trajectories:
    """The trajectories with the model's names where they have others.

    Args:
        trajectories: of the trial. known: the trial's name by the model's.
    """
    others = {name: marker for marker, name in known.items() if without_subject(name) != marker}
    if not others:
        return trajectories
    kept = [path for path in trajectories if path.name in others or without_subject(path.name) not in others.values()]
    paths = tuple(replace(path, name=others.get(path.name, path.name)) for path in kept)
    return replace(trajectories, paths=paths)


def _check(stated: Mapping[str, str], names: Sequence[str]) -> None:
    for marker, name in stated.items():
        if marker not in KNOWN_MARKERS:
            raise KinemarkError(f"{marker} is none of the gait model's markers, which are {', '.join(KNOWN_MARKERS)}.")
        if name not in names:
            raise KinemarkError(f"{marker} is said to be {name!r}, which is not in the trial; there are "
                                f"{some_names(list(names))}.")  # fmt: skip
    if twice := sorted({name for name in stated.values() if list(stated.values()).count(name) > 1}):
        raise KinemarkError(f"{', '.join(twice)} is said to be two markers. Give each marker a name of its own.")


def _called(names: Sequence[str]) -> dict[tuple[Side | None, str], str]:
    """The first of the names for each side and word, by the surest way to read it."""
    ways = landmarks(names)
    found: dict[tuple[Side | None, str], str] = {}
    for k in range(max(map(len, ways.values()), default=0)):
        for name in names:
            for one in ways[name][k : k + 1]:
                found.setdefault((one.side, one.word), name)
    return found


def _words(marker: str) -> list[tuple[Side | None, str]]:
    """How a marker's name may be read."""
    if marker in OF_THE_MIDDLE:
        return [(None, word) for word in OF_THE_MIDDLE[marker]]
    side = next(side for side in SIDES if marker.startswith(LETTER[side]))
    return [(side, word) for word in OF_A_SIDE[marker[1:]]]
