"""How the markers of a trial were named: a line, and a table of names with their probabilities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .formatting import count, number, percent
from .tables import Table
from .words.template import listed

MOST_UNSURE = 100
"""Rows of unsure tracks that are shown; chosen for the page's size."""


def label_line(labels: Mapping[str, Any]) -> str:
    """By what the markers were named, and how well it fits."""
    if labels["refused"]:
        return "Nothing is named: the template does not fit (see what needs attention)."
    parts = []
    if labels["sources"]:
        parts.append(f"Named by {listed(labels['sources'])}.")
    if labels["fit"] is not None:
        parts.append(f"The trial scores {number(labels['fit'], 2)} of what these score on their own data.")
    if labels.get("undecided"):
        parts.append(f"Not told apart: {'; '.join(listed(pair) for pair in labels['undecided'])}.")
    if labels.get("stated"):
        parts.append(f"{count(labels['stated'], 'track')} named by hand.")
    if labels.get("ghosts_removed"):
        parts.append(f"{count(labels['ghosts_removed'], 'track')} taken for ghosts and left out.")
    return " ".join(parts)


def label_table(labels: Mapping[str, Any]) -> Table:
    """A row a marker; those that are missing or not sure are marked."""
    head = ["marker", "probability", "state", "samples", "pieces", "runner-up"]
    markers = labels["markers"]
    rows = [
        [
            one["name"],
            percent(one["probability"]),
            one["state"],
            number(one["samples"]),
            number(one["pieces"]),
            one["runner_up"] or "–",
        ]
        for one in markers
    ]
    marked = [one["state"] in ("missing", "unsure") for one in markers]
    return Table(head, rows, marked=marked, absent="No marker has a name.")


def unsure_table(labels: Mapping[str, Any], first_frame: int) -> Table:
    """A row for each track whose name is not sure, so that it has none; `first_frame` is the recording's."""
    unsure: Sequence[Mapping[str, Any]] = labels["unsure"]
    rows = [
        [
            one["name"],
            percent(one["probability"]),
            one["runner_up"] or "no marker",
            f"{number(one['first_frame'] + first_frame)}–{number(one['last_frame'] + first_frame)}",
            number(one["samples"]),
        ]
        for one in unsure[:MOST_UNSURE]
    ]
    more = f"And {len(unsure) - MOST_UNSURE} more, in quality.json." if len(unsure) > MOST_UNSURE else ""
    return Table(["probably", "probability", "or", "frames", "samples"], rows, absent="None.", note=more)
