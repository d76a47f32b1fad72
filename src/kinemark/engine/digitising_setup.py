"""The start of digitising, written into `session.toml`: the markers, the reference marker, where answers are kept."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tomlkit

from ..data import KinemarkError
from ..io.answers_csv import read_answers
from ..io.files import replacing
from .digitising import answer_files
from .session import Session
from .session_file_text import parsed, table_in
from .session_name import FILE
from .settings import read_settings

MOST_MARKERS = 30
"""Of a frame, the reference marker included; as UM²AS has it (thesis 3.5)."""


@dataclass(frozen=True, slots=True)
class DigitisingSetup:
    """What `[digitise]` says.

    Attributes:
        markers: their names, in the order in which they are asked for.
        reference: the one that does not move; None where there is none.
        confirm_reference: whether it is asked about in every frame.
        take_proposals: whether what the other cameras say is taken without a question.
        history: frames for which a hidden marker is remembered.
    """

    markers: tuple[str, ...]
    reference: str | None = None
    confirm_reference: bool = True
    take_proposals: bool = False
    history: int = 2


def set_up(root: Path, trial: str, setup: DigitisingSetup) -> None:
    """Write the start of digitising a trial; comments stay.

    Raises:
        KinemarkError: there are no markers or too many, an answer was given already, or the file would not be
            understood then.
    """
    if not 1 <= len(setup.markers) <= MOST_MARKERS:
        raise KinemarkError(f"There are {len(setup.markers)} markers. Name 1 to {MOST_MARKERS}.")
    session = Session.open(root)
    entry = session.trial(trial).entry
    if entry.images is None:
        raise KinemarkError(f"{trial} has no images: its detections were made elsewhere.")
    if entry.answers is not None:
        _check_unanswered(session, trial, entry.answers)
    document = parsed(root / FILE)
    table = table_in(document, "digitise")
    for key, value in asdict(setup).items():
        if value is None:
            table.pop(key, None)
        else:
            table[key] = list(value) if isinstance(value, tuple) else value
    own: Any = next(one for one in document["trials"] if one["name"] == trial)
    if "answers" not in own:
        own["answers"] = f"answers/{trial}/{{camera}}.csv"
    with replacing(root / FILE) as beside:
        beside.write_text(tomlkit.dumps(document), "utf-8")
        read_settings(beside)  # raises before anything is replaced


def _check_unanswered(session: Session, trial: str, pattern: str) -> None:
    """Answers are to the questions that the present markers lead to."""
    names = session.settings.cameras.names or session.calibrate().rig.names
    for path in answer_files(session.root, pattern, names).values():
        if n := len(read_answers(path)):
            raise KinemarkError(
                f"{path.name} has {n} answers, which are of the present markers. Take them back, or remove the file, "
                f"before {trial} is set up otherwise."
            )
