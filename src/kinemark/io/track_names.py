"""Names of tracks that a person stated, as TOML or CSV.

    [names]                                  track,name,first,last
    "*1" = "LASI"                            *1,LASI,,
    "*7" = false                             *7,,,
    "*3" = [                                 *3,LKNE,1,120
        { name = "LKNE", last = 120 },       *3,LTIB,121,
        { name = "LTIB", first = 121 },
    ]

`first` and `last` are frames, counted from 1 as in the file; the track's own where they are not given. No name (an
empty cell; false in TOML) says that the track is no marker. Both columns of frames may be absent.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..data import KinemarkError
from .number_text import AGAIN, bad_line, read_text
from .text_rows import csv_rows
from .toml_text import check_keys, toml_table

COLUMNS = ("track", "name", "first", "last")
MOST = 100_000
"""Most statements of a file; chosen, lest a broken file take memory."""


class TrackName(NamedTuple):
    """That a track is this marker, or none.

    Attributes:
        track: its name. name: of the marker; None where it is no marker.
        first, last: first and last frame of which it is stated, counted from 1; None for the track's own.
    """

    track: str
    name: str | None
    first: int | None = None
    last: int | None = None


def read_track_names(path: Path) -> tuple[TrackName, ...]:
    """The statements of a file, `.toml` or `.csv`.

    Raises:
        KinemarkError: the file is absent or of another kind, a line is no statement, or two contradict each other.
    """
    readers = {".toml": _from_toml, ".csv": _from_csv}
    if path.suffix.lower() not in readers:
        raise KinemarkError(f"{path} wants one of the endings {', '.join(readers)}.")
    found = readers[path.suffix.lower()](path)
    if len(found) > MOST:
        raise KinemarkError(f"{path} has {len(found)} statements, the most is {MOST}.")
    _check_together(path, found)
    return found


def _from_csv(path: Path) -> tuple[TrackName, ...]:
    rows = csv_rows(path)
    head = tuple(cell.strip().lower() for cell in rows[0][1]) if rows else ()
    if head[:2] != COLUMNS[:2] or not set(head) <= set(COLUMNS) or len(set(head)) < len(head):
        raise KinemarkError(f"{path} begins with {','.join(head)[:60]!r}. Wanted are the columns {','.join(COLUMNS)}.")
    found = []
    for line, row in rows[1:]:
        if not any(cell.strip() for cell in row):
            continue
        if (len(row) > len(head) and any(cell.strip() for cell in row[len(head) :])) or len(row) < 2:
            raise bad_line(path, line, f"has {len(row)} cells, wanted {len(head)}. {AGAIN}")
        cells = {key: cell.strip() for key, cell in zip(head, row, strict=False)}
        try:
            first, last = (int(cells[key]) if cells.get(key) else None for key in ("first", "last"))
            found.append(_statement(cells["track"], cells["name"] or None, first, last))
        except ValueError as error:
            raise bad_line(path, line, f"{error}") from None
    return tuple(found)


def _from_toml(path: Path) -> tuple[TrackName, ...]:
    table = toml_table(read_text(path), str(path))
    names = table.get("names")
    if not isinstance(names, dict) or set(table) != {"names"}:
        raise KinemarkError(f'{path} has {", ".join(table) or "nothing"}. Wanted is one table [names]: "*1" = "LASI".')
    try:
        return tuple(one for track, value in names.items() for one in _of_track(track, value))
    except (ValueError, TypeError) as error:
        raise KinemarkError(f"{path}: {error}. Correct it.") from None


def _of_track(track: str, value: Any) -> list[TrackName]:
    """One name, or several with their frames."""
    found = []
    for row in value if isinstance(value, list) else [value]:
        one: Mapping[str, Any] = row if isinstance(row, dict) else {"name": row}
        check_keys(track, one, ("name", "first", "last"))
        name = one.get("name", "")
        if name is not False and not isinstance(name, str):
            raise ValueError(f"the name of {track} is {name!r}, wanted text, or false where it is no marker")
        frames = [one.get(key) for key in ("first", "last")]
        if any(frame is not None and (isinstance(frame, bool) or not isinstance(frame, int)) for frame in frames):
            raise ValueError(f"the frames of {track} are {frames}, wanted whole numbers from 1")
        found.append(_statement(track, name or None, *frames))
    return found


def _statement(track: str, name: str | None, first: int | None, last: int | None) -> TrackName:
    """Checked by itself."""
    if not track.strip():
        raise ValueError("there is no track")
    if (first is not None and first < 1) or (last is not None and last < (first or 1)):
        raise ValueError(f"the frames of {track} are {first} to {last}, wanted first to last, from 1")
    return TrackName(track, name, first, last)


def _check_together(path: Path, found: tuple[TrackName, ...]) -> None:
    """No frame of a track has two statements."""
    by_track: dict[str, list[TrackName]] = {}
    for one in found:
        for other in by_track.setdefault(one.track, []):
            if (one.first or 1) <= (other.last or 1 << 62) and (other.first or 1) <= (one.last or 1 << 62):
                raise KinemarkError(
                    f"{path} says of {one.track} both {other.name or 'no marker'} and {one.name or 'no marker'} in the "
                    "same frames. Keep one."
                )
        by_track[one.track].append(one)
