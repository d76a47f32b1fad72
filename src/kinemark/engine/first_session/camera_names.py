"""Which part of the names of files is the camera: `walk01_cam1.avi`, `cam1/walk01.avi`, `walk01/left.mp4`.

Each hypothesis cuts one piece out of a path, the camera's name, and leaves a pattern with `{camera}` in its place. The
hypothesis is taken under which most files share a pattern with another file, the patterns have the same set of
names, the files of a pattern are of one size and length, as synchronous cameras give them, and whose names look most
like those of cameras.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from .role_words import says_role

CAMERA = "{camera}"
WORD = re.compile(
    r"(?:(?:cam(?:era)?|kamera|gopro)[ _-]?|(?<![a-z0-9])(?:c|ch|view)[ _-]?)"
    r"(?P<id>\d{8}|\d{1,3}|[a-h])(?:(?![a-z0-9])|(?=DLC))",
    re.IGNORECASE,
)
SIDE = re.compile(
    r"(?<![a-z])(?:left|right|front|back|rear|side|top|bottom|middle|cent(?:er|re)|l|r)(?![a-z])", re.IGNORECASE
)
RUN = re.compile(r"[0-9]+|[^\W\d_]+")
RUNS = 4
"""How many runs of letters or digits, from the end of a name, may be the camera; chosen."""


class Cut(NamedTuple):
    """A path in two: the camera's name, and the pattern that it leaves."""

    camera: str
    pattern: str


class Grouping(NamedTuple):
    """Patterns with the path of each camera, by name; rest: paths without a camera; how: the hypothesis's name."""

    patterns: Mapping[str, Mapping[str, str]]
    rest: tuple[str, ...]
    how: str

    @property
    def names(self) -> tuple[str, ...]:
        """The names that most patterns have, in natural order."""
        several = (frozenset(found) for found in self.patterns.values() if len(found) > 1)
        sets: Counter[frozenset[str]] = Counter(several)
        most = max(sets.items(), key=lambda item: (item[1], len(item[0])), default=(frozenset[str](), 0))[0]
        return tuple(sorted(most, key=natural))


def natural(name: str) -> tuple[tuple[int, str], ...]:
    """A key by which cam2 comes before cam10."""
    parts = re.split(r"([0-9]+)", name.lower())
    return tuple((int(part), "") if k % 2 else (-1, part) for k, part in enumerate(parts) if part)


def by_word(path: str) -> Cut | None:
    """`cam1`, `Camera_A`, `c03`: the word and its number."""
    return _last(WORD, path, 0)


def by_number(path: str) -> Cut | None:
    """Only the number after such a word, where recordings use different words."""
    return _last(WORD, path, "id")


def by_side(path: str) -> Cut | None:
    """`left`, `front`, …"""
    return _last(SIDE, path, 0)


def by_folder(path: str) -> Cut | None:
    """The folder that holds the file."""
    folders = path.split("/")[:-1]
    return Cut(folders[-1], "/".join([*folders[:-1], CAMERA, path.split("/")[-1]])) if folders else None


def by_stem(path: str) -> Cut | None:
    """The whole name of the file."""
    folder, name = path.rpartition("/")[::2]
    stem, dot, ending = name.rpartition(".")
    return None if "#" in stem else Cut(stem, f"{folder}/{CAMERA}{dot}{ending}".lstrip("/"))


def by_first(path: str) -> Cut | None:
    """What stands before the first `_`, `-` or blank of the name, where a recording's word and number follow."""
    folder, name = path.rpartition("/")[::2]
    found = re.match(r"([^\W_]+)([_ -].+)", name)
    return Cut(found[1], f"{folder}/{CAMERA}{found[2]}".lstrip("/")) if found else None


def by_run(k: int) -> Callable[[str], Cut | None]:
    """The k-th run of letters or digits from the end of the name."""

    def cut(path: str) -> Cut | None:
        folder, name = path.rpartition("/")[::2]
        stem, dot, ending = name.rpartition(".")
        runs = list(RUN.finditer(stem))
        if len(runs) <= k:
            return None
        run = runs[-1 - k]
        left = f"{stem[: run.start()]}{CAMERA}{stem[run.end() :]}"
        return Cut(run[0], f"{folder}/{left}{dot}{ending}".lstrip("/"))

    return cut


def _last(form: re.Pattern[str], path: str, part: int | str) -> Cut | None:
    """The last match in a path without its ending; the same text elsewhere in the path is the camera as well."""
    stem, dot, ending = path.rpartition(".")
    found = list(form.finditer(stem))
    if not found:
        return None
    said, name = found[-1][0], found[-1][part]
    start = found[-1].start(part) - found[-1].start()
    hole = said[:start] + CAMERA + said[start + len(name) :]
    whole = re.compile(rf"(?<![A-Za-z0-9]){re.escape(said)}(?![A-Za-z0-9])")
    left = stem[: found[-1].start()] + hole + stem[found[-1].end() :]
    return Cut(name, whole.sub(hole, left) + dot + ending)


HYPOTHESES: dict[str, tuple[Callable[[str], Cut | None], float]] = {
    "word": (by_word, 0.5),
    "number": (by_number, 0.4),
    "side": (by_side, 0.35),
    "folder": (by_folder, 0.2),
    "stem": (by_stem, 0.01),
    "run first": (by_first, 0.03),
    **{f"run {k + 1}": (by_run(k), 0.1 - 0.02 * k) for k in range(RUNS)},
}
"""By name, how a path is cut, and how much its names look like those of cameras; chosen, below what one piece of
evidence counts, 1."""


def grouped(paths: Iterable[str], how: str) -> Grouping:
    """The paths under one hypothesis."""
    cut = HYPOTHESES[how][0]
    patterns: dict[str, dict[str, str]] = defaultdict(dict)
    rest = []
    for path in paths:
        found = cut(path)
        if found is None:
            rest.append(path)
        else:
            patterns[found.pattern][found.camera] = path
    return Grouping(dict(patterns), tuple(rest), how)


def best_grouping(paths: Sequence[str], alike: Callable[[Sequence[str]], bool]) -> Grouping | None:
    """The paths under the hypothesis that most speaks for; None where no two files share a pattern.

    Args:
        paths: of the files or sequences.
        alike: whether files could be one recording, being of one kind, size and length.
    """
    groupings = [grouped(paths, how) for how in HYPOTHESES]
    scored = [(score(one, len(paths), alike), one) for one in groupings if one.names]
    return max(scored, key=lambda pair: pair[0])[1] if scored else None


def score(grouping: Grouping, n_paths: int, alike: Callable[[Sequence[str]], bool]) -> float:
    """How much speaks for a hypothesis: covered files, one set of names, equal files, names as of cameras.

    Names as `wand` and `floor` are those of recordings: that outweighs one of these.
    """
    several = [found for found in grouping.patterns.values() if len(found) > 1]
    covered = sum(map(len, several)) / n_paths
    same_names = sum(set(found) == set(grouping.names) for found in several) / len(several)
    equal = sum(alike(list(found.values())) for found in several) / len(several)
    of_recordings = any(map(says_role, grouping.names))
    return covered + same_names + equal + HYPOTHESES[grouping.how][1] - of_recordings
