"""2D points whose markers a file names: nothing is matched or tracked, and trajectories have the names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...data import Detections, KinemarkError
from ...io.detections_csv import NamedDetections
from ...io.named_points_csv import layout_of, read_camera_files, read_named_detections
from ..keys import digest, file_key
from .excerpt import within
from .operated import marker_within
from .recording import Recording
from .trial_source import OperatorIdentities, PlainSource

HOLE = "{camera}"


def names_markers(of: Recording) -> bool:
    """Whether a trial's file of 2D points is a CSV that says which marker each one is."""
    text = str(of.entry.detections)
    if not text.lower().endswith(".csv"):
        return False
    first = of.root / text.replace(HOLE, of.rig.names[0])
    return HOLE in text or (first.is_file() and layout_of(first) is not None)


@dataclass(frozen=True, slots=True)
class NamedDetectionFile(PlainSource):
    """A CSV file of 2D points with names, or one a camera."""

    of: Recording

    @property
    def paths(self) -> dict[str, Path]:
        """The file of each camera; the same for all where there is one."""
        text = str(self.of.entry.detections)
        return {name: self.of.root / text.replace(HOLE, name) for name in self.of.rig.names}

    def key(self) -> str:
        """Of the files, the cameras' order, the rate, fixed marks and the cameras' times."""
        of, files = self.of, tuple(dict.fromkeys(self.paths.values()))
        if missing := [path for path in files if not path.is_file()]:
            raise KinemarkError(f"{missing[0]} is not a file. Check detections of trial {of.entry.name!r}.")
        return digest(file_key(*files), of.rig.names, of.rate(None), of.corrections(), of.frames)

    def detections(self, threads: int | None = None) -> Detections:
        """Those of the calibrated cameras.

        Raises:
            KinemarkError: a file cannot be read, holds none, or lacks a camera.
        """
        found = self._read().detections
        if not len(found):
            raise KinemarkError(f"{self.of.root / str(self.of.entry.detections)} has no 2D points. Export it again.")
        return self.of.corrected(within(found, self.of)).detections

    def _read(self) -> NamedDetections:
        """All that is there of the calibrated cameras, in their order."""
        of, paths = self.of, self.paths
        rate = of.rate(None)
        if HOLE in str(of.entry.detections):
            return read_camera_files(paths, rate=rate)
        path = next(iter(paths.values()))
        if layout_of(path) == "deeplabcut":
            raise KinemarkError(
                f"{path} is of one camera, and the calibration has {', '.join(of.rig.names)}. Name the files of all, "
                'with {camera} where a camera\'s name stands: detections = "walk01_{camera}.csv".'
            )
        return selected(path, read_named_detections(path, rate=rate, cameras=of.rig.names), of.rig.names)

    def operated(self) -> OperatorIdentities:
        """The markers as the file names them."""
        found = self._read()
        return OperatorIdentities(found.names, marker_within(found, self.of), {})


def selected(path: Path, found: NamedDetections, names: Sequence[str]) -> NamedDetections:
    """Only these cameras, in this order.

    Raises:
        KinemarkError: the file lacks one.
    """
    have = found.detections.cameras
    if missing := sorted(set(names) - set(have)):
        raise KinemarkError(
            f"{path} has cameras {', '.join(have)}, and the calibration also {', '.join(missing)}. "
            "Call them alike in both, and name in [cameras] those to be used."
        )
    camera = found.detections.camera
    rows = np.concatenate([np.flatnonzero(camera == have.index(name)) for name in names])
    return NamedDetections(found.detections.select(names), found.marker[rows], found.names)
