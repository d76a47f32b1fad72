"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, field_validator, model_validator

from .calibrate import ControlPoints
from .calibrate.bundle import Bundle
from .calibrate.control_points import Dlt
from .calibrate.reference_marker import REACH, TOLERANCE
from .calibrate.wand import Wand
from .data import KinemarkError
from .detect import Centroids, KissNearest, KissScanning
from .follow import FOLLOWERS, FormerTwoCameras, Simultaneous
from .match import EpipolarTriplets, KissTriplets, NearestEpipolar
from .reconstruct import CameraPairs, LeastSquares
from .track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas

METHODS: dict[str, dict[str, type]] = {
    "calibrate": {"control_points": ControlPoints, "dlt": Dlt, "wand": Wand, "bundle": Bundle},
    "detect": {"centroids": Centroids, "kiss_scanning": KissScanning, "kiss_nearest": KissNearest},
    "match": {
        "epipolar_triplets": EpipolarTriplets,
        "kiss_triplets": KissTriplets,
        "nearest_epipolar": NearestEpipolar,
    },
    "reconstruct": {"least_squares": LeastSquares, "camera_pairs": CameraPairs},
    "track": {
        "simultaneous": Simultaneous,
        "former_two_cameras": FormerTwoCameras,
        "extrapolation_ladder": ExtrapolationLadder,
        "kiss_tracking": KissTracking,
        "swamidas": Swamidas,
        "distance_only": DistanceOnly,
    },
}
"""The methods of each stage under their names in a session file; the first is the default, but for `calibrate`, where
the way of calibrating decides (`METHODS_OF_WAY`)."""

ADVICE = "A session is a folder with a session.toml, saved as UTF-8; docs/session.md shows one."

RESERVED = (".", "..", "rig.toml", "steps.json", "calibration.json", "calibration.html", "calibrations")
"""What a trial cannot be called, since results are kept by these names."""

Unit = Literal["mm", "cm", "m", "in"]
Model = TypeVar("Model", bound=BaseModel)


class Strict(BaseModel):
    """A table of the file; a key that it does not know is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Cameras(Strict):
    """`[cameras]`: names in their order; interlaced: "top" or "bottom" (true means "top") where fields are frames.

    size_px: width and height of all images, where a calibration from detections cannot know them otherwise.
    """

    names: tuple[str, ...] = ()
    size_px: tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]] | None = None
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


class Seen(Strict):
    """What cameras saw of something: images, or detections made of them before. Exactly one of both."""

    images: str | None = None
    detections: Path | None = None

    @model_validator(mode="after")
    def one_source(self) -> Self:
        """Exactly one source must be given."""
        if (self.images is None) == (self.detections is None):
            raise ValueError("wants either images or detections")
        return self


class DigitisedPoints(Strict):
    """Control points and their places in the images, in a CSV file; with images, a place snaps to the marker there.

    marker_diameter_mm: of spheres, whose images are then corrected for perspective.
    """

    points: Path
    images: str | None = None
    marker_diameter_mm: float | None = Field(None, gt=0)


class ControlFrame(Strict):
    """Hanging rods of markers, recognised in one image a camera."""

    rods: Path
    images: str


class WandRecording(Seen):
    """A stick with markers in a row, waved through the volume.

    lengths_mm: gaps between neighbouring markers, K − 1 of K markers; marker_diameter_mm: of spheres.
    """

    lengths_mm: tuple[Annotated[float, Field(gt=0)], ...] = Field(min_length=1, max_length=3)
    marker_diameter_mm: float | None = Field(None, gt=0)


class Distance(Seen):
    """Two markers at a known distance, from centre to centre, that all cameras see."""

    mm: float = Field(gt=0)


class SingleMarker(Seen):
    """One marker, as an LED, moved through the volume; the scale is that of `distance`, or of the world frame."""

    distance: Distance | None = None


class LFrame(Seen):
    """Three markers on the floor that make the world: a corner, a long arm along X and a short one along Y.

    arms_mm: from the corner to the marker on each arm, centre to centre; height_mm: of the centres above the floor.
    """

    height_mm: float = 0.0
    arms_mm: tuple[Annotated[float, Field(gt=0)], Annotated[float, Field(gt=0)]]


class LinearisationGrid(Strict):
    """A plane grid seen from near by, one image a camera, or several by a pattern with *.

    grid: columns and rows, of dots or of inner corners; pitch_mm: between neighbours; radial, tangential: which lens
    terms are fitted; chosen by cross-validation where absent.
    """

    grid: tuple[Annotated[int, Field(ge=3)], Annotated[int, Field(ge=3)]]
    pitch_mm: float = Field(gt=0)
    images: str
    pattern: Literal["dots", "chessboard"] = "dots"
    radial: int | None = Field(None, ge=0, le=3)
    tangential: bool | None = None


Places = dict[str, tuple[tuple[float, float], ...]]


class Calibration(Strict):
    """`[calibration]`: exactly one way; beside most of them the lenses, the world frame, and fixed marks.

    reference_marker: where each camera saw marks that never move when it was calibrated, px; their shift in a trial
    corrects its detections. mark_reach_px: no image shifts further; mark_tolerance_px: how far marks of one camera may
    differ from a common shift, and move during a trial.
    """

    file: Path | None = None
    length_unit: Unit | None = None
    control_points: DigitisedPoints | None = None
    control_frame: ControlFrame | None = None
    wand: WandRecording | None = None
    single_marker: SingleMarker | None = None
    linearisation: LinearisationGrid | None = None
    l_frame: LFrame | None = None
    world_points: DigitisedPoints | None = None
    reference_marker: Places | None = None
    mark_reach_px: float = Field(REACH, gt=0)
    mark_tolerance_px: float = Field(TOLERANCE, gt=0)

    @property
    def way(self) -> str:
        """The name of the way."""
        return next(way for way in WAYS if getattr(self, way) is not None)

    @model_validator(mode="after")
    def one_way(self) -> Calibration:
        """Exactly one way must be given, and beside it only what goes with it."""
        ways = [way for way in WAYS if getattr(self, way) is not None]
        if len(ways) != 1:
            found = " and ".join(ways) or "none"
            raise ValueError(f"wants exactly one of {', '.join(WAYS[:-1])} and {WAYS[-1]}, found {found}")
        goes_with = {"length_unit": ("file",), "linearisation": WAYS[1:], "l_frame": FREE, "world_points": FREE}
        for key, partners in goes_with.items():
            if getattr(self, key) is not None and ways[0] not in partners:
                raise ValueError(f"{key} goes with {' or '.join(partners)}, not with {ways[0]}")
        if self.l_frame and self.world_points:
            raise ValueError("wants one world frame, l_frame or world_points, found both")
        if self.single_marker and not (self.single_marker.distance or self.l_frame or self.world_points):
            raise ValueError("single_marker does not tell the scale: give distance in it, l_frame or world_points")
        return self


WAYS = ("file", "control_points", "control_frame", "wand", "single_marker")
"""The ways to a calibration, of which a session has one."""

FREE = ("wand", "single_marker")
"""Those that know no laboratory: their world is the first camera's unless it is given."""

METHODS_OF_WAY = {
    "file": (),
    "control_points": ("control_points", "dlt"),
    "control_frame": ("control_points", "dlt"),
    "wand": ("wand",),
    "single_marker": ("bundle",),
}
"""What `[calibrate]` may say for each way; the first is the default."""


class Masks(Strict):
    """`[masks]`: parts of the images to leave out, drawn in a file, or learned from a recording of the empty volume."""

    file: Path | None = None
    empty: str | None = None
    grow_px: float | None = Field(None, ge=0)

    @model_validator(mode="after")
    def something(self) -> Masks:
        """An empty table would mask nothing."""
        if self.file is None and self.empty is None:
            raise ValueError("wants file, empty or both")
        return self


class TrialEntry(Strict):
    """`[[trials]]`: images or detections.

    reference_marker: where the fixed marks of `[calibration]` are now; found among the detections where absent.
    """

    name: str
    images: str | None = None
    detections: Path | None = None
    reference_marker: Places | None = None

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
    masks: Masks | None = None
    calibrate: ControlPoints | Dlt | Wand | Bundle = Field(None, validate_default=True)
    detect: Centroids | KissScanning | KissNearest = Centroids()
    match: EpipolarTriplets | KissTriplets | NearestEpipolar = EpipolarTriplets()
    reconstruct: LeastSquares | CameraPairs = LeastSquares()
    track: Simultaneous | FormerTwoCameras | ExtrapolationLadder | KissTracking | Swamidas | DistanceOnly = (
        Simultaneous()
    )

    @field_validator("calibrate", "detect", "match", "reconstruct", "track", mode="before")
    @classmethod
    def chosen(cls, table: Any, info: Any) -> Any:
        """The method that a stage's table names, with its parameters."""
        if info.field_name == "calibrate" and "calibration" in info.data:
            return calibrate_method(info.data["calibration"].way, {} if table is None else table)
        return method_of(info.field_name, table) if isinstance(table, dict) else table

    @model_validator(mode="after")
    def stages_used(self) -> Settings:
        """A tracker that takes images directly leaves the stages before it nothing to do."""
        idle = {"match", "reconstruct"} & self.model_fields_set if type(self.track) in FOLLOWERS else set()
        if isinstance(self.track, Simultaneous) and isinstance(self.reconstruct, LeastSquares):
            idle -= {"reconstruct"}  # its points are placed so
        if idle:
            own = _method_name("track", self.track)
            staged = ", ".join(name for name, kind in METHODS["track"].items() if kind not in FOLLOWERS)
            raise ValueError(
                f"track by {own!r} matches by itself, so [{'] and ['.join(sorted(idle))}] would do nothing: "
                f"leave it out, or give [track] one of the methods {staged}"
            )
        return self

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


def calibrate_method(way: str, table: Any) -> Any:
    """The method of `[calibrate]`, which must be one that goes with the way of `[calibration]`.

    Raises:
        ValueError: as `method_of`, or the method is for another way.
    """
    fitting = METHODS_OF_WAY[way] or tuple(METHODS["calibrate"])
    if not isinstance(table, dict):
        return table
    name = table.get("method", fitting[0])
    if name in METHODS["calibrate"] and name not in fitting:
        raise ValueError(f"method {name!r} is not for a calibration by {way}; there {_are(list(fitting))}")
    return method_of("calibrate", {"method": name} | table)


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


def _method_name(stage: str, method: object) -> str:
    """What a session file calls a method."""
    return next(name for name, kind in METHODS[stage].items() if kind is type(method))


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
    if not where:
        return str(row["msg"].removeprefix("Value error, "))
    if row["type"] == "missing":
        return f"{where}: is missing"
    return f"{where}: {row['msg'].removeprefix('Value error, ')}, found {row['input']!r}"[:400]


def _keys(table: tuple[Any, ...]) -> list[str]:
    """The keys that a table of the file may have."""
    model: Any = Settings
    for part in table:
        if isinstance(part, str) and part in model.model_fields:
            model = _model_in(model.model_fields[part].annotation) or model
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The table that a type holds, as in `Table | None` and `tuple[Table, ...]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_model_in, get_args(annotation))), None)


def _guess(key: str, keys: list[str]) -> str:
    """A suggestion for a mistyped key."""
    near = difflib.get_close_matches(key, keys, 1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def _are(keys: list[str]) -> str:
    """What there is, in words."""
    return ("is only " if len(keys) == 1 else "are ") + ", ".join(keys)
