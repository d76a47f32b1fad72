"""Detections as CSV: `camera, frame, u_px, v_px`, optionally `marker`, `area_px2`, `var_u_px2`, `var_v_px2`, `merged`.

Frames count from 0. `u` and `v` may stand for `u_px` and `v_px`. With `marker` it says which marker each point is.
`merged` is 1 where an image may be of more markers than one, and 0 elsewhere; a file that marks any marks all.
Spreadsheets of countries that write 2,5 save such a table with semicolons or tabs and decimal commas: read too.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import Detections, KinemarkError
from ..data.array_types import Bools, Floats, Ints
from .csv_table import write_table
from .number_text import AGAIN, bad_line, numbers, plain, read_text, separator, whole

NEEDED = ("camera", "frame", "u_px", "v_px")
VARIANCES = ("var_u_px2", "var_v_px2")
OPTIONAL = ("area_px2", *VARIANCES)
MARKER, MERGED = "marker", "merged"
SHORT = {"u": "u_px", "v": "v_px"}
ROWS_AT_ONCE = 65536  # rows turned to numbers in one go; chosen for memory
MOST_COUNTS = 10_000_000  # cameras times frames that a sparse file may claim; chosen for memory


class NamedDetections(NamedTuple):
    """Detections (D rows) whose markers are known.

    marker: (D) the marker of each row, by its place in `names`; -1 for none. names: (M) of the markers.
    """

    detections: Detections
    marker: Ints
    names: tuple[str, ...]


def read_detections_csv(
    path: Path | str, *, rate: float, cameras: Sequence[str] | None = None, n_frames: int | None = None
) -> Detections:
    """Detections of all cameras, sorted by camera and frame and otherwise as the file orders them.

    Names of markers that the file has are left aside; `read_named_detections` takes them.

    Args:
        path: the file; its columns and rows may come in any order.
        rate: frames a second, Hz; the file does not say it.
        cameras: names in the session's order; without it, in the order in which the file first names them.
        n_frames: of the recording; without it, up to the last frame in which something was seen.

    Raises:
        KinemarkError: the file is absent, a column is missing or unknown, a cell is no number, a camera is not in
            `cameras` or a frame not below `n_frames`.
    """
    return read_long(path, rate=rate, cameras=cameras, n_frames=n_frames).detections


def read_long(
    path: Path | str, *, rate: float, cameras: Sequence[str] | None = None, n_frames: int | None = None
) -> NamedDetections:
    """The same with the markers of the rows, -1 where the file does not name them; see `read_detections_csv`."""
    text = read_text(path)
    mark = separator(text)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark)
    names: dict[str, int] = {name: c for c, name in enumerate(cameras or ())}
    markers: dict[str, int] = {}
    try:
        heading = [SHORT.get(cell.strip(), cell.strip()) for cell in next(reader, [])]
        check_heading(path, heading)
        rows = ((reader.line_num, row) for row in reader if any(row))
        if mark != ",":
            rows = ((line, _with_points(row, heading)) for line, row in rows)
        parts = list(chunks(path, rows, heading, names, cameras is None, markers))
    except csv.Error as error:
        raise bad_line(path, reader.line_num, f"{error}") from error
    line = np.concatenate([np.zeros(0, np.int64), *(lines for lines, _ in parts)])
    table = np.concatenate([np.zeros((0, len(heading))), *(values for _, values in parts)])
    column = dict(zip(heading, table.T, strict=True))
    frame = whole(path, line.tolist(), column["frame"], "frame")
    check_rows(path, line, column, frame, n_frames)
    total = n_frames if n_frames is not None else int(frame.max(initial=-1)) + 1
    if len(names) * total > max(MOST_COUNTS, 100 * len(table)):
        raise KinemarkError(f"{path} has only {len(table)} detections in {total} frames; frames count from 0.")
    camera = column["camera"].astype(np.int64)
    counts = np.bincount(camera * total + frame, minlength=len(names) * total).reshape(len(names), total)
    marker = column[MARKER].astype(np.int64) if MARKER in column else np.full(len(line), -1)
    check_once(path, line, (camera * total + frame, marker), tuple(markers))
    order = np.lexsort([frame, camera])
    uv = np.column_stack([column["u_px"], column["v_px"]])[order]
    shape = {"area": column["area_px2"][order]} if "area_px2" in column else {}
    shape |= {"merged": column[MERGED][order] == 1} if MERGED in column else {}
    found = Detections.build(tuple(names), rate, counts, uv, covariance(column, order), **shape)
    return NamedDetections(found, marker[order], tuple(markers))


def _with_points(row: list[str], heading: list[str]) -> list[str]:
    """A row's numbers with points where it has decimal commas; names stay."""
    named = [k for k, name in enumerate(heading) if name in ("camera", MARKER)]
    return [cell if k in named else cell.replace(",", ".") for k, cell in enumerate(row)]


def check_heading(path: Path | str, heading: list[str]) -> None:
    """The columns that must be there, and no unknown one."""
    known = (*NEEDED, MARKER, *OPTIONAL, MERGED)
    if unknown := [cell for cell in heading if cell not in known]:
        raise bad_line(path, 1, f"unknown column {unknown[0]!r}; known are {', '.join(known)}. Remove it.")
    if missing := [cell for cell in NEEDED if cell not in heading]:
        raise bad_line(path, 1, f"has no column {missing[0]!r}; wanted are {', '.join(NEEDED)}")
    if len(set(heading)) != len(heading) or (VARIANCES[0] in heading) != (VARIANCES[1] in heading):
        raise bad_line(path, 1, f"columns must differ and var_u_px2, var_v_px2 come together; found {heading}")


def chunks(
    path: Path | str,
    rows: Iterator[tuple[int, list[str]]],
    heading: list[str],
    names: dict[str, int],
    add: bool,
    markers: dict[str, int],
) -> Iterator[tuple[Ints, Floats]]:
    """Line numbers and rows as numbers, some at a time.

    Cameras become their index in `names`, which grows when `add`; markers theirs in `markers`, -1 where it is empty.
    """
    at, named = heading.index("camera"), heading.index(MARKER) if MARKER in heading else None
    while pairs := list(islice(rows, ROWS_AT_ONCE)):
        for line, row in pairs:
            if len(row) != len(heading):
                raise bad_line(path, line, f"has {len(row)} cells, wanted {len(heading)}. {AGAIN}")
            name = row[at].strip()
            if name not in names and not add:
                raise bad_line(path, line, f"camera {name!r} is not one of {', '.join(names)}")
            row[at] = str(names.setdefault(name, len(names)))
            if named is not None:
                said = row[named].strip()
                row[named] = str(markers.setdefault(said, len(markers))) if said else "-1"
        lines = [line for line, _ in pairs]
        yield np.array(lines, np.int64), table(path, lines, [row for _, row in pairs])


def table(path: Path | str, lines: Sequence[int], rows: list[list[str]]) -> Floats:
    """Rows of equal length as numbers: all at once, and line by line only where that fails or cells are empty."""
    try:
        if not any("_" in "".join(row) for row in rows):
            return np.array(rows, dtype=np.float64)
    except ValueError:
        pass
    return numbers(path, lines, rows, len(rows[0]))


def check_rows(path: Path | str, line: Ints, column: dict[str, Floats], frame: Ints, n_frames: int | None) -> None:
    """Frames within the recording, finite centroids, no negative variance, `merged` 0 or 1."""
    last = int(frame.max(initial=0)) if n_frames is None else n_frames - 1
    checks: list[tuple[Bools, str]] = [
        ((frame < 0) | (frame > last), f"frame is not one of 0 … {last}"),
        (~np.isfinite(column["u_px"] + column["v_px"]), "u_px or v_px is missing. Leave out what was not seen."),
        *((column[name] < 0, f"{name} is negative") for name in VARIANCES if name in column),
    ]
    if MERGED in column:
        what = "merged is neither 0 nor 1. Write 1 where an image may be of more markers than one, and 0 elsewhere."
        checks.append((~np.isin(column[MERGED], (0, 1)), what))
    for wrong, what in checks:
        if wrong.any():
            raise bad_line(path, int(line[wrong][0]), what)


def check_once(path: Path | str, line: Ints, at: tuple[Ints, Ints], names: tuple[str, ...]) -> None:
    """No marker twice in one image; `at` is the image and the marker of each row."""
    image, marker = at
    named = np.flatnonzero(marker >= 0)
    order = named[np.lexsort([line[named], marker[named], image[named]])]
    again = np.flatnonzero((np.diff(image[order]) == 0) & (np.diff(marker[order]) == 0))
    if len(again):
        row = order[again[0] + 1]
        what = f"marker {names[marker[row]]!r} comes twice in one camera and frame, wanted once. Remove one."
        raise bad_line(path, int(line[row]), what)


def covariance(column: dict[str, Floats], order: Ints) -> Floats | None:
    """(D, 2, 2) px² without correlation; NaN in rows that do not say it, None where no row does."""
    if VARIANCES[0] not in column:
        return None
    variance = np.column_stack([column[name] for name in VARIANCES])[order]
    known = np.asarray(np.isfinite(variance).all(1))
    return np.where(known[:, None, None], variance[:, :, None] * np.eye(2), np.nan)


def write_detections_csv(path: Path | str, detections: Detections | NamedDetections) -> None:
    """Write the valid detections, every digit kept: area and variances where any is known, `merged` where any image is,
    and names of markers.

    Covariances between u and v, widths, heights, peaks and what was found invalid have no place here; HDF5 keeps them.

    Raises:
        TypeError: `detections` are none, as where both arguments changed places.
        KinemarkError: the file cannot be written.
    """
    named = detections if isinstance(detections, NamedDetections) else None
    found = named.detections if named else detections
    if not isinstance(found, Detections):
        raise TypeError(f"detections are a {type(found).__name__}, wanted write_detections_csv(path, detections)")
    kept = found.keep(found.valid)
    columns = {
        "camera": np.array(kept.cameras, object)[kept.camera].tolist(),
        "frame": kept.frame.tolist(),
        "u_px": list(map(plain, kept.uv[:, 0].tolist())),
        "v_px": list(map(plain, kept.uv[:, 1].tolist())),
    }
    if named:
        columns[MARKER] = [named.names[m] if m >= 0 else "" for m in named.marker[found.valid].tolist()]
    optional = dict(zip(OPTIONAL, (kept.area, kept.cov[:, 0, 0], kept.cov[:, 1, 1]), strict=True))
    variances_known = np.isfinite(kept.cov).any()
    for name, values in optional.items():
        if variances_known if name in VARIANCES else np.isfinite(values).any():
            columns[name] = list(map(plain, values.tolist()))
    if kept.merged.any():
        columns[MERGED] = kept.merged.astype(int).tolist()
    write_table(path, list(columns), zip(*columns.values(), strict=True))
