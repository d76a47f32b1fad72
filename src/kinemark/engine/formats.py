"""Any file that Kinemark knows: reading it, saying what is in it, and converting it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..data import Cloud, Detections, KinemarkError, Matches, Rig, Rods, Tracks, Trajectories, Trial
from ..geometry import to_dlt
from ..io.c3d import markers, read_c3d, write_c3d
from ..io.detections_csv import read_detections_csv, write_detections_csv
from ..io.dlt_csv import read_dlt_csv, write_dlt_csv
from ..io.images import ImageSource, open_images
from ..io.number_text import read_text
from ..io.records import load, save
from ..io.rig_toml import read_rig_toml, write_rig_toml
from ..io.rods_toml import read_rods
from ..io.tdf import Tdf, read_tdf
from ..io.trajectories_csv import read_trajectories_csv, write_trajectories_csv
from ..io.trc import read_trc, write_trc
from ..io.um2as import trajectories_of_tdc
from ..track import to_trajectories
from .alongside import together
from .calibration import rig_of_dlt
from .session import Session
from .sources import FILE

VIDEO = 30.0  # Hz; stands where a .tdc file does not say its rate: UM²AS digitises video
UNSAID = 1.0  # Hz; stands where a detections CSV does not say its rate
What = Literal["trajectories", "detections", "rig"]
IMAGES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".mkv", ".mp4", ".avi", ".mov", ".mpg", ".m4v")
WRITERS = {
    "trajectories": (".c3d", ".trc", ".csv"),
    "detections": (".h5", ".csv"),
    "rig": (".toml", ".csv"),
}


def read(path: Path, *, what: What | None = None, length_unit: str | None = None, rate_hz: float | None = None) -> Any:
    """What a file holds, as the record that fits: `Trial`, `Tdf`, `Rig`, `Detections`, `Session`, …

    Raises:
        KinemarkError: the kind of file is not known, or the file is damaged.
    """
    suffix = path.suffix.lower()
    if path.is_dir() or path.name == FILE:
        return Session.open(path)
    readers: dict[str, Callable[[], Any]] = {
        ".c3d": lambda: read_c3d(path),
        ".tdf": lambda: read_tdf(path),
        ".trc": lambda: Trial(path.stem, read_trc(path)),
        ".tdc": lambda: Trial(path.stem, trajectories_of_tdc(path, rate=rate_hz or VIDEO)),
        ".toml": lambda: read_rig_toml(path, length_unit),
        ".csv": lambda: _read_csv(path, what, length_unit, rate_hz),
        ".h5": lambda: load(path),
    }
    if path.name == "rods.toml":
        return read_rods(path)
    if suffix not in readers and suffix not in IMAGES:
        raise KinemarkError(
            f"{path} is of no known kind. Known are sessions, {', '.join(readers)}, and images and videos as "
            f"{', '.join(IMAGES)}."
        )
    return readers.get(suffix, lambda: open_images(path))()


def read_trial(path: Path, *, rate_hz: float | None = None) -> Trial:
    """The trial that a file of trajectories or tracks holds: C3D, TDF, TRC, CSV or HDF5.

    Raises:
        KinemarkError: it holds no trajectories, or as `read`.
    """
    found = read(path, rate_hz=rate_hz)
    parts = {} if isinstance(found, np.ndarray) else _parts(path, found)
    if "trajectories" not in parts:
        raise KinemarkError(f"{path} holds no trajectories. Give a .c3d, .tdf, .trc, .csv or .h5 file that does.")
    return parts["trajectories"]


def _read_csv(path: Path, what: What | None, length_unit: str | None, rate_hz: float | None) -> Any:
    """A CSV file: its first line tells detections and trajectories from DLT parameters."""
    head = read_text(path).split("\n", 1)[0]
    if what == "detections" or (what is None and "u_px" in head):
        return read_detections_csv(path, rate=rate_hz or UNSAID)
    if what == "trajectories" or (what is None and "_x_mm" in head):
        return Trial(path.stem, read_trajectories_csv(path, rate=rate_hz))
    return read_dlt_csv(path) if length_unit is None else rig_of_dlt(path, (), length_unit)


def describe(path: Path) -> dict[str, Any]:
    """What is in a file, by name.

    Raises:
        KinemarkError: as `read`.
    """
    found = read(path)
    describers: dict[type, Callable[[Any], dict[str, Any]]] = {
        Trial: _trial,
        Tdf: _tdf,
        Rig: _rig,
        Detections: _detections,
        Matches: lambda m: {"holds": "matches", "frames": m.n_frames, "groups": len(m)},
        Cloud: lambda c: {"holds": "points", "frames": c.n_frames, "points": len(c)},
        Tracks: lambda t: {"holds": "tracks", "frames": t.cloud.n_frames, "tracks": len(t), "points": len(t.cloud)},
        ImageSource: _images,
        Session: _session,
        Rods: lambda r: {"holds": "hanging rods", "rods": ", ".join(r.names), "markers on each": r.xyz.shape[1]},
        np.ndarray: lambda L: {"holds": "DLT parameters", "cameras": len(L)},
    }
    return describers[type(found)](found)


def convert(
    source: Path,
    target: Path,
    *,
    what: What | None = None,
    length_unit: str | None = None,
    rate_hz: float | None = None,
) -> None:
    """Read one file and write its content in another format, told by the names' endings.

    Args:
        source: the file to read.
        target: the file to write.
        what: which part of it, where the ending of `target` leaves that open.
        length_unit: of a rig file that does not say it.
        rate_hz: of a CSV file that does not say it.

    Raises:
        KinemarkError: the target exists, its format does not hold what the source has, or the source is damaged.
    """
    if target.exists():
        raise KinemarkError(f"{target} exists, and nothing is overwritten. Name another file or remove it.")
    found = read(source, what=what, length_unit=length_unit, rate_hz=rate_hz)
    if isinstance(found, np.ndarray):
        raise KinemarkError(f"{source} holds DLT parameters of an unknown unit. Say --length-unit m or mm.")
    have = _parts(source, found)
    if rate_hz is not None and not 0 < rate_hz < np.inf:
        raise KinemarkError(f"--rate-hz is {rate_hz}, wanted a number above 0.")
    if isinstance(found, Detections) and found.rate == UNSAID and rate_hz is None and source.suffix.lower() == ".csv":
        raise KinemarkError(f"{source} does not say its frame rate. Say --rate-hz.")
    suffix = target.suffix.lower()
    fits = [kind for kind in have if suffix in WRITERS[kind] and what in (None, kind)]
    if len(fits) != 1:
        raise KinemarkError(
            f"{source} has {', '.join(have) or 'nothing to convert'}; {suffix or 'no ending'} can hold "
            f"{' or '.join(k for k, endings in WRITERS.items() if suffix in endings) or 'none of it'}. "
            + ("Say which with --what." if len(fits) > 1 else "Choose another ending.")
        )
    _write(fits[0], have[fits[0]], target)


def _parts(source: Path, found: Any) -> dict[What, Any]:
    """What of a record can be written elsewhere."""
    if isinstance(found, Tdf):
        trial = found.trajectories and _whole_trial(source.stem, found)
        parts: dict[What, Any] = {"trajectories": trial, "detections": found.detections, "rig": found.rig}
        return {kind: part for kind, part in parts.items() if part is not None}
    if isinstance(found, Tracks):
        return {"trajectories": Trial(source.stem, to_trajectories(found, None))}
    kinds: dict[type, What] = {Trial: "trajectories", Detections: "detections", Rig: "rig"}
    return {kinds[type(found)]: found} if type(found) in kinds else {}


def write_trial(target: Path, trial: Trial) -> None:
    """A trial to a file of the kind that its ending names; only C3D holds more than the markers."""
    _write("trajectories", trial, target)


def _whole_trial(name: str, tdf: Tdf) -> Trial:
    """The markers of a BTS file with its channels as a C3D file can hold them."""
    assert tdf.trajectories is not None  # the caller has looked
    return together(Trial(name, tdf.trajectories, tdf.analog, tdf.plates, tdf.events), tdf.trajectories)


def _write(kind: What, part: Any, target: Path) -> None:
    """One part to a file."""
    writers: dict[tuple[str, str], Callable[[], None]] = {
        ("trajectories", ".c3d"): lambda: write_c3d(target, part),
        ("trajectories", ".trc"): lambda: write_trc(target, _positions(target, part)),
        ("trajectories", ".csv"): lambda: write_trajectories_csv(target, _positions(target, part)),
        ("detections", ".h5"): lambda: save(target, part),
        ("detections", ".csv"): lambda: write_detections_csv(target, part),
        ("rig", ".toml"): lambda: write_rig_toml(target, part),
        ("rig", ".csv"): lambda: _write_dlt(target, part),
    }
    writers[kind, target.suffix.lower()]()


def _positions(target: Path, trial: Trial) -> Trajectories:
    """The markers of a trial, without the angles, moments and powers that a C3D file keeps among them."""
    positions = markers(trial)
    if not len(positions):
        raise KinemarkError(f"The source has no markers, and {target.suffix} holds nothing else. Convert to .c3d.")
    return positions


def _write_dlt(target: Path, rig: Rig) -> None:
    """Eleven parameters a camera, for mm; refused where a lens would be lost."""
    if bent := [camera.name for camera in rig if camera.distortion.any()]:
        raise KinemarkError(
            f"Cameras {', '.join(bent)} have lens distortion, which DLT parameters do not hold. Write a .toml instead."
        )
    write_dlt_csv(target, to_dlt(rig.P))


def _trial(trial: Trial) -> dict[str, Any]:
    """A C3D, TRC or CSV trial."""
    t = markers(trial)
    others = len(trial.trajectories) - len(t)
    gaps = [stop - first for path in t for first, stop in path.gaps]
    return {
        "holds": "a trial",
        "markers": f"{len(t)}: {', '.join(t.names)}" if t.names else 0,
        **({"angles, moments and the like": others} if others else {}),
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
