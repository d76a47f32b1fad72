"""The methods of each stage by their names, and their parameters from a table of the file.

All that there is to say of a method is declared beside its function (`data.method`); nothing is listed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from pydantic import TypeAdapter
from typing_extensions import TypedDict

from ...calibrate import CALIBRATE
from ...data.method import Declaration, Parameter, Stage, parameters_of
from ...data.nearest_word import are, guess
from ...detect import DETECT
from ...digitise import DIGITISE
from ...fill import FILL, Filling
from ...kinematics import ANGLES, SMOOTH
from ...label import LABEL, Labelling
from ...match import MATCH
from ...reconstruct import RECONSTRUCT
from ...track import TRACK

STAGES: dict[str, Stage] = {
    stage.name: stage for stage in (CALIBRATE, DETECT, MATCH, RECONSTRUCT, TRACK, LABEL, FILL, DIGITISE, ANGLES, SMOOTH)
}
"""The stages in their order."""

SETTABLE: dict[str, Stage] = {name: stage for name, stage in STAGES.items() if stage not in (ANGLES, SMOOTH)}
"""Those that have a table of a method in a session file; `[angles]` is one of its own."""

COMMON: dict[str, tuple[Parameter, ...]] = {
    "label": parameters_of(Labelling),
    "fill": parameters_of(Filling),
}
"""Parameters that a stage has besides those of its methods."""

WHOLE: dict[str, type[Any]] = {"label": Labelling, "fill": Filling}
"""Of stages that have parameters besides those of their methods, what holds both."""


def whole_of(stage: str, table: dict[str, Any]) -> Any:
    """What the table of such a stage says: the parameters of its method, and those that go for all.

    Raises:
        ValueError: as `method_of`.
    """
    common = {p.name: p for p in COMMON[stage]}
    method = method_of(stage, {key: value for key, value in table.items() if key not in common}, beside=common)
    settled = _validated(stage, common, {key: value for key, value in table.items() if key in common})
    return WHOLE[stage](**settled, method=method, name=method_name(stage, method))


def methods_of_cameras(table: dict[str, Any], cameras: Any) -> dict[str, Any]:
    """The method of each camera: `[detect]` with what `[detect.cameras.NAME]` says in its place.

    Raises:
        ValueError: as `method_of`, or one is no table, or names another method.
    """
    if not isinstance(cameras, dict) or not all(isinstance(own, dict) for own in cameras.values()):
        raise ValueError("detect.cameras: wants a table for each camera, as [detect.cameras.left] and threshold = 40")
    made = {}
    for name, own in cameras.items():
        if "method" in own:
            raise ValueError(f"detect.cameras.{name}: method is one for all cameras, give it in [detect]")
        try:
            made[name] = method_of("detect", table | own)
        except ValueError as error:
            raise ValueError(f"detect.cameras.{name}: {error}") from error
    return made


def check_camera_names(cameras: Iterable[str], known: Sequence[str]) -> None:
    """Refuse parameters of cameras that are not among these.

    Raises:
        ValueError: there is one.
    """
    for name in cameras:
        if name not in known:
            raise ValueError(
                f"detect.cameras.{name}: no camera has this name{guess(name, list(known))}; there {are(list(known))}"
            )


def methods_of_way(way: str) -> list[str]:
    """What `[calibrate]` may name for a way of `[calibration]`, the default first."""
    return [name for name, declared in CALIBRATE.items() if way in declared.ways]


def calibrate_method(way: str, table: Any) -> Any:
    """The method of `[calibrate]`, which must be one that goes with the way of `[calibration]`.

    Raises:
        ValueError: as `method_of`, or the method is for another way.
    """
    fitting = methods_of_way(way) or list(CALIBRATE)
    if not isinstance(table, dict):
        return table
    name = table.get("method", fitting[0])
    if name in CALIBRATE and name not in fitting:
        raise ValueError(f"method {name!r} is not for a calibration by {way}; there {are(fitting)}")
    return method_of("calibrate", {"method": name} | table)


def method_of(stage: str, table: dict[str, Any], *, beside: Iterable[str] = ()) -> Any:
    """A stage's method from its table.

    Args:
        stage: its name.
        table: the method's name and parameters; what is absent is the default.
        beside: keys that the table may have besides, which an error lists too.

    Raises:
        ValueError: the method or one of its parameters is not known, or a value is of the wrong kind or out of range.
    """
    table, known = dict(table), STAGES[stage]
    name = table.pop("method", known.default)
    if not isinstance(name, str) or name not in known:
        raise ValueError(f"method {name!r} is not known{guess(str(name), list(known))}; there {are(list(known))}")
    return _made(known[name], table, ("method", *beside))


def _made(declared: Declaration, table: dict[str, Any], beside: Sequence[str]) -> Any:
    """A method with the parameters of a table."""
    parameters = {p.name: p for p in declared.stateable}
    renamed = {p.former: p.name for p in declared.stateable if p.former}
    for key in table:
        if key not in parameters and key in renamed:
            raise ValueError(f"{key!r} of {declared.name} is now called {renamed[key]!r}")
        if key not in parameters:
            there = [*beside, *parameters]
            raise ValueError(f"{key!r} is not a parameter of {declared.name}{guess(key, there)}; there {are(there)}")
    if absent := [p.name for p in declared.parameters if p.required and p.name not in table]:
        raise ValueError(f"{declared.name} wants {' and '.join(absent)}")
    return declared.kind(**_validated(declared.name, parameters, table))


def _validated(name: str, parameters: dict[str, Parameter], table: dict[str, Any]) -> dict[str, Any]:
    """The values of a table as Python has them, as tuples for lists; their ranges are checked by the method itself."""
    wanted = TypedDict(name, {key: parameters[key].type for key in table})  # type: ignore[misc]  # known only now
    return dict(TypeAdapter(wanted).validate_python(table))


def method_name(stage: str, method: object) -> str:
    """What a session file calls a method.

    Raises:
        ValueError: it is none of the stage's.
    """
    return STAGES[stage].of(method).name
