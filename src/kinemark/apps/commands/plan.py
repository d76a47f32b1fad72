"""`kinemark plan`: where the cameras should stand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...engine.plan_settings import PlanSettings
from ..output import Json, SelfContained, print_result
from ..progress import progress


def plan(
    folder: Path = Path("plan"),
    *,
    settings: Annotated[PlanSettings | None, Parameter(name="*")] = None,
    self_contained: SelfContained = False,
    json: Json = False,
) -> None:
    """Say where cameras should stand for a volume and a subject, how exact they will be, and what one more would bring.

    Writes plan.toml (the cameras, as a rig file), plan.json and plan.html.

    Args:
        folder: of the results.
        settings: what is asked for.
    """
    from ...engine.camera_plan import camera_plan
    from ...report.terminal_summary import plan_summary

    with progress() as tell:
        result = camera_plan(folder, settings=settings or PlanSettings(), self_contained=self_contained, progress=tell)
    print_result(result.figures if json else f"{plan_summary(result.figures)}\nresults:  {result.folder}/plan.html")
