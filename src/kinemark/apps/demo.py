"""The demonstration: a simulated gait laboratory, processed from its images alone and compared with the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.open_trial import OpenTrial
from ..engine.progress import Progress, silent
from ..engine.session import Session
from ..engine.session_name import FILE
from ..engine.simulate import Scene, simulate
from ..report.terminal_summary import summary
from ..synth.score import Score, score


@dataclass(frozen=True, slots=True, eq=False)
class Demonstration:
    """A demonstration's outcome.

    Attributes:
        results: of the trial.
        score: against the truth; markers: how many there were.
        seconds: the whole took; simulated: whether the images were made in it.
    """

    results: OpenTrial
    score: Score
    markers: int
    seconds: float
    simulated: bool

    @property
    def passed(self) -> bool:
        """Whether every marker was recovered and none swapped."""
        return self.score.found == self.markers and self.score.swaps == 0

    def figures(self) -> dict[str, Any]:
        """The comparison as plain data."""
        s = self.score
        return {
            "markers": self.markers,
            "markers_recovered": s.found,
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
        xyz = truth["xyz"]
    return Demonstration(results, score(results.tracks, xyz), len(xyz), time.perf_counter() - began, fresh)
