"""The demonstration: a simulated gait laboratory, processed from its images alone and compared with the truth."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats
from ..engine.open_trial import OpenTrial
from ..engine.progress import Progress, silent
from ..engine.session import Session
from ..engine.session_name import FILE
from ..engine.simulate import Scene, simulate
from ..report.terminal_summary import summary
from ..synth.score import Score, score

NEAR_MM = 20.0
"""How far a named trajectory may be from its marker; chosen: markers are farther apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """A demonstration's outcome.

    Attributes:
        results: of the trial.
        score: against the truth; markers: how many there were; named: how many of them have their own name alone.
        seconds: the whole took; simulated: whether the images were made in it.
    """

    results: OpenTrial
    score: Score
    markers: int
    named: int
    seconds: float
    simulated: bool

    @property
    def passed(self) -> bool:
        """Whether every marker was recovered and rightly named, and none swapped."""
        return self.score.found == self.named == self.markers and self.score.swaps == 0

    def figures(self) -> dict[str, Any]:
        """The comparison as plain data."""
        s = self.score
        return {
            "markers": self.markers,
            "markers_recovered": s.found,
            "markers_named": self.named,
            "swaps": s.swaps,
            "recall": round(s.recall, 4),
            "tracks_per_marker": round(float(s.fragments.mean()), 3),
            "extra_points_per_frame": round(s.extra_per_frame, 4),
            "rmse_3d_mm": round(s.rmse, 4),
            "coverage_95": round(s.coverage, 4),
            "seconds": round(self.seconds, 1),
        }

    def text(self) -> str:
        """The comparison in words."""
        s = self.score
        return (
            f"{summary(self.results.quality)}\n\n"
            "Against the truth, which only this comparison has read:\n"
            f"  markers recovered   {s.found} of {self.markers}, in {s.fragments.sum()} tracks, {s.swaps} swaps\n"
            f"  markers named       {self.named} of {self.markers}, by an earlier trial of the subject\n"
            f"  samples recovered   {100 * s.recall:.1f} %, {s.extra_per_frame:.3f} points a frame that are no marker\n"
            f"  3D RMSE             {s.rmse:.3f} mm\n"
            f"  95 % ellipsoids     hold the truth in {100 * s.coverage:.1f} % of samples\n"
            f"  time                {self.seconds:.1f} s"
            f"{', the simulation and its images included' if self.simulated else ''}\n\n"
            f"trajectories  {self.results.folder / (self.results.folder.name + '.c3d')}\n"
            f"report        {self.results.folder / 'report.html'}"
        )


def demo(
    folder: Path, *, scene: Scene | None = None, self_contained: bool = False, progress: Progress = silent
) -> Demonstration:
    """Simulate a laboratory in a folder, run its session, and compare with the truth.

    A folder that holds a session of an earlier demonstration is run again without simulating it anew. Where
    `self_contained`, each page holds the drawing library.

    Raises:
        KinemarkError: the folder holds something else, or the session cannot be run.
    """
    began = time.perf_counter()
    fresh = not (folder / FILE).is_file() or not (folder / "truth.npz").is_file()
    if fresh:
        simulate(folder, scene=scene, progress=progress)
    session = Session.open(folder, self_contained=self_contained)
    results = next(iter(session.run(progress=progress).values()))
    with np.load(folder / "truth.npz", allow_pickle=False) as truth:
        xyz, names = truth["xyz"], [str(name) for name in truth["names"]]
    found = score(results.tracks, xyz)
    named = rightly_named(results.trajectories, xyz, names)
    return Demonstration(results, found, len(xyz), named, time.perf_counter() - began, fresh)


def rightly_named(trajectories: Trajectories, xyz: Floats, names: Sequence[str]) -> int:
    """How many of the markers at xyz (M, F, 3), mm, are where the trajectory of their name is, in all its frames."""
    right = 0
    for name, path in zip(names, xyz, strict=True):
        own = trajectories[name].xyz if name in trajectories.names else np.full_like(path, np.nan)
        away = np.linalg.norm(own - path, axis=1)
        right += bool(np.isfinite(away).any() and np.nanmax(away) < NEAR_MM)
    return right
