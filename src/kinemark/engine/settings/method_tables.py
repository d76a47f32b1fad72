"""The methods of each stage by their names, and their parameters from a table of the file."""

from __future__ import annotations

from dataclasses import MISSING, Field, fields, replace
from typing import Any, get_type_hints

from pydantic import TypeAdapter
from pydantic.errors import PydanticSchemaGenerationError
from typing_extensions import TypedDict

from ...calibrate import ControlPoints
from ...calibrate.bundle import Bundle
from ...calibrate.control_points import Dlt
from ...calibrate.wand import Wand
from ...detect import Centroids, KissNearest, KissScanning
from ...fill import METHODS as FILLING
from ...fill import Filling
from ...match import EpipolarTriplets, KissTriplets, NearestEpipolar
from ...reconstruct import CameraPairs, LeastSquares
from ...track import DistanceOnly, ExtrapolationLadder, KissTracking, Swamidas
from ...track.simultaneous import FormerTwoCameras, Simultaneous
from .suggestions import are, guess

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
    "fill": FILLING,
}
"""The methods of each stage under their names in a session file; the first is the default, but for `calibrate`, where
the way of calibrating decides (`METHODS_OF_WAY`)."""

METHODS_OF_WAY = {
    "file": (),
    "control_points": ("control_points", "dlt"),
    "control_frame": ("control_points", "dlt"),
    "wand": ("wand",),
    "single_marker": ("bundle",),
}
"""What `[calibrate]` may say for each way; the first is the default."""


def filling_of(table: dict[str, Any]) -> Filling:
    """What `[fill]` says: the parameters of its method, and those of filling as a whole.

    Raises:
        ValueError: as `method_of`.
    """
    own = {f.name for f in fields(Filling)} - {"method", "name"}
    whole = {key: value for key, value in table.items() if key in own}
    method = method_of("fill", {key: value for key, value in table.items() if key not in own})
    settled = TypeAdapter(Filling).validate_python(whole)
    return replace(settled, method=method, name=method_name("fill", method))


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
        raise ValueError(f"method {name!r} is not for a calibration by {way}; there {are(list(fitting))}")
    return method_of("calibrate", {"method": name} | table)


def method_of(stage: str, table: dict[str, Any]) -> Any:
    """A stage's method from its table.

    Raises:
        ValueError: the method or one of its parameters is not known, or a value is of the wrong kind.
    """
    table = dict(table)
    known = METHODS[stage]
    name = table.pop("method", default_name(stage))
    if name not in known:
        raise ValueError(f"method {name!r} is not known{guess(str(name), list(known))}; there {are(list(known))}")
    return parameters_of(known[name], name, table)


def parameters_of(kind: type, name: str, table: dict[str, Any]) -> Any:
    """A method with the parameters of a table.

    Raises:
        ValueError: one of them is not known, or a value is of the wrong kind.
    """
    parameters = plain_parameters(kind)
    for key in table:
        if key not in parameters:
            there = list(parameters)
            raise ValueError(f"{key!r} is not a parameter of {name}{guess(key, there)}; there {are(there)}")
    if absent := [f.name for f in fields(kind) if _required(f) and f.name not in table]:
        raise ValueError(f"{name} wants {' and '.join(absent)}")
    wanted = TypedDict(name, {key: parameters[key] for key in table})  # type: ignore[misc]  # known only now
    return kind(**TypeAdapter(wanted).validate_python(table))


def _required(field: Field[Any]) -> bool:
    """Whether a parameter has no default."""
    return field.default is MISSING and field.default_factory is MISSING


def plain_parameters(kind: type) -> dict[str, Any]:
    """The parameters of a method that a file can state, and their types; some take records that only Python has."""
    hints = get_type_hints(kind)
    plain = {}
    for field in fields(kind):
        try:
            TypeAdapter(hints[field.name])
        except PydanticSchemaGenerationError:
            continue
        plain[field.name] = hints[field.name]
    return plain


def default_name(stage: str) -> str:
    """What a session file calls the method of a stage that it does not name."""
    return next(iter(METHODS[stage]))


def method_name(stage: str, method: object) -> str:
    """What a session file calls a method."""
    return next(name for name, kind in METHODS[stage].items() if kind is type(method))
