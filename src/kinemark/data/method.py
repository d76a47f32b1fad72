"""A method is declared once: its name, its function and its parameters, in one file.

    @dataclass(frozen=True, slots=True)
    class KissTracking(Method):
        \"\"\"Tracking by linear extrapolation and a search sphere.\"\"\"

        search_radius: float = parameter(40.0, unit="mm", above=0, meaning="radius of the search sphere")

    @TRACK.method("kiss_tracking", KissTracking, source="Shafiq, Tümer and Güler 2001, section 5")
    def track_kiss(cloud: Cloud, *, method: KissTracking) -> Tracks:
        ...

A stage knows all methods whose modules lie anywhere in its package: it imports them when it is first asked. So a new
method is one new file there, and the stage's function, the settings, `--set`, `kinemark methods`, the tables of the
documentation and the JSON schema have it. A method that is declared elsewhere is known as soon as it is imported.
"""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from inspect import cleandoc
from pathlib import PurePath
from threading import RLock
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .parameter import ONE, Parameter, check_parameters, parameter, parameters_of

__all__ = [
    "ONE",
    "Declaration",
    "Method",
    "Parameter",
    "Stage",
    "check_parameters",
    "parameter",
    "parameters_of",
    "plain_parameters",
]

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Method:
    """Base of all methods, frozen dataclasses whose parameters are checked as they were declared."""

    def __post_init__(self) -> None:
        check_parameters(self)
        self.check_together()

    def check_together(self) -> None:
        """Refuse parameters that do not go together; overridden by methods that have such a rule.

        Raises:
            ValueError: they do not.
        """


@dataclass(frozen=True, slots=True)
class Declaration:
    """A method as it was declared.

    Attributes:
        stage: the stage's name.
        name: in settings and on the command line.
        kind: the class of its parameters.
        function: does the work, called as the stage says; None where the stage chooses among methods by it.
        source: author, year and section of the method's publication; empty where it is Kinemark's own.
        takes: what the function takes, where methods of one stage take different things.
        ways: of calibrating, that it goes with.
        rank: place among the stage's methods where their order matters; those without come last.
    """

    stage: str
    name: str
    kind: type[Method]
    function: Callable[..., Any] | None = None
    source: str = ""
    takes: str = ""
    ways: tuple[str, ...] = ()
    rank: int = 1000

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Its parameters, in their order."""
        return parameters_of(self.kind)

    @property
    def stateable(self) -> tuple[Parameter, ...]:
        """Those of its parameters that a file can state."""
        return tuple(p for p in self.parameters if p.stateable)

    @property
    def summary(self) -> str:
        """What it does, in one sentence."""
        return cleandoc(self.kind.__doc__ or "").split("\n\n")[0].replace("\n", " ")


class Stage(Mapping[str, Declaration]):
    """The methods of a stage by their names, the default first and the others by rank and alphabet.

    Attributes:
        name: in settings and on the command line.
        package: in which its methods' modules are looked for.
        default: name of the method that is taken where none is named.
        meaning: what the stage does, in one line.
    """

    def __init__(self, name: str, package: str, *, default: str, meaning: str) -> None:
        self.name, self.package, self.default, self.meaning = name, package, default, meaning
        self._known: dict[str, Declaration] = {}
        self._complete, self._lock = False, RLock()

    def method(self, name: str, kind: type[Method], **more: Any) -> Callable[[Function], Function]:
        """Declare the function that is decorated to be that of a method; `more` as `Declaration`."""

        def declared(function: Function) -> Function:
            self.declare(Declaration(self.name, name, kind, function, **more))
            return function

        return declared

    def declare(self, declaration: Declaration) -> None:
        """Make a method known.

        Raises:
            ValueError: another one has its name.
            TypeError: a field of its class is not declared with `parameter`.
        """
        name, kind = declaration.name, declaration.kind
        known = self._known.get(name)
        if known and (known.kind.__module__, known.kind.__qualname__) != (kind.__module__, kind.__qualname__):
            raise ValueError(
                f"{self.name} has a method {name!r} already, {known.kind.__qualname__}; choose another name"
            )
        declared = {p.name for p in parameters_of(kind)}
        if unsaid := [f.name for f in fields(kind) if f.name not in declared]:
            raise TypeError(f"{kind.__qualname__}.{unsaid[0]} is not declared, wanted {unsaid[0]}: … = parameter(…)")
        self._known[name] = declaration

    def __getitem__(self, name: str) -> Declaration:
        if name not in self._known:
            self._find()
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        self._find()
        return iter(sorted(self._known, key=lambda name: (name != self.default, self._known[name].rank, name)))

    def __len__(self) -> int:
        self._find()
        return len(self._known)

    def of(self, method: object) -> Declaration:
        """The declaration of a method by its type.

        Raises:
            ValueError: it is none of the stage's.
        """
        for complete in (False, True):
            if complete:
                self._find()
            for declaration in self._known.values():
                if declaration.kind is type(method):
                    return declaration
        raise ValueError(f"{method!r} is no method of the stage {self.name}; there are {', '.join(self)}")

    def function(self, method: object, *, takes: str = "") -> Callable[..., Any]:
        """What does a method.

        Raises:
            ValueError: it is none of the stage's, or it takes something else.
        """
        found = self.of(method)
        if found.takes != takes or found.function is None:
            fitting = [name for name, other in self.items() if other.takes == takes and other.function]
            raise ValueError(
                f"method {found.name} takes no {takes or 'input here'}, wanted one of {', '.join(fitting)}"
            )
        return found.function

    def make(self, name: str | None = None, **parameters: Any) -> Any:
        """A method by its name; the default where none is given.

        Raises:
            KeyError: there is none of that name.
            ValueError: a parameter is not what it may be.
        """
        return self[name or self.default].kind(**parameters)

    def _find(self) -> None:
        """Import all modules of the package, which declare the methods; only the first time."""
        with self._lock:
            if not self._complete:
                self._complete = True  # modules may ask while they are being imported
                try:
                    _import_all(importlib.import_module(self.package))
                except BaseException:
                    self._complete = False
                    raise


def _import_all(package: Any) -> None:
    for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
        if found.name.rpartition(".")[2].startswith("_"):  # compiled code
            continue
        module = importlib.import_module(found.name)
        if found.ispkg:
            _import_all(module)


def plain_parameters(method: Any) -> dict[str, Any]:
    """The parameters of a method as plain values that JSON can hold, for keys and for the record of what was done.

    An array becomes its type, shape and a hash of its content; a record becomes its class and its fields; None gives
    none. Equal methods give equal values, on every machine.

    Raises:
        TypeError: a value is none that can be written down.
    """
    return {} if method is None else {f.name: plain(getattr(method, f.name), f.name) for f in fields(method)}


def plain(value: Any, name: str = "value") -> Any:
    """One such value, called by its name where it cannot be written down."""
    if value is None or (isinstance(value, (bool, int, str)) and not isinstance(value, Enum)):
        return value
    if isinstance(value, np.generic):
        return plain(value.item(), name)
    if isinstance(value, float):
        return value if np.isfinite(value) else str(value)  # JSON has no word for these
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, np.ndarray):
        return _of_array(value)
    if is_dataclass(value) or hasattr(value, "_fields"):
        names = value._fields if isinstance(value, tuple) else [f.name for f in fields(value)]  # type: ignore[attr-defined]
        return {"is": type(value).__name__} | {one: plain(getattr(value, one), f"{name}.{one}") for one in names}
    if isinstance(value, Mapping):
        return {str(key): plain(one, f"{name}[{key}]") for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [plain(one, f"{name}[{k}]") for k, one in enumerate(value)]
    raise TypeError(f"{name} is a {type(value).__name__}, wanted a plain value, an array, or a record of these")


def _of_array(array: NDArray[Any]) -> dict[str, Any]:
    """Type, shape and hash of the content, whatever the order of its bytes in memory."""
    if array.dtype.hasobject:
        raise TypeError("an array holds Python objects, wanted numbers or text")
    dtype = array.dtype.newbyteorder("<")
    content = np.ascontiguousarray(array, dtype).tobytes()
    return {"array": dtype.str, "shape": list(array.shape), "sha256": hashlib.sha256(content).hexdigest()}
