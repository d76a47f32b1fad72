"""What is in a file or a session: as data, and as lines for a person."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..data import Analog, Detections, Rig, Signals, Trajectories, Trial
from ..io.formats import UNKNOWN_RATE, ReadOptions, holds, read_file
from ..io.tdf import Tdf
from .put_aside import computed_names
from .session_name import FILE

if TYPE_CHECKING:
    from ..io.images import ImageSource
    from .session import Session


def describe(path: Path, options: ReadOptions = ReadOptions()) -> dict[str, Any]:  # noqa: B008  frozen
    """What is in a file or a session, by name: numbers, texts, and lists and tables of them.

    Args:
        path: a file, or the folder of a session.
        options: what the caller states of the file.

    Raises:
        KinemarkError: the kind of file is not known, or the file is damaged.
    """
    if is_session(path):
        return _session(open_session(path))
    found = read_file(path, options)
    describers: dict[str, Callable[[Any], dict[str, Any]]] = {
        "Trial": _trial,
        "Trajectories": lambda t: _trial(Trial("", t)),
        "Signals": lambda s: {"signals": _signals(s)},
        "Tdf": _tdf,
        "Rig": _rig,
        "Detections": _detections,
        "NamedDetections": lambda n: _detections(n.detections) | {"markers": list(n.names)},
        "Matches": lambda m: {"frames": m.n_frames, "groups": len(m)},
        "Cloud": lambda c: {"frames": c.n_frames, "points": len(c)},
        "Tracks": lambda t: {"frames": t.cloud.n_frames, "tracks": len(t), "points": len(t.cloud)},
        "ImageSource": _images,
        "Rods": lambda r: {"rods": list(r.names), "markers_on_each": int(r.xyz.shape[1])},
        "ndarray": lambda L: {"cameras": len(L)},
    }
    known = describers.get(type(found).__name__, lambda _: {})
    return {"holds": holds(found)} | known(found)


def is_session(path: Path) -> bool:
    """Whether a path is that of a session."""
    return path.is_dir() or path.name == FILE


def open_session(path: Path) -> Session:
    """The session at a path."""
    from .session import Session  # brings all stages, which takes long, and files need none

    return Session.open(path)


def _trial(trial: Trial) -> dict[str, Any]:
    t = trial.trajectories
    computed = _computed(trial)
    markers = [path for path in t if path.name not in computed]
    gaps = [stop - first for path in markers for first, stop in path.gaps]
    return {
        "markers": [path.name for path in markers],
        "computed_points": [name for name in t.names if name in computed],
        "never_seen": [path.name for path in markers if np.isnan(path.xyz).all()],
        "frames": t.n_frames,
        "first_frame": t.first_frame,
        "rate_hz": t.rate,
        "duration_s": t.n_frames / t.rate,
        "gaps": {"count": len(gaps), "longest_frames": max(gaps, default=0)},
        "signals": _signals(trial.signals),
        "analog": [_analog(a) for a in trial.analog],
        "force_plates": [{"type": p.type, "channels": list(p.channels)} for p in trial.plates],
        "events": _events(trial),
        "poses": [{"segments": list(p.names), "rate_hz": p.rate} for p in trial.poses],
        "about": dict(trial.about),
        "notes": list(trial.notes),
    }


def _computed(trial: Trial) -> tuple[str, ...]:
    """Points that a program computed of markers."""
    return computed_names(trial) if len(trial.trajectories) else ()


def _signals(signals: Signals) -> list[dict[str, Any]]:
    return [{"name": s.name, "kind": s.kind, "unit": s.unit, "rate_hz": s.rate} for s in signals]


def _analog(a: Analog) -> dict[str, Any]:
    samples = int(a.values.shape[1])
    return {
        "channels": list(a.names), "units": list(a.units), "rate_hz": a.rate, "samples": samples, "start_s": a.start
    }  # fmt: skip


def _events(trial: Trial | Tdf) -> list[dict[str, Any]]:
    e = trial.events
    rows = zip(e.label, e.side, e.time.tolist(), strict=True)
    return [{"label": label, "side": side, "time_s": time} for label, side, time in rows]


def _tdf(tdf: Tdf) -> dict[str, Any]:
    """A BTS file; what it does not hold is left out."""
    none = Trajectories((), 1.0)
    trial = Trial("", tdf.trajectories or none, tdf.analog, tdf.plates, tdf.events, about=tdf.about, notes=tdf.notes)
    facts = _trial(trial)
    if tdf.trajectories is None:
        facts = {key: facts[key] for key in ("analog", "force_plates", "events", "about", "notes")}
    calibration = {} if tdf.rig is None else {"calibration": _rig(tdf.rig)}
    seen = {} if tdf.detections is None else {"detections": _detections(tdf.detections)}
    return calibration | seen | facts


def _rig(rig: Rig) -> dict[str, Any]:
    """Calibrated cameras."""
    cameras = [
        {
            "name": c.name,
            "size_px": [int(n) for n in c.size],
            "focal_length_px": float(c.K[0, 0]),
            "centre_mm": c.centre.tolist(),
        }
        for c in rig
    ]
    return {"method": rig.method or None, "cameras": cameras}


def _detections(d: Detections) -> dict[str, Any]:
    rate = d.rate if d.rate != UNKNOWN_RATE else None
    return {"cameras": list(d.cameras), "frames": d.n_frames, "rate_hz": rate, "points": len(d)}


def _images(source: ImageSource) -> dict[str, Any]:
    return {
        **({"holds": "a video"} if source.video else {}),
        "size_px": [int(n) for n in source.size],
        "frames": source.n_frames,
        "rate_hz": source.rate or None,
    }


def _session(session: Session) -> dict[str, Any]:
    s = session.settings
    done = [t.name for t in s.trials if (session.results / t.name / "quality.json").is_file()]
    return {
        "holds": "a session",
        "name": s.name,
        "cameras": list(s.cameras.names),
        "trials": [trial.name for trial in s.trials],
        "done": done,
    }


# For a person


def described(facts: Mapping[str, Any]) -> list[str]:
    """The same as lines; what there is none of is left out."""
    lines = []
    for key, value in facts.items():
        if key in ("notes", "about"):
            items = value.items() if key == "about" else (("note", text) for text in value)
            lines += [f"{name}: {text}" for name, text in items]
        elif isinstance(value, Mapping) and key not in IN_WORDS:
            lines += [f"{key}: {line}" for line in described(value)]
        elif value is not None and value != []:
            lines.append(f"{LABELS.get(key, key.replace('_', ' '))}: {IN_WORDS.get(key, _plain)(value)}")
    return lines


def _plain(value: Any) -> str:
    if isinstance(value, list):
        return f"{len(value)}: {', '.join(map(str, value))}"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _camera(c: Mapping[str, Any]) -> str:
    place = ", ".join(f"{x:z.0f}" for x in c["centre_mm"])
    size = " × ".join(map(str, c["size_px"]))
    return f"\n    {c['name']}: {size} px, focal length {c['focal_length_px']:.1f} px, at ({place}) mm"


def _kinds(signals: list[Mapping[str, Any]]) -> str:
    """How many of each: `58 angles, 16 powers`."""
    each = Counter("EMG channel" if s["kind"] == "emg" else s["kind"] for s in signals)
    return ", ".join(f"{n} {kind}{'' if n == 1 else 's'}" for kind, n in each.items())


def _cameras(value: Any) -> str:
    """Calibrated ones with their places, or names."""
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        return f"{len(value)}{''.join(map(_camera, value))}"
    return ", ".join(value) if isinstance(value, list) else str(value)


LABELS = {
    "computed_points": "computed of markers",
    "never_seen": "never seen",
    "rate_hz": "rate",
    "duration_s": "duration",
    "size_px": "size",
    "force_plates": "force plates",
}
IN_WORDS: dict[str, Callable[[Any], str]] = {
    "rate_hz": lambda rate: f"{rate:g} Hz",
    "duration_s": lambda seconds: f"{seconds:.2f} s",
    "size_px": lambda size: f"{size[0]} × {size[1]} px",
    "gaps": lambda gaps: f"{gaps['count']}, longest {gaps['longest_frames']} frames",
    "signals": _kinds,
    "analog": lambda records: "; ".join(f"{len(a['channels'])} channels at {a['rate_hz']:g} Hz" for a in records),
    "force_plates": lambda plates: str(len(plates)),
    "events": lambda events: str(len(events)),
    "poses": lambda poses: "; ".join(f"{len(p['segments'])} segments at {p['rate_hz']:g} Hz" for p in poses),
    "cameras": _cameras,
    "trials": ", ".join,
    "done": ", ".join,
    "rods": ", ".join,
}
"""How a figure is put for a person; the unit stands in its name."""
