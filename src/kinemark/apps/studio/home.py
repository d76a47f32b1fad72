"""The cards of Home, from what stands on disk: nothing is processed for them."""

from __future__ import annotations

import getpass
from contextlib import suppress
from pathlib import Path
from typing import Any

from ...data import KinemarkError, Step, Trial
from ...data.edits import Entry, Signed, is_named, live
from ...engine.editing.journal import Journal
from ...engine.keys import code_key
from ...engine.open_trial import OpenTrial
from ...engine.session import Session
from ...engine.session_name import FILE
from ...engine.store import STEPS, Store
from ...findings.verdict import grade_shown
from ...io.files import read_json
from ...io.trial import read_trial
from ...version import __version__
from . import session_gait
from .messages import Home, Last, SessionCard, TrialCard, TrialState
from .shelf import Place, Shelf

QUALITY = "quality.json"
STALE = "Settings, edits or the program changed since it was run. Run it again: what was said of it is kept."


def home(shelf: Shelf, failed: dict[str, str], looked: dict[str, int | None]) -> Home:
    """All that may be opened.

    Args:
        shelf: what there is. failed: by id, why a run of a trial came to nothing.
        looked: by id, problems that are worth a look of the trials in which they were looked for.
    """
    sessions = [_session(folder, failed, looked) for folder in shelf.sessions()]
    files = [_file(place, looked) for place in shelf.files()]
    return Home(sessions=sessions, files=files, version=__version__, by=user())


def user() -> str:
    """Whose account it is."""
    with suppress(KeyError, OSError):
        return getpass.getuser()
    return "unknown"


def last_of(entries: tuple[Entry, ...]) -> Last | None:
    """Who spoke last."""
    return Last(by=entries[-1].by, at=entries[-1].at) if entries else None


def _session(folder: Path, failed: dict[str, str], looked: dict[str, int | None]) -> SessionCard:
    key = Place(folder).id
    try:
        session = Session.open(folder)
    except KinemarkError as error:
        return SessionCard(id=key, title=folder.name, folder=folder.name, trials=[], words=str(error))
    trials = [_trial(session.trial(name), Place(folder, name), failed, looked) for name in session.names]
    return SessionCard(
        id=key, title=session.settings.name, folder=folder.name, trials=trials, gait=session_gait.state(session)
    )


def _trial(trial: OpenTrial, place: Place, failed: dict[str, str], looked: dict[str, int | None]) -> TrialCard:
    """A trial by its last run and its journal."""
    journal = Journal.of(trial.workspace.root, trial.name)
    entries, quality = journal.entries, figures(trial.folder / QUALITY)
    words = failed.get(place.id, "")
    found: TrialState = "failed" if words else state(trial, entries)
    counted = _counts(quality)
    return TrialCard(
        id=place.id,
        name=trial.name,
        state=found,
        verdict=grade_shown(quality["verdict"]) if quality else "",
        problems=looked.get(place.id),
        edits=len(live(entries)),
        last=last_of(entries),
        words=words or (STALE if found == "stale" else ""),
        **counted,
    )


def _counts(quality: dict[str, Any]) -> dict[str, Any]:
    """Frames, rate and markers of a trial's figures."""
    if not quality:
        return {}
    recording, names = quality["recording"], [one["name"] for one in quality["trajectories"]["markers"]]
    return {
        "frames": recording["frames"],
        "rate": recording["rate_hz"],
        "markers": len(names),
        "named": sum(map(is_named, names)),
    }


def state(trial: OpenTrial, entries: tuple[Entry, ...]) -> TrialState:
    """How far a trial is, and whether anything was said or set since."""
    done = Store.read(trial.folder).old
    if "track" not in done:
        return "not run"
    if other_program(done["track"]):
        return "stale"
    said = live(entries)
    if said and any(isinstance(edit, Signed) for edit in said[-1].edits):
        return "signed"
    if "write" in done:
        return "stale" if newer(trial) else "done"
    return "filled" if "fill" in done else "tracked"


def other_program(step: Step) -> str:
    """In words that another Kinemark did a stage than this one, whose results are its own; nothing else."""
    version, _, code = step.version.partition("+")
    if code == code_key():
        return ""
    was = f"Kinemark {version}" if version != __version__ else f"another state of Kinemark {version}"
    return f"It was run by {was}, and this one may find other numbers."


def newer(trial: OpenTrial) -> bool:
    """Whether the settings or the journal were written after the last run."""
    root = trial.workspace.root
    given = (root / FILE, Journal.of(root, trial.name).path)
    ran = written(trial.folder / STEPS)
    return any(written(path) > ran for path in given)


def written(path: Path) -> int:
    """When a file was written, ns; 0 where there is none."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _file(place: Place, looked: dict[str, int | None]) -> TrialCard:
    """A file by its journal; it is read when it is opened."""
    entries = Journal.of(place.path.parent, place.path.stem).entries
    said = live(entries)
    signed = bool(said) and any(isinstance(edit, Signed) for edit in said[-1].edits)
    counted, words = _read(place.path, written(place.path))
    found: TrialState = "failed" if words else "signed" if signed else "tracked"
    return TrialCard(
        id=place.id, name=place.name, state=found, problems=looked.get(place.id), edits=len(said),
        last=last_of(entries), words=words, **counted,
    )  # fmt: skip


_KNOWN: dict[Path, tuple[int, dict[str, Any], str]] = {}
_LAST: list[tuple[Path, int, Trial]] = []
"""The file that was read last, until it is opened: where there is one, it is the one that is looked at."""


def _read(path: Path, changed: int) -> tuple[dict[str, Any], str]:
    """What a file holds, read once; and why it cannot be read."""
    if path not in _KNOWN or _KNOWN[path][0] != changed:
        try:
            trial = read_trial(path)
            found, _LAST[:] = trial.trajectories, [(path, changed, trial)]
            named = sum(map(is_named, found.names))
            counted = {"frames": found.n_frames, "rate": found.rate, "markers": len(found), "named": named}
            _KNOWN[path] = changed, counted, ""
        except KinemarkError as error:
            _KNOWN[path] = changed, {}, str(error)
    return _KNOWN[path][1:]


def read_once(path: Path) -> Trial | None:
    """The trial of a file as Home has just read it; None where it read another one since, or the file changed."""
    known = next(((was, trial) for where, was, trial in _LAST if where == path), None)
    if known is None or known[0] != written(path):
        return None
    _LAST.clear()
    return known[1]


def figures(path: Path) -> dict[str, Any]:
    """What a file of figures holds; nothing where it is absent or of another version."""
    found = read_json(path)
    return found if "verdict" in found else {}
