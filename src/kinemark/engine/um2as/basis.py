"""What UM²AS's files of a session were made from, by which its menu knows which of them are out of date.

`made.json` beside the files keeps, of each that a screen wrote, a key of its content and keys of all that the session
then said and it depends on. A file that is not as a screen wrote it, as those of the command line, tells nothing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...io.files import write_text
from ..keys import digest, file_key
from ..session import Session

MADE = "made.json"
ASPECT, CALIBRATION, MARK, THRESHOLD, START = (
    "The aspect ratio", "The calibration", "The reference marker", "The threshold", "The start-up information",
)  # fmt: skip
OF_BALLS = (ASPECT, CALIBRATION, THRESHOLD)
"""What `.cp` files depend on besides the files that they are made of."""
OF_MARK = (ASPECT, MARK)
"""The same of `.rf` files."""
OF_MARKERS = (ASPECT, CALIBRATION, MARK, THRESHOLD, START)
"""The same of `.da` files: other cameras propose by the calibration."""


def basis(session: Session, trial: str, of: Sequence[str]) -> dict[str, str]:
    """Keys of what a session says of these things, by their words."""
    s, entry = session.settings, session.trial(trial).entry
    c, root = s.calibration, session.root
    named = (c.file, c.control_points and c.control_points.points, c.control_frame and c.control_frame.rods)
    files = file_key(*(root / path for path in named if path))
    said: dict[str, Any] = {
        ASPECT: s.cameras.aspect_ratio or 1.0,
        CALIBRATION: (c.model_copy(update={"reference_marker": None}), files),
        MARK: c.reference_marker,
        THRESHOLD: (s.detect, s.detect_cameras),
        START: (s.digitise, entry.every, entry.frames),
    }
    return {words: digest(said[words]) for words in of}


def remember(folder: Path, files: Sequence[Path], made_of: Mapping[str, str]) -> None:
    """Keep what files in this folder were made of, which a screen has just written."""
    known = _known(folder) | {path.name: {"file": file_key(path), "of": dict(made_of)} for path in files}
    write_text(folder / MADE, json.dumps(known, indent=1) + "\n")


def changed(folder: Path, files: Sequence[Path], now: Mapping[str, str]) -> str:
    """What of it is otherwise now, in words; empty where nothing is, or nothing is known."""
    known = _known(folder)
    for path in files:
        one = known.get(path.name)
        if one is None or one["file"] != file_key(path):
            continue
        if other := [words for words, key in now.items() if one["of"].get(words) != key]:
            return f"{other[0]} was changed since: do it again."
    return ""


def _known(folder: Path) -> dict[str, Any]:
    """What was kept; nothing where it cannot be read."""
    try:
        return dict(json.loads((folder / MADE).read_text("utf-8")))
    except (OSError, ValueError):
        return {}
