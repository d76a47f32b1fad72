"""Models of segment chains as TOML.

name, source, side = "right", forward = "+x", up = "+z"
base = "isb_upper_limb"                                          all that the file does not say is as in that model
[aliases]    MARKER = ["other name", "{S}NAME"]                  {S} is R or L, as the side is
[points]     NAME = ["A", "B"]                                   the mean of others
[[segment]]  name; first and second = { axis = "y", vector = ["from", "to"] }
             or { axis = "x", normal = ["from", "to", "from", "to"] }
[[joint]]    name, parent, child, sequence = "zxy", middle = "positive",
             angles = [{ positive = "flexion", negative = "extension", normal = [-10.0, 150.0] }, {}, …]
[[cluster]]  name, markers = [three or more], points = [what it carries]
[[centre]]   name, between = ["cluster", "cluster"]
[signs]      JOINT = [1, -1, 1]                                  −1 turns an angle round, with its words and range
[stick]      links = [["A", "B"], …]                             what the stick figure draws
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, TypeVar

from ..data import KinemarkError
from ..data.models import Axis, Centre, Cluster, Joint, JointMotion, Model, Segment
from ..data.nearest_word import guess
from .number_text import read_text
from .toml_text import check_keys, list_of, names_in, text_of, texts_of, toml_table

T = TypeVar("T")
SIMPLE = ("name", "source", "side", "forward", "up")
KEYS = {
    "the file": (
        [*SIMPLE, "base", "aliases", "points", "segment", "joint", "cluster", "centre", "signs", "stick"],
        ["name", "segment", "joint"],
    ),
    "segment": (["name", "first", "second"], ["name", "first", "second"]),
    "axis": (["axis", "vector", "normal"], ["axis"]),
    "joint": (
        ["name", "parent", "child", "sequence", "middle", "angles"],
        ["name", "parent", "child", "sequence", "angles"],
    ),
    "angle": (["positive", "negative", "normal"], []),
    "cluster": (["name", "markers", "points"], ["name", "markers"]),
    "centre": (["name", "between"], ["name", "between"]),
    "stick": (["links"], []),
}
"""What each table may have, and what it must have."""


def models() -> tuple[str, ...]:
    """Names of the models that come with Kinemark."""
    return names_in(_folder())


def _folder() -> Any:
    return files("kinemark.kinematics").joinpath("models")


def load_model(name_or_path: str | Path, *, side: Literal["right", "left"] | None = None) -> Model:
    """A model by its name, or from a TOML file.

    Args:
        name_or_path: one of `models()`, or the path of a file.
        side: instead of the model's own.

    Raises:
        KinemarkError: there is no such model or file, or the file is no such description.
    """
    name = str(name_or_path)
    if name in models():
        return model_from_toml(_folder().joinpath(f"{name}.toml").read_text(encoding="utf-8"), side=side)
    if not Path(name).is_file():
        meant = guess(name, models())
        raise KinemarkError(f"{name} is neither a model nor a file{meant}. Models are {', '.join(models())}.")
    try:
        return model_from_toml(read_text(name), side=side)
    except KinemarkError as error:
        raise KinemarkError(f"{name}: {error}") from None


def model_from_toml(text: str, *, side: Literal["right", "left"] | None = None) -> Model:
    """The model that a text describes.

    Raises:
        KinemarkError: it is no TOML, a key is unknown or absent, or the model does not hold together.
    """
    table = toml_table(text, "The model")
    try:
        return _model(_on_base(table), side)
    except (ValueError, TypeError) as error:
        raise KinemarkError(f"The model does not hold together: {error}. Correct it.") from None


def _on_base(table: dict[str, Any]) -> dict[str, Any]:
    """The table with what it leaves to the model that it names as its base; aliases come before those of the base."""
    if "base" not in table:
        return table
    base = _text("base", table["base"])
    if base not in models():
        raise ValueError(f"base is {base!r}, wanted one of {', '.join(models())}")
    below = tomllib.loads(_folder().joinpath(f"{base}.toml").read_text(encoding="utf-8"))
    known, own = (_table(each, "aliases") for each in (below, table))
    aliases = known | {name: [*texts_of(f"aliases.{name}", names), *known.get(name, ())] for name, names in own.items()}
    points = _table(below, "points") | _table(table, "points")
    return below | {k: v for k, v in table.items() if k != "base"} | {"aliases": aliases, "points": points}


def _model(table: dict[str, Any], side: str | None) -> Model:
    _check("the file", table)
    which = side or str(table.get("side", "right"))
    letter = "L" if which == "left" else "R"
    aliases = {
        name: tuple(other.replace("{S}", letter) for other in texts_of(f"aliases.{name}", others))
        for name, others in _table(table, "aliases").items()
    }
    means = {name: texts_of(f"points.{name}", parts) for name, parts in _table(table, "points").items()}
    stick = _table(table, "stick")
    _check("stick", stick)
    return Model(
        name=_text("name", table["name"]),
        source=_text("source", table.get("source", "")),
        side=which,  # type: ignore[arg-type]  # the record checks it
        forward=_text("forward", table.get("forward", "+x")),
        up=_text("up", table.get("up", "+z")),
        aliases=aliases,
        means=means,
        segments=_each(table, "segment", _segment),
        joints=_signed(_each(table, "joint", _joint), _table(table, "signs")),
        clusters=_each(table, "cluster", _cluster),
        centres=_each(table, "centre", _centre),
        links=tuple(_pair("a link of the stick figure", link) for link in list_of("links", stick.get("links", []))),
    )


def _each(table: Mapping[str, Any], kind: str, make: Callable[[Mapping[str, Any]], T]) -> tuple[T, ...]:
    rows = list_of(f"[[{kind}]]", table.get(kind, []))
    for row in rows:
        _check(kind, row)
    return tuple(make(row) for row in rows)


def _segment(row: Mapping[str, Any]) -> Segment:
    return Segment(_text("name", row["name"]), _axis(row["first"]), _axis(row["second"]))


def _axis(row: Any) -> Axis:
    _check("axis", row)
    if ("vector" in row) == ("normal" in row):
        raise ValueError(f"axis {row['axis']} must have either a vector or a normal")
    kind, wanted = ("vector", 2) if "vector" in row else ("normal", 4)
    points = texts_of(kind, row[kind])
    if len(points) != wanted:
        raise ValueError(f"the {kind} of axis {row['axis']} has {len(points)} points, wanted {wanted}")
    return Axis(_text("axis", row["axis"]), points)


def _joint(row: Mapping[str, Any]) -> Joint:
    motions = tuple(_motion(angle) for angle in list_of("angles", row["angles"]))
    name, parent, child, sequence = (_text(key, row[key]) for key in ("name", "parent", "child", "sequence"))
    return Joint(name, parent, child, sequence, motions, row.get("middle", "positive"))


def _signed(joints: tuple[Joint, ...], signs: Mapping[str, Any]) -> tuple[Joint, ...]:
    """The joints with the angles turned round that `[signs]` says."""
    names = [joint.name for joint in joints]
    if strange := sorted(set(signs) - set(names)):
        raise ValueError(f"signs has {', '.join(strange)}; there are the joints {', '.join(names)}")
    return tuple(_with_signs(joint, signs[joint.name]) if joint.name in signs else joint for joint in joints)


def _with_signs(joint: Joint, signs: Any) -> Joint:
    if not isinstance(signs, list) or len(signs) != 3 or not all(sign in (1, -1) for sign in signs):
        raise ValueError(f"signs of {joint.name} are {signs!r}, wanted three of 1 and -1")
    pairs = zip(joint.motions, signs, strict=True)
    motions = (motion.reversed() if motion and sign < 0 else motion for motion, sign in pairs)
    first, second, third = (int(sign) for sign in signs)
    return replace(joint, motions=tuple(motions), signs=(first, second, third))


def _motion(row: Any) -> JointMotion | None:
    _check("angle", row)
    if not row:
        return None
    if "positive" not in row:
        raise ValueError("an angle has no positive, the word for what the joint does where it is above zero")
    normal = row.get("normal")
    if normal is not None and not (
        isinstance(normal, list) and len(normal) == 2 and all(isinstance(x, (int, float)) for x in normal)
    ):
        raise ValueError(f"normal is {normal!r}, wanted the least and the greatest angle, deg")
    positive, negative = _text("positive", row["positive"]), _text("negative", row.get("negative", ""))
    return JointMotion(positive, negative, None if normal is None else (float(normal[0]), float(normal[1])))


def _cluster(row: Mapping[str, Any]) -> Cluster:
    points = texts_of("points", row.get("points", []))
    return Cluster(_text("name", row["name"]), texts_of("markers", row["markers"]), points)


def _centre(row: Mapping[str, Any]) -> Centre:
    return Centre(_text("name", row["name"]), _pair("between", row["between"]))


def _check(kind: str, row: Any) -> None:
    """A table has only known keys and all that it must have."""
    known, needed = KEYS[kind]
    if not isinstance(row, dict):
        raise ValueError(f"{kind} is {row!r}, wanted a table")
    check_keys(f"{kind} {row.get('name', '')}".strip() if kind != "the file" else kind, row, known)
    if absent := [key for key in needed if key not in row]:
        raise ValueError(f"{kind} {row.get('name', '')} has no {', '.join(absent)}".replace("  ", " "))


def _table(table: Mapping[str, Any], key: str) -> dict[str, Any]:
    found = table.get(key, {})
    if not isinstance(found, dict):
        raise ValueError(f"{key} is {found!r}, wanted a table")
    return found


def _text(key: str, value: Any) -> str:
    if key == "name" and not str(value).strip():
        raise ValueError(f"{key} is {value!r}, wanted text")
    return text_of(key, value)


def _pair(key: str, value: Any) -> tuple[str, str]:
    pair = texts_of(key, value)
    if len(pair) != 2:
        raise ValueError(f"{key} has {len(pair)} names, wanted two")
    return pair[0], pair[1]
