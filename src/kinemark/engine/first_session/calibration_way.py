"""Which recording calibrates the cameras, which ones go with it, and what must be asked as no file says it."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Literal

from .proposal import NAMING, FoundRecording, Question, Reason, Role, SessionProposal, day_in, parsed

ASKED = (Role.WAND, Role.SINGLE_MARKER)
"""What a recording that is called a calibration may be where no file of rods or control points is there."""
WAYS = (Role.RIG, Role.CONTROL_FRAME, Role.CONTROL_POINTS, Role.WAND, Role.SINGLE_MARKER)
"""In the order in which they are taken where recordings allow several: what asks least comes first."""


def completed(proposal: SessionProposal) -> SessionProposal:
    """The same with the way to the calibration, what goes beside it, and the questions, by the recordings' roles."""
    recordings = tuple(_sided(proposal.recordings))
    ways = [one for role in WAYS for one in recordings if one.role is role and _usable(one, recordings)]
    ways.sort(key=lambda one: _of_another_day(one, proposal.date))
    way = ways[0] if ways else None
    free = way is not None and way.role in ASKED
    beside = tuple(
        one
        for one in recordings
        if (one.role is Role.L_FRAME and free)
        or (one.role is Role.GRID and way is not None and way.role is not Role.RIG)
    )
    notes = [note for note in proposal.notes if note.kind not in OWN_NOTES]
    notes += [Reason("also_calibrates", {"path": one.path, "role": str(one.role)}) for one in ways[1:]]
    if way is not None and _of_another_day(way, proposal.date):
        notes.append(Reason("calibrated_another_day", {"path": way.path, "day": day_in(way.path)}))
    if way is None:
        notes.append(Reason("no_calibration"))
        pictures = [one for one in recordings if one.role in TARGETS and one.content == "images"]
        notes += [Reason("no_target_file", {"path": one.path}) for one in pictures if (one.frames or 0) < MOVING]
    if not any(one.role in (Role.TRIAL, Role.STATIC) for one in recordings):
        notes.append(Reason("no_trials"))
    whole = replace(proposal, recordings=recordings, way=way, beside=beside, notes=tuple(notes))
    return replace(whole, questions=tuple(_questions(whole)))


UNITLESS = ("holds_dlt", "holds_rig_without_unit")
"""Why a file is a calibration that does not say its unit of length."""
MOVING = 30
"""Images of a camera, from which on a recording may be of a wand in motion; chosen."""
TARGETS = (Role.CALIBRATION, Role.CONTROL_FRAME)
RATE = Question("rate_hz")
OWN_NOTES = ("no_target_file", "also_calibrates", "calibrated_another_day", "no_calibration", "no_trials")


def _sided(recordings: Iterable[FoundRecording]) -> Iterator[FoundRecording]:
    """Pictures that are called a calibration, or as a file of points is, go with the file of rods or points."""
    found = tuple(recordings)
    contents = {one.content for one in found}
    points = {PurePosixPath(one.path).stem: one.path for one in found if one.content == "points"}
    for one in found:
        if one.why.kind == "no_word" and one.frames == 1 and one.content == "images" and one.name in points:
            why = Reason("still_of_points", {"path": points[one.name]})
            yield replace(one, role=Role.CONTROL_POINTS, why=why)
        elif one.role is Role.CALIBRATION and one.content == "images":
            role = Role.CONTROL_FRAME if "rods" in contents else Role.CONTROL_POINTS if "points" in contents else None
            yield one if role is None else replace(one, role=role)
        elif one.role is Role.CONTROL_FRAME and one.content == "images" and "rods" not in contents:
            yield replace(one, role=Role.CONTROL_POINTS) if "points" in contents else one
        else:
            yield one


def _of_another_day(one: FoundRecording, day: str) -> bool:
    """Whether the name of a recording says another day than that of the trials; cameras may have been moved since."""
    return bool(day) and day_in(one.path) not in ("", day)


def _usable(one: FoundRecording, recordings: Iterable[FoundRecording]) -> bool:
    """Whether a recording can be the way; rods are named through their pictures, and points by themselves."""
    contents = {other.content for other in recordings}
    if one.role is Role.CONTROL_FRAME:
        return one.content == "images" and "rods" in contents
    if one.role is Role.CONTROL_POINTS:
        return one.content == "points"
    return True


def _questions(proposal: SessionProposal) -> Iterator[Question]:
    """What no file tells."""
    way = proposal.way
    if proposal.rate is None and any(one.content in ("images", "detections") for one in proposal.trials):
        yield RATE
    if way is None:
        moving = [one for one in proposal.recordings if one.role is Role.CALIBRATION and (one.frames or 0) >= MOVING]
        yield from (Question("calibration.way", 0, 0, tuple(map(str, ASKED)), about=one.path) for one in moving[:1])
    elif way.why.kind in UNITLESS:
        yield Question("calibration.length_unit", 0, 0, ("mm", "cm", "m", "in"), about=way.path)
    elif way.role is Role.WAND:
        yield Question("calibration.wand.lengths_mm", 1, 4, about=way.path)
        yield Question("calibration.wand.marker_diameter_mm", about=way.path, optional=True)
    elif way.role is Role.CONTROL_POINTS:
        yield Question("calibration.control_points.marker_diameter_mm", about=way.path, optional=True)
    filmed = any(one.content == "images" for one in proposal.trials)
    if way is not None and way.role in ASKED and way.content == "detections" and not filmed:
        yield Question("cameras.size_px", 2, 2, whole=True, about=way.path)
    for one in proposal.beside:
        if one.role is Role.L_FRAME:
            yield Question("calibration.l_frame.arms_mm", 2, 2, about=one.path)
            yield Question("calibration.l_frame.height_mm", about=one.path, optional=True)
        else:
            yield Question("calibration.linearisation.grid", 2, 2, whole=True, about=one.path)
            yield Question("calibration.linearisation.pitch_mm", about=one.path)


def answered(proposal: SessionProposal, key: str, text: str) -> SessionProposal:
    """The same with one more answer, as it was typed; numbers are separated by commas or blanks.

    The rate may be stated where a file tells it too: videos are often played slower than they were recorded.

    Raises:
        ValueError: there is no such question, or the text does not answer it.
    """
    question = next((one for one in (*proposal.questions, RATE) if one.key == key), None)
    if question is None:
        known = ", ".join(one.key for one in proposal.questions) or "none"
        raise ValueError(f"{key} is not asked; there are {known}")
    said = parsed(question, text)
    if key == "calibration.way":
        return with_role(proposal, question.about, Role(str(said)))
    return replace(proposal, answers={**proposal.answers, key: said})


def with_role(proposal: SessionProposal, path: str, role: Role) -> SessionProposal:
    """The same with a recording that is for something else, as a person says.

    Raises:
        ValueError: there is no such recording, or it cannot be for that.
    """
    contents = {one.path: one.content for one in proposal.recordings}
    if path not in contents:
        raise ValueError(f"{path} is none of the recordings")
    allowed = NAMING.get(contents[path])
    fits = role in allowed if allowed else role not in (Role.TEMPLATE, Role.STATIC_TEMPLATE)
    if not fits and role is not Role.UNUSED:
        raise ValueError(_unfit(path, allowed))
    why = Reason("stated", {"role": str(role)})
    changed = [replace(one, role=role, why=why) if one.path == path else one for one in proposal.recordings]
    return completed(replace(proposal, recordings=tuple(changed)))


def _unfit(path: str, allowed: Sequence[Role] | None) -> str:
    """Why a recording cannot have a role that was said."""
    if allowed is None:
        return f"{path} is no labelled trial, so that it names no markers; C3D, TRC and .template.h5 files can"
    return f"{path} holds no images or 2D points: it may be {', '.join(map(str, allowed))} or {Role.UNUSED}"


def with_facts(
    proposal: SessionProposal,
    *,
    name: str | None = None,
    date: str | None = None,
    rate: float | None = None,
    interlaced: Literal[False, "top", "bottom"] | None = None,
    names: Mapping[str, str] | None = None,
) -> SessionProposal:
    """The same with what a person says of the whole; what is None stays as it was guessed.

    Args:
        proposal: that is changed.
        name: of the session; date: of the recording, YYYY-MM-DD, empty for none.
        rate: Hz of frames, of fields where interlaced.
        interlaced: the field that was taken first, False for whole frames.
        names: of trials, by the paths of their recordings.

    Raises:
        ValueError: the rate is not above 0, the date is none, or a recording is not there.
    """
    if rate is not None and not 0 < rate < float("inf"):
        raise ValueError(f"{rate} Hz is no rate; wanted is a number above 0")
    if date:
        datetime.date.fromisoformat(date)
    if strange := sorted({*(names or {})} - {one.path for one in proposal.recordings}):
        raise ValueError(f"{strange[0]} is none of the recordings")
    said = Reason("stated")
    called = tuple(replace(one, name=(names or {}).get(one.path, one.name)) for one in proposal.recordings)
    found = replace(proposal, recordings=called, name=name or proposal.name)
    found = found if date is None else replace(found, date=date)
    found = found if rate is None else replace(found, rate=rate, rate_why=said)
    found = found if interlaced is None else replace(found, interlaced=interlaced, interlaced_why=said)
    return completed(found)
