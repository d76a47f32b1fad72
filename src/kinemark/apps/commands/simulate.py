"""`kinemark simulate` and `demo`: the virtual laboratory."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...data import KinemarkError
from ...data.typed import typed
from ...engine.simulate import Scene
from ...engine.simulate import simulate as simulate_session
from ..output import Json, SelfContained, print_result
from ..progress import progress


def demo(folder: Path = Path("demo"), *, self_contained: SelfContained = False, json: Json = False) -> None:
    """Simulate a gait laboratory, process its images, and compare with the truth.

    Args:
        folder: where the session goes.
    """
    from ..demo import demo as run_demo

    with progress() as tell:
        result = run_demo(folder, self_contained=self_contained, progress=tell)
    print_result(result.figures() if json else result.text())
    if not result.passed:
        raise KinemarkError("The demo did not reach what it should; see the figures above.")


def simulate(folder: Path, *, scene: Annotated[Scene | None, Parameter(name="*")] = None, json: Json = False) -> None:
    """Make a session of a virtual laboratory, with images and exact truth, ready for `kinemark run`.

    Args:
        folder: a new or empty folder.
        scene: what is simulated.
    """
    scene = scene or Scene()
    with progress() as tell:
        simulate_session(folder, scene=scene, progress=tell)
    file = folder / "session.toml"
    said = f"{file} is written. Next: kinemark run {typed(folder)}"
    print_result({"written": str(file), "scene": scene.figures()} if json else said)
