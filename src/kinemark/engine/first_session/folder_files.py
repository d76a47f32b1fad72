"""The files of a folder by what they hold: videos and images, 2D points, and files that belong to a calibration."""

from __future__ import annotations

import os
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from ...data import Detections, KinemarkError, Rig, Rods, Trial
from ...io.detections_csv import NamedDetections
from ...io.formats import IMAGES, ReadOptions, read_file
from ...io.images import open_images
from ...io.named_points_csv import layout_of
from ...io.number_text import read_text
from ...io.rig_toml import read_rig_toml
from ...io.tdf import Tdf, read_tdf
from ...io.um2as import files_of_set, read_msr
from ..naming.template_files import is_template
from ..session_name import FILE
from ..settings import is_da
from .camera_names import WORD, grouped, natural
from .labelled_trials import kept_template
from .proposal import FoundRecording, Reason, Role
from .role_words import role_of

ANY_IMAGE = re.compile(r"(?:im|img|image|frame|fr|pic|picture|photo|shot|snap|capture|grab)s?", re.IGNORECASE)
"""Words that any image has before its number, and that name no trial; chosen."""


def trial_name(path: str) -> str:
    """A short name of a trial, from its pattern: what the path says besides camera, number of the image and ending."""
    stem = path.rsplit(".", 1)[0]
    parts = [tidied(part) for part in stem.split("/")]
    named = [part for part in parts if part]
    said = [part for part in named if not ANY_IMAGE.fullmatch(part)] or named
    return said[-1] if said else ""


def tidied(part: str) -> str:
    """A part of a path without camera and number of the image, and without separators at its ends."""
    bare = re.sub(r"\{camera\}|%(0\d+)?d|\*|#", "", part)
    return re.sub(r"([ _.-])[ _.-]+", r"\1", bare).strip(" _.-")


NUMBERED = 3
"""Images whose names differ by a number only, from which on they are a sequence; chosen: fewer are single pictures."""
LAST_NUMBER = re.compile(r"[0-9]+(?=[^0-9]*$)")
MADE = ("results", "__pycache__")
"""Folders that no recordings are in."""


def files_below(folder: Path) -> tuple[str, ...]:
    """Paths relative to the folder, in natural order; hidden ones and results are left out.

    Raises:
        KinemarkError: it is no folder.
    """
    if not folder.is_dir():
        raise KinemarkError(f"{folder} is not a folder. Name the folder that holds the recordings.")
    found = []
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".") and name not in MADE]
        within = Path(parent).relative_to(folder)
        found += [(within / name).as_posix() for name in names if not name.startswith(".") and name != FILE]
    return tuple(sorted(found, key=lambda path: [natural(part) for part in path.split("/")]))


def is_picture(path: str) -> bool:
    """Whether it is a video or an image, by its ending."""
    return Path(path).suffix.lower() in IMAGES


def is_video(path: str) -> bool:
    """Whether it is a video, by its ending."""
    return Path(path).suffix.lower() in IMAGES[IMAGES.index(".mkv") :]


class Stream(NamedTuple):
    """What one camera took: a video, an image, or images that a number counts, for which `#` stands in the path."""

    path: str
    files: tuple[str, ...]

    @property
    def pattern(self) -> str:
        """The path as a session names it: `%06d` where numbers have no gaps, else `*`."""
        if "#" not in self.path:
            return self.path
        digits = [number_of(file) for file in self.files]
        whole = all(int(b) == int(a) + 1 for a, b in pairwise(digits))
        width = len(digits[0])
        if whole and all(len(d) == max(width, len(str(int(d)))) for d in digits):
            form = f"%0{width}d" if digits[0].startswith("0") or width > 1 else "%d"
            return self.path.replace("#", form)
        return self.path.replace("#", "*")


def number_of(path: str) -> str:
    """The last number in a file's name, which counts images; that of a camera does not, and gives an empty text."""
    stem = path.rsplit("/", 1)[-1].rsplit(".", 1)[0]
    found = LAST_NUMBER.search(stem)
    cameras = [match.span() for match in WORD.finditer(stem)]
    if found is None or any(first <= found.start() < last for first, last in cameras):
        return ""
    return found[0]


def streams_of(pictures: Iterable[str], cameras: Sequence[str]) -> list[Stream]:
    """Videos, images and sequences; numbers that are just the names of cameras do not make a sequence."""
    counted: dict[str, list[str]] = defaultdict(list)
    streams = []
    for path in pictures:
        number = "" if is_video(path) else number_of(path)
        if number:
            head, _, tail = path.rpartition(number)
            counted[f"{head}#{tail}"].append(path)
        else:
            streams.append(Stream(path, (path,)))
    for path, files in counted.items():
        numbers = [number_of(file) for file in files]
        if len(files) < NUMBERED or set(numbers) == set(cameras):
            streams += [Stream(file, (file,)) for file in files]
        else:
            streams.append(Stream(path, tuple(files)))
    return streams


class Facts(NamedTuple):
    """Images of a stream, Hz and size in px; None where unknown."""

    frames: int | None
    rate: float | None
    size: tuple[int, int] | None


def facts_of(folder: Path, stream: Stream) -> Facts:
    """What a stream says of itself; of a damaged one nothing."""
    try:
        source = open_images(folder / stream.files[0])
    except KinemarkError:
        return Facts(None, None, None)
    many = len(stream.files)
    return Facts(many if many > 1 else source.n_frames, source.rate, source.size)


def other_file(folder: Path, path: str) -> FoundRecording | None:
    """What a file that is no picture is to a session; None where it is none of its files.

    A file that should be one and cannot be read is found, and its reason says why.
    """
    try:
        record = _record(folder / path)
    except KinemarkError as error:
        ours = Path(path).suffix.lower() in (".tdf", ".c3d", ".da1", ".cp1") or _of_cameras(folder / path)
        why = Reason("unreadable", {"error": str(error)})
        return FoundRecording(path, "other", (), Role.UNUSED, why) if ours else None
    role, why = role_of(path)
    name = trial_name(path)
    if isinstance(record, Detections):
        rate = None if Path(path).suffix.lower() == ".csv" else record.rate
        return FoundRecording(path, "detections", record.cameras, role, why, name, record.n_frames, rate)
    if isinstance(record, Tdf) and record.detections is not None:
        seen = record.detections
        return FoundRecording(path, "detections", seen.cameras, role, why, name, seen.n_frames, seen.rate)
    if isinstance(record, FoundRecording):
        return record
    held = {Rods: ("rods", Role.CONTROL_FRAME), Rig: ("rig", Role.RIG), Trial: ("trajectories", Role.UNUSED)}
    kind: Any = held.get(type(record))
    if kind is None:
        return None
    cameras = record.names if isinstance(record, Rig) else ()
    return FoundRecording(path, kind[0], tuple(cameras), kind[1], Reason(f"holds_{kind[0]}"))


def _of_cameras(path: Path) -> bool:
    """Whether a file is TOML with the table of a camera, be it one that cannot be used."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        tables = tomllib.loads(read_text(path)).values()
    except (KinemarkError, tomllib.TOMLDecodeError, RecursionError):
        return False
    return any(isinstance(table, dict) and {"matrix", "rotation", "translation"} <= {*table} for table in tables)


def _record(path: Path) -> Any:
    """The record of a file, or directly what was found of it; None for files that no session has."""
    suffix = path.suffix.lower()
    if is_template(path):
        return kept_template(path)
    if suffix == ".csv":
        return _csv(path)
    if suffix == ".tdf":
        return read_tdf(path, parts=("detections",))
    if is_da(path) or suffix.startswith(".cp"):
        return _um2as(path)
    if suffix == ".msr":
        return FoundRecording(
            path.name, "points", (), Role.CONTROL_POINTS, Reason("holds_measured", {"n": len(read_msr(path))})
        )
    if suffix == ".toml":
        return _toml(path)
    return read_file(path, ReadOptions()) if suffix in (".c3d", ".trc", ".h5") else None


def _toml(path: Path) -> Any:
    """Rods or a rig; where its file does not say the unit of length, as those of other programs, that is asked."""
    try:
        return read_file(path, ReadOptions())
    except KinemarkError:
        cameras = read_rig_toml(path, "mm").names  # any unit will do for the names
    return FoundRecording(path.name, "rig", tuple(cameras), Role.RIG, Reason("holds_rig_without_unit"))


def _um2as(path: Path) -> FoundRecording | None:
    """The first of UM²AS's files of a set stands for the set."""
    kind = "da" if is_da(path) else "cp"
    if path.suffix.lower() != f".{kind}1":
        return None
    n = len(files_of_set(path, kind))
    if kind == "cp":
        return FoundRecording(path.name, "rig", (), Role.RIG, Reason("holds_rig", {"files": n}))
    return FoundRecording(path.name, "detections", (), Role.TRIAL, Reason("digitised", {"files": n}), path.stem)


def _csv(path: Path) -> Any:
    """Detections, control points or DLT parameters."""
    with path.open(encoding="utf-8", errors="replace") as file:
        heading = [cell.strip() for cell in file.readline(1 << 20).split(",")]
    if "x_mm" in heading and any(cell.endswith("_u_px") for cell in heading):
        cameras = tuple(cell.removesuffix("_u_px") for cell in heading if cell.endswith("_u_px"))
        return FoundRecording(path.name, "points", cameras, Role.CONTROL_POINTS, Reason("holds_points"))
    if {"name", "x_mm", "y_mm", "z_mm"} <= {*heading} and not {"frame", "time_s"} & {*heading}:
        return FoundRecording(path.name, "points", (), Role.CONTROL_POINTS, Reason("holds_places"))
    record = read_file(path, ReadOptions())
    if isinstance(record, NamedDetections):
        return None if layout_of(path) == "deeplabcut" else record.detections
    if isinstance(record, Detections | Trial):
        return record
    cameras = tuple(f"cam{c + 1}" for c in range(len(record)))
    return FoundRecording(path.name, "rig", cameras, Role.RIG, Reason("holds_dlt", {"cameras": len(record)}))


def camera_files(folder: Path, paths: Iterable[str]) -> list[FoundRecording]:
    """DeepLabCut's files, one a camera, by the words for cameras in their names."""
    ours = [path for path in paths if path.lower().endswith(".csv") and _is_deeplabcut(folder / path)]
    grouping = grouped(ours, "word")
    return [
        FoundRecording(pattern, "detections", tuple(sorted(found, key=natural)), *role_of(pattern), trial_name(pattern))
        for pattern, found in grouping.patterns.items()
    ]


def _is_deeplabcut(path: Path) -> bool:
    try:
        return layout_of(path) == "deeplabcut"
    except KinemarkError:
        return False


def tdf_with_rig(folder: Path, paths: Sequence[str]) -> str | None:
    """The first TDF file that holds a calibration."""
    for path in paths:
        try:
            if path.lower().endswith(".tdf") and read_tdf(folder / path, parts=("rig",)).rig is not None:
                return path
        except KinemarkError:
            continue
    return None
