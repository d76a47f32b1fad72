"""Which markers are the left and the right one of a landmark, by how they are called."""

from __future__ import annotations

import re
from collections.abc import Sequence, Set
from functools import lru_cache
from typing import NamedTuple

Rule = tuple[str, str]
RULES: tuple[Rule, ...] = (
    (r"^((?:.*[:/ ])?)[Ll]eft", r"\1{right}"),
    (r"(?<![A-Za-z])[Ll]eft(?![a-z])", "{right}"),
    (r"Left", "{right}"),
    (r"^((?:.*:)?)L(?=[A-Z0-9_. -])", r"\1{R}"),
    (r"^((?:.*:)?)l(?=[A-Z0-9_. -])", r"\1{R}"),
    (r"(?<=[_. -])L$", "{R}"),
    (r"(?<=[_. -])l$", "{R}"),
    (r"(?<=[a-z0-9])L(?=\d*$)", "{R}"),
    (r"(?<=[A-Z0-9])l(?=\d*$)", "{R}"),
    (r"^L(?=[a-z])", "{R}"),
    (r"(?<=_)L(?=[A-Z_])", "{R}"),
    (r"(?<=[_. -])[Ll](?=[_. -])", "{R}"),
    (r"(?<=[a-z])L(?=[A-Z])", "{R}"),
    (r"^((?:.*:)?)l(?=[a-z])", r"\1{R}"),
    (r"(?<=[A-Z])L(?=\d*$)", "{R}"),
)
"""How names say left, and where "right" stands instead; conventions of the common programs."""
OTHER_SIDE = {
    "Left": "Right",
    "Right": "Left",
    "left": "right",
    "right": "left",
    "L": "R",
    "R": "L",
    "l": "r",
    "r": "l",
}
"""Words and letters of a side, longer ones first."""
SIBLINGS = {"L": "M", "R": "U"}
"""Letters that tell lateral from medial, and radial from ulnar, where L and R would say a side; conventional."""
LAST_SIBLINGS = {"L": "U"}
"""The same of lower and upper, not at the beginning: UARM is an upper arm, and LARM a left one; conventional."""
VERTEBRA = r"[Ll][1-5]"
"""Of the loins; conventional."""
NO_SIDES = (
    r"(?:[Ll]at(?:eral)?|[Rr]ad(?:ius|ial)?|[Ll]ow(?:er)?|[Ll]umbar|[Rr]ibs?)(?![a-z])"
    r"|(?:LAT(?:ERAL)?|RAD(?:IUS|IAL)?|LOW(?:ER)?|LUMBAR|RIBS?)(?![A-Za-z])"
)
"""Words at the beginning of names that say no side, though their first letter might; conventional."""
LISTS = 64
"""Of names, whose pairs and landmarks are kept; chosen: a session has a few marker sets."""


class Pair(NamedTuple):
    """Left and right marker of a landmark, and its name without the side, and without the subject's prefix."""

    left: str
    right: str
    landmark: str


def paired(names: Sequence[str]) -> tuple[Pair, ...]:
    """Pairs of left and right names that differ in the side alone; each name in one pair at most.

    The rule that pairs most names comes first, so that LFLL has its partner by how the others are spelt.
    """
    return _paired(tuple(names))


@lru_cache(LISTS)
def _paired(names: tuple[str, ...]) -> tuple[Pair, ...]:
    """See `paired`; labelling asks the same of the same names a hundred times."""
    pairs = _one_each(_by_rule(names), set(names))
    return tuple(pairs[name] for name in names if name in pairs)


def _by_rule(names: Sequence[str]) -> list[list[Pair]]:
    """What each rule makes of left names, whether or not the right one is there."""
    return [[pair for name in names if (pair := _pair(name, rule))] for rule in RULES]


def _one_each(found: Sequence[Sequence[Pair]], there: Set[str]) -> dict[str, Pair]:
    """The pairs that are there by their left names, by the rule that pairs most of them.

    A rule that pairs none but lateral markers with radial ones, whose siblings are there too, has no sides.
    """
    both = [[pair for pair in rows if pair.right in there] for rows in found]
    both = [rows for rows in both if not all(_on_one_limb(pair, there) for pair in rows)]
    pairs: dict[str, Pair] = {}
    used: set[str] = set()
    for rows in sorted(both, key=len, reverse=True):
        for pair in rows:
            if not {pair.left, pair.right} & used:
                pairs[pair.left] = pair
                used |= {pair.left, pair.right}
    return pairs


def _on_one_limb(pair: Pair, there: Set[str]) -> bool:
    """Whether FOREl and FOREr are lateral and radial, as FOREm and FOREu are there."""
    return _has_sibling(pair.left, pair.right, there) and _has_sibling(pair.right, pair.left, there)


def sides_by_name(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Left and right names of all pairs (`paired`), in the order of the left ones."""
    return tuple((pair.left, pair.right) for pair in paired(names))


def one_sided(names: Sequence[str]) -> tuple[str, ...]:
    """Names that say a side as the names of pairs do, and whose other side is not there.

    A marker may be worn on one side only, as RBAK is, or its partner may be lost: names do not tell which. Letters and
    words that say something else are no sides (`_says_no_side`).
    """
    there, found = set(names), _by_rule(names)
    pairs = _one_each(found, there)
    telling = [k for k, rows in enumerate(found) if any(pair.right in there for pair in rows)]
    rest = there - {*pairs} - {pair.right for pair in pairs.values()}
    lost = [(pair.left, pair.right) for k in telling for pair in found[k]]
    for name in rest:  # a right name is the left one of its mirror image
        mirrored = (pair for k in telling if (pair := _pair(_mirrored(name), RULES[k])))
        lost += [(name, _mirrored(pair.right)) for pair in mirrored]
    alone = {name for name, other in lost if other not in there and not _says_no_side(name, other, there)} & rest
    return tuple(name for name in names if name in alone)


def _says_no_side(name: str, other: str, there: Set[str]) -> bool:
    """Whether what tells a name from that of the other side, which is not there, says something else.

    L beside the same name with M says lateral, R beside U radial, and a last L beside U lower: SCAPl and SCAPm, STYLr
    and STYLu, LE and ME. Some words begin like a side, and L1 to L5 are vertebrae where nothing is called R1 to R5.
    """
    plain = without_subject(name)
    if re.fullmatch(VERTEBRA, plain):
        return there.isdisjoint(name.replace(plain, f"{'R' if plain[0] == 'L' else 'r'}{k}") for k in range(1, 6))
    return bool(re.match(NO_SIDES, plain)) or _has_sibling(name, other, there)


def _has_sibling(name: str, other: str, there: Set[str]) -> bool:
    """Whether a marker is there whose name has, in place of the letter of the side, that of a sibling on the limb."""
    where = [k for k, (a, b) in enumerate(zip(name, other, strict=False)) if a != b]
    if len(name) != len(other) or len(where) != 1:
        return False
    k = where[0]
    letters = SIBLINGS.get(name[k].upper(), "") + (LAST_SIBLINGS.get(name[k].upper(), "") if k else "")
    letters = letters if name[k].isupper() else letters.lower()
    return any(f"{name[:k]}{letter}{name[k + 1 :]}" in there for letter in letters)


def _mirrored(name: str) -> str:
    """With the other side wherever a word or letter may say one."""
    return re.sub("|".join(OTHER_SIDE), lambda found: OTHER_SIDE[found.group(0)], name)


def without_subject(name: str) -> str:
    """Without the subject's prefix, as in `Anna:LASI`."""
    return name.rsplit(":", 1)[-1]


def _pair(name: str, rule: Rule) -> Pair | None:
    """A left name, and what the right one and the landmark are called; None for a name that the rule has no side in."""
    pattern, template = rule
    found = re.search(pattern, name)
    if not found:
        return None
    word = found.group(0)
    capital = word.lstrip(found.group(1) if found.groups() else "")[:1].isupper()

    def spelt(right: str, letter: str) -> str:
        return name[: found.start()] + found.expand(template.format(right=right, R=letter)) + name[found.end() :]

    other = spelt("Right", "R") if capital else spelt("right", "r")
    return Pair(name, other, without_subject(spelt("", "")))
