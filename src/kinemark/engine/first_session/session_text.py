"""A proposal as the text of a `session.toml`: what is known as settings, the rest as comments that say what is wanted.

Lines that begin with `# ?` are settings that want a value; without the mark and with the value they hold.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.items import Table

from ...data import KinemarkError
from ...data.typed import typed
from ...io.control_points import PointedPoints, write_pointed
from ...io.um2as import read_msr
from ...report.words.first_session import HEAD, question_text, reason_text
from ..session_name import FILE, MARK
from .calibration_way import UNITLESS
from .proposal import FoundRecording, Role, SessionProposal

MEASURED = ".msr"
"""The ending of UM²AS's measured places of control balls."""


def session_text(proposal: SessionProposal) -> str:
    """The text of `session.toml`."""
    document = tomlkit.document()
    for line in HEAD:
        document.add(tomlkit.comment(line))
    document.add(tomlkit.nl())
    document["name"] = proposal.name
    if proposal.date:
        document["date"] = tomlkit.date(proposal.date)
    _add_rate(document, proposal)
    document.add(tomlkit.nl())
    document["cameras"] = _cameras(proposal)
    document["calibration"] = calibration_table(proposal)
    if proposal.inverted_why is not None:
        detect = tomlkit.table()
        detect["inverted"] = tomlkit.item(True).comment(reason_text(proposal.inverted_why))
        detect.add(tomlkit.nl())
        document["detect"] = detect
    if (label := _label(proposal)).value.body:
        document["label"] = label
    if proposal.trials:
        document["trials"] = _trials(proposal.trials)
    text = tomlkit.dumps(document).rstrip("\n") + "\n"
    rest = [f"# {line}" for line in _rest(proposal)]
    return text + ("\n" + "\n".join(rest) + "\n" if rest else "")


def write_first_session(proposal: SessionProposal) -> Path:
    """Write `session.toml` into the folder; an existing one is not touched.

    Raises:
        KinemarkError: there is one already, or the folder cannot be written.
    """
    path = proposal.folder / FILE
    text = session_text(proposal)
    if path.exists():
        raise existing(path)
    points_of_measured(proposal)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise existing(path) from error
    except OSError as error:
        raise KinemarkError(f"{path} cannot be written: {error}. Choose a place that you may write to.") from error
    return path


def existing(path: Path) -> KinemarkError:
    """The error where a session is there already."""
    return KinemarkError(
        f"{path} is there already and is not overwritten. Rename it, or go on: kinemark calibrate {typed(path.parent)}"
    )


def points_file(path: str) -> str:
    """The CSV file of control points; one of UM²AS's measured places is written anew beside it."""
    return path.removesuffix(MEASURED) + ".csv" if path.endswith(MEASURED) else path


def points_of_measured(proposal: SessionProposal) -> None:
    """Measured places that calibrate are written as the control points of a session, unless they are there already."""
    if proposal.way is None or not proposal.way.path.endswith(MEASURED):
        return
    measured = proposal.folder / proposal.way.path
    target = measured.with_suffix(".csv")
    if not target.exists():
        xyz = read_msr(measured)
        write_pointed(target, PointedPoints.unseen([str(n + 1) for n in range(len(xyz))], xyz))


def _add_rate(document: tomlkit.TOMLDocument, proposal: SessionProposal) -> None:
    answer = proposal.answers.get("rate_hz")
    if isinstance(answer, tuple):
        document["rate_hz"] = _number(answer[0])
    elif proposal.rate is not None:
        document["rate_hz"] = tomlkit.item(_number(round(proposal.rate, 6))).comment(reason_text(proposal.rate_why))
    else:
        document.add(tomlkit.comment(f"{MARK} rate_hz = ?  # {reason_text(proposal.rate_why)}"))


def _cameras(proposal: SessionProposal) -> Table:
    table = tomlkit.table()
    if proposal.cameras:
        table["names"] = tomlkit.item(list(proposal.cameras)).comment(reason_text(proposal.cameras_why))
    else:
        table.add(tomlkit.comment(f"{MARK} names = [?, ?]  # {reason_text(proposal.cameras_why)}"))
    if any(one.content == "images" for one in proposal.recordings):
        table["interlaced"] = tomlkit.item(proposal.interlaced).comment(reason_text(proposal.interlaced_why))
    size = proposal.answers.get("cameras.size_px")
    if isinstance(size, tuple):
        table["size_px"] = [int(n) for n in size if not isinstance(n, str)]
    elif any(one.key == "cameras.size_px" for one in proposal.open):
        table.add(tomlkit.comment(f"{MARK} size_px = [?, ?]  # width and height of all images, which no file says"))
    table.add(tomlkit.nl())
    return table


def calibration_table(proposal: SessionProposal) -> Table:
    """The way, and beside it what is known whole; the rest is commented out."""
    table = tomlkit.table()
    rows = [*([proposal.way] if proposal.way else []), *proposal.beside]
    scaled = "calibration.l_frame.arms_mm" in proposal.answers
    for one in rows:
        key, said = str(one.role), _said(one, proposal)
        unknown = any(value is None for value in said.values())
        unscaled = one.role is Role.SINGLE_MARKER and not scaled
        if one.role is Role.RIG:
            _add_rig(table, one, proposal)
        elif unknown or unscaled:
            table.add(tomlkit.comment(f"{MARK} {key} = {_open(said)}  # {reason_text(one.why)}"))
            wants = [question_text(want) for want in proposal.open if want.key.startswith(f"calibration.{key}.")]
            for want in [*wants, *([UNSCALED] if unscaled else [])]:
                table.add(tomlkit.comment(f"  {want}"))
        else:
            table[key] = tomlkit.inline_table()
            table[key].update(said)
            table[key].comment(reason_text(one.why))
    if not rows:
        for question in proposal.open:
            if question.key == "calibration.way":
                table.add(tomlkit.comment(f'{MARK} wand = {{ images = "{question.about}", lengths_mm = [?] }}'))
                table.add(tomlkit.comment(f"  {question_text(question)}"))
        table.add(tomlkit.comment(f"{MARK} {NO_WAY}"))
    table.add(tomlkit.nl())
    return table


UNNAMED = "name the markers of one trial in kinemark studio (Labels): the others are named by it"
UNSCALED = "a single marker does not tell the scale: give an l_frame below, or distance = { mm = ?, images = ? } in it"
NO_WAY = "file, control_points, control_frame, wand or single_marker: exactly one is wanted; see docs/session.md"


def _add_rig(table: Table, one: FoundRecording, proposal: SessionProposal) -> None:
    """A ready-made calibration; DLT parameters and the TOML files of some programs do not say their unit."""
    table["file"] = tomlkit.item(one.path).comment(reason_text(one.why))
    unit = proposal.answers.get("calibration.length_unit")
    if isinstance(unit, str):
        table["length_unit"] = unit
    elif one.why.kind in UNITLESS:
        table.add(tomlkit.comment(f'{MARK} length_unit = "?"  # mm, cm, m or in, which the file does not say'))


def _said(one: FoundRecording, proposal: SessionProposal) -> dict[str, Any]:
    """What the table of a recording says; None for what is not known."""
    key = f"calibration.{one.role}"

    def answer(name: str, *, whole: bool = False) -> Any:
        said = proposal.answers.get(f"{key}.{name}")
        return None if said is None else [int(n) if whole else _number(n) for n in said if not isinstance(n, str)]

    source: dict[str, Any] = {one.content: one.path}
    thick = answer("marker_diameter_mm")
    spheres = {"marker_diameter_mm": thick[0]} if thick else {}
    if one.role is Role.WAND:
        return {**source, "lengths_mm": answer("lengths_mm"), **spheres}
    if one.role is Role.L_FRAME:
        height = answer("height_mm")
        return {**source, "arms_mm": answer("arms_mm"), **({"height_mm": height[0]} if height else {})}
    if one.role is Role.GRID:
        pitch = answer("pitch_mm")
        return {"grid": answer("grid", whole=True), "pitch_mm": pitch and pitch[0], **source}
    if one.role is Role.CONTROL_FRAME:
        rods = next(other.path for other in proposal.recordings if other.content == "rods")
        return {"rods": rods, **source}
    if one.role is Role.CONTROL_POINTS:
        pictures = [o.path for o in proposal.recordings if o.role is one.role and o.content == "images"]
        return {"points": points_file(one.path), **({"images": pictures[0]} if pictures else {}), **spheres}
    return source


def _open(said: dict[str, Any]) -> str:
    """A table with question marks for what is not known."""
    lists = ("lengths_mm", "arms_mm", "grid")
    parts = [
        f"{name} = {('[?]' if name in lists else '?') if value is None else tomlkit.item(value).as_string()}"
        for name, value in said.items()
    ]
    return f"{{ {', '.join(parts)} }}"


def _label(proposal: SessionProposal) -> Table:
    """What names the markers: labelled trials and kept templates, and static ones, else the trial that is named first.

    Empty where there are no trials, or several subjects, who each want a table.
    """
    table = tomlkit.table()
    for key, role in (("template", Role.TEMPLATE), ("static", Role.STATIC_TEMPLATE)):
        if own := [one for one in proposal.recordings if one.role is role]:
            table[key] = tomlkit.item([one.path for one in own]).comment(reason_text(own[0].why))
    several = any(one.why.kind == "several_subjects" for one in proposal.recordings)
    if not table and proposal.trials and not several:
        table.comment(UNNAMED)
    if table or table.trivia.comment:
        table.add(tomlkit.nl())
    return table


def _trials(trials: Iterable[FoundRecording]) -> Any:
    tables = tomlkit.aot()
    for one in trials:
        table = tomlkit.table()
        table["name"] = tomlkit.item(one.name).comment(reason_text(one.why))
        table[one.content] = one.path
        if one.role is Role.STATIC:
            table["kind"] = "static"
        table.add(tomlkit.nl())
        tables.append(table)
    return tables


def _rest(proposal: SessionProposal) -> list[str]:
    """What contradicts itself, and what is not used and why."""
    lines = [reason_text(note) for note in proposal.notes]
    naming = [one for one in proposal.recordings if one.role in (Role.TEMPLATE, Role.STATIC_TEMPLATE)]
    used = {
        one.path for one in (*naming, *proposal.trials, *proposal.beside, *([proposal.way] if proposal.way else []))
    }
    used |= {note.values["path"] for note in proposal.notes if note.kind == "also_calibrates"}
    with_way = (Role.CONTROL_FRAME, Role.CONTROL_POINTS)
    for one in proposal.recordings:
        rods = proposal.way is not None and one.role is proposal.way.role and one.role in with_way
        if one.path not in used and not rods:
            lines.append(f"not used: {one.path}: {reason_text(one.why)}")
    lines += [f"{one.path}: cameras have different numbers of images" for one in proposal.trials if one.unequal]
    return lines


def _number(value: float) -> float | int:
    """Whole numbers without a fraction."""
    return int(value) if float(value).is_integer() else float(value)
