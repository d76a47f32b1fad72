"""Marker sets in words, as a picture, and learnt from a file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...data import KinemarkError, MarkerSet
from ...data.nearest_word import guess, some_names
from ...io.files import check_new
from ...io.marker_sets import marker_sets, read_marker_set, write_marker_set
from ...io.trial import read_trial
from ...label.learn_set import learn_marker_set
from ...report.marker_figure import marker_set_html, marker_set_svg
from ...report.templating import write_text
from ..put_aside import put_aside
from .subject_templates import before_all

ALIKE = 0.6
"""Share of a set's names that a trial must have for them to mean the same; chosen: names such as C7 are in many."""
PICTURES = (".svg", ".html", ".htm")
"""Endings of the pictures that are written."""


def listed() -> list[dict[str, Any]]:
    """The sets that come with Kinemark: name, number of markers, description."""
    sets = [read_marker_set(name) for name in marker_sets()]
    return [{"name": one.name, "markers": len(one), "description": one.description} for one in sets]


def set_by_names(names: Iterable[str]) -> MarkerSet | None:
    """The set that comes with Kinemark which has most of these names, the smallest of several; None unless it fits."""
    sets, there = [read_marker_set(name) for name in marker_sets()], set(names)
    count = {one.name: len(there & {*one.names}) for one in sets}
    like = max(sets, key=lambda one: (count[one.name], -len(one)))
    return like if count[like.name] >= ALIKE * len(like) else None


def list_text() -> str:
    """A line for each."""
    return "\n".join(f"{one['name']:<20} {one['markers']:3d} markers  {one['description']}" for one in listed())


def set_figures(of: MarkerSet) -> dict[str, Any]:
    """All that a set says, for a machine."""
    return {
        "name": of.name,
        "description": of.description,
        "source": of.source,
        "markers": [_marker(of, name) for name in of.names],
        "segments": {name: {"markers": list(ms), "spread": of.rigidity.get(name)} for name, ms in of.segments.items()},
        "joints": {name: list(two) for name, two in of.joints.items()},
        "pairs": [list(pair) for pair in of.pairs],
        "links": [
            {"markers": [of.names[a], of.names[b]], "length_mm": _finite(length), "spread_mm": _finite(spread)}
            for (a, b), length, spread in zip(of.links.tolist(), of.length, of.spread, strict=True)
        ],
    }


def _marker(of: MarkerSet, name: str) -> dict[str, Any]:
    worn = "optional" if name in of.optional else "static" if name in of.static_only else "always"
    return {"name": name, "meaning": of.meaning.get(name), "worn": worn, "place": _place(of, name)}


def _place(of: MarkerSet, name: str) -> list[float] | None:
    return list(of.places[name]) if name in of.places else None


def _finite(value: float) -> float | None:
    return round(float(value), 3) if np.isfinite(value) else None


def set_text(of: MarkerSet) -> str:
    """The same as lines of text."""
    worn = {"optional": " (may be absent)", "static": " (static trial only)", "always": ""}
    wide = max(map(len, of.names))
    rows = [_marker(of, name) for name in of.names]
    lines = [f"{of.name or 'marker set'}: {len(of)} markers. {of.description}".rstrip(), ""]
    lines += [f"  {one['name']:<{wide}}  {one['meaning'] or ''}{worn[one['worn']]}".rstrip() for one in rows]
    if of.segments:
        lines += ["", "segments, and the spread of their distances:"]
        lines += [f"  {name}: {', '.join(ms)}{_spread(of, name)}" for name, ms in of.segments.items()]
    if of.joints:
        lines += ["", "joints:", *(f"  {name}: {two[0]} and {two[1]}" for name, two in of.joints.items())]
    if of.pairs:
        lines += ["", "left and right: " + ", ".join(f"{left}/{right}" for left, right in of.pairs)]
    if of.source:
        lines += ["", f"source: {of.source}"]
    return "\n".join(lines)


def _spread(of: MarkerSet, segment: str) -> str:
    return f" ({100 * of.rigidity[segment]:.1f} %)" if segment in of.rigidity else ""


def draw_set(path: Path, of: MarkerSet) -> None:
    """Write the picture of a set.

    Raises:
        KinemarkError: the file exists, has another ending than .svg or .html, or the set says no places.
    """
    if path.suffix.lower() not in PICTURES:
        raise KinemarkError(f"{path} wants one of the endings {', '.join(PICTURES)}.")
    _check_free(path)
    write_text(path, marker_set_svg(of) if path.suffix.lower() == ".svg" else marker_set_html(of))


def set_from_file(source: Path, target: Path, *, names: Sequence[str] = ()) -> MarkerSet:
    """Learn a marker set from a labelled trial and write it.

    Args:
        source: a labelled trial, of any program. target: the TOML file to write; an existing one is not replaced.
        names: of the markers; all that do not begin with "*" where there are none. A subject's name before all markers,
            as in `Anna:LASI`, is left away.

    Raises:
        KinemarkError: a file cannot be read or written, a name is not in it, or it shows no motion.
    """
    if target.suffix.lower() != ".toml":
        raise KinemarkError(f"{target} wants the ending .toml.")
    _check_free(target)
    given = read_trial(source)
    prefix = before_all(given.trajectories)
    names = [name.removeprefix(prefix) for name in names]
    rest = put_aside(given, keep=[prefix + name for name in names]).rest
    trial = replace(rest, paths=tuple(replace(path, name=path.name.removeprefix(prefix)) for path in rest))
    if absent := [name for name in names if name not in trial.names]:
        raise KinemarkError(
            f"{source} has no marker {absent[0]}{guess(absent[0], trial.names)}. There are {some_names(trial.names)}."
        )
    try:
        found = learn_marker_set(trial, names=names or None, name=target.stem)
    except KinemarkError as error:
        raise KinemarkError(f"{source}: {error}") from None
    found = _in_words(found)
    write_marker_set(target, found)
    return found


def _in_words(found: MarkerSet) -> MarkerSet:
    """With the meaning of names that are those of a set that comes with Kinemark."""
    like = set_by_names(found.names)
    if like is None:
        return found
    return replace(found, meaning={name: like.meaning[name] for name in found.names if name in like.meaning})


def _check_free(path: Path) -> None:
    check_new(path)
