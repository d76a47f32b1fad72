"""Kinemark: marker-based optical motion capture, from camera images to 3D trajectories.

The stages, each `stage(data, …, method=Method(…)) -> data`:

    rig = read_rig_toml("rig.toml")
    seen = detect([open_images(f"walk/{c}.mkv") for c in rig.names], cameras=rig.names, rate=50.0)
    trajectories = to_trajectories(track_detections(seen, rig), rig)
    filled, gaps = fill(trajectories)
    write_c3d("walk.c3d", Trial("walk", filled))

A whole session with its report: `from kinemark.engine.session import Session`.
"""

import inspect
import sys
from collections.abc import Callable
from importlib import import_module
from types import ModuleType

import lazy_loader

# The public names stand in __init__.pyi; each is imported when it is first used.
_imported, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


class _Stage(ModuleType):
    """A package that is called as the function of its name: `kinemark.detect(…)` beside `kinemark.detect.learning`."""

    @property
    def _function(self) -> Callable[..., object]:
        return vars(self)[self.__name__.rpartition(".")[2]]

    def __call__(self, *args: object, **named: object) -> object:
        return self._function(*args, **named)

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self._function)

    def __reduce__(self) -> tuple[Callable[[str], ModuleType], tuple[str]]:
        return import_module, (self.__name__,)


class _Package(ModuleType):
    """Where a public function and the package that it lives in have one name, the package is both."""

    def __setattr__(self, name: str, value: object) -> None:
        if name in __all__ and isinstance(value, ModuleType):
            value.__class__ = _Stage
        super().__setattr__(name, value)


def __getattr__(name: str) -> object:
    found = _imported(name)
    package = sys.modules.get(f"{__name__}.{name}")
    if package is None:
        return found
    setattr(sys.modules[__name__], name, package)  # in the place of the function, which lazy_loader put there
    return package


sys.modules[__name__].__class__ = _Package
