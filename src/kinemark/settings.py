"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, field_validator, model_validator

from .calibrate import ControlPoints
from .data import KinemarkError
from .detect import Centroids
from .match import EpipolarTriplets
from .reconstruct import LeastSquares
from .track import ExtrapolationLadder

METHODS: dict[str, dict[str, type]] = {
    "calibrate": {"control_points": ControlPoints},
    "detect": {"centroids": Centroids},
    "match": {"epipolar_triplets": EpipolarTriplets},
    "reconstruct": {"least_squares": LeastSquares},
    "track": {"extrapolation_ladder": ExtrapolationLadder},
}
"""The methods of each stage under their names in a session file; the first is the default."""

ADVICE = "A session is a folder with a session.toml, saved as UTF-8; docs/session.md shows one."

RESERVED = (".", "..", "rig.toml", "steps.json")
"""What a trial cannot be called, since results are kept by these names."""

Unit = Literal["mm", "cm", "m", "in"]
Model = TypeVar("Model", bound=BaseModel)


class Strict(BaseModel):
    """A table of the file; a key that it does not know is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Cameras(Strict):
    """`[cameras]`: names in their order; interlaced: "top" or "bottom" (true means "top") where fields are frames."""

    names: tuple[str, ...] = ()
    interlaced: bool | Literal["top", "bottom"] = False

    @field_validator("names")
    @classmethod
    def distinct(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        """Two cameras of one name could not be told apart."""
        if len(set(names)) != len(names):
            raise ValueError(f"names must differ, found {list(names)}")
        return names

    @property
    def first_field(self) -> Literal[False, "top", "bottom"]:
        """Which field of a frame was taken first; False where frames are whole."""
        return "top" if self.interlaced is True else self.interlaced


class DigitisedPoints(Strict):
    """Control points and their places in the images, in a CSV file; with images, a place snaps to the marker there."""

    points: Path
    images: str | None = None


class ControlFrame(Strict):
    """Hanging rods of markers, recognised in one image a camera."""

    rods: Path
    images: str


class Calibration(Strict):
    """`[calibration]`: exactly one way."""

    file: Path | None = None
    length_unit: Unit | None = None
    control_points: DigitisedPoints | None = None
    control_frame: ControlFrame | None = None

    @model_validator(mode="after")
    def one_way(self) -> Calibration:
        """Exactly one way must be given."""
        ways = [way for way in ("file", "control_points", "control_frame") if getattr(self, way) is not None]
        if len(ways) != 1:
            found = " and ".join(ways) or "none"
            raise ValueError(f"wants exactly one of file, control_points and control_frame, found {found}")
        return self


class TrialEntry(Strict):
    """`[[trials]]`: images or detections."""

    name: str
    images: str | None = None
    detections: Path | None = None

    @field_validator("name")
    @classmethod
    def folder(cls, name: str) -> str:
        """Results go into a folder of this name."""
        if not name.isprintable() or Path(name).name != name or len(name) > 100 or name in RESERVED:
            raise ValueError(f"the name must be one that a folder can have, and not {', '.join(RESERVED)}")
        return name

    @model_validator(mode="after")
    def one_source(self) -> TrialEntry:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError(f"trial {self.name!r} wants either images or detections")
        return self


class Settings(Strict):
    """The whole file."""

    name: str
    rate_hz: float | None = Field(None, gt=0, le=1e6)
    volume_mm: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    cameras: Cameras = Cameras()
    calibration: Calibration
    trials: tuple[TrialEntry, ...] = Field(min_length=1)
    calibrate: ControlPoints = ControlPoints()
    detect: Centroids = Centroids()
    match: EpipolarTriplets = EpipolarTriplets()
    reconstruct: LeastSquares = LeastSquares()
    track: ExtrapolationLadder = ExtrapolationLadder()

    @field_validator("calibrate", "detect", "match", "reconstruct", "track", mode="before")
    @classmethod
    def chosen(cls, table: Any, info: Any) -> Any:
        """The method that a stage's table names, with its parameters."""
        return method_of(info.field_name, table) if isinstance(table, dict) else table

    @field_validator("volume_mm")
    @classmethod
    def box(cls, volume: Any) -> Any:
        """The first corner is the lesser one."""
        if volume is not None and not all(a < b for a, b in zip(*volume, strict=True)):
            raise ValueError("wants the least corner first, then the greatest")
        return volume

    @field_validator("trials")
    @classmethod
    def distinct(cls, trials: tuple[TrialEntry, ...]) -> tuple[TrialEntry, ...]:
        """Results are kept by name, so names must differ."""
        names = [trial.name for trial in trials]
        if len(set(names)) != len(names):
            raise ValueError(f"trials must have different names, found {names}")
        return trials


def method_of(stage: str, table: dict[str, Any]) -> Any:
    """A stage's method from its table.

    Raises:
        ValueError: the method or one of its parameters is not known, or a value is of the wrong kind.
    """
    table = dict(table)
    known = METHODS[stage]
    name = table.pop("method", next(iter(known)))
    if name not in known:
        raise ValueError(f"method {name!r} is not known; there {_are(list(known))}")
    kind = known[name]
    parameters = [f.name for f in fields(kind)]
    for key in table:
        if key not in parameters:
            raise ValueError(f"{key!r} is not a parameter of {name}{_guess(key, parameters)}; there {_are(parameters)}")
    return TypeAdapter(kind).validate_python(table)


def read_settings(path: Path) -> Settings:
    """The settings of a session file.

    Raises:
        KinemarkError: it is absent, no TOML, or says something that is not understood; all such places are named.
    """
    try:
        if not path.is_file():
            raise KinemarkError(
                f"{path} is not there. Write one, or make one to look at with: kinemark simulate FOLDER"
            )
        return Settings.model_validate(tomllib.loads(path.read_text("utf-8")))
    except UnicodeDecodeError as error:
        raise KinemarkError(f"{path} is not UTF-8 text: {error.reason}. {ADVICE}") from error
    except tomllib.TOMLDecodeError as error:
        raise KinemarkError(f"{path} is not TOML: {error}. Correct that line.") from error
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error}") from error
    except ValidationError as error:
        rows = [row for row in error.errors() if row["loc"] != ("trials",) or len(error.errors()) == 1]
        lines = "\n".join(f"  {_said(row)}" for row in rows)
        raise KinemarkError(f"{path} has settings that are not understood:\n{lines}") from error


def _said(row: Any) -> str:
    """One line of a pydantic error, in the words of the file."""
    where = ".".join(str(part) for part in row["loc"])
    if row["type"] == "extra_forbidden":
        keys = _keys(row["loc"][:-1])
        return f"{where}: there is no such key{_guess(str(row['loc'][-1]), keys)}; there {_are(keys)}"
    if row["type"] == "missing":
        return f"{where}: is missing"
    return f"{where}: {row['msg'].removeprefix('Value error, ')}, found {row['input']!r}"[:400]


def _keys(table: tuple[Any, ...]) -> list[str]:
    """The keys that a table of the file may have."""
    model: Any = Settings
    for part in table:
        if isinstance(part, str):
            model = {
                "cameras": Cameras,
                "calibration": Calibration,
                "trials": TrialEntry,
                "control_points": DigitisedPoints,
                "control_frame": ControlFrame,
            }[part]
    return list(model.model_fields)


def _guess(key: str, keys: list[str]) -> str:
    """A suggestion for a mistyped key."""
    near = difflib.get_close_matches(key, keys, 1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def _are(keys: list[str]) -> str:
    """What there is, in words."""
    return ("is only " if len(keys) == 1 else "are ") + ", ".join(keys)
