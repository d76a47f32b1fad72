"""How much an operator had to do in a trial that was digitised, for the page and the terminal."""

from __future__ import annotations

from typing import Any

from .formatting import count, number, percent
from .tables import Table

REASONS = {
    "first_two_frames": "in the first two frames",
    "not_found": "markers not found",
    "ambiguous": "ambiguous",
    "reference": "reference",
}


def digitised_line(digitising: dict[str, Any]) -> str:
    """One sentence; `digitising` is that of quality.json, which is empty where files were digitised elsewhere."""
    cameras = digitising["cameras"].values()
    images = sum(camera["frames"] * camera["markers"] for camera in cameras)
    corrected, absent = (sum(camera[key] for camera in cameras) for key in ("corrected", "not_present"))
    return (
        f"An operator digitised this trial: {count(digitising['questions'], 'question')} for {number(images)} images "
        f"of markers ({percent(digitising['questions'] / max(images, 1))}), {count(corrected, 'place')} corrected, "
        f"{number(absent)} not present."
    )


def digitised_table(digitising: dict[str, Any]) -> Table:
    """A row a camera."""
    head = ["camera", "frames", "markers", "questions", *REASONS.values()]
    head += ["proposals taken", "without a question", "corrected", "not present"]
    keys = ("proposals_confirmed", "proposals_taken_unasked", "corrected", "not_present")
    rows = [
        [
            name,
            *(number(camera[key]) for key in ("frames", "markers", "questions")),
            *(number(camera["questions_by_reason"][key]) for key in REASONS),
            *(number(camera[key]) for key in keys),
        ]
        for name, camera in digitising["cameras"].items()
    ]
    return Table(head, rows)
