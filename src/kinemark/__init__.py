"""Kinemark: marker-based optical motion capture, from camera images to 3D trajectories.

The stages, each `stage(data, …, method=Method(…)) -> data`:

    rig = read_rig_toml("rig.toml")
    seen = detect([open_images(f"walk/{c}.mkv") for c in rig.names], cameras=rig.names, rate=50.0)
    trajectories = to_trajectories(track_detections(seen, rig), rig)
    filled, gaps = fill(trajectories)
    write_c3d("walk.c3d", Trial("walk", filled))

A whole session with its report: `from kinemark.engine.session import Session`.
"""

import sys
from types import ModuleType

import lazy_loader

# The public names stand in __init__.pyi; each is imported when it is first used.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


class _Package(ModuleType):
    """`kinemark.detect` is the function, although the package that it lives in has the same name.

    The import system would bind the package to that name as soon as anything in it is imported.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in __all__ and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
