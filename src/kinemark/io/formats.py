"""The one table of file formats: by its ending, and where that leaves it open by its content, what a file holds.

Reading gives the record that fits; writing takes a trial, detections or a rig. A new format is one row here. What
brings a large library (HDF5, video, TOML) is imported when such a file is met, so that others do not wait for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from ..data import (
    KinemarkError,
    MarkerTrajectory,
    Origin,
    Rig,
    Rods,
    Trajectories,
    Trial,
)
from ..data.trial import UP
from ..data.typed import typed
from .c3d import read_c3d, write_c3d
from .detections_csv import NamedDetections, read_detections_csv, write_detections_csv
from .dlt_csv import read_dlt_csv, write_dlt_csv
from .files import check_new
from .motive_csv import is_motive, read_motive_csv
from .named_points_csv import layout_of, read_named_detections
from .nexus_csv import is_nexus, read_nexus_csv
from .notes import FileNote
from .number_text import bad_line, read_head
from .possible_places import with_possible_places
from .qualisys_tsv import is_qualisys, read_qualisys_tsv
from .tdf import Tdf, read_tdf
from .trajectories_csv import read_csv_trial, write_trajectories_csv
from .trc import read_trc_trial, write_trc
from .trc_table import is_trc

Content = Literal["trajectories", "detections", "rig"]
"""What can be written."""
OTHER = "what else the source file held, such as its parameters"

VIDEO = 30.0
"""Hz; stands where a .tdc file does not say its rate: UM²AS digitises video."""
UNKNOWN_RATE = 1.0
"""Hz; stands where a detections CSV does not say its rate; chosen."""
IMAGES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".mkv", ".mp4", ".avi", ".mov", ".mpg", ".m4v")
TABLES = (
    "Wanted is frame, time_s, NAME_x_mm, NAME_y_mm, NAME_z_mm … of trajectories; camera, frame, u_px, v_px of 2D "
    "points; or DLT coefficients, which have no heading. All tables: docs/reference/files.md"
)
"""What a CSV file may hold."""
HOLDS = {
    "Trial": "a trial",
    "Trajectories": "trajectories",
    "Signals": "signals",
    "Tdf": "a BTS recording",
    "Rig": "a calibrated rig",
    "Rods": "hanging rods",
    "Detections": "2D points",
    "NamedDetections": "2D points with names",
    "Matches": "matches",
    "Cloud": "points without names",
    "Tracks": "tracks",
    "Fills": "filled samples",
    "ImageSource": "images",
}
"""What a record of each class is called; arrays are DLT parameters."""


class ReadOptions(NamedTuple):
    """What the caller says of a file.

    Hz and unit of length where it is silent or wrong about them, whether to read what there is of a damaged one, and
    which content a CSV has.
    """

    rate_hz: float | None = None
    length_unit: str | None = None
    partial: bool = False
    what: Content | None = None


class Format(NamedTuple):
    """One format.

    Attributes:
        read: gives the record of a file.
        write: for each content that the format holds, writes it and returns what it could not hold.
        own_unit: of length, where the format fixes it; its files state their rate too, and no caller may state others.
    """

    read: Callable[[Path, ReadOptions], Any]
    write: Mapping[Content, Callable[[Path, Any], tuple[FileNote, ...]]] = {}
    own_unit: str = ""


def _unheeded(path: Path, options: ReadOptions, unit: str, rate: float | None = None) -> None:
    """Raises KinemarkError where the caller states otherwise what a file states itself, and nothing would change."""
    for what, own, said, flag in (
        ("unit of length", unit, options.length_unit, "--length-unit"),
        ("rate in Hz", rate, options.rate_hz, "--rate-hz"),
    ):
        if None not in (own, said) and own != said:
            raise KinemarkError(
                f"{path} states its own {what}, {own}, which {flag} {said} does not change. Leave it out."
            )


def _rate_of(found: Any) -> float | None:
    """Frames a second of a record; None where it has none."""
    parts = (getattr(found, name, None) for name in ("trajectories", "detections", "cloud"))
    owner = next((part for part in parts if part is not None), found)
    return getattr(owner, "rate", None)


EXPORTS = (
    (is_motive, read_motive_csv),
    (is_nexus, read_nexus_csv),
    (is_qualisys, read_qualisys_tsv),
    (is_trc, read_trc_trial),
)
"""Tables in text that their first line makes known, whatever the file's ending."""


def _csv(path: Path, options: ReadOptions) -> Any:
    """A table in text: its heading tells detections and trajectories from DLT parameters, which have none."""
    text = read_head(path)
    first_line = text.lstrip("\r\n\t,; ").split("\n", 1)[0]
    for says, read in EXPORTS:
        if says(first_line):
            return read(path, rate_hz=options.rate_hz, length_unit=options.length_unit, partial=options.partial)
    if layout_of(path) is not None:
        return read_named_detections(path, rate=options.rate_hz or UNKNOWN_RATE)
    head = text.split("\n", 1)[0]
    found = "detections" if "u_px" in head else "trajectories" if "_x_mm" in head else options.what
    if "_x_mm" in head:
        _unheeded(path, options, "mm")
    if found == "detections":
        return read_detections_csv(path, rate=options.rate_hz or UNKNOWN_RATE)
    if found == "trajectories" or head.startswith("frame"):
        return read_csv_trial(path, rate=options.rate_hz, partial=options.partial)
    if not any(character.isdigit() for character in head.split(",")[0]):
        raise bad_line(path, 1, f"{head.strip()[:60]!r} is the heading of no table that is known. {TABLES}")
    return read_dlt_csv(path)


def _tsv(path: Path, options: ReadOptions) -> Any:
    """A table with tabs; one of an unknown heading is taken for QTM's, whose reader says what it wants."""
    head = read_head(path).split("\n", 1)[0]
    ours = "_x_mm" in head or "camera" in head
    if ours or any(says(head) for says, _ in EXPORTS):
        return _csv(path, options)
    return read_qualisys_tsv(path, rate_hz=options.rate_hz, length_unit=options.length_unit, partial=options.partial)


def _tdf(path: Path, options: ReadOptions) -> Tdf:
    return read_tdf(path, partial=options.partial)


def _toml(path: Path, options: ReadOptions) -> Rig | Rods:
    from .rig_toml import read_rig_toml
    from .rods_toml import read_rods

    return read_rods(path) if path.name == "rods.toml" else read_rig_toml(path, options.length_unit)


def _load(path: Path, options: ReadOptions) -> Any:
    from .records import load

    return load(path)


def _save(path: Path, record: Any) -> tuple[FileNote, ...]:
    from .records import save

    if isinstance(record, NamedDetections):
        save(path, record.detections)
        return (FileNote("not_written", "names", record.names),)
    save(path, record)
    return ()


def _markers_only(write: Callable[[Path, Trajectories], None]) -> Callable[[Path, Trial], tuple[FileNote, ...]]:
    """Writes the markers of a trial, and says what else it has."""

    def written(path: Path, trial: Trial) -> tuple[FileNote, ...]:
        if not len(trial.trajectories) or not trial.trajectories.n_frames:
            lack = "frames" if len(trial.trajectories) else "markers"
            raise KinemarkError(f"The source has no {lack}, and {path.suffix} holds nothing else. Convert to .c3d.")
        write(path, trial.trajectories)
        have = {
            **_of_samples(trial.trajectories),
            "signals": trial.signals.names,
            "analog": tuple(name for a in trial.analog for name in a.names),
            "force plates": tuple(str(i + 1) for i in range(len(trial.plates))),
            "events": tuple(dict.fromkeys(trial.events.label)),
            "about the capture": tuple(name for name in trial.about if name != UP),
            "which axis goes up": tuple(axis for name, axis in trial.about.items() if name == UP),
            "poses": tuple(name for p in trial.poses for name in p.names),
        }
        left = [FileNote("not_written", what, names) for what, names in have.items() if names]
        return (*left, *([FileNote("not_written", OTHER)] if trial.source is not None else []))

    return written


def _of_samples(trajectories: Trajectories) -> dict[str, tuple[str, ...]]:
    """The markers of which more than the position is known, by what it is."""
    known: dict[str, Callable[[MarkerTrajectory], bool]] = {
        "covariance": lambda path: bool(np.isfinite(path.cov).any()),
        "residuals": lambda path: bool((np.nan_to_num(path.residual) > 0).any()),
        "cameras": lambda path: bool(path.cameras.any()),
        "which samples were filled or edited": lambda path: bool((path.origin > Origin.MEASURED).any()),
    }
    return {what: tuple(path.name for path in trajectories if has(path)) for what, has in known.items()}


def _tdc(path: Path, options: ReadOptions) -> Trial:
    from .um2as import trajectories_of_tdc

    return Trial(path.stem, trajectories_of_tdc(path, rate=options.rate_hz or VIDEO))


def _write_tdc(path: Path, trial: Trial) -> tuple[FileNote, ...]:
    """UM²AS's file holds places alone."""
    from .um2as import write_tdc

    left = _markers_only(lambda p, t: write_tdc(p, t.xyz))(path, trial)
    return (*left, FileNote("not_written", "rate and names of markers"))


def _write_csv(path: Path, trial: Trial) -> tuple[FileNote, ...]:
    """Markers with their times, of which one alone does not tell the rate."""
    left = _markers_only(write_trajectories_csv)(path, trial)
    return (*left, FileNote("not_written", "the rate")) if trial.trajectories.n_frames == 1 else left


def _write_dlt(path: Path, rig: Rig) -> None:
    """Eleven parameters a camera, for mm; refused where a lens would be lost."""
    if bent := [camera.name for camera in rig if camera.distortion.any()]:
        raise KinemarkError(
            f"Cameras {', '.join(bent)} have lens distortion, which DLT parameters do not hold. Write a .toml instead."
        )
    from ..geometry import to_dlt

    write_dlt_csv(path, to_dlt(rig.P))


def _write_rig(path: Path, rig: Rig) -> None:
    from .rig_toml import write_rig_toml

    write_rig_toml(path, rig)


def _whole(write: Callable[[Path, Any], None]) -> Callable[[Path, Any], tuple[FileNote, ...]]:
    """A writer that loses nothing."""

    def written(path: Path, record: Any) -> tuple[FileNote, ...]:
        write(path, record)
        return ()

    return written


FORMATS: dict[str, Format] = {
    ".c3d": Format(
        lambda p, options: read_c3d(p, units=options.length_unit, rate_hz=options.rate_hz, partial=options.partial),
        {"trajectories": write_c3d},
    ),
    ".tdf": Format(_tdf, own_unit="m"),
    ".trc": Format(
        lambda p, options: read_trc_trial(
            p, length_unit=options.length_unit, rate_hz=options.rate_hz, partial=options.partial
        ),
        {"trajectories": _markers_only(write_trc)},
    ),
    ".tsv": Format(_tsv),
    ".txt": Format(_csv),
    ".csv": Format(
        _csv,
        {
            "trajectories": _write_csv,
            "detections": _whole(write_detections_csv),
            "rig": _whole(_write_dlt),
        },
    ),
    ".h5": Format(_load, {"trajectories": _save, "detections": _save}, own_unit="mm"),
    ".tdc": Format(_tdc, {"trajectories": _write_tdc}),
    ".toml": Format(_toml, {"rig": _whole(_write_rig)}),
}


def endings(content: Content) -> tuple[str, ...]:
    """The endings of the formats that hold this."""
    return tuple(ending for ending, one in FORMATS.items() if content in one.write)


def check_new_trial(path: Path) -> None:
    """Raises KinemarkError where a file is there already, or has not the ending of a format of trajectories."""
    check_new(path)
    if path.suffix.lower() not in endings("trajectories"):
        raise KinemarkError(f"{path} wants one of the endings {', '.join(endings('trajectories'))}.")


def holds(found: Any) -> str:
    """What a record is, in words."""
    return HOLDS.get(type(found).__name__, "DLT parameters")


def read_file(path: Path, options: ReadOptions = ReadOptions()) -> Any:  # noqa: B008  frozen
    """What a file holds, as the record that fits: `Trial`, `Tdf`, `Rig`, `Detections`, …; an array for DLT parameters.

    Raises:
        KinemarkError: the kind of file is not known, or the file is absent, damaged, or states itself what the options
            state of it.
    """
    ending = path.suffix.lower()
    if ending in FORMATS:
        found = FORMATS[ending].read(path, options)
        if unit := FORMATS[ending].own_unit:
            _unheeded(path, options, unit, _rate_of(found))
        return with_possible_places(found) if isinstance(found, Trial) else found
    if ending in IMAGES:
        from .images import open_images

        return open_images(path)
    if (path / "session.toml").is_file():
        done = sorted(file for file in path.glob("results/*/*.c3d") if file.stem == file.parent.name)
        way = (
            f"Give a file in its results, as {typed(done[0])}"
            if done
            else (f"Process it with kinemark run {typed(path)}, and give a file in its results")
        )
        raise KinemarkError(f"{path} is a session. {way}.")
    if path.is_dir():
        raise KinemarkError(f"{path} is a folder without a session.toml. Name the files in it, as {path / '*.c3d'}.")
    if not path.exists():
        raise KinemarkError(f"{path} is not there. Check the path.")
    raise KinemarkError(
        f"{path} is of no known kind. Known are sessions, {', '.join(FORMATS)}, and images and videos as "
        f"{', '.join(IMAGES)}."
    )


def write_file(path: Path, content: Content, record: Any) -> tuple[FileNote, ...]:
    """Write a record in the format that the ending names; returns what the format could not hold.

    Raises:
        KinemarkError: no format of that ending holds such content, or the file cannot be written.
    """
    one = FORMATS.get(path.suffix.lower())
    if one is None or content not in one.write:
        raise KinemarkError(f"{path} wants one of the endings {', '.join(endings(content))}.")
    return one.write[content](path, record)
