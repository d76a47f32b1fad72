"""Another way of calibrating an existing session: what its recordings allow, what must be asked, what is written.

`[calibration]` is written anew; fixed marks and lenses stay, and so does everything else, with its comments. Former
calibrations are kept among the results.
"""

from __future__ import annotations

from collections.abc import Mapping, Set
from pathlib import Path

from tomlkit import TOMLDocument

from ..data import KinemarkError
from ..data.errors import users_mistake
from ..report.words.first_session import question_text
from .first_session import (
    FoundRecording,
    Role,
    SessionProposal,
    answered,
    calibration_table,
    propose_session,
    with_role,
)
from .first_session.calibration_way import MOVING, WAYS
from .first_session.session_text import points_of_measured
from .session import Session
from .session_changes import parsed, write_session
from .session_name import FILE

STAYS = ("reference_marker", "mark_reach_px", "mark_tolerance_px", "linearisation")
"""Keys of `[calibration]` that go with any way; a world frame goes with a wand or a single marker alone."""
WORLD = ("l_frame", "world_points")


def ways_of(root: Path) -> list[SessionProposal]:
    """What each recording of a session would be as its calibration, `way` and `questions` of each.

    Raises:
        KinemarkError: the session cannot be read, or its folder has no recordings.
    """
    trials = {entry.images for entry in Session.open(root).settings.trials}
    proposal = propose_session(root)
    contents = {one.content for one in proposal.recordings}
    found = []
    for one in proposal.recordings:
        for role in _roles(one, contents):
            if one.path not in trials and (made := as_way(proposal, one.path, role)).way is not None:
                found.append(made)
    return found


def as_way(proposal: SessionProposal, path: str, role: Role) -> SessionProposal:
    """The proposal with one recording as the way to the calibration, and no other.

    Raises:
        ValueError: there is no such recording.
    """
    for other in proposal.recordings:
        beside = role is Role.CONTROL_POINTS and other.role is role and other.content == "images"
        if other.path != path and other.role in WAYS and not beside:
            proposal = with_role(proposal, other.path, Role.UNUSED)
    return with_role(proposal, path, role)


def change_way(root: Path, path: str, role: Role, answers: Mapping[str, str]) -> None:
    """Calibrate the session by another recording from now on.

    Args:
        root: the session's folder.
        path: of the recording. role: what it is. answers: as typed, by the keys of its questions.

    Raises:
        KinemarkError: there is no such way, an answer is wanted or none, or the file would not be understood.
    """
    one = next((p for p in ways_of(root) if p.way is not None and (p.way.path, p.way.role) == (path, role)), None)
    if one is None or one.way is None:
        raise KinemarkError(f"{path} cannot calibrate this session by {role}. Look at the list again.")
    for key, text in answers.items():
        if text.strip():
            with users_mistake():
                one = answered(one, key, text)
    if wanted := [ask for ask in one.open if ask.key.startswith("calibration.")]:
        raise KinemarkError(f"Asked is: {question_text(wanted[0])}")
    points_of_measured(one)
    document = parsed(root / FILE)
    _put(document, one)
    _write(root / FILE, document)


def _roles(one: FoundRecording, contents: Set[str]) -> tuple[Role, ...]:
    """What a recording may be as a calibration."""
    if one.content == "rig":
        return (Role.RIG,)
    if one.content == "points":
        return (Role.CONTROL_POINTS,)
    if one.content == "images" and one.role in (Role.CONTROL_FRAME, Role.CALIBRATION) and "rods" in contents:
        return (Role.CONTROL_FRAME,)
    if one.role in (Role.WAND, Role.SINGLE_MARKER):
        return (one.role,)
    moving = one.content in ("images", "detections") and (one.frames or 0) >= MOVING
    return (Role.WAND, Role.SINGLE_MARKER) if moving and one.role is not Role.STATIC else ()


def _put(document: TOMLDocument, proposal: SessionProposal) -> None:
    """The new table in place of the old one, of which stays what goes with both."""
    old, new = document["calibration"].unwrap(), calibration_table(proposal)
    assert proposal.way is not None
    stays = (*STAYS, *(WORLD if proposal.way.role in (Role.WAND, Role.SINGLE_MARKER) else ()))
    del document["calibration"]
    document["calibration"] = new
    for key in stays:
        if key in old and key not in new and not (key in WORLD and any(one in new for one in WORLD)):
            document["calibration"][key] = old[key]


def _write(file: Path, document: TOMLDocument) -> None:
    """Whole or not at all; a `[calibrate]` that is of the former way goes with it."""
    try:
        write_session(file, document)
    except KinemarkError:
        if "calibrate" not in document:
            raise
        del document["calibrate"]
        write_session(file, document)
