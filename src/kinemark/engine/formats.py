"""Any file that Kinemark knows: saying what is in it, and converting it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..data import Cloud, Detections, KinemarkError, Matches, Rig, Rods, Signals, Tracks, Trajectories, Trial
from ..io.formats import FORMATS, UNSAID, Content, Said, endings, holds, read_file, write_file
from ..io.images import ImageSource
from ..io.notes import FileNote
from ..io.tdf import Tdf
from ..io.trial import trial_in
from .session_name import FILE

if TYPE_CHECKING:
    from .session import Session


def describe(path: Path) -> dict[str, Any]:
    """What is in a file or a session, by name.

    Raises:
        KinemarkError: the kind of file is not known, or the file is damaged.
    """
    if _is_session(path):
        return _session(_open_session(path))
    found = read_file(path)
    describers: dict[type, Callable[[Any], dict[str, Any]]] = {
        Trial: _trial,
        Trajectories: lambda t: _trial(Trial("", t)),
        Signals: lambda s: {"holds": "signals", "signals": _signals(s)},
        Tdf: _tdf,
        Rig: _rig,
        Detections: _detections,
        Matches: lambda m: {"holds": "matches", "frames": m.n_frames, "groups": len(m)},
        Cloud: lambda c: {"holds": "points", "frames": c.n_frames, "points": len(c)},
        Tracks: lambda t: {"holds": "tracks", "frames": t.cloud.n_frames, "tracks": len(t), "points": len(t.cloud)},
        ImageSource: _images,
        Rods: lambda r: {"holds": "hanging rods", "rods": ", ".join(r.names), "markers on each": r.xyz.shape[1]},
        np.ndarray: lambda L: {"holds": "DLT parameters", "cameras": len(L)},
    }
    known = describers.get(type(found))
    return {"holds": holds(found)} if known is None else known(found)


def convert(
    source: Path,
    target: Path,
    *,
    what: Content | None = None,
    length_unit: str | None = None,
    rate_hz: float | None = None,
) -> tuple[FileNote, ...]:
    """Read one file and write its content in another format, the formats by the names' endings.

    Args:
        source: the file to read.
        target: the file to write.
        what: which part of it, where the ending of `target` leaves that open.
        length_unit: of a rig or C3D file that does not say it.
        rate_hz: of a CSV or TDC file that does not say it.

    Returns:
        What the target could not hold.

    Raises:
        KinemarkError: the target exists, its format does not hold what the source has, or the source is damaged.
    """
    if target.exists():
        raise KinemarkError(f"{target} exists, and nothing is overwritten. Name another file or remove it.")
    if rate_hz is not None and not 0 < rate_hz < np.inf:
        raise KinemarkError(f"--rate-hz is {rate_hz}, wanted a number above 0.")
    have = _contents(source, Said(rate_hz, length_unit, what))
    suffix = target.suffix.lower()
    fits = [content for content in have if suffix in endings(content) and what in (None, content)]
    if len(fits) != 1:
        held = FORMATS[suffix].write if suffix in FORMATS else ()
        raise KinemarkError(
            f"{source} has {', '.join(have) or 'nothing to convert'}; {suffix or 'no ending'} can hold "
            f"{' or '.join(held) or 'none of it'}. "
            + ("Say which with --what." if len(fits) > 1 else "Choose another ending.")
        )
    return write_file(target, fits[0], have[fits[0]])


def _contents(source: Path, said: Said) -> dict[Content, Any]:
    """What of a file can be written elsewhere."""
    found = _open_session(source) if _is_session(source) else read_file(source, said)
    if isinstance(found, np.ndarray):
        if said.length_unit is None:
            raise KinemarkError(f"{source} holds DLT parameters of an unknown unit. Say --length-unit m or mm.")
        from .calibration import rig_of_dlt  # takes long to import, and no other file needs it

        found = rig_of_dlt(source, (), said.length_unit)
    if (
        isinstance(found, Detections)
        and found.rate == UNSAID
        and said.rate_hz is None
        and source.suffix.lower() == ".csv"
    ):
        raise KinemarkError(f"{source} does not say its frame rate. Say --rate-hz.")
    parts: dict[Content, Any] = {"trajectories": trial_in(source.stem, found)}
    if isinstance(found, Tdf):
        parts |= {"detections": found.detections, "rig": found.rig}
    elif isinstance(found, (Detections, Rig)):
        parts["detections" if isinstance(found, Detections) else "rig"] = found
    return {content: part for content, part in parts.items() if part is not None}


def _is_session(path: Path) -> bool:
    return path.is_dir() or path.name == FILE


def _open_session(path: Path) -> Session:
    from .session import Session  # brings all stages, which takes long, and files need none

    return Session.open(path)


def _signals(signals: Signals) -> str:
    """How many there are of each kind."""
    return ", ".join(f"{n} of kind {kind}" for kind, n in Counter(s.kind for s in signals).items())


def _trial(trial: Trial) -> dict[str, Any]:
    """A trial."""
    t = trial.trajectories
    gaps = [stop - first for path in t for first, stop in path.gaps]
    return {
        "holds": "a trial",
        "markers": f"{len(t)}: {', '.join(t.names)}" if t.names else 0,
        **({"signals": _signals(trial.signals)} if len(trial.signals) else {}),
        "frames": t.n_frames,
        "first frame": t.first_frame,
        "rate": f"{t.rate:g} Hz",
        "duration": f"{t.n_frames / t.rate:.2f} s",
        "gaps": f"{len(gaps)}, longest {max(gaps, default=0)} frames",
        "analog": "; ".join(f"{len(a)} channels at {a.rate:g} Hz" for a in trial.analog) or "none",
        "force plates": len(trial.plates),
        "events": len(trial.events),
    }


def _tdf(tdf: Tdf) -> dict[str, Any]:
    """A BTS file."""
    facts: dict[str, Any] = {"holds": "a BTS recording"}
    if tdf.rig:
        facts["calibration"] = f"{len(tdf.rig)} cameras"
    if tdf.detections:
        facts |= {k: v for k, v in _detections(tdf.detections).items() if k != "holds"}
    if tdf.trajectories:
        facts |= {k: v for k, v in _trial(Trial("", tdf.trajectories)).items() if k in ("markers", "gaps")}
    facts["analog"] = "; ".join(f"{len(a)} channels at {a.rate:g} Hz" for a in tdf.analog) or "none"
    return facts | {"force plates": len(tdf.plates), "events": len(tdf.events)}


def _rig(rig: Rig) -> dict[str, Any]:
    """Calibrated cameras."""
    facts: dict[str, Any] = {"holds": "a calibrated rig", "method": rig.method or "unknown", "cameras": len(rig)}
    for c in rig:
        place = ", ".join(f"{x:.0f}" for x in c.centre)
        facts[c.name] = f"{c.size[0]} × {c.size[1]} px, focal length {c.K[0, 0]:.1f} px, at ({place}) mm"
    return facts


def _detections(d: Detections) -> dict[str, Any]:
    """2D points."""
    return {
        "holds": "2D points",
        "cameras": ", ".join(d.cameras),
        "frames": d.n_frames,
        "rate": f"{d.rate:g} Hz" if d.rate != UNSAID else "not said",
        "points": f"{len(d)}, {len(d) / max(d.n_frames * len(d.cameras), 1):.1f} a camera and frame",
    }


def _images(source: ImageSource) -> dict[str, Any]:
    """A video or images."""
    return {
        "holds": "video" if source.video else "images",
        "size": f"{source.size[0]} × {source.size[1]} px",
        "frames": source.n_frames,
        "rate": f"{source.rate:g} Hz" if source.rate else "not said",
    }


def _session(session: Session) -> dict[str, Any]:
    """A session folder."""
    s = session.settings
    return {
        "holds": f"the session {s.name!r}",
        "cameras": ", ".join(s.cameras.names) or "as calibrated",
        "trials": ", ".join(trial.name for trial in s.trials),
        "done": ", ".join(t.name for t in s.trials if (session.results / t.name / "quality.json").is_file()) or "none",
    }
