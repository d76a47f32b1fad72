"""Parameters of a method, each declared once: default, unit, range and meaning.

A field of a method says all that there is to say of it,

    search_radius: float = parameter(40.0, unit="mm", above=0, meaning="radius of the search sphere about a prediction")

and its check, the settings, the list of methods, the tables of the documentation and the JSON schema follow from that.
The type of the field says the rest: `float | None` may be None, `Literal["first", "any"]` is a choice, and the range
of `tuple[float, ...]` is that of every element.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

import numpy as np

DECLARED = "declared"
"""Under which a dataclass' field keeps what was declared."""

SCALARS: dict[Any, str] = {bool: "true or false", int: "whole number", float: "number", str: "text"}

ONE = "1"
"""The unit of a pure number."""


class Range(NamedTuple):
    """What a number may be: `low` and `high` themselves are allowed, `above` and `below` are not.

    Numbers must be finite, unless a bound that is itself allowed is infinite.
    """

    low: float | None = None
    high: float | None = None
    above: float | None = None
    below: float | None = None

    def holds(self, value: float) -> bool:
        """Whether a number is in the range; NaN never is."""
        over = value >= self.low if self.low is not None else value > _or(self.above, -math.inf)
        under = value <= self.high if self.high is not None else value < _or(self.below, math.inf)
        return bool(over and under)

    def text(self) -> str:
        """The range in words, such as "0 to below 255"; empty where every finite number will do."""
        low = "" if self.low is None else f"{self.low:g}"
        high = "" if self.high is None or math.isinf(self.high) else f"{self.high:g}"
        above = "" if self.above is None else f"above {self.above:g}"
        below = "" if self.below is None else f"below {self.below:g}"
        if low and not (high or below):
            return f"{low} or more"
        if high and not (low or above):
            return f"{high} or less"
        return f"{above} and {below}" if above and below else " to ".join(filter(None, (low or above, high or below)))


class FieldMetadata(NamedTuple):
    """What the metadata of a field keeps of its parameter."""

    unit: str
    range: Range
    meaning: str
    former: str


def parameter(
    default: Any = MISSING,
    *,
    meaning: str,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    below: float | None = None,
    factory: Callable[[], Any] | None = None,
    former: str = "",
) -> Any:
    """A field of a method.

    Args:
        default: of the parameter; it must be given where there is neither default nor factory.
        meaning: in one line.
        unit: of a number, "mm", "px", …; "1" of a pure number, or what is counted, as "frames".
        low: least value; `above`: a bound that is not reached itself.
        high: greatest value, which may be infinite; `below`: a bound that is not reached itself. Without an infinite
            bound numbers must be finite.
        above: see `low`.
        below: see `high`.
        factory: makes the default, where it is only known later.
        former: name that the parameter had before; the error for it names the new one.
    """
    declared = {DECLARED: FieldMetadata(unit, Range(low, high, above, below), meaning, former)}
    if factory is not None:
        return field(default_factory=factory, metadata=declared)
    return field(default=default, metadata=declared)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter as it was declared.

    Attributes:
        name: of the field.
        type: its annotation.
        unit, range, meaning: as given to `parameter`.
        field_default: of the field; MISSING where it must be given.
        factory: makes the default; MISSING where none does.
        former: name that it had before; empty where it had no other.
    """

    name: str
    type: Any
    unit: str
    range: Range
    meaning: str
    field_default: Any = MISSING
    factory: Any = MISSING
    former: str = ""

    @property
    def default(self) -> Any:
        """The default; None where there is none, too."""
        if self.factory is not MISSING:
            return self.factory()
        return None if self.required else self.field_default

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.field_default is MISSING and self.factory is MISSING

    @property
    def optional(self) -> bool:
        """Whether it may be None."""
        return NoneType in get_args(self.type) if get_origin(self.type) in (Union, UnionType) else False

    @property
    def inner(self) -> Any:
        """Its type where it is not None."""
        if not self.optional:
            return self.type
        rest = tuple(part for part in get_args(self.type) if part is not NoneType)
        return rest[0] if len(rest) == 1 else Union[rest]  # noqa: UP007  # made of a tuple

    @property
    def kind(self) -> str:
        """What it is, in words; "record" where only Python can make one, so that no file can state it."""
        return _kind(self.inner)

    @property
    def choices(self) -> tuple[Any, ...]:
        """The values that it may have, of a choice."""
        return get_args(self.inner) if self.kind == "choice" else ()

    @property
    def stateable(self) -> bool:
        """Whether a file can state it."""
        return self.kind != "record"

    @property
    def leaf(self) -> Any:
        """The type of the elements of a list, at the bottom; else its own."""
        kind = self.inner
        while get_origin(kind) is tuple:
            kind = get_args(kind)[0]
        return kind

    def wanted(self) -> str:
        """What it may be, in words."""
        return _or_none(self._wanted(self.kind), self.optional)

    def check(self, value: Any) -> None:
        """Refuse what it may not be.

        Raises:
            ValueError: the message has the name, what was found and what is wanted.
        """
        if value is None and self.optional:
            return
        for name, found, fits in self._parts(self.name, value, self.inner):
            if not fits:
                what = self._wanted(self.kind if name == self.name else _kind(self.leaf))
                raise ValueError(f"{name} is {found!r}, wanted {_or_none(what, self.optional and name == self.name)}")

    def _parts(self, name: str, value: Any, kind: Any) -> Iterator[tuple[str, Any, bool]]:
        """Name, value and whether it is what it may be: of the value, or of all elements of a list."""
        if get_origin(kind) is tuple and not isinstance(value, str) and hasattr(value, "__iter__"):
            parts, one_kind = list(value), get_args(kind)
            if one_kind[-1] is not Ellipsis and len(parts) != len(one_kind):
                yield name, value, False
            for k, part in enumerate(parts):
                yield from self._parts(f"{name}[{k}]", part, one_kind[0])
        else:
            yield name, value, _fits(value, kind, self.range)

    def _wanted(self, kind: str) -> str:
        limits, unit = self.range.text(), "" if self.unit in ("", ONE) else f" {self.unit}"
        match kind:
            case "choice":
                return " or ".join(filter(None, (", ".join(self.choices[:-1]), self.choices[-1])))
            case "number":
                return f"a number {limits}{unit}".replace("  ", " ") if limits[:1] in ("", "a", "b") else limits + unit
            case "whole number":
                return f"a whole number{', ' if limits else ''}{limits}{unit}"
            case "list":
                of = self._wanted(_kind(self.leaf))
                return "a list" if _kind(self.leaf) in ("text", "record") else f"a list, each {of}"
            case _:
                return kind


def parameters_of(kind: type) -> tuple[Parameter, ...]:
    """The parameters that a class declares, in its order."""
    return _parameters(kind)


@cache
def _parameters(kind: Any) -> tuple[Parameter, ...]:
    hints, found = get_type_hints(kind), []
    for f in fields(kind):
        if DECLARED in f.metadata:
            unit, limits, meaning, former = f.metadata[DECLARED]
            found.append(Parameter(f.name, hints[f.name], unit, limits, meaning, f.default, f.default_factory, former))
    return tuple(found)


def check_parameters(method: object) -> None:
    """Refuse a method one of whose parameters is not what it may be.

    Raises:
        ValueError: as `Parameter.check`.
    """
    for declared in parameters_of(type(method)):
        declared.check(getattr(method, declared.name))


def _kind(inner: Any) -> str:
    if inner in SCALARS:
        return SCALARS[inner]
    if get_origin(inner) is Literal:
        return "choice"
    if get_origin(inner) is tuple:
        return "list"
    return "record"


def _fits(value: Any, kind: Any, limits: Range) -> bool:
    """Whether a value, which is not None, is of a kind and within limits."""
    if kind is bool:
        return isinstance(value, (bool, np.bool_))
    if kind in (int, float):
        number = isinstance(value, Integral if kind is int else Real) and not isinstance(value, bool)
        return number and limits.holds(value)
    if get_origin(kind) is Literal:
        return value in get_args(kind)
    if get_origin(kind) is tuple:  # it is no list, or it would have been taken apart
        return False
    return isinstance(value, str) if kind is str else True


def _or(value: float | None, default: float) -> float:
    return default if value is None else value


def _or_none(text: str, optional: bool) -> str:
    return f"{text}, or None" if optional else text
