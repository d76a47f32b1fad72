"""Marker sets as TOML.

name, description, source = "author year"
pairs = [["LASI", "RASI"], …]                                    left and right of the same landmark
links = [["SACR", "LASI"], { markers = ["LASI", "RASI"], length_mm = 240.0, spread_mm = 2.0 }, …]
[markers]    NAME = { meaning = "in words", place = [forward, left, up], view = "front", worn = "always" }
             place in shares of the body's height, standing; view: front, back or both; worn: always, optional or static
[segments]   NAME = { markers = ["A", "B"], spread = 0.02 }      how rigid: standard deviation of distances as a share
[joints]     NAME = { segments = ["A", "B"], place = [forward, left, up] }
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ..data import KinemarkError, MarkerSet
from ..data.marker_set import FACES, known
from ..data.nearest_word import guess
from .files import write_text
from .number_text import read_text
from .toml_text import MOST, check_keys, list_of, names_in, text_of, texts_of, toml_table

KEYS = {
    "the file": ("name", "description", "source", "pairs", "links", "markers", "segments", "joints"),
    "marker": ("meaning", "place", "view", "worn"),
    "segment": ("markers", "spread"),
    "joint": ("segments", "place"),
    "link": ("markers", "length_mm", "spread_mm"),
}
"""What each table may have."""
WORN = ("always", "optional", "static")


def marker_sets() -> tuple[str, ...]:
    """Names of the marker sets that come with Kinemark."""
    return names_in(_folder())


def _folder() -> Any:
    return files("kinemark.data").joinpath("marker_sets")


def read_marker_set(name_or_path: str | Path) -> MarkerSet:
    """A marker set by its name, or from a TOML file.

    Args:
        name_or_path: one of `marker_sets()`, or the path of a file.

    Raises:
        KinemarkError: there is no such set or file, or the file is no such description or contradicts itself.
    """
    name = str(name_or_path)
    if name in marker_sets():
        return marker_set_from_toml(_folder().joinpath(f"{name}.toml").read_text(encoding="utf-8"))
    if not Path(name).is_file():
        raise KinemarkError(
            f"{name} is neither a marker set nor a file{guess(name, marker_sets())}. Marker sets are "
            f"{', '.join(marker_sets())}."
        )
    try:
        return marker_set_from_toml(read_text(name))
    except KinemarkError as error:
        raise KinemarkError(f"{name}: {error}") from None


def marker_set_from_toml(text: str) -> MarkerSet:
    """The marker set that a text describes.

    Raises:
        KinemarkError: it is no TOML, a key is unknown, or the set does not hold together.
    """
    table = toml_table(text, "The marker set")
    try:
        return _marker_set(table)
    except (ValueError, TypeError) as error:
        raise KinemarkError(f"The marker set does not hold together: {error}. Correct it.") from None


def _marker_set(table: Mapping[str, Any]) -> MarkerSet:
    _check("the file", "", table)
    markers, segments, joints = (_tables(table, key) for key in ("markers", "segments", "joints"))
    if not markers:
        raise ValueError("it has no markers, wanted a table [markers] with one for each name")
    names = tuple(markers)
    links, length, spread = _links(list_of("links", table.get("links", [])), names)
    worn = {name: _one_of(f"worn of {name}", row.get("worn", "always"), WORN) for name, row in markers.items()}
    places = {name: _place(name, row["place"]) for name, row in (markers | joints).items() if "place" in row}
    if both := sorted(set(markers) & set(joints)):
        raise ValueError(f"{both[0]} is the name of a marker and of a joint")
    return MarkerSet(
        names,
        {name: texts_of(f"markers of {name}", row.get("markers", [])) for name, row in segments.items()},
        links,
        length,
        spread,
        tuple(_two("a pair", pair) for pair in list_of("pairs", table.get("pairs", []))),
        **{key: text_of(key, table.get(key, "")) for key in ("name", "description", "source")},
        meaning={
            name: text_of(f"meaning of {name}", row["meaning"]) for name, row in markers.items() if "meaning" in row
        },
        rigidity={
            name: _number(f"spread of {name}", row["spread"]) for name, row in segments.items() if "spread" in row
        },
        joints={name: _two(f"segments of {name}", row.get("segments")) for name, row in joints.items()},
        places=places,
        faces={name: _one_of(f"view of {name}", row["view"], FACES) for name, row in markers.items() if "view" in row},
        optional=tuple(name for name in names if worn[name] == "optional"),
        static_only=tuple(name for name in names if worn[name] == "static"),
    )


def _links(rows: list[Any], names: tuple[str, ...]) -> tuple[Any, Any, Any]:
    """(L, 2) indices, (L) lengths and (L) spreads, mm."""
    ends, length, spread = [], [], []
    for row in rows:
        table = row if isinstance(row, dict) else {"markers": row}
        _check("link", "", table)
        two = _two("a link", table.get("markers"))
        known("marker", "a link", two, names)
        ends.append([names.index(name) for name in two])
        length.append(_number("length_mm", table.get("length_mm", float("nan"))))
        spread.append(_number("spread_mm", table.get("spread_mm", float("nan"))))
    return np.array(ends, np.int64).reshape(-1, 2), np.array(length), np.array(spread)


def _tables(table: Mapping[str, Any], key: str) -> dict[str, Any]:
    found = table.get(key, {})
    if not isinstance(found, dict) or len(found) > MOST:
        raise ValueError(f"[{key}] must be a table of at most {MOST} names")
    for name, row in found.items():
        if not name.strip():
            raise ValueError(f"a name in [{key}] is empty")
        _check(key.removesuffix("s"), name, row)
    return found


def _check(kind: str, name: str, row: Any) -> None:
    """A table has only known keys."""
    if not isinstance(row, dict):
        raise ValueError(f"{kind} {name} is {row!r}, wanted a table".replace("  ", " "))
    check_keys(f"{kind} {name}".strip(), row, KEYS[kind])


def _two(key: str, value: Any) -> tuple[str, str]:
    two = texts_of(key, value)
    if len(two) != 2 or two[0] == two[1]:
        raise ValueError(f"{key} is {list(two)}, wanted two different names")
    return two[0], two[1]


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{key} is {value!r}, wanted a number")
    return float(value)


def _place(name: str, value: Any) -> tuple[float, float, float]:
    numbers = [_number(f"a number of the place of {name}", one) for one in list_of(f"place of {name}", value)]
    if len(numbers) != 3:
        raise ValueError(f"the place of {name} has {len(numbers)} numbers, wanted three: forward, left, up")
    return numbers[0], numbers[1], numbers[2]


def _one_of(key: str, value: Any, options: tuple[Any, ...]) -> Any:
    if value not in options:
        raise ValueError(f"{key} is {value!r}, wanted {', '.join(options)}")
    return value


def write_marker_set(path: Path | str, marker_set: MarkerSet) -> None:
    """Write a marker set as TOML; `read_marker_set` gives back the same.

    Raises:
        KinemarkError: the file cannot be written.
    """
    write_text(path, marker_set_toml(marker_set))


def marker_set_toml(of: MarkerSet) -> str:
    """The text of the file."""
    document = tomlkit.document()
    for key in ("name", "description", "source"):
        if text := getattr(of, key):
            document[key] = text
    links = [_link(of, k) for k in range(len(of.links))]
    for key, rows in (("pairs", [list(pair) for pair in of.pairs]), ("links", links)):
        if rows:
            document[key] = tomlkit.array("[\n" + "".join(f"  {_inline(row).as_string()},\n" for row in rows) + "]")
    joints = {name: {"segments": list(two)} | _placed(of, name) for name, two in of.joints.items()}
    for key, table in (
        ("markers", {name: _marker(of, name) for name in of.names}),
        ("segments", {name: _segment(of, name) for name in of.segments}),
        ("joints", joints),
    ):
        if table:
            document[key] = tomlkit.table()
            for name, row in table.items():
                document[key].append(name, _inline(row))
    return tomlkit.dumps(document)


def _marker(of: MarkerSet, name: str) -> dict[str, Any]:
    row = {"meaning": of.meaning[name]} if name in of.meaning else {}
    row |= _placed(of, name) | ({"view": of.faces[name]} if name in of.faces else {})
    worn = "optional" if name in of.optional else "static" if name in of.static_only else ""
    return row | ({"worn": worn} if worn else {})


def _segment(of: MarkerSet, name: str) -> dict[str, Any]:
    return {"markers": list(of.segments[name])} | ({"spread": of.rigidity[name]} if name in of.rigidity else {})


def _placed(of: MarkerSet, name: str) -> dict[str, Any]:
    return {"place": [float(x) for x in of.places[name]]} if name in of.places else {}


def _link(of: MarkerSet, k: int) -> Any:
    ends = [of.names[i] for i in of.links[k]]
    numbers = {"length_mm": float(of.length[k]), "spread_mm": float(of.spread[k])}
    stated = {key: round(number, 3) for key, number in numbers.items() if np.isfinite(number)}
    return {"markers": ends} | stated if stated else ends


def _inline(value: Any) -> Any:
    """A value in one line."""
    if isinstance(value, dict):
        table = tomlkit.inline_table()
        for key, item in value.items():
            table.append(key, _inline(item))
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(_inline(item) for item in value)
        return array
    return tomlkit.item(value)
